//! Snow from measured spectra of albedo, transmittance and fluxes at depth, by optimal estimation (Rodgers 2000,
//! *Inverse Methods for Atmospheric Sounding*, ch. 5).
//!
//! In the infrared the albedo of thick snow depends on the specific surface area, since light takes longer paths in the
//! ice of larger grains; in the visible it depends on impurities (Warren & Wiscombe 1980; Gallet et al. 2009,
//! doi:10.5194/tc-3-167-2009). The state has the logarithms of any [`Variable`](crate::Variable)s, or the log-odds of
//! fractions, with a normal prior. Its posterior says how well the data determine each of them. All packs are solved
//! together, each step of all in parallel, with exact derivatives.
//!
//! ```
//! use snowblue_transport::inversion::{Illumination, Inversion, Measured, Observation, Outcome, Prior, Quantity};
//! use snowblue_transport::ordinates::{OrdinatesOptions, solve_stack_without_errors};
//! use snowblue_transport::{GrainSize, Incidence, Layer, Property, SnowSample, Stack, Variable};
//!
//! let wavelengths_nm = vec![700.0, 900.0, 1030.0, 1240.0];
//! let incidence = Incidence::Beam { angle_deg: 60.0 };
//! let half_space = |sample| Layer::snow(sample, f64::INFINITY);
//! let grain_size = GrainSize::from_specific_surface_area(12.0, -5.0)?;
//! let truth = Stack {
//!     layers: vec![half_space(SnowSample { grain_size, ..SnowSample::default() })],
//!     ground_albedo: 0.0.into(),
//!     depths_cm: vec![],
//!     incidences: vec![incidence],
//!     wavelengths_nm: wavelengths_nm.clone(),
//! };
//! let options = OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() };
//! let solved = solve_stack_without_errors(&truth, &options)?;
//! let albedo = Measured {
//!     quantity: Quantity::Albedo,
//!     depths_cm: vec![],
//!     values: solved.iter().map(|row| row.whole.fluxes.reflectance.value).collect(),
//!     standard_deviations: vec![0.01; 4],
//!     scale_error: 0.0,
//!     correlation_nm: 0.0,
//! };
//! let inversion = Inversion {
//!     wavelengths_nm,
//!     bands: None,
//!     variables: vec![Variable::Snow(Property::SurfaceArea).into()],
//!     prior_covariance: vec![Prior::weak(Variable::Snow(Property::SurfaceArea)).deviation.powi(2)],
//!     options,
//! };
//! let observation = Observation {
//!     layers: vec![half_space(SnowSample::default())],
//!     ground_albedo: 0.0.into(),
//!     illumination: Illumination::Single(incidence),
//!     prior_medians: vec![20.0],
//!     measured: vec![albedo],
//! };
//! let found = &inversion.retrieve(&[observation], &|_| ())?[0];
//! assert!(found.outcome == Outcome::Converged && (found.values[0].median - 12.0).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! **Simplified.** Errors of the model are not added to the errors of the measurement. The posterior is normal in the
//! state, by the derivatives at its mode.

use std::collections::BTreeMap;
use std::fmt;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use snowblue_base::ParameterRange;

mod estimation;
mod measured;
mod model;
mod problem;
mod state;

pub use crate::error::InversionError;
use crate::variable::LayerVariable;
use estimation::{End, Knowledge, Posterior, Search};
use measured::Data;
pub use measured::{Measured, Quantity};
use model::Model;
pub use problem::{Illumination, Inversion, Observation};
pub use state::Prior;

/// Packs that are solved together: enough for all threads, while their fluxes take little memory.
const PACKS_AT_ONCE: usize = 256;
/// Half the width of a normal interval that holds 95 %, in standard deviations.
const HALF_WIDTH_OF_95_PERCENT: f64 = 1.959_963_984_540_054;

