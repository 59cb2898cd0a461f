"""Derivatives of spectra: names, units, pairing and errors. The numbers are tested in Rust."""

import numpy as np
import pytest
import xarray as xr

import snowblue

NM = [450.0, 900.0, 1300.0]
NAMES = ["ssa_m2_kg", "density_kg_m3", "thickness_cm", "water_saturation", "black-carbon", "saharan-dust",
         "colorado-dust", "brown-carbon", "snow-algae", "cos_angle", "ground_albedo"]


@pytest.fixture(scope="module")
def pits():
    return xr.Dataset(
        {
            "ssa": ("pit", [60.0, 25.0, 12.0]),
            "density": ("pit", [120.0, 300.0, 350.0]),
            "soot": ("pit", [20.0, 5.0, 50.0]),
            "water": ("pit", [0.0, 0.0, 0.1]),
            "thickness": ("pit", [2.0, 15.0, 8.0]),
            "angle": ("pit", [10.0, 60.0, 84.0]),
            "ground": ("pit", [0.0, 0.2, 0.6]),
        },
        {"pit": ["ridge", "valley", "road"]},
    )


def solve(pits, jacobian=()):
    return snowblue.spectrum(
        ssa_m2_kg=pits.ssa, density_kg_m3=pits.density, impurities_ng_g={"black-carbon": pits.soot},
        water_saturation=pits.water, thickness_cm=pits.thickness, angle_deg=pits.angle, ground_albedo=pits.ground,
        wavelength_nm=NM, standard_errors=False, jacobian=jacobian)


def test_derivatives_predict_neighbouring_pits(pits):
    """To second order: a step of 1e-4 leaves some 1e-4 of the change by central differences, squared."""
    solved = solve(pits, NAMES)
    for column, name in [("ssa", "ssa_m2_kg"), ("density", "density_kg_m3"), ("thickness", "thickness_cm"),
                         ("soot", "black-carbon")]:
        step = 1e-4 * pits[column]
        more, less = (solve(pits.assign({column: pits[column] + sign * step})) for sign in (1, -1))
        for flux in ("reflectance", "transmittance"):
            derivative = solved[f"{flux}_per_{name.replace('-', '_')}"]
            assert derivative.dims == solved[flux].dims == ("pit", "wavelength")
            difference = (more[flux] - less[flux]).values / (2 * step.values[:, None])
            # Where the flux is known to 1e-13 of 1.
            rounding = 1e-13 / step.values[:, None]
            assert (abs(derivative.values - difference) <= 1e-5 * abs(difference) + rounding).all(), (name, flux)


def test_every_parameter_has_three_derivatives_with_units(pits):
    solved, plain = solve(pits, NAMES), solve(pits)
    assert [name for name in solved if "_per_" not in name] == list(plain)
    for name in plain:
        assert (solved[name] == plain[name]).all()
    assert len(solved) == len(plain) + 3 * len(NAMES)
    units = {name: solved[f"transmittance_per_{name.replace('-', '_')}"].units for name in NAMES}
    assert units == {
        "ssa_m2_kg": "m-2 kg", "density_kg_m3": "kg-1 m3", "thickness_cm": "cm-1", "water_saturation": "1",
        "cos_angle": "1", "ground_albedo": "1", **dict.fromkeys(NAMES[4:9], "ng-1 g")}
    soot = solved.reflectance_per_black_carbon
    assert soot.long_name == "derivative of reflectance with respect to black carbon"
    assert soot.pit.values.tolist() == pits.pit.values.tolist() and (soot < 0).all()


def test_a_word_is_one_parameter():
    one = snowblue.spectrum(wavelength_nm=550, jacobian="density_kg_m3", standard_errors=False)
    same = snowblue.spectrum(wavelength_nm=550, jacobian=("density_kg_m3",), standard_errors=False)
    xr.testing.assert_identical(one, same)
    assert one.reflectance_per_density_kg_m3.item() > 0 > one.transmittance_per_density_kg_m3.item()
    # With standard errors there are none of derivatives.
    errors = snowblue.spectrum(wavelength_nm=550, jacobian="density_kg_m3")
    assert "transmittance_se" in errors and "transmittance_per_density_kg_m3_se" not in errors
    assert (errors.transmittance_per_density_kg_m3 == one.transmittance_per_density_kg_m3).all()


