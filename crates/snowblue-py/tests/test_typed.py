"""What people type: names that are nearly right, half-spaces, intervals, snow that ages, and pickles."""

import pickle

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import snowblue
from snowblue import _native
from snowblue._arguments import Snow


@pytest.mark.parametrize("call, message", [
    (lambda: snowblue.spectrum(ssa=20), "'ssa' is not known; did you mean ssa_m2_kg[?] There are thickness_cm,.* ice$"),
    (lambda: snowblue.spectrum(thicknes_cm=20), "did you mean thickness_cm"),
    (lambda: snowblue.spectrum(grain_size=400), "'grain_size' is not known; did you mean grain_size_um[?] .*ssa_m2_kg"),
    (lambda: snowblue.layers([{"snow": "firn"}]), "thickness_cm"),
    (lambda: snowblue.albedo(densitiy=20), "did you mean density_kg_m3"),
    (lambda: snowblue.albedo(jacobian="ssa_m2_kg"), "'jacobian' is not known"),
    (lambda: snowblue.color(grain_size=20), "did you mean grain_size_um[?] There are spectrum, illuminant"),
    (lambda: snowblue.layers([{"thickness_cm": 1}], depth=3), "did you mean depth_cm[?] There are layers"),
    (lambda: snowblue.layers([{"thickness": 1}]), "did you mean thickness_cm"),
    (lambda: snowblue.sky(elevation=3), "did you mean elevation_deg"),
    (lambda: snowblue.sun_position(lat=3), "did you mean latitude_deg"),
    (lambda: snowblue.match("#fff", angle=3), "did you mean angle_deg[?] There are target"),
    (lambda: snowblue.invert([0.9], [500], sigma=1), "'sigma' is not known; .*standard_deviation"),
    (lambda: snowblue.Scene(cam={}), "did you mean camera"),
    (lambda: snowblue.Database.build(density=3), "did you mean density_kg_m3"),
    (lambda: snowblue.spectrum(soot=3), r"did you mean impurities_ng_g=\{'black-carbon': ...\}"),
    (lambda: snowblue.spectrum(saharan_dust_ng_g=3), r"did you mean impurities_ng_g=\{'saharan-dust'"),
    (lambda: snowblue.spectrum(plus_minus={"ssa": 3}), "did you mean ssa_m2_kg"),
    (lambda: snowblue.spectrum("fresh"), "^'fresh' is given without the name .*did you mean snow='fresh'[?] There are"),
    (lambda: snowblue.albedo("fresh"), "did you mean snow='fresh'"),
    (lambda: snowblue.bsdf(15), "^15 is given without the name .*; did you mean thickness_cm=15[?]"),
    (lambda: snowblue.sky(25), "did you mean elevation_deg=25[?] There are elevation_deg, latitude_deg"),
    (lambda: snowblue.match("#fff", "fresh"), "did you mean snow='fresh'"),
    (lambda: snowblue.layers([{"thickness_cm": 3}, {"snow": "fresh"}]), r"^layers\[1\] has no thickness_cm$"),
    (lambda: snowblue.light_at_depth([{"thickness_cm": 1}], {}, depth_cm=0, progress=False), "'progress' is not known"),
])
def test_unknown_names_are_answered_with_the_nearest_and_all(call, message):
    with pytest.raises(TypeError, match=message):
        call()


PACK = "must be mappings in a list, or a pandas.DataFrame, top first"


