"""Retrieval of snow from spectra."""

import numpy as np
import pytest
import xarray as xr

import snowblue

NM = np.arange(400.0, 1401.0, 50.0)
SOOTY = dict(ssa_m2_kg=18, impurities_ng_g={"black-carbon": 300})


def noisy(array, deviation, seed=1):
    return array + np.random.default_rng(seed).normal(0, deviation, array.shape)


def test_snow_is_retrieved_within_its_posterior():
    measured = noisy(snowblue.albedo(**SOOTY, angle_deg="diffuse", wavelength_nm=NM), 0.004)
    fit = snowblue.invert(measured, standard_deviation=0.004)
    # Two numbers, each within 4 standard deviations: 1e-4.
    assert abs(fit.ssa - 18) < 4 * fit.ssa_sd and abs(fit.black_carbon - 300) < 4 * fit.black_carbon_sd
    assert fit.ssa_lower < fit.ssa < fit.ssa_upper and fit.outcome == "converged"
    # χ² of 21 degrees of freedom: 0.05 % and 99.95 %.
    assert 5.9 < fit.chi_square < 48 and fit.data == 21
    assert 0 < fit.degrees_of_freedom < 2
    assert fit.ssa.units == "m2 kg-1" and fit.black_carbon.units == "ng g-1" and fit.ssa.dims == ()
    kernel = fit.averaging_kernel
    assert kernel.dims == ("parameter", "true_parameter") and list(kernel.parameter.values) == ["ssa", "black_carbon"]
    assert abs(np.trace(kernel) - fit.degrees_of_freedom) < 1e-12
    assert fit.albedo_fit.dims == ("wavelength",) and abs(fit.albedo_fit - measured).max() < 0.02
    assert "black-carbon: median 30, deviation 2" in fit.prior


def test_the_light_is_that_of_the_spectrum_or_named():
    measured = snowblue.albedo(ssa_m2_kg=20, angle_deg=60, wavelength_nm=NM)
    told = snowblue.invert(measured)
    assert abs(told.ssa - 20) < 0.05 and told.light == "beam at 60 degrees, by the albedo's coordinate 'angle'"
    bare = measured.drop_vars("angle")
    assert abs(snowblue.invert(bare, angle_deg=60).ssa - told.ssa) < 1e-9
    assert abs(snowblue.invert(bare.assign_attrs(angle_deg=60.0)).ssa - told.ssa) < 1e-9
    as_diffuse = snowblue.invert(bare)
    assert as_diffuse.light == "diffuse, by default" and as_diffuse.ssa > 24
    both = xr.concat([measured, as_diffuse.albedo], "sky", coords="minimal", compat="override").drop_vars("angle")
    both = snowblue.invert(both, angle_deg=xr.DataArray([60, -1], dims="sky"))
    assert both.light == "diffuse or beam at 60 degrees"
    # An argument goes before a coordinate.
    assert snowblue.invert(measured, angle_deg="diffuse").ssa == as_diffuse.ssa
    assert snowblue.invert(measured, angle_deg=60).light == "beam at 60 degrees" and told.angle_deg == 60
    unnamed = measured.assign_coords(angle=np.pi / 3)
    with pytest.raises(ValueError, match="coordinate 'angle' with the units None, but they must be degree"):
        snowblue.invert(unnamed)

    sky = snowblue.albedo(ssa_m2_kg=20, angle_deg="diffuse", wavelength_nm=NM).drop_vars("angle")
    fraction = xr.DataArray(0.9 - 0.6 * (NM - 400) / 1000, dims="wavelength", coords={"wavelength": NM})
    mixed = fraction * sky + (1 - fraction) * bare
    fit = snowblue.invert(mixed, angle_deg=60, diffuse_fraction=fraction)
    assert abs(fit.ssa - 20) < 0.05 and fit.light == "beam at 60 degrees with diffuse light"
    assert abs(snowblue.invert(mixed, angle_deg=60).ssa - 20) > 0.2
    with pytest.raises(ValueError, match="diffuse_fraction needs the angle of a beam"):
        snowblue.invert(mixed, diffuse_fraction=0.5)