def test_what_a_slab_does_not_depend_on_has_the_derivative_0():
    deep = snowblue.spectrum(
        thickness_cm=np.inf, angle_deg="diffuse", wavelength_nm=550, standard_errors=False,
        jacobian=["thickness_cm", "cos_angle"])
    assert deep.reflectance_per_thickness_cm.item() == deep.reflectance_per_cos_angle.item() == 0


PACK = [dict(thickness_cm=2, ssa_m2_kg=45, density_kg_m3=120),
        dict(thickness_cm=8, ssa_m2_kg=20, density_kg_m3=250, impurities_ng_g={"black-carbon": 50}),
        dict(thickness_cm=20, ssa_m2_kg=9, density_kg_m3=400)]


def solve_layers(pack, jacobian=(), **changed):
    arguments = dict(depth_cm=[0, 1, 5, 15], ground_albedo=0.3, angle_deg=[50, "diffuse"], wavelength_nm=NM) | changed
    return snowblue.layers(pack, standard_errors=False, jacobian=jacobian, **arguments)


def test_layers_have_derivatives_of_each_layer():
    names = ["ssa_m2_kg", "density_kg_m3", "thickness_cm", "black-carbon", "ground_albedo"]
    solved, plain = solve_layers(PACK, names), solve_layers(PACK)
    xr.testing.assert_equal(solved[list(plain)], plain)
    assert len(solved) == 8 + 8 * len(names) and "changed_layer" not in plain.coords
    assert solved.reflectance_per_ssa_m2_kg.dims == ("angle", "wavelength", "changed_layer")
    assert solved.down_per_ssa_m2_kg.dims == ("angle", "wavelength", "depth", "changed_layer")
    assert solved.up_per_ground_albedo.dims == ("angle", "wavelength", "depth")
    assert solved.e_folding_depth_per_density_kg_m3.units == "cm kg-1 m3"
    assert solved.fluence_per_thickness_cm.units == "cm-1"
    assert solved.e_folding_depth_per_thickness_cm.units == "1"
    assert solved.net_per_black_carbon.long_name == "derivative of net with respect to black carbon"
    for name in ("ssa_m2_kg", "density_kg_m3", "thickness_cm", "black-carbon"):
        derivatives = solved[[f"{flux}_per_{name.replace('-', '_')}" for flux in plain]]
        for layer in range(3):
            def changed(factor):
                pack = [dict(one) for one in PACK]
                if name == "black-carbon":
                    pack[layer]["impurities_ng_g"] = {"black-carbon": 50 * factor}
                else:
                    pack[layer][name] *= factor
                return solve_layers(pack)
            if name == "black-carbon" and layer != 1:
                continue
            step = 1e-4 * (50 if name == "black-carbon" else PACK[layer][name])
            more, less = changed(1 + 1e-4), changed(1 - 1e-4)
            for flux in plain:
                found = derivatives[f"{flux}_per_{name.replace('-', '_')}"].sel(changed_layer=layer)
                difference = (more[flux] - less[flux]) / (2 * step)
                tolerance = 1e-5 * abs(difference) + 1e-12 * abs(plain[flux]).max() / step
                assert (abs(found - difference) <= tolerance).all(), (name, layer, flux)
    more, less = (solve_layers(PACK, ground_albedo=0.3 + sign * 1e-4) for sign in (1, -1))
    difference = (more.up - less.up) / 2e-4
    assert abs(solved.up_per_ground_albedo - difference).max() < 1e-7


