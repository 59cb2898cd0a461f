//! Slabs of snow by discrete ordinates: slabs of one snow, and many slabs, each with its own snow, thickness, light
//! and ground, with the standard errors of their grain tallies.
//!
//! Grains that differ only in size share the rays that are traced through them: scattering angles do not depend on
//! the size, and paths are proportional to it. Slabs of one snow share its modes. The numbers of a slab do not depend
//! on other slabs, to the last bit. Derivatives are computed with the values, from common modes and linear systems.

use std::cell::LazyCell;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::differentiated::DifferentiatedMedium;
use super::eigen::Scaled;
use super::homogeneous::{HomogeneousMedium, ModalLight, Passed, SlabSolution};
use super::layered::{LayeredMedium, MediumLayer};
use super::options::{OrdinatesOptions, Peak, Streams};
use super::solve_each::groups_alike;
use crate::TransportError;
use crate::batch::{Batch, BatchError, SlabCase};
use crate::dual::{Dual, LANES, Real};
use crate::ground::GroundAlbedo;
use crate::medium::{Composition, Demand, GrainTallies, Medium, Population, directions};
use crate::sample::Property;
use crate::slab::{Estimate, Fluxes, Incidence, Radiometry, Slab};
use crate::variable::Variable;

/// Samples that are solved before their fluxes are put in order: enough for all threads, while the fluxes that wait
/// take little memory.
const PLANS_AT_ONCE: usize = 1024;

/// Fluxes of a batch with their derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct DifferentiatedFluxes {
    /// Fluxes of each case at each wavelength; the wavelength varies fastest.
    pub fluxes: Vec<Fluxes>,
    /// Derivatives of each case at each wavelength with respect to each variable; the variable varies fastest.
    pub derivatives: Vec<Fluxes<f64>>,
}

/// Variables, no more than a [`Dual`] has derivatives, and a medium with its derivatives by these variables. Without
/// variables the derivatives are deviations of the grain tallies.
struct Differentiation {
    variables: Vec<Variable>,
    medium: Medium<Dual>,
}

/// Reflectance and transmittance of each case of a sample, and their derivatives by each group of variables.
struct Solved {
    values: Vec<Passed>,
    differentiated: Vec<Vec<Passed<Dual>>>,
}

/// The cases of one sample, grouped by the number of streams, then by thickness and ground.
struct Plan {
    sample: usize,
    groups: Vec<StreamPlan>,
    /// The greatest number of streams.
    degree: usize,
    /// The ground of each case.
    grounds: Vec<GroundAlbedo>,
}

/// Cases with one number of streams.
struct StreamPlan {
    streams: usize,
    incidences: Vec<Incidence>,
    slabs: Vec<SlabPlan>,
}

/// Cases with one thickness and ground.
struct SlabPlan {
    thickness_cm: f64,
    ground_albedo: GroundAlbedo,
    /// Indices among the cases of the sample and among the incidences.
    cases: Vec<(usize, usize)>,
}

/// Cases with one number of streams while they are gathered.
#[derive(Default)]
struct Gathered {
    /// The place of an incidence among the incidences, by the bits of its angle.
    known: BTreeMap<u64, usize>,
    incidences: Vec<Incidence>,
    /// The slabs by the bits of thickness and ground.
    slabs: BTreeMap<(u64, Vec<u64>), SlabPlan>,
}

/// Reflectance, transmittance and absorptance for each thickness, then each incidence, then each wavelength.
///
/// The standard errors follow from the covariance of the grain tallies, by the delta method.
///
/// # Errors
/// If a parameter or the number of streams is out of range.
pub fn solve(slab: &Slab, options: &OrdinatesOptions) -> Result<Vec<Radiometry>, TransportError> {
    solve_with(slab, options, true)
}

/// As [`solve`], without standard errors, which are NaN: they take half of the time once the grains are tallied.
///
/// # Errors
/// If a parameter or the number of streams is out of range.
pub fn solve_without_errors(slab: &Slab, options: &OrdinatesOptions) -> Result<Vec<Radiometry>, TransportError> {
    solve_with(slab, options, false)
}

