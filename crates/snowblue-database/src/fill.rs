//! Fills a table by either engine, as a whole or some of its grains at a time.
//!
//! Each engine solves only for the axes that change its result. Discrete ordinates need one grain tally for each
//! facetness, and one eigenproblem for each (size, facetness, wavelength) of dry and clean snow; densities,
//! thicknesses and angles follow by back substitution. Monte Carlo needs one trace for all wavelengths and
//! thicknesses, and all densities of dry snow. Transport in dry snow depends only on the product of density and
//! thickness, also with impurities. The paper traced 10⁵ rays for each of its 767,250 values.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use snowblue_transport::monte_carlo::{self, MonteCarloOptions};
use snowblue_transport::optics::IceTable;
use snowblue_transport::ordinates::{
    HomogeneousMedium, ModalLight, OrdinatesOptions, Peak, StreamGroup, Streams, solve_each,
};
use snowblue_transport::rng::Stream;
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::{Radiometry, Slab};
use snowblue_transport::{Demand, GrainTallies, Medium, Population, TallyPlan};

use crate::table::{Attribute, CurveValues, StandardErrors};
use crate::{Axes, DatabaseError, Table};

/// Fills a table on `axes` with transmittance and reflectance. `progress` is called after each step.
///
/// ```
/// use snowblue_database::fill::{FillOptions, fill};
/// use snowblue_database::{Axes, Quantity};
///
/// let axes = Axes {
///     grain_sizes_um: vec![400.0],
///     facetness: vec![0.3],
///     densities_kg_m3: vec![300.0],
///     angles_deg: vec![0.0],
///     thicknesses_cm: vec![1.0, 15.0],
///     wavelengths_nm: vec![450.0, 700.0],
///     ..Axes::paper()
/// };
/// let table = fill(&axes, &FillOptions::by_ordinates(1 << 10), &|_| ())?;
/// let curves: Vec<&[f64]> = table.curves(Quantity::Transmittance).collect();
/// // 15 cm of snow transmit little light, and more of the blue than of the red.
/// assert!(curves[1][0] < curves[0][0] && curves[1][0] > 2.0 * curves[1][1]);
/// # Ok::<(), snowblue_database::DatabaseError>(())
/// ```
///
/// # Errors
/// If an axis or an option is out of range.
pub fn fill(
    axes: &Axes,
    options: &FillOptions,
    progress: &(dyn Fn(FillProgress) + Sync),
) -> Result<Table, DatabaseError> {
    let grains: Vec<usize> = (0..axes.grains()).collect();
    let values = fill_grains(axes, options, &grains, progress)?;
    Ok(Table::new(axes.clone(), values, options.metadata()))
}

/// The curves of any samples by discrete ordinates, as a table whose samples are numbered from 1 on in place of grain
/// sizes. The angles and thicknesses come from [`Axes::with_thin_and_thick_knots`]. The samples may have any grains,
/// but must share one table of ice constants.
///
/// # Errors
/// If a sample is out of range, or its tables do not cover a wavelength.
pub(crate) fn fill_samples(
    samples: &[SnowSample],
    wavelengths_nm: &[f64],
    tally_rays: u32,
) -> Result<Table, DatabaseError> {
    let axes = Axes {
        grain_sizes_um: (1..=samples.len()).map(|number| number as f64).collect(),
        facetness: vec![0.0],
        densities_kg_m3: vec![0.0],
        wavelengths_nm: wavelengths_nm.to_vec(),
        ..Axes::with_thin_and_thick_knots()
    };
    let slab = Slab {
        sample: SnowSample::default(),
        thicknesses_cm: axes.thicknesses_cm.clone(),
        incidences: axes.incidences(),
        wavelengths_nm: wavelengths_nm.to_vec(),
    };
    let mut values = CurveValues { transmittance: Vec::new(), reflectance: Vec::new(), errors: None };
    for spectra in solve_each(samples, &slab, &OrdinatesOptions { tally_rays, ..OrdinatesOptions::default() })? {
        for incidence in 0..slab.incidences.len() {
            for thickness in 0..slab.thicknesses_cm.len() {
                let fluxes = spectra.spectrum(thickness, incidence);
                values.transmittance.extend(fluxes.iter().map(|flux| flux.transmittance));
                values.reflectance.extend(fluxes.iter().map(|flux| flux.reflectance));
            }
        }
    }
    Ok(Table::new(axes, values, Vec::new()))
}

