//! Snow from a measured albedo.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use snowblue_transport::inversion::{AlbedoModel, Fitted, MeasuredAlbedo, Pack, Scale};

use crate::arguments::{Ordinates, Snow};
use crate::work::{input, run};

/// A measured albedo, and its standard deviation at each wavelength.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Measured {
    wavelength_nm: Vec<f64>,
    albedo: Vec<f64>,
    standard_deviation: Vec<f64>,
}

/// The pack under the light of an overcast sky.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct GivenPack {
    snow: Snow,
    thickness_cm: f64,
    ground_albedo: f64,
    free_scale: bool,
}

/// The specific surface area and the black carbon that fit an albedo best, with the albedo of that snow.
#[pyfunction]
pub(crate) fn invert<'py>(
    py: Python<'py>,
    measured: Measured,
    pack: GivenPack,
    ordinates: Ordinates,
) -> PyResult<Bound<'py, PyDict>> {
    let snow = pack.snow.sample()?;
    let scale = if pack.free_scale { Scale::Free } else { Scale::Trusted };
    let pack = Pack { snow, thickness_cm: pack.thickness_cm, ground_albedo: pack.ground_albedo };
    let options = ordinates.options()?;
    let (fit, albedo) = run(py, None, move |_| {
        let model = AlbedoModel::new(&snow, &measured.wavelength_nm, &options).map_err(input)?;
        let values = measured.albedo.iter().zip(&measured.standard_deviation).enumerate();
        let points: Vec<MeasuredAlbedo> = values
            .map(|(wavelength, (albedo, deviation))| MeasuredAlbedo {
                wavelength,
                albedo: *albedo,
                standard_deviation: *deviation,
            })
            .collect();
        let fit = model.fit(&pack, &points, scale).map_err(input)?;
        let albedo = model.albedo(&pack, &fit.finding()).map_err(input)?;
        Ok((fit, albedo))
    })?;
    let dict = PyDict::new(py);
    for (name, Fitted { value, standard_error, block_error }) in
        [("ssa", fit.surface_area_m2_kg), ("black_carbon", fit.black_carbon_ng_g), ("scale", fit.scale)]
    {
        dict.set_item(name, value)?;
        dict.set_item(format!("{name}_se"), standard_error)?;
        dict.set_item(format!("{name}_block_se"), block_error)?;
    }
    dict.set_item("correlation", fit.area_carbon_correlation)?;
    dict.set_item("chi_square_per_freedom", fit.chi_square_per_freedom)?;
    dict.set_item("albedo", albedo)?;
    Ok(dict)
}
