//! Fills a table by discrete ordinates.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use rayon::prelude::*;
use snowblue_transport::ordinates::{HomogeneousMedium, Light, Peak, StreamGroup, Streams};
use snowblue_transport::sample::SnowSample;
use snowblue_transport::{Demand, GrainTallies, Medium, Population, TallyPlan};

use super::{FillTimes, Values};
use crate::Axes;

/// Grains of a table's samples, with a tally for each facetness that they have.
pub(super) fn fill(
    (axes, samples): (&Axes, &[SnowSample]),
    (streams, rays, seed): (Streams, u32, u64),
    grains: &[usize],
    progress: &(dyn Fn(u64, u64) + Sync),
) -> (Values, FillTimes) {
    let peak = samples.iter().map(Peak::of).max().unwrap_or_default();
    let plan = TallyPlan { degree: streams.most(&axes.incidences(), peak), rays, seed };
    let per_grain = axes.samples_per_grain();
    // One pair of tallies serves all that any sample of the whole table asks for, so that parts have the same bits.
    let first = Demand::of_sample(&samples[0], &axes.wavelengths_nm);
    let demand =
        samples.iter().fold(first, |whole, sample| whole.and(&Demand::of_sample(sample, &axes.wavelengths_nm)));
    let mut tallies: BTreeMap<usize, GrainTallies> = BTreeMap::new();
    let facetness_of = |grain: &usize| grain % axes.facetness.len();
    // A tally takes about as long as ten grains.
    let kinds = grains.iter().map(facetness_of).collect::<std::collections::BTreeSet<_>>();
    let steps = 10 * kinds.len() as u64 + grains.len() as u64;
    let start = Instant::now();
    for facetness in kinds {
        progress(10 * tallies.len() as u64, steps);
        let population = Population::of_sample(&samples[facetness * per_grain]);
        tallies.insert(facetness, GrainTallies::new(&population, &demand, &plan));
    }
    let tally = start.elapsed();
    let start = Instant::now();
    let done = AtomicU64::new(10 * tallies.len() as u64);
    let blocks: Vec<[Vec<f64>; 2]> = grains
        .par_iter()
        .map(|grain| {
            let samples = &samples[grain * per_grain..][..per_grain];
            let block = fill_grain(axes, samples, &tallies[&facetness_of(grain)], streams);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, steps);
            block
        })
        .collect();
    let (transmittance, reflectance) = blocks.into_iter().map(|[t, r]| (t, r)).unzip::<_, _, Vec<_>, Vec<_>>();
    let values = Values { transmittance: transmittance.concat(), reflectance: reflectance.concat(), errors: None };
    (values, FillTimes { tally, solve: start.elapsed() })
}

/// Transmittance and reflectance of the samples of one kind of grain: [sample][light][thickness][wavelength].
fn fill_grain(axes: &Axes, samples: &[SnowSample], tallies: &GrainTallies, streams: Streams) -> [Vec<f64>; 2] {
    let incidences = axes.incidences();
    let (lights, thicknesses, wavelengths) = (incidences.len(), axes.thicknesses_cm.len(), axes.wavelengths_nm.len());
    let block = samples.len() * lights * thicknesses * wavelengths;
    let mut filled = [vec![0.0; block], vec![0.0; block]];
    for (w, wavelength_nm) in axes.wavelengths_nm.iter().enumerate() {
        let media: Vec<Medium> = samples.iter().map(|sample| tallies.medium(sample, *wavelength_nm, None)).collect();
        // Dry and clean samples differ in density alone, and scatter alike.
        let like = |s: usize| media.iter().position(|other| other.scattering == media[s].scattering).unwrap_or(s);
        let like: Vec<usize> = (0..media.len()).map(like).collect();
        let mut modes: BTreeMap<(usize, usize), (HomogeneousMedium, Vec<Light>)> = BTreeMap::new();
        for (s, medium) in media.iter().enumerate() {
            for StreamGroup { streams, places: of_group } in streams.groups(&incidences, Peak::of(&samples[s])) {
                let (modes, lit) = modes.entry((like[s], streams)).or_insert_with(|| {
                    let modes = HomogeneousMedium::new(&medium.scattering, streams);
                    let lit = of_group.iter().map(|light| modes.light(&incidences[*light])).collect();
                    (modes, lit)
                });
                for (t, thickness_cm) in axes.thicknesses_cm.iter().enumerate() {
                    let under_each = modes.fluxes(medium.extinction_per_m * thickness_cm * 0.01, lit);
                    for (light, fluxes) in of_group.iter().zip(under_each) {
                        let place = ((s * lights + light) * thicknesses + t) * wavelengths + w;
                        filled[0][place] = fluxes.transmittance;
                        filled[1][place] = fluxes.reflectance;
                    }
                }
            }
        }
    }
    filled
}
