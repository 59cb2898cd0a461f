"""Single scattering by the droplets of clouds, as a table of CSV.

python scripts/cloud_droplets.py INDEX > crates/snowblue-sky/data/cloud_droplets.csv

INDEX is the table of water at 273 K of Rowe, Fergoda & Neshyba (2020, J. Geophys. Res. Atmos. 125, e2020JD032624) that
ships with BioSNICAR (https://github.com/jmcook1186/biosnicar-py) as
Data/OP_data/480band/refractive_index_water_273K_Rowe2020.csv. Needs NumPy and miepython 3.3.

The radii have the distribution of Hansen & Travis (1974, Space Sci. Rev. 16, 527, equation 2.56).
"""

import sys
from pathlib import Path

import miepython
import numpy as np

RADIUS_UM, VARIANCE = 10.0, 0.1
"""The effective radius of droplets and the effective variance of their distribution."""

SKY = Path(__file__).resolve().parents[1] / "crates" / "snowblue-sky" / "data" / "bird_riordan_1986.csv"

index = np.genfromtxt(sys.argv[1], delimiter=",", names=True)
# So many radii that the resonances of single spheres average out.
radii_um = np.linspace(0.5, 40.0, 2000)
number = radii_um ** (1 / VARIANCE - 3) * np.exp(-radii_um / (RADIUS_UM * VARIANCE))
print("wavelength_nm,coalbedo,asymmetry,absorption_per_m")
for wavelength_nm in np.genfromtxt(SKY, delimiter=",", names=True)["wavelength_nm"]:
    micrometres = 1e-3 * wavelength_nm
    n = np.interp(micrometres, index["wvl"], index["n"])
    k = np.exp(np.interp(np.log(micrometres), np.log(index["wvl"]), np.log(index["k"])))
    sizes = 2 * np.pi * radii_um / micrometres
    rows = np.array([miepython.efficiencies_mx(n - 1j * k, size) for size in sizes])
    extinction, scattering, asymmetry = rows[:, 0], rows[:, 1], rows[:, 3]
    area = number * radii_um**2
    coalbedo = 1 - (area @ scattering) / (area @ extinction)
    mean_cosine = (area @ (scattering * asymmetry)) / (area @ scattering)
    absorption_per_m = 4e6 * np.pi * k / micrometres
    print(f"{wavelength_nm:g},{coalbedo:.4e},{mean_cosine:.4f},{absorption_per_m:.4e}")
