//! Rays through layers of different snow over a Lambertian ground, each wavelength on its own: the check of the layered
//! ordinates.
//!
//! Free flights in optical depth do not know of layers; only the grains that are met do. A ray that reaches the ground is
//! sent back with the chance of its albedo, and counts as often as it arrives.

use super::walk::{Medium, turn};
use super::{MonteCarloOptions, check_rays, cos_incidence};
use crate::TransportError;
use crate::ice::Ice;
use crate::population::hit_size_m;
use crate::rays::sum_over_rays;
use crate::rng::Stream;
use crate::slab::Radiometry;
use crate::stack::{Layer, Stack};

/// A layer at one wavelength.
struct Bed {
    medium: Medium,
    absorption_per_m: f64,
    /// Optical depth of its lower face below the top.
    bottom: f64,
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
    let mut bottom = 0.0;
    let bed = |layer: &Layer| {
        let ice = Ice::new(layer.sample.ice);
        bottom += layer.optical_depth(layer.thickness_cm);
        Bed {
            medium: Medium::new(&layer.sample, ice.index(wavelength_nm)),
            absorption_per_m: ice.absorption_per_m(wavelength_nm),
            bottom,
        }
    };
    stack.layers.iter().map(bed).collect()
}

/// Weight that leaves on top, and weight that arrives at the ground, of one ray.
fn pass(beds: &[Bed], ground_albedo: f64, cos_incidence: f64, stream: &mut Stream) -> [f64; 2] {
    let ground = beds[beds.len() - 1].bottom;
    let (mut depth, mut cosine) = (0.0, cos_incidence);
    let (mut absorbed, mut arrived) = (0.0_f64, 0.0);
    loop {
        depth -= stream.uniform().ln() * cosine;
        if depth <= 0.0 {
            return [(-absorbed).exp(), arrived];
        }
        if depth >= ground {
            arrived += (-absorbed).exp();
            if stream.uniform() >= ground_albedo {
                return [0.0, arrived];
            }
            (depth, cosine) = (ground, -stream.uniform().sqrt());
            continue;
        }
        let bed = &beds[beds.partition_point(|bed| bed.bottom <= depth)];
        let grain = bed.medium.population.grain([stream.uniform(), stream.uniform()], bed.medium.relative_index);
        let scattered = grain.scatter(stream);
        absorbed += bed.absorption_per_m * scattered.ice_path * hit_size_m(&bed.medium.size, stream);
        cosine = turn(cosine, scattered.cos_scattering, stream);
    }
}
