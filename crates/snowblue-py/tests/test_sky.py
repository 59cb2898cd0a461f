"""Daylight: the command's figures, axes and units, Mitsuba's sun, and another program's position of the sun."""

import datetime

import mitsuba
import numpy as np
import pandas as pd
import pytest
import xarray as xr

import snowblue

# The command prints 9 significant digits.
PRINTED = 1e-8
INNSBRUCK = {"latitude_deg": 47.27, "longitude_deg": 11.39}


def test_figures_are_those_of_the_command(command):
    for words, keywords in (
        (["--turbidity", 2.2, "--ground-albedo", 0.3], {"turbidity": 2.2, "ground_albedo": 0.3}),
        ([], {}),
        (["--overcast"], {"overcast": True}),
        (["--overcast", "--cloud-thickness", 40, "--ground-albedo", 0.2, "--precipitable-water", 0.5],
         {"overcast": True, "cloud_optical_thickness": 40, "ground_albedo": 0.2, "precipitable_water_cm": 0.5}),
    ):
        rows = command("sky", "--elevation", 25, "--wavelengths", "350,450,650,1240", *words)
        ours = snowblue.sky(elevation_deg=25, wavelength_nm=[350, 450, 650, 1240], **keywords)
        for name in ("direct_normal", "direct", "diffuse", "global"):
            printed = [float(row[f"{name}_w_m2_nm"]) for row in rows]
            np.testing.assert_allclose(ours[name], printed, rtol=PRINTED)


def test_a_place_and_a_time_are_those_of_the_command(command):
    time = "2026-02-01T12:00:00+01:00"
    for words, keywords in (([], {}), (["--refraction"], {"refraction": True})):
        rows = command("sky", "--latitude", 47.27, "--longitude", 11.39, "--time", time, "--wavelengths", 550, *words)
        ours = snowblue.sky(**INNSBRUCK, time=time, wavelength_nm=550, **keywords)
        assert float(rows[0]["global_w_m2_nm"]) == pytest.approx(ours["global"].item(), rel=PRINTED)


def test_times_and_elevations_make_an_axis():
    zone = datetime.timezone(datetime.timedelta(hours=1))
    times = [datetime.datetime(2026, 2, 1, hour, 30, tzinfo=zone) for hour in (9, 12, 15)]
    day = snowblue.sky(**INNSBRUCK, time=times, wavelength_nm=[450, 650])
    assert day.direct.dims == ("time", "wavelength") and day.par_direct.dims == ("time",)
    assert day.time.values[0] == np.datetime64("2026-02-01T08:30:00")
    one = snowblue.sky(**INNSBRUCK, time="2026-02-01T12:30:00+01:00", wavelength_nm=[450, 650])
    assert one.direct.dims == ("wavelength",)
    np.testing.assert_allclose(day.direct.isel(time=1), one.direct, rtol=1e-12)
    np.testing.assert_allclose(day.elevation.isel(time=1), one.elevation, rtol=1e-12)
    assert (day.azimuth.diff("time") > 0).all()

    heights = snowblue.sky(elevation_deg=[10, 30, 50], wavelength_nm=550)
    assert heights["global"].dims == ("elevation", "wavelength")
    assert (heights.illuminance_direct.diff("elevation") > 0).all()


def test_variables_have_units_and_attributes_say_what_made_them():
    light = snowblue.sky(elevation_deg=30, turbidity=2)
    assert light.direct.units == "W m-2 nm-1" and light.illuminance_direct.units == "lx"
    assert light.par_diffuse.units == "umol m-2 s-1" and light.elevation.units == "degree"
    assert all(variable.long_name for variable in light.data_vars.values())
    assert light.attrs["sky"] == "clear" and light.attrs["turbidity"] == 2 and light.attrs["ground_albedo"] == 0.8
    np.testing.assert_allclose(light["global"], light.direct + light.diffuse, rtol=1e-12)
    np.testing.assert_allclose(light.direct, 0.5 * light.direct_normal, rtol=1e-12)
    overcast = snowblue.sky(elevation_deg=30, overcast=True)
    assert overcast.attrs["sky"] == "overcast" and "turbidity" not in overcast.attrs
    assert overcast.attrs["cloud_optical_thickness"] == 15 and overcast.attrs["precipitable_water_cm"] == 1.42
    assert (overcast.direct == 0).all() and overcast.illuminance_diffuse.item() == pytest.approx(10800)


def test_par_is_the_integral_of_the_spectrum():
    """By the trapezoidal rule every 5 nm, as in the crate; 8.3593e-3 umol per J and nm."""
    light = snowblue.sky(elevation_deg=40, wavelength_nm=np.arange(400, 701, 5))
    for part in ("direct", "diffuse"):
        photons = (light[part] * light.wavelength * 8.3593469e-3).integrate("wavelength").item()
        assert photons == pytest.approx(light[f"par_{part}"].item(), rel=1e-6)


