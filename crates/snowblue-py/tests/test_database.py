"""Tables."""

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


def test_look_ups_are_paired_along_shared_dimensions():
    table = snowblue.Database.embedded()
    pits = xr.Dataset({"size": ("pit", [150.0, 300.0]), "thick": ("pit", [5.0, 20.0]), "angle": ("pit", [0.0, 60.0])},
                      {"pit": ["ridge", "valley"]})
    paired = table.look_up(grain_size_um=pits["size"], thickness_cm=pits.thick, angle_deg=pits.angle,
                           density_kg_m3=[250, 350])
    assert paired.transmittance.dims == ("pit", "density", "wavelength") and paired.pit.values[1] == "valley"
    crossed = table.look_up(grain_size_um=[150, 300], thickness_cm=[5, 20], angle_deg=[0, 60], density_kg_m3=[250, 350])
    for name in ("transmittance", "reflectance"):
        for place in range(2):
            at = {"grain_size": place, "thickness": place, "angle": place}
            np.testing.assert_array_equal(paired[name][place], crossed[name].isel(at))


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
    gap = table.look_up(thickness_cm=[5, np.nan], density_kg_m3=[250, 300]).transmittance
    assert gap.sel(thickness=5).notnull().all() and gap.isel(thickness=1).isnull().all()
    with pytest.raises(ValueError, match=r"density is 950 kg/m³, .*, at pit\[1\]"):
        table.look_up(
            thickness_cm=xr.DataArray([5, 6], dims="pit"), density_kg_m3=xr.DataArray([300, 950], dims="pit"))
    with pytest.raises(ValueError, match="'tea' is not known"):
        table.look_up(thickness_cm=5, tea=1)
    with pytest.raises(ValueError, match="number of tally rays is 0, but must lie in 1024"):
        snowblue.Database.build(tally_rays=0)
    with pytest.raises(ValueError, match="preset"):
        snowblue.Database.build(preset="snow")
