"""Spectra: the command's figures, axes and units, and two other models."""

import multiprocessing
import os
import re

import matplotlib.pyplot as plt
import numpy as np
import pytest
import tartes
import xarray as xr
from PythonicDISORT import pydisort

import snowblue

# The command prints 7 significant digits or more.
PRINTED = 1e-6


def test_figures_are_those_of_the_command(command):
    for engine in ([], ["--engine", "montecarlo", "--rays", "2000"]):
        rows = command("spectrum", "--thickness", "1,5", "--angle", "0,60,diffuse", "--wavelengths", "450,650",
                       "--grain-size", "200:300", "--impurity", "black-carbon=20", *engine)
        keywords = {"engine": "montecarlo", "rays": 2000} if engine else {}
        ours = snowblue.spectrum(
            thickness_cm=[1, 5], angle_deg=[0, 60, "diffuse"], wavelength_nm=[450, 650], grain_size_um=(200, 300),
            impurities_ng_g={"black-carbon": 20}, **keywords)
        names = ["reflectance", "transmittance", "absorptance"]
        names += [f"{name}_se" for name in names] if engine else []
        for name in names:
            printed = np.array([float(row[name]) for row in rows]).reshape(ours[name].shape)
            np.testing.assert_allclose(ours[name], printed, rtol=PRINTED)


def test_layers_are_those_of_the_command(command, tmp_path):
    pack = tmp_path / "pack.toml"
    pack.write_text("[[layer]]\nthickness_cm = 3\nsnow = \"fresh\"\n[[layer]]\nthickness_cm = 20\nsnow = \"firn\"\n")
    layers = [dict(thickness_cm=3, snow="fresh"), dict(thickness_cm=20, snow="firn")]
    common = ["spectrum", "--layers", pack, "--ground-albedo", 0.3, "--wavelengths", "450,850"]
    ours = snowblue.layers(layers, ground_albedo=0.3, wavelength_nm=[450, 850], depth_cm=[0, 1, 5])
    for row, reflectance in zip(command(*common), ours.reflectance.values.ravel()):
        assert float(row["reflectance"]) == pytest.approx(reflectance, rel=PRINTED)
    rows = command(*common, "--depths", "0,1,5")
    for printed, name in (("down", "down"), ("up", "up"), ("net", "net"), ("e_folding_depth_cm", "e_folding_depth")):
        expected = np.array([float(row[printed]) for row in rows]).reshape(ours[name].shape)
        np.testing.assert_allclose(ours[name], expected, rtol=PRINTED)


def test_energy_on_a_ground_is_conserved():
    for albedo in (0.5, 1):
        pack = snowblue.layers([dict(thickness_cm=1)], ground_albedo=albedo, wavelength_nm=[450, 650])
        assert "ground" in pack.transmittance.attrs["long_name"]
        all_light = pack.reflectance + pack.absorptance + (1 - albedo) * pack.transmittance
        np.testing.assert_allclose(all_light, 1, rtol=1e-9)
    assert pack.transmittance.sel(wavelength=450).item() > 1.2


def test_bsdf_is_that_of_the_command_and_adds_up(command):
    rows = command("bsdf", "--thickness", 1, "--angle", 60, "--wavelengths", 550, "--rays", 2000)
    ours = snowblue.bsdf(thickness_cm=1, angle_deg=60, wavelength_nm=550, rays=2000)
    printed = np.array([float(row["bsdf_per_sr"]) for row in rows]).reshape(2, 10, 12)
    np.testing.assert_allclose(ours.brdf.values[0], printed[0], rtol=PRINTED)
    np.testing.assert_allclose(ours.btdf.values[0], printed[1], rtol=PRINTED)
    # Each patch has the same integral of cos(theta) over solid angle.
    assert ours.brdf.sum().item() * np.pi / 120 == pytest.approx(ours.reflectance.item(), rel=1e-9)


