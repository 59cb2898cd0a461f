//! Snow from measured spectra.

use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use snowblue_transport::inversion::{
    Illumination, Inversion, InversionError, Measured, Prior, Retrieval, Retrieved, Spectrum, state_range,
};
use snowblue_transport::slab::Incidence;
use snowblue_transport::{ParameterRange, SnowSample, Variable, short_number};

use crate::arguments::{Angle, Ordinates};
use crate::snow::Snows;
use crate::work::{Control, input, input_at, run};

/// What is known of the snow of each spectrum, and the light: as in a spectrum's cases.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct GivenSpectra<'py> {
    thickness_cm: Vec<f64>,
    angle_deg: Vec<Angle>,
    ground_albedo: Vec<f64>,
    wavelength_nm: Vec<f64>,
    /// [spectrum][snow, thickness, angle, ground]
    places: PyReadonlyArray2<'py, i64>,
    /// [spectrum][wavelength]
    diffuse_fraction: Option<PyReadonlyArray2<'py, f64>>,
    albedo: Option<GivenMeasured<'py>>,
    transmittance: Option<GivenMeasured<'py>>,
}

/// Measured values with their errors, [spectrum][wavelength].
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct GivenMeasured<'py> {
    values: PyReadonlyArray2<'py, f64>,
    standard_deviation: PyReadonlyArray2<'py, f64>,
    scale_error: f64,
    correlation_nm: f64,
}

/// What is retrieved, its prior, which is weak where none is given, and options of the engine.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Unknowns<'py> {
    names: Vec<String>,
    median: Vec<Option<f64>>,
    deviation: Vec<Option<f64>>,
    correlation: Option<PyReadonlyArray2<'py, f64>>,
    ordinates: Ordinates,
}

/// A number of each retrieval.
type Number = fn(&Retrieval) -> f64;

/// Numbers of each retrieval.
type Numbers = fn(&Retrieval) -> &[f64];

/// What is known of a factor that all values of a spectrum have in common.
type Scale = fn(&Retrieval) -> &Retrieved;

/// A number of what is known of a quantity.
type Aspect = fn(&Retrieved) -> f64;

const ASPECTS: [(&str, Aspect); 4] = [
    ("", |value| value.median),
    ("_sd", |value| value.standard_deviation),
    ("_lower", |value| value.interval[0]),
    ("_upper", |value| value.interval[1]),
];

/// The posterior of each spectrum: an array of all spectra for each quantity and aspect, matrices row by row, and the
/// prior as it was used. An error of one spectrum has its row, and its wavelength if there is one.
#[pyfunction]
#[pyo3(signature = (snows, spectra, unknowns, progress))]
pub(crate) fn invert<'py>(
    py: Python<'py>,
    snows: &Snows,
    spectra: GivenSpectra<'py>,
    unknowns: Unknowns<'py>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let variables: Vec<Variable> =
        unknowns.names.iter().map(|name| name.parse().map_err(input)).collect::<PyResult<_>>()?;
    let priors = unknowns.priors(&variables)?;
    let inversion = Inversion {
        wavelengths_nm: spectra.wavelength_nm.clone(),
        prior_covariance: unknowns.covariance(&priors)?,
        variables: variables.clone(),
        options: unknowns.ordinates.options()?,
    };
    let measured: [(bool, (&str, Numbers, Scale)); 2] = [
        (spectra.albedo.is_some(), ("albedo", |one| &one.albedo, |one| &one.albedo_scale)),
        (spectra.transmittance.is_some(), ("transmittance", |one| &one.transmittance, |one| &one.transmittance_scale)),
    ];
    let measured: Vec<_> = measured.into_iter().filter(|(is_given, _)| *is_given).map(|(_, what)| what).collect();
    let given = spectra.spectra(&snows.samples, &variables, &priors)?;
    let count = given.len() as u64;
    let found = run(py, progress.as_ref(), move |control: &Control| {
        let found = inversion.retrieve(&given, &|done| control.set(done as u64, count));
        found.map_err(|InversionError { spectrum, wavelength, error }| input_at(error, spectrum, wavelength))
    })?;
    let dict = PyDict::new(py);
    let array = |of: &dyn Fn(&Retrieval) -> f64| PyArray1::from_vec(py, found.iter().map(of).collect());
    for (aspect, of) in ASPECTS {
        for (i, name) in unknowns.names.iter().enumerate() {
            dict.set_item(format!("{name}{aspect}"), array(&|one| of(&one.values[i])))?;
        }
        for (name, _, scale) in &measured {
            dict.set_item(format!("{name}_scale{aspect}"), array(&|one| of(scale(one))))?;
        }
    }
    let numbers: [(&str, Number); 5] = [
        ("degrees_of_freedom", |one| one.degrees_of_freedom),
        ("data", |one| one.data as f64),
        ("data_chi_square", |one| one.data_chi_square),
        ("chi_square", |one| one.chi_square),
        ("solutions", |one| one.solutions as f64),
    ];
    for (name, of) in numbers {
        dict.set_item(name, array(&of))?;
    }
    let several = |of: Numbers| PyArray1::from_vec(py, found.iter().flat_map(of).copied().collect());
    dict.set_item("covariance", several(|one| &one.covariance))?;
    dict.set_item("averaging_kernel", several(|one| &one.averaging_kernel))?;
    for (name, fit, _) in measured {
        dict.set_item(format!("{name}_fit"), several(fit))?;
    }
    dict.set_item("outcome", found.iter().map(|one| one.outcome.to_string()).collect::<Vec<_>>())?;
    dict.set_item("prior", priors.iter().map(|prior| (prior.median, prior.deviation)).collect::<Vec<_>>())?;
    Ok(dict)
}