@pytest.mark.parametrize("call, message", [
    (lambda: snowblue.spectrum(impurities_ng_g=[1, 2]),
     r"^impurities_ng_g is \[1, 2\], but must be a mapping such as \{'black-carbon': 10\}$"),
    (lambda: snowblue.spectrum(impurities_ng_g=np.ones(2)), r"^impurities_ng_g is array\(\[1., 1.\]\), but must be"),
    (lambda: snowblue.spectrum(impurities_ng_g={"soot": 1}),
     "^impurity 'soot' is not known; did you mean black-carbon[?] There are black-carbon, black-carbon-coated, "),
    (lambda: snowblue.spectrum(impurities_ng_g={"snow-algea": [1, 2]}), "did you mean snow-algae"),
    (lambda: snowblue.spectrum(impurities_ng_g={5: 1}), "^impurity 5 is not known; there are black-carbon"),
    (lambda: snowblue.spectrum(impurities_ng_g={"snow-algae": 1, "snow_algae": 1}), "has snow-algae twice"),
    (lambda: snowblue.spectrum(plus_minus=2), r"^plus_minus is 2, but must be a mapping such as \{'ssa_m2_kg': 2"),
    (lambda: snowblue.layers({"thickness_cm": 1}), rf"^layers is one mapping, \{{'thickness_cm': 1\}}, but {PACK}"),
    (lambda: snowblue.layers("fresh"), f"^layers is 'fresh', but {PACK}"),
    (lambda: snowblue.layers(10), f"^layers is 10, but {PACK}"),
    (lambda: snowblue.layers([10]), r"^layers\[0\] is 10, but must be a mapping such as \{'thickness_cm': 10"),
    (lambda: snowblue.light_at_depth([{"thickness_cm": 1}], 30, depth_cm=0), "^sky is 30, but must be a mapping"),
    (lambda: snowblue.light_at_depth([{"thickness_cm": 1}], {"elevation_deg": 30}, depth_cm=0, bands=5),
     "^bands is 5, but must be names of bands, such as 'par'$"),
    (lambda: snowblue.albedo(engine="montecarlo"), "^thickness_cm is inf, a half-space, which needs the engine 'ord"),
    (lambda: snowblue.albedo(engine="monte-carlo"), "^engine 'monte-carlo' is not known; did you mean montecarlo"),
    (lambda: snowblue.Database.build(engine="mote-carlo"), "^engine 'mote-carlo' is not known; did you mean monteca"),
    (lambda: snowblue.spectrum(standard_errors="no"), "^standard_errors is 'no', but must be True or False$"),
    (lambda: snowblue.albedo(per_wavelength=1), "^per_wavelength is 1, but must be True or False$"),
    (lambda: snowblue.aged_ssa(ssa_m2_kg=60, age_h=1, temperature_gradient="no"), "^temperature_gradient is 'no', but"),
    (lambda: snowblue.spectrum(progress=5), "^progress is 5, but must be True, False or a function$"),
    (lambda: snowblue.spectrum(jacobian="ssa"), "^parameter 'ssa' is not known; did you mean ssa_m2_kg[?] There are"),
    (lambda: snowblue.invert([0.9], [500], retrieve="density"), "^parameter 'density' .*did you mean density_kg_m3"),
    (lambda: snowblue.albedo(ssa_m2_kg=(20, 30)), r"^ssa_m2_kg is \(20, 30\), but must be a number; a list makes an"),
    (lambda: snowblue.albedo(ssa_m2_kg=True), "^ssa_m2_kg is True, but must be a number$"),
    (lambda: snowblue.albedo(density_kg_m3=np.array([200, 300], "timedelta64[ns]")),
     r"^density_kg_m3 is np.timedelta64\(200,'ns'\), but must be a number, at density\[0\]$"),
    (lambda: snowblue.albedo(thickness_cm=np.datetime64(20, "ns")), "^thickness is np.datetime64.*, but must be a num"),
    (lambda: snowblue.albedo(ssa_m2_kg=xr.Dataset()), "^specific_surface_area is a Dataset, but must be an array"),
    (lambda: snowblue.invert(snowblue.spectrum(wavelength_nm=500)), "^albedo is a Dataset, but must be an array"),
    (lambda: snowblue.layers([{"thickness_cm": 1}], ground_albedo=[0.1]), r"^ground_albedo is \[0.1\], but must"),
    (lambda: snowblue.bsdf(thickness_cm=[1, 2]), r"^thickness_cm is \[1, 2\], but must be a number$"),
    (lambda: snowblue.color(np.ones(31)), "^the spectrum is array.*, but must be a Dataset or an xarray.DataArray$"),
    (lambda: snowblue.color(snowblue.spectrum()[["reflectance"]]), "^the spectra have no transmittance$"),
    (lambda: snowblue.Database.embedded().look_up(thickness_cm=1, temp=3), "^property 'temp' .*did you mean temp"),
    (lambda: snowblue.single_scattering(degree="many"), "^degree is 'many', but must be a number"),
])
def test_values_of_another_kind_are_named_with_what_is_expected(call, message):
    with pytest.raises(ValueError, match=message) as error:
        call()
    assert "\n" not in str(error.value)


def stating(units, *values):
    return xr.DataArray(list(values), dims="pit", attrs={"units": units})