def test_arrays_make_axes_and_tuples_do_not():
    wet = snowblue.spectrum(
        grain_size_um=[200, 400, 800], water_saturation=np.array([0, 0.1]), impurities_ng_g={"black-carbon": [0, 50]},
        facetness=(0.2, 0.4, 0.3, 0.075), thickness_cm=5, wavelength_nm=[450, 650], standard_errors=False)
    assert wet.transmittance.dims == (
        "grain_size", "water_saturation", "black_carbon", "thickness", "angle", "wavelength")
    assert wet.transmittance.shape == (3, 2, 2, 1, 1, 2)
    # Coarser, wetter and cleaner snow lets more light through.
    for axis, sign in (("grain_size", 1), ("water_saturation", 1), ("black_carbon", -1)):
        assert (sign * wet.transmittance.diff(axis) > 0).all(), axis
    one = snowblue.spectrum(
        grain_size_um=400, water_saturation=0.1, thickness_cm=5, wavelength_nm=[450, 650], standard_errors=False)
    np.testing.assert_allclose(
        wet.transmittance.sel(grain_size=400, water_saturation=0.1, black_carbon=0), one.transmittance, rtol=1e-12)
    assert wet.attrs["density_kg_m3"] == 300 and "grain_size_um" not in wet.attrs


def test_data_arrays_that_share_an_axis_are_paired():
    sites = xr.DataArray([200.0, 400.0], dims="site", coords={"site": ["ridge", "valley"]})
    paired = snowblue.spectrum(grain_size_um=sites, density_kg_m3=sites + 50, thickness_cm=2, wavelength_nm=550)
    assert paired.transmittance.dims == ("site", "thickness", "angle", "wavelength")
    valley = snowblue.spectrum(grain_size_um=400, density_kg_m3=450, thickness_cm=2, wavelength_nm=550)
    assert paired.transmittance.sel(site="valley").item() == pytest.approx(valley.transmittance.item(), rel=1e-12)
    with pytest.raises(ValueError, match="'site' has 3 values in density, but 2 elsewhere"):
        snowblue.spectrum(grain_size_um=sites, density_kg_m3=xr.DataArray([1.0, 2.0, 3.0], dims="site"))


def test_arrays_with_other_labels_are_refused():
    sizes = xr.DataArray([200.0, 800.0], dims="site", coords={"site": ["ridge", "valley"]})
    densities = xr.DataArray([450.0, 150.0], dims="site", coords={"site": ["valley", "ridge"]})
    with pytest.raises(ValueError, match="'site' has other labels"):
        snowblue.spectrum(grain_size_um=sizes, density_kg_m3=densities)


def test_a_forked_process_is_told_to_be_spawned():
    snowblue.spectrum(thickness_cm=1, wavelength_nm=500)
    done = multiprocessing.get_context("fork").Process(target=_in_child)
    done.start()
    done.join(60)
    assert done.exitcode == 0


def _in_child():
    try:
        snowblue.spectrum(thickness_cm=2, wavelength_nm=500)
    except RuntimeError as error:
        os._exit(0 if "spawn" in str(error) else 1)
    os._exit(2)


def test_energy_is_conserved_and_errors_may_be_left_out():
    with_errors = snowblue.spectrum(thickness_cm=[1, 10])
    total = with_errors.reflectance + with_errors.transmittance + with_errors.absorptance
    np.testing.assert_allclose(total, 1.0, rtol=1e-12)
    without = snowblue.spectrum(thickness_cm=[1, 10], standard_errors=False)
    assert not any(name.endswith("_se") for name in without)
    np.testing.assert_allclose(without.transmittance, with_errors.transmittance, rtol=1e-12)


