"""Light at depth: energy, the command's figures, another sun, days and nights, and what is wrong."""

import numpy as np
import pytest
import xarray as xr

import snowblue

# The command prints 9 significant digits.
PRINTED = 1e-8
PACK = [
    {"thickness_cm": 10, "snow": "fresh", "density_kg_m3": 100},
    {"thickness_cm": 60, "snow": "rounded", "impurities_ng_g": {"black-carbon": 10}},
]
LAYERS = """[[layer]]
thickness_cm = 10
snow = "fresh"
density_kg_m3 = 100
[[layer]]
thickness_cm = 60
snow = "rounded"
impurities_ng_g = { black-carbon = 10 }
"""
INNSBRUCK = {"latitude_deg": 47.27, "longitude_deg": 11.39}
NOON = {**INNSBRUCK, "time": "2026-02-01T12:00:00+01:00", "turbidity": 2}
DEPTHS = [0, 1, 10, 40]


def test_light_is_conserved_and_is_that_of_layers_weighted_by_the_sky():
    light = snowblue.light_at_depth(PACK, NOON, depth_cm=DEPTHS, ground_albedo=0.2)
    sky = snowblue.sky(**NOON, wavelength_nm=light.wavelength)
    np.testing.assert_allclose(light.down.sel(depth=0), sky["global"], rtol=1e-12)
    unit = snowblue.layers(PACK, depth_cm=DEPTHS, ground_albedo=0.2, wavelength_nm=light.wavelength,
                           angle_deg=[90 - sky.elevation.item(), "diffuse"], standard_errors=False)
    for ours, name in (("down", "down"), ("net", "net"), ("actinic", "fluence")):
        of_sun, of_sky = unit[name].isel(angle=0), unit[name].isel(angle=1)
        expected = (of_sun * sky.direct + of_sky * sky.diffuse).transpose("depth", "wavelength")
        np.testing.assert_allclose(light[ours], expected, rtol=1e-9)
    # What the layers and the ground keep is what does not leave the top.
    at_ground = snowblue.light_at_depth(PACK, NOON, depth_cm=[70], ground_albedo=0.2)
    kept = light.solar_layer_absorbed.sum() + at_ground.solar_net.sel(depth=70)
    np.testing.assert_allclose(kept, light.solar_net.sel(depth=0), rtol=1e-9)
    np.testing.assert_allclose(light.net.sel(depth=0).integrate("wavelength"), light.solar_net.sel(depth=0), rtol=1e-12)
    # The photons of 400 to 700 nm that `sky` counts every 5 nm.
    assert light.par_down.sel(depth=0).item() == pytest.approx((sky.par_direct + sky.par_diffuse).item(), rel=2e-3)


def test_soot_never_cools_and_bands_are_whole():
    """The radiative forcing of soot and of dust, in deep snow at noon."""
    def absorbed(**impurities_ng_g):
        pack = [{"thickness_cm": np.inf, "ssa_m2_kg": 20, "impurities_ng_g": impurities_ng_g}]
        return snowblue.light_at_depth(pack, NOON, depth_cm=0, bands=["solar", "near-infrared"])

    clean = absorbed()
    for dirty in (absorbed(black_carbon=100), absorbed(saharan_dust=50_000), absorbed(snow_algae=20_000)):
        forcing = (dirty.solar_net - clean.solar_net).item()
        assert forcing > 1 and dirty.near_infrared_net > clean.near_infrared_net
    with pytest.raises(ValueError, match="the solar band needs wavelengths from 320 to 2500 nm, .*from 320 to 400 nm$"):
        snowblue.bands(snowblue.spectrum(thickness_cm=100, standard_errors=False), "solar")


