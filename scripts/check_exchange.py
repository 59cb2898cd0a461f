#!/usr/bin/env python3
"""Tables and pictures in other programs: xarray opens tables, TARTES fills them, NumPy reads the raw numbers; OpenEXR reads
pictures, their spectra and their sums.

    python3 scripts/check_exchange.py PATH_OF_SNOWBLUE
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR
import xarray as xr

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "contrib" / "tartes"))
import table as tartes_table  # noqa: E402

SNOWBLUE = sys.argv[1]
AXES = ["--grain-size", "200,400", "--facetness", "0.3", "--density", "250,300", "--thickness", "1,5,15"]
UNITS = {"grain_size": "um", "density": "kg m-3", "angle": "degree", "thickness": "cm", "wavelength": "nm"}


def snowblue(*arguments):
    done = subprocess.run([SNOWBLUE, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def xarray_opens_tables(folder):
    """Axes have names and units, values stand at their places, and diffuse light is told."""
    full = folder / "full.nc"
    snowblue("database", "build", *AXES, "--angle", "0,60,diffuse", "--water-saturation", "0,0.1",
             "--tally-rays", "262144", "-o", full)
    with xr.open_dataset(full) as table:
        assert table.transmittance.dims == (
            "grain_size", "facetness", "density", "water_saturation", "angle", "thickness", "wavelength")
        for name, unit in UNITS.items():
            assert table[name].attrs["units"] == unit, name
        assert table.angle.attrs["flag_meanings"] == "diffuse" and table.angle.values[0] == -1
        dry = table.sel(grain_size=400, density=300, angle=60, thickness=5, water_saturation=0, facetness=0.3)
        rows = snowblue("spectrum", "--thickness", 5, "--angle", 60, "--quiet", "--format", "csv").splitlines()[1:]
        printed = np.array([[float(field) for field in row.split(",")] for row in rows])
        # The same rays at grains, but other grids to interpolate on, and more streams where some of the snow is wet.
        assert np.abs(dry.transmittance.values / printed[:, 4] - 1).max() < 1e-4
    compressed = folder / "compressed.nc"
    snowblue("database", "build", *AXES, "--tally-rays", "262144", "--space", "log", "--components", 3, "-o", compressed)
    with xr.open_dataset(compressed) as table, xr.open_dataset(full) as whole:
        rebuilt = np.exp((table.transmittance_coefficients * table.transmittance_basis).sum("component"))
        exact = whole.transmittance.sel(water_saturation=0, drop=True).sel(angle=[0, 60])
        assert np.abs(rebuilt.sel(angle=[0, 60]) - exact).max() < 2e-3
    return full


def dimensions_come_in_any_order(folder, full):
    """A transposed table in single precision is imported to the same values."""
    turned, back = folder / "turned.nc", folder / "back.nc"
    with xr.open_dataset(full) as table:
        shuffled = table.transpose("wavelength", "angle", "density", ...).astype("float32")
        shuffled.to_netcdf(turned, format="NETCDF3_64BIT")
        snowblue("database", "import", turned, "-o", back)
        with xr.open_dataset(back) as imported:
            for name in ("transmittance", "reflectance"):
                assert np.abs(imported[name] - table[name]).max() < 1e-7


def tartes_fills_a_table(folder):
    """Curves of another model make a compressed table that colours come out of."""
    tartes_table.sizes_um = np.array([200.0, 400.0])
    tartes_table.densities = np.array([300.0])
    tartes_table.angles = np.array([0.0, 60.0])
    theirs, table, raw = folder / "tartes.nc", folder / "snow.nc", folder / "snow.json"
    tartes_table.main(theirs)
    snowblue("database", "import", theirs, "--space", "log", "--components", 3, "-o", table)
    assert "56 curves of 2 kinds of snow, 3 components in log space" in snowblue("database", "info", table)
    snowblue("database", "export", table, "-o", raw)
    document = json.loads(raw.read_text())
    numbers = np.fromfile(folder / document["numbers"], "<f4")
    arrays = {one["name"]: numbers[one["first_number"]:][: one["count"]] for one in document["arrays"]}
    lengths = [len(axis["values"]) for axis in document["axes"]]
    coefficients = arrays["transmittance_coefficients"].reshape(*lengths[:-1], 3)
    values = np.exp(coefficients @ arrays["transmittance_basis"].reshape(-1, 3).T)
    with xr.open_dataset(theirs) as original:
        expected = original.transmittance.transpose("grain_size", "facetness", "density", "angle", "thickness", ...)
        assert np.abs(values - expected.values).max() < 5e-3


def openexr_reads_pictures(folder):
    """Channels, units and windows are where the format has them; the sums are what the colours are means of."""
    scene = Path(__file__).resolve().parent.parent / "scenes" / "block_30cm.toml"
    path, samples = folder / "part.exr", 3
    snowblue("render", scene, "--width", 32, "--height", 24, "--spp", samples, "--crop", "4:30,6:20",
             "--channels", "spectrum,variance,normal,albedo,thickness,angle", "-o", path)
    with OpenEXR.File(str(path), separate_channels=True) as picture:
        header = dict(picture.header())
        values = {name: channel.pixels for name, channel in picture.channels().items()}
    assert header["spectralLayoutVersion"] == "1.0" and header["emissiveUnits"] == "W.m^-2.sr^-1.nm^-1"
    corners = [[tuple(int(x) for x in corner) for corner in header[window]] for window in ("dataWindow", "displayWindow")]
    assert corners == [[(4, 6), (29, 19)], [(0, 0), (31, 23)]], corners
    spectrum = np.array([values[f"S0.{nm},000000nm"] for nm in range(400, 701, 10)])
    assert spectrum.shape == (31, 14, 26) and spectrum.max() > 0
    xyz = np.array([sum(values[f"sums.{name}.{word}"] * 2.0 ** (32 * word - 64) for word in range(4)) for name in "XYZ"])
    # IEC 61966-2-1, by the primaries.
    primaries = np.array([[0.64, 0.3, 0.15], [0.33, 0.6, 0.06], [0.03, 0.1, 0.79]])
    white = np.array([0.3127 / 0.3290, 1, (1 - 0.3127 - 0.3290) / 0.3290])
    to_xyz = primaries * np.linalg.solve(primaries, white)
    rgb = np.einsum("ij,jkl->ikl", np.linalg.inv(to_xyz), xyz / samples)
    shown = np.array([values[name] for name in "RGB"])
    assert np.abs(rgb - shown).max() < 2e-4 * shown.max()
    assert np.abs(np.hypot(np.hypot(*(values[f"normal.{axis}"] for axis in "XY")), values["normal.Z"])).max() < 1 + 1e-6


with tempfile.TemporaryDirectory() as name:
    place = Path(name)
    table_of_water = xarray_opens_tables(place)
    dimensions_come_in_any_order(place, table_of_water)
    tartes_fills_a_table(place)
    openexr_reads_pictures(place)
print("xarray, TARTES, NumPy and OpenEXR agree")
