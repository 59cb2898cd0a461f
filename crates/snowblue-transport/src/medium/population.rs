//! Grains as light meets them: drawn in proportion to their projected area.

use crate::grain::{Grain, ROUGHNESS_PER_FACETNESS, Spheroid};
use crate::rng::Stream;
use crate::sample::{GrainSize, Quantiles, SizeMeasure, SnowSample, TruncatedNormal};

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

/// The sizes of hit grains: uniform in number, weighted with their square.
#[derive(Debug, Clone)]
pub(crate) struct HitSizes(Quantiles);

impl HitSizes {
    pub(crate) fn new(size: &GrainSize) -> Self {
        Self(Quantiles::new(size.min_um, size.max_um, |size_um| size_um * size_um))
    }
}

/// The size of a hit grain, in m.
#[inline]
pub(crate) fn hit_size_m(sizes: &HitSizes, stream: &mut Stream) -> f64 {
    sizes.0.at(stream.uniform()) * 1e-6
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The inverse of a cumulative distribution that goes as s³ is a cube root.
    #[test]
    fn hit_sizes_follow_their_square() {
        let sizes = HitSizes::new(&GrainSize { min_um: 100.0, max_um: 900.0, measure: SizeMeasure::default() });
        for i in 1..100 {
            let share = f64::from(i) / 100.0;
            let expected = (100_f64.powi(3) + share * (900_f64.powi(3) - 100_f64.powi(3))).cbrt();
            // Linear between 1024 quantiles; the cube root bends most at the thin end, by 0.03 µm.
            assert!((sizes.0.at(share) - expected).abs() < 0.05, "{share}");
        }
    }
}
