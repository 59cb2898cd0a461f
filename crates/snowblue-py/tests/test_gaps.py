"""Gaps in maps and series: where an argument is missing, so are the results, and all others stay as they are."""

import numpy as np
import pandas as pd
import pytest
import snowblue
import xarray as xr

NM = [500, 900]


def hours() -> xr.Dataset:
    """A series with a missing surface area, and with nights."""
    return xr.Dataset({
        "ssa": ("time", [20.0, np.nan, 30.0, 40.0, 25.0]),
        "angle": ("time", [60.0, 50.0, 95.0, np.nan, 70.0]),
    })


@pytest.mark.parametrize("is_lazy", [False, True])
def test_missing_values_and_nights_are_missing(is_lazy):
    series = hours().chunk({"time": 2}) if is_lazy else hours()
    found = snowblue.spectrum(
        ssa_m2_kg=series.ssa, angle_deg=series.angle, thickness_cm=10, wavelength_nm=NM, jacobian="density_kg_m3")
    kept = hours().isel(time=[0, 4])
    expected = snowblue.spectrum(
        ssa_m2_kg=kept.ssa, angle_deg=kept.angle, thickness_cm=10, wavelength_nm=NM, jacobian="density_kg_m3")
    assert np.isnan(found.reflectance.isel(time=[1, 2, 3])).all()
    for name, values in expected.data_vars.items():
        np.testing.assert_array_equal(found[name].isel(time=[0, 4]), values)
    albedo = snowblue.albedo(ssa_m2_kg=series.ssa, angle_deg=series.angle, wavelength_nm=NM)
    assert np.isnan(albedo).all("wavelength").values.tolist() == [False, True, True, True, False]


def test_errors_name_the_row_of_all_rows():
    with pytest.raises(ValueError, match=r"density is 1200 kg/m³.*at density\[2\]$"):
        snowblue.spectrum(density_kg_m3=[300, np.nan, 1200], wavelength_nm=500)
    with pytest.raises(ValueError, match="95"):
        snowblue.spectrum(angle_deg=95, wavelength_nm=500)


def test_layers_have_nights_and_need_sizes():
    pack = [{"thickness_cm": 5, "ssa_m2_kg": 30}, {"thickness_cm": 20, "ssa_m2_kg": 10}]
    found = snowblue.layers(pack, angle_deg=[50, 95, np.nan], wavelength_nm=NM, depth_cm=[1])
    alone = snowblue.layers(pack, angle_deg=50, wavelength_nm=NM, depth_cm=[1])
    np.testing.assert_array_equal(found.isel(angle=[0]).down, alone.down)
    assert np.isnan(found.isel(angle=[1, 2]).reflectance).all()
    assert np.isnan(snowblue.layers(pack, angle_deg=[95], wavelength_nm=NM).reflectance).all()
    table = pd.DataFrame(pack)
    table.loc[1, "ssa_m2_kg"] = np.nan
    with pytest.raises(ValueError, match=r"ssa_m2_kg is NaN.*at layers\[1\]"):
        snowblue.layers(table, wavelength_nm=NM)
    table["snow"] = [None, "firn"]
    assert snowblue.layers(table, wavelength_nm=NM).reflectance.notnull().all()


def test_retrievals_have_gaps():
    series = hours()
    nm = np.arange(500, 1100, 100)
    truth = snowblue.albedo(ssa_m2_kg=20, wavelength_nm=nm, angle_deg=60)
    measured = truth.expand_dims(time=5).drop_vars("angle", errors="ignore").copy()
    found = snowblue.invert(
        measured, standard_deviation=0.01, retrieve="ssa_m2_kg", thickness_cm=np.inf,
        angle_deg=series.angle, ground_albedo=0.0)
    assert np.isnan(found.ssa).values.tolist() == [False, False, True, True, False]
    assert float(found.ssa[0]) == pytest.approx(20, rel=0.01)
    assert found.outcome.values[2] == ""


def test_brf_has_the_albedo_as_its_mean():
    nodes, weights = np.polynomial.legendre.leggauss(16)
    mu = 0.5 * (nodes + 1)
    azimuths = np.arange(0, 360, 15.0)
    pack = [{"thickness_cm": 1, "ssa_m2_kg": 40}, {"thickness_cm": np.inf, "ssa_m2_kg": 10}]
    arguments = {"angle_deg": [30, 70], "wavelength_nm": [500, 1030]}
    found = snowblue.brf(
        view_zenith_deg=np.degrees(np.arccos(mu)), view_azimuth_deg=azimuths, layers=pack, **arguments).brf
    assert found.dims == ("angle", "wavelength", "view_zenith", "view_azimuth")
    flux = (found.mean("view_azimuth") * (weights * mu)).sum("view_zenith")
    expected = snowblue.layers(pack, standard_errors=False, **arguments).reflectance
    np.testing.assert_allclose(flux, expected, rtol=3e-3)
    with pytest.raises(TypeError, match="belongs to the layers"):
        snowblue.brf(view_zenith_deg=0, layers=pack, ssa_m2_kg=20)
    with pytest.raises(ValueError, match="clear ice"):
        snowblue.brf(view_zenith_deg=0, layers=[{"kind": "ice", "thickness_cm": 1}])
