"""Daylight on the ground, and where the sun stands."""

from __future__ import annotations

import datetime
import re
from typing import TYPE_CHECKING, Any

import numpy as np

from snowblue import _native
from snowblue._arguments import (
    WAVELENGTH,
    Quantity,
    argument_names,
    attributes,
    checks_names,
    is_several,
    number,
    own_axis,
    shown,
)

if TYPE_CHECKING:
    import xarray as xr

CLEAR_TURBIDITY, CLOUD_OPTICAL_THICKNESS = 3.0, 15.0
SKY_NM = np.arange(320.0, 721.0, 10.0)
# Standard names are those of the CF conventions.
ELEVATION = Quantity(
    "elevation", "degree", "angle from the horizon to the sun", {"standard_name": "solar_elevation_angle"}
)
AZIMUTH = Quantity(
    "azimuth", "degree", "angle of the sun from north, clockwise", {"standard_name": "solar_azimuth_angle"}
)

IRRADIANCE = "W m-2 nm-1"
_VARIABLES = {
    "direct_normal": (IRRADIANCE, "irradiance by the sun of a plane that faces it"),
    "direct": (IRRADIANCE, "irradiance of level ground by the sun"),
    "diffuse": (IRRADIANCE, "irradiance of level ground by the sky"),
    "global": (IRRADIANCE, "irradiance of level ground by the sun and the sky"),
    "illuminance_direct": ("lx", "illuminance of level ground by the sun"),
    "illuminance_diffuse": ("lx", "illuminance of level ground by the sky"),
    "par_direct": ("umol m-2 s-1", "photosynthetically active radiation on level ground, from the sun"),
    "par_diffuse": ("umol m-2 s-1", "photosynthetically active radiation on level ground, from the sky"),
}


@checks_names()
def sunlight(wavelength_nm: Any = np.arange(300.0, 2501.0, 10.0)) -> xr.DataArray:
    """The sun's spectrum of ASTM G173-03: sun and clear sky on a plane that is tilted by 37° towards the sun.

    Parameters
    ----------
    wavelength_nm : float or array, 300 to 2500

    Returns
    -------
    xarray.DataArray
        Irradiance in W m-2 nm-1.

    Examples
    --------
    >>> import snowblue
    >>> sun = snowblue.sunlight()
    >>> bool(sun.sel(wavelength=slice(700, None)).integrate("wavelength") > 0.45 * sun.integrate("wavelength"))
    True
    """
    import xarray as xr

    wavelength = own_axis(WAVELENGTH, wavelength_nm)
    made = {"units": IRRADIANCE, "long_name": "irradiance by the standard sun"}
    values = _native.sunlight(wavelength.values.tolist())
    return xr.DataArray(values, {"wavelength": wavelength}, ["wavelength"], "sunlight", made)


@checks_names()
def sun_position(*, latitude_deg: float, longitude_deg: float, time: Any) -> xr.Dataset:
    """Where the sun stands, within 0.02°.

    Parameters
    ----------
    latitude_deg : float, -90 to 90
        North is positive.
    longitude_deg : float, -180 to 180
        East is positive.
    time : str, datetime with a time zone, numpy.datetime64, pandas.Timestamp, or a list or an array of them
        Such as "2026-02-01T12:00:00+01:00". Times of NumPy, pandas and xarray without a time zone are UTC. A list
        makes the axis `time`, in UTC. A date alone, "2026-02-01" or a datetime.date, is the middles of its 96 quarters
        of an hour by the mean solar time of the place; as a numpy.datetime64 it is its beginning.

    Returns
    -------
    xarray.Dataset
        `elevation` in degrees without refraction, negative below the horizon; `apparent_elevation`, at which the sun is
        seen; `azimuth` in degrees from north, clockwise.

    Examples
    --------
    >>> import snowblue
    >>> sun = snowblue.sun_position(latitude_deg=78.22, longitude_deg=15.65, time="2025-12-21T12:00:00+01:00")
    >>> bool(sun.elevation < -10)  # Longyearbyen has no day in December
    True
    """
    import xarray as xr

    dims, positions = _positions(latitude_deg, longitude_deg, time)
    elevation, apparent, azimuth, seconds = positions
    variables = {
        "elevation": (dims, elevation, ELEVATION.attributes()),
        "apparent_elevation": (dims, apparent, {"units": "degree", "long_name": "elevation of the sun, as it is seen"}),
        "azimuth": (dims, azimuth, AZIMUTH.attributes()),
    }
    place = {"latitude_deg": float(latitude_deg), "longitude_deg": float(longitude_deg)}
    return xr.Dataset(variables, {"time": _time_coordinate(dims, seconds)}, attributes(**place))


