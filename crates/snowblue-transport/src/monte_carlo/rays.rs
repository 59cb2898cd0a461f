//! The rays of a computation: how many there are, their cosines of incidence, and sums over them that do not depend on
//! the number of threads.

use rayon::prelude::*;
use snowblue_base::{ParameterRange, RangeError};

use crate::rng::Stream;
use crate::slab::{Estimate, Incidence};

/// Number of rays.
const RAY_RANGE: ParameterRange = ParameterRange { quantity: "number of rays", least: 2.0, greatest: 1e12, unit: "" };
/// Rays per wavelength in the paper.
pub const DEFAULT_RAYS: u64 = 100_000;
/// Rays per task.
const RAYS_PER_TASK: u64 = 64;
/// Tasks whose sums are held in memory at a time.
const TASKS_PER_BLOCK: usize = 1 << 12;
/// Rays whose results are held in memory at a time.
const RAYS_PER_BLOCK: usize = 1 << 15;

/// Options of the Monte Carlo engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MonteCarloOptions {
    /// Rays per incidence and index node (per incidence and wavelength in snow with impurities or with more than half
    /// of its pores filled by water); with `per_wavelength`, rays per incidence, thickness and wavelength.
    pub rays: u64,
    /// Seed of all randomness.
    pub seed: u64,
    /// Whether to trace each wavelength and thickness separately, as in the paper.
    pub per_wavelength: bool,
}

/// Progress of a computation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RayProgress {
    /// Rays traced so far.
    pub traced: u64,
    /// Rays to trace in all.
    pub total: u64,
}

impl Default for MonteCarloOptions {
    fn default() -> Self {
        Self { rays: DEFAULT_RAYS, seed: 1, per_wavelength: false }
    }
}

pub(super) fn check_rays(rays: u64) -> Result<(), RangeError> {
    RAY_RANGE.check(rays as f64)
}

/// Cosine from the normal of an incident ray; for Lambertian light μ² is uniform.
pub(super) fn cos_incidence(incidence: Incidence, stream: &mut Stream) -> f64 {
    match incidence {
        Incidence::Beam { angle_deg } => angle_deg.to_radians().cos(),
        Incidence::Diffuse => stream.uniform().sqrt(),
    }
}

/// Sums and sums of squares of N quantities over rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sums<const N: usize> {
    first: [f64; N],
    second: [f64; N],
}

/// Traces rays 0 … `rays` − 1 and sums the results of `trace` in ray order.
pub(crate) fn sum_over_rays<const N: usize>(rays: u64, trace: impl Fn(u64) -> [f64; N] + Sync) -> Sums<N> {
    let task = |task: u64| {
        let mut sums = Sums { first: [0.0; N], second: [0.0; N] };
        for ray in task * RAYS_PER_TASK..((task + 1) * RAYS_PER_TASK).min(rays) {
            for (i, value) in trace(ray).into_iter().enumerate() {
                sums.first[i] += value;
                sums.second[i] += value * value;
            }
        }
        sums
    };
    let mut total = Sums { first: [0.0; N], second: [0.0; N] };
    let tasks = rays.div_ceil(RAYS_PER_TASK);
    for first in (0..tasks).step_by(TASKS_PER_BLOCK) {
        let last = (first + TASKS_PER_BLOCK as u64).min(tasks);
        let parts: Vec<Sums<N>> = (first..last).into_par_iter().map(task).collect();
        for part in parts {
            for i in 0..N {
                total.first[i] += part.first[i];
                total.second[i] += part.second[i];
            }
        }
    }
    total
}

/// Traces rays 0 … `rays` − 1 and passes the results of `trace` to `take` in ray order, block by block.
///
/// For rays that each add to a few of many sums.
pub(crate) fn trace_in_order<T: Send>(rays: u64, trace: impl Fn(u64) -> T + Sync, mut take: impl FnMut(&[T])) {
    for first in (0..rays).step_by(RAYS_PER_BLOCK) {
        let last = (first + RAYS_PER_BLOCK as u64).min(rays);
        let block: Vec<T> = (first..last).into_par_iter().map(&trace).collect();
        take(&block);
    }
}

/// Mean of a quantity over `rays` rays, and its standard error, from the sums of its values and of their squares.
pub(crate) fn estimate(first: f64, second: f64, rays: u64) -> Estimate {
    let count = rays as f64;
    let mean = first / count;
    let variance = (second / count - mean * mean).max(0.0);
    Estimate { value: mean, standard_error: (variance / (count - 1.0).max(1.0)).sqrt() }
}

impl<const N: usize> Sums<N> {
    /// Mean of quantity `i` over `rays` rays, and its standard error.
    pub(crate) fn estimate(&self, i: usize, rays: u64) -> Estimate {
        estimate(self.first[i], self.second[i], rays)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_ray_has_no_error_and_too_many_are_refused() {
        assert!(check_rays(2).is_ok() && check_rays(1_000_000_000_000).is_ok());
        let message = check_rays(1).unwrap_err().to_string();
        assert_eq!(message, "number of rays is 1, but must lie in 2–1000000000000");
        assert!(check_rays(1_000_000_000_001).is_err());
    }
}