/// The posterior of a pack. Matrices belong to the logarithms or log-odds of the variables, row by row.
///
/// A variable at an end of its range, beyond which the cost falls, is held there. The posterior describes the other
/// variables, given this value: the rows of the held variable in the covariance and the averaging kernel are 0, and
/// its standard deviation is 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Retrieval {
    /// Posterior of each variable.
    pub values: Vec<Retrieved>,
    /// Covariance.
    pub covariance: Vec<f64>,
    /// Derivative of the retrieved state by the true state: the identity where the data determine all variables, 0
    /// where the result is the prior.
    pub averaging_kernel: Vec<f64>,
    /// Degrees of freedom for signal, the trace of the averaging kernel: how many variables the data determine.
    pub degrees_of_freedom: f64,
    /// Number of measured values.
    pub data: usize,
    /// Sum of the squared residuals in units of their errors.
    pub data_chi_square: f64,
    /// `data_chi_square` plus the squared distance from the prior. If model, errors and prior are right, the sum is
    /// distributed as χ² with as many degrees of freedom as there are data.
    pub chi_square: f64,
    /// Ratio of measured to true values, for each measured quantity.
    pub scales: Vec<Retrieved>,
    /// Each measured quantity in the retrieved snow, at each depth and wavelength or band. NaN where no pack has data,
    /// where the model of this snow does not hold, and where this pack has no data at all.
    pub fits: Vec<Vec<f64>>,
    /// Number of solutions of the equation of transfer.
    pub solutions: usize,
    /// How the search has ended.
    pub outcome: Outcome,
}

/// Posterior of a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Retrieved {
    /// Median, in the quantity's unit.
    pub median: f64,
    /// Standard deviation to first order, in the quantity's unit.
    pub standard_deviation: f64,
    /// Ends of the interval that holds the quantity with a probability of 95 %.
    pub interval: [f64; 2],
}

/// How a search has ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// At the most probable state.
    Converged,
    /// At the most probable state within the ranges; these variables are held, each at an end of its range, beyond
    /// which the cost falls.
    AtEndOfRange(Vec<LayerVariable>),
    /// Not at the most probable state.
    NotConverged,
    /// There are no measured values; the posterior is the prior.
    NoData,
}

/// A retrieval in work.
struct Task<'o> {
    number: usize,
    observation: &'o Observation,
    /// Data of each measured quantity.
    data: Vec<Data>,
    search: Search,
    /// The model at the best state so far.
    best: Option<Model>,
}

