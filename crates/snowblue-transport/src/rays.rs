//! Many rays on many threads, summed in one order.

use rayon::prelude::*;

/// Rays that one task traces before its sums are added to the others'.
const RAYS_PER_TASK: u64 = 64;

/// Sums and sums of squares of N quantities over rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sums<const N: usize> {
    first: [f64; N],
    second: [f64; N],
}

/// Traces rays 0 … `rays` − 1 and adds up what `trace` returns, in ray order, whatever the number of threads.
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
    let parts: Vec<Sums<N>> = (0..rays.div_ceil(RAYS_PER_TASK)).into_par_iter().map(task).collect();
    let mut total = Sums { first: [0.0; N], second: [0.0; N] };
    for part in parts {
        for i in 0..N {
            total.first[i] += part.first[i];
            total.second[i] += part.second[i];
        }
    }
    total
}

impl<const N: usize> Sums<N> {
    /// Mean of quantity `i` over `rays` rays, and its standard error.
    pub(crate) fn estimate(&self, i: usize, rays: u64) -> crate::slab::Estimate {
        let count = rays as f64;
        let mean = self.first[i] / count;
        let variance = (self.second[i] / count - mean * mean).max(0.0);
        crate::slab::Estimate { value: mean, standard_error: (variance / (count - 1.0).max(1.0)).sqrt() }
    }
}