def test_particles_of_a_table_are_those_of_the_columns():
    wavelength = xr.DataArray([300.0, 2500.0], dims="wavelength")
    by_name = snowblue.substance("my_soot", {"wavelength_nm": [300, 2500], "absorption_m2_kg": [9000, 2000]})
    values = xr.DataArray([9000.0, 2000.0], {"wavelength": wavelength}, ["wavelength"], attrs={"units": "m2 kg-1"})
    assert by_name == snowblue.substance("my-soot", values) == "my-soot"
    dirty = snowblue.spectrum(
        thickness_cm=np.inf, wavelength_nm=500, impurities_ng_g={by_name: [0, 100]}, jacobian=by_name)
    assert dirty.my_soot.dims == ("my_soot",) and (dirty.reflectance_per_my_soot < 0).all()
    assert dirty.reflectance[1] < dirty.reflectance[0]
    scattering = {"wavelength": wavelength, "extinction_m2_kg": [800, 400], "single_scattering_albedo": [0.8, 0.9]}
    for name, particles, words in (
        ("my-soot", {"wavelength_nm": [300, 2500], "absorption_m2_kg": [1, 2]}, "my-soot: the name is taken"),
        ("black-carbon", values, "the name is taken by a built-in substance"),
        ("my soot", values, "must have only letters"),
        ("dust", scattering, "asymmetry has 0 values, but there are 2 wavelengths"),
        ("dust", values[::-1], "ascend"),
        ("dust", values.assign_attrs(units="m2 g-1"), "states the units 'm2 g-1'"),
        ("dust", {"absorbance": [1, 2]}, "'absorbance' is not known; there are wavelength_nm"),
    ):
        with pytest.raises(ValueError, match=words):
            snowblue.substance(name, particles)


def test_units_and_axes_are_stated():
    light = snowblue.light_at_depth(PACK, NOON, depth_cm=DEPTHS, bands=["solar", "par", "near-infrared"])
    assert light.down.dims == ("depth", "wavelength") and light.down.units == "W m-2 nm-1"
    assert light.par_actinic.units == "umol m-2 s-1" and light.near_infrared_absorbed.units == "W m-3"
    assert light.layer_warming.dims == ("layer",) and light.warming.units == "K h-1"
    assert light.depth.standard_name == "depth" and light.elevation.standard_name == "solar_elevation_angle"
    assert light.wavelength.max() == 2500 and light.sky_turbidity == 2
    dark = snowblue.light_at_depth(PACK[:1], {"elevation_deg": 20, "overcast": True}, depth_cm=0)
    assert dark.wavelength.max() == 2500


def test_figures_are_those_of_the_command(command, tmp_path):
    pack = tmp_path / "pack.toml"
    pack.write_text(LAYERS)
    words = ["spectrum", "--layers", pack, "--depths", "0,1,10,40", "--turbidity", 2, "--ground-albedo", 0.2]
    place = "47.27,11.39,2026-02-01"
    ours = snowblue.light_at_depth(PACK, NOON, depth_cm=DEPTHS, ground_albedo=0.2)
    rows = command(*words, "--sky", f"{place}T12:00:00+01:00")
    for name in ("down", "up", "net", "actinic"):
        printed = [float(row[f"{name}_w_m2_nm"]) for row in rows]
        np.testing.assert_allclose(ours[name].values.ravel(), printed, rtol=PRINTED)
    rows = command(*words, "--sky", f"{place}T12:00:00+01:00", "--broadband", "par,solar")
    at_depth = [row for row in rows if not row["bottom_cm"]]
    for band in ("par", "solar"):
        printed = [float(row["actinic_per_m2"]) for row in at_depth if row["band"].startswith(f"{band}-")]
        np.testing.assert_allclose(ours[f"{band}_actinic"], printed, rtol=PRINTED)
    in_layers = [row for row in rows if row["bottom_cm"] and row["band"].startswith("solar-")]
    np.testing.assert_allclose(ours.layer_warming, [float(row["warming_k_h"]) for row in in_layers], rtol=PRINTED)
    words += ["--wavelengths", "400:700:20"]
    visible = {"wavelength_nm": np.arange(400, 701, 20)}
    day = snowblue.light_at_depth(
        PACK, NOON | visible | {"time": "2026-02-01"}, depth_cm=DEPTHS, ground_albedo=0.2, daily=True
    )
    rows = command(*words, "--sky", place, "--broadband", "par")
    printed = [float(row["down_per_m2"]) for row in rows if row["down_per_m2"]]
    np.testing.assert_allclose(day.par_down, printed, rtol=PRINTED)
    assert rows[0]["unit"] == "µmol" and day.par_down.units == "umol m-2"


