//! What a snow is, and its single scattering.

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use snowblue_transport::medium::{Demand, GrainTallies, Medium, Population, TallyPlan};
use snowblue_transport::ordinates::OrdinatesOptions;
use snowblue_transport::parameters::PARAMETERS;
use snowblue_transport::sample::{SnowSample, TruncatedNormal};

use crate::arguments::Snow;
use crate::work::{input, run};

/// What each parameter is, its limits and its default, by the names of the keyword arguments.
#[pyfunction]
pub(crate) fn parameters(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    for parameter in PARAMETERS {
        let dict = PyDict::new(py);
        dict.set_item("title", parameter.title)?;
        dict.set_item("unit", parameter.range.unit)?;
        dict.set_item("least", parameter.range.least)?;
        dict.set_item("greatest", parameter.range.greatest)?;
        dict.set_item("default", parameter.default)?;
        dict.set_item("text", parameter.text)?;
        dict.set_item("effect", parameter.effect)?;
        dict.set_item("source", parameter.source)?;
        all.set_item(parameter.key, dict)?;
    }
    Ok(all)
}

/// All properties of a snow, those of its kind and defaults included, by the names of the keyword arguments.
#[pyfunction]
pub(crate) fn resolved<'py>(py: Python<'py>, snow: Snow) -> PyResult<Bound<'py, PyDict>> {
    let sample = snow.sample()?;
    let dict = PyDict::new(py);
    let numbers = |distribution: &TruncatedNormal| {
        [distribution.min, distribution.max, distribution.mean, distribution.standard_deviation]
    };
    dict.set_item("grain_size_um", [sample.grain_size.min_um, sample.grain_size.max_um])?;
    dict.set_item("size_measure", sample.grain_size.measure.name())?;
    dict.set_item("facetness", numbers(&sample.facetness))?;
    dict.set_item("sphericity", numbers(&sample.sphericity))?;
    dict.set_item("density_kg_m3", sample.density_kg_m3)?;
    dict.set_item("water_saturation", sample.water_saturation)?;
    for (substance, mass_fraction_ng_g) in sample.impurities.present() {
        dict.set_item(format!("{}_ng_g", substance.name().replace('-', "_")), mass_fraction_ng_g)?;
    }
    dict.set_item("temperature_c", sample.temperature_c)?;
    dict.set_item("ice", sample.ice.name())?;
    Ok(dict)
}

/// Extinction coefficient, co-albedo and moments of the phase function at each wavelength, the degree of the moments
/// running fastest.
#[pyfunction]
pub(crate) fn single_scattering<'py>(
    py: Python<'py>,
    snow: Snow,
    wavelengths_nm: Vec<f64>,
    degree: usize,
    seed: u64,
) -> PyResult<Bound<'py, PyDict>> {
    let sample = snow.sample()?;
    sample.check().map_err(input)?;
    for wavelength_nm in &wavelengths_nm {
        sample.check_wavelength(*wavelength_nm).map_err(input)?;
    }
    let media = run(py, None, move |_| Ok(media(&sample, &wavelengths_nm, degree, seed)))?;
    let dict = PyDict::new(py);
    let of = |value: fn(&Medium) -> f64| PyArray1::from_vec(py, media.iter().map(value).collect());
    dict.set_item("extinction", of(|medium| medium.extinction_per_m))?;
    dict.set_item("coalbedo", of(|medium| medium.scattering.one_minus_albedo))?;
    dict.set_item("asymmetry", of(|medium| medium.scattering.asymmetry()))?;
    let moments = media.iter().flat_map(|medium| medium.scattering.moments.iter().copied()).collect();
    dict.set_item("moments", PyArray1::from_vec(py, moments))?;
    Ok(dict)
}

fn media(sample: &SnowSample, wavelengths_nm: &[f64], degree: usize, seed: u64) -> Vec<Medium> {
    let plan = TallyPlan { degree, rays: OrdinatesOptions::default().tally_rays, seed };
    let demand = Demand::of_sample(sample, wavelengths_nm);
    let tallies = GrainTallies::new(&Population::of_sample(sample), &demand, &plan);
    wavelengths_nm.iter().map(|wavelength_nm| tallies.medium(sample, *wavelength_nm, None)).collect()
}
