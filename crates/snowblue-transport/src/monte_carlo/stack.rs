//! Layers of different snow on a Lambertian ground by Monte Carlo, each wavelength separately: the check of the layered
//! ordinates.
//!
//! Free flights are drawn in optical depth across all layers; the layer at their end provides the grain. The ground
//! reflects a ray with the probability of its albedo. A ray counts in the transmittance each time that it arrives at
//! the ground.

use super::options::{MonteCarloOptions, RayProgress, check_rays, cos_incidence};
use super::rays::sum_over_rays;
use super::walk::{Absorption, Paths, Scatterers, scattered_cosine};
use crate::TransportError;
use crate::medium::{Constituents, hit_size_m};
use crate::rng::Stream;
use crate::slab::{Radiometry, THICKNESS_RANGE};
use crate::stack::{Layer, Stack};

/// A layer at one wavelength.
struct OpticalLayer {
    scatterers: Scatterers,
    absorption: Absorption,
    /// Optical depths of its top and bottom below the top of the stack.
    top: f64,
    bottom: f64,
    /// Optical depth of absorption in the pores above it, along the vertical.
    pores_above: f64,
}

/// Reflectance, flux that arrives at the ground, and absorptance of the snow, for each incidence, then each wavelength.
///
/// `progress` is called with the number of rays traced.
///
/// # Errors
/// If a parameter is out of range, and for a half-space.
pub fn solve_stack(
    stack: &Stack,
    options: &MonteCarloOptions,
    progress: &(dyn Fn(RayProgress) + Sync),
) -> Result<Vec<Radiometry>, TransportError> {
    stack.check()?;
    stack.layers.iter().try_for_each(|layer| THICKNESS_RANGE.check(layer.thickness_cm))?;
    check_rays(options.rays)?;
    let mut answer = Vec::new();
    let total = (stack.incidences.len() * stack.wavelengths_nm.len()) as u64 * options.rays;
    for &incidence in &stack.incidences {
        for &wavelength_nm in &stack.wavelengths_nm {
            let layers = optical_layers(stack, wavelength_nm);
            // The inverted seed makes the streams independent of those of slabs.
            let seed = Stream::key(!options.seed, answer.len() as u64);
            let sums = sum_over_rays(options.rays, |ray| {
                let mut stream = Stream::new(seed, ray);
                let cosine = cos_incidence(incidence, &mut stream);
                let [reflected, arrived] = trace_ray(&layers, stack.ground_albedo, cosine, &mut stream);
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
            progress(RayProgress { traced: answer.len() as u64 * options.rays, total });
        }
    }
    Ok(answer)
}

fn optical_layers(stack: &Stack, wavelength_nm: f64) -> Vec<OpticalLayer> {
    let (mut bottom, mut pores_above) = (0.0, 0.0);
    let layer = |Layer { sample, thickness_cm }: &Layer| {
        let constituents = Constituents::new(sample, wavelength_nm);
        let scatterers = Scatterers::new(sample, &constituents);
        let absorption = Absorption::new(&constituents, &scatterers);
        let (top, above) = (bottom, pores_above);
        bottom += scatterers.extinction_per_m * thickness_cm * 0.01;
        pores_above += constituents.pore_absorption_per_m * thickness_cm * 0.01;
        OpticalLayer { scatterers, absorption, top, bottom, pores_above: above }
    };
    stack.layers.iter().map(layer).collect()
}

/// The layer at an optical depth, or the last one.
fn layer_at(layers: &[OpticalLayer], depth: f64) -> &OpticalLayer {
    &layers[layers.partition_point(|layer| layer.bottom <= depth).min(layers.len() - 1)]
}

/// Optical depth of absorption in the pores down to an optical depth, along the vertical.
fn pore_absorption(layers: &[OpticalLayer], depth: f64) -> f64 {
    let layer = layer_at(layers, depth);
    layer.pores_above + layer.absorption.free * (depth - layer.top)
}

/// Traces a ray: the weight that leaves the top, and the weight that arrives at the ground.
fn trace_ray(layers: &[OpticalLayer], ground_albedo: f64, cos_incidence: f64, stream: &mut Stream) -> [f64; 2] {
    let ground = layers[layers.len() - 1].bottom;
    let (mut depth, mut cosine) = (0.0, cos_incidence);
    let (mut absorbed, mut arrived) = (0.0_f64, 0.0);
    loop {
        let beyond = depth - stream.uniform().ln() * cosine;
        let next = beyond.clamp(0.0, ground);
        absorbed += ((pore_absorption(layers, next) - pore_absorption(layers, depth)) / cosine).abs();
        depth = next;
        // Without snow a downward ray reaches the ground, not the top.
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
        let layer = layer_at(layers, depth);
        let collision = layer.scatterers.collide(stream);
        let mut paths = Paths::default();
        collision.add_ice_path(hit_size_m(&layer.scatterers.size, stream), &mut paths);
        absorbed += layer.absorption.in_ice(paths.ice_m);
        cosine = scattered_cosine(cosine, collision.cos_scattering, stream);
    }
}