def test_the_sun_is_that_of_mitsuba():
    """Its default sun has the mean radiance of the disc, from a fit that differs from the disc by 0.3 %."""
    variant = mitsuba.variant()
    mitsuba.set_variant("scalar_spectral")
    try:
        for elevation_deg, turbidity in ((20, 2.0), (60, 5.0)):
            elevation = np.radians(elevation_deg)
            towards = [0.0, np.cos(elevation), np.sin(elevation)]
            sun = mitsuba.load_dict(
                {"type": "sunsky", "sun_direction": towards, "turbidity": turbidity, "sky_scale": 0.0})
            interaction = mitsuba.SurfaceInteraction3f()
            interaction.wi = -mitsuba.Vector3f(towards)
            interaction.wavelengths = wavelengths_nm = [400.0, 480.0, 560.0, 680.0]
            solid_angle = 2 * np.pi * (1 - np.cos(np.radians(0.5358 / 2)))
            expected = solid_angle * np.array(sun.eval(interaction))
            ours = snowblue.sky(elevation_deg=elevation_deg, turbidity=turbidity, wavelength_nm=wavelengths_nm)
            np.testing.assert_allclose(ours.direct_normal, expected, rtol=5e-3)
    finally:
        mitsuba.set_variant(variant)


def test_the_sun_stands_where_it_should():
    """Reda & Andreas 2004, doi:10.1016/j.solener.2003.12.003, appendix A.5."""
    sun = snowblue.sun_position(
        latitude_deg=39.742476, longitude_deg=-105.1786, time="2003-10-17T12:30:30-07:00")
    assert sun.elevation.item() == pytest.approx(39.872046, abs=0.01)
    assert sun.azimuth.item() == pytest.approx(194.34024, abs=0.015)
    assert sun.apparent_elevation.item() == pytest.approx(sun.elevation.item() + 0.02, abs=0.002)
    assert sun.time.values == np.datetime64("2003-10-17T19:30:30")
    day = snowblue.sun_position(**INNSBRUCK, time=["2026-06-21T04:00Z", "2026-06-21T11:00Z", "2026-06-21T18:00Z"])
    assert day.elevation.dims == ("time",) and day.elevation.values.argmax() == 1


def test_times_of_numpy_pandas_and_xarray_are_utc():
    texts = ["2026-02-01T08:30Z", "2026-02-01T11:30Z"]
    expected = snowblue.sun_position(**INNSBRUCK, time=texts)
    plain = np.array(["2026-02-01T08:30", "2026-02-01T11:30"], dtype="datetime64[m]")
    for times in (plain, list(plain), pd.DatetimeIndex(plain), pd.Series(plain), list(pd.DatetimeIndex(plain)),
                  expected.time, pd.DatetimeIndex(plain).tz_localize("UTC").tz_convert("Europe/Vienna")):
        xr.testing.assert_identical(snowblue.sun_position(**INNSBRUCK, time=times), expected)
    first = snowblue.sun_position(**INNSBRUCK, time=texts[0])
    for time in (plain[0], pd.Timestamp(plain[0]), expected.time[0], plain[0].astype("datetime64[ns]")):
        xr.testing.assert_identical(snowblue.sun_position(**INNSBRUCK, time=time), first)
    day = snowblue.sun_position(**INNSBRUCK, time="2026-02-01")
    xr.testing.assert_identical(snowblue.sun_position(**INNSBRUCK, time=datetime.date(2026, 2, 1)), day)
    midnight = snowblue.sun_position(**INNSBRUCK, time="2026-02-01T00:00Z")
    xr.testing.assert_identical(snowblue.sun_position(**INNSBRUCK, time=np.datetime64("2026-02-01")), midnight)


@pytest.mark.parametrize("keywords, message", [
    ({}, "give either elevation_deg, or latitude_deg, longitude_deg and time"),
    ({"latitude_deg": 47, "longitude_deg": 11}, "give either elevation_deg, or "),
    ({"elevation_deg": 30, "time": "2026-02-01T12:00Z"}, "give either elevation_deg, or "),
    ({"elevation_deg": 30, "refraction": True}, "give either elevation_deg, or "),
    ({"elevation_deg": -93.2}, "sun elevation is -93.2°, but must lie in -90–90°"),
    ({"elevation_deg": 30, "turbidity": 0.5}, "turbidity is 0.5, but must lie in 1–10"),
    ({"elevation_deg": 30, "ground_albedo": 1.5}, "ground albedo is 1.5, but must lie in 0–1"),
    ({"elevation_deg": 30, "wavelength_nm": 2501}, "wavelength is 2501 nm, but must lie in 320–2500 nm"),
    ({"elevation_deg": 30, "overcast": True, "turbidity": 2}, "turbidity is of a clear sky, but overcast=True"),
    ({"elevation_deg": 30, "cloud_optical_thickness": 2}, "cloud_optical_thickness is of an overcast sky"),
    ({"elevation_deg": 30, "overcast": True, "cloud_optical_thickness": 0}, "thickness of clouds is 0, but must"),
    ({**INNSBRUCK, "time": "noon"}, "time is `noon`, but must be a date, a time and its offset from UTC"),
    ({**INNSBRUCK, "time": 12}, "time is 12, but must be a text such as"),
    ({**INNSBRUCK, "time": datetime.datetime(2026, 2, 1, 12)}, "offset from UTC"),
    ({**INNSBRUCK, "time": np.datetime64("NaT")}, "but must be a text such as"),
    ({**INNSBRUCK, "time": np.datetime64("2026-02-01T12", "h") + np.zeros((2, 2), int)}, "time has 2 dimensions"),
    ({**INNSBRUCK, "time": []}, "time has no values"),
])
def test_bad_input_is_refused(keywords, message):
    with pytest.raises(ValueError) as refusal:
        snowblue.sky(**keywords)
    assert message in str(refusal.value)