@pytest.mark.parametrize("call, message", [
    (lambda: snowblue.spectrum(thickness_cm=stating("m", 0.2, 0.3)),
     "^thickness states the units 'm', but must be in cm: convert it, and its attribute$"),
    (lambda: snowblue.spectrum(density_kg_m3=stating("g cm-3", 0.2, 0.3)), "density states the units 'g cm-3'"),
    (lambda: snowblue.spectrum(wavelength_nm=stating("um", 500, 600)), "wavelength states the units 'um', but .* nm"),
    (lambda: snowblue.spectrum(temperature_c=stating("K", -5, -4)), "but must be in degrees Celsius"),
    (lambda: snowblue.spectrum(facetness=stating("%", 0.1, 0.2)), "'%', but must be in fractions"),
    (lambda: snowblue.spectrum(angle_deg=stating("radian", 1, 1)), "'radian', but must be in degrees"),
    (lambda: snowblue.spectrum(impurities_ng_g={"black-carbon": stating("mg/g", 1, 1)}), "black_carbon states the "),
    (lambda: snowblue.aged_ssa(ssa_m2_kg=60, age_h=stating("days", 1, 2)), "age states the units 'days'"),
    (lambda: snowblue.layers([{"thickness_cm": 5}], depth_cm=stating("m", 0.1)[0]), "depth states the units 'm'"),
    (lambda: snowblue.invert(stating("%", 0.9, 0.8), [500, 600]), "albedo states the units '%', but must be in fracti"),
    (lambda: snowblue.Database.embedded().look_up(thickness_cm=stating("mm", 9)), "thickness states the units 'mm'"),
])
def test_arrays_that_state_other_units_are_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_units_may_be_spelt_in_several_ways():
    plain = snowblue.spectrum(ssa_m2_kg=20, density_kg_m3=300, thickness_cm=5, temperature_c=-5, wavelength_nm=500)
    for words in (("m2 kg-1", "kg m-3", "cm", "degC"), ("m²/kg", "kg/m^3", "centimeter", "°C"),
                  ("m^2 kg^-1", "kg m**-3", "cm", "degrees_celsius"), ("m² kg⁻¹", "kg·m⁻³", "cm", "celsius")):
        ssa, density, thickness, temperature = (
            stating(units, value) for units, value in zip(words, (20.0, 300.0, 5.0, -5.0)))
        same = snowblue.spectrum(ssa_m2_kg=ssa, density_kg_m3=density, thickness_cm=thickness,
                                 temperature_c=temperature, wavelength_nm=500)
        assert same.reflectance.item() == plain.reflectance.item()
    # What a result has for coordinates may be an argument.
    again = snowblue.spectrum(angle_deg=snowblue.spectrum(angle_deg=[0, -1]).angle, wavelength_nm=plain.wavelength)
    assert again.angle.values.tolist() == [0, -1]


def test_tables_of_layers_have_columns_of_impurities():
    table = pd.DataFrame({"thickness_cm": [3, 20], "black_carbon_ng_g": [np.nan, 50.0], "snow": [pd.NA, "firn"]})
    pack = [{"thickness_cm": 3}, {"thickness_cm": 20, "snow": "firn", "impurities_ng_g": {"black-carbon": 50}}]
    keywords = {"wavelength_nm": 500, "standard_errors": False}
    xr.testing.assert_identical(snowblue.layers(table, **keywords), snowblue.layers(pack, **keywords))


def test_names_of_impurities_have_hyphens_or_underscores():
    given = [{"impurities_ng_g": {name: [5, 50]}, "plus_minus": {name: 2}, "jacobian": name, "wavelength_nm": 500}
             for name in ("black-carbon", "black_carbon")]
    one, other = (snowblue.spectrum(**keywords).drop_attrs() for keywords in given)
    assert one.identical(other) and "reflectance_per_black_carbon" in other
    pack = [{"thickness_cm": 5, "impurities_ng_g": {"black_carbon": 5}}]
    light = snowblue.light_at_depth(pack, {"elevation_deg": 30}, depth_cm=[1], jacobian="black_carbon")
    assert "W m-2 nm-1 ng-1 g" == light.down_per_black_carbon.units and light.wavelength.max() == 2500


def test_functions_keep_their_names_and_help():
    assert snowblue.spectrum.__name__ == "spectrum" and "half-space" in snowblue.spectrum.__doc__


