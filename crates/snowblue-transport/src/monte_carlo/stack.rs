//! Rays through layers of different snow over a Lambertian ground, each wavelength on its own: the check of the layered
//! ordinates.
//!
//! Free flights in optical depth do not know of layers; only the grains that are met do. A ray that reaches the ground is
//! sent back with the chance of its albedo, and counts as often as it arrives.

use super::options::{MonteCarloOptions, check_rays, cos_incidence};
use super::rays::sum_over_rays;
use super::walk::{Absorption, Paths, Scatterers, turn};
use crate::TransportError;
use crate::medium::{Constituents, hit_size_m};
use crate::rng::Stream;
use crate::slab::Radiometry;
use crate::stack::{Layer, Stack};

/// A layer at one wavelength.
struct Bed {
    scatterers: Scatterers,
    absorption: Absorption,
    /// Optical depths of its faces below the top.
    top: f64,
    bottom: f64,
    /// What the pores above it absorb of light that comes straight down, as an optical depth.
    pores_above: f64,
}

/// Reflectance, flux that arrives at the ground, and absorptance of the snow: for each incidence, then each wavelength.
///
/// `progress` is told how many of how many rays are traced.
///
/// # Errors
/// If the question is out of range.
pub fn solve_stack(
    stack: &Stack,
    options: &MonteCarloOptions,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Vec<Radiometry>, TransportError> {
    stack.check()?;
    check_rays(options.rays)?;
    let mut answer = Vec::new();
    let all = (stack.incidences.len() * stack.wavelengths_nm.len()) as u64 * options.rays;
    for &incidence in &stack.incidences {
        for &wavelength_nm in &stack.wavelengths_nm {
            let beds = beds(stack, wavelength_nm);
            // Other streams than those of slabs without layers.
            let seed = Stream::key(!options.seed, answer.len() as u64);
            let sums = sum_over_rays(options.rays, |ray| {
                let mut stream = Stream::new(seed, ray);
                let cosine = cos_incidence(incidence, &mut stream);
                let [reflected, arrived] = pass(&beds, stack.ground_albedo, cosine, &mut stream);
                [reflected, arrived, 1.0 - reflected - (1.0 - stack.ground_albedo) * arrived]
            });
            answer.push(Radiometry {
                thickness_cm: stack.thickness_cm(),
                incidence,
                wavelength_nm,
                reflectance: sums.estimate(0, options.rays),
                transmittance: sums.estimate(1, options.rays),
                absorptance: sums.estimate(2, options.rays),
            });
            progress(answer.len() as u64 * options.rays, all);
        }
    }
    Ok(answer)
}

fn beds(stack: &Stack, wavelength_nm: f64) -> Vec<Bed> {
    let (mut bottom, mut pores_above) = (0.0, 0.0);
    let bed = |Layer { sample, thickness_cm }: &Layer| {
        let met = Constituents::new(sample, wavelength_nm);
        let scatterers = Scatterers::new(sample, &met);
        let absorption = Absorption::new(&met, &scatterers);
        let (top, above) = (bottom, pores_above);
        bottom += scatterers.extinction_per_m * thickness_cm * 0.01;
        pores_above += met.pore_absorption_per_m * thickness_cm * 0.01;
        Bed { scatterers, absorption, top, bottom, pores_above: above }
    };
    stack.layers.iter().map(bed).collect()
}

/// The layer at an optical depth; beyond the last, that.
fn at(beds: &[Bed], depth: f64) -> &Bed {
    &beds[beds.partition_point(|bed| bed.bottom <= depth).min(beds.len() - 1)]
}

/// What pores down to an optical depth absorb of light that comes straight down.
fn pores(beds: &[Bed], depth: f64) -> f64 {
    let bed = at(beds, depth);
    bed.pores_above + bed.absorption.free * (depth - bed.top)
}

/// Weight that leaves on top, and weight that arrives at the ground, of one ray.
fn pass(beds: &[Bed], ground_albedo: f64, cos_incidence: f64, stream: &mut Stream) -> [f64; 2] {
    let ground = beds[beds.len() - 1].bottom;
    let (mut depth, mut cosine) = (0.0, cos_incidence);
    let (mut absorbed, mut arrived) = (0.0_f64, 0.0);
    loop {
        let beyond = depth - stream.uniform().ln() * cosine;
        let next = beyond.clamp(0.0, ground);
        absorbed += ((pores(beds, next) - pores(beds, depth)) / cosine).abs();
        depth = next;
        // Where nothing lies, the way down is to the ground.
        if cosine < 0.0 && beyond <= 0.0 {
            return [(-absorbed).exp(), arrived];
        }
        if beyond >= ground {
            arrived += (-absorbed).exp();
            if stream.uniform() >= ground_albedo {
                return [0.0, arrived];
            }
            (depth, cosine) = (ground, -stream.uniform().sqrt());
            continue;
        }
        let bed = at(beds, depth);
        let met = bed.scatterers.meet(stream);
        let mut paths = Paths::default();
        met.lengthen(hit_size_m(&bed.scatterers.size, stream), &mut paths);
        absorbed += bed.absorption.in_ice(paths.ice_m);
        cosine = turn(cosine, met.cos_scattering, stream);
    }
}
