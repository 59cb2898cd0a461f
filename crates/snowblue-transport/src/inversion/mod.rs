//! Snow from measured spectra of albedo and transmittance, by optimal estimation (Rodgers 2000, *Inverse Methods for
//! Atmospheric Sounding*, ch. 5).
//!
//! In the infrared the albedo of thick snow depends on the specific surface area, since light takes longer paths in the
//! ice of larger grains; in the visible it depends on impurities (Warren & Wiscombe 1980; Gallet et al. 2009,
//! doi:10.5194/tc-3-167-2009). The state has the logarithms of any [`Variable`]s, or the log-odds of fractions, with a
//! normal prior. Its posterior says how well the data determine each of them. All spectra are solved together, each
//! step of all in one batch, with the exact derivatives of [`differentiate_batch`].
//!
//! ```
//! use snowblue_transport::batch::{Batch, SlabCase};
//! use snowblue_transport::inversion::{Illumination, Inversion, Measured, Outcome, Prior, Spectrum};
//! use snowblue_transport::ordinates::{OrdinatesOptions, solve_batch};
//! use snowblue_transport::{GrainSize, Incidence, SnowSample, Variable};
//!
//! let wavelengths_nm = vec![700.0, 900.0, 1030.0, 1240.0];
//! let incidence = Incidence::Beam { angle_deg: 60.0 };
//! let grain_size = GrainSize::from_specific_surface_area(12.0, -5.0)?;
//! let case = SlabCase { sample: 0, thickness_cm: f64::INFINITY, incidence, ground_albedo: 0.0 };
//! let snow = SnowSample { grain_size, ..SnowSample::default() };
//! let truth = Batch { samples: vec![snow], cases: vec![case], wavelengths_nm: wavelengths_nm.clone() };
//! let options = OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() };
//! let solved = solve_batch(&truth, &options, false, &|_| ())?;
//! let measured = Measured {
//!     values: solved.iter().map(|row| row.reflectance.value).collect(),
//!     standard_deviations: vec![0.01; 4],
//!     scale_error: 0.0,
//!     correlation_nm: 0.0,
//! };
//! let inversion = Inversion {
//!     wavelengths_nm,
//!     variables: vec![Variable::SurfaceArea],
//!     prior_covariance: vec![Prior::weak(Variable::SurfaceArea).deviation.powi(2)],
//!     options,
//! };
//! let spectrum = Spectrum {
//!     snow: SnowSample::default(),
//!     thickness_cm: f64::INFINITY,
//!     ground_albedo: 0.0,
//!     illumination: Illumination::Single(incidence),
//!     prior_medians: vec![20.0],
//!     albedo: Some(measured),
//!     transmittance: None,
//! };
//! let found = &inversion.retrieve(&[spectrum], &|_| ())?[0];
//! assert!(found.outcome == Outcome::Converged && (found.values[0].median - 12.0).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! **Simplified.** One homogeneous layer of snow. Errors of the model are not added to those of the measurement. The
//! posterior is normal in the state, by the derivatives at its mode.

use std::collections::BTreeMap;
use std::fmt;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use snowblue_base::ParameterRange;

mod error;
mod estimation;
mod measured;
mod state;

use crate::TransportError;
use crate::batch::{Batch, BatchError, CaseFluxes, SlabCase};
use crate::medium::{Demand, GrainTallies, Population};
use crate::optics::Substance;
use crate::ordinates::{DifferentiatedFluxes, OrdinatesOptions, Peak, differentiate_batch};
use crate::sample::{GrainSize, SURFACE_AREA_RANGE, SnowSample};
use crate::slab::{FluxDerivatives, Incidence, check_incidences, check_thickness, check_wavelengths};
use crate::stack::GROUND_ALBEDO_RANGE;
use crate::variable::Variable;
pub use error::InversionError;
use estimation::{End, Knowledge, Posterior, Search};
pub use measured::Measured;
use measured::{ALBEDO_DEVIATION_RANGE, Data, TRANSMITTANCE_DEVIATION_RANGE};
pub use state::{Prior, state_range};

