"""Writes the colours that crates/snowblue-color/tests/published.rs expects.

They come from the package colour-science, an independent implementation:
    pip install colour-science==0.4.7 && python scripts/color_golden.py
"""

import csv
from pathlib import Path

import colour
import numpy as np

FOLDER = Path(__file__).parent.parent / "crates/snowblue-color/tests/data"
OBSERVER = "CIE 1931 2 Degree Standard Observer"
SHAPE = colour.SpectralShape(400, 700, 10)
WAVELENGTHS_NM = SHAPE.wavelengths
# Smooth, steep and jagged; `snow` has the size and slope of 15 cm of snow.
SPECTRA = {
    "snow": 0.0215 * np.exp(-(((WAVELENGTHS_NM - 400) / 265) ** 3)),
    "green_band": np.exp(-(((WAVELENGTHS_NM - 540) / 30) ** 2)),
    "red_edge": np.where(WAVELENGTHS_NM < 605, 0.02, 0.9),
    "saw": 0.1 + 0.2 * ((WAVELENGTHS_NM / 10) % 4),
}
ILLUMINANTS = ["E", "D50", "D65", "A", "FL3.15", "HP5", "LED-B5", "LED-V1"]
TABULATED = ["A", "C", "E", "D50", "D55", "D65", "D75"]
TABULATED += [f"FL{i}" for i in range(1, 13)] + [f"FL3.{i}" for i in range(1, 16)] + [f"HP{i}" for i in range(1, 6)]
TABULATED += [f"LED-{i}" for i in ("B1", "B2", "B3", "B4", "B5", "BH1", "RGB1", "V1", "V2")]


def write(name, header, rows):
    with open(FOLDER / name, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def colours():
    observer = colour.MSDS_CMFS[OBSERVER].copy().align(SHAPE)
    srgb = colour.RGB_COLOURSPACES["sRGB"]
    xyz_to_rgb = np.linalg.inv(colour.normalised_primary_matrix(srgb.primaries, srgb.whitepoint))
    for name in ILLUMINANTS:
        illuminant = colour.SDS_ILLUMINANTS[name].copy().align(SHAPE)
        white = colour.sd_to_XYZ(colour.sd_ones(SHAPE), observer, illuminant, method="Integration") / 100
        for spectrum, values in SPECTRA.items():
            curve = colour.SpectralDistribution(np.round(values, 6), WAVELENGTHS_NM)
            xyz = colour.sd_to_XYZ(curve, observer, illuminant, method="Integration") / 100
            lab = colour.XYZ_to_Lab(xyz, colour.XYZ_to_xy(white))
            yield [spectrum, name] + [f"{v:.12g}" for v in (*xyz, *lab, *(xyz_to_rgb @ xyz))]


write("spectra.csv", ["wavelength_nm", *SPECTRA], zip(WAVELENGTHS_NM, *(np.round(v, 6) for v in SPECTRA.values())))
write("colours.csv", ["spectrum", "illuminant", *"XYZLab", "r_linear", "g_linear", "b_linear"], colours())
chromaticities = colour.CCS_ILLUMINANTS[OBSERVER]
write("illuminant_chromaticities.csv", ["illuminant", "x", "y"], ([n, *np.round(chromaticities[n], 5)] for n in TABULATED))