def test_a_day_is_the_sum_of_its_quarters_and_the_night_is_dark():
    day = {**INNSBRUCK, "time": "2026-06-21", "turbidity": 2, "wavelength_nm": np.arange(320, 2501, 20)}
    quarters = snowblue.light_at_depth(PACK, day, depth_cm=[0, 5], bands=["par", "solar"])
    assert quarters.sizes["time"] == 96
    night = quarters.where(quarters.elevation < 0, drop=True)
    assert night.sizes["time"] > 20 and (night.down == 0).all() and (night.warming == 0).all()
    total = snowblue.light_at_depth(PACK, day, depth_cm=[0, 5], bands=["par", "solar"], daily=True)
    np.testing.assert_allclose(total.par_down, 86400 * quarters.par_down.mean("time"), rtol=1e-12)
    np.testing.assert_allclose(total.warming, 24 * quarters.warming.mean("time"), rtol=1e-12)
    # Around Midsummer a clear day has some 60 mol of photons per m².
    assert 45e6 < total.par_down.sel(depth=0) < 70e6
    dark = snowblue.sky(elevation_deg=[-5, 5], wavelength_nm=[450, 1000])
    assert (dark.direct.isel(elevation=0) == 0).all() and dark.par_diffuse[0] == 0 and (dark.direct[1] > 0).all()


def test_the_infrared_of_the_sky_is_that_of_the_standard_sun():
    # ASTM G173-03 has the air mass 1.5, 1.42 cm of water and a light haze; scaled at 640–700 nm, as its plane is
    # tilted.
    wavelength_nm = np.arange(640, 2501, 5)
    sky = snowblue.sky(elevation_deg=41.8, turbidity=2.5, wavelength_nm=wavelength_nm)["global"]
    sun = snowblue.sunlight(wavelength_nm)
    join = slice(640, 700)

    def band(first, last):
        part = slice(first, last)
        return (sky.sel(wavelength=part).mean() / sky.sel(wavelength=join).mean()).item() / (
            sun.sel(wavelength=part).mean() / sun.sel(wavelength=join).mean()
        ).item()
    # The report compares its model with measurements and rigorous codes, and finds 5 to 10 %.
    for first, last in ((720, 900), (900, 1000), (1000, 1100), (1150, 1300), (1500, 1750), (2050, 2400)):
        assert 0.9 < band(first, last) < 1.1, (first, last, band(first, last))
    dry = snowblue.sky(elevation_deg=41.8, precipitable_water_cm=0.1, wavelength_nm=[940, 1040])["global"]
    wet = snowblue.sky(elevation_deg=41.8, precipitable_water_cm=3, wavelength_nm=[940, 1040])["global"]
    assert wet[0] < 0.6 * dry[0] and wet[1] > 0.99 * dry[1]


def test_bands_are_those_that_the_wavelengths_cover():
    def names(wavelength_nm):
        sky = {"elevation_deg": 30, "wavelength_nm": wavelength_nm}
        return {name for name in ("solar_down", "par_down", "warming")
                if name in snowblue.light_at_depth(PACK, sky, depth_cm=[0])}
    assert names([450]) == names([500, 510]) == set()
    assert names(np.arange(400, 701, 50)) == {"par_down"}
    assert names(np.arange(320, 2501, 20)) == {"solar_down", "par_down", "warming"}


def test_a_half_space_keeps_what_arrives_but_has_no_warming():
    endless = [PACK[0], PACK[1] | {"thickness_cm": np.inf}]
    light = snowblue.light_at_depth(endless, NOON, depth_cm=[0, 200])
    np.testing.assert_allclose(light.solar_layer_absorbed.sum(), light.solar_net.sel(depth=0), rtol=1e-9)
    assert light.layer_warming[0] > 0 and np.isnan(light.layer_warming[1]) and light.warming.notnull().all()


def test_the_sum_of_a_day_says_which():
    far_west = {"latitude_deg": 0, "longitude_deg": -180, "time": "2026-02-01", "wavelength_nm": [450]}
    total = snowblue.light_at_depth(PACK, far_west, depth_cm=[0], daily=True)
    assert total.attrs["sum"] == "from 2026-02-01T12:00:00 to 2026-02-02T12:00:00 UTC"