def test_clear_ice_is_a_layer():
    snow = {"thickness_cm": 3, "ssa_m2_kg": 30, "density_kg_m3": 200}
    pack = [snow, {"kind": "ice", "thickness_cm": 1}, {**snow, "thickness_cm": 20}]
    keywords = dict(depth_cm=[0, 3, 3.5, 4], angle_deg=[0, 70, "diffuse"], wavelength_nm=[450, 1030],
                    standard_errors=False)
    solved = snowblue.layers(pack, jacobian=["thickness_cm", "ssa_m2_kg"], **keywords)
    np.testing.assert_allclose(solved.net.isel(depth=0), 1 - solved.reflectance, rtol=1e-9)
    assert (solved.net.diff("depth") < 0).all() and "kind=ice" in solved.attrs["layers"]
    assert (solved.reflectance_per_ssa_m2_kg.isel(changed_layer=1) == 0).all()
    thicker = snowblue.layers([snow, {"kind": "ice", "thickness_cm": 1.0001}, pack[2]], **keywords)
    slope = (thicker.reflectance - solved.reflectance) / 0.0001
    # To first order in the step, and rounding over it.
    np.testing.assert_allclose(solved.reflectance_per_thickness_cm.isel(changed_layer=1), slope, rtol=1e-3, atol=1e-9)
    table = pd.DataFrame({"thickness_cm": [3, 1, 20], "kind": [np.nan, "ice", np.nan], "ssa_m2_kg": [30, np.nan, 30],
                          "density_kg_m3": [200, np.nan, 200]})
    assert snowblue.layers(table, **keywords).reflectance.equals(solved.reflectance)
    # None is an argument that is not given.
    unsaid = [{**snow, "kind": None}, {**pack[1], "snow": None, "ssa_m2_kg": None, "ice": None}, pack[2]]
    assert snowblue.layers(unsaid, **keywords).reflectance.equals(solved.reflectance)
    walked = snowblue.layers(pack, angle_deg=70, wavelength_nm=1030, engine="montecarlo", rays=20_000)
    exact = solved.sel(angle=70, wavelength=1030)
    assert abs(walked.reflectance - exact.reflectance).item() < 4 * walked.reflectance_se.item()
    sky = {"elevation_deg": 30, "wavelength_nm": np.arange(320, 2501, 20)}
    light = snowblue.light_at_depth(pack, sky, depth_cm=[1, 3.5])
    assert (light.solar_layer_absorbed > 0).all() and (light.layer_warming > 0).all()
    alone = snowblue.layers([{"kind": "ice", "thickness_cm": 1, "ice": "picard2016"}], wavelength_nm=450)
    # Two faces in air reflect 2 F/(1 + F).
    np.testing.assert_allclose(alone.reflectance.item(), 2 * 0.01861 / 1.01861, rtol=0.01)


def test_ice_is_refused_with_a_reason():
    for layer, message in [
        ({"kind": "ice", "thickness_cm": 1, "ssa_m2_kg": 20},
         "ssa_m2_kg is a property of snow: a layer of clear ice has only thickness_cm"),
        ({"kind": "water", "thickness_cm": 1}, "kind of layer 'water' is not known; it must be ice, or"),
        ({"kind": 3, "thickness_cm": 1}, "kind is 3, but must be a word"),
        ({"kind": "ice", "thickness_cm": 1, "ice": 3}, "ice is 3, but must be a word"),
        ({"kind": "ice", "thickness_cm": 0}, "thickness of ice is 0 cm, but must lie in 0.01–100000 cm"),
    ]:
        with pytest.raises(ValueError, match=message):
            snowblue.layers([layer])
    with pytest.raises(ValueError, match=r"kind is 3, but must be a word, at layers\[1\]"):
        snowblue.layers([{"thickness_cm": 3}, {"kind": 3, "thickness_cm": 1}])
    with pytest.raises(ValueError, match="density is 917 kg/m³, but must lie in 10–900 kg/m³: .* kind = \"ice\""):
        snowblue.layers([{"thickness_cm": 3}, {"thickness_cm": 1, "density_kg_m3": 917}])
    with pytest.raises(ValueError, match="density is 1200 kg/m³, but must lie in 10–900 kg/m³$"):
        snowblue.spectrum(density_kg_m3=1200)


