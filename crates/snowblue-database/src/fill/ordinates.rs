//! Fills a table by discrete ordinates.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use snowblue_transport::ordinates::{HomogeneousMedium, Light, Peak, StreamGroup, Streams};
use snowblue_transport::sample::SnowSample;
use snowblue_transport::{Demand, GrainTallies, Medium, Population, TallyPlan};

use super::job::{FillJob, FillStage};
use crate::Axes;
use crate::table::CurveValues;

/// Progress steps of a tally, which takes about as long as ten grains.
const STEPS_PER_TALLY: u64 = 10;

/// Transmittance and reflectance of the samples of one grain: [sample][light][thickness][wavelength].
struct GrainValues {
    transmittance: Vec<f64>,
    reflectance: Vec<f64>,
}

/// Fills the grains of a job, with a tally of `rays` for each facetness.
pub(super) fn fill(job: &FillJob, streams: Streams, rays: u32) -> CurveValues {
    let FillJob { axes, samples, grains, .. } = job;
    let peak = samples.iter().map(Peak::of).max().unwrap_or_default();
    let plan = TallyPlan { degree: streams.most(&axes.incidences(), peak), rays, seed: job.seed };
    let per_grain = axes.samples_per_grain();
    // The tallies cover every sample of the whole table, so that parts of it have the same bits.
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
        let media: Vec<Medium> = samples.iter().map(|sample| tallies.medium(sample, *wavelength_nm, None)).collect();
        // Dry and clean samples that differ only in density have the same scattering.
        let same = |s: usize| media.iter().position(|other| other.scattering == media[s].scattering).unwrap_or(s);
        let same: Vec<usize> = (0..media.len()).map(same).collect();
        let mut modes: BTreeMap<(usize, usize), (HomogeneousMedium, Vec<Light>)> = BTreeMap::new();
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
