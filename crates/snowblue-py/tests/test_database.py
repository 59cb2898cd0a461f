"""Tables and inversion."""

import numpy as np
import pytest
import xarray as xr

import snowblue

SMALL = dict(grain_size_um=[200, 400], facetness=[0.3], density_kg_m3=[300], thickness_cm=[1, 5, 15],
             angle_deg=[0, 60], wavelength_nm=np.arange(400, 701, 20), tally_rays=1 << 16)


def test_look_ups_agree_with_the_engine():
    looked_up = snowblue.Database.embedded().look_up(
        thickness_cm=[3, 12], angle_deg=[0, 50], grain_size_um=[180, 320], density_kg_m3=250)
    solved = snowblue.spectrum(
        thickness_cm=[3, 12], angle_deg=[0, 50], grain_size_um=[180, 320], density_kg_m3=250, standard_errors=False)
    # Between the values of the table, log space and 3 components are right to 2 % (docs: the table).
    np.testing.assert_allclose(looked_up.transmittance, solved.transmittance, rtol=0.02)
    np.testing.assert_allclose(looked_up.reflectance, solved.reflectance, atol=0.005)


def test_tables_are_built_compressed_written_and_read(tmp_path):
    full = snowblue.Database.build(**SMALL)
    curves = full.to_xarray()
    assert curves.transmittance.dims == ("grain_size", "facetness", "density", "angle", "thickness", "wavelength")
    errors = full.fidelity(components=3)
    assert (errors.rmse_worst.diff("components") < 0).all()
    compressed = full.compress(components=3)
    compressed.write(tmp_path / "small.nc")
    again = snowblue.Database.open(tmp_path / "small.nc")
    assert again.components == 3 and len(again) == 12 and "compressed" in repr(again)
    xr.testing.assert_identical(again.to_xarray(), compressed.to_xarray())
    worst = np.abs(compressed.to_xarray().transmittance - curves.transmittance).max().item()
    assert worst < 4 * errors.rmse_worst.sel(quantity="transmittance", components=3).item()
    with pytest.raises(ValueError, match="needs a full table"):
        compressed.fidelity()
    with pytest.raises(ValueError, match="look-ups need a compressed table"):
        full.look_up(thickness_cm=5)
    with pytest.raises(TypeError, match="components, max_delta_e or max_rmse"):
        full.compress()


def test_files_of_xarray_are_tables(tmp_path):
    full = snowblue.Database.build(**SMALL).to_xarray()
    path = tmp_path / "curves.nc"
    full.to_netcdf(path, format="NETCDF3_64BIT")
    xr.testing.assert_equal(snowblue.Database.open(path).to_xarray(), full)
    full.transpose("wavelength", ...).to_netcdf(path, format="NETCDF3_64BIT")
    with pytest.raises(ValueError, match="has not the dimensions grain_size, facetness, .* in this order"):
        snowblue.Database.open(path)


def test_bad_tables_and_look_ups_are_named(tmp_path):
    with pytest.raises(FileNotFoundError, match="missing.nc"):
        snowblue.Database.open(tmp_path / "missing.nc")
    (tmp_path / "text.nc").write_text("no table")
    with pytest.raises(ValueError, match="text.nc"):
        snowblue.Database.open(tmp_path / "text.nc")
    table = snowblue.Database.embedded()
    with pytest.raises(ValueError, match="thickness is 500 cm, but must lie in 0–"):
        table.look_up(thickness_cm=500)
    with pytest.raises(ValueError, match="angle is 95°"):
        table.look_up(thickness_cm=5, angle_deg=95)
    with pytest.raises(ValueError, match="grain size"):
        table.look_up(thickness_cm=5, grain_size_um=2000)
    with pytest.raises(ValueError, match="'tea' is not known"):
        table.look_up(thickness_cm=5, tea=1)
    with pytest.raises(ValueError, match="number of tally rays is 0, but must lie in 1024"):
        snowblue.Database.build(tally_rays=0)
    with pytest.raises(ValueError, match="preset"):
        snowblue.Database.build(preset="snow")


def test_albedo_is_inverted_within_its_standard_errors():
    nm = np.arange(400, 1401, 20)
    snow = dict(ssa_m2_kg=18, impurities_ng_g={"black-carbon": 300})
    true = snowblue.spectrum(thickness_cm=100, angle_deg="diffuse", wavelength_nm=nm, **snow)
    noisy = true.reflectance.squeeze(drop=True) + np.random.default_rng(1).normal(0, 0.004, nm.size)
    fit = snowblue.invert(noisy, standard_deviation=0.004)
    # Two numbers, each within 4 standard errors: 1e-4.
    assert abs(fit.ssa - 18) < 4 * fit.ssa_se and abs(fit.black_carbon - 300) < 4 * fit.black_carbon_se
    assert 0.4 < fit.chi_square_per_freedom < 2
    with pytest.raises(TypeError, match="wavelength_nm is missing"):
        snowblue.invert([0.9, 0.8])
    with pytest.raises(ValueError, match="shape"):
        snowblue.invert([0.9, 0.8], [400])
    with pytest.raises(ValueError, match="2 wavelengths for 2 parameters"):
        snowblue.invert([0.9, 0.8], [400, 500])
    with pytest.raises(ValueError, match="the albedo is -0.5 to 0.9"):
        snowblue.invert([0.9, 0.8, -0.5], [400, 500, 600])
    with pytest.raises(ValueError, match="above 0"):
        snowblue.invert([0.9, 0.8], [400, 500], standard_deviation=0)


def test_an_albedo_may_have_axes_of_one_value():
    nm = np.arange(400.0, 1401.0, 50.0)
    measured = snowblue.spectrum(
        ssa_m2_kg=[20, 30], thickness_cm=100, angle_deg="diffuse", wavelength_nm=nm, standard_errors=False).reflectance
    one = measured.isel(specific_surface_area=[0])
    plain = snowblue.invert(one.values.ravel(), nm, standard_deviation=0.01)
    errors = np.full(one.shape, 0.01)
    assert snowblue.invert(one, standard_deviation=errors).ssa.item() == plain.ssa.item()
    with pytest.raises(ValueError, match=r"the albedo has the shape \(2, 1, 1, 21\), but there are 21 wavelengths"):
        snowblue.invert(measured)
    with pytest.raises(ValueError, match=r"the standard deviation has the shape \(2,\), but there are 21 values"):
        snowblue.invert(one, standard_deviation=[0.01, 0.02])