/// Fills the given grains, each an index into grain size × facetness. The values are bit for bit equal to the values
/// that [`fill`] computes. Their order is `[grain][sample][light][thickness][wavelength]`.
///
/// # Errors
/// If an axis or an option is out of range.
pub fn fill_grains(
    axes: &Axes,
    options: &FillOptions,
    grains: &[usize],
    progress: &(dyn Fn(FillProgress) + Sync),
) -> Result<CurveValues, DatabaseError> {
    axes.check(options.ice)?;
    let samples: Vec<SnowSample> =
        (0..axes.samples()).map(|number| axes.sample(number, options.ice)).collect::<Result<_, _>>()?;
    let job = FillJob { axes, samples: &samples, grains, seed: options.seed, progress };
    match options.engine {
        Engine::Ordinates { streams, tally_rays } => {
            streams.check()?;
            Ok(fill_by_ordinates(&job, streams, tally_rays))
        }
        Engine::MonteCarlo { rays } => fill_by_monte_carlo(&job, rays),
    }
}

/// How a table is filled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FillOptions {
    /// The engine and its options.
    pub engine: Engine,
    /// Seed of the random numbers.
    pub seed: u64,
    /// The ice constants.
    pub ice: IceTable,
}

/// An engine and its options.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Engine {
    /// Discrete ordinates.
    Ordinates {
        /// Ordinates in both hemispheres; `Auto` solves steep and grazing angles separately.
        streams: Streams,
        /// Rays per facetness and index node of the grain tally; 2²⁰ leave an error of 0.1 % in T of 15 cm.
        tally_rays: u32,
    },
    /// Random walks from grain to grain, the paper's method.
    MonteCarlo {
        /// Rays per sample, angle and index node.
        rays: u64,
    },
}

impl FillOptions {
    /// Discrete ordinates with automatic streams and `tally_rays` rays of the grain tally.
    #[must_use]
    pub fn by_ordinates(tally_rays: u32) -> Self {
        let engine = Engine::Ordinates { streams: Streams::default(), tally_rays };
        Self { engine, seed: 1, ice: IceTable::default() }
    }

    /// The metadata of a table filled with these options.
    #[must_use]
    pub fn metadata(&self) -> Vec<Attribute> {
        let engine = match self.engine {
            Engine::Ordinates { streams, tally_rays } => vec![
                Attribute::new("engine", "discrete ordinates"),
                Attribute::new("streams", streams.to_string()),
                Attribute::new("tally_rays", tally_rays.to_string()),
            ],
            Engine::MonteCarlo { rays } => {
                vec![Attribute::new("engine", "Monte Carlo"), Attribute::new("rays", rays.to_string())]
            }
        };
        let first = [
            Attribute::new("title", "Spectral transmittance and reflectance of snow"),
            Attribute::new("source", format!("snowblue {}", env!("CARGO_PKG_VERSION"))),
        ];
        let last = [
            Attribute::new("seed", self.seed.to_string()),
            Attribute::new(ICE_CONSTANTS, ice_name(self.ice)),
            Attribute::new("grain_size_measure", "greatest extension, mean of a uniform range of +-50 um"),
        ];
        first.into_iter().chain(engine).chain(last).collect()
    }
}

impl Default for FillOptions {
    fn default() -> Self {
        Self::by_ordinates(1 << 20)
    }
}

const ICE_CONSTANTS: &str = "ice_constants";

/// The ice constants of a table, from its metadata.
///
/// # Errors
/// [`DatabaseError::Metadata`] if the metadata do not name them.
pub fn ice_from_metadata(metadata: &[Attribute]) -> Result<IceTable, DatabaseError> {
    let word = find(metadata, ICE_CONSTANTS);
    let known = [IceTable::WarrenBrandt2008, IceTable::Picard2016];
    let ice = known.into_iter().find(|ice| word == Some(ice_name(*ice)));
    ice.ok_or(DatabaseError::Metadata { name: ICE_CONSTANTS })
}

fn ice_name(ice: IceTable) -> &'static str {
    match ice {
        IceTable::WarrenBrandt2008 => "Warren & Brandt 2008",
        IceTable::Picard2016 => "Picard, Libois & Arnaud 2016; Warren & Brandt 2008 above 600 nm",
    }
}

fn find<'m>(metadata: &'m [Attribute], name: &str) -> Option<&'m str> {
    metadata.iter().find(|attribute| attribute.name == name).map(|attribute| attribute.value.as_str())
}

/// A stage of filling a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FillStage {
    /// Tracing rays in single grains, for discrete ordinates.
    Tally,
    /// Solving the equation of transfer, or tracing rays through the snow.
    Solve,
}