def test_spectra_have_dimensions_and_gaps():
    pits = xr.Dataset({"ssa": ("pit", [8.0, 20.0, 60.0]), "sun": ("pit", [30.0, 50.0, 70.0])}, {"pit": ["a", "b", "c"]})
    albedo = snowblue.albedo(ssa_m2_kg=pits.ssa, angle_deg=pits.sun, wavelength_nm=NM)
    assert albedo.dims == ("pit", "wavelength")
    visits = [noisy(albedo, 0.005, seed) for seed in (1, 2)]
    several = xr.concat(visits, "visit").transpose("wavelength", "visit", "pit")
    several[3:6, 1, 2] = np.nan
    several[:, 0, 1] = np.nan
    fit = snowblue.invert(several, standard_deviation=0.005)
    assert set(fit.ssa.dims) == {"pit", "visit"} and list(fit.pit.values) == ["a", "b", "c"]
    at = fit.isel(visit=1)
    assert (abs(at.ssa.values - pits.ssa.values) < 4 * at.ssa_sd.values).all()
    empty = fit.isel(visit=0, pit=1)
    assert empty.outcome == "no data" and abs(empty.ssa - 20) < 1e-9 and empty.degrees_of_freedom == 0
    assert (fit.outcome == "converged").sum() == 5 and fit.data.isel(visit=1, pit=2) == 18
    # Alone, without the missing wavelengths, to the noise of the rays through grains.
    alone = several.isel(visit=1, pit=2).dropna("wavelength")
    alone = snowblue.invert(alone, standard_deviation=0.005)
    assert abs(alone.ssa / fit.ssa.isel(visit=1, pit=2) - 1) < 1e-3
    plain = snowblue.invert(
        several.isel(visit=1).transpose("pit", "wavelength").values, NM, standard_deviation=np.full(NM.size, 0.005),
        angle_deg=xr.DataArray(pits.sun.values, dims="dim_0"))
    np.testing.assert_allclose(plain.ssa, at.ssa, rtol=1e-12)
    masked = np.ma.masked_invalid(several.isel(visit=1).transpose("pit", "wavelength").values)
    plain = snowblue.invert(
        masked, NM, standard_deviation=0.005, angle_deg=xr.DataArray(pits.sun.values, dims="dim_0"))
    np.testing.assert_allclose(plain.ssa, at.ssa, rtol=1e-12)


def test_arrays_pair_with_the_spectrum_whatever_its_dimension_is_called():
    named = snowblue.albedo(ssa_m2_kg=[20, 30], angle_deg=60, wavelength_nm=NM)
    named = named.rename(specific_surface_area="pit").drop_vars("pit")
    fraction = xr.full_like(named.wavelength, 0.2)
    expected = snowblue.invert(named, standard_deviation=0.02 * named, angle_deg=60, diffuse_fraction=fraction)
    # The labels of the bands are no wavelengths.
    band = named.swap_dims(wavelength="band").drop_vars("wavelength").assign_coords(band=range(1, NM.size + 1))
    for spectrum in (band, band.drop_vars("band"), band.transpose("pit", "band"), band.assign_coords(nm=("band", NM))):
        spectrum = spectrum.transpose(..., "band")
        deviation = 0.02 * spectrum
        for given in (deviation, deviation.values):
            fit = snowblue.invert(
                spectrum, NM, standard_deviation=given, angle_deg=60,
                diffuse_fraction=xr.DataArray(np.full(NM.size, 0.2), dims="band"))
            assert fit.ssa.dims == ("pit",) and fit.albedo.dims == ("pit", "wavelength")
            np.testing.assert_array_equal(fit.ssa, expected.ssa)
            np.testing.assert_array_equal(fit.wavelength, NM)


def test_a_series_with_its_own_index_is_a_spectrum():
    pd = pytest.importorskip("pandas")
    measured = snowblue.albedo(ssa_m2_kg=20, wavelength_nm=NM)
    series = pd.Series(measured.values)
    fit = snowblue.invert(series, NM, standard_deviation=pd.Series(np.full(NM.size, 0.01)), angle_deg="diffuse")
    assert fit.ssa == snowblue.invert(measured).ssa and fit.ssa.dims == ()


def test_a_wet_pit_has_other_wavelengths_than_a_dry_one():
    wavelength_nm = [*NM[12:], 1600.0]
    dry = snowblue.albedo(ssa_m2_kg=20, wavelength_nm=wavelength_nm).drop_vars("specific_surface_area", errors="ignore")
    pits = xr.concat([dry, dry.where(dry.wavelength < 1500)], "pit")
    fit = snowblue.invert(
        pits, retrieve="ssa_m2_kg", water_saturation=xr.DataArray([0.0, 0.05], dims="pit"))
    assert (fit.outcome == "converged").all() and list(fit.data.values) == [10, 9]
    assert fit.albedo_fit.notnull().all()


