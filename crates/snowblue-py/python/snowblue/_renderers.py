"""What the faces in other renderers share: white light and colours at 31 wavelengths."""

from __future__ import annotations

from typing import Any

import numpy as np

from snowblue import _native
from snowblue._arguments import VISIBLE_NM

BAND_WIDTH_NM = 310.0
"""31 wavelengths, 10 nm apart."""

# Coloured light is three bands that overlap by 40 nm; their sum is 1.
BAND_EDGES_NM = (490.0, 580.0)
BAND_OVERLAP_NM = 40.0


def _rgb(spectra: np.ndarray) -> np.ndarray:
    """Linear sRGB of light relative to D65, which is white, as in renderers that compute with three colours."""
    light = {"illuminant": "D65", "observer": "1931"}
    values = np.ascontiguousarray(spectra, dtype=float).reshape(-1)
    return _native.colors(values, VISIBLE_NM.tolist(), light, 0.0)["rgb_linear"].reshape(-1, 3)


def _bands(rgb: Any) -> np.ndarray:
    """Light of a linear sRGB colour at 31 wavelengths, relative to D65."""
    red, green, blue = rgb
    low, high = (np.clip((VISIBLE_NM - edge) / BAND_OVERLAP_NM + 0.5, 0.0, 1.0) for edge in BAND_EDGES_NM)
    return blue * (1 - low) + green * (low - high) + red * high


def _csv(values: np.ndarray) -> bytes:
    """A spectrum as a file of a scene."""
    rows = "".join(f"{nm:g},{value:.9g}\n" for nm, value in zip(VISIBLE_NM, values))
    return ("wavelength_nm,value\n" + rows).encode()
