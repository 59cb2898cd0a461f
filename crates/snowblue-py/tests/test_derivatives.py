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
    xr.testing.assert_equal(solved[list(plain)].drop_vars("layer"), plain)
    assert len(solved) == 8 + 8 * len(names) and "layer" not in plain.coords
    assert solved.reflectance_per_ssa_m2_kg.dims == ("angle", "wavelength", "layer")
    assert solved.down_per_ssa_m2_kg.dims == ("angle", "wavelength", "depth", "layer")
    assert solved.up_per_ground_albedo.dims == ("angle", "wavelength", "depth")
    assert solved.e_folding_depth_per_density_kg_m3.units == "cm kg-1 m3"
    assert solved.fluence_per_thickness_cm.units == "cm-1"
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
                found = derivatives[f"{flux}_per_{name.replace('-', '_')}"].sel(layer=layer)
                difference = (more[flux] - less[flux]) / (2 * step)
                tolerance = 1e-5 * abs(difference) + 1e-12 * abs(plain[flux]).max() / step
                assert (abs(found - difference) <= tolerance).all(), (name, layer, flux)
    more, less = (solve_layers(PACK, ground_albedo=0.3 + sign * 1e-4) for sign in (1, -1))
    difference = (more.up - less.up) / 2e-4
    assert abs(solved.up_per_ground_albedo - difference).max() < 1e-7


def test_errors_have_one_line():
    with pytest.raises(ValueError, match=r"^parameter 'size' is not known; there are ssa_m2_kg, .*, ground_albedo$"):
        solve_layers(PACK, ["size"])
    with pytest.raises(ValueError, match="^jacobian needs the engine 'ordinates'$"):
        solve_layers(PACK, "ssa_m2_kg", engine="montecarlo", depth_cm=())
    with pytest.raises(ValueError, match=r"^parameter 'size' is not known; there are ssa_m2_kg, .*, ground_albedo$"):
        snowblue.spectrum(jacobian=["ssa_m2_kg", "size"])
    with pytest.raises(ValueError, match="^wavelength in snow with impurities is 300 nm, but must lie in 305–1495 nm$"):
        snowblue.spectrum(wavelength_nm=300, jacobian="black-carbon")
    with pytest.raises(ValueError, match="^jacobian needs the engine 'ordinates'$"):
        snowblue.spectrum(engine="montecarlo", jacobian="ssa_m2_kg")
    # An albedo has no place for them.
    with pytest.raises(TypeError, match="jacobian"):
        snowblue.albedo(jacobian="ssa_m2_kg")