def test_measured_light_is_taken():
    wavelength = ("wavelength", np.arange(400.0, 701.0, 50))
    measured = xr.Dataset(
        {"direct": ("wavelength", np.full(7, 0.5)), "diffuse": ("wavelength", np.full(7, 0.2)), "elevation": 30.0},
        {"wavelength": wavelength},
    )
    light = snowblue.light_at_depth(PACK, measured, depth_cm=[0])
    np.testing.assert_allclose(light.down, 0.7, rtol=1e-12)
    with pytest.raises(ValueError, match="the sky has no 'diffuse'"):
        snowblue.light_at_depth(PACK, measured.drop_vars("diffuse"), depth_cm=[0])
    with pytest.raises(ValueError, match="elevation of the sun is not a number"):
        snowblue.light_at_depth(PACK, measured.assign(elevation=np.nan), depth_cm=[0])
    for name, wrong in (("direct", np.nan), ("diffuse", -0.1)):
        values = measured[name].values.copy()
        values[2] = wrong
        with pytest.raises(ValueError, match=f"{name} light at 500 nm is {wrong}, but must be a number from 0 up"):
            snowblue.light_at_depth(PACK, measured.assign({name: ("wavelength", values)}), depth_cm=[0])
    twilight = measured.assign(elevation=-3.0, direct=0 * measured.direct)
    np.testing.assert_allclose(snowblue.light_at_depth(PACK, twilight, depth_cm=[0]).down, 0.2, rtol=1e-12)
    with pytest.raises(ValueError, match="direct light at 400 nm is 0.5 with the sun at -3 degrees, but must be 0"):
        snowblue.light_at_depth(PACK, measured.assign(elevation=-3.0), depth_cm=[0])
    with pytest.raises(ValueError, match="the wavelengths of the sky must ascend"):
        snowblue.light_at_depth(PACK, measured.isel(wavelength=slice(None, None, -1)), depth_cm=[0])
    for name, units in (("direct", "mW m-2 nm-1"), ("diffuse", "W m-2 um-1"), ("elevation", "radian")):
        stated = measured.copy(deep=True)
        stated[name].attrs["units"] = units
        with pytest.raises(ValueError, match=f"{name} states the units '{units}', but must be in "):
            snowblue.light_at_depth(PACK, stated, depth_cm=[0])


@pytest.mark.parametrize("keywords, message", [
    ({"sky": {"elevation": 30}}, "'elevation' is not known; did you mean elevation_deg"),
    ({"sky": {"elevation_deg": 95}}, "sun elevation is 95°, but must lie in -90–90°"),
    ({"sky": {"elevation_deg": 30, "wavelength_nm": [400, 2600]}}, "wavelength is 2600 nm, but must lie in 320–2500"),
    ({"sky": {"elevation_deg": 30, "overcast": True, "turbidity": 2}}, "turbidity is of a clear sky"),
    ({"sky": {"elevation_deg": 30, "precipitable_water_cm": 20}}, "precipitable water is 20 cm, but must lie in 0–10"),
    ({"depth_cm": [0, 80]}, "depth is 80 cm, but must lie in 0–70 cm"),
    ({"daily": True}, "daily sums need a sky at times"),
    ({"bands": ["uv"]}, "'uv' is not known; there are solar, par"),
    ({"bands": "par", "sky": {"elevation_deg": 30, "wavelength_nm": [450, 500]}}, "par"),
    ({"depths": [0]}, "'depths' is not known; did you mean depth_cm"),
    ({"sky": {**INNSBRUCK, "time": "2026-02-30"}}, "day is 30, but month 2"),
])
def test_what_is_wrong_is_said(keywords, message):
    given = {"sky": {"elevation_deg": 30}, "depth_cm": [0], **keywords}
    with pytest.raises((ValueError, TypeError), match=message):
        snowblue.light_at_depth(PACK, **given)


def test_times_that_fill_no_day_have_no_sum():
    hours = [f"2026-02-01T{hour:02}:00Z" for hour in (9, 10, 11)]
    with pytest.raises(ValueError, match="equal steps that fill a day"):
        snowblue.light_at_depth(PACK, {**INNSBRUCK, "time": hours}, depth_cm=[0], daily=True)