def test_transmittance_tells_the_thickness():
    arguments = dict(ssa_m2_kg=25, density_kg_m3=250, thickness_cm=4, angle_deg=40, wavelength_nm=NM)
    truth = snowblue.spectrum(**arguments, standard_errors=False).squeeze(drop=True)
    fit = snowblue.invert(
        truth.reflectance, transmittance=truth.transmittance,
        transmittance_standard_deviation=0.02 * truth.transmittance, angle_deg=40, thickness_cm=6, density_kg_m3=250,
        retrieve={"ssa_m2_kg": (20, 0.5), "thickness_cm": None})
    assert abs(fit.thickness - 4) < 0.02 and fit.thickness.units == "cm" and abs(fit.ssa - 25) < 0.2
    assert fit.degrees_of_freedom > 1.9 and fit.data == 42 and "thickness_cm: median of the argument" in fit.prior
    only = snowblue.invert(
        transmittance=truth.transmittance, transmittance_standard_deviation=0.01, angle_deg=40, thickness_cm=4)
    assert "albedo_fit" not in only and only.outcome == "converged"
    with pytest.raises(ValueError, match="standard deviation of the transmittance is 0, but must lie in 1e-18–1000000"):
        snowblue.invert(transmittance=truth.transmittance, transmittance_standard_deviation=0, thickness_cm=4)
    with pytest.raises(ValueError, match="transmittance is .*, but must lie in -0.5–2"):
        snowblue.invert(transmittance=100 * truth.transmittance, transmittance_standard_deviation=1, thickness_cm=4)
    with pytest.raises(ValueError, match="transmittance needs a thickness that is finite"):
        snowblue.invert(transmittance=truth.transmittance, transmittance_standard_deviation=0.01)
    with pytest.raises(TypeError, match="transmittance_standard_deviation"):
        snowblue.invert(transmittance=truth.transmittance)


def test_errors_in_common_are_part_of_the_posterior():
    measured = 1.03 * snowblue.albedo(**SOOTY, wavelength_nm=NM)
    trusted = snowblue.invert(measured, standard_deviation=0.004)
    scaled = snowblue.invert(measured, standard_deviation=0.004, scale_error=0.03)
    smooth = snowblue.invert(measured, standard_deviation=0.004, correlation_nm=100)
    assert abs(trusted.ssa - 18) > 4 * trusted.ssa_sd and abs(scaled.ssa - 18) < scaled.ssa_sd
    assert abs(scaled.albedo_scale - 1.03) < scaled.albedo_scale_sd and "albedo_scale" not in trusted
    assert smooth.ssa_sd > 1.5 * trusted.ssa_sd
    correlated = snowblue.invert(measured, prior_correlation=[[1, 0.5], [0.5, 1]])
    assert correlated.ssa != snowblue.invert(measured).ssa
    for wrong in ([[1]], [1, 0.5], [[[1, 0], [0, 1]]]):
        with pytest.raises(ValueError, match="2 rows and 2 columns"):
            snowblue.invert(measured, prior_correlation=wrong)
    with pytest.raises(ValueError, match="is 0.3 in row 1 and column 2, but is 0.4 in row 2 and column 1"):
        snowblue.invert(measured, prior_correlation=[[1, 0.3], [0.4, 1]])
    with pytest.raises(ValueError, match="is 2 in row 1 and column 2, but must lie in -1–1"):
        snowblue.invert(measured, prior_correlation=[[1, 2], [2, 1]])
    with pytest.raises(ValueError, match="prior_correlation is not an array of numbers with rows of one length"):
        snowblue.invert(measured, prior_correlation=[[1, 0.3], [1]])


def test_a_symmetric_correlation_is_one_with_any_deviations():
    """(0.3 · 0.7) · 1.5 and (0.3 · 1.5) · 0.7 differ by rounding."""
    assert 0.3 * 0.7 * 1.5 != 0.3 * 1.5 * 0.7
    fit = snowblue.invert(
        np.full(NM.size, np.nan), NM, retrieve={"ssa_m2_kg": (20, 0.7), "black-carbon": (30, 1.5)},
        prior_correlation=[[1, 0.3], [0.3, 1]])
    np.testing.assert_allclose(fit.covariance, [[0.49, 0.315], [0.315, 2.25]], rtol=1e-12)


def test_a_parameter_at_an_end_of_its_range_is_held_there():
    bright = snowblue.albedo(ssa_m2_kg=200, impurities_ng_g={"black-carbon": 100}, wavelength_nm=NM)
    bright = bright.where(bright.wavelength < 900, 1.0)
    fit = snowblue.invert(bright, standard_deviation=0.02)
    assert fit.outcome == "ssa_m2_kg is at an end of its range" and abs(fit.ssa - 300) < 1e-9
    assert fit.ssa_sd == 0 and (fit.averaging_kernel.sel(parameter="ssa") == 0).all()
    # The other has the posterior that it has in snow of this area, to the noise of the rays through grains.
    alone = snowblue.invert(bright, standard_deviation=0.02, retrieve="black-carbon", ssa_m2_kg=300)
    assert abs(np.log(fit.black_carbon / alone.black_carbon)) < 0.01
    assert abs(fit.black_carbon_sd / alone.black_carbon_sd - 1) < 0.01