def test_results_are_at_home_in_xarray_pandas_and_matplotlib(tmp_path):
    result = snowblue.spectrum(thickness_cm=[1, 5], angle_deg=[0, "diffuse"])
    assert result.wavelength.attrs == {
        "long_name": "wavelength", "units": "nm", "standard_name": "radiation_wavelength"}
    assert result.angle.values.tolist() == [0, -1] and result.angle.attrs["flag_meanings"] == "diffuse"
    result.to_netcdf(tmp_path / "snow.nc", engine="scipy")
    with xr.open_dataset(tmp_path / "snow.nc") as again:
        xr.testing.assert_identical(again.transmittance.load(), result.transmittance)
        assert again.attrs["ice"] == "warren2008"
    frame = result.to_dataframe()
    assert len(frame) == 2 * 2 * 31 and frame.loc[(5.0, 0.0, 450.0), "transmittance"] > 0.05
    lines = result.transmittance.sel(angle=0).plot(hue="thickness")
    assert len(lines) == 2 and plt.gca().get_xlabel() == "wavelength [nm]"
    plt.close("all")


@pytest.mark.parametrize(("keywords", "words"), [
    ({"density_kg_m3": 1200}, "density is 1200 kg/m³, but must lie in 10–900 kg/m³"),
    ({"thickness_cm": -1}, "thickness is -1 cm"),
    ({"angle_deg": 95}, "angle is 95°"),
    ({"angle_deg": "steep"}, "'steep' is neither an angle"),
    ({"wavelength_nm": [200]}, "wavelength is 200 nm"),
    ({"wavelength_nm": []}, "no wavelength"),
    ({"snow": "slush"}, "'slush' is not known; there are fresh"),
    ({"ice": "hale1973"}, "there are warren2008, picard2016"),
    ({"impurities_ng_g": {"tea": 1}}, "'tea' is not known"),
    ({"grain_size_um": 400, "ssa_m2_kg": 20}, "cannot be given with a grain size"),
    ({"grain_size_um": (1, 2, 3)}, "a mean .* or a range"),
    ({"facetness": 2}, "facetness is 2, but must lie in 0–1"),
    ({"grain_size_um": np.ones((2, 2))}, "2 dimensions"),
    ({"streams": 7}, "streams are 7"),
    ({"streams": "many"}, "neither a number of streams"),
    ({"engine": "voxels"}, "there are ordinates, montecarlo"),
    ({"engine": "montecarlo", "rays": 1}, "rays is 1, but must be at least 2"),
    ({"seed": -1}, "seed is -1, but must be at least 0"),
    ({"grain_size_um": []}, "grain_size has no values"),
    ({"density_kg_m3": xr.DataArray([100.0, 200.0], dims="wavelength")}, "'wavelength', which belongs to the results"),
])
def test_bad_input_is_named(keywords, words):
    with pytest.raises(ValueError, match=words):
        snowblue.spectrum(**keywords)


@pytest.mark.parametrize(("keywords", "words"), [
    ({"thickness_cm": "5"}, "thickness is '5', but must be a number"),
    ({"angle_deg": [None]}, "angle_deg is None, but must be a number"),
    ({"grain_size_um": "400"}, "grain_size_um is '400', but must be a number"),
    ({"facetness": ("0.3", 1, 2, 3)}, "facetness is '0.3', but must be a number"),
    ({"impurities_ng_g": {"black-carbon": "x"}}, "black-carbon is 'x', but must be a number"),
    ({"ice": 5}, "ice is 5.*, but must be a word"),
])
def test_words_for_numbers_are_refused(keywords, words):
    with pytest.raises(ValueError, match=words):
        snowblue.spectrum(**keywords)


def test_layers_have_standard_errors_unless_they_are_not_wanted():
    pack = [dict(thickness_cm=3)]
    with_errors = snowblue.layers(pack, depth_cm=[1], wavelength_nm=550)
    without = snowblue.layers(pack, depth_cm=[1], wavelength_nm=550, standard_errors=False)
    assert {name for name in with_errors if not name.endswith("_se")} == set(without)
    assert "reflectance_se" in with_errors and "down_se" in with_errors
    assert without.reflectance.item() == with_errors.reflectance.item()