@checks_names()
def sky(
    *,
    elevation_deg: Any = None,
    latitude_deg: float | None = None,
    longitude_deg: float | None = None,
    time: Any = None,
    refraction: bool = False,
    turbidity: float | None = None,
    ground_albedo: float = 0.8,
    overcast: bool = False,
    cloud_optical_thickness: float | None = None,
    precipitable_water_cm: float = 1.42,
    wavelength_nm: Any = SKY_NM,
) -> xr.Dataset:
    """Irradiance of level ground by the sun and the sky.

    A clear sky is that of Hosek & Wilkie (2012, 2013) to 720 nm and that of Bird & Riordan (1986) beyond, scaled to
    agree at 656 nm, for the mean distance of the sun; an overcast sky is that of the CIE with the spectrum D65 and the
    mean illuminance of Krochmann & Seidl (1974), and beyond 720 nm what clouds of droplets let through of the sun's
    light. With the sun below the horizon all light is zero: there is no model of twilight.

    Parameters
    ----------
    elevation_deg : float or array, -90 to 90
        Angle from the horizon to the sun, instead of a place and a time. An array makes the axis `elevation`.
    latitude_deg, longitude_deg, time
        As for :func:`sun_position`.
    refraction : bool
        Use the elevation at which the sun is seen at that place and time.
    turbidity : float, 1 to 10
        Haze of a clear sky: 2 is very clear air, 3, the default, clear, 6 moist and warm, 10 hazy.
    ground_albedo : float, 0 to 1
        Fraction of visible light that the ground reflects into the sky. Beyond, the ground is as snow.
    overcast : bool
        An overcast sky instead of a clear one.
    cloud_optical_thickness : float, 1 to 200
        Of the clouds of an overcast sky, by default 15. It changes the infrared, which clouds absorb; the illuminance
        is a mean over all clouds and stays.
    precipitable_water_cm : float, 0 to 10
        Water vapour in the air, which absorbs in the infrared: by default that of the US Standard Atmosphere; 0.1 to
        1 in cold air.
    wavelength_nm : float or array, 320 to 2500

    Returns
    -------
    xarray.Dataset
        `direct`, `diffuse` and their sum `global`, and `direct_normal` on a plane that faces the sun, in W m-2 nm-1;
        `illuminance_direct` and `illuminance_diffuse` in lx; `par_direct` and `par_diffuse`, the photons of 400 to
        700 nm, in umol m-2 s-1.

    Examples
    --------
    >>> import snowblue
    >>> light = snowblue.sky(elevation_deg=30, turbidity=2, wavelength_nm=[450, 650])
    >>> bool(light.diffuse.sel(wavelength=450) > 2 * light.diffuse.sel(wavelength=650))  # the sky is blue
    True
    """
    import xarray as xr

    coords: dict[str, Any] = {}
    place = (latitude_deg, longitude_deg, time)
    if elevation_deg is not None:
        if any(part is not None for part in place) or refraction:
            raise ValueError("give either elevation_deg, or latitude_deg, longitude_deg and time")
        dims = ("elevation",) if is_several(elevation_deg) else ()
        elevations = own_axis(ELEVATION, elevation_deg).values
        elevations = elevations if dims else elevations[0]
    else:
        if any(part is None for part in place):
            raise ValueError("give either elevation_deg, or latitude_deg, longitude_deg and time")
        dims, (elevation, apparent, azimuth, seconds) = _positions(*place)
        elevations = apparent if refraction else elevation
        coords = {"time": _time_coordinate(dims, seconds), "azimuth": (dims, azimuth, AZIMUTH.attributes())}
    coords["wavelength"] = own_axis(WAVELENGTH, wavelength_nm)
    if overcast and turbidity is not None:
        raise ValueError("turbidity is of a clear sky, but overcast=True")
    if not overcast and cloud_optical_thickness is not None:
        raise ValueError("cloud_optical_thickness is of an overcast sky: give overcast=True as well")
    haze_name, haze, usual = (
        ("cloud_optical_thickness", cloud_optical_thickness, CLOUD_OPTICAL_THICKNESS)
        if overcast
        else ("turbidity", turbidity, CLEAR_TURBIDITY)
    )
    made = {
        haze_name: usual if haze is None else number(haze_name, haze),
        "ground_albedo": number("ground_albedo", ground_albedo),
        "precipitable_water_cm": number("precipitable_water_cm", precipitable_water_cm),
    }
    weather = (overcast, *made.values())
    wavelengths_nm = coords["wavelength"].values.tolist()
    rows = [_native.sky(elevation, weather, wavelengths_nm) for elevation in np.ravel(elevations).tolist()]
    variables = {}
    for name, (unit, long_name) in _VARIABLES.items():
        array = np.array([row[name] for row in rows])
        own = (*dims, "wavelength") if array.ndim == 2 else dims
        array = array.reshape([len(rows)] * len(dims) + list(array.shape[1:]))
        variables[name] = (own, array, {"units": unit, "long_name": long_name})
    coords["elevation"] = (dims, elevations, ELEVATION.attributes())
    return xr.Dataset(variables, coords, attributes(sky="overcast" if overcast else "clear", **made))