/// Range of a measured albedo. White references err, and so does a dark signal.
const ALBEDO_RANGE: ParameterRange = ParameterRange { quantity: "albedo", least: -0.5, greatest: 1.5, unit: "" };
/// Range of a measured transmittance, which exceeds 1 over a bright ground, but hardly 1.3. Percent are out of range.
const TRANSMITTANCE_RANGE: ParameterRange =
    ParameterRange { quantity: "transmittance", least: -0.5, greatest: 2.0, unit: "" };
const DIFFUSE_FRACTION_RANGE: ParameterRange =
    ParameterRange { quantity: "diffuse fraction", least: 0.0, greatest: 1.0, unit: "" };
const PRIOR_DEVIATION_RANGE: ParameterRange =
    ParameterRange { quantity: "standard deviation", least: 1e-6, greatest: 100.0, unit: "" };
/// Spectra that are solved together: enough for all threads, while their fluxes take little memory.
const SPECTRA_AT_ONCE: usize = 256;
/// An angle that takes the streams of grazing light.
const GRAZING_DEG: f64 = 89.0;
/// Half the width of a normal interval that holds 95 %, in standard deviations.
const HALF_WIDTH_OF_95_PERCENT: f64 = 1.959_963_984_540_054;

/// What is to be retrieved from spectra at the same wavelengths, and how well it is known beforehand.
#[derive(Debug, Clone, PartialEq)]
pub struct Inversion {
    /// Wavelengths, in nm.
    pub wavelengths_nm: Vec<f64>,
    /// What is to be retrieved. With the surface area, the grains have one optical diameter.
    pub variables: Vec<Variable>,
    /// Covariance of the prior, row by row, of the logarithms of the variables, or the log-odds of saturation, cosine
    /// and ground albedo.
    pub prior_covariance: Vec<f64>,
    /// Options of the engine.
    pub options: OrdinatesOptions,
}

/// Measured spectra of one snow, and what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// The snow; what is retrieved of it is ignored.
    pub snow: SnowSample,
    /// Thickness, in cm; infinity for a half-space.
    pub thickness_cm: f64,
    /// Albedo of the Lambertian ground.
    pub ground_albedo: f64,
    /// Light on the snow.
    pub illumination: Illumination,
    /// Median of the prior of each variable, in its unit.
    pub prior_medians: Vec<f64>,
    /// The fraction of the light that the snow and the ground reflect.
    pub albedo: Option<Measured>,
    /// The fraction of the light that arrives at the ground.
    pub transmittance: Option<Measured>,
}

/// Light on the snow.
#[derive(Debug, Clone, PartialEq)]
pub enum Illumination {
    /// A beam or Lambertian light.
    Single(Incidence),
    /// The beam of the sun with Lambertian light.
    Mixed {
        /// Angle of the beam from the normal, in degrees.
        angle_deg: f64,
        /// Fraction of the irradiance that is diffuse, at each wavelength.
        diffuse_fractions: Vec<f64>,
    },
}

