"""The albedo of deep clean snow by BioSNICAR, with the single scattering of its grains, as a table of CSV.

python scripts/biosnicar_table.py CHECKOUT > docs/data/biosnicar_spheres.csv

CHECKOUT is that of https://github.com/jmcook1186/biosnicar-py; its packages (xarray, netCDF4, pandas, PyYAML, and
others) must be installed.
"""

import sys
from contextlib import redirect_stdout

import numpy as np

RADIUS_UM = 164
LAYERS_M = [0.01, 10.0, 100.0]
DENSITY_KG_M3 = 300
ANGLES_DEG = (0, 50, 75, 85)
"""Of the beams; the diffuse light comes after them."""

sys.path.insert(0, sys.argv[1])
from biosnicar.drivers.setup_snicar import setup_snicar  # noqa: E402
from biosnicar.optical_properties.column_OPs import get_layer_OPs, mix_in_impurities  # noqa: E402
from biosnicar.rt_solvers.adding_doubling_solver import adding_doubling_solver  # noqa: E402

# BioSNICAR prints a setting.
with redirect_stdout(sys.stderr):
    ice, light, _, config, _, impurities = setup_snicar("default")
config.sphere_ice_path = "Data/OP_data/480band/ice_spherical_grains_BH83/"
config.smooth = False
count = len(LAYERS_M)
ice.dz, ice.nbr_lyr = LAYERS_M, count
ice.layer_type, ice.shp = [0] * count, [0] * count
ice.rho, ice.rds = [DENSITY_KG_M3] * count, [RADIUS_UM] * count
ice.cdom = ice.water = ice.lwc = ice.lwc_pct_bbl = [0] * count
ice.sfc = np.full(config.nbr_wvl, 0.25)
# The ice of Warren & Brandt (2008).
ice.op_dir = "ice_Wrn08/ice_Wrn08_"
for impurity in impurities:
    impurity.conc = [0] * count
albedo, asymmetry, extinction_m2_kg = get_layer_OPs(ice, config)
columns = []
for angle_deg in (*ANGLES_DEG, None):
    light.direct, light.solzen = int(angle_deg is not None), angle_deg or 0
    light.calculate_irradiance()
    mixed = mix_in_impurities(albedo, asymmetry, extinction_m2_kg, ice, impurities, config)
    columns.append(adding_doubling_solver(*mixed, ice, light, config).albedo)
albedos = [*(f"albedo_{angle_deg}" for angle_deg in ANGLES_DEG), "albedo_diffuse"]
print("wavelength_nm", "coalbedo", "asymmetry", *albedos, sep=",")
for row, wavelength_nm in enumerate(np.round(1000 * config.wavelengths).astype(int)):
    if wavelength_nm in range(305, 2500, 100):
        print(wavelength_nm, f"{1 - albedo[0, row]:.6e}", f"{asymmetry[0, row]:.6f}",
              *(f"{column[row]:.6f}" for column in columns), sep=",")