def test_wrong_input_is_named_with_its_place():
    with pytest.raises(TypeError, match="no albedo, transmittance or fluxes are given"):
        snowblue.invert()
    with pytest.raises(TypeError, match="wavelength_nm is missing"):
        snowblue.invert([0.9, 0.8])
    with pytest.raises(ValueError, match=r"the albedo has the shape \(2,\), but there are 1 wavelengths"):
        snowblue.invert([0.9, 0.8], [400])
    with pytest.raises(ValueError, match="wavelength_nm has no values"):
        snowblue.invert([], [])
    with pytest.raises(ValueError, match="albedo is not an array of numbers with rows of one length"):
        snowblue.invert([[0.9, 0.8], [0.7]], [400, 500])
    with pytest.raises(ValueError, match="the prior of ground_albedo has no median, and the snow's own value 0 is not"):
        snowblue.invert([0.9, 0.8], [400, 500], retrieve="ground_albedo", thickness_cm=5)
    with pytest.raises(ValueError, match="the prior of cos_angle has no median, and the snow's own value 1 is not"):
        snowblue.invert([0.9, 0.8], [400, 500], retrieve="cos_angle", angle_deg=0)
    with pytest.raises(ValueError, match="deviation of density_kg_m3 is 0, but must be above 0"):
        snowblue.invert([0.9, 0.8], [400, 500], retrieve={"density_kg_m3": (300, 0)})
    with pytest.raises(ValueError, match=r"albedo is 2, but must lie in -0.5–1.5, at wavelength\[1\]"):
        snowblue.invert([0.9, 2.0, 0.5], [400, 500, 600])
    with pytest.raises(ValueError, match=r"standard deviation of the albedo is 0, .* at wavelength\[0\]"):
        snowblue.invert([0.9, 0.8], [400, 500], standard_deviation=0)
    measured = snowblue.albedo(ssa_m2_kg=[20, 30], wavelength_nm=NM)
    wrong = measured.copy()
    wrong[1, 4] = np.inf
    with pytest.raises(ValueError, match=r"albedo is inf, .*, at specific_surface_area\[1\], wavelength\[4\]"):
        snowblue.invert(wrong)
    with pytest.raises(ValueError, match=r"the standard deviation of the albedo has the shape \(2,\), but there are"):
        snowblue.invert(measured, standard_deviation=[0.01, 0.02])
    with pytest.raises(ValueError, match=r"density is 1200 kg/m³, but must lie in 10–900 kg/m³, at pit\[1\]"):
        snowblue.invert(
            measured.isel(specific_surface_area=0), density_kg_m3=xr.DataArray([300.0, 1200.0], dims="pit"))
    with pytest.raises(ValueError, match=r"^wavelength is inf nm, but must lie in 300–2500 nm, at wavelength\[1\]$"):
        snowblue.invert([0.9, 0.8], [400, np.inf])
    down = xr.DataArray([[0.5, 0.4]], {"wavelength": [400, 500], "depth": [3]}, ["depth", "wavelength"])
    with pytest.raises(ValueError, match="the standard deviation of the flux down has the shape"):
        snowblue.invert(fluxes={"down": down}, fluxes_standard_deviation=[1, 1, 1])
    with pytest.raises(ValueError, match="standard deviation of the flux down is 0, but must lie"):
        snowblue.invert(fluxes={"down": down}, fluxes_standard_deviation=0)
    with pytest.raises(ValueError, match="parameter 'size' is not known; there are ssa_m2_kg"):
        snowblue.invert(measured, retrieve="size")
    with pytest.raises(ValueError, match="the prior of ssa_m2_kg is 20, but must be a median and a deviation"):
        snowblue.invert(measured, retrieve={"ssa_m2_kg": 20})
    with pytest.raises(ValueError, match="specific surface area is 2000 m²/kg, but must lie in 1.4–300 m²/kg"):
        snowblue.invert(measured, retrieve={"ssa_m2_kg": (2000, 1)})
    with pytest.raises(TypeError, match="'free_scale' is not known"):
        snowblue.invert(measured, free_scale=True)


def test_the_result_can_be_written(tmp_path):
    pytest.importorskip("scipy")
    fit = snowblue.invert(snowblue.albedo(ssa_m2_kg=[20, 30], wavelength_nm=NM))
    fit.to_netcdf(tmp_path / "fit.nc", engine="scipy")
    again = xr.open_dataset(tmp_path / "fit.nc", engine="scipy")
    np.testing.assert_array_equal(again.ssa, fit.ssa)
    assert (again.outcome == "converged").all() and again.light == fit.light