/// The posterior of a spectrum. Matrices are those of the logarithms or log-odds of the variables, row by row.
///
/// A variable at an end of its range, beyond which the cost falls, is held there. The posterior is that of the others
/// given this value: the rows of the held one in the covariance and the averaging kernel are 0, and so is its
/// deviation.
#[derive(Debug, Clone, PartialEq)]
pub struct Retrieval {
    /// What is known of each variable.
    pub values: Vec<Retrieved>,
    /// Covariance.
    pub covariance: Vec<f64>,
    /// Derivative of the retrieved state by the true one: the identity where the data determine all, 0 where the
    /// result is that of the prior.
    pub averaging_kernel: Vec<f64>,
    /// Degrees of freedom for signal, the trace of the averaging kernel: how many variables the data determine.
    pub degrees_of_freedom: f64,
    /// Number of values in the spectra.
    pub data: usize,
    /// Sum of the squared residuals in units of their errors.
    pub data_chi_square: f64,
    /// The same with the squared distance from the prior; it is distributed as χ² with as many degrees of freedom as
    /// there are data if model, errors and prior are right.
    pub chi_square: f64,
    /// Measured over true albedo.
    pub albedo_scale: Retrieved,
    /// Measured over true transmittance.
    pub transmittance_scale: Retrieved,
    /// Albedo of the retrieved snow at each wavelength. NaN where no spectrum has data, where the model of this snow
    /// does not hold, and where this spectrum has no data at all.
    pub albedo: Vec<f64>,
    /// The same for the transmittance.
    pub transmittance: Vec<f64>,
    /// Number of solutions of the equation of transfer.
    pub solutions: usize,
    /// How the search has ended.
    pub outcome: Outcome,
}

/// What is known of a quantity.
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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// At the most probable state.
    Converged,
    /// At the most probable state within the ranges; this variable is held at an end of its range, beyond which the
    /// cost falls.
    AtEndOfRange(Variable),
    /// Not at the most probable state.
    NotConverged,
    /// The spectrum has no values; the posterior is the prior.
    NoData,
}

/// A spectrum in work.
struct Task<'s> {
    number: usize,
    spectrum: &'s Spectrum,
    albedo: Option<Data>,
    transmittance: Option<Data>,
    search: Search,
    /// Reflectance and transmittance at the best state so far, at each wavelength that is solved at.
    best: Vec<[f64; 2]>,
}

