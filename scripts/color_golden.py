"""Writes the expected colours of crates/snowblue-color/tests/it/published.rs.

The package colour-science, an independent implementation, computes them:
    pip install colour-science==0.4.7 && python scripts/color_golden.py
"""

import csv
from pathlib import Path

import colour
import numpy as np

FOLDER = Path(__file__).parent.parent / "crates/snowblue-color/tests/data"
OBSERVERS = ["CIE 1931 2 Degree Standard Observer", "CIE 1964 10 Degree Standard Observer"]
OBSERVER = OBSERVERS[0]
SHAPE = colour.SpectralShape(400, 700, 10)
WAVELENGTHS_NM = SHAPE.wavelengths
# Smooth, steep and jagged spectra. `snow` has the magnitude and slope of 15 cm of snow.
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


def linear(curve, shape):
    """Linear interpolation. The package's default for even steps is Sprague."""
    known = colour.LinearInterpolator(curve.wavelengths, curve.values)
    return colour.SpectralDistribution(known(shape.wavelengths), shape.wavelengths)


def chromaticities():
    """Published chromaticities, without FL1-FL12 for 10 degrees, which differ by 1e-4 from ASTM E308."""
    for observer in OBSERVERS:
        for name in TABULATED:
            if observer == OBSERVER or not name.startswith("FL") or "." in name:
                yield [name, observer.split()[1], *np.round(colour.CCS_ILLUMINANTS[observer][name], 5)]


def sums():
    """Every illuminant, observer and step, with the three spectra in turn."""
    curves = {
        "snow": lambda nm: 0.0215 * np.exp(-((np.maximum(nm - 400, 0) / 265) ** 3)),
        "green_band": lambda nm: np.exp(-(((nm - 540) / 30) ** 2)),
        "ramp": lambda nm: (nm - 300) / 600,
    }
    turn = 0
    for name in TABULATED:
        table = colour.SDS_ILLUMINANTS[name].shape
        first, last = max(table.start, 360), min(table.end, 780)
        for observer in OBSERVERS:
            for step in (1, 5, 10):
                shape = colour.SpectralShape(first, last, step)
                illuminant = linear(colour.SDS_ILLUMINANTS[name], shape)
                matching = colour.MSDS_CMFS[observer].copy().align(shape)
                spectrum = list(curves)[(turn + turn // 6) % 3]
                turn += 1
                curve = colour.SpectralDistribution(curves[spectrum](shape.wavelengths), shape.wavelengths)
                xyz = colour.sd_to_XYZ(curve, matching, illuminant, method="Integration") / 100
                year = observer.split()[1]
                yield [name, year, step, spectrum] + [f"{v:.12g}" for v in xyz]


def spaces():
    """The same lights in other spaces. `adapted` is the Bradford adaptation from D65 to the white of ACEScg."""
    d65 = colour.xy_to_XYZ([0.3127, 0.3290])
    aces = colour.xy_to_XYZ([0.32168, 0.33767])
    lights = [d65, aces, [0.2, 0.25, 0.6], [0.0011, 0.00105, 0.00494], [0.4, 0.2, 0.02], [0.05, 0.1, 0.07]]
    before = None
    for xyz in np.array(lights):
        adapted = colour.chromatic_adaptation(xyz, d65, aces, method="Von Kries", transform="Bradford")
        row = [*xyz]
        for name in ("ITU-R BT.2020", "ACEScg"):
            space = colour.RGB_COLOURSPACES[name]
            row += [*(np.linalg.inv(colour.normalised_primary_matrix(space.primaries, space.whitepoint)) @ xyz)]
        lab = colour.XYZ_to_Lab(xyz, [0.3127, 0.3290])
        row += [*adapted, *lab, 0 if before is None else colour.delta_E(before, lab, method="CIE 2000")]
        row += [*colour.XYZ_to_Oklab(xyz)]
        before = lab
        yield [f"{v:.12g}" for v in row]


def interpolated():
    """Sprague interpolation of the spectrum of snow."""
    curve = np.round(SPECTRA["snow"], 6)
    wavelengths_nm = np.array([400, 401, 413, 426.5, 555, 683, 697, 700])
    return zip(wavelengths_nm, [f"{v:.12g}" for v in colour.SpragueInterpolator(WAVELENGTHS_NM, curve)(wavelengths_nm)])


write("spectra.csv", ["wavelength_nm", *SPECTRA], zip(WAVELENGTHS_NM, *(np.round(v, 6) for v in SPECTRA.values())))
write("colours.csv", ["spectrum", "illuminant", *"XYZLab", "r_linear", "g_linear", "b_linear"], colours())
write("illuminant_chromaticities.csv", ["illuminant", "observer", "x", "y"], chromaticities())
write("sums.csv", ["illuminant", "observer", "step_nm", "spectrum", *"XYZ"], sums())
channels = [f"{channel}_{space}" for space in ("rec2020", "acescg") for channel in "rgb"]
write(
    "spaces.csv",
    [*"XYZ", *channels, *(f"{name}_adapted" for name in "XYZ"), *"Lab", "delta_e_2000_from_row_above",
     *(f"ok_{name}" for name in "lab")],
    spaces(),
)
write("sprague.csv", ["wavelength_nm", "snow"], interpolated())
