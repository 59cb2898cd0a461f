//! Snow from measured spectra.

use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use snowblue_transport::inversion::{
    Illumination, Inversion, InversionError, Measured, Observation, Prior, Quantity, Retrieval, Retrieved,
};
use snowblue_transport::slab::Incidence;
use snowblue_transport::{GroundAlbedo, Layer, LayerVariable, ParameterRange, SnowSample, Variable, short_number};

use crate::arguments::{Angle, GivenGround, Ordinates};
use crate::snow::Snows;
use crate::spectra::GivenLayer;
use crate::work::{Control, input, input_at, input_in_row, run};

/// The known properties of each pack and its light, as in the cases of a spectrum, and the measured values.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct GivenPacks<'py> {
    thickness_cm: Vec<f64>,
    angle_deg: Vec<Angle>,
    ground_albedo: Vec<GivenGround>,
    wavelength_nm: Vec<f64>,
    /// The weights of the wavelengths in each band, if values are measured in bands.
    bands: Option<Vec<Vec<f64>>>,
    /// [pack][snow, thickness, angle, ground]
    places: PyReadonlyArray2<'py, i64>,
    /// The layers of all packs, in place of their snow and thickness.
    layers: Option<Vec<GivenLayer>>,
    /// [pack][wavelength]
    diffuse_fraction: Option<PyReadonlyArray2<'py, f64>>,
    measured: Vec<GivenMeasured<'py>>,
}

/// Measured values with their errors, [pack][depth and wavelength or band].
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct GivenMeasured<'py> {
    quantity: String,
    depth_cm: Vec<f64>,
    values: PyReadonlyArray2<'py, f64>,
    standard_deviation: PyReadonlyArray2<'py, f64>,
    scale_error: f64,
    correlation_nm: f64,
}

/// The retrieved parameters: their names, perhaps of one layer, and their names in the results; their prior, which is
/// weak where none is given; and options of the engine.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Unknowns<'py> {
    names: Vec<(String, Option<usize>)>,
    labels: Vec<String>,
    median: Vec<Option<f64>>,
    deviation: Vec<Option<f64>>,
    correlation: Option<PyReadonlyArray2<'py, f64>>,
    ordinates: Ordinates,
}

/// A number of each retrieval.
type Number = fn(&Retrieval) -> f64;

/// Numbers of each retrieval.
type Numbers<'a> = &'a dyn Fn(&Retrieval) -> &[f64];

/// A number of the posterior of a quantity.
type Aspect = fn(&Retrieved) -> f64;

const ASPECTS: [(&str, Aspect); 4] = [
    ("", |value| value.median),
    ("_sd", |value| value.standard_deviation),
    ("_lower", |value| value.interval[0]),
    ("_upper", |value| value.interval[1]),
];

