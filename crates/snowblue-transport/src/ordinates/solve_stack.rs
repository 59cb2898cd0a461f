//! The ordinates' answer for layers of snow on a ground, with the error that the grain tallies leave.
//!
//! Layers of like grains share a tally, and layers that scatter alike share their modes. All tallies take the same
//! scrambles of the sequence, so leaving out a batch leaves it out of all of them.

use rayon::prelude::*;

use super::homogeneous::HomogeneousMedium;
use super::integrals::third_exponential_integral;
use super::jackknife::Jackknife;
use super::layered::{FaceFluxes, LayeredMedium, MediumLayer};
use super::solve::OrdinatesOptions;
use super::streams::{Peak, StreamGroup, Streams};
use crate::TransportError;
use crate::medium::{Demand, GrainTallies, Medium, Population};
use crate::sample::SnowSample;
use crate::slab::{Incidence, Radiometry};
use crate::stack::{DepthFluxes, Layer, Slice, Slices, Stack, StackRadiometry};

/// Tallies of all grains of a stack.
struct Grains {
    tallies: Vec<GrainTallies>,
    /// The tallies of each layer.
    kind_of_layer: Vec<usize>,
}

/// What is known of one light at one wavelength.
#[derive(Clone, Default)]
struct Seen {
    reflectance: f64,
    transmittance: f64,
    optical_depth: f64,
    /// At each depth: fluxes, and the e-folding depth in cm.
    profile: Vec<(FaceFluxes, f64)>,
}

/// Fluxes above, at the depths in, and below a stack: for each incidence, then each wavelength.
///
/// The standard errors are those of the grain tallies, by a jackknife over their batches.
///
/// # Errors
/// If the question or the number of streams is out of range.
pub fn solve_stack(stack: &Stack, options: &OrdinatesOptions) -> Result<Vec<StackRadiometry>, TransportError> {
    stack.check()?;
    options.streams.check()?;
    let grains = Grains::new(stack, options);
    let slices = stack.slices();
    // [wavelength][incidence]
    let spectra: Vec<Vec<StackRadiometry>> = stack
        .wavelengths_nm
        .par_iter()
        .map(|&wavelength_nm| {
            let seen = Jackknife::new(|without| {
                look(stack, &slices, &grains.media(stack, wavelength_nm, without), options.streams)
            });
            (0..stack.incidences.len()).map(|place| answer(stack, (place, wavelength_nm), &seen)).collect()
        })
        .collect();
    let answers = (0..stack.incidences.len()).flat_map(|i| spectra.iter().map(move |spectrum| spectrum[i].clone()));
    Ok(answers.collect())
}

fn answer(stack: &Stack, (place, wavelength_nm): (usize, f64), seen: &Jackknife<Vec<Seen>>) -> StackRadiometry {
    let incidence = stack.incidences[place];
    let absorbed =
        |seen: &Vec<Seen>| 1.0 - seen[place].reflectance - (1.0 - stack.ground_albedo) * seen[place].transmittance;
    let at_depth = |(number, depth_cm): (usize, &f64)| {
        let estimate =
            |quantity: fn(&FaceFluxes) -> f64| seen.estimate(|seen| quantity(&seen[place].profile[number].0));
        DepthFluxes {
            depth_cm: *depth_cm,
            down: estimate(|fluxes| fluxes.down),
            up: estimate(|fluxes| fluxes.up),
            net: estimate(|fluxes| fluxes.net),
            e_folding_depth_cm: seen.estimate(|seen| seen[place].profile[number].1),
        }
    };
    let direct = |optical_depth: f64| match incidence {
        Incidence::Beam { angle_deg } => (-optical_depth / angle_deg.to_radians().cos()).exp(),
        Incidence::Diffuse => 2.0 * third_exponential_integral(optical_depth),
    };
    StackRadiometry {
        whole: Radiometry {
            thickness_cm: stack.thickness_cm(),
            incidence,
            wavelength_nm,
            reflectance: seen.estimate(|seen| seen[place].reflectance),
            transmittance: seen.estimate(|seen| seen[place].transmittance),
            absorptance: seen.estimate(absorbed),
        },
        direct: seen.estimate(|seen| direct(seen[place].optical_depth)).value,
        profile: stack.depths_cm.iter().enumerate().map(at_depth).collect(),
    }
}