impl Inversion {
    /// Retrieves the state of each spectrum. `progress` is called from any thread with the number of spectra done.
    ///
    /// # Errors
    /// For the first quantity that is missing, out of range or contradicts another.
    pub fn retrieve(
        &self,
        spectra: &[Spectrum],
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<Vec<Retrieval>, InversionError> {
        let precision_root = self.check()?;
        let mut used = vec![false; self.wavelengths_nm.len()];
        for (number, spectrum) in spectra.iter().enumerate() {
            let own = self.check_spectrum(spectrum);
            let own = own.map_err(|error| InversionError { spectrum: Some(number), ..error })?;
            own.into_iter().for_each(|place| used[place] = true);
        }
        // Spectra are solved together at the wavelengths of all of them at which the model of their snow holds.
        let mut groups: BTreeMap<Vec<usize>, Vec<(usize, &Spectrum)>> = BTreeMap::new();
        for (number, spectrum) in spectra.iter().enumerate() {
            let holds = |place: &usize| used[*place] && self.check_place(spectrum, *place).is_ok();
            let places = (0..used.len()).filter(holds).collect();
            groups.entry(places).or_default().push((number, spectrum));
        }
        let mut done = Vec::with_capacity(spectra.len());
        for (places, group) in &groups {
            self.prepare_tallies(group, places);
            for chunk in group.chunks(SPECTRA_AT_ONCE) {
                let first = done.len();
                let found = self.solve(chunk, places, &precision_root, &|count| progress(first + count))?;
                done.extend(chunk.iter().map(|(number, _)| *number).zip(found));
            }
        }
        progress(spectra.len());
        done.sort_by_key(|(number, _)| *number);
        Ok(done.into_iter().map(|(_, retrieval)| retrieval).collect())
    }

    /// Checks what all spectra have in common, and gives the root of the inverse covariance of the prior.
    fn check(&self) -> Result<DMatrix<f64>, InversionError> {
        let Self { wavelengths_nm, variables, prior_covariance, options } = self;
        options.streams.check()?;
        if wavelengths_nm.is_empty() {
            return Err(TransportError::Missing { quantity: "wavelength" }.into());
        }
        let n = variables.len();
        if n == 0 {
            return Err(TransportError::Missing { quantity: "quantity to retrieve" }.into());
        }
        for (place, variable) in variables.iter().enumerate() {
            if variables[..place].contains(variable) {
                return Err(combination(variable.name(), "is to be retrieved twice").into());
            }
        }
        if prior_covariance.len() != n * n {
            let (quantity, count) = ("covariance of the prior", prior_covariance.len());
            return Err(TransportError::Count { quantity, count, expected: "those of a row for each variable" }.into());
        }
        let covariance = DMatrix::from_row_slice(n, n, prior_covariance);
        for (variable, variance) in variables.iter().zip(covariance.diagonal().iter()) {
            let check = PRIOR_DEVIATION_RANGE.check(variance.sqrt());
            check.map_err(|error| TransportError::Prior { parameter: variable.name(), error })?;
        }
        let is_symmetric = covariance == covariance.transpose();
        estimation::precision_root(&covariance)
            .filter(|_| is_symmetric)
            .ok_or_else(|| combination("covariance of the prior", "must be symmetric and positive definite").into())
    }

    /// Checks a spectrum, and gives the wavelengths at which it has data.
    fn check_spectrum(&self, spectrum: &Spectrum) -> Result<Vec<usize>, InversionError> {
        let Spectrum { snow, thickness_cm, ground_albedo, illumination, prior_medians, albedo, transmittance } =
            spectrum;
        snow.check()?;
        check_thickness(*thickness_cm)?;
        GROUND_ALBEDO_RANGE.check(*ground_albedo)?;
        check_incidences(&illumination.incidences())?;
        if let Illumination::Mixed { diffuse_fractions, .. } = illumination
            && diffuse_fractions.len() != self.wavelengths_nm.len()
        {
            let (quantity, count) = (DIFFUSE_FRACTION_RANGE.quantity, diffuse_fractions.len());
            let expected = "as many as there are wavelengths";
            return Err(TransportError::Count { quantity, count, expected }.into());
        }
        if prior_medians.len() != self.variables.len() {
            let (quantity, count) = ("median of the prior", prior_medians.len());
            return Err(TransportError::Count { quantity, count, expected: "one for each variable" }.into());
        }
        for (variable, median) in self.variables.iter().zip(prior_medians) {
            match variable {
                Variable::Thickness if thickness_cm.is_infinite() => {
                    return Err(combination("thickness", "cannot be retrieved for a half-space").into());
                }
                Variable::CosIncidence if matches!(illumination, Illumination::Single(Incidence::Diffuse)) => {
                    return Err(combination("angle", "cannot be retrieved under diffuse light").into());
                }
                _ => {
                    let check = state_range(*variable).check(*median);
                    check.map_err(|error| TransportError::Prior { parameter: variable.name(), error })?;
                }
            }
        }
        let ranges = [(ALBEDO_RANGE, ALBEDO_DEVIATION_RANGE), (TRANSMITTANCE_RANGE, TRANSMITTANCE_DEVIATION_RANGE)];
        for (measured, (values, deviations)) in [albedo, transmittance].into_iter().zip(ranges) {
            if let Some(measured) = measured {
                measured.check(&values, &deviations, &self.wavelengths_nm)?;
            }
        }
        let has_transmittance = transmittance.as_ref().is_some_and(|measured| measured.present().next().is_some());
        if has_transmittance && thickness_cm.is_infinite() {
            return Err(combination("transmittance", "needs a thickness that is finite").into());
        }
        let has_data = |place: &usize| spectrum.measured().any(|measured| !measured.values[*place].is_nan());
        let own: Vec<usize> = (0..self.wavelengths_nm.len()).filter(has_data).collect();
        for place in &own {
            let check = self.check_place(spectrum, *place);
            check.map_err(|error| InversionError::at_wavelength(*place, error))?;
        }
        Ok(own)
    }

    /// Checks that the model of a spectrum's snow and light holds at a wavelength.
    fn check_place(&self, spectrum: &Spectrum, place: usize) -> Result<(), TransportError> {
        if let Illumination::Mixed { diffuse_fractions, .. } = &spectrum.illumination {
            DIFFUSE_FRACTION_RANGE.check(diffuse_fractions[place])?;
        }
        let wavelength_nm = self.wavelengths_nm[place];
        check_wavelengths(&[wavelength_nm], &spectrum.snow)?;
        self.variables.iter().try_for_each(|variable| variable.check_wavelength(wavelength_nm))
    }

    /// Traces the rays that serve all steps: those of the coarsest grains. The process keeps them.
    fn prepare_tallies(&self, spectra: &[(usize, &Spectrum)], used: &[usize]) {
        if !self.variables.contains(&Variable::SurfaceArea) || used.is_empty() {
            return;
        }
        let wavelengths_nm: Vec<f64> = used.iter().map(|place| self.wavelengths_nm[*place]).collect();
        let mut known: Vec<SnowSample> = Vec::new();
        for (_, spectrum) in spectra {
            let coarsest = with(&spectrum.snow, Variable::SurfaceArea, SURFACE_AREA_RANGE.least);
            if known.iter().any(|sample| sample.has_grains_of(&coarsest)) {
                continue;
            }
            known.push(coarsest);
            let is_wet = self.variables.contains(&Variable::WaterSaturation);
            let adds_peak = is_wet || self.variables.contains(&Variable::MassFraction(Substance::SnowAlgae));
            let peak = if adds_peak { Peak::Sharp } else { Peak::of(&coarsest) };
            let mut incidences = spectrum.illumination.incidences();
            if self.variables.contains(&Variable::CosIncidence) {
                incidences.push(Incidence::Beam { angle_deg: GRAZING_DEG });
            }
            let demand = Demand::of_sample(&coarsest, &wavelengths_nm);
            let demand = Demand { wet: demand.wet || is_wet, ..demand };
            let plan = self.options.plan(&incidences, peak);
            drop(GrainTallies::new(&Population::of_sample(&coarsest), &demand, &plan));
        }
    }

    /// Retrieves some spectra together.
    fn solve(
        &self,
        spectra: &[(usize, &Spectrum)],
        used: &[usize],
        precision_root: &DMatrix<f64>,
        progress: &(dyn Fn(usize) + Sync),
    ) -> Result<Vec<Retrieval>, InversionError> {
        let mut tasks: Vec<Task> =
            spectra.iter().map(|(number, spectrum)| self.task(*number, spectrum, precision_root)).collect();
        loop {
            let mut active: Vec<&mut Task> =
                tasks.iter_mut().filter(|task| task.data() > 0 && !task.search.has_ended()).collect();
            let done = spectra.len() - active.len();
            if active.is_empty() {
                break;
            }
            let (batch, cases) = self.batch(&active, used);
            let solved = differentiate_batch(&batch, &self.variables, &self.options, false, &|_| progress(done));
            let solved = solved.map_err(|BatchError { case, error }| {
                let task = case.and_then(|case| cases.iter().rposition(|first| *first <= case));
                InversionError { spectrum: task.map(|task| active[task].number), wavelength: None, error }
            })?;
            active.par_iter_mut().zip(&cases).for_each(|(task, case)| self.step(task, &solved, *case, used));
        }
        Ok(tasks.into_par_iter().map(|task| self.retrieval(task, used)).collect())
    }

    fn task<'s>(&self, number: usize, spectrum: &'s Spectrum, precision_root: &DMatrix<f64>) -> Task<'s> {
        let scale_errors = spectrum.scale_errors();
        let (n, all) = (self.variables.len(), self.variables.len() + scale_errors.len());
        let mut prior = Knowledge {
            mean: DVector::zeros(all),
            precision_root: DMatrix::zeros(all, all),
            least: DVector::from_element(all, f64::NEG_INFINITY),
            greatest: DVector::from_element(all, f64::INFINITY),
        };
        prior.precision_root.view_mut((0, 0), (n, n)).copy_from(precision_root);
        for (i, (variable, median)) in self.variables.iter().zip(&spectrum.prior_medians).enumerate() {
            let ParameterRange { least, greatest, .. } = state_range(*variable);
            prior.mean[i] = state::element(*variable, *median);
            prior.least[i] = state::element(*variable, least);
            prior.greatest[i] = state::element(*variable, greatest);
        }
        for (i, scale_error) in scale_errors.iter().enumerate() {
            prior.precision_root[(n + i, n + i)] = scale_error.recip();
        }
        let data = |measured: &Option<Measured>| measured.as_ref().map(|measured| measured.data(&self.wavelengths_nm));
        Task {
            number,
            spectrum,
            albedo: data(&spectrum.albedo),
            transmittance: data(&spectrum.transmittance),
            search: Search::new(prior),
            best: Vec::new(),
        }
    }

    /// The slabs at the trials of some searches, and the first case of each.
    fn batch(&self, tasks: &[&mut Task], used: &[usize]) -> (Batch, Vec<usize>) {
        let mut batch = Batch {
            samples: Vec::with_capacity(tasks.len()),
            cases: Vec::with_capacity(tasks.len()),
            wavelengths_nm: used.iter().map(|place| self.wavelengths_nm[*place]).collect(),
        };
        let mut first = Vec::with_capacity(tasks.len());
        for task in tasks {
            first.push(batch.cases.len());
            let (sample, cases) = self.slabs(task.spectrum, &task.values(&self.variables), batch.samples.len());
            batch.samples.push(sample);
            batch.cases.extend(cases);
        }
        (batch, first)
    }

    /// The snow of a spectrum with some values of the variables, and its slab under each light.
    fn slabs(&self, spectrum: &Spectrum, values: &[f64], place: usize) -> (SnowSample, Vec<SlabCase>) {
        let mut sample = spectrum.snow;
        let (mut thickness_cm, mut ground_albedo) = (spectrum.thickness_cm, spectrum.ground_albedo);
        let mut incidences = spectrum.illumination.incidences();
        for (variable, value) in self.variables.iter().zip(values) {
            match variable {
                Variable::Thickness => thickness_cm = *value,
                Variable::GroundAlbedo => ground_albedo = *value,
                Variable::CosIncidence => incidences[0] = Incidence::Beam { angle_deg: value.acos().to_degrees() },
                _ => sample = with(&sample, *variable, *value),
            }
        }
        let case = |incidence| SlabCase { sample: place, thickness_cm, incidence, ground_albedo };
        (sample, incidences.into_iter().map(case).collect())
    }

    /// Gives a search what has been solved, from its first case.
    fn step(&self, task: &mut Task, solved: &DifferentiatedFluxes, case: usize, used: &[usize]) {
        let values = task.values(&self.variables);
        let n = self.variables.len();
        let lights = task.spectrum.illumination.weights(used);
        let mean = |of: &dyn Fn(usize) -> f64, k: usize| -> f64 {
            (0..lights.len()).map(|light| lights[light][k] * of((case + light) * used.len() + k)).sum()
        };
        let fluxes: [fn(&CaseFluxes) -> f64; 2] = [|row| row.reflectance.value, |row| row.transmittance.value];
        let derivatives: [fn(&FluxDerivatives) -> f64; 2] = [|row| row.reflectance, |row| row.transmittance];
        let model: Vec<[f64; 2]> =
            (0..used.len()).map(|k| fluxes.map(|flux| mean(&|row| flux(&solved.fluxes[row]), k))).collect();
        // Measurements have places among all wavelengths.
        let mut position = vec![usize::MAX; self.wavelengths_nm.len()];
        used.iter().enumerate().for_each(|(k, place)| position[*place] = k);
        let trial = task.search.trial();
        let mut residuals = Vec::with_capacity(task.data());
        let mut columns = vec![Vec::with_capacity(task.data()); trial.len()];
        let mut scale = n;
        for (quantity, (data, measured)) in task.quantities().into_iter().enumerate() {
            let (Some(data), Some(measured)) = (data, measured) else { continue };
            let has_scale = measured.scale_error > 0.0;
            let factor = if has_scale { trial[scale].exp() } else { 1.0 };
            let scaled = |place: usize| factor * model[position[place]][quantity];
            residuals.extend(data.residuals(scaled));
            for (i, column) in columns.iter_mut().enumerate() {
                if i < n {
                    let slope = factor * state::slope(self.variables[i], values[i]);
                    let by = derivatives[quantity];
                    let by = |row: usize| by(&solved.derivatives[row * n + i]);
                    column.extend(data.derivatives(|place| slope * mean(&by, position[place])));
                } else if has_scale && i == scale {
                    column.extend(data.derivatives(scaled));
                } else {
                    column.extend(std::iter::repeat_n(0.0, data.len()));
                }
            }
            scale += usize::from(has_scale);
        }
        let jacobian = DMatrix::from_fn(residuals.len(), columns.len(), |i, j| columns[j][i]);
        if task.search.take(&DVector::from_vec(residuals), &jacobian) {
            task.best = model;
        }
    }

    fn retrieval(&self, task: Task, used: &[usize]) -> Retrieval {
        let n = self.variables.len();
        let data = task.data();
        let scaled = task.quantities().map(|(_, measured)| measured.is_some_and(|measured| measured.scale_error > 0.0));
        let mut spectra = [vec![f64::NAN; self.wavelengths_nm.len()], vec![f64::NAN; self.wavelengths_nm.len()]];
        for (place, model) in used.iter().zip(&task.best) {
            spectra.iter_mut().zip(model).for_each(|(spectrum, value)| spectrum[*place] = *value);
        }
        let [albedo, transmittance] = spectra;
        let Posterior { state, covariance, averaging_kernel, data_cost, prior_cost, is_at_end, solutions, end } =
            task.search.posterior();
        let block = |matrix: &DMatrix<f64>| (0..n * n).map(|k| matrix[(k / n, k % n)]).collect();
        let deviation = |i: usize| covariance[(i, i)].sqrt();
        let ended = is_at_end.iter().position(|is_at_end| *is_at_end).and_then(|i| self.variables.get(i));
        let retrieved = |(i, variable): (usize, &Variable)| {
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
        let [albedo_scale, transmittance_scale] = scaled.map(|is_scaled| {
            if !is_scaled {
                return Retrieved { median: 1.0, standard_deviation: 0.0, interval: [1.0; 2] };
            }
            let (element, deviation) = (state[next], deviation(next));
            next += 1;
            let ends = [-1.0, 1.0].map(|sign| (element + sign * HALF_WIDTH_OF_95_PERCENT * deviation).exp());
            Retrieved { median: element.exp(), standard_deviation: element.exp() * deviation, interval: ends }
        });
        Retrieval {
            values: self.variables.iter().enumerate().map(retrieved).collect(),
            covariance: block(&covariance),
            averaging_kernel: block(&averaging_kernel),
            degrees_of_freedom: (0..n).map(|i| averaging_kernel[(i, i)]).sum(),
            data,
            data_chi_square: data_cost,
            chi_square: data_cost + prior_cost,
            albedo_scale,
            transmittance_scale,
            albedo,
            transmittance,
            solutions,
            outcome: match (data, end, ended) {
                (0, ..) => Outcome::NoData,
                (_, End::NotConverged, _) => Outcome::NotConverged,
                (_, End::Converged, Some(variable)) => Outcome::AtEndOfRange(*variable),
                (_, End::Converged, None) => Outcome::Converged,
            },
        }
    }
}