def test_light_at_depth_has_derivatives_in_bands():
    sun = dict(elevation_deg=[30.0, -2.0], turbidity=2, wavelength_nm=np.arange(400.0, 1001.0, 20))
    def solve(pack, jacobian=()):
        return snowblue.light_at_depth(
            pack, sun, depth_cm=[0, 1, 5], ground_albedo=0.3, bands=["visible", "par"], jacobian=jacobian)

    solved, plain = solve(PACK, ["density_kg_m3", "black-carbon", "cos_angle"]), solve(PACK)
    xr.testing.assert_equal(solved[list(plain)], plain)
    assert solved.par_down_per_black_carbon.dims == ("elevation", "changed_layer", "depth")
    assert solved.par_down_per_black_carbon.units == "umol m-2 s-1 ng-1 g"
    assert solved.net_per_cos_angle.dims == ("elevation", "depth", "wavelength")
    assert "warming_per_density_kg_m3" not in solved
    denser, looser = ([one | {"density_kg_m3": 250 * factor} if i == 1 else one for i, one in enumerate(PACK)]
                      for factor in (1 + 1e-4, 1 - 1e-4))
    more, less = solve(denser), solve(looser)
    for name in ("down", "par_actinic", "visible_absorbed", "layer_absorbed", "visible_layer_absorbed"):
        found = solved[f"{name}_per_density_kg_m3"].sel(changed_layer=1)
        difference = (more[name] - less[name]) / 0.05
        assert (abs(found - difference) <= 1e-5 * abs(difference) + 1e-10 * abs(plain[name]).max()).all(), name
    # At night nothing changes.
    assert not solved.par_down_per_black_carbon.isel(elevation=1).any()


def test_bands_are_means_of_values_and_derivatives():
    nm = np.arange(400.0, 1001.0, 10)
    solved = solve_layers(PACK, ["ssa_m2_kg"], wavelength_nm=nm)
    red = xr.DataArray([0.0, 1.0, 1.0, 0.0], {"wavelength": [600.0, 610.0, 690.0, 700.0]}, name="red")
    means = snowblue.bands(solved, {"par": None, "red": red, "green": ([500, 550, 600], [0, 2, 0])})
    assert means.band.values.tolist() == ["par", "red", "green"] and means.attrs["light"] == "ASTM G173-03"
    assert means.down_per_ssa_m2_kg.dims == ("angle", "band", "depth", "changed_layer")
    assert means.down_per_ssa_m2_kg.attrs == solved.down_per_ssa_m2_kg.attrs
    assert not any(name.startswith("e_folding") for name in means)
    # A sum of many narrow trapezoids.
    fine = np.linspace(600.0, 700.0, 1001)
    weight = snowblue.sunlight(fine).values * red.interp(wavelength=fine).values
    curve = solved.reflectance_per_ssa_m2_kg.interp(wavelength=fine)
    expected = (curve * xr.DataArray(weight, dims="wavelength")).sum("wavelength") / weight.sum()
    np.testing.assert_allclose(means.reflectance_per_ssa_m2_kg.sel(band="red"), expected, rtol=1e-4)
    # The derivative of a mean by central differences.
    step = 1e-4 * 20
    more, less = ([one | {"ssa_m2_kg": 20 + sign * step} if i == 1 else one for i, one in enumerate(PACK)]
                  for sign in (1, -1))
    more, less = (snowblue.bands(solve_layers(pack, wavelength_nm=nm), "par").up for pack in (more, less))
    difference = (more - less) / (2 * step)
    np.testing.assert_allclose(
        means.up_per_ssa_m2_kg.sel(changed_layer=1, band=["par"]), difference, rtol=1e-5, atol=1e-10)
    # Another light weighs otherwise, and a plain array has plain means.
    flat = xr.ones_like(solved.wavelength).rename("flat")
    albedo = snowblue.albedo(ssa_m2_kg=20, wavelength_nm=nm)
    by_flat, by_sun = snowblue.bands(albedo, "visible", light=flat), snowblue.bands(albedo, "visible")
    assert by_flat.name == "albedo" and by_flat.dims == ("band",) and by_flat.item() != by_sun.item()
    visible = albedo.sel(wavelength=slice(400, 700))
    assert by_flat.item() == pytest.approx((visible.integrate("wavelength") / 300).item(), rel=1e-12)


def test_a_band_of_one_wavelength_is_the_spectrum_there():
    """Also where the spectrum has it twice."""
    for wavelengths_nm in ([400.0, 500.0, 600.0], [500.0, 500.0, 600.0]):
        albedo = snowblue.albedo(wavelength_nm=wavelengths_nm)
        narrow = snowblue.bands(albedo, {"green": ([500], [3])})
        np.testing.assert_allclose(narrow.sel(band="green"), albedo[1], rtol=1e-15)


