"""Computes `crates/snowblue-scene/data/rgb_basis.csv`: three basis spectra that upsample linear sRGB, for the light of
RGB images and for reflectances.

The light of an image is D65(λ) · (r R(λ) + g G(λ) + b B(λ)). The basis spectra are the smoothest ones (least sum of
squared differences between neighbours) such that none is negative, R + G + B = 1 at every wavelength, and each has the
chromaticity of its primary under D65. This is the problem of Mallett & Yuksel (2019), "Spectral primary decomposition
for rendering with sRGB reflectance", EGSR, doi:10.2312/sr.20191216, solved on 400-700 nm in steps of 10 nm.

Usage: python scripts/rgb_basis.py [--check]    (needs numpy and scipy)
"""

import pathlib
import sys

import numpy as np
from scipy.optimize import minimize

CRATES = pathlib.Path(__file__).parent.parent / "crates"
FILE = CRATES / "snowblue-scene" / "data" / "rgb_basis.csv"
PRIMARIES_XY = [(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)]
WAVELENGTHS_NM = np.arange(400.0, 701.0, 10.0)


def column(name, index):
    table = np.loadtxt(CRATES / "snowblue-color" / "data" / name, delimiter=",", skiprows=1)
    return np.interp(WAVELENGTHS_NM, table[:, 0], table[:, index])


def basis():
    weights = np.array([column("cmf_1931_2deg_1nm.csv", k) for k in (1, 2, 3)]) * column("illuminant_d65.csv", 1)
    weights /= weights[1].sum()
    primaries = np.array([(x / y, 1.0, (1.0 - x - y) / y) for x, y in PRIMARIES_XY]).T
    targets = primaries * np.linalg.solve(primaries, weights.sum(axis=1))
    count = len(WAVELENGTHS_NM)
    step = np.diff(np.eye(count), axis=0)
    roughness = np.kron(np.eye(3), step.T @ step)
    # Blue follows from red and green, since the three sum to one.
    left = [np.hstack([np.eye(count)] * 3)] + [np.kron(np.eye(3)[k], weights) for k in (0, 1)]
    left, right = np.vstack(left), np.concatenate([np.ones(count), targets[:, 0], targets[:, 1]])
    scale = 100.0  # the solver's stopping criterion is absolute
    solved = minimize(
        lambda x: scale * x @ roughness @ x,
        np.full(3 * count, 1.0 / 3.0),
        jac=lambda x: 2.0 * scale * roughness @ x,
        bounds=[(0.0, 1.0)] * (3 * count),
        constraints={"type": "eq", "fun": lambda x: left @ x - right, "jac": lambda x: left},
        method="SLSQP",
        options={"maxiter": 2000, "ftol": 1e-15},
    )
    assert np.abs(left @ solved.x - right).max() < 1e-9, solved.message
    red, green, _ = solved.x.reshape(3, count).round(6)
    return np.column_stack([WAVELENGTHS_NM, red, green, 1.0 - red - green])


def main():
    table = basis()
    if "--check" in sys.argv:
        stored = np.loadtxt(FILE, delimiter=",", skiprows=1)
        worst = np.abs(stored - table).max()
        print(f"largest difference from {FILE.name}: {worst:.1e}")
        sys.exit(worst > 1e-4)
    header = "wavelength_nm,red,green,blue"
    np.savetxt(FILE, table, fmt=["%d", "%.6f", "%.6f", "%.6f"], delimiter=",", header=header, comments="")


if __name__ == "__main__":
    main()
