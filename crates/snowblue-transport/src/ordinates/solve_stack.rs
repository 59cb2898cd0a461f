//! The ordinates' answer for layers of snow on a ground, with the error that the grain tallies leave.
//!
//! Layers of like grains share a tally, and layers that scatter alike share their modes. All tallies take the same
//! scrambles of the sequence, so leaving out a batch leaves it out of all of them.

use rayon::prelude::*;

use super::integrals::third_exponential_integral;
use super::jackknife::Jackknife;
use super::phase::Scattering;
use super::slab::HomogeneousMedium;
use super::solve::{OrdinatesOptions, index_range, most_absorption};
use super::stack::{FaceFluxes, LayeredMedium};
use super::streams::Streams;
use crate::TransportError;
use crate::ice::Ice;
use crate::population::Population;
use crate::sample::SnowSample;
use crate::slab::{Incidence, Radiometry};
use crate::stack::{DepthFluxes, Stack, StackRadiometry};
use crate::tally::{Tally, TallyPlan};

/// Tallies of all grains of a stack.
struct Grains {
    tallies: Vec<Tally>,
    /// A sample for each kind of scattering, with the number of its tally.
    kinds: Vec<(SnowSample, usize)>,
    /// The kind of each layer.
    kind_of_layer: Vec<usize>,
}

/// What is known of one light at one wavelength.
#[derive(Clone, Default)]
struct Seen {
    reflectance: f64,
    transmittance: f64,
    /// At each depth: fluxes, and the e-folding depth in cm.
    profile: Vec<(FaceFluxes, f64)>,
}

/// A stack cut at its depths: slices of layers with their optical depths, and the face at each depth.
struct Cut {
    slices: Vec<(usize, f64)>,
    faces: Vec<usize>,
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
    let (slices, faces) = stack.slices();
    let optical = |(layer, thickness_cm): (usize, f64)| (layer, stack.layers[layer].optical_depth(thickness_cm));
    let cut = Cut { slices: slices.into_iter().map(optical).collect(), faces };
    // [wavelength][incidence]
    let spectra: Vec<Vec<StackRadiometry>> = stack
        .wavelengths_nm
        .par_iter()
        .map(|&wavelength_nm| {
            let seen = Jackknife::new(|without| {
                look(stack, &cut, &grains.scattering(wavelength_nm, without), options.streams)
            });
            (0..stack.incidences.len()).map(|place| answer(stack, &cut, (place, wavelength_nm), &seen)).collect()
        })
        .collect();
    let answers = (0..stack.incidences.len()).flat_map(|i| spectra.iter().map(move |spectrum| spectrum[i].clone()));
    Ok(answers.collect())
}

fn answer(
    stack: &Stack,
    cut: &Cut,
    (place, wavelength_nm): (usize, f64),
    seen: &Jackknife<Vec<Seen>>,
) -> StackRadiometry {
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
    let optical_depth: f64 = cut.slices.iter().map(|(_, optical_depth)| optical_depth).sum();
    StackRadiometry {
        whole: Radiometry {
            thickness_cm: stack.thickness_cm(),
            incidence,
            wavelength_nm,
            reflectance: seen.estimate(|seen| seen[place].reflectance),
            transmittance: seen.estimate(|seen| seen[place].transmittance),
            absorptance: seen.estimate(absorbed),
        },
        direct: match incidence {
            Incidence::Beam { angle_deg } => (-optical_depth / angle_deg.to_radians().cos()).exp(),
            Incidence::Diffuse => 2.0 * third_exponential_integral(optical_depth),
        },
        profile: stack.depths_cm.iter().enumerate().map(at_depth).collect(),
    }
}

/// What each light does in a stack whose kinds of snow scatter like `scattering`.
fn look(stack: &Stack, cut: &Cut, scattering: &LayerScattering, streams: Streams) -> Vec<Seen> {
    let mut all = vec![Seen::default(); stack.incidences.len()];
    for (streams, places) in streams.groups(&stack.incidences) {
        let media: Vec<HomogeneousMedium> =
            scattering.kinds.iter().map(|kind| HomogeneousMedium::new(kind, streams)).collect();
        let medium = |layer: usize| &media[scattering.kind_of_layer[layer]];
        let slices: Vec<_> = cut.slices.iter().map(|(layer, depth)| (medium(*layer), *depth)).collect();
        let incidences: Vec<Incidence> = places.iter().map(|place| stack.incidences[*place]).collect();
        let pile = LayeredMedium::new(&slices, stack.ground_albedo, &incidences);
        let (top, bottom) = (pile.fluxes(0), pile.fluxes(slices.len()));
        for (i, place) in places.iter().enumerate() {
            all[*place].reflectance = top[i].up;
            all[*place].transmittance = bottom[i].down;
        }
        for face in &cut.faces {
            let (layer, _) = cut.slices[(*face).min(slices.len() - 1)];
            let rate_per_cm = medium(layer).decay_rate() * stack.layers[layer].optical_depth(1.0);
            for (place, fluxes) in places.iter().zip(pile.fluxes(*face)) {
                all[*place].profile.push((fluxes, 1.0 / rate_per_cm));
            }
        }
    }
    all
}

/// Single scattering of each kind of snow at one wavelength.
struct LayerScattering<'g> {
    kinds: Vec<Scattering>,
    kind_of_layer: &'g [usize],
}

impl Grains {
    fn new(stack: &Stack, options: &OrdinatesOptions) -> Self {
        let all_ice = || stack.layers.iter().map(|layer| (Ice::new(layer.sample.ice), layer.sample.grain_size.max_um));
        let most = all_ice().map(|(ice, max_um)| most_absorption(&ice, &stack.wavelengths_nm, max_um));
        let plan = TallyPlan {
            degree: options.streams.most(&stack.incidences),
            most_absorption: most.fold(0.0, f64::max),
            rays: options.tally_rays,
            seed: options.seed,
        };
        let mut grains = Self { tallies: Vec::new(), kinds: Vec::new(), kind_of_layer: Vec::new() };
        for layer in &stack.layers {
            let sample = layer.sample;
            let like_grains = |(other, _): &&(SnowSample, usize)| {
                (other.sphericity, other.facetness, other.grain_size.measure, other.ice)
                    == (sample.sphericity, sample.facetness, sample.grain_size.measure, sample.ice)
            };
            let tally = grains.kinds.iter().find(like_grains).map_or_else(
                || {
                    let range = index_range(&Ice::new(sample.ice), &stack.wavelengths_nm);
                    grains.tallies.push(Tally::new(&Population::of_sample(&sample), range, &plan));
                    grains.tallies.len() - 1
                },
                |(_, tally)| *tally,
            );
            let alike = |(other, of): &(SnowSample, usize)| *of == tally && other.grain_size == sample.grain_size;
            let kind = grains.kinds.iter().position(alike).unwrap_or_else(|| {
                grains.kinds.push((sample, tally));
                grains.kinds.len() - 1
            });
            grains.kind_of_layer.push(kind);
        }
        grains
    }

    fn scattering(&self, wavelength_nm: f64, without: Option<usize>) -> LayerScattering<'_> {
        let of_kind = |(sample, tally): &(SnowSample, usize)| {
            let (tally, ice) = (&self.tallies[*tally], Ice::new(sample.ice));
            match without {
                None => tally.scattering(&sample.grain_size, &ice, wavelength_nm),
                Some(batch) => tally.scattering_without(batch, &sample.grain_size, &ice, wavelength_nm),
            }
        };
        LayerScattering { kinds: self.kinds.iter().map(of_kind).collect(), kind_of_layer: &self.kind_of_layer }
    }
}