@pytest.mark.parametrize("change, keywords, message", [
    ({"density_kg_m3": np.inf}, {}, r"density is inf kg/m³, but must lie in 10–900 kg/m³, at layers\[1\]$"),
    ({"thickness_cm": np.inf}, {}, r"thickness is inf cm, .*, at layers\[1\]$"),
    ({"facetness": np.nan}, {}, r"facetness is NaN, .*, at layers\[1\]$"),
    ({}, {"depth_cm": [1, -np.inf]}, r"depth is -inf cm, but must lie in 0–9 cm, at depth\[1\]$"),
    ({}, {"angle_deg": [0, 30, -5]}, r"angle is -5°, but must lie in 0–89.99°, at angle\[2\]$"),
    ({}, {"wavelength_nm": [500, 200]}, r"wavelength is 200 nm, but must lie in 300–2500 nm, at wavelength\[1\]$"),
    ({}, {"ground_albedo": 2}, "ground albedo is 2, but must lie in 0–1$"),
])
def test_what_is_wrong_in_layers_is_named_with_its_place(change, keywords, message):
    pack = [{"thickness_cm": 2}, {"thickness_cm": 3} | change, {"thickness_cm": 4}]
    with pytest.raises(ValueError, match=message):
        snowblue.layers(pack, **keywords)
    if change:
        with pytest.raises(ValueError, match=message):
            snowblue.light_at_depth(pack, {"elevation_deg": 30}, depth_cm=[1])
        with pytest.raises(ValueError, match=message):
            snowblue.invert([0.9, 0.8], [500, 600], layers=pack)


def test_the_last_layer_may_be_endless():
    rows = pd.DataFrame({"thickness_cm": [np.inf], "ssa_m2_kg": [20.0], "snow": [np.nan]})
    endless = snowblue.layers(rows, angle_deg=60, wavelength_nm=[450, 1030], depth_cm=[0, 1000], standard_errors=False)
    albedo = snowblue.albedo(ssa_m2_kg=20, angle_deg=60, wavelength_nm=[450, 1030])
    np.testing.assert_allclose(endless.reflectance.squeeze(), albedo, rtol=1e-9)
    assert (endless.transmittance == 0).all() and endless.fluence.isel(depth=1).max() < 1e-3
    with pytest.raises(ValueError, match="thickness is inf cm"):
        snowblue.layers([{"thickness_cm": np.inf}, {"thickness_cm": 1}])
    with pytest.raises(ValueError, match="thickness is inf cm"):
        snowblue.layers([{"thickness_cm": np.inf}], engine="montecarlo")


def test_half_spaces_are_those_of_the_command(command):
    rows = command("spectrum", "--ssa", 20, "--thickness", "inf", "--angle", 60, "--wavelengths", "450,1030")
    albedo = snowblue.albedo(ssa_m2_kg=20, angle_deg=60, wavelength_nm=[450, 1030])
    np.testing.assert_allclose([float(row["reflectance"]) for row in rows], albedo, rtol=1e-8)
    assert [row["thickness_cm"] for row in rows] == ["inf", "inf"]


def test_intervals_hold_the_value_and_are_those_of_the_command(command):
    deviations = {"ssa_m2_kg": 2, "density_kg_m3": 30, "black-carbon": 5}
    snow = {"ssa_m2_kg": 20, "impurities_ng_g": {"black-carbon": 20}, "wavelength_nm": [450, 700], "thickness_cm": 10}
    found = snowblue.spectrum(**snow, plus_minus=deviations, standard_errors=False)
    for name in ("reflectance", "transmittance", "absorptance"):
        assert (found[f"{name}_lower"] < found[name]).all() and (found[name] < found[f"{name}_upper"]).all()
    assert found.reflectance_lower.dims == found.reflectance.dims and "95 %" in found.reflectance_lower.long_name
    # To first order the half-width of an interval of 95 % is 1.96 standard deviations.
    by = snowblue.spectrum(**snow, jacobian=list(deviations))
    slopes = [by[f"reflectance_per_{name.replace('-', '_')}"] for name in deviations]
    first = 1.96 * np.sqrt(sum((slope * one) ** 2 for slope, one in zip(slopes, deviations.values())))
    half = 0.5 * (found.reflectance_upper - found.reflectance_lower)
    # The drawn ends have errors of some per cent of the width, and the distributions are skew.
    np.testing.assert_allclose(half, first, rtol=0.12)
    rows = command("spectrum", "--ssa", 20, "--impurity", "black-carbon=20", "--wavelengths", "450,700", "--thickness",
                   10, "--plus-minus", "ssa=2,density=30,black-carbon=5")
    np.testing.assert_allclose([float(row["reflectance_upper"]) for row in rows],
                               found.reflectance_upper.values.ravel(), rtol=1e-8)


