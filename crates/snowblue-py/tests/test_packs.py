"""Packs of layers of a dataset, and grounds with spectra."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import snowblue

NM = [450.0, 700.0, 1030.0]
SOIL = xr.DataArray([0.1, 0.3, 0.5], {"wavelength": [400.0, 600.0, 1200.0]}, ["wavelength"])
ALBEDOS = [0.15, 0.1 / 3 + 0.3, 0.2 * 43 / 60 + 0.3]
COLUMNS = {
    "thickness_cm": [[5.0, 20.0, np.nan], [3.0, 7.0, 30.0], [np.nan] * 3, [4.0, np.nan, 2.0], [9.0, 1.0, np.nan]],
    "ssa_m2_kg": [[30.0, 10.0, np.nan], [60.0, 25.0, 8.0], [np.nan] * 3, [20.0, 20.0, 20.0], [np.nan, 9.0, np.nan]],
    "density_kg_m3": [[200.0, 300.0, np.nan], [90.0, 250.0, 400.0], [np.nan] * 3, [300.0] * 3, [300.0] * 3],
    "black_carbon_ng_g": [[0.0, 50.0, np.nan], [5.0, 0.0, 9.0], [np.nan] * 3, [0.0] * 3, [0.0] * 3],
}


def season() -> xr.Dataset:
    """Two whole packs, a day without snow, a pack with a hole, and a pack without a surface area."""
    variables = {name: (("time", "layer"), np.array(values)) for name, values in COLUMNS.items()}
    return xr.Dataset(variables, {"time": pd.date_range("2026-01-01", periods=5)})


def alone(packs: xr.Dataset, time: int) -> list[dict[str, float]]:
    """A pack as layers in a list."""
    frame = packs.isel(time=time).drop_vars("time").to_dataframe().dropna(subset=["thickness_cm"])
    masses = frame.pop("black_carbon_ng_g")
    return [{**row, "impurities_ng_g": {"black-carbon": ng_g}} for row, ng_g in zip(frame.to_dict("records"), masses)]


def test_each_pack_has_the_fluxes_that_it_has_alone():
    packs = season()
    options = dict(wavelength_nm=NM, jacobian=["ssa_m2_kg", "ground_albedo"], ground_albedo=0.2)
    solved = snowblue.layers(packs, depth_cm=[12.0, 0.0, 2.0], angle_deg=60, **options)
    assert solved.reflectance.dims == ("time", "angle", "wavelength")
    assert solved.down.dims == ("time", "angle", "wavelength", "depth")
    assert solved.down_per_ssa_m2_kg.dims == ("time", "angle", "wavelength", "depth", "changed_layer")
    for time in (0, 1):
        own = snowblue.layers(alone(packs, time), depth_cm=[12.0, 0.0, 2.0], angle_deg=60, **options)
        here = solved.isel(time=time, drop=True)
        count = own.sizes["changed_layer"]
        for name, one in own.data_vars.items():
            found = here[name].isel(changed_layer=slice(count)) if "changed_layer" in one.dims else here[name]
            xr.testing.assert_equal(found.variable, one.variable)
    assert np.isnan(solved.reflectance_per_ssa_m2_kg.isel(time=0, changed_layer=2)).all()
    for name, one in solved.data_vars.items():
        assert np.isnan(one.isel(time=[2, 3, 4])).all(), name
        assert "units" in one.attrs and "long_name" in one.attrs
    assert solved.attrs["ground_albedo"] == 0.2


def test_a_depth_below_the_ground_has_no_fluxes():
    packs = season().isel(time=[0, 1])
    down = snowblue.layers(packs, depth_cm=[30.0, 1.0, 25.0], wavelength_nm=450, standard_errors=False).down
    assert np.isnan(down.values.ravel()).tolist() == [True, False, False, False, False, False]


def test_angles_and_grounds_pair_with_packs():
    packs = season().isel(time=[0, 1])
    ground = xr.concat([SOIL, 0.5 * SOIL], packs.time)
    angles = xr.DataArray([30.0, 95.0], {"time": packs.time}, ["time"])
    options = dict(wavelength_nm=NM, standard_errors=False)
    solved = snowblue.layers(packs, angle_deg=angles, ground_albedo=ground, **options)
    assert solved.reflectance.dims == ("time", "wavelength")
    own = snowblue.layers(alone(packs, 0), angle_deg=30, ground_albedo=SOIL, **options)
    np.testing.assert_array_equal(solved.transmittance[0], own.transmittance[0])
    assert np.isnan(solved.reflectance[1]).all()
    # Angles on an axis of their own.
    several = snowblue.layers(packs, angle_deg=[0, 30], ground_albedo=ground, **options)
    assert several.reflectance.dims == ("time", "angle", "wavelength")
    np.testing.assert_array_equal(several.reflectance[0, 1], own.reflectance[0])


def test_coordinates_on_layers_are_properties_or_left_out():
    packs = season().isel(time=[0, 1]).assign_coords(site=("time", ["a", "b"]))
    packs = packs.assign_coords(z=packs.thickness_cm.cumsum("layer")).set_coords("density_kg_m3")
    options = dict(wavelength_nm=NM, standard_errors=False)
    solved = snowblue.layers(packs, **options)
    assert set(solved.coords) == {"time", "site", "angle", "wavelength"}
    plain = snowblue.layers(season().isel(time=[0, 1]), **options)
    xr.testing.assert_equal(solved.reflectance.drop_vars("site"), plain.reflectance)


def test_ice_may_lie_among_the_layers():
    snow = [{"thickness_cm": 4, "ssa_m2_kg": 30}, {"thickness_cm": 9, "ssa_m2_kg": 10}]
    layers = [snow[0], {"kind": "ice", "thickness_cm": 1}, snow[1]]
    packs = xr.Dataset(
        {
            "kind": ("layer", ["", "ice", ""]),
            "thickness_cm": ("layer", [4.0, 1.0, 9.0]),
            "ssa_m2_kg": ("layer", [30.0, np.nan, 10.0]),
        }
    )
    found = snowblue.layers(packs, wavelength_nm=NM).reflectance
    xr.testing.assert_equal(found, snowblue.layers(layers, wavelength_nm=NM).reflectance)
    with pytest.raises(ValueError, match="ssa_m2_kg is a property of snow"):
        snowblue.layers(packs.fillna(20.0), wavelength_nm=NM)


def test_blocks_of_dask_have_the_same_fluxes():
    pytest.importorskip("dask")
    packs = season()
    options = dict(wavelength_nm=NM, standard_errors=False, depth_cm=[1.0])
    lazy = snowblue.layers(packs.chunk(time=2, layer=1), **options)
    assert lazy.reflectance.chunks is not None
    xr.testing.assert_equal(lazy.compute(), snowblue.layers(packs, **options))


def test_wrong_packs_are_named():
    packs = season().isel(time=[0, 1])
    dense = packs.copy(deep=True)
    dense.density_kg_m3[1, 2] = 1200.0
    with pytest.raises(ValueError, match=r"density is 1200 kg/m³.* in layer 2, at time\[1\]"):
        snowblue.layers(dense)
    with pytest.raises(ValueError, match="needs the dimension 'layer', top first, and the variable thickness_cm"):
        snowblue.layers(packs.rename(layer="depth_index"))
    with pytest.raises(TypeError, match="'ssa' is not known"):
        snowblue.layers(packs.rename(ssa_m2_kg="ssa"))
    with pytest.raises(ValueError, match="need the engine 'ordinates'"):
        snowblue.layers(packs, engine="montecarlo")
    packs.ssa_m2_kg.attrs["units"] = "mm"
    with pytest.raises(ValueError, match="states the units 'mm'"):
        snowblue.layers(packs)


def test_a_ground_with_a_spectrum_is_grey_at_each_wavelength():
    pack = [dict(thickness_cm=2, ssa_m2_kg=40), dict(thickness_cm=3, ssa_m2_kg=10)]
    views = dict(view_zenith_deg=30, view_azimuth_deg=0)
    functions = {
        "reflectance": lambda ground: snowblue.spectrum(thickness_cm=4, wavelength_nm=NM, ground_albedo=ground),
        "transmittance": lambda ground: snowblue.layers(pack, wavelength_nm=NM, ground_albedo=ground),
        "reflectance_per_ground_albedo": lambda ground: snowblue.layers(
            pack, wavelength_nm=NM, ground_albedo=ground, jacobian="ground_albedo"
        ),
        "brf": lambda ground: snowblue.brf(wavelength_nm=NM, thickness_cm=4, ground_albedo=ground, streams=8, **views),
        "down": lambda ground: snowblue.light_at_depth(
            pack, dict(elevation_deg=30, wavelength_nm=NM), depth_cm=4, ground_albedo=ground, bands=[]
        ),
    }
    for name, solve in functions.items():
        found = solve(SOIL)
        assert "ground_albedo" not in found.attrs
        np.testing.assert_allclose(found.ground_albedo, ALBEDOS, rtol=1e-12)
        for place, albedo in enumerate(ALBEDOS):
            np.testing.assert_allclose(
                found[name].isel(wavelength=place), solve(albedo)[name].isel(wavelength=place), rtol=1e-9, err_msg=name
            )
        assert not np.allclose(found[name], solve(0.0)[name], rtol=1e-3, atol=0)


def test_a_ground_spectrum_may_be_a_series_and_vary_by_row():
    series = pd.Series(SOIL.values, index=pd.Index(SOIL.wavelength.values, name="wavelength"))
    options = dict(thickness_cm=4, wavelength_nm=[1030.0, 450.0], standard_errors=False)
    one = snowblue.spectrum(ground_albedo=series, **options).transmittance
    xr.testing.assert_equal(one, snowblue.spectrum(ground_albedo=SOIL, **options).transmittance)
    both = xr.concat([SOIL, SOIL.where(SOIL.wavelength < 500)], "pit")
    rows = snowblue.spectrum(ground_albedo=both, **options).transmittance
    np.testing.assert_array_equal(rows.sel(pit=0).values, one.values)
    # A gap in a spectrum is a gap of its pit.
    assert np.isnan(rows.sel(pit=1)).all()


def test_a_ground_spectrum_must_cover_the_wavelengths():
    for call in (
        lambda: snowblue.spectrum(wavelength_nm=[390.0, 500.0], ground_albedo=SOIL),
        lambda: snowblue.layers([dict(thickness_cm=1)], wavelength_nm=[390.0, 500.0], ground_albedo=SOIL),
    ):
        with pytest.raises(ValueError, match="albedo is given from 400 to 1200 nm, but it is needed from 390 to 500"):
            call()
    with pytest.raises(ValueError, match="no coordinate with its values in nm"):
        snowblue.spectrum(wavelength_nm=[500.0], ground_albedo=SOIL.drop_vars("wavelength"))
    with pytest.raises(ValueError, match="ground albedo is 1.6, but must lie in 0–1"):
        snowblue.spectrum(wavelength_nm=[500.0], ground_albedo=3 * SOIL + 1)
    with pytest.raises(ValueError, match=r"ground_albedo is \[0.1, 0.2\], but must be one number, or a spectrum"):
        snowblue.layers([dict(thickness_cm=1)], ground_albedo=[0.1, 0.2])


def test_a_ground_with_a_spectrum_is_known_in_retrievals():
    nm = np.arange(400.0, 1201.0, 50.0)
    ground = SOIL
    measured = snowblue.albedo(thickness_cm=1, ssa_m2_kg=18, angle_deg=60, wavelength_nm=nm, ground_albedo=ground)
    known = dict(thickness_cm=1, angle_deg=60, retrieve="ssa_m2_kg", standard_deviation=1e-3)
    # The spectrum carries its ground as a coordinate.
    stated = snowblue.invert(measured, **known)
    given = snowblue.invert(measured.drop_vars("ground_albedo"), ground_albedo=ground, **known)
    grey = snowblue.invert(measured.drop_vars("ground_albedo"), ground_albedo=0.1, **known)
    assert abs(stated.ssa - 18) < 2 * stated.ssa_sd and abs(given.ssa - 18) < 2 * given.ssa_sd
    assert abs(grey.ssa - 18) > 5 * grey.ssa_sd
    responses = {"a": ([450, 500], [1, 1]), "b": ([1000, 1050], [1, 1])}
    bands = snowblue.bands(measured.drop_vars("ground_albedo"), responses)
    banded = snowblue.invert(bands, bands=responses, wavelength_nm=nm, ground_albedo=ground, **known)
    assert abs(banded.ssa - 18) < 2 * banded.ssa_sd
    with pytest.raises(ValueError, match="the ground has a spectrum"):
        snowblue.invert(measured, **{**known, "retrieve": ["ssa_m2_kg", "ground_albedo"]})
