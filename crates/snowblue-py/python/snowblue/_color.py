"""Colours of light through snow, snow of a colour, and swatches."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any

import numpy as np

from snowblue import _native
from snowblue._arguments import (
    ANGLE,
    SNOW_NAMES,
    Snow,
    angle,
    angles_or_diffuse,
    attributes,
    checks_names,
    is_several,
    number,
    one_snow,
    ordinates,
    own_axis,
    shown,
    single_values,
)
from snowblue._spectra import SPECTRUM_NAMES, spectrum

if TYPE_CHECKING:
    import xarray as xr
    from typing_extensions import Unpack


MOST_PIXELS = 16_384
"""Most pixels along a side of a picture of swatches."""


@checks_names(*SPECTRUM_NAMES)
def color(
    spectrum: xr.DataArray | xr.Dataset | None = None,
    *,
    illuminant: Any = "D65",
    observer: str = "1931",
    exposure_stops: float | None = 0.0,
    reflected: bool = False,
    **slab_and_snow: Any,
) -> xr.Dataset:
    """Colours of the light that snow transmits or reflects.

    Parameters
    ----------
    spectrum : xarray.DataArray or xarray.Dataset, optional
        Transmittance or reflectance on a dimension `wavelength` (nm), or the whole result of
        :func:`snowblue.spectrum`. It must cover 400 to 700 nm in steps of at most 20 nm; values outside do not count.
        Without it, that of the snow and slab that further arguments describe.
    illuminant : str or list
        CIE illuminant, one of :func:`snowblue.illuminants`.
    observer : "1931" or "1964"
    exposure_stops : float, optional
        Exposure of `hex` only. None brings the brightest channel of all to 0.9.
    reflected : bool
        The reflected light instead of the transmitted light, of a dataset or of the snow that further arguments
        describe.
    **slab_and_snow
        Arguments of :func:`snowblue.spectrum`.

    Returns
    -------
    xarray.Dataset
        X, Y, Z, L, a, b, r_linear, g_linear, b_linear (linear sRGB) and hex, on the axes of the spectra but wavelength.
        The light without snow has Y = 1 and is the white of CIELAB; there is no chromatic adaptation.

    Examples
    --------
    >>> import snowblue
    >>> deep = snowblue.color(thickness_cm=30, exposure_stops=None)
    >>> bool(deep.b_linear > 2 * deep.r_linear)
    True
    """
    import xarray as xr

    if isinstance(spectrum, xr.DataArray) and reflected:
        raise TypeError("reflected has no effect on a given spectrum")
    if spectrum is not None and slab_and_snow:
        raise TypeError(f"{next(iter(slab_and_snow))} has no effect on a given spectrum")
    if spectrum is None or isinstance(spectrum, xr.Dataset):
        curves = _curves(reflected, spectrum, slab_and_snow)
    else:
        curves = spectrum
    if not hasattr(curves, "dims"):
        raise ValueError(f"the spectrum is {shown(spectrum)}, but must be a Dataset or an xarray.DataArray")
    if "wavelength" not in curves.dims:
        raise ValueError("the spectrum has no dimension 'wavelength'")
    curves = curves.transpose(..., "wavelength")
    values = np.ascontiguousarray(curves.values, dtype=float).reshape(-1)
    several = is_several(illuminant)
    results = [
        _native.colors(
            values, curves.wavelength.values.tolist(), {"illuminant": str(one), "observer": observer}, exposure_stops
        )
        for one in (illuminant if several else [illuminant])
    ]
    dims = [*(["illuminant"] if several else []), *curves.dims[:-1]]
    shape = [*([len(results)] if several else []), *curves.shape[:-1]]
    variables: dict[str, Any] = {}
    for group, names in (("xyz", "XYZ"), ("lab", "Lab"), ("rgb_linear", ("r_linear", "g_linear", "b_linear"))):
        triples = np.concatenate([one[group] for one in results]).reshape(*shape, 3)
        for number, name in enumerate(names):
            variables[name] = (dims, triples[..., number])
    words = [word for one in results for word in one["hex"]]
    variables["hex"] = (dims, np.array(words, dtype=str).reshape(shape))
    coords = {name: coord for name, coord in curves.coords.items() if "wavelength" not in coord.dims}
    if several:
        coords["illuminant"] = ("illuminant", [str(one) for one in illuminant])
    made = {name: value for name, value in curves.attrs.items() if name not in ("units", "long_name")}
    light = {} if several else {"illuminant": str(illuminant)}
    exposure = "auto" if exposure_stops is None else f"{exposure_stops} stops"
    made |= light | {"observer": f"CIE {observer}", "exposure_of_hex": exposure}
    return xr.Dataset(variables, coords, attributes(**made))


def _curves(reflected: bool, solved: xr.Dataset | None, slab_and_snow: Mapping[str, Any]) -> xr.DataArray:
    if solved is None:
        solved = spectrum(standard_errors=False, **slab_and_snow)
    name = "reflectance" if reflected else "transmittance"
    if name not in solved:
        raise ValueError(f"the spectra have no {name}")
    curves = solved[name]
    made = {name: value for name, value in solved.attrs.items() if name not in ("Conventions", "source")}
    return curves.assign_attrs(made | {"light": "reflected" if reflected else "transmitted"})


@checks_names(*SNOW_NAMES)
def match(
    target: str,
    *,
    thickness_cm: float | tuple[float, float] | None = None,
    angle_deg: Any = 0.0,
    illuminant: str = "D65",
    streams: int | str = "auto",
    seed: int = 1,
    **snow: Unpack[Snow],
) -> xr.Dataset:
    """Snow whose transmitted light comes closest to a colour.

    Hue and chroma are matched, not the luminance. Quantities that are not given are searched for: first the thickness;
    if that is given or cannot reach the target, the grain size (100 to 2000 µm), then the density (100 to 450 kg/m³).

    Parameters
    ----------
    target : str
        An sRGB colour, "#9fc5f8".
    thickness_cm : float or tuple, optional
        The thickness, or the ends of the range to search.
    angle_deg : float or "diffuse"
    illuminant : str
    streams, seed
        As in :func:`snowblue.spectrum`.
    **snow
        Arguments of :class:`Snow`, one value each.

    Returns
    -------
    xarray.Dataset
        On the dimension `candidate`: the first is closest to the default snow, the others let more or less light
        through. `delta_e` is the CIELAB 1976 difference, both colours at L* = 50; up to 2.3 it is not noticeable. If
        that cannot be reached, there is a warning.
    """
    import xarray as xr

    given = one_snow(snow)
    for name, word, like in (("target", target, "#9fc5f8"), ("illuminant", illuminant, "D65")):
        if not isinstance(word, str):
            raise ValueError(f"{name} is {word!r}, but must be one word, such as '{like}'")
    ends = None
    if thickness_cm is not None:
        if is_several(thickness_cm):
            raise ValueError(f"thickness_cm is {thickness_cm!r}, but must be one thickness or a tuple of two")
        pair = thickness_cm if isinstance(thickness_cm, tuple) else (thickness_cm, thickness_cm)
        ends = tuple(number("thickness_cm", one) for one in pair)
        if len(ends) != 2 or not 0 < ends[0] <= ends[1]:
            raise ValueError(f"thickness_cm is {thickness_cm}, but must be one thickness or an ascending pair above 0")
    fixed = {
        "thickness_cm": ends,
        "grain_size": any(name in snow for name in ("grain_size_um", "ssa_m2_kg", "snow")),
        "density": any(name in snow for name in ("density_kg_m3", "snow")),
    }
    incidences = angles_or_diffuse(own_axis(ANGLE, angle_deg, angle))
    if len(incidences) != 1:
        raise ValueError(f"angle_deg is {angle_deg}, but must be one angle")
    light = {"illuminant": illuminant, "observer": "1931"}
    rows, missed = _native.match_color(target, given, incidences[0], fixed, light, ordinates(streams, seed))
    if missed:
        warnings.warn(f"{target}: {missed}", stacklevel=2)
    variables = {name: ("candidate", [row[name] for row in rows]) for name in rows[0]}
    # The candidates state what is searched for.
    searched = ("snow_id",) if fixed["grain_size"] else ("snow_id", "grain_size_um")
    searched += () if fixed["density"] else ("density_kg_m3",)
    kept = {name: value for name, value in single_values(given, {}).items() if name not in searched}
    made = {**kept, "target": target, "angle_deg": incidences[0], "illuminant": illuminant, "seed": seed}
    return xr.Dataset(variables, attrs=attributes(**made))


@checks_names(*SPECTRUM_NAMES)
def swatch(
    *,
    columns: Mapping[str, Any],
    rows: Mapping[str, Any] | None = None,
    illuminant: str = "D65",
    observer: str = "1931",
    exposure_stops: float | None = None,
    reflected: bool = False,
    size_px: int = 160,
    seed: int = 1,
    output: str | PathLike[str] | None = None,
    **slab_and_snow: Any,
) -> np.ndarray:
    """Draws the colours of light through snow over any two parameters, as squares without gaps.

    Parameters
    ----------
    columns, rows : mapping
        The name of an argument of :func:`snowblue.color`, and the values that it takes: `{"thickness_cm": [5, 15]}`.
    illuminant, observer, reflected
        As in :func:`snowblue.color`.
    exposure_stops : float, optional
        Exposure of all swatches; None brings the greatest channel to 0.9 of white.
    size_px : int, 16 to 2048
        Width and height of a swatch.
    seed : int
    output : path, optional
        A PNG file to write.
    **slab_and_snow
        Arguments of :func:`snowblue.spectrum`, one value each.

    Returns
    -------
    numpy.ndarray
        8-bit sRGB of shape (height, width, 3).
    """
    if not 16 <= size_px <= 2048:
        raise ValueError(f"size_px is {size_px}, but must lie in 16–2048")
    across, down = (_axis(axis) for axis in (columns, rows or {}))
    if across and down and across[0] == down[0]:
        raise ValueError(f"{across[0]} varies along rows and columns")
    for axis in (across, down):
        if axis and axis[0] in slab_and_snow:
            raise ValueError(f"{axis[0]} varies along rows or columns, but is also given")
        if axis and len(axis[1]) * size_px > MOST_PIXELS:
            side = f"{len(axis[1])} swatches of {size_px} pixels are {len(axis[1]) * size_px} pixels"
            raise ValueError(f"{axis[0]}: {side}, but must be at most {MOST_PIXELS}")
    triples = []
    for below in down[1] if down else [None]:
        for beside in across[1] if across else [None]:
            own = {axis[0]: value for axis, value in ((down, below), (across, beside)) if axis}
            light = {"illuminant": illuminant, "observer": observer, "reflected": reflected, "seed": seed}
            one = color(**{**light, **slab_and_snow, **own})
            if one.sizes.get("thickness") != 1 or one.hex.size != 1:
                raise ValueError("an argument has several values: give these as rows or columns")
            triples.append([one[name].item() for name in ("r_linear", "g_linear", "b_linear")])
    count = len(across[1]) if across else 1
    path = None if output is None else fspath(output)
    drawn = _native.draw_swatches(np.array(triples, dtype=float).reshape(-1), count, size_px, exposure_stops, path)
    return drawn.reshape(-1, count * size_px, 3)


def _axis(axis: Mapping[str, Any]) -> tuple[str, list[Any]] | None:
    if not axis:
        return None
    if len(axis) != 1:
        raise ValueError(f"an axis of swatches has one parameter, not {len(axis)}")
    [(name, values)] = axis.items()
    plain = [value.item() if hasattr(value, "item") else value for value in values]
    if not plain:
        raise ValueError(f"{name} has no values, but a row or column of swatches needs one at least")
    return name, plain
