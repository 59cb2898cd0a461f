//! Layers of snow on a ground by discrete ordinates, with the standard errors of the grain tallies.
//!
//! Layers with the same grain shapes share a tally, and layers with the same single scattering share their modes. All
//! tallies use the same scrambles of the sequence, so the jackknife leaves out the same batch of all of them.

use rayon::prelude::*;

use super::homogeneous::HomogeneousMedium;
use super::integrals::third_exponential_integral;
use super::jackknife::Jackknife;
use super::layered::{FaceFluxes, LayeredMedium, MediumLayer};
use super::options::OrdinatesOptions;
use super::streams::{Peak, StreamGroup, Streams};
use crate::TransportError;
use crate::medium::{Demand, GrainTallies, Medium, Population};
use crate::sample::SnowSample;
use crate::slab::{Incidence, Radiometry};
use crate::stack::{DepthFluxes, Layer, Slice, Slices, Stack, StackRadiometry};

/// Tallies of the grains of a stack.
struct Grains {
    tallies: Vec<GrainTallies>,
    /// The tallies of each layer.
    kind_of_layer: Vec<usize>,
}

/// Fluxes of a stack for one incidence at one wavelength.
#[derive(Clone, Default)]
struct StackFluxes {
    reflectance: f64,
    transmittance: f64,
    optical_depth: f64,
    /// At each depth.
    profile: Vec<ProfilePoint>,
}

/// Fluxes and e-folding depth at one depth.
#[derive(Clone, Copy)]
struct ProfilePoint {
    fluxes: FaceFluxes,
    fluence: f64,
    absorption_per_m: f64,
    e_folding_depth_cm: f64,
}

/// Fluxes above a stack, at its depths, and below it, for each incidence, then each wavelength.
///
/// The standard errors are those of the grain tallies, by a jackknife over their batches.
///
/// # Errors
/// If a parameter or the number of streams is out of range.
pub fn solve_stack(stack: &Stack, options: &OrdinatesOptions) -> Result<Vec<StackRadiometry>, TransportError> {
    solve_with(stack, options, true)
}

/// As [`solve_stack`], without standard errors, which are NaN: they take most of the time once the grains are tallied.
///
/// # Errors
/// If a parameter or the number of streams is out of range.
pub fn solve_stack_without_errors(
    stack: &Stack,
    options: &OrdinatesOptions,
) -> Result<Vec<StackRadiometry>, TransportError> {
    solve_with(stack, options, false)
}

fn solve_with(stack: &Stack, options: &OrdinatesOptions, errors: bool) -> Result<Vec<StackRadiometry>, TransportError> {
    stack.check()?;
    options.streams.check()?;
    let grains = Grains::new(stack, options);
    let slices = stack.slices();
    // [wavelength][incidence]
    let spectra: Vec<Vec<StackRadiometry>> = stack
        .wavelengths_nm
        .par_iter()
        .map(|&wavelength_nm| {
            let fluxes =
                |without| stack_fluxes(stack, &slices, &grains.media(stack, wavelength_nm, without), options.streams);
            let jackknife = if errors { Jackknife::new(fluxes) } else { Jackknife::without_errors(fluxes) };
            (0..stack.incidences.len()).map(|place| radiometry(stack, place, wavelength_nm, &jackknife)).collect()
        })
        .collect();
    let answers = (0..stack.incidences.len()).flat_map(|i| spectra.iter().map(move |spectrum| spectrum[i].clone()));
    Ok(answers.collect())
}

fn radiometry(
    stack: &Stack,
    place: usize,
    wavelength_nm: f64,
    jackknife: &Jackknife<Vec<StackFluxes>>,
) -> StackRadiometry {
    let incidence = stack.incidences[place];
    let absorbed = |fluxes: &Vec<StackFluxes>| {
        1.0 - fluxes[place].reflectance - (1.0 - stack.ground_albedo) * fluxes[place].transmittance
    };
    let at_depth = |(number, depth_cm): (usize, &f64)| {
        let estimate =
            |quantity: fn(&ProfilePoint) -> f64| jackknife.estimate(|all| quantity(&all[place].profile[number]));
        DepthFluxes {
            depth_cm: *depth_cm,
            down: estimate(|at| at.fluxes.down),
            up: estimate(|at| at.fluxes.up),
            net: estimate(|at| at.fluxes.net),
            fluence: estimate(|at| at.fluence),
            absorbed_per_m: estimate(|at| at.absorption_per_m * at.fluence),
            e_folding_depth_cm: estimate(|at| at.e_folding_depth_cm),
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
            reflectance: jackknife.estimate(|fluxes| fluxes[place].reflectance),
            transmittance: jackknife.estimate(|fluxes| fluxes[place].transmittance),
            absorptance: jackknife.estimate(absorbed),
        },
        direct: jackknife.estimate(|fluxes| direct(fluxes[place].optical_depth)).value,
        profile: stack.depths_cm.iter().enumerate().map(at_depth).collect(),
    }
}

/// The sharpest peak of all layers, which use the same number of streams.
fn peak(stack: &Stack) -> Peak {
    stack.layers.iter().map(|layer| Peak::of(&layer.sample)).max().unwrap_or_default()
}

/// Fluxes of a stack with layers of these media under each incidence.
fn stack_fluxes(stack: &Stack, cut: &Slices, media: &[Medium], streams: Streams) -> Vec<StackFluxes> {
    let mut all = vec![StackFluxes::default(); stack.incidences.len()];
    // Layers with the same single scattering, as of one snow at several densities, share their modes.
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
        let layered = LayeredMedium::new(&slices, stack.ground_albedo, &incidences);
        let (top, bottom) = (layered.fluxes(0), layered.fluxes(slices.len()));
        for (i, place) in places.iter().enumerate() {
            all[*place].reflectance = top[i].up;
            all[*place].transmittance = bottom[i].down;
            all[*place].optical_depth = slices.iter().map(|slice| slice.optical_depth).sum();
        }
        for face in &cut.faces {
            let layer = cut.layer_below(*face);
            let rate_per_cm = modes(layer).decay_rate() * optical_depth(&Slice { layer, thickness_cm: 1.0 });
            let absorption_per_m = media[layer].extinction_per_m * media[layer].scattering.one_minus_albedo;
            let at_face = layered.fluxes(*face).into_iter().zip(layered.fluence_rates(*face));
            for (place, (fluxes, fluence)) in places.iter().zip(at_face) {
                let e_folding_depth_cm = 1.0 / rate_per_cm;
                all[*place].profile.push(ProfilePoint { fluxes, fluence, absorption_per_m, e_folding_depth_cm });
            }
        }
    }
    all
}

impl Grains {
    fn new(stack: &Stack, options: &OrdinatesOptions) -> Self {
        let plan = options.plan(&stack.incidences, peak(stack));
        // A sample of each kind of grains, with the demand of all layers of that kind.
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