SKY_NAMES = argument_names(sky)


def _positions(latitude_deg: Any, longitude_deg: Any, time: Any) -> tuple[tuple[str, ...], np.ndarray]:
    """The dimensions of the time, and elevation, apparent elevation, azimuth and seconds since 1970."""
    if hasattr(time, "dtype"):
        array = np.asarray(time)
        if array.ndim > 1:
            raise ValueError(f"time has {array.ndim} dimensions, but must have 1")
        time = list(array) if array.ndim == 1 else array[()]
    elif isinstance(time, datetime.date) and not isinstance(time, datetime.datetime):
        time = time.isoformat()
    is_date = isinstance(time, str) and re.fullmatch(r"\d{4}-\d{2}-\d{2}", time) is not None
    dims = ("time",) if is_several(time) or is_date else ()
    if dims and len(time) == 0:
        raise ValueError("time has no values")
    place = (number("latitude_deg", latitude_deg), number("longitude_deg", longitude_deg))
    if is_date:
        rows = _native.sun_of_day(*place, time)
    else:
        rows = [_native.sun_position(*place, _time(one)) for one in (time if dims else [time])]
    return dims, np.array(rows).T.reshape(4, *([len(rows)] if dims else []))


def _time(time: Any) -> str:
    """A time as text. That of NumPy and pandas is UTC unless it has a time zone, that of Python needs one."""
    if hasattr(time, "to_datetime64") and time.tzinfo is None:
        time = time.to_datetime64()
    if isinstance(time, np.datetime64) and not np.isnat(time):
        return f"{time.astype('datetime64[ms]')}Z"
    if isinstance(time, datetime.datetime):
        return time.isoformat()
    if not isinstance(time, str):
        raise ValueError(
            f"time is {shown(time)}, but must be a text such as '2026-02-01T12:00:00+01:00', a datetime with a time "
            "zone or a numpy.datetime64, which is UTC"
        )
    return time


def _time_coordinate(dims: tuple[str, ...], seconds: np.ndarray) -> tuple[Any, ...]:
    times = np.round(1000 * seconds).astype("datetime64[ms]").astype("datetime64[ns]")
    return (dims, times, {"long_name": "time, UTC", "standard_name": "time"})