def test_both_tables_of_ice_are_in_the_interval():
    blue = {"ssa_m2_kg": 20, "wavelength_nm": 450, "thickness_cm": 50, "standard_errors": False}
    values = sorted(snowblue.spectrum(**blue, ice=ice).transmittance.item() for ice in ("warren2008", "picard2016"))
    found = snowblue.spectrum(**blue, plus_minus={"ice": True})
    ends = [found.transmittance_lower.item(), found.transmittance_upper.item()]
    np.testing.assert_allclose(ends, values, rtol=1e-12)


@pytest.mark.parametrize("deviations, message", [
    ({"ssa_m2_kg": 200}, r"deviation of specific surface area is 200 m²/kg, .*, at specific_surface_area\[0\]"),
    ({"grain_size_um": 10, "ssa_m2_kg": 1}, "two names of one size"),
    ({"black-carbon": 5}, "black-carbon needs a value above 0 to have a standard deviation"),
    ({"density_kg_m3": -1}, "standard deviation of density is -1 kg/m³"),
    ({"density_kg_m3": "a"}, "density_kg_m3 is 'a', but must be a number"),
    ({"ice": "no"}, "ice is 'no', but must be True or False"),
])
def test_deviations_that_cannot_be_are_refused(deviations, message):
    with pytest.raises(ValueError, match=message):
        snowblue.spectrum(ssa_m2_kg=[20, 40], wavelength_nm=450, plus_minus=deviations)


def test_snow_ages():
    aged = snowblue.aged_ssa(ssa_m2_kg=[60, 30], age_h=[0, 24, 240], temperature_c=-10)
    assert aged.dims == ("new_snow", "age") and (aged.diff("age") < 0).all()
    np.testing.assert_array_equal(aged.isel(age=0), [60, 30])
    faster = snowblue.aged_ssa(ssa_m2_kg=60, age_h=240, temperature_c=-10, temperature_gradient=True)
    assert faster < aged.sel(new_snow=60, age=240)
    albedo = snowblue.albedo(ssa_m2_kg=aged, wavelength_nm=1030)
    assert albedo.dims == ("new_snow", "age") and (albedo.diff("age") < 0).all()
    with pytest.raises(ValueError, match=r"age is -1 h, but must lie in 0–8784 h, at age\[1\]"):
        snowblue.aged_ssa(ssa_m2_kg=60, age_h=[0, -1])


def test_snow_that_ages_keeps_its_labels():
    new = xr.DataArray([60.0, 30.0], dims="site", coords={"site": ["ridge", "valley"], "height": ("site", [2000, 900])})
    aged = snowblue.aged_ssa(ssa_m2_kg=new, age_h=24)
    assert aged.site.values.tolist() == ["ridge", "valley"] and {"height", "new_snow"} < {*aged.coords}


def test_scenes_and_tables_travel_as_pickles(tmp_path):
    vertices = 0.2 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    scene = snowblue.Scene(
        camera={"position": [1, -1, 0.6], "look_at": [0, 0, 0.05], "vertical_fov_deg": 30},
        film={"width": 16, "height": 12, "exposure": -1.0},
        material={"snow": {"type": "snow", "grain_size_um": 400, "density_kg_m3": 300}},
        light=[{"type": "point", "position": [-0.5, -1, 0.5], "illuminant": "D65", "radiant_intensity_w_sr": 10}],
        object=[{"mesh": (vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]), "material": "snow"}],
    )
    again = pickle.loads(pickle.dumps(scene))
    pictures = [one.render(samples_per_pixel=1, integrator="diffusion").rgb for one in (scene, again)]
    np.testing.assert_array_equal(*pictures)
    table = snowblue.Database.embedded()
    again = pickle.loads(pickle.dumps(table))
    looked_up = [one.look_up(thickness_cm=10).transmittance for one in (table, again)]
    np.testing.assert_array_equal(*looked_up)
    assert again.metadata == table.metadata


def test_a_bake_has_a_short_name():
    bake = snowblue.Bake([], [], "")
    assert repr(bake) == "<snowblue.Bake: objects: 0, vertices: 0, lamps: 0>"


def test_the_types_and_words_of_snow_are_those_of_the_table():
    known = [*(key for key, *_ in _native.properties()), "snow", "size_measure", "impurities_ng_g", "ice"]
    assert sorted(Snow.__annotations__) == sorted(known)
    for name in known:
        assert name in Snow.__doc__, name