impl Unknowns<'_> {
    fn priors(&self, variables: &[Variable]) -> PyResult<Vec<Prior>> {
        if self.median.len() != variables.len() || self.deviation.len() != variables.len() {
            return Err(input("there is not one prior for each quantity"));
        }
        let given = self.median.iter().zip(&self.deviation);
        let prior = |(variable, (median, deviation)): (&Variable, (&Option<f64>, &Option<f64>))| {
            let weak = Prior::weak(*variable);
            Prior { median: median.or(weak.median), deviation: deviation.unwrap_or(weak.deviation) }
        };
        Ok(variables.iter().zip(given).map(prior).collect())
    }

    /// Covariance of the prior, row by row.
    fn covariance(&self, priors: &[Prior]) -> PyResult<Vec<f64>> {
        let n = priors.len();
        let correlations = self.correlation.as_ref().map(PyReadonlyArray2::as_array);
        if correlations.is_some_and(|given| given.shape() != [n, n]) {
            return Err(input(format!("the correlation of the prior must have {n} rows and {n} columns")));
        }
        let correlation = |i: usize, j: usize| match &correlations {
            Some(given) => given[[i, j]],
            None => f64::from(u8::from(i == j)),
        };
        for (i, j) in (0..n * n).map(|k| (k / n, k % n)) {
            let (value, mirrored) = (correlation(i, j), correlation(j, i));
            let rule = if i == j && (value - 1.0).abs() > 0.0 {
                "must be 1".to_owned()
            } else if !(-1.0..=1.0).contains(&value) {
                "must lie in -1–1".to_owned()
            } else if (value - mirrored).abs() > 0.0 {
                format!("is {mirrored} in row {} and column {}", j + 1, i + 1)
            } else {
                continue;
            };
            let place = format!("row {} and column {}", i + 1, j + 1);
            return Err(input(format!("the correlation of the prior is {value} in {place}, but {rule}")));
        }
        // The product of deviations comes first, so that a symmetric correlation gives a symmetric covariance.
        let entry = |k: usize| {
            let (i, j) = (k / n, k % n);
            correlation(i, j) * (priors[i].deviation * priors[j].deviation)
        };
        Ok((0..n * n).map(entry).collect())
    }
}

impl GivenSpectra<'_> {
    fn spectra(&self, samples: &[SnowSample], variables: &[Variable], priors: &[Prior]) -> PyResult<Vec<Spectrum>> {
        let places = self.places.as_array();
        let count = places.nrows();
        let measured = [&self.albedo, &self.transmittance].into_iter().flatten();
        let arrays = measured.flat_map(|given| [&given.values, &given.standard_deviation]);
        for array in arrays.chain(&self.diffuse_fraction) {
            if array.as_array().shape() != [count, self.wavelength_nm.len()] {
                return Err(input("an array does not have a value for each spectrum and wavelength"));
            }
        }
        let row = |array: &PyReadonlyArray2<f64>, number: usize| array.as_array().row(number).to_vec();
        let spectrum = |number: usize| -> PyResult<Spectrum> {
            let place = |column: usize, count: usize| {
                let place = usize::try_from(places[[number, column]]).ok().filter(|place| *place < count);
                place.ok_or_else(|| input(format!("spectrum {number} has a place that is not among the values")))
            };
            let incidence = self.angle_deg[place(2, self.angle_deg.len())?].incidence()?;
            let illumination = match (&self.diffuse_fraction, incidence) {
                (None, incidence) => Illumination::Single(incidence),
                (Some(fractions), Incidence::Beam { angle_deg }) => {
                    Illumination::Mixed { angle_deg, diffuse_fractions: row(fractions, number) }
                }
                (Some(_), Incidence::Diffuse) => {
                    return Err(input_at("diffuse_fraction needs the angle of a beam", Some(number), None));
                }
            };
            let measured = |given: &Option<GivenMeasured>| {
                given.as_ref().map(|given| Measured {
                    values: row(&given.values, number),
                    standard_deviations: row(&given.standard_deviation, number),
                    scale_error: given.scale_error,
                    correlation_nm: given.correlation_nm,
                })
            };
            let mut spectrum = Spectrum {
                snow: samples[place(0, samples.len())?],
                thickness_cm: self.thickness_cm[place(1, self.thickness_cm.len())?],
                ground_albedo: self.ground_albedo[place(3, self.ground_albedo.len())?],
                illumination,
                prior_medians: Vec::new(),
                albedo: measured(&self.albedo),
                transmittance: measured(&self.transmittance),
            };
            let median = |(variable, prior): (&Variable, &Prior)| {
                let known = spectrum.known(*variable);
                let ParameterRange { least, greatest, .. } = state_range(*variable);
                // A half-space and diffuse light are another error.
                if prior.median.is_none() && known.is_finite() && !(least..=greatest).contains(&known) {
                    let text = format!(
                        "the prior of {variable} has no median, and the snow's own value {} is not within {}–{}: give \
                         the prior a median, or another value",
                        short_number(known),
                        short_number(least),
                        short_number(greatest),
                    );
                    return Err(input_at(text, Some(number), None));
                }
                Ok(prior.median.unwrap_or(known))
            };
            spectrum.prior_medians = variables.iter().zip(priors).map(median).collect::<PyResult<_>>()?;
            Ok(spectrum)
        };
        (0..count).map(spectrum).collect()
    }
}
