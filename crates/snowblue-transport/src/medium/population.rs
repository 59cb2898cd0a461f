//! Random grains, drawn in proportion to their projected area.

use std::sync::OnceLock;

use crate::grain::{Grain, ROUGHNESS_PER_FACETNESS, Scattered, Spheroid};
use crate::rng::Stream;
use crate::sample::{GrainSize, Quantiles, SizeMeasure, SnowSample, TruncatedNormal};

/// Distributions of shape and facetness of grains, weighted by projected area. Sizes do not affect directions and are
/// drawn separately.
#[derive(Debug, Clone)]
pub struct Population {
    /// The distributions by number.
    given: [TruncatedNormal; 2],
    measure: SizeMeasure,
    /// Tabulated when the first grain is drawn: with a known tally none is.
    quantiles: OnceLock<[Quantiles; 2]>,
}

/// Populations of the same distributions are equal.
impl PartialEq for Population {
    fn eq(&self, other: &Self) -> bool {
        (self.given, self.measure) == (other.given, other.measure)
    }
}

impl Population {
    /// The grains of a sample.
    #[must_use]
    pub fn of_sample(sample: &SnowSample) -> Self {
        Self::new(&sample.sphericity, &sample.facetness, sample.grain_size.measure)
    }

    /// Grains with given distributions by number, whose sizes are given by `measure`.
    #[must_use]
    pub fn new(sphericity: &TruncatedNormal, facetness: &TruncatedNormal, measure: SizeMeasure) -> Self {
        Self { given: [*sphericity, *facetness], measure, quantiles: OnceLock::new() }
    }

    /// The grain of the given relative index for two uniform numbers.
    #[inline]
    pub(crate) fn grain(&self, [shape, facetness]: [f64; 2], relative_index: f64) -> Grain {
        let [of_sphericity, of_facetness] = self.quantiles.get_or_init(|| self.weighted());
        Grain {
            shape: Spheroid::of_unit_size(of_sphericity.at(shape), self.measure),
            roughness: ROUGHNESS_PER_FACETNESS * of_facetness.at(facetness),
            relative_index,
        }
    }

    /// Quantiles of sphericity and facetness, weighted by projected area.
    fn weighted(&self) -> [Quantiles; 2] {
        let [sphericity, facetness] = &self.given;
        [sphericity.weighted(|psi| Spheroid::of_unit_size(psi, self.measure).surface()), facetness.weighted(|_| 1.0)]
    }

    /// Scattering of a random ray by a random grain of the given relative index, and its weight: the entry point is
    /// uniform over the unit sphere, so that a stream that starts with a low-discrepancy point keeps its evenness.
    #[inline]
    pub(super) fn scatter(&self, relative_index: f64, stream: &mut Stream) -> (Scattered, f64) {
        let grain = self.grain([stream.uniform(), stream.uniform()], relative_index);
        let z = 2.0 * stream.uniform() - 1.0;
        let angles = [stream.uniform(), stream.uniform()];
        let weight = grain.shape.relative_area(z) / grain.shape.mean_relative_area();
        (grain.scatter_hit(grain.shape.hit_at(z, angles), stream), weight)
    }
}

/// Distribution of grain sizes: uniform in number, weighted by their square.
#[derive(Debug, Clone)]
pub(crate) struct HitSizes(Quantiles);

impl HitSizes {
    pub(crate) fn new(size: &GrainSize) -> Self {
        Self(Quantiles::new(size.min_um, size.max_um, |size_um| size_um * size_um))
    }
}

/// A random grain size, weighted by projected area, in m.
#[inline]
pub(crate) fn hit_size_m(sizes: &HitSizes, stream: &mut Stream) -> f64 {
    sizes.0.at(stream.uniform()) * 1e-6
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The inverse of the cumulative distribution, which goes as s³, is a cube root.
    #[test]
    fn hit_sizes_are_weighted_by_their_square() {
        let sizes = HitSizes::new(&GrainSize { min_um: 100.0, max_um: 900.0, measure: SizeMeasure::default() });
        for i in 1..100 {
            let probability = f64::from(i) / 100.0;
            let expected = (100_f64.powi(3) + probability * (900_f64.powi(3) - 100_f64.powi(3))).cbrt();
            // Linear between 1024 quantiles; the cube root deviates most at the lower end, by 0.03 µm.
            assert!((sizes.0.at(probability) - expected).abs() < 0.05, "{probability}");
        }
    }
}
