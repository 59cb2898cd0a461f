"""Snow from a measured albedo."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from snowblue import _native
from snowblue._arguments import WAVELENGTH, Snow, attributes, numbers, one_snow, ordinates, wavelength_coordinate

if TYPE_CHECKING:
    import xarray as xr
    from typing_extensions import Unpack


BLOCK = 10
"""Neighbouring wavelengths whose errors may correlate; fewer than 4 blocks have no scatter that says something."""


def invert(
    albedo: Any,
    wavelength_nm: Any = None,
    *,
    standard_deviation: Any = 0.01,
    thickness_cm: float = 100.0,
    ground_albedo: float = 0.0,
    free_scale: bool = False,
    streams: int | str = "auto",
    seed: int = 1,
    **snow: Unpack[Snow],
) -> xr.Dataset:
    """The specific surface area and the black carbon of the snow that fits a measured albedo best.

    The light is that of an overcast sky. In the infrared the albedo depends on the surface area, in the visible on
    impurities.

    Parameters
    ----------
    albedo : array
        Albedo at each wavelength; an `xarray.DataArray` with a dimension `wavelength` (nm) needs no `wavelength_nm`.
        Further axes may have one value each.
    wavelength_nm : array, 305 to 1495
    standard_deviation : float or array
        Standard deviation of the albedo. A parameter at an end of its range has the standard error 0.
    thickness_cm, ground_albedo : float
        The thickness of the snow, and the albedo of the ground below.
    free_scale : bool
        Whether the albedo may have a common unknown factor, which is fitted too.
    streams, seed
        As in :func:`snowblue.spectrum`.
    **snow
        Arguments of :class:`Snow`; grain size and black carbon are ignored.

    Returns
    -------
    xarray.Dataset
        `ssa` (m²/kg), `black_carbon` (ng/g) and `scale` with two standard errors: `_se` for errors that are independent
        at all wavelengths, `_block_se` for errors that correlate over 10 neighbouring wavelengths in the order given,
        which needs more than 30 (NaN) and is itself uncertain with fewer than some 100; the measured and
        the fitted albedo; chi² per degree of freedom, and the correlation of surface area and black carbon.

    Examples
    --------
    >>> import numpy as np
    >>> import snowblue
    >>> wavelength_nm = np.arange(400, 1401, 50)
    >>> measured = snowblue.spectrum(ssa_m2_kg=20, thickness_cm=100, angle_deg="diffuse", wavelength_nm=wavelength_nm)
    >>> fit = snowblue.invert(measured.reflectance)
    >>> abs(fit.ssa.item() - 20) < 0.5
    True
    """
    import xarray as xr

    if wavelength_nm is None:
        if "wavelength" not in getattr(albedo, "dims", ()):
            raise TypeError("wavelength_nm is missing, and the albedo has no dimension 'wavelength'")
        wavelength_nm = albedo.wavelength.values
    wavelengths_nm = numbers(WAVELENGTH, wavelength_nm)
    values = np.atleast_1d(np.squeeze(np.asarray(albedo, dtype=float)))
    if values.shape != (len(wavelengths_nm),):
        count = len(wavelengths_nm)
        raise ValueError(f"the albedo has the shape {np.shape(albedo)}, but there are {count} wavelengths")
    deviations = np.squeeze(np.asarray(standard_deviation, dtype=float))
    if deviations.shape not in ((), values.shape):
        raise ValueError(
            f"the standard deviation has the shape {np.shape(standard_deviation)}, but there are {len(values)} values"
        )
    deviations = np.broadcast_to(deviations, values.shape)
    if not (np.isfinite(values).all() and (deviations > 0).all() and np.isfinite(deviations).all()):
        raise ValueError("the albedo must be finite, and its standard deviation finite and above 0")
    if values.min() < 0 or values.max() > 1.5:
        raise ValueError(f"the albedo is {values.min():g} to {values.max():g}, but must lie in 0–1.5")
    parameters = 3 if free_scale else 2
    if len(values) <= parameters:
        raise ValueError(f"there are {len(values)} wavelengths for {parameters} parameters: give more")
    if not thickness_cm > 0:
        raise ValueError(f"thickness is {thickness_cm} cm, but must be above 0 cm")
    given = one_snow(snow)
    measured = {
        "wavelength_nm": wavelengths_nm,
        "albedo": values.tolist(),
        "standard_deviation": deviations.tolist(),
    }
    pack = {
        "snow": given.fixed,
        "thickness_cm": float(thickness_cm),
        "ground_albedo": float(ground_albedo),
        "free_scale": free_scale,
    }
    fit = _native.invert(measured, pack, ordinates(streams, seed))
    if len(values) <= 3 * BLOCK:
        for name in ("ssa", "black_carbon", "scale"):
            fit[f"{name}_block_se"] = float("nan")
    units = {"ssa": "m2 kg-1", "black_carbon": "ng g-1"}
    variables: dict[str, Any] = {
        "albedo": ("wavelength", values, {"units": "1", "long_name": "measured albedo"}),
        "albedo_fit": ("wavelength", fit.pop("albedo"), {"units": "1", "long_name": "albedo of the fitted snow"}),
    }
    for name, value in fit.items():
        plain = name.removesuffix("_se").removesuffix("_block")
        variables[name] = ((), value, {"units": units.get(plain, "1")})
    coords = {"wavelength": wavelength_coordinate(wavelengths_nm)}
    made = {"thickness_cm": float(thickness_cm), "ground_albedo": float(ground_albedo), "seed": seed}
    made["free_scale"] = int(free_scale)
    found = ("grain_size_um", "size_measure", "black_carbon_ng_g")
    kept = {name: value for name, value in given.attrs.items() if name not in found}
    return xr.Dataset(variables, coords, attributes(**kept, **made))
