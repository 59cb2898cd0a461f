#!/usr/bin/env python3
"""Checks files against other programs: xarray opens tables, NumPy reads the raw export, and OpenEXR reads images with
their spectra and sums.

    python3 scripts/check_exchange.py SNOWBLUE
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR
import xarray as xr

SNOWBLUE = sys.argv[1]
AXES = ["--grain-size", "200,400", "--facetness", "0.3", "--density", "250,300", "--thickness", "1,5,15"]
UNITS = {"grain_size": "um", "density": "kg m-3", "angle": "degree", "thickness": "cm", "wavelength": "nm"}


def snowblue(*arguments):
    done = subprocess.run([SNOWBLUE, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def xarray_opens_tables(folder):
    """Axes have names and units, values have the right coordinates, and diffuse incidence is flagged."""
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
        # The same grain optics, but another interpolation grid, and more streams where some of the snow is wet.
        assert np.abs(dry.transmittance.values / printed[:, 4] - 1).max() < 1e-4
    compressed = folder / "compressed.nc"
    snowblue("database", "build", *AXES, "--tally-rays", "262144", "--space", "log", "--components", 3,
             "-o", compressed)
    with xr.open_dataset(compressed) as table, xr.open_dataset(full) as whole:
        rebuilt = np.exp((table.transmittance_coefficients * table.transmittance_basis).sum("component"))
        exact = whole.transmittance.sel(water_saturation=0, drop=True).sel(angle=[0, 60])
        assert np.abs(rebuilt.sel(angle=[0, 60]) - exact).max() < 2e-3


def numpy_reads_exports(folder):
    """The rows of an export are the values of its table."""
    rows = folder / "snow.csv"
    snowblue("database", "export", folder / "compressed.nc", "-o", rows)
    columns = np.genfromtxt(rows, delimiter=",", names=True)
    with xr.open_dataset(folder / "compressed.nc") as table:
        rebuilt = np.exp((table.transmittance_coefficients * table.transmittance_basis).sum("component"))
        np.testing.assert_allclose(columns["transmittance"], rebuilt.values.ravel(), rtol=1e-5)


def openexr_reads_images(folder):
    """Channels, units and windows follow the format; unfiltered colours are the means of the stored sums."""
    scene = Path(__file__).resolve().parent.parent / "scenes" / "block_30cm.toml"
    path, samples = folder / "part.exr", 3
    snowblue("render", scene, "--width", 32, "--height", 24, "--spp", samples, "--crop", "4:30,6:20", "--raw",
             "--aovs", "spectrum,variance,normal,albedo,thickness,angle", "-o", path)
    with OpenEXR.File(str(path), separate_channels=True) as image:
        header = dict(image.header())
        values = {name: channel.pixels for name, channel in image.channels().items()}
    assert header["spectralLayoutVersion"] == "1.0" and header["emissiveUnits"] == "W.m^-2.sr^-1.nm^-1"
    windows = [header[window] for window in ("dataWindow", "displayWindow")]
    corners = [[tuple(int(x) for x in corner) for corner in window] for window in windows]
    assert corners == [[(4, 6), (29, 19)], [(0, 0), (31, 23)]], corners
    spectrum = np.array([values[f"S0.{nm},000000nm"] for nm in range(400, 701, 10)])
    assert spectrum.shape == (31, 14, 26) and spectrum.max() > 0
    # Sums are 128-bit fixed-point numbers in four words, with 64 fractional bits: the highest word has the sign, as
    # single samples of hybrid may be negative.
    words = [[values[f"sums.{name}.{word}"] for word in range(4)] for name in "XYZ"]
    signed = [[*low, high.astype(np.int32)] for *low, high in words]
    xyz = np.array([sum(value * 2.0 ** (32 * k - 64) for k, value in enumerate(four)) for four in signed])
    # sRGB primaries and white (IEC 61966-2-1).
    primaries = np.array([[0.64, 0.3, 0.15], [0.33, 0.6, 0.06], [0.03, 0.1, 0.79]])
    white = np.array([0.3127 / 0.3290, 1, (1 - 0.3127 - 0.3290) / 0.3290])
    to_xyz = primaries * np.linalg.solve(primaries, white)
    rgb = np.einsum("ij,jkl->ikl", np.linalg.inv(to_xyz), xyz / samples)
    shown = np.array([values[name] for name in "RGB"])
    assert np.abs(rgb - shown).max() < 2e-4 * shown.max()
    assert np.abs(np.hypot(np.hypot(*(values[f"normal.{axis}"] for axis in "XY")), values["normal.Z"])).max() < 1 + 1e-6


with tempfile.TemporaryDirectory() as name:
    temporary = Path(name)
    xarray_opens_tables(temporary)
    numpy_reads_exports(temporary)
    openexr_reads_images(temporary)
print("xarray, NumPy and OpenEXR agree")