impl Spectrum {
    /// The value of a variable in the snow, its pack and the light; NaN for the cosine of diffuse light.
    #[must_use]
    pub fn known(&self, variable: Variable) -> f64 {
        match variable {
            Variable::SurfaceArea => 4.0 * self.snow.extinction_per_m() / self.snow.density_kg_m3,
            Variable::Density => self.snow.density_kg_m3,
            Variable::Thickness => self.thickness_cm,
            Variable::WaterSaturation => self.snow.water_saturation,
            Variable::MassFraction(substance) => self.snow.impurities.ng_g(substance),
            Variable::CosIncidence => match self.illumination.incidences()[0] {
                Incidence::Beam { angle_deg } => angle_deg.to_radians().cos(),
                Incidence::Diffuse => f64::NAN,
            },
            Variable::GroundAlbedo => self.ground_albedo,
        }
    }

    fn measured(&self) -> impl Iterator<Item = &Measured> {
        self.albedo.iter().chain(&self.transmittance)
    }

    /// Those that are not 0, in the order of their elements of the state.
    fn scale_errors(&self) -> Vec<f64> {
        self.measured().map(|measured| measured.scale_error).filter(|scale_error| *scale_error > 0.0).collect()
    }
}

impl Task<'_> {
    /// The number of measured values.
    fn data(&self) -> usize {
        self.albedo.as_ref().map_or(0, Data::len) + self.transmittance.as_ref().map_or(0, Data::len)
    }

    /// Albedo, then transmittance.
    fn quantities(&self) -> [(Option<&Data>, Option<&Measured>); 2] {
        let Spectrum { albedo, transmittance, .. } = self.spectrum;
        [(self.albedo.as_ref(), albedo.as_ref()), (self.transmittance.as_ref(), transmittance.as_ref())]
    }

    /// The variables at the trial.
    fn values(&self, variables: &[Variable]) -> Vec<f64> {
        let elements = self.search.trial().iter();
        variables.iter().zip(elements).map(|(variable, element)| state::value(*variable, *element)).collect()
    }
}

