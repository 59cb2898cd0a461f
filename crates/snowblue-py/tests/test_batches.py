"""Many slabs at once: pairing, shared work, errors, and the ground."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import snowblue

NM = [450.0, 650.0, 1000.0]


@pytest.fixture(scope="module")
def pits():
    """A table of snow pits, one of them wet and one of coarse, dirty snow."""
    return xr.Dataset(
        {
            "ssa": ("pit", [60.0, 25.0, 3.0, 12.0]),
            "density": ("pit", [120.0, 300.0, 480.0, 350.0]),
            "soot": ("pit", [0.0, 5.0, 400.0, 20.0]),
            "water": ("pit", [0.0, 0.0, 0.0, 0.1]),
            "thickness": ("pit", [2.0, 15.0, 40.0, 8.0]),
            "angle": ("pit", [0.0, 60.0, 85.0, -1.0]),
            "ground": ("pit", [0.0, 0.2, 0.0, 0.9]),
        },
        {"pit": ["ridge", "valley", "glacier", "road"]},
    )


def test_every_pit_has_the_bits_that_it_has_alone(pits):
    """Shared rays through grains are the same rays: not even rounding differs."""
    together = snowblue.spectrum(
        ssa_m2_kg=pits.ssa, density_kg_m3=pits.density, impurities_ng_g={"black-carbon": pits.soot},
        water_saturation=pits.water, thickness_cm=pits.thickness, angle_deg=pits.angle, ground_albedo=pits.ground,
        wavelength_nm=NM)
    assert together.transmittance.dims == ("pit", "wavelength")
    assert together.angle.dims == together.thickness.dims == together.ground_albedo.dims == ("pit",)
    assert together.pit.values.tolist() == pits.pit.values.tolist()
    for name in reversed(pits.pit.values):
        pit = {key: value.item() for key, value in pits.sel(pit=name).data_vars.items()}
        alone = snowblue.spectrum(
            ssa_m2_kg=pit["ssa"], density_kg_m3=pit["density"], impurities_ng_g={"black-carbon": pit["soot"]},
            water_saturation=pit["water"], thickness_cm=pit["thickness"],
            angle_deg="diffuse" if pit["angle"] == -1 else pit["angle"], ground_albedo=pit["ground"], wavelength_nm=NM)
        for quantity in ("reflectance", "transmittance", "absorptance"):
            assert (alone[quantity].values.ravel() == together[quantity].sel(pit=name).values).all(), (name, quantity)


def test_slabs_of_one_snow_may_be_paired_and_crossed():
    sites = {"dims": "site", "coords": {"site": [3, 7]}}
    thickness, angle = xr.DataArray([1.0, 9.0], **sites), xr.DataArray([0.0, 70.0], **sites)
    paired = snowblue.spectrum(thickness_cm=thickness, angle_deg=angle, wavelength_nm=NM)
    crossed = snowblue.spectrum(thickness_cm=[1, 9], angle_deg=[0, 70], wavelength_nm=NM)
    assert paired.transmittance.dims == ("site", "wavelength")
    for place in range(2):
        at = dict(thickness=thickness.values[place], angle=angle.values[place])
        for name in ("transmittance", "reflectance_se"):
            assert (paired[name][place].values == crossed[name].sel(at).values).all()
    # A third argument on its own axis crosses the pairs.
    both = snowblue.spectrum(
        thickness_cm=thickness, angle_deg=angle, density_kg_m3=[200, 400], wavelength_nm=NM, standard_errors=False)
    assert both.transmittance.dims == ("density", "site", "wavelength")


def test_arrays_of_several_dimensions_are_broadcast_by_name():
    ssa = xr.DataArray([[10.0, 20.0, 30.0], [15.0, 25.0, 35.0]], dims=("time", "site"))
    density = xr.DataArray([200.0, 300.0, 400.0], dims="site")
    thickness = xr.DataArray([5.0, 50.0], dims="time")
    grid = snowblue.spectrum(ssa_m2_kg=ssa, density_kg_m3=density, thickness_cm=thickness, wavelength_nm=NM)
    assert grid.reflectance.dims == ("time", "site", "angle", "wavelength")
    one = snowblue.spectrum(ssa_m2_kg=25, density_kg_m3=300, thickness_cm=50, wavelength_nm=NM)
    assert (grid.reflectance[1, 1, 0].values == one.reflectance.values.ravel()).all()
    # The order of the dimensions is that in which they first come.
    turned = snowblue.spectrum(density_kg_m3=density, ssa_m2_kg=ssa, thickness_cm=thickness, wavelength_nm=NM)
    assert turned.reflectance.dims == ("site", "time", "angle", "wavelength")
    xr.testing.assert_equal(turned.reflectance.transpose(*grid.reflectance.dims), grid.reflectance)


def test_snow_may_share_the_axis_of_thickness():
    depth = xr.DataArray([1.0, 10.0], dims="thickness", coords={"thickness": [1.0, 10.0]})
    density = xr.DataArray([100.0, 400.0], dims="thickness")
    both = snowblue.spectrum(thickness_cm=depth, density_kg_m3=density, wavelength_nm=550)
    assert both.transmittance.dims == ("thickness", "angle", "wavelength")
    one = snowblue.spectrum(thickness_cm=10, density_kg_m3=400, wavelength_nm=550)
    assert both.transmittance.sel(thickness=10).item() == one.transmittance.item()


def test_wavelengths_may_lie_on_another_axis():
    channels = xr.DataArray([469.0, 555.0, 858.0], dims="channel", coords={"channel": ["blue", "green", "nir"]})
    seen = snowblue.spectrum(wavelength_nm=channels)
    assert seen.reflectance.dims == ("thickness", "angle", "channel")
    assert seen.wavelength.dims == ("channel",) and seen.reflectance.sel(channel="nir").wavelength == 858
    with pytest.raises(ValueError, match="all slabs have the same wavelengths"):
        snowblue.spectrum(wavelength_nm=channels, density_kg_m3=xr.DataArray([100, 200, 300], dims="channel"))


def test_spectra_have_standard_errors_unless_they_are_not_wanted():
    for density in (200, [200, 300]):
        errors = snowblue.spectrum(density_kg_m3=density, wavelength_nm=550)
        assert (errors.transmittance_se > 0).all()
        plain = snowblue.spectrum(density_kg_m3=density, wavelength_nm=550, standard_errors=False)
        assert "transmittance_se" not in plain and (plain.transmittance == errors.transmittance).all()
    # An albedo has no place for them.
    with pytest.raises(TypeError, match="standard_errors"):
        snowblue.albedo(standard_errors=True)


def plain(**keywords):
    return snowblue.spectrum(wavelength_nm=[550, 900], standard_errors=False, **keywords)


def test_arguments_are_the_coordinates_whatever_others_carry():
    pits = xr.Dataset({"ssa": ("density", [20.0, 40.0])}, {"density": [200.0, 300.0]})
    doubled = plain(density_kg_m3=pits.density * 2, ssa_m2_kg=pits.ssa)
    assert doubled.reflectance.dims == ("density", "thickness", "angle", "wavelength")
    assert doubled.density.values.tolist() == [400, 600] and doubled.density.units == "kg m-3"
    one = plain(density_kg_m3=600, ssa_m2_kg=40)
    assert (doubled.transmittance[1].values == one.transmittance.values).all()
    # In the other order too, and where the argument has an axis of its own.
    assert plain(ssa_m2_kg=pits.ssa, density_kg_m3=pits.density * 2).density.values.tolist() == [400, 600]
    sites = xr.DataArray([20.0, 40.0], dims="site", coords={"site": [3, 7], "angle": ("site", [8.0, 9.0])})
    assert plain(ssa_m2_kg=sites, angle_deg=[0, 60]).angle.values.tolist() == [0, 60]


def test_carried_coordinates_are_kept_unless_they_differ_or_have_names_of_results():
    def sites(values, **coords):
        return xr.DataArray(values, dims="site", coords={name: ("site", list(one)) for name, one in coords.items()})

    ssa = sites(
        [20.0, 40.0], site="ab", height=[1, 2], slope=[5, 6], reflectance=[0.5, 0.6], density=[1, 2], place="pq")
    thickness = sites([3.0, 4.0], site="ab", height=[1, 2], slope=[5, 7], owner="xy")
    solved = plain(ssa_m2_kg=ssa, thickness_cm=thickness)
    assert set(solved.coords) == {
        "site", "height", "place", "owner", "specific_surface_area", "thickness", "angle", "wavelength"}
    assert set(solved.data_vars) == {"reflectance", "transmittance", "absorptance"}
    # A value that has the name of an axis is none of its labels.
    named = xr.DataArray([200.0, 300.0], dims="pit").assign_coords(day=8)
    alone = plain(density_kg_m3=named, ssa_m2_kg=xr.DataArray([20.0, 40.0, 60.0], dims="day"))
    assert alone.reflectance.dims[:2] == ("pit", "day") and "day" not in alone.coords
    # The axis of wavelengths replaces no argument.
    channels = xr.DataArray([500.0, 600.0], dims="channel", coords={"thickness": ("channel", [8, 9])})
    seen = snowblue.spectrum(wavelength_nm=channels, thickness_cm=[1, 2, 3], standard_errors=False)
    assert seen.thickness.values.tolist() == [1, 2, 3]


def test_arrays_may_share_an_axis_that_is_an_argument():
    on = {"dims": "thickness", "coords": {"thickness": [1.0, 10.0]}}
    depth, ground = xr.DataArray([1.0, 10.0], **on), xr.DataArray([0.1, 0.5], **on)
    paired = plain(thickness_cm=depth, ground_albedo=ground)
    assert paired.reflectance.dims == ("thickness", "angle", "wavelength")
    assert (paired.transmittance.sel(thickness=10).values
            == plain(thickness_cm=10, ground_albedo=0.5).transmittance[0].values).all()
    ds = xr.Dataset({"ssa": ("density", [20.0, 40.0])}, {"density": [200, 300]})
    both = plain(density_kg_m3=ds.density, ssa_m2_kg=ds.ssa)
    assert both.reflectance.dims[0] == "density"
    assert both.identical(plain(density_kg_m3=[200, 300], ssa_m2_kg=ds.ssa))
    with pytest.raises(ValueError, match="'density' has other labels"):
        plain(density_kg_m3=[200, 400], ssa_m2_kg=ds.ssa)
    with pytest.raises(ValueError, match="'density' has other labels"):
        plain(density_kg_m3=ds.density, ssa_m2_kg=ds.ssa[::-1])


def test_levels_of_an_index_remain():
    grid = xr.DataArray([[10.0, 20.0], [30.0, 40.0]], dims=("year", "site"), coords={"year": [1, 2], "site": [3, 4]})
    stacked = grid.stack(row=("year", "site"))
    solved = plain(ssa_m2_kg=stacked, density_kg_m3=stacked * 10)
    assert solved.reflectance.dims[0] == "row"
    assert solved.unstack("row").sel(year=2, site=3).specific_surface_area == 30
    # A level that is an argument makes way for it.
    renamed = grid.rename(year="density").stack(row=("density", "site"))
    solved = plain(ssa_m2_kg=renamed, density_kg_m3=renamed * 10)
    assert solved.density.values.tolist() == [100, 200, 300, 400] and solved.site.values.tolist() == [3, 4, 3, 4]


def test_angles_in_words_keep_their_numbers():
    for mixed in (np.array([0, "diffuse", "60"]), [0, "diffuse", "60"], np.array([0, "diffuse", 60], dtype=object)):
        solved = plain(angle_deg=mixed)
        assert solved.angle.values.tolist() == [0, -1, 60]
    assert (solved.reflectance.values == plain(angle_deg=[0, -1, 60]).reflectance.values).all()


def test_series_are_paired_by_their_index():
    table = pd.DataFrame({"ssa": [20.0, 40.0, 60.0], "thickness": [1.0, 5.0, 9.0]}, index=["a", "b", "c"])
    solved = plain(ssa_m2_kg=table.ssa, thickness_cm=table.thickness)
    assert solved.reflectance.dims == ("index", "angle", "wavelength")
    assert (solved.reflectance.sel(index="b").values == plain(ssa_m2_kg=40, thickness_cm=5).reflectance[0].values).all()
    with pytest.raises(ValueError, match="other labels"):
        plain(ssa_m2_kg=table.ssa, thickness_cm=table.thickness[::-1])


def test_masked_values_are_missing():
    by_density = plain(density_kg_m3=np.ma.masked_equal([300, 50], 50)).reflectance
    by_thickness = plain(thickness_cm=np.ma.masked_less([1.0, 5.0], 2)).reflectance
    assert by_density.isnull().all(["thickness", "angle", "wavelength"]).values.tolist() == [False, True]
    assert by_thickness.isnull().all(["angle", "wavelength"]).values.tolist() == [True, False]


def test_wavelengths_of_an_albedo_may_be_a_tuple():
    assert snowblue.albedo(wavelength_nm=(500, 1000)).dims == ("wavelength",)
    for value in ([[500, 600]], xr.DataArray([[500.0, 600.0]], dims=("a", "b"))):
        with pytest.raises(ValueError, match="wavelength has 2 dimensions, but must have 1"):
            snowblue.albedo(wavelength_nm=value)


@pytest.mark.parametrize(("keywords", "words"), [
    ({"density_kg_m3": [300, 1200]}, r"density is 1200 kg/m³, but must lie in 10–900 kg/m³, at density\[1\]"),
    ({"grain_size_um": xr.DataArray([400.0, 60.0], dims="site")}, r"mean grain size is 60 µm.*, at site\[1\]"),
    ({"snow": ["firn", "slush"]}, r"'slush' is not known; there are .*, at snow\[1\]"),
    ({"thickness_cm": [1, 2, -3]}, r"thickness is -3 cm.*, at thickness\[2\]"),
    ({"angle_deg": [0, -5], "thickness_cm": [1, 2]}, r"angle is -5°.*, at thickness\[0\], angle\[1\]"),
    ({"ground_albedo": xr.DataArray([0.1, 1.5], dims="site")}, r"ground albedo is 1.5.*, at site\[1\]"),
    ({"ssa_m2_kg": [20, 0.1]}, r"specific surface area is 0.1 m²/kg.*, at specific_surface_area\[1\]"),
    ({"impurities_ng_g": {"black-carbon": [0, -5]}}, r"-5 ng/g.*, at black_carbon\[1\]"),
    ({"thickness_cm": [[1, 2], [3, 4]]}, "thickness has 2 dimensions"),
    ({"thickness_cm": []}, "thickness has no values"),
    ({"thickness_cm": (1, 2)}, "must be a number or an array"),
    ({"thickness_cm": xr.DataArray([1.0, 2.0], dims="site"), "density_kg_m3": xr.DataArray([1.0], dims="site")},
     "'site' has 2 values in thickness, but 1 elsewhere"),
    ({"thickness_cm": xr.DataArray([1.0, 2.0], dims="wavelength")}, "'wavelength', which belongs to the results"),
    ({"thickness_cm": np.inf, "engine": "montecarlo"}, "thickness_cm is inf, a half-space, which needs the engine"),
    ({"density_kg_m3": np.array([200, None])}, r"density_kg_m3 is None.*, at density\[1\]"),
    ({"density_kg_m3": [200, "x"]}, r"density_kg_m3 is 'x'.*, at density\[1\]"),
    ({"thickness_cm": [1, "x"]}, r"thickness is 'x'.*, at thickness\[1\]"),
    ({"angle_deg": [0, "steep"]}, r"'steep' is neither an angle in degrees nor 'diffuse', at angle\[1\]"),
    ({"density_kg_m3": [[200, 300], [400]]}, r"density_kg_m3 is \[200, 300\], but must be a number, at density\[0\]"),
    ({"snow": ["firn", 3]}, r"snow is 3, but must be a word, at snow\[1\]"),
    ({"wavelength_nm": [500, None]}, r"wavelength is None.*, at wavelength\[1\]"),
    ({"wavelength_nm": [500, np.inf]}, r"wavelength is inf nm, but must lie in 300–2500 nm, at wavelength\[1\]"),
    ({"density_kg_m3": [200, -np.inf]}, r"density is -inf kg/m³, .*, at density\[1\]"),
    ({"thickness_cm": xr.DataArray([1.0], dims="reflectance")}, "'reflectance', which belongs to the results"),
])
def test_wrong_elements_are_named_with_their_index(keywords, words):
    with pytest.raises(ValueError, match=words):
        snowblue.spectrum(**keywords)


def test_an_infinite_thickness_is_the_limit_of_great_ones():
    """At 1 km and 1000 nm nothing gets through, so that only rounding differs."""
    deep = snowblue.spectrum(thickness_cm=[1e5, np.inf], angle_deg=[0, 60, "diffuse"], wavelength_nm=[700, 1000])
    np.testing.assert_allclose(
        deep.reflectance.sel(thickness=np.inf), deep.reflectance.sel(thickness=1e5), rtol=1e-12)
    assert (deep.transmittance.sel(thickness=np.inf) == 0).all()
    ground = snowblue.spectrum(thickness_cm=np.inf, angle_deg=[0, 60, "diffuse"], wavelength_nm=[700, 1000],
                               ground_albedo=0.8)
    # Other sums give the same light.
    np.testing.assert_allclose(ground.reflectance[0], deep.reflectance.sel(thickness=np.inf), rtol=1e-9)


def test_a_ground_is_that_of_layers_and_of_the_adding_method():
    common = dict(angle_deg=[0, 60], wavelength_nm=NM)
    ours = snowblue.spectrum(snow="fresh", thickness_cm=2, ground_albedo=0.6, **common).squeeze("thickness")
    layers = snowblue.layers([dict(snow="fresh", thickness_cm=2)], ground_albedo=0.6, **common)
    for name in ("reflectance", "transmittance", "absorptance"):
        assert (ours[name].values == layers[name].values).all(), name
    # Errors are sums in another order.
    np.testing.assert_allclose(ours.reflectance_se, layers.reflectance_se, rtol=1e-6)
    assert ours.transmittance.long_name == layers.transmittance.long_name and ours.ground_albedo == 0.6
    # Light is reflected between the ground and the lower face, which under diffuse light acts as the upper one.
    bare = snowblue.spectrum(snow="fresh", thickness_cm=2, **common).squeeze("thickness")
    sky = snowblue.spectrum(snow="fresh", thickness_cm=2, angle_deg="diffuse", wavelength_nm=NM).squeeze()
    down = bare.transmittance / (1 - 0.6 * sky.reflectance)
    np.testing.assert_allclose(ours.transmittance, down, rtol=1e-9)
    np.testing.assert_allclose(ours.reflectance, bare.reflectance + 0.6 * down * sky.transmittance, rtol=1e-9)


def test_random_walks_take_batches_too():
    sites = dict(dims="site")
    common = dict(wavelength_nm=NM, engine="montecarlo", rays=500)
    walked = snowblue.spectrum(
        density_kg_m3=xr.DataArray([200.0, 400.0], **sites), thickness_cm=xr.DataArray([1.0, 3.0], **sites),
        ground_albedo=xr.DataArray([0.0, 0.5], **sites), **common)
    alone = snowblue.spectrum(density_kg_m3=200, thickness_cm=1, **common)
    assert (walked.transmittance[0].values == alone.transmittance[0].values).all()
    layer = snowblue.layers([dict(density_kg_m3=400, thickness_cm=3)], ground_albedo=0.5, **common)
    assert (walked.reflectance[1].values == layer.reflectance.values).all()


def test_the_albedo_of_deep_snow_is_one_line():
    albedo = snowblue.albedo(ssa_m2_kg=20, angle_deg=60, wavelength_nm=[500, 1000])
    assert albedo.dims == ("wavelength",) and albedo.name == "albedo" and albedo.angle == 60
    deep = snowblue.spectrum(ssa_m2_kg=20, angle_deg=60, thickness_cm=np.inf, wavelength_nm=[500, 1000])
    assert (albedo.values == deep.reflectance.values.ravel()).all()
    assert snowblue.albedo(ssa_m2_kg=[10, 20], wavelength_nm=500).dims == ("specific_surface_area",)


def test_layers_may_be_a_data_frame():
    rows = [dict(thickness_cm=3.0, snow="fresh"), dict(thickness_cm=20.0, density_kg_m3=400.0)]
    framed = snowblue.layers(pd.DataFrame(rows), wavelength_nm=NM, standard_errors=False)
    assert (framed.reflectance == snowblue.layers(rows, wavelength_nm=NM, standard_errors=False).reflectance).all()


def test_a_dataset_has_a_colour():
    solved = snowblue.spectrum(thickness_cm=[5, 20], standard_errors=False)
    assert (snowblue.color(solved).hex == snowblue.color(solved.transmittance).hex).all()
    assert (snowblue.color(solved, reflected=True).hex == snowblue.color(solved.reflectance).hex).all()
