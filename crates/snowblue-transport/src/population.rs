//! Grains as light meets them: drawn in proportion to their projected area.

use crate::grain::Spheroid;
use crate::rng::Stream;
use crate::sample::{GrainSize, Quantiles, SizeMeasure, SnowSample, TruncatedNormal};
use crate::scatter::{Grain, ROUGHNESS_PER_FACETNESS};

/// The laws of shape and facetness of the grains that light hits. Sizes do not change directions and stand apart.
#[derive(Debug, Clone)]
pub struct Population {
    sphericity: Quantiles,
    facetness: Quantiles,
    measure: SizeMeasure,
}

impl Population {
    /// The grains of a sample.
    #[must_use]
    pub fn of_sample(sample: &SnowSample) -> Self {
        Self::new(&sample.sphericity, &sample.facetness, sample.grain_size.measure)
    }

    /// Grains of given laws, number-weighted, whose sizes are given by `measure`.
    #[must_use]
    pub fn new(sphericity: &TruncatedNormal, facetness: &TruncatedNormal, measure: SizeMeasure) -> Self {
        Self {
            sphericity: sphericity.weighted(|psi| Spheroid::of_unit_size(psi, measure).surface()),
            facetness: facetness.weighted(|_| 1.0),
            measure,
        }
    }

    /// The hit grain that belongs to two uniform numbers, in ice of the given index.
    #[inline]
    pub(crate) fn grain(&self, [shape, facetness]: [f64; 2], relative_index: f64) -> Grain {
        Grain {
            shape: Spheroid::of_unit_size(self.sphericity.at(shape), self.measure),
            roughness: ROUGHNESS_PER_FACETNESS * self.facetness.at(facetness),
            relative_index,
        }
    }
}

/// The size of a hit grain, in m: uniform in number, weighted with its square.
#[inline]
pub(crate) fn hit_size_m(size: &GrainSize, stream: &mut Stream) -> f64 {
    let (low, high) = (size.min_um.powi(3), size.max_um.powi(3));
    (low + stream.uniform() * (high - low)).cbrt() * 1e-6
}