PACK = [dict(thickness_cm=3, density_kg_m3=150), dict(thickness_cm=20, density_kg_m3=350)]


def layered():
    """Two layers of 45 and 12 m²/kg with 60 ng/g of soot, and what is measured of them."""
    soot = {"black-carbon": 60}
    pack = [dict(layer, ssa_m2_kg=area, impurities_ng_g=soot) for layer, area in zip(PACK, (45, 12))]
    return snowblue.layers(
        pack, ground_albedo=0.1, angle_deg=60, depth_cm=[2, 12], wavelength_nm=NM[:15], standard_errors=False
    ).squeeze(drop=True)


def test_layers_are_retrieved_from_fluxes_at_depth():
    exact = layered()
    albedo = noisy(exact.reflectance, 0.01)
    fluxes = {}
    deviations = {}
    for seed, name in enumerate(("down", "fluence")):
        deviations[name] = 0.05 * exact[name] + 1e-6
        fluxes[name] = exact[name] + deviations[name] * np.random.default_rng(seed).normal(size=exact[name].shape)
    given = dict(layers=PACK, ground_albedo=0.1, angle_deg=60)
    retrieve = [("ssa_m2_kg", 0), ("ssa_m2_kg", 1), "black-carbon"]
    fit = snowblue.invert(albedo, fluxes=fluxes, fluxes_standard_deviation=deviations, retrieve=retrieve, **given)
    assert fit.outcome == "converged" and fit.data == 15 * 5
    for name, truth in (("ssa_0", 45), ("ssa_1", 12), ("black_carbon", 60)):
        # Three numbers, each within 4 standard deviations: 2e-4.
        assert abs(fit[name] - truth) < 4 * fit[f"{name}_sd"], name
    # χ² of 75 degrees of freedom: 0.05 % and 99.95 %.
    assert 39 < fit.chi_square < 124
    assert list(fit.parameter.values) == ["ssa_0", "ssa_1", "black_carbon"]
    assert fit.ssa_1.long_name.startswith("specific surface area of layer 1") and fit.ssa_1.units == "m2 kg-1"
    assert fit.down_fit.dims == ("depth", "wavelength") and list(fit.depth.values) == [2, 12]
    assert (abs(fit.down_fit / exact.down.transpose("depth", "wavelength") - 1) < 0.1).all()
    assert "thickness_cm" not in fit.attrs and fit.layers.startswith("3 cm, density_kg_m3=150")
    assert fit.prior.startswith("ssa_m2_kg of layer 0: median 20")
    # What is retrieved is not stated as known.
    known = [dict(layer, ssa_m2_kg=30, impurities_ng_g={"black_carbon": 5}) for layer in PACK]
    same = snowblue.invert(
        albedo, fluxes=xr.Dataset(fluxes), fluxes_standard_deviation=xr.Dataset(deviations), retrieve=retrieve,
        **{**given, "layers": known})
    assert same.layers == fit.layers and same.ssa_1 == fit.ssa_1
    # The albedo alone says little of what lies below.
    alone = snowblue.invert(albedo, retrieve=retrieve, **given)
    assert alone.ssa_1_sd > 10 * fit.ssa_1_sd and alone.degrees_of_freedom < fit.degrees_of_freedom

    # Fluxes without an albedo, of several pits, with gaps, and with a factor in common.
    pits = xr.concat([fluxes["down"], 1.2 * fluxes["down"]], "pit").transpose("depth", "pit", "wavelength")
    pits[0, 1, 3:6] = np.nan
    deviation = deviations["down"].transpose("wavelength", "depth")
    scaled = snowblue.invert(
        fluxes={"down": pits}, fluxes_standard_deviation=deviation, retrieve=retrieve, scale_error=0.3,
        diffuse_fraction=xr.full_like(pits.wavelength, 0.0), **given)
    assert scaled.ssa_0.dims == ("pit",) and list(scaled.data.values) == [30, 27]
    # Both have the same noise, but for the gaps.
    assert abs(scaled.down_scale[1] - 1.2 * scaled.down_scale[0]) < scaled.down_scale_sd[1]


def test_one_layer_is_snow_without_layers():
    exact = snowblue.spectrum(
        ssa_m2_kg=25, density_kg_m3=200, thickness_cm=8, angle_deg=50, wavelength_nm=NM[:15], standard_errors=False)
    data = dict(
        albedo=exact.reflectance.squeeze(drop=True), transmittance=exact.transmittance.squeeze(drop=True),
        transmittance_standard_deviation=0.01, angle_deg=50)
    plain = snowblue.invert(**data, density_kg_m3=200, thickness_cm=8)
    in_layer = snowblue.invert(**data, layers=[dict(density_kg_m3=200, thickness_cm=8)])
    assert in_layer.ssa == plain.ssa and in_layer.covariance.equals(plain.covariance)
    first = snowblue.invert(
        **data, layers=[dict(density_kg_m3=200, thickness_cm=8)], retrieve=[("ssa_m2_kg", 0), ("black-carbon", 0)])
    assert first.ssa_0 == plain.ssa