fn solve_with(slab: &Slab, options: &OrdinatesOptions, errors: bool) -> Result<Vec<Radiometry>, TransportError> {
    slab.check()?;
    let batch = Batch::from(slab);
    let solved = solve_batch(&batch, options, errors, &|_| ()).map_err(|wrong| wrong.error)?;
    Ok(batch.radiometry(&solved))
}

/// Fluxes of each case at each wavelength, the wavelength running fastest. Without `errors` the standard errors of the
/// grain tallies are NaN; they take as long as the values.
///
/// `progress` is called from any thread with the number of cases done.
///
/// ```
/// use snowblue_transport::batch::{Batch, SlabCase};
/// use snowblue_transport::ordinates::{OrdinatesOptions, solve_batch};
/// use snowblue_transport::{GrainSize, Incidence, SnowSample, TransportError};
///
/// let of_area = |area_m2_kg: f64| -> Result<SnowSample, TransportError> {
///     let grain_size = GrainSize::from_specific_surface_area(area_m2_kg, -5.0)?;
///     Ok(SnowSample { grain_size, ..SnowSample::default() })
/// };
/// let case = |sample, thickness_cm| SlabCase {
///     sample,
///     thickness_cm,
///     incidence: Incidence::Diffuse,
///     ground_albedo: 0.0.into(),
/// };
/// let batch = Batch {
///     samples: vec![of_area(10.0)?, of_area(40.0)?],
///     cases: vec![case(0, f64::INFINITY), case(1, 20.0)],
///     wavelengths_nm: vec![900.0],
/// };
/// let options = OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() };
/// let solved = solve_batch(&batch, &options, false, &|_| ())?;
/// // In the infrared a layer of fine grains is brighter than any depth of coarse ones.
/// assert!(solved[1].reflectance.value > solved[0].reflectance.value);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`Batch::check`], and for a wrong number of streams.
///
/// # Panics
/// If a case refers to a sample that does not exist.
pub fn solve_batch(
    batch: &Batch,
    options: &OrdinatesOptions,
    errors: bool,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Vec<Fluxes>, BatchError> {
    Ok(differentiate_batch(batch, &[], options, errors, progress)?.fluxes)
}

/// As [`solve_batch`], with the derivatives with respect to each of `variables`.
///
/// The values as computed, with their tallies and streams, are differentiated by tangent-linear equations and not by
/// differences. In snow without a substance or without water, and on black ground, the derivative is the one-sided
/// derivative towards greater values of the variable; it does not include that wet snow and algae take more streams.
///
/// ```
/// use snowblue_transport::batch::{Batch, SlabCase};
/// use snowblue_transport::ordinates::{OrdinatesOptions, differentiate_batch};
/// use snowblue_transport::{Incidence, Property, SnowSample, Substance, Variable};
///
/// let case = SlabCase { sample: 0, thickness_cm: 5.0, incidence: Incidence::Diffuse, ground_albedo: 0.0.into() };
/// let batch = Batch { samples: vec![SnowSample::default()], cases: vec![case], wavelengths_nm: vec![450.0] };
/// let options = OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() };
/// let soot = Variable::impurity(Substance::BLACK_CARBON);
/// let solved = differentiate_batch(&batch, &[Variable::Snow(Property::Density), soot], &options, false, &|_| ())?;
/// // Denser snow of this thickness is brighter, and sootier snow is darker.
/// assert!(solved.derivatives[0].reflectance > 0.0 && solved.derivatives[1].reflectance < 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`solve_batch`], and for a wavelength that the table of a variable's substance does not cover.
///
/// # Panics
/// If a case refers to a sample that does not exist.
pub fn differentiate_batch(
    batch: &Batch,
    variables: &[Variable],
    options: &OrdinatesOptions,
    errors: bool,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<DifferentiatedFluxes, BatchError> {
    options.streams.check()?;
    batch.check()?;
    let Batch { samples, cases, wavelengths_nm } = batch;
    for variable in variables {
        wavelengths_nm.iter().try_for_each(|wavelength_nm| variable.check_at(*wavelength_nm))?;
    }
    let cases_of = batch.cases_of_samples();
    let nothing = Fluxes::from([f64::NAN; 3]);
    let mut derivatives = vec![nothing; cases.len() * wavelengths_nm.len() * variables.len()];
    let nothing = nothing.map(|value| Estimate { value, standard_error: value });
    let mut fluxes = vec![nothing; cases.len() * wavelengths_nm.len()];
    let done = AtomicUsize::new(0);
    let used = (0..samples.len()).filter(|sample| !cases_of[*sample].is_empty());
    for group in groups_alike(samples, used) {
        let plan = |sample: &usize| Plan::new(*sample, &cases_of[*sample], batch, options.streams);
        let plans: Vec<Plan> = group.iter().map(plan).collect();
        let tallies =
            shared_tallies(&plans, batch, variables.contains(&Variable::Snow(Property::WaterSaturation)), options);
        let solve = |plan: &Plan| {
            let sample = &samples[plan.sample];
            let tallies = tallies.narrowed(plan.degree, sample.grain_size.max_um);
            let composition = Composition::new(sample);
            let group = |group| (group, composition.differentiated(group));
            let groups: Vec<_> = variables.chunks(LANES).map(group).collect();
            let exactly = composition.differentiated(&[]);
            let at = |wavelength_nm: &f64| {
                let differentiation = |(variables, composition): &(&[Variable], Composition<Dual>)| Differentiation {
                    variables: variables.to_vec(),
                    medium: tallies.medium_of(&sample.grain_size, &composition.at(*wavelength_nm)),
                };
                let mut differentiations: Vec<Differentiation> = groups.iter().map(differentiation).collect();
                let constituents = composition.at(*wavelength_nm);
                let medium = if errors {
                    let deviations = tallies.deviations(&sample.grain_size, &constituents);
                    let exactly = exactly.at(*wavelength_nm);
                    differentiations.extend(directions(std::iter::once(&deviations)).chunks(LANES).map(|directions| {
                        let medium = tallies.deviated_medium(&exactly, &deviations, directions);
                        Differentiation { variables: Vec::new(), medium }
                    }));
                    tallies.medium_of_deviations(&constituents, &deviations)
                } else {
                    tallies.medium_of(&sample.grain_size, &constituents)
                };
                plan.solve(&medium, *wavelength_nm, &differentiations, errors)
            };
            let by_wavelength: Vec<_> = wavelengths_nm.par_iter().map(at).collect();
            progress(done.fetch_add(plan.grounds.len(), Ordering::Relaxed) + plan.grounds.len());
            by_wavelength
        };
        for plans in plans.chunks(PLANS_AT_ONCE) {
            let answers: Vec<Vec<DifferentiatedFluxes>> = plans.par_iter().map(solve).collect();
            for (plan, by_wavelength) in plans.iter().zip(&answers) {
                for (place, number) in cases_of[plan.sample].iter().enumerate() {
                    for (wavelength, answer) in by_wavelength.iter().enumerate() {
                        let row = number * wavelengths_nm.len() + wavelength;
                        fluxes[row] = answer.fluxes[place];
                        let of_case = |row: usize| row * variables.len()..(row + 1) * variables.len();
                        derivatives[of_case(row)].copy_from_slice(&answer.derivatives[of_case(place)]);
                    }
                }
            }
        }
    }
    Ok(DifferentiatedFluxes { fluxes, derivatives })
}

/// The tallies of all samples of a group, also in water if any of them is wet or if wanted.
fn shared_tallies(plans: &[Plan], batch: &Batch, in_water: bool, options: &OrdinatesOptions) -> GrainTallies {
    let sample = |plan: &Plan| &batch.samples[plan.sample];
    let demand = Demand::of_samples(plans.iter().map(sample), &batch.wavelengths_nm);
    let demand = Demand { wet: demand.wet || in_water, ..demand };
    let degree = plans.iter().map(|plan| plan.degree).max().unwrap_or_default();
    GrainTallies::new(&Population::of_sample(sample(&plans[0])), &demand, &options.plan_of_degree(degree))
}

impl Gathered {
    fn add(&mut self, place: usize, SlabCase { thickness_cm, incidence, ground_albedo, .. }: &SlabCase) {
        let key = match incidence {
            Incidence::Beam { angle_deg } => angle_deg.to_bits(),
            Incidence::Diffuse => u64::MAX,
        };
        let light = *self.known.entry(key).or_insert(self.incidences.len());
        if light == self.incidences.len() {
            self.incidences.push(*incidence);
        }
        let slab = self.slabs.entry((thickness_cm.to_bits(), ground_albedo.bits()));
        let new = || SlabPlan { thickness_cm: *thickness_cm, ground_albedo: ground_albedo.clone(), cases: Vec::new() };
        slab.or_insert_with(new).cases.push((place, light));
    }
}

impl Plan {
    fn new(sample: usize, cases: &[usize], batch: &Batch, streams: Streams) -> Self {
        let peak = Peak::of(&batch.samples[sample]);
        let mut groups: BTreeMap<usize, Gathered> = BTreeMap::new();
        let mut grounds = Vec::with_capacity(cases.len());
        for (place, number) in cases.iter().enumerate() {
            let case = &batch.cases[*number];
            groups.entry(streams.under(&case.incidence, peak)).or_default().add(place, case);
            grounds.push(case.ground_albedo.clone());
        }
        let degree = groups.keys().next_back().copied().unwrap_or_default();
        let group = |(streams, Gathered { incidences, slabs, .. }): (usize, Gathered)| StreamPlan {
            streams,
            incidences,
            slabs: slabs.into_values().collect(),
        };
        Self { sample, groups: groups.into_iter().map(group).collect(), degree, grounds }
    }

    /// All cases in a medium at its wavelength in nm, with the derivatives by the variables of `differentiations`, and
    /// with their errors if those without variables give `errors`.
    fn solve(
        &self,
        medium: &Medium,
        wavelength_nm: f64,
        differentiations: &[Differentiation],
        errors: bool,
    ) -> DifferentiatedFluxes {
        let nothing = |_: &Differentiation| vec![Passed::of(Dual::from(f64::NAN)); self.grounds.len()];
        let mut solved = Solved {
            values: vec![Passed::of(f64::NAN); self.grounds.len()],
            differentiated: differentiations.iter().map(nothing).collect(),
        };
        self.groups.iter().for_each(|group| group.fill(medium, wavelength_nm, differentiations, &mut solved));
        let mut answer = DifferentiatedFluxes { fluxes: Vec::new(), derivatives: Vec::new() };
        for (place, ground) in self.grounds.iter().enumerate() {
            let ground = ground.at(wavelength_nm);
            let mut variances = Fluxes::from([if errors { 0.0 } else { f64::NAN }; 3]).to_array();
            for (Differentiation { variables, .. }, of_case) in differentiations.iter().zip(&solved.differentiated) {
                let fluxes = of_case[place].fluxes(Variable::GroundAlbedo.number(ground, variables));
                let by = |lane: usize| fluxes.map(|number| number.derivatives()[lane]);
                answer.derivatives.extend((0..variables.len()).map(by));
                if variables.is_empty() {
                    let squares = fluxes.to_array().map(|number| number.squared_gradient());
                    variances.iter_mut().zip(squares).for_each(|(sum, square)| *sum += square);
                }
            }
            let values = solved.values[place].fluxes(ground).to_array();
            let estimate = |flux: usize| Estimate { value: values[flux], standard_error: variances[flux].sqrt() };
            answer.fluxes.push(Fluxes::from([0, 1, 2].map(estimate)));
        }
        answer
    }
}

impl StreamPlan {
    /// Fills in the cases of these streams.
    fn fill(&self, medium: &Medium, wavelength_nm: f64, differentiations: &[Differentiation], solved: &mut Solved) {
        let modes = HomogeneousMedium::new(&medium.scattering, self.streams);
        let lights: Vec<ModalLight> = self.incidences.iter().map(|incidence| modes.light(incidence)).collect();
        let plan = |by| DifferentiatedPlan::new(by, &modes, self);
        let differentiated: Vec<DifferentiatedPlan> = differentiations.iter().map(plan).collect();
        for slab @ SlabPlan { thickness_cm, ground_albedo, cases } in &self.slabs {
            let optical_depth = medium.extinction_per_m * thickness_cm * 0.01;
            let solution = LazyCell::new(|| modes.solve_slab(optical_depth * modes.scaled.depth_ratio));
            let ground_albedo = ground_albedo.at(wavelength_nm);
            if ground_albedo > 0.0 {
                let under: Vec<Incidence> = cases.iter().map(|(_, light)| self.incidences[*light]).collect();
                let layer = MediumLayer { medium: &modes, optical_depth };
                let layered = LayeredMedium::new(&[layer], ground_albedo, &under);
                for (((place, _), top), bottom) in cases.iter().zip(layered.fluxes(0)).zip(layered.fluxes(1)) {
                    solved.values[*place] = Passed { reflectance: top.up, transmittance: bottom.down };
                }
            } else {
                let lit = modes.lit(&solution);
                for (place, light) in cases {
                    solved.values[*place] = lit.passed(&lights[*light]);
                }
            }
            for (plan, passed) in differentiated.iter().zip(&mut solved.differentiated) {
                plan.fill(slab, ground_albedo, &solution, passed);
            }
        }
    }
}

/// Cases with one number of streams, prepared for some variables.
struct DifferentiatedPlan<'m> {
    by: &'m Differentiation,
    medium: DifferentiatedMedium,
    lights: Vec<ModalLight<Dual>>,
}

impl<'m> DifferentiatedPlan<'m> {
    fn new(by: &'m Differentiation, modes: &'m HomogeneousMedium, plan: &StreamPlan) -> Self {
        let Differentiation { variables, medium } = by;
        let medium = DifferentiatedMedium::new(modes, Scaled::new(&medium.scattering, plan.streams));
        let cosine = |cosine: f64| Variable::CosIncidence.number(cosine, variables);
        let lights = plan.incidences.iter().map(|incidence| medium.light(incidence, cosine)).collect();
        Self { by, medium, lights }
    }

    /// Fills in the cases of a slab, whose systems have been solved.
    fn fill(&self, slab: &SlabPlan, ground_albedo: f64, solution: &SlabSolution, all: &mut [Passed<Dual>]) {
        let Differentiation { variables, medium } = self.by;
        let thickness_cm = Variable::Thickness.number(slab.thickness_cm, variables);
        let lit = self.medium.lit(medium.extinction_per_m, thickness_cm, solution);
        let ground_albedo = Variable::GroundAlbedo.number(ground_albedo, variables);
        let diffuse = (!ground_albedo.is_zero()).then(|| lit.passed(&ModalLight::Lambertian));
        for (place, light) in &slab.cases {
            let passed = lit.passed(&self.lights[*light]);
            all[*place] = diffuse.map_or(passed, |diffuse| on_ground(passed, diffuse, ground_albedo));
        }
    }
}

impl<T: Real> Passed<T> {
    fn of(value: T) -> Self {
        Self { reflectance: value, transmittance: value }
    }
}

/// A slab on a Lambertian ground: light goes back and forth between them (van de Hulst 1980, *Multiple Light
/// Scattering*, ch. 4). `diffuse` is the slab under Lambertian light, from either side.
///
/// [`LayeredMedium`] gives equal values, also for several layers.
fn on_ground(slab: Passed<Dual>, diffuse: Passed<Dual>, albedo: Dual) -> Passed<Dual> {
    let transmittance = slab.transmittance / (Dual::from(1.0) - albedo * diffuse.reflectance);
    Passed { reflectance: slab.reflectance + albedo * transmittance * diffuse.transmittance, transmittance }
}