/// The posterior of each pack: an array of all packs for each quantity and aspect, matrices row by row, and the prior
/// as it was used. An error of one pack has its row, and its wavelength or band if there is one.
#[pyfunction]
#[pyo3(signature = (snows, packs, unknowns, progress))]
pub(crate) fn invert<'py>(
    py: Python<'py>,
    snows: &Snows,
    packs: GivenPacks<'py>,
    unknowns: Unknowns<'py>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let variables = unknowns.variables()?;
    let priors = unknowns.priors(&variables)?;
    let inversion = Inversion {
        wavelengths_nm: packs.wavelength_nm.clone(),
        bands: packs.bands.clone(),
        prior_covariance: unknowns.covariance(&priors)?,
        variables: variables.clone(),
        options: unknowns.ordinates.options()?,
    };
    let measured: Vec<String> = packs.measured.iter().map(|measured| measured.quantity.clone()).collect();
    let given = packs.observations(&snows.samples, &variables, &priors)?;
    let count = given.len() as u64;
    let found = run(py, progress.as_ref(), move |control: &Control| {
        let found = inversion.retrieve(&given, &|done| control.set(done as u64, count));
        found.map_err(|error| {
            let InversionError { observation, wavelength, .. } = error;
            input_at(error, observation, wavelength)
        })
    })?;
    let dict = PyDict::new(py);
    let array = |of: &dyn Fn(&Retrieval) -> f64| PyArray1::from_vec(py, found.iter().map(of).collect());
    for (aspect, of) in ASPECTS {
        for (i, name) in unknowns.labels.iter().enumerate() {
            dict.set_item(format!("{name}{aspect}"), array(&|one| of(&one.values[i])))?;
        }
        for (i, name) in measured.iter().enumerate() {
            dict.set_item(format!("{name}_scale{aspect}"), array(&|one| of(&one.scales[i])))?;
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
    dict.set_item("covariance", several(&|one| &one.covariance))?;
    dict.set_item("averaging_kernel", several(&|one| &one.averaging_kernel))?;
    for (i, name) in measured.iter().enumerate() {
        dict.set_item(format!("{name}_fit"), several(&|one| &one.fits[i]))?;
    }
    dict.set_item("outcome", found.iter().map(|one| one.outcome.to_string()).collect::<Vec<_>>())?;
    dict.set_item("prior", priors.iter().map(|prior| (prior.median, prior.deviation)).collect::<Vec<_>>())?;
    Ok(dict)
}

impl Unknowns<'_> {
    fn variables(&self) -> PyResult<Vec<LayerVariable>> {
        let variable = |(name, layer): &(String, Option<usize>)| -> PyResult<LayerVariable> {
            let by = LayerVariable { variable: name.parse().map_err(input)?, layer: *layer };
            if layer.is_some() && !by.variable.is_of_layer() {
                return Err(input(format!("{name} belongs to no layer, but one is given")));
            }
            Ok(by)
        };
        self.names.iter().map(variable).collect()
    }

    fn priors(&self, variables: &[LayerVariable]) -> PyResult<Vec<Prior>> {
        if self.median.len() != variables.len() || self.deviation.len() != variables.len() {
            return Err(input("there is not one prior for each quantity"));
        }
        let given = self.median.iter().zip(&self.deviation);
        let prior = |(by, (median, deviation)): (&LayerVariable, (&Option<f64>, &Option<f64>))| {
            let weak = Prior::weak(by.variable);
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

impl GivenPacks<'_> {
    fn observations(
        &self,
        samples: &[SnowSample],
        variables: &[LayerVariable],
        priors: &[Prior],
    ) -> PyResult<Vec<Observation>> {
        let places = self.places.as_array();
        let count = places.nrows();
        let check = |array: &PyReadonlyArray2<f64>, of_pack: usize| {
            let is_whole = array.as_array().shape() == [count, of_pack];
            is_whole.then_some(()).ok_or_else(|| input("an array does not have all the values of each pack"))
        };
        let wavelengths = self.wavelength_nm.len();
        self.diffuse_fraction.as_ref().map_or(Ok(()), |fraction| check(fraction, wavelengths))?;
        let channels = self.bands.as_ref().map_or(wavelengths, Vec::len);
        for GivenMeasured { depth_cm, values, standard_deviation, .. } in &self.measured {
            let of_pack = depth_cm.len().max(1) * channels;
            check(values, of_pack).and_then(|()| check(standard_deviation, of_pack))?;
        }
        let layers = self.layers.as_ref().map(|layers| layers.iter().map(GivenLayer::layer).collect::<Result<_, _>>());
        let layers: Option<Vec<Layer>> = layers.transpose().map_err(input)?;
        let row = |array: &PyReadonlyArray2<f64>, number: usize| array.as_array().row(number).to_vec();
        let observation = |number: usize| -> PyResult<Observation> {
            let place = |column: usize, count: usize| {
                let place = usize::try_from(places[[number, column]]).ok().filter(|place| *place < count);
                place.ok_or_else(|| input(format!("pack {number} has a place that is not among the values")))
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
            let measured = |given: &GivenMeasured| -> PyResult<Measured> {
                Ok(Measured {
                    quantity: given.quantity.parse::<Quantity>().map_err(input)?,
                    depths_cm: given.depth_cm.clone(),
                    values: row(&given.values, number),
                    standard_deviations: row(&given.standard_deviation, number),
                    scale_error: given.scale_error,
                    correlation_nm: given.correlation_nm,
                })
            };
            let slab = || -> PyResult<Vec<Layer>> {
                let sample = samples[place(0, samples.len())?];
                Ok(vec![Layer::snow(sample, self.thickness_cm[place(1, self.thickness_cm.len())?])])
            };
            let mut observation = Observation {
                layers: layers.as_ref().map_or_else(slab, |layers| Ok(layers.clone()))?,
                ground_albedo: self.ground_albedo[place(3, self.ground_albedo.len())?]
                    .albedo()
                    .map_err(|error| input_in_row(error, number))?,
                illumination,
                prior_medians: Vec::new(),
                measured: self.measured.iter().map(measured).collect::<PyResult<_>>()?,
            };
            let median = |(by, prior): (&LayerVariable, &Prior)| {
                prior_median(&observation, by, prior).map_err(|text| input_at(text, Some(number), None))
            };
            observation.prior_medians = variables.iter().zip(priors).map(median).collect::<PyResult<_>>()?;
            Ok(observation)
        };
        (0..count).map(observation).collect()
    }
}

/// The median of a prior. If the prior has no median, the known value.
fn prior_median(observation: &Observation, by: &LayerVariable, prior: &Prior) -> Result<f64, String> {
    let known = observation.known(*by);
    if let Some(median) = prior.median {
        return Ok(median);
    }
    if by.layer.is_none() && by.variable.is_of_layer() && known.is_nan() {
        return Err(format!("the prior of {by} has no median, and the layers differ: give the prior a median"));
    }
    if by.variable == Variable::GroundAlbedo && matches!(observation.ground_albedo, GroundAlbedo::Spectrum(_)) {
        return Err("the prior of ground_albedo has no median, and the ground has a spectrum: give the prior a \
                    median"
            .to_owned());
    }
    let ParameterRange { least, greatest, .. } = observation.range(by);
    // A half-space and diffuse light are another error.
    if known.is_finite() && !(least..=greatest).contains(&known) {
        return Err(format!(
            "the prior of {by} has no median, and the snow's own value {} is not within {}–{}: give the prior a \
             median, or another value",
            short_number(known),
            short_number(least),
            short_number(greatest),
        ));
    }
    Ok(known)
}