def test_wrong_layers_and_fluxes_are_named():
    exact = layered()
    given = dict(fluxes={"down": exact.down}, fluxes_standard_deviation=0.1, layers=PACK, ground_albedo=0.1,
                 angle_deg=60, retrieve="ssa_m2_kg")

    def told(error, match, **changed):
        with pytest.raises(error, match=match):
            snowblue.invert(**{**given, **changed})

    told(TypeError, "down needs fluxes_standard_deviation", fluxes_standard_deviation=None)
    told(TypeError, "thickness_cm belongs to the layers", thickness_cm=3)
    told(TypeError, "density_kg_m3 belongs to the layers", density_kg_m3=300)
    told(ValueError, "number of the layer is 2, but must lie in 0–1", retrieve=[("ssa_m2_kg", 2)])
    told(ValueError, "ground_albedo belongs to no layer", retrieve=[("ground_albedo", 0)])
    told(ValueError, "the layers differ: give the prior a median", retrieve="density_kg_m3")
    told(ValueError, "fluxes have 'actinic', but may have down, up, net, fluence", fluxes={"actinic": exact.down})
    told(ValueError, "down must be an xarray.DataArray with the dimension 'depth'", fluxes={"down": exact.down.values})
    metres = exact.down.assign_coords(depth=exact.depth.assign_attrs(units="m"))
    told(ValueError, "down has depths in m, but they must be in cm", fluxes={"down": metres})
    other = dict(down=exact.down, up=exact.up.isel(depth=[0]))
    told(ValueError, "up has other depths than down", fluxes=other)
    told(ValueError, "fluxes_standard_deviation has 'albedo', but the fluxes are down",
         fluxes_standard_deviation={"down": 0.1, "albedo": 0.1})
    told(TypeError, "down needs fluxes_standard_deviation", fluxes_standard_deviation={})
    told(TypeError, "fluxes_standard_deviation is given without fluxes", fluxes=None)
    told(TypeError, "transmittance_standard_deviation is given without a", transmittance_standard_deviation=0.1)
    told(TypeError, "albedo needs standard_deviation", albedo=exact.reflectance, standard_deviation=None)
    told(ValueError, "fluxes is .*, but must be a mapping such as", fluxes=[exact.down])
    told(ValueError, "fluxes are empty", fluxes={})
    told(ValueError, "down has no dimension of wavelengths", fluxes={"down": exact.down.isel(wavelength=0)})
    told(ValueError, "down must have depths, and all of them finite",
         fluxes={"down": exact.down.assign_coords(depth=[2, np.nan])})
    told(ValueError, "retrieve is 5, but must be names", retrieve=5)
    told(ValueError, "the number of the layer is 10000000000, but must be below", retrieve=[("ssa_m2_kg", 10**10)])
    told(ValueError, "ssa_m2_kg is to be retrieved twice", retrieve=[("ssa_m2_kg", 0)] * 2)
    told(ValueError, "deviation of ssa_m2_kg of layer 0 is -1, but must be above 0",
         retrieve={("ssa_m2_kg", 0): (20, -1)})
    told(ValueError, "other depths than the fluxes", fluxes_standard_deviation=exact.down.isel(depth=[0]))
    told(ValueError, r"down is 40, but must lie in -0.5–3, at a depth of 12 cm, at wavelength\[2\]",
         fluxes={"down": xr.where((exact.depth == 12) & (exact.wavelength == NM[2]), 40, exact.down)})
    told(ValueError, "depth is 30 cm, but must lie in 0–23 cm",
         fluxes={"down": exact.down.assign_coords(depth=[2, 30])})
    told(ValueError, r"retrieve has \('ssa_m2_kg', 0, 1\), but must have names", retrieve=[("ssa_m2_kg", 0, 1)])


SENSOR = {
    "blue": ([440, 450, 500, 510], [0, 1, 1, 0]),
    "green": xr.DataArray([0.0, 1.0, 1.0, 0.0], {"wavelength": [530.0, 550.0, 580.0, 590.0]}, ["wavelength"]),
    "red": ([640, 670], [1, 1]),
    "infrared": ([840, 870, 890], [0.2, 1, 0.4]),
    "swir": ([1220, 1240, 1260], [0, 1, 0]),
}