/// The sharpest peak of all layers, which have their streams in common.
fn peak(stack: &Stack) -> Peak {
    stack.layers.iter().map(|layer| Peak::of(&layer.sample)).max().unwrap_or_default()
}

/// What each light does in a stack of layers of these media.
fn look(stack: &Stack, cut: &Slices, media: &[Medium], streams: Streams) -> Vec<Seen> {
    let mut all = vec![Seen::default(); stack.incidences.len()];
    // Layers that scatter alike, as those of one snow at several densities do, share their modes.
    let first_alike =
        |layer: usize| media.iter().position(|medium| medium.scattering == media[layer].scattering).unwrap_or(layer);
    let optical_depth = |slice: &Slice| media[slice.layer].extinction_per_m * slice.thickness_cm * 0.01;
    for StreamGroup { streams, places } in streams.groups(&stack.incidences, peak(stack)) {
        let modes: Vec<Option<HomogeneousMedium>> = (0..media.len())
            .map(|layer| {
                (first_alike(layer) == layer).then(|| HomogeneousMedium::new(&media[layer].scattering, streams))
            })
            .collect();
        let modes =
            |layer: usize| modes[first_alike(layer)].as_ref().unwrap_or_else(|| unreachable!("it is the first"));
        let slices: Vec<MediumLayer> = cut
            .slices
            .iter()
            .map(|slice| MediumLayer { medium: modes(slice.layer), optical_depth: optical_depth(slice) })
            .collect();
        let incidences: Vec<Incidence> = places.iter().map(|place| stack.incidences[*place]).collect();
        let pile = LayeredMedium::new(&slices, stack.ground_albedo, &incidences);
        let (top, bottom) = (pile.fluxes(0), pile.fluxes(slices.len()));
        for (i, place) in places.iter().enumerate() {
            all[*place].reflectance = top[i].up;
            all[*place].transmittance = bottom[i].down;
            all[*place].optical_depth = slices.iter().map(|slice| slice.optical_depth).sum();
        }
        for face in &cut.faces {
            let Slice { layer, .. } = cut.slices[(*face).min(slices.len() - 1)];
            let rate_per_cm = modes(layer).decay_rate() * optical_depth(&Slice { layer, thickness_cm: 1.0 });
            for (place, fluxes) in places.iter().zip(pile.fluxes(*face)) {
                all[*place].profile.push((fluxes, 1.0 / rate_per_cm));
            }
        }
    }
    all
}

impl Grains {
    fn new(stack: &Stack, options: &OrdinatesOptions) -> Self {
        let plan = options.plan(&stack.incidences, peak(stack));
        // A sample of each population, with what all of it asks for.
        let mut kinds: Vec<(SnowSample, Demand)> = Vec::new();
        let mut kind_of_layer = Vec::new();
        for Layer { sample, .. } in &stack.layers {
            let demand = Demand::of_sample(sample, &stack.wavelengths_nm);
            let kind = kinds.iter().position(|(other, _)| other.has_grains_of(sample)).unwrap_or(kinds.len());
            match kinds.get_mut(kind) {
                Some((_, whole)) => *whole = whole.and(&demand),
                None => kinds.push((*sample, demand)),
            }
            kind_of_layer.push(kind);
        }
        let tallies =
            kinds.iter().map(|(sample, demand)| GrainTallies::new(&Population::of_sample(sample), demand, &plan));
        Self { tallies: tallies.collect(), kind_of_layer }
    }

    /// The medium of each layer at a wavelength.
    fn media(&self, stack: &Stack, wavelength_nm: f64, without: Option<usize>) -> Vec<Medium> {
        let layers = stack.layers.iter().zip(&self.kind_of_layer);
        layers.map(|(layer, kind)| self.tallies[*kind].medium(&layer.sample, wavelength_nm, without)).collect()
    }
}
