//! Properties of a snow, and its single scattering.

use std::collections::BTreeMap;
use std::sync::Arc;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use snowblue_database::unit_in_files;
use snowblue_transport::medium::{Demand, GrainTallies, Medium, Population, TallyPlan};
use snowblue_transport::optics::{IceTable, OwnParticles, Substance};
use snowblue_transport::ordinates::OrdinatesOptions;
use snowblue_transport::sample::{self, Metamorphism, Property, SnowSample, TruncatedNormal, aged_surface_area_m2_kg};
use snowblue_transport::spread::Uncertainty;

use crate::arguments::{Column, GivenSnow};
use crate::work::{input, input_in_row, run};

/// What each parameter is, its limits and its default, by the names of the keyword arguments.
#[pyfunction]
pub(crate) fn parameters(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    for parameter in sample::parameters() {
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

/// The properties of snow that are numbers, without impurities: the name of the keyword argument, the name and the unit
/// in results, and whether fluxes have derivatives with respect to it.
#[pyfunction]
pub(crate) fn properties() -> Vec<(&'static str, &'static str, &'static str, bool)> {
    let plain = Property::all().filter(|property| !matches!(property, Property::Impurity(_)));
    plain.map(|one| (one.key(), one.name(), unit_in_files(one), one.has_derivative())).collect()
}

/// Names of impurities.
#[pyfunction]
pub(crate) fn substances() -> Vec<&'static str> {
    Substance::all().map(Substance::name).collect()
}

/// Declares a substance by the columns of its table, and returns its name.
#[pyfunction]
pub(crate) fn declare_substance(name: &str, mut columns: BTreeMap<String, Vec<f64>>) -> PyResult<&'static str> {
    let mut take = |key: &str| columns.remove(key).unwrap_or_default();
    let particles = OwnParticles {
        wavelength_nm: take("wavelength_nm"),
        extinction_m2_kg: take("extinction_m2_kg"),
        single_scattering_albedo: take("single_scattering_albedo"),
        asymmetry: take("asymmetry"),
        absorption_m2_kg: take("absorption_m2_kg"),
    };
    particles.declare(name).map(Substance::name).map_err(input)
}

/// Properties that may have a standard deviation, without impurities, by the names of the keyword arguments.
#[pyfunction]
pub(crate) fn uncertain_properties() -> Vec<&'static str> {
    Uncertainty::properties().filter(|one| !matches!(one, Property::Impurity(_))).map(Property::key).collect()
}

/// Several snows.
#[pyclass(frozen)]
pub(crate) struct Snows {
    pub(crate) samples: Arc<Vec<SnowSample>>,
}

#[pymethods]
impl Snows {
    /// `count` snows with the properties `fixed`, and with `columns` of values of others. An error has the row of the
    /// first wrong snow.
    #[new]
    fn new(fixed: GivenSnow, columns: BTreeMap<String, Column>, count: usize) -> PyResult<Self> {
        Ok(Self { samples: Arc::new(fixed.samples(&columns, count)?) })
    }

    /// The properties that all snows have in common, those of their kind and defaults included, by the names of the
    /// keyword arguments.
    fn common<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let Some((first, others)) = self.samples.split_first() else { return Ok(dict) };
        let mut common = values(first);
        for sample in others {
            let own = values(sample);
            common.retain(|property| own.contains(property));
        }
        for (key, value) in common {
            match value {
                Value::Number(number) => dict.set_item(key, number)?,
                Value::Numbers(numbers) => dict.set_item(key, numbers)?,
                Value::Word(word) => dict.set_item(key, word)?,
            }
        }
        Ok(dict)
    }
}

/// The value of a property of snow.
#[derive(PartialEq)]
enum Value {
    Number(f64),
    Numbers(Vec<f64>),
    Word(String),
}

/// All properties of a sample, and its identifier.
fn values(sample: &SnowSample) -> Vec<(&'static str, Value)> {
    let numbers = |distribution: &TruncatedNormal| {
        let TruncatedNormal { min, max, mean, standard_deviation } = *distribution;
        Value::Numbers(vec![min, max, mean, standard_deviation])
    };
    let size = &sample.grain_size;
    let value = |property: Property| {
        let value = match property {
            Property::GrainSize => Value::Numbers(vec![size.min_um, size.max_um]),
            Property::Facetness => numbers(&sample.facetness),
            Property::Sphericity => numbers(&sample.sphericity),
            Property::SurfaceArea => return None,
            Property::Impurity(_) if property.get(sample) <= 0.0 => return None,
            _ => Value::Number(property.get(sample)),
        };
        Some((property.key(), value))
    };
    let words = [("size_measure", size.measure.name()), ("ice", sample.ice.name()), ("snow_id", &sample.id())];
    let words = words.map(|(key, word)| (key, Value::Word(word.to_owned())));
    let plain = Property::all().filter(|property| !matches!(property, Property::Impurity(_)));
    let impurities = Substance::known().map(Property::Impurity);
    plain.chain(impurities).filter_map(value).chain(words).collect()
}

/// Specific surface areas of snow after each age in hours, in m²/kg, from those of new snow at each temperature. An
/// error of one has its row.
#[pyfunction]
pub(crate) fn aged_surface_area(
    py: Python<'_>,
    new_m2_kg: Vec<f64>,
    temperature_c: Vec<f64>,
    age_h: Vec<f64>,
    temperature_gradient: bool,
) -> PyResult<Bound<'_, PyArray1<f64>>> {
    let metamorphism = if temperature_gradient { Metamorphism::TemperatureGradient } else { Metamorphism::Isothermal };
    let rows = new_m2_kg.iter().zip(&temperature_c).zip(&age_h).enumerate();
    let aged = |(row, ((new, temperature), age)): (usize, ((&f64, &f64), &f64))| {
        aged_surface_area_m2_kg(*new, *temperature, *age, metamorphism).map_err(|error| input_in_row(error, row))
    };
    Ok(PyArray1::from_vec(py, rows.map(aged).collect::<PyResult<_>>()?))
}

/// The first and the last wavelength of the model, in nm.
#[pyfunction]
pub(crate) fn wavelength_range() -> (f64, f64) {
    let range = IceTable::default().wavelength_range();
    (range.first_nm, range.last_nm)
}

/// Extinction coefficient, co-albedo and moments of the phase function at each wavelength, the degree of the moments
/// running fastest.
#[pyfunction]
pub(crate) fn single_scattering<'py>(
    py: Python<'py>,
    snow: GivenSnow,
    wavelengths_nm: Vec<f64>,
    degree: usize,
    seed: u64,
) -> PyResult<Bound<'py, PyDict>> {
    let sample = snow.sample().map_err(input)?;
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
    wavelengths_nm.iter().map(|wavelength_nm| tallies.medium(sample, *wavelength_nm)).collect()
}