def test_snow_is_retrieved_from_bands_of_a_sensor():
    dense = snowblue.albedo(
        ssa_m2_kg=[12, 40], impurities_ng_g={"black-carbon": 200}, angle_deg=60, wavelength_nm=np.arange(400, 1301, 2))
    bands = snowblue.bands(dense, SENSOR)
    measured = noisy(bands, 0.004)
    fit = snowblue.invert(measured, bands=SENSOR, standard_deviation=0.004)
    truth = {"ssa": [12, 40], "black_carbon": [200, 200]}
    # Four numbers, each within 4 standard deviations: 3e-4.
    assert all((abs(fit[name] - own) < 4 * fit[f"{name}_sd"]).all() for name, own in truth.items())
    assert (fit.outcome == "converged").all() and list(fit.data.values) == [5, 5]
    assert fit.albedo.dims == ("specific_surface_area", "band") and list(fit.band.values) == list(SENSOR)
    assert fit.wavelength.dims == ("band",) and fit.light.startswith("beam at 60 degrees")
    np.testing.assert_allclose(fit.wavelength, [475, 562.5, 655, 866, 1240], atol=6)
    # At the wavelengths of the data the model errs by nothing, and the wide prior shifts the result by little.
    wide = dict(standard_deviation=1e-3, retrieve={"ssa_m2_kg": (20, 3), "black-carbon": (99, 3)})
    exact = snowblue.invert(bands, dense.wavelength, bands=SENSOR, **wide)
    coarse = snowblue.invert(bands, bands=SENSOR, **wide)
    for name, own in truth.items():
        np.testing.assert_allclose(exact[name], own, rtol=1e-3)
        # Steps of 10 nm, which make the albedo near an absorption band less smooth.
        np.testing.assert_allclose(coarse[name], own, rtol=0.01)
    # A thousandth of the surface area, the noise of the rays through grains, changes an albedo by less than this.
    assert abs(exact.albedo_fit - bands).max() < 3e-4
    # By name or by place, whatever the dimension is called.
    shuffled = measured.isel(band=[3, 0, 4, 2, 1])
    for given in (shuffled, measured.values, measured.rename(band="channel").drop_vars("channel"), measured.T):
        again = snowblue.invert(given, bands=SENSOR, standard_deviation=0.004, angle_deg=60)
        np.testing.assert_array_equal(again.ssa, fit.ssa)
    # The light, and the deviation of each band.
    light = xr.DataArray([0.0, 1.0], {"wavelength": [400.0, 1300.0]}, ["wavelength"], name="lamp")
    lit = snowblue.invert(snowblue.bands(dense, SENSOR, light=light), bands=SENSOR, light=light,
                          standard_deviation=xr.full_like(bands[0], 1e-3).isel(band=[1, 0, 2, 3, 4]))
    np.testing.assert_allclose(lit.ssa, truth["ssa"], rtol=0.005)
    assert lit.band_light == "lamp" and fit.band_light == "ASTM G173-03"


def test_bands_of_single_wavelengths_equal_the_spectrum():
    places = [2, 6, 9, 12, 16]
    measured = noisy(snowblue.albedo(**SOOTY, angle_deg="diffuse", wavelength_nm=NM[places]), 0.004)
    arguments = dict(standard_deviation=0.004, scale_error=0.02, correlation_nm=80)
    expected = snowblue.invert(measured, **arguments)
    single = {f"b{nm:g}": ([nm], [1]) for nm in NM[places]}
    found = snowblue.invert(measured.values, bands=single, **arguments)
    for name in ("ssa", "ssa_sd", "black_carbon", "black_carbon_sd", "chi_square", "albedo_scale", "covariance"):
        np.testing.assert_allclose(found[name], expected[name], rtol=1e-9)
    np.testing.assert_allclose(found.wavelength, expected.wavelength, rtol=1e-15)
    means = snowblue.bands(expected.albedo_fit, single)
    np.testing.assert_allclose(means, expected.albedo_fit, rtol=1e-15)


def test_the_ground_is_that_of_the_spectrum():
    arguments = dict(ssa_m2_kg=20, thickness_cm=2, ground_albedo=0.6, wavelength_nm=np.arange(400, 901, 50))
    for spectrum in (snowblue.spectrum(**arguments, angle_deg=0).reflectance, snowblue.albedo(**arguments)):
        fit = snowblue.invert(spectrum.squeeze(), retrieve="ssa_m2_kg")
        assert fit.ground_albedo == 0.6 and abs(fit.ssa / 20 - 1) < 0.02