impl Inversion {
    /// Retrieves the state of each pack. `progress` is called from any thread with the number of packs done.
    ///
    /// # Errors
    /// For the first quantity that is missing, out of range or contradicts another.
    pub fn retrieve(
        &self,
        observations: &[Observation],
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<Vec<Retrieval>, InversionError> {
        let precision_root = self.check()?;
        let channels = self.channels();
        let mut used = vec![false; self.wavelengths_nm.len()];
        for (number, observation) in observations.iter().enumerate() {
            let own = self.check_observation(observation, &channels);
            let own = own.map_err(|error| InversionError { observation: Some(number), ..error })?;
            own.into_iter().for_each(|place| used[place] = true);
        }
        // Packs are solved together at the wavelengths of all of them at which the model of their snow holds.
        let mut groups: BTreeMap<Vec<usize>, Vec<(usize, &Observation)>> = BTreeMap::new();
        for (number, observation) in observations.iter().enumerate() {
            let holds = |place: &usize| used[*place] && self.check_place(observation, *place).is_ok();
            let places = (0..used.len()).filter(holds).collect();
            groups.entry(places).or_default().push((number, observation));
        }
        let mut done = Vec::with_capacity(observations.len());
        for (places, group) in &groups {
            self.prepare_tallies(group.iter().map(|(_, observation)| *observation), places);
            for chunk in group.chunks(PACKS_AT_ONCE) {
                let first = done.len();
                let found = self.solve(chunk, places, &precision_root, &|count| progress(first + count))?;
                done.extend(chunk.iter().map(|(number, _)| *number).zip(found));
            }
        }
        progress(observations.len());
        done.sort_by_key(|(number, _)| *number);
        Ok(done.into_iter().map(|(_, retrieval)| retrieval).collect())
    }

    /// Retrieves some packs together.
    fn solve(
        &self,
        observations: &[(usize, &Observation)],
        used: &[usize],
        precision_root: &DMatrix<f64>,
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<Vec<Retrieval>, InversionError> {
        let mut tasks: Vec<Task> =
            observations.iter().map(|(number, observation)| self.task(*number, observation, precision_root)).collect();
        loop {
            let mut active: Vec<&mut Task> =
                tasks.iter_mut().filter(|task| task.count() > 0 && !task.search.has_ended()).collect();
            if active.is_empty() {
                break;
            }
            let done = observations.len() - active.len();
            active.par_iter_mut().try_for_each(|task| {
                progress(done);
                let model = self.model(task.observation, &task.values(&self.variables), used);
                let model = model.map_err(|error| InversionError { observation: Some(task.number), ..error.into() })?;
                self.step(task, model);
                Ok::<(), InversionError>(())
            })?;
        }
        Ok(tasks.into_par_iter().map(|task| self.retrieval(task)).collect())
    }

    fn task<'o>(&self, number: usize, observation: &'o Observation, precision_root: &DMatrix<f64>) -> Task<'o> {
        let (channels, scale_errors) = (self.channels(), observation.scale_errors());
        let (n, all) = (self.variables.len(), self.variables.len() + scale_errors.len());
        let mut prior = Knowledge {
            mean: DVector::zeros(all),
            precision_root: DMatrix::zeros(all, all),
            least: DVector::from_element(all, f64::NEG_INFINITY),
            greatest: DVector::from_element(all, f64::INFINITY),
        };
        prior.precision_root.view_mut((0, 0), (n, n)).copy_from(precision_root);
        for (i, (by, median)) in self.variables.iter().zip(&observation.prior_medians).enumerate() {
            let ParameterRange { least, greatest, .. } = observation.range(by);
            prior.mean[i] = state::element(by.variable, *median);
            prior.least[i] = state::element(by.variable, least);
            prior.greatest[i] = state::element(by.variable, greatest);
        }
        for (i, scale_error) in scale_errors.iter().enumerate() {
            prior.precision_root[(n + i, n + i)] = scale_error.recip();
        }
        Task {
            number,
            observation,
            data: observation.measured.iter().map(|measured| measured.data(&channels)).collect(),
            search: Search::new(prior),
            best: None,
        }
    }

    /// Passes the residuals and derivatives of the model at the trial to the search.
    fn step(&self, task: &mut Task, model: Model) {
        let values = task.values(&self.variables);
        let n = self.variables.len();
        let trial = task.search.trial();
        let mut residuals = Vec::with_capacity(task.count());
        let mut columns = vec![Vec::with_capacity(task.count()); trial.len()];
        let (mut scale, mut row) = (n, 0);
        for (data, measured) in task.data.iter().zip(&task.observation.measured) {
            let has_scale = measured.scale_error > 0.0;
            let factor = if has_scale { trial[scale].exp() } else { 1.0 };
            let scaled = |place: usize| factor * model.value(row, place);
            residuals.extend(data.residuals(scaled));
            for (i, column) in columns.iter_mut().enumerate() {
                if i < n {
                    let slope = factor * state::slope(self.variables[i].variable, values[i]);
                    column.extend(data.derivatives(|place| slope * model.derivative(i, row, place)));
                } else if has_scale && i == scale {
                    column.extend(data.derivatives(scaled));
                } else {
                    column.extend(std::iter::repeat_n(0.0, data.len()));
                }
            }
            scale += usize::from(has_scale);
            row += measured.rows();
        }
        let jacobian = DMatrix::from_fn(residuals.len(), columns.len(), |i, j| columns[j][i]);
        if task.search.take(&DVector::from_vec(residuals), &jacobian) {
            task.best = Some(model);
        }
    }