impl Illumination {
    /// The beam, if there is one, then diffuse light, if there is some.
    fn incidences(&self) -> Vec<Incidence> {
        match self {
            Self::Single(incidence) => vec![*incidence],
            Self::Mixed { angle_deg, .. } => vec![Incidence::Beam { angle_deg: *angle_deg }, Incidence::Diffuse],
        }
    }

    /// The weight of each incidence at some wavelengths.
    fn weights(&self, places: &[usize]) -> Vec<Vec<f64>> {
        match self {
            Self::Single(_) => vec![vec![1.0; places.len()]],
            Self::Mixed { diffuse_fractions, .. } => {
                let diffuse: Vec<f64> = places.iter().map(|place| diffuse_fractions[*place]).collect();
                vec![diffuse.iter().map(|fraction| 1.0 - fraction).collect(), diffuse]
            }
        }
    }
}

/// Formats as a sentence without a stop.
impl fmt::Display for Outcome {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Converged => out.write_str("converged"),
            Self::AtEndOfRange(variable) => write!(out, "{variable} is at an end of its range"),
            Self::NotConverged => out.write_str("not converged"),
            Self::NoData => out.write_str("no data"),
        }
    }
}

fn combination(quantity: &'static str, rule: &'static str) -> TransportError {
    TransportError::Combination { quantity, rule }
}

/// Snow with another value, within its range, of one of its variables.
fn with(sample: &SnowSample, variable: Variable, value: f64) -> SnowSample {
    let mut changed = *sample;
    match variable {
        Variable::SurfaceArea => {
            let grain_size = GrainSize::from_specific_surface_area(value, sample.temperature_c);
            changed.grain_size = grain_size.unwrap_or_else(|error| unreachable!("within its range: {error}"));
        }
        Variable::Density => changed.density_kg_m3 = value,
        Variable::WaterSaturation => changed.water_saturation = value,
        Variable::MassFraction(substance) => changed.impurities = changed.impurities.with(substance, value),
        Variable::Thickness | Variable::CosIncidence | Variable::GroundAlbedo => {}
    }
    changed
}