def test_transmittance_fluxes_and_a_sky_in_bands():
    light = snowblue.sky(elevation_deg=30, turbidity=2, ground_albedo=0.9, wavelength_nm=np.arange(420, 901, 10))
    fraction = (light.diffuse / (light.direct + light.diffuse)).drop_vars("elevation")
    sensor = {name: SENSOR[name] for name in ("blue", "green", "red", "infrared")}
    arguments = dict(thickness_cm=6, density_kg_m3=200, ground_albedo=0.2)
    parts = [
        snowblue.layers([dict(ssa_m2_kg=25, thickness_cm=6, density_kg_m3=200)], ground_albedo=0.2, angle_deg=angle,
                        depth_cm=[1, 3], wavelength_nm=np.arange(420, 901, 5), standard_errors=False).squeeze(drop=True)
        for angle in (60, "diffuse")
    ]
    names = ["reflectance", "transmittance", "down"]
    dense = fraction.interp(wavelength=parts[0].wavelength)
    truth = snowblue.bands((1 - dense) * parts[0][names] + dense * parts[1][names], sensor)
    fit = snowblue.invert(
        truth.reflectance, bands=sensor, angle_deg=60, diffuse_fraction=fraction, retrieve="ssa_m2_kg",
        transmittance=truth.transmittance, transmittance_standard_deviation=0.02 * truth.transmittance,
        fluxes={"down": truth.down}, fluxes_standard_deviation=0.02 * truth.down, **arguments)
    assert abs(fit.ssa - 25) < 0.1 and fit.data == 16 and fit.down_fit.dims == ("depth", "band")
    assert abs(fit.down_fit / truth.down - 1).max() < 0.005
    with pytest.raises(ValueError, match="diffuse fraction is given from 420 to 600 nm, but it is needed from"):
        snowblue.invert(
            truth.reflectance, bands=sensor, angle_deg=60, diffuse_fraction=fraction.sel(wavelength=slice(420, 600)))


def test_wrong_bands_are_named():
    measured = xr.DataArray(np.full((2, 5), 0.8), dims=("pit", "band"))
    wrong = measured.copy()
    wrong[1, 2] = 2
    with pytest.raises(ValueError, match=r"albedo is 2, but must lie in -0.5–1.5, at pit\[1\], in the band red"):
        snowblue.invert(wrong, bands=SENSOR)
    with pytest.raises(ValueError, match="albedo is 2, but must lie in -0.5–1.5, in the band red"):
        snowblue.invert(wrong[1], bands=SENSOR)
    far = SENSOR | {"swir": ([1560, 1660], [1, 1])}
    assert snowblue.invert(measured[0], bands=far).data == 5
    for change, text in (
        ({"red": ([670, 640], [1, 1])}, "band red: the wavelengths of a band must ascend"),
        ({"red": ([640, 670], [1, -1])}, "band red: response is -1"),
        ({"red": ([640, np.nan], [1, 1])}, "response of red has wavelengths that are no numbers"),
        ({"red": ([640], [0])}, "band red: response is 0, but must be above 0"),
        ({"red": ([], [])}, "band red: "),
        ({"red": 3}, "response of red is neither"),
    ):
        with pytest.raises(ValueError, match=text):
            snowblue.invert(measured, bands=SENSOR | change)
    with pytest.raises(ValueError, match="5 bands"):
        snowblue.invert(measured[:, :3], bands=SENSOR)
    with pytest.raises(ValueError, match="albedo has other bands than those given"):
        snowblue.invert(measured.assign_coords(band=list("abcde")), bands=SENSOR)
    with pytest.raises(ValueError, match="standard deviation of the albedo has other bands than the spectra"):
        deviation = xr.DataArray(np.full(5, 0.01), {"band": list("abcde")}, ["band"])
        snowblue.invert(measured, bands=SENSOR, standard_deviation=deviation)
    with pytest.raises(ValueError, match="has the dimension 'wavelength', but its values must be those of the bands"):
        snowblue.invert(measured.rename(band="wavelength"), bands=SENSOR)
    with pytest.raises(TypeError, match="light is given without bands"):
        snowblue.invert([0.9], [500], light=snowblue.sunlight())
    with pytest.raises(TypeError, match="wavelength_nm is missing, and the band visible has no response"):
        snowblue.invert(0.9, bands="visible")
    with pytest.raises(ValueError, match="band b: its wavelength of 500 nm is not one of the spectra"):
        snowblue.invert(0.9, np.arange(401, 700, 10), bands={"b": ([500], [1])})
    visible = snowblue.invert([0.9], np.arange(400, 701, 10), bands="visible")
    assert visible.outcome == "converged" and visible.data == 1
    same = {"one": SENSOR["red"], "other": SENSOR["red"]}
    with pytest.raises(ValueError, match="mean wavelength of a band is that of another.*, in the band other"):
        snowblue.invert([0.9, 0.9], bands=same, correlation_nm=50)