def test_progress_is_reported_and_may_stop_the_work():
    seen = []
    snowblue.spectrum(engine="montecarlo", rays=30_000, thickness_cm=5, progress=lambda *at: seen.append(at))
    assert seen and all(0 <= done <= total for done, total in seen)

    def stop(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        snowblue.spectrum(engine="montecarlo", rays=10**6, thickness_cm=50, progress=stop)


def test_discrete_ordinates_agree_with_pythonicdisort():
    """The same medium in another solver (Ho 2024, doi:10.21105/joss.06442): its 16 streams are Gauss nodes of each
    hemisphere with delta-M scaling, as ours, so that only rounding differs: transmittance is some 1e-1."""
    medium = snowblue.single_scattering(wavelength_nm=[500, 700], degree=16)
    ours = snowblue.spectrum(thickness_cm=5, angle_deg=60, wavelength_nm=[500, 700], streams=16)
    for nm in (500, 700):
        one = medium.sel(wavelength=nm)
        depth = one.extinction.item() * 0.05
        moments, mu0 = one.moments.values, 0.5
        assert abs(moments[0] - 1) < 1e-12
        moments[0] = 1
        _, up, down, _ = pydisort(
            depth, 1 - one.coalbedo.item(), 16, moments, mu0, 1 / mu0, 0.0, only_flux=True, f_arr=moments[16])
        assert up(0) == pytest.approx(ours.reflectance.sel(wavelength=nm).item(), rel=1e-5)
        assert sum(down(depth)) == pytest.approx(ours.transmittance.sel(wavelength=nm).item(), rel=1e-5)


def test_two_streams_of_tartes_agree_within_their_physics():
    """TARTES (Libois et al. 2013) has two streams and a grain of its own, whose kappa (1 - g) is a fifth above ours:
    the albedo of deep snow differs by less than 0.01 in the visible, the transmittance of 5 cm by less than 25 %."""
    # Surface over volume of spheroids with a sphericity of 0.7-0.9, times their greatest extension, is 8.204. Of sizes
    # uniform in number over 350-450 um, <s2>/<s3> replaces 1/s; ice has 917.7 kg/m3 at -5 degrees Celsius.
    area = 8.204 * (450**3 - 350**3) / 3 / ((450**4 - 350**4) / 4) * 1e6 / 917.7
    nm = np.array([450.0, 550.0, 650.0])
    ours = snowblue.spectrum(grain_size_um=400, thickness_cm=[5, 200], angle_deg=0, wavelength_nm=nm).squeeze()
    albedo, _ = tartes.tartes(nm * 1e-9, area, 300.0, [2.0], refrac_index="w2008", dir_frac=1.0, mudir=1.0,
                              compute_absorption=True)
    assert np.abs(ours.reflectance.sel(thickness=200) - albedo).max() < 0.01
    _, absorbed = tartes.tartes(nm * 1e-9, area, 300.0, [0.05], refrac_index="w2008", soilalbedo=0.0, dir_frac=1.0,
                                mudir=1.0, compute_absorption=True)
    transmitted = np.asarray(absorbed).reshape(len(nm), -1)[:, -1]
    assert np.abs(transmitted / ours.transmittance.sel(thickness=5) - 1).max() < 0.25


def test_the_documentation_has_the_limits_of_the_parameters():
    parameters = snowblue.parameters()
    documented = [snowblue.Snow, snowblue.spectrum, snowblue.layers, snowblue.bsdf]
    lines = [line for one in documented for line in re.findall(r"^ *(?:- `)?(\w+)`? ?: (.*)$", one.__doc__, re.M)]
    limited = {key for key, text in lines if re.search(r"\d to \d", text)} & parameters.keys()
    assert limited >= {"grain_size_um", "ssa_m2_kg", "density_kg_m3", "thickness_cm", "ground_albedo"}
    for key, text in lines:
        if key in limited:
            limits = f"{parameters[key]['least']:g} to {parameters[key]['greatest']:.15g}"
            assert limits in text, (key, limits, text)
