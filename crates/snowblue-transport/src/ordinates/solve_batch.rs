//! Many slabs of snow by discrete ordinates, each with its own snow, thickness, light and ground.
//!
//! Grains that are alike but for their size share the rays that are traced through them: scattering angles do not
//! depend on the size, and paths are proportional to it. Slabs of one snow share its modes. Each slab has the numbers
//! that it has alone, to the last bit.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::homogeneous::{HomogeneousMedium, Light};
use super::jackknife::Jackknife;
use super::layered::{LayeredMedium, MediumLayer};
use super::options::OrdinatesOptions;
use super::solve_alike::groups_alike;
use super::streams::{Peak, Streams};
use crate::batch::{Batch, BatchError, CaseFluxes, SlabCase};
use crate::medium::{Composition, Demand, GrainTallies, Medium, Population};
use crate::slab::{Estimate, Incidence};

/// Samples that are solved before their fluxes are put in order: enough for all threads, while the fluxes that wait
/// take little memory.
const PLANS_AT_ONCE: usize = 1024;

/// Reflectance and transmittance.
#[derive(Debug, Clone, Copy, Default)]
struct Passed {
    reflectance: f64,
    transmittance: f64,
}

/// The cases of one sample by what they share: the number of streams, then thickness and ground.
struct Plan {
    sample: usize,
    groups: Vec<StreamPlan>,
    /// The greatest number of streams.
    degree: usize,
    /// The albedo of each case's ground.
    grounds: Vec<f64>,
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
    ground_albedo: f64,
    /// Places among the sample's cases and among the incidences.
    cases: Vec<(usize, usize)>,
}

/// Cases with one number of streams while they are gathered.
#[derive(Default)]
struct Gathered {
    /// The place of an incidence among the incidences, by the bits of its angle.
    known: BTreeMap<u64, usize>,
    incidences: Vec<Incidence>,
    /// Places of cases and incidences, by the bits of thickness and ground.
    slabs: BTreeMap<[u64; 2], Vec<(usize, usize)>>,
}