def test_bands_that_are_not_covered_are_named():
    albedo = snowblue.albedo(ssa_m2_kg=20, wavelength_nm=np.arange(400.0, 651.0, 50))
    with pytest.raises(ValueError, match="^band par: the .* band needs wavelengths from 400 to 700 nm"):
        snowblue.bands(albedo, "par")
    with pytest.raises(TypeError, match="'red' is not known; there are solar, par"):
        snowblue.bands(albedo, "red")
    with pytest.raises(ValueError, match="^band red: response is -1, but must lie in 0"):
        snowblue.bands(albedo, {"red": ([450, 500], [1, -1])})
    with pytest.raises(ValueError, match="^the response of red has wavelengths of the shape"):
        snowblue.bands(albedo, {"red": ([450, 500], [1])})
    with pytest.raises(ValueError, match="^the spectra need the dimension 'wavelength', and may not have 'band'$"):
        snowblue.bands(albedo.isel(wavelength=0), "par")
    with pytest.raises(ValueError, match="^band near-infrared: the near-infrared band needs wavelengths from 700"):
        snowblue.bands(albedo, "near-infrared")
    short = xr.DataArray([1.0, 1.0], {"wavelength": [400.0, 480.0]}, ["wavelength"], name="blue lamp")
    with pytest.raises(ValueError, match="^band par: wavelength of a response is 700 nm, but must lie in 400–480 nm$"):
        snowblue.bands(snowblue.albedo(wavelength_nm=np.arange(400.0, 701.0, 20)), "par", light=short)
    with pytest.raises(ValueError, match="^the spectra are of the type list, but must be a Dataset or a DataArray$"):
        snowblue.bands([1.0], "par")


def test_bands_of_irradiances_are_refused():
    noon = dict(elevation_deg=30, turbidity=2, wavelength_nm=np.arange(400.0, 701.0, 50))
    light = snowblue.light_at_depth(PACK, noon, depth_cm=[1])
    for spectra in (light, light.net):
        with pytest.raises(ValueError, match="' is in W m-2 nm-1, but means of bands are those of fractions of light$"):
            snowblue.bands(spectra, "par")


def test_a_layer_of_no_thickness_has_no_derivatives_of_light_at_depth():
    empty = [dict(thickness_cm=10), dict(thickness_cm=0), dict(thickness_cm=20)]
    message = "^thickness of a layer must be above 0 for derivatives of the light at depth$"
    noon = dict(elevation_deg=30, turbidity=2, wavelength_nm=[450, 500])
    with pytest.raises(ValueError, match=message):
        snowblue.light_at_depth(empty, noon, depth_cm=[1], jacobian="ssa_m2_kg")
    # But it has light.
    absorbed = snowblue.light_at_depth(empty, noon, depth_cm=[1]).layer_absorbed.sum("wavelength")
    assert absorbed[0] > absorbed[1] == 0


def test_errors_have_one_line():
    with pytest.raises(ValueError, match=r"^parameter 'size' is not known; there are ssa_m2_kg, .*, glacier-algae\b"):
        solve_layers(PACK, ["size"])
    with pytest.raises(ValueError, match="^jacobian needs the engine 'ordinates'$"):
        solve_layers(PACK, "ssa_m2_kg", engine="montecarlo", depth_cm=())
    with pytest.raises(ValueError, match="^jacobian is 5, but must be names of parameters$"):
        solve_layers(PACK, 5)
    with pytest.raises(ValueError, match=r"^jacobian is \[5\], but must be names of parameters$"):
        solve_layers(PACK, [5])


def test_parameters_may_come_from_an_iterator():
    noon = dict(elevation_deg=30, turbidity=2, wavelength_nm=[450, 550])
    light = snowblue.light_at_depth(PACK, noon, depth_cm=[1], jacobian=iter(["ssa_m2_kg"]))
    assert "net_per_ssa_m2_kg" in light


def test_parameters_that_are_not_known_are_named():
    with pytest.raises(ValueError, match=r"^parameter 'size' is not known; there are ssa_m2_kg, .*, glacier-algae\b"):
        snowblue.spectrum(jacobian=["ssa_m2_kg", "size"])
    with pytest.raises(ValueError, match="^jacobian needs the engine 'ordinates'$"):
        snowblue.spectrum(engine="montecarlo", jacobian="ssa_m2_kg")
    # An albedo has no place for them.
    with pytest.raises(TypeError, match="jacobian"):
        snowblue.albedo(jacobian="ssa_m2_kg")