/// Progress of a fill. Its first report of [`FillStage::Solve`] comes when the tally is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FillProgress {
    /// The current stage.
    pub stage: FillStage,
    /// Steps done, over all stages.
    pub done: u64,
    /// Steps of all stages.
    pub total: u64,
}

/// Some grains of a table.
struct FillJob<'job> {
    pub(super) axes: &'job Axes,
    /// All samples of the table.
    pub(super) samples: &'job [SnowSample],
    /// Indices of the grains to fill.
    pub(super) grains: &'job [usize],
    pub(super) seed: u64,
    pub(super) progress: &'job (dyn Fn(FillProgress) + Sync),
}

impl FillJob<'_> {
    fn report(&self, stage: FillStage, done: u64, total: u64) {
        (self.progress)(FillProgress { stage, done, total });
    }
}

/// Progress steps of a tally, which takes about as long as ten grains.
const STEPS_PER_TALLY: u64 = 10;

/// Transmittance and reflectance of the samples of one grain: [sample][light][thickness][wavelength].
struct GrainValues {
    transmittance: Vec<f64>,
    reflectance: Vec<f64>,
}

/// Fills the grains of a job, with a tally of `rays` for each facetness.
fn fill_by_ordinates(job: &FillJob, streams: Streams, rays: u32) -> CurveValues {
    let FillJob { axes, samples, grains, .. } = job;
    let peak = samples.iter().map(Peak::of).max().unwrap_or_default();
    let plan = TallyPlan { degree: streams.most(&axes.incidences(), peak), rays, seed: job.seed };
    let per_grain = axes.samples_per_grain();
    // The tallies cover every sample of the whole table, so that the values of a part of the table equal the values
    // of the whole table bit for bit.
    let first = Demand::of_sample(&samples[0], &axes.wavelengths_nm);
    let demand =
        samples.iter().fold(first, |whole, sample| whole.and(&Demand::of_sample(sample, &axes.wavelengths_nm)));
    let mut tallies: BTreeMap<usize, GrainTallies> = BTreeMap::new();
    let facetness_of = |grain: &usize| grain % axes.facetness.len();
    let kinds: BTreeSet<usize> = grains.iter().map(facetness_of).collect();
    let total = STEPS_PER_TALLY * kinds.len() as u64 + grains.len() as u64;
    for facetness in kinds {
        job.report(FillStage::Tally, STEPS_PER_TALLY * tallies.len() as u64, total);
        let population = Population::of_sample(&samples[facetness * per_grain]);
        tallies.insert(facetness, GrainTallies::new(&population, &demand, &plan));
    }
    let tallied = STEPS_PER_TALLY * tallies.len() as u64;
    job.report(FillStage::Solve, tallied, total);
    let done = AtomicU64::new(tallied);
    let blocks: Vec<GrainValues> = grains
        .par_iter()
        .map(|grain| {
            let samples = &samples[grain * per_grain..][..per_grain];
            let block = fill_grain(axes, samples, &tallies[&facetness_of(grain)], streams);
            job.report(FillStage::Solve, done.fetch_add(1, Ordering::Relaxed) + 1, total);
            block
        })
        .collect();
    CurveValues {
        transmittance: blocks.iter().flat_map(|block| &block.transmittance).copied().collect(),
        reflectance: blocks.iter().flat_map(|block| &block.reflectance).copied().collect(),
        errors: None,
    }
}

fn fill_grain(axes: &Axes, samples: &[SnowSample], tallies: &GrainTallies, streams: Streams) -> GrainValues {
    let incidences = axes.incidences();
    let (lights, thicknesses, wavelengths) = (incidences.len(), axes.thicknesses_cm.len(), axes.wavelengths_nm.len());
    let block = samples.len() * lights * thicknesses * wavelengths;
    let mut filled = GrainValues { transmittance: vec![0.0; block], reflectance: vec![0.0; block] };
    for (w, wavelength_nm) in axes.wavelengths_nm.iter().enumerate() {
        let media: Vec<Medium> = samples.iter().map(|sample| tallies.medium(sample, *wavelength_nm)).collect();
        // Dry and clean samples that differ only in density have equal scattering.
        let same = |s: usize| media.iter().position(|other| other.scattering == media[s].scattering).unwrap_or(s);
        let same: Vec<usize> = (0..media.len()).map(same).collect();
        let mut modes: BTreeMap<(usize, usize), (HomogeneousMedium, Vec<ModalLight>)> = BTreeMap::new();
        for (s, medium) in media.iter().enumerate() {
            for StreamGroup { streams, places: group } in streams.groups(&incidences, Peak::of(&samples[s])) {
                let (modes, lit) = modes.entry((same[s], streams)).or_insert_with(|| {
                    let modes = HomogeneousMedium::new(&medium.scattering, streams);
                    let lit = group.iter().map(|light| modes.light(&incidences[*light])).collect();
                    (modes, lit)
                });
                for (t, thickness_cm) in axes.thicknesses_cm.iter().enumerate() {
                    let all_fluxes = modes.fluxes(medium.extinction_per_m * thickness_cm * 0.01, &*lit);
                    for (light, fluxes) in group.iter().zip(all_fluxes) {
                        let index = ((s * lights + light) * thicknesses + t) * wavelengths + w;
                        filled.transmittance[index] = fluxes.transmittance;
                        filled.reflectance[index] = fluxes.reflectance;
                    }
                }
            }
        }
    }
    filled
}

