"""Means over bands of sunlight and of sensors."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from snowblue import _native
from snowblue._arguments import FLUXES, WAVELENGTH, check_names, checks_names, own_axis
from snowblue._light import BANDS
from snowblue._spectra import DEPTH_FLUXES

if TYPE_CHECKING:
    import xarray as xr

FRACTIONS = ("albedo", *FLUXES, *(name for name in DEPTH_FLUXES if name != "e_folding_depth"))


@checks_names()
def bands(
    solved: xr.Dataset | xr.DataArray,
    bands: str | Iterable[str] | Mapping[str, Any] = ("solar", "par"),
    *,
    light: xr.DataArray | None = None,
) -> xr.Dataset | xr.DataArray:
    """Means of spectra over bands, of sunlight or of a sensor: of fluxes, and of their derivatives.

    A mean is weighted with the light that falls on the snow and with the response of the band. As it is linear in the
    spectrum, the mean of a derivative is the derivative of the mean.

    Parameters
    ----------
    solved : xarray.Dataset or xarray.DataArray
        Result of :func:`spectrum`, :func:`layers` or :func:`albedo`, with ascending wavelengths that cover the bands in
        steps of 50 nm or less.
    bands : names, or a mapping of names to responses
        solar (320 to 2500 nm), par (photons of 400 to 700 nm), visible, near-infrared (700 to 2500 nm). A response is
        an :class:`xarray.DataArray` on `wavelength`, or a pair of wavelengths (nm) and values, in any unit; between the
        wavelengths it is linear, and beyond them 0. A response at a single wavelength is a band of this wavelength,
        which must be one of the spectra. None is the band of that name.
    light : xarray.DataArray, optional
        Irradiance on `wavelength`, which must cover the bands, in any unit of energy, such as that of :func:`sky`; by
        default the standard sun, that of :func:`sunlight`.

    Returns
    -------
    xarray.Dataset or xarray.DataArray
        With `band` in place of `wavelength`. Standard errors are those of errors that are fully correlated between
        wavelengths, and too large for independent ones. E-folding depths, which are no fractions of light, and
        intervals are left out.

    Examples
    --------
    >>> import numpy as np
    >>> import snowblue
    >>> snow = snowblue.spectrum(thickness_cm=np.inf, wavelength_nm=np.arange(400, 1401, 20), standard_errors=False,
    ...                          jacobian="ssa_m2_kg")
    >>> means = snowblue.bands(snow, {"visible": None, "swir": ([1200, 1250, 1300], [0, 1, 0])})
    >>> visible, infrared = means.reflectance_per_ssa_m2_kg.squeeze().values
    >>> bool(infrared > 10 * visible > 0)
    True
    """
    import xarray as xr

    if not isinstance(solved, (xr.Dataset, xr.DataArray)):
        raise ValueError(f"the spectra are of the type {type(solved).__name__}, but must be a Dataset or a DataArray")
    if "wavelength" not in solved.dims or "band" in solved.dims:
        raise ValueError("the spectra need the dimension 'wavelength', and may not have 'band'")
    curves = response_curves(bands)
    weights = band_weights(curves, light, own_axis(WAVELENGTH, solved.wavelength).values.tolist())
    matrix = xr.DataArray(weights, {"band": list(curves)}, ["band", "wavelength"])

    def mean(spectrum: xr.DataArray) -> xr.DataArray:
        dims = [("band" if dim == "wavelength" else dim) for dim in spectrum.dims]
        found = xr.dot(matrix, spectrum.drop_vars("wavelength"), dim="wavelength").transpose(*dims)
        return found.assign_attrs(spectrum.attrs)

    if isinstance(solved, xr.DataArray):
        # Derivatives of fractions have units.
        if "_per_" not in str(solved.name) or _plain(solved.name) not in FRACTIONS:
            _check_fraction(solved)
        return mean(solved).rename(solved.name)
    kept = [name for name in solved.data_vars if _plain(name) in FRACTIONS and "wavelength" in solved[name].dims]
    if not kept:
        raise ValueError(f"the spectra have none of the variables {', '.join(FRACTIONS)}")
    for name in {_plain(name) for name in kept} & set(solved.data_vars):
        _check_fraction(solved[name])
    made = {"light": "ASTM G173-03" if light is None else str(light.name or "given")}
    return xr.Dataset({name: mean(solved[name]) for name in kept}, attrs=solved.attrs | made)


Curve = tuple[list[float], list[float]]
"""Wavelengths and values of a spectrum."""


def response_curves(bands: str | Iterable[str] | Mapping[str, Any]) -> dict[str, Curve | None]:
    """The response of each band; None of those whose names have one."""
    if isinstance(bands, str):
        bands = [bands]
    responses = dict(bands) if isinstance(bands, Mapping) else dict.fromkeys(bands or ())
    if not all(isinstance(name, str) for name in responses):
        raise ValueError("the names of bands must be words")
    check_names(BANDS, [name for name, response in responses.items() if response is None])
    if not responses:
        raise ValueError("no band is given")
    return {
        name: None if response is None else _curve(f"response of {name}", response)
        for name, response in responses.items()
    }


def band_weights(
    curves: Mapping[str, Curve | None], light: xr.DataArray | None, wavelengths_nm: list[float]
) -> np.ndarray:
    """The weight of each wavelength in each band, row by row."""
    lit = None if light is None else _curve("light", light)
    weights = []
    for name, curve in curves.items():
        try:
            if curve is not None and len(curve[0]) == 1:
                weights.append(_single(curve, wavelengths_nm))
            else:
                weights.append(_native.band_weights(name if curve is None else None, curve, lit, wavelengths_nm))
        except ValueError as error:
            raise ValueError(f"band {name}: {error}") from None
    return np.array(weights)


def _single(curve: Curve, wavelengths_nm: list[float]) -> np.ndarray:
    """The weights of a band of one wavelength."""
    [wavelength_nm], [response] = curve
    if not 0 < response < np.inf:
        raise ValueError(f"response is {response:g}, but must be above 0")
    if wavelength_nm not in wavelengths_nm:
        raise ValueError(f"its wavelength of {wavelength_nm:g} nm is not one of the spectra")
    at = np.array(wavelengths_nm) == wavelength_nm
    return at / at.sum()


def _check_fraction(spectrum: xr.DataArray) -> None:
    """Irradiances must not be weighted with sunlight again."""
    units = spectrum.attrs.get("units", "1")
    if units != "1":
        raise ValueError(f"'{spectrum.name}' is in {units}, but means of bands are those of fractions of light")


def _plain(name: Any) -> str:
    """The quantity whose standard error or derivative a variable is, or itself."""
    return str(name).partition("_per_")[0].removesuffix("_se")


def _curve(label: str, given: Any) -> Curve:
    """Wavelengths and values of a spectrum."""
    if hasattr(given, "dims"):
        if given.dims != ("wavelength",) or "wavelength" not in given.coords:
            dims = ", ".join(map(str, given.dims))
            raise ValueError(f"the {label} has the dimensions {dims}, but must have 'wavelength' with its values")
        given = (given.wavelength.values, given.values)
    try:
        wavelengths_nm, values = (np.asarray(one, dtype=float) for one in given)
    except (TypeError, ValueError):
        text = f"the {label} is neither an array on 'wavelength' nor a pair of wavelengths and values"
        raise ValueError(text) from None
    if not np.isfinite(wavelengths_nm).all():
        raise ValueError(f"the {label} has wavelengths that are no numbers")
    if wavelengths_nm.ndim != 1 or values.shape != wavelengths_nm.shape:
        raise ValueError(
            f"the {label} has wavelengths of the shape {wavelengths_nm.shape}, but values of the shape {values.shape}"
        )
    return wavelengths_nm.tolist(), values.tolist()
