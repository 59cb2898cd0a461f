"""Light at depth in snow under the sun and the sky."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from snowblue import _native
from snowblue._arguments import (
    DEPTH,
    THICKNESS,
    WAVELENGTH,
    Quantity,
    attributes,
    check_names,
    checks_names,
    mapping,
    names_of,
    one_ground,
    ordinates,
    own_axis,
)
from snowblue._sky import ELEVATION, IRRADIANCE, SKY_NAMES, sky as daylight
from snowblue._spectra import (
    changed_layer,
    described_layers,
    is_of_layers,
    locating_layers,
    packed_layers,
    parameter_quantity,
    parameters,
)

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

LEVELS = {
    "down": "flux downwards, through a level plane",
    "up": "flux upwards, through a level plane",
    "net": "net flux downwards",
    "actinic": "actinic flux (fluence rate), from all directions",
    "absorbed": "power that the snow absorbs per volume",
    "layer_absorbed": "power that the layer absorbs per level area",
}
LOWEST_SUN_DEG = -1.0
"""Refraction and the sun's radius show some of it down to an elevation of -0.85 degrees."""
BANDS = ("solar", "par", "visible", "near-infrared")
AXES = ("depth", "layer", "wavelength", "changed_layer")


@checks_names()
def light_at_depth(
    layers: Iterable[Mapping[str, Any]] | pd.DataFrame,
    sky: Mapping[str, Any] | xr.Dataset,
    *,
    depth_cm: Any,
    ground_albedo: Any = 0.0,
    daily: bool = False,
    bands: Iterable[str] | None = None,
    jacobian: str | Iterable[str] = (),
    streams: int | str = "auto",
    seed: int = 1,
) -> xr.Dataset:
    """Light and warming in layers of snow under the sun and the sky, at depths and in layers.

    Irradiances and fluxes are per level area (plane); actinic fluxes count light from all directions alike (scalar);
    absorbed power is per volume of snow, or per level area of a layer. The sky is taken as equally bright everywhere.

    Parameters
    ----------
    layers : mappings or pandas.DataFrame, top first
        As in :func:`layers`.
    sky : mapping or xarray.Dataset
        Arguments of :func:`sky`, such as `dict(latitude_deg=47.27, longitude_deg=11.39, time="2026-02-01T12:00+01:00",
        turbidity=2)`, or its result, or measurements in that form: `direct` and `diffuse` in W m-2 nm-1 on
        `wavelength`, which ascends, and the `elevation` of the sun in degrees. Default wavelengths are every 10 nm of
        320 to 720 nm and, under a clear sky, every 20 nm of 740 to 2500 nm.
    depth_cm : array
        Depths below the surface. At a face of ice fluxes are those outside it; `absorbed` and `warming` at a face of
        ice to air are those of the ice.
    ground_albedo : float, 0 to 1, or a spectrum on `wavelength` as in :func:`spectrum`
        Albedo of the ground below the snow.
    daily : bool
        Sums over a day instead of values at each time, whose steps must be equal: of the 96 quarters of an hour that
        :func:`sky` takes for a date alone, `time="2026-02-01"`.
    bands : names
        Integrals: solar (320 to 2500 nm), par (photons of 400 to 700 nm), visible, near-infrared. By default
        those of solar and par that the wavelengths cover.
    jacobian : str or several, optional
        Parameters with respect to which all but the warming is differentiated, as in :func:`layers`, at constant
        irradiances: `par_down_per_ssa_m2_kg` and so on, before the other axes on `changed_layer`, the layer whose
        property changes. `layer_absorbed` is what the layer absorbs between its faces, which move with a thickness.
    streams, seed
        As in :func:`spectrum`.

    Returns
    -------
    xarray.Dataset
        On the axis of the sky, then `depth`, then `wavelength`: `down`, `up`, `net`, `actinic` in W m-2 nm-1, and
        `absorbed` in W m-3 nm-1; `layer_absorbed` in W m-2 nm-1, on `layer`. Bands have their names before these:
        `solar_net` in W m-2, `par_actinic` in umol m-2 s-1. `warming` and `layer_warming`, in K h-1, are those of the
        ice by the absorbed light alone, and NaN in wet snow and of a half-space. Sums of a day have J for W,
        umol for umol s-1, and K.

    Examples
    --------
    >>> import snowblue
    >>> pack = [dict(thickness_cm=10, snow="fresh"), dict(thickness_cm=50, snow="rounded")]
    >>> noon = dict(elevation_deg=25, turbidity=2)
    >>> light = snowblue.light_at_depth(pack, noon, depth_cm=[0, 10, 20])
    >>> bool(light.par_actinic.sel(depth=10) > 3 * light.par_down.sel(depth=10))
    True
    """
    import xarray as xr

    packed = packed_layers(layers)
    depth = own_axis(DEPTH, depth_cm)
    depths_cm = depth.values.tolist()
    jacobian = parameters(jacobian)
    if not isinstance(sky, xr.Dataset):
        sky = mapping("sky", sky, "{'elevation_deg': 25}, or a dataset of snowblue.sky")
        check_names(SKY_NAMES, sky)
        sky = daylight(**{"wavelength_nm": _native.daylight_wavelengths(), **sky})
    for name in ("direct", "diffuse", "elevation"):
        if name not in sky:
            raise ValueError(f"the sky has no '{name}'")
    for quantity in (Quantity("direct", IRRADIANCE), Quantity("diffuse", IRRADIANCE), ELEVATION):
        quantity.check(sky[quantity.name])
    wavelength = own_axis(WAVELENGTH, sky.wavelength)
    wavelengths_nm = wavelength.values.tolist()
    if not np.all(np.diff(wavelengths_nm) > 0):
        raise ValueError("the wavelengths of the sky must ascend: sort it with sky.sortby('wavelength')")
    dims = [dim for dim in sky.direct.dims if dim != "wavelength"]
    if len(dims) > 1:
        raise ValueError(f"the sky has the axes {', '.join(map(str, dims))}, but may have one beside the wavelength")
    if daily and dims != ["time"]:
        raise ValueError("daily sums need a sky at times: give a date, time='2026-02-01'")
    direct, diffuse = (
        sky[name].transpose(*dims, "wavelength").values.reshape(-1, len(wavelengths_nm))
        for name in ("direct", "diffuse")
    )
    elevations = np.broadcast_to(sky.elevation.values, [sky.sizes[dim] for dim in dims]).reshape(-1)
    if not np.isfinite(elevations).all():
        raise ValueError("elevation of the sun is not a number")
    if daily:
        _check_steps(sky.time.values)
    for name, light in (("direct", direct), ("diffuse", diffuse)):
        wrong = ~(np.isfinite(light) & (light >= 0))
        if wrong.any():
            row, place = np.argwhere(wrong)[0]
            where = f"{wavelengths_nm[place]:g} nm" + (f", {dims[0]} {row}" if dims else "")
            raise ValueError(f"{name} light at {where} is {light[row, place]}, but must be a number from 0 up")
    of_night = (elevations < LOWEST_SUN_DEG)[:, None] & (direct > 0)
    if of_night.any():
        row, place = np.argwhere(of_night)[0]
        raise ValueError(
            f"direct light at {wavelengths_nm[place]:g} nm is {direct[row, place]:g} with the sun at "
            f"{elevations[row]:g} degrees, but must be 0 with the sun below the horizon"
        )
    lights = list(zip(elevations.tolist(), direct.tolist(), diffuse.tolist()))
    if bands is None:
        covered = _native.covered_bands(wavelengths_nm)
        bands = [band for band in ("solar", "par") if band in covered]
    bands = names_of("bands", bands, "bands, such as 'par'")
    check_names(BANDS, bands)
    albedo, of_ground, stated = one_ground(ground_albedo, wavelength)
    ground = {"layers": packed, "ground_albedo": albedo, "depth_cm": depths_cm}
    with locating_layers(packed, depths_cm):
        arrays = _native.light_in_layers(
            ground, wavelengths_nm, lights, bands, bool(daily), jacobian, ordinates(streams, seed)
        )
    dims = [] if daily else dims
    kept = {} if daily else {name: sky[name].variable for name in ("time", "elevation", "azimuth") if name in sky}
    layer = xr.Variable("layer", np.arange(len(packed)), {"long_name": "number of the layer, from the top"})
    depth.attrs |= {"standard_name": "depth", "positive": "down"}
    coords = {
        **kept,
        "depth": depth,
        "layer": layer,
        "thickness": xr.Variable("layer", [thickness_cm for _, thickness_cm in packed], THICKNESS.attributes()),
        "wavelength": wavelength,
        **of_ground,
        "changed_layer": changed_layer(len(packed)),
    }
    sizes = {dim: sky.sizes[dim] for dim in dims} | {name: coords[name].size for name in AXES}
    variables = {}
    for label, array in arrays.items():
        label = label.replace("-", "_")
        name, _, parameter = label.partition("_per_")
        band = next((band for band in bands if name.startswith(band.replace("-", "_") + "_")), None)
        plain = name.removeprefix(band.replace("-", "_") + "_") if band else name
        is_spectral = not band and "warming" not in name
        attrs = _describe(plain, band, is_spectral, daily)
        if parameter:
            quantity = parameter_quantity(parameter)
            attrs["units"] = quantity.of_derivative(attrs["units"])
            of = f"derivative with respect to {quantity.attributes()['long_name']} of: "
            attrs["long_name"] = of + attrs["long_name"]
        own = [*dims, *(["changed_layer"] if is_of_layers(parameter) else [])]
        own += ["layer" if plain.startswith("layer") else "depth", *(["wavelength"] if is_spectral else [])]
        array = array / 3600.0 if "warming" in name and daily else array
        variables[label] = (own, array.reshape([sizes[dim] for dim in own]), attrs)
    if not jacobian:
        del coords["changed_layer"]
    made = {
        **{f"sky_{name}": value for name, value in sky.attrs.items() if name not in ("Conventions", "source")},
        "layers": described_layers(packed),
        **stated,
        "engine": f"discrete ordinates, {streams} streams",
        "seed": seed,
    }
    if daily:
        half = (sky.time.values[1] - sky.time.values[0]) // 2
        ends = (sky.time.values[0] - half, sky.time.values[-1] + half)
        made["sum"] = "from {} to {} UTC".format(*(str(end.astype("datetime64[s]")) for end in ends))
    return xr.Dataset(variables, coords, attributes(**made))


def _check_steps(times: np.ndarray) -> None:
    steps = np.diff(times)
    day = np.timedelta64(1, "D")
    # Times are rounded to milliseconds.
    if len(steps) == 0 or abs(len(times) * steps - day).max() > np.timedelta64(1, "s"):
        raise ValueError("daily sums need times at equal steps that fill a day: give a date, time='2026-02-01'")


def _describe(plain: str, band: str | None, spectral: bool, daily: bool) -> dict[str, str]:
    if "warming" in plain:
        where = "by the light that the layer absorbs" if plain.startswith("layer") else "by light at this depth"
        long_name = f"warming of the ice {where}"
        return {"units": "K" if daily else "K h-1", "long_name": long_name}
    volume = "m-3" if plain == "absorbed" else "m-2"
    if band == "par":
        units = f"umol {volume}" if daily else f"umol {volume} s-1"
    else:
        units = f"{'J' if daily else 'W'} {volume}{' nm-1' if spectral else ''}"
    of = {"par": "photosynthetically active radiation: ", None: ""}.get(band, f"{band} radiation: ")
    long_name = LEVELS[plain].replace("power", "photons") if band == "par" else LEVELS[plain]
    return {"units": units, "long_name": of + long_name}