/// Fills the grains of a job with `rays` for each sample, angle and index node.
fn fill_by_monte_carlo(job: &FillJob, rays: u64) -> Result<CurveValues, DatabaseError> {
    let FillJob { axes, samples, grains, .. } = job;
    let (densities, per_grain) = (axes.densities_kg_m3.len(), axes.samples_per_grain());
    let kinds = per_grain / densities;
    let curves = axes.curves_per_sample() * axes.wavelengths_nm.len();
    let total = (grains.len() * per_grain) as u64;
    let mut filled = Filled::new(grains.len() * per_grain * curves);
    job.report(FillStage::Solve, 0, total);
    for (g, grain) in grains.iter().enumerate() {
        for kind in 0..kinds {
            let number = |density: usize| density * kinds + kind;
            let at_density = |density: usize| &samples[grain * per_grain + number(density)];
            let is_wet = at_density(0).water_saturation > 0.0;
            // Densities that one trace serves: all densities of dry snow, or one density of wet snow.
            let groups: Vec<Vec<usize>> =
                if is_wet { (0..densities).map(|d| vec![d]).collect() } else { vec![(0..densities).collect()] };
            for group in groups {
                let sample = at_density(group[0]);
                let options = MonteCarloOptions {
                    rays,
                    seed: Stream::key(job.seed, (grain * per_grain + number(group[0])) as u64),
                    per_wavelength: false,
                };
                let scale = |density: &usize| at_density(*density).density_kg_m3 / sample.density_kg_m3;
                let thicknesses_cm =
                    group.iter().flat_map(|density| axes.thicknesses_cm.iter().map(move |h| h * scale(density)));
                let slab = Slab {
                    sample: *sample,
                    thicknesses_cm: thicknesses_cm.collect(),
                    incidences: axes.incidences(),
                    wavelengths_nm: axes.wavelengths_nm.clone(),
                };
                let solved = monte_carlo::solve(&slab, &options, &|_| ())?;
                for (density, traced) in group.iter().zip(solved.chunks_exact(curves)) {
                    filled.place(axes, traced, (g * per_grain + number(*density)) * curves);
                    let done = (g * per_grain + kind * densities + density + 1) as u64;
                    job.report(FillStage::Solve, done, total);
                }
            }
        }
    }
    let Filled { transmittance, reflectance, errors } = filled;
    Ok(CurveValues { transmittance, reflectance, errors: Some(errors) })
}

/// Values and standard errors, filled sample by sample.
struct Filled {
    transmittance: Vec<f64>,
    reflectance: Vec<f64>,
    errors: StandardErrors,
}

impl Filled {
    fn new(values: usize) -> Self {
        let zeros = || vec![0.0; values];
        let errors = StandardErrors { transmittance: zeros(), reflectance: zeros() };
        Self { transmittance: zeros(), reflectance: zeros(), errors }
    }

    /// Reorders the results of one sample from [thickness][light][wavelength] to [light][thickness][wavelength], and
    /// stores them from index `first` on.
    fn place(&mut self, axes: &Axes, traced: &[Radiometry], first: usize) {
        let (lights, wavelengths) = (axes.incidences().len(), axes.wavelengths_nm.len());
        let thicknesses = axes.thicknesses_cm.len();
        for (number, row) in traced.iter().enumerate() {
            let (t, rest) = (number / (lights * wavelengths), number % (lights * wavelengths));
            let index = first + ((rest / wavelengths) * thicknesses + t) * wavelengths + rest % wavelengths;
            self.transmittance[index] = row.fluxes.transmittance.value;
            self.reflectance[index] = row.fluxes.reflectance.value;
            self.errors.transmittance[index] = row.fluxes.transmittance.standard_error;
            self.errors.reflectance[index] = row.fluxes.reflectance.standard_error;
        }
    }
}