/// Fluxes of each case at each wavelength, the wavelength running fastest. Without `errors` the standard errors, by a
/// jackknife over the batches of the grain tallies, are NaN; they take 16 times as long as the values.
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
///     ground_albedo: 0.0,
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
/// If a case has a sample that is none of the samples.
pub fn solve_batch(
    batch: &Batch,
    options: &OrdinatesOptions,
    errors: bool,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Vec<CaseFluxes>, BatchError> {
    options.streams.check()?;
    batch.check()?;
    let Batch { samples, cases, wavelengths_nm } = batch;
    let cases_of = batch.cases_of_samples();
    let nothing = Estimate { value: f64::NAN, standard_error: f64::NAN };
    let nothing = CaseFluxes { reflectance: nothing, transmittance: nothing, absorptance: nothing };
    let mut solved = vec![nothing; cases.len() * wavelengths_nm.len()];
    let done = AtomicUsize::new(0);
    let used = (0..samples.len()).filter(|sample| !cases_of[*sample].is_empty());
    for group in groups_alike(samples, used) {
        let plan = |sample: &usize| Plan::new(*sample, &cases_of[*sample], batch, options.streams);
        let plans: Vec<Plan> = group.iter().map(plan).collect();
        let tallies = shared_tallies(&plans, batch, options);
        let solve = |plan: &Plan| {
            let sample = &samples[plan.sample];
            let tallies = tallies.narrowed(plan.degree, sample.grain_size.max_um);
            let composition = Composition::new(sample);
            let at = |wavelength_nm: &f64| {
                let constituents = composition.at(*wavelength_nm);
                plan.solve(|without| tallies.medium_of(&sample.grain_size, &constituents, without), errors)
            };
            let by_wavelength: Vec<Vec<CaseFluxes>> = wavelengths_nm.par_iter().map(at).collect();
            progress(done.fetch_add(plan.grounds.len(), Ordering::Relaxed) + plan.grounds.len());
            by_wavelength
        };
        for plans in plans.chunks(PLANS_AT_ONCE) {
            let answers: Vec<Vec<Vec<CaseFluxes>>> = plans.par_iter().map(solve).collect();
            for (plan, by_wavelength) in plans.iter().zip(&answers) {
                for (place, number) in cases_of[plan.sample].iter().enumerate() {
                    let row = &mut solved[number * wavelengths_nm.len()..][..wavelengths_nm.len()];
                    row.iter_mut().zip(by_wavelength).for_each(|(value, cases)| *value = cases[place]);
                }
            }
        }
    }
    Ok(solved)
}

/// The tallies of all samples of a group.
fn shared_tallies(plans: &[Plan], batch: &Batch, options: &OrdinatesOptions) -> GrainTallies {
    let sample = |plan: &Plan| &batch.samples[plan.sample];
    let demand = Demand::of_samples(plans.iter().map(sample), &batch.wavelengths_nm);
    let degree = plans.iter().map(|plan| plan.degree).max().unwrap_or_default();
    GrainTallies::new(&Population::of_sample(sample(&plans[0])), &demand, &options.plan_of_degree(degree))
}

impl Gathered {
    fn add(&mut self, place: usize, SlabCase { thickness_cm, incidence, ground_albedo, .. }: SlabCase) {
        let key = match incidence {
            Incidence::Beam { angle_deg } => angle_deg.to_bits(),
            Incidence::Diffuse => u64::MAX,
        };
        let light = *self.known.entry(key).or_insert(self.incidences.len());
        if light == self.incidences.len() {
            self.incidences.push(incidence);
        }
        self.slabs.entry([thickness_cm, ground_albedo].map(f64::to_bits)).or_default().push((place, light));
    }
}

impl Plan {
    fn new(sample: usize, cases: &[usize], batch: &Batch, streams: Streams) -> Self {
        let peak = Peak::of(&batch.samples[sample]);
        let mut groups: BTreeMap<usize, Gathered> = BTreeMap::new();
        let mut grounds = Vec::with_capacity(cases.len());
        for (place, number) in cases.iter().enumerate() {
            let case = batch.cases[*number];
            groups.entry(streams.under(&case.incidence, peak)).or_default().add(place, case);
            grounds.push(case.ground_albedo);
        }
        let degree = groups.keys().next_back().copied().unwrap_or_default();
        let group = |(streams, Gathered { incidences, slabs, .. }): (usize, Gathered)| {
            let slab = |([thickness, ground], cases): ([u64; 2], _)| SlabPlan {
                thickness_cm: f64::from_bits(thickness),
                ground_albedo: f64::from_bits(ground),
                cases,
            };
            StreamPlan { streams, incidences, slabs: slabs.into_iter().map(slab).collect() }
        };
        Self { sample, groups: groups.into_iter().map(group).collect(), degree, grounds }
    }

    /// All cases at one wavelength.
    fn solve(&self, medium: impl Fn(Option<usize>) -> Medium, errors: bool) -> Vec<CaseFluxes> {
        let result = |without| self.passed(&medium(without));
        let fluxes = if errors { Jackknife::new(result) } else { Jackknife::without_errors(result) };
        let case = |(place, ground): (usize, &f64)| CaseFluxes {
            reflectance: fluxes.estimate(|passed| passed[place].reflectance),
            transmittance: fluxes.estimate(|passed| passed[place].transmittance),
            absorptance: fluxes.estimate(|passed: &Vec<Passed>| {
                1.0 - passed[place].reflectance - (1.0 - ground) * passed[place].transmittance
            }),
        };
        self.grounds.iter().enumerate().map(case).collect()
    }

    /// Reflectance and transmittance of each case on a medium.
    fn passed(&self, medium: &Medium) -> Vec<Passed> {
        let mut all = vec![Passed::default(); self.grounds.len()];
        for StreamPlan { streams, incidences, slabs } in &self.groups {
            let modes = HomogeneousMedium::new(&medium.scattering, *streams);
            let mut lights: Vec<Option<Light>> = incidences.iter().map(|_| None).collect();
            for SlabPlan { thickness_cm, ground_albedo, cases } in slabs {
                let optical_depth = medium.extinction_per_m * thickness_cm * 0.01;
                if *ground_albedo > 0.0 {
                    let under: Vec<Incidence> = cases.iter().map(|(_, light)| incidences[*light]).collect();
                    let layer = MediumLayer { medium: &modes, optical_depth };
                    let layered = LayeredMedium::new(&[layer], *ground_albedo, &under);
                    for (((place, _), top), bottom) in cases.iter().zip(layered.fluxes(0)).zip(layered.fluxes(1)) {
                        all[*place] = Passed { reflectance: top.up, transmittance: bottom.down };
                    }
                    continue;
                }
                for (_, light) in cases {
                    lights[*light].get_or_insert_with(|| modes.light(&incidences[*light]));
                }
                let under = cases.iter().filter_map(|(_, light)| lights[*light].as_ref());
                for ((place, _), fluxes) in cases.iter().zip(modes.fluxes(optical_depth, under)) {
                    all[*place] = Passed { reflectance: fluxes.reflectance, transmittance: fluxes.transmittance };
                }
            }
        }
        all
    }
}