    fn retrieval(&self, task: Task) -> Retrieval {
        let n = self.variables.len();
        let data = task.count();
        let mut first = 0;
        let mut fit = |measured: &Measured| -> Vec<f64> {
            let (channels, row) = (self.channels().len(), first);
            first += measured.rows();
            let value = |place: usize| task.best.as_ref().map_or(f64::NAN, |best| best.value(row, place));
            (0..measured.rows() * channels).map(value).collect()
        };
        let fits = task.observation.measured.iter().map(&mut fit).collect();
        let Posterior { state, covariance, averaging_kernel, data_cost, prior_cost, is_at_end, solutions, end } =
            task.search.posterior();
        let block = |matrix: &DMatrix<f64>| (0..n * n).map(|k| matrix[(k / n, k % n)]).collect();
        let deviation = |i: usize| covariance[(i, i)].sqrt();
        let held: Vec<LayerVariable> = self
            .variables
            .iter()
            .zip(&is_at_end)
            .filter_map(|(variable, is_at_end)| is_at_end.then_some(*variable))
            .collect();
        let retrieved = |(i, LayerVariable { variable, .. }): (usize, &LayerVariable)| {
            let at = |element: f64| state::value(*variable, element);
            let half_width = HALF_WIDTH_OF_95_PERCENT * deviation(i);
            let median = at(state[i]);
            Retrieved {
                median,
                standard_deviation: state::slope(*variable, median) * deviation(i),
                interval: [at(state[i] - half_width), at(state[i] + half_width)],
            }
        };
        let mut next = n;
        let mut scale = |measured: &Measured| {
            if measured.scale_error <= 0.0 {
                return Retrieved { median: 1.0, standard_deviation: 0.0, interval: [1.0; 2] };
            }
            let (element, deviation) = (state[next], deviation(next));
            next += 1;
            let ends = [-1.0, 1.0].map(|sign| (element + sign * HALF_WIDTH_OF_95_PERCENT * deviation).exp());
            Retrieved { median: element.exp(), standard_deviation: element.exp() * deviation, interval: ends }
        };
        Retrieval {
            values: self.variables.iter().enumerate().map(retrieved).collect(),
            covariance: block(&covariance),
            averaging_kernel: block(&averaging_kernel),
            degrees_of_freedom: (0..n).map(|i| averaging_kernel[(i, i)]).sum(),
            data,
            data_chi_square: data_cost,
            chi_square: data_cost + prior_cost,
            scales: task.observation.measured.iter().map(&mut scale).collect(),
            fits,
            solutions,
            outcome: match (data, end) {
                (0, _) => Outcome::NoData,
                (_, End::NotConverged) => Outcome::NotConverged,
                (_, End::Converged) if held.is_empty() => Outcome::Converged,
                (_, End::Converged) => Outcome::AtEndOfRange(held),
            },
        }
    }
}

impl Task<'_> {
    /// The number of measured values.
    fn count(&self) -> usize {
        self.data.iter().map(Data::len).sum()
    }

    /// The variables at the trial.
    fn values(&self, variables: &[LayerVariable]) -> Vec<f64> {
        let elements = self.search.trial().iter();
        variables.iter().zip(elements).map(|(by, element)| state::value(by.variable, *element)).collect()
    }
}

/// Formats as a sentence without a stop.
impl fmt::Display for Outcome {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Converged => out.write_str("converged"),
            Self::AtEndOfRange(held) => {
                let names: Vec<String> = held.iter().map(ToString::to_string).collect();
                let held = if names.len() == 1 { "is at an end of its range" } else { "are at ends of their ranges" };
                write!(out, "{} {held}", names.join(" and "))
            }
            Self::NotConverged => out.write_str("not converged"),
            Self::NoData => out.write_str("no data"),
        }
    }
}
