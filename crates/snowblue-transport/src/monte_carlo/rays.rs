//! Sums over rays that do not depend on the number of threads.

use rayon::prelude::*;

use crate::slab::Estimate;

/// Rays per task.
const RAYS_PER_TASK: u64 = 64;
/// Tasks whose sums are held in memory at a time.
const TASKS_PER_BLOCK: usize = 1 << 12;
/// Rays whose results are held in memory at a time.
const RAYS_PER_BLOCK: usize = 1 << 15;

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

/// Mean of a quantity over `rays` rays, and its standard error, from the sum of its values and that of their squares.
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
