//! Random grains, drawn in proportion to their projected area, and the size of the flat facets that they consist of.
//!
//! A body with the radius of curvature R is cut into flat facets of the diameter d. At the distance r from the middle
//! of a facet, the normal of the facet deviates from the normal of the round body by the slope r/R. Points are
//! uniform over a facet, so the median slope is d/(2√2 R). The median slope of the microsurface of a grain is its
//! roughness α (GGX: a share t²/(α² + t²) of the slopes lies below t). Equal medians give
//!
//! ```text
//! d = 2√2 α R = √2 α D,   α = 0.25 f,
//! ```
//!
//! with the facetness f and the diameter D of the sphere with the surface area of the grain. A grain then has 2/α²
//! facets, whatever its size: 128 at f = 0.5. The model has no size of facets of its own, so this is our choice;
//! crystals with larger faces exist (hoar, new snow).

use std::f64::consts::PI;
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
    /// Tabulated when the first grain is drawn; with a known tally no grain is drawn.
    quantiles: OnceLock<[Quantiles; 2]>,
}

/// Populations with equal distributions are equal.
impl PartialEq for Population {
    fn eq(&self, other: &Self) -> bool {
        (self.given, self.measure) == (other.given, other.measure)
    }
}

impl Population {
    /// The grains of a sample.
    #[must_use]
    pub fn of_sample(sample: &SnowSample) -> Self {
        let SnowSample { sphericity, facetness, grain_size, .. } = *sample;
        Self { given: [sphericity, facetness], measure: grain_size.measure, quantiles: OnceLock::new() }
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

/// Diameters of the facets of the smallest and of the largest grains of a sample, in µm, by its mean facetness and
/// sphericity; 0 for smooth grains.
///
/// ```
/// # use snowblue_transport::{SnowSample, TruncatedNormal, medium::facet_diameters_um};
/// let faceted = SnowSample { facetness: TruncatedNormal::exactly(1.0), ..SnowSample::default() };
/// let [least, greatest] = facet_diameters_um(&faceted);
/// // Grains of 350–450 µm with faces a quarter as wide.
/// assert!(least > 80.0 && greatest < 130.0);
/// ```
#[must_use]
pub fn facet_diameters_um(sample: &SnowSample) -> [f64; 2] {
    let roughness = ROUGHNESS_PER_FACETNESS * sample.facetness.mean_of(|facetness| facetness);
    let measure = sample.grain_size.measure;
    let surface = sample.sphericity.mean_of(|sphericity| Spheroid::of_unit_size(sphericity, measure).surface());
    let per_size = std::f64::consts::SQRT_2 * roughness * (surface / PI).sqrt();
    [sample.grain_size.min_um, sample.grain_size.max_um].map(|size_um| per_size * size_um)
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

    /// The median slope between a sphere and its facets, by points evenly over a facet, is the roughness.
    #[test]
    fn facets_of_a_sphere_deviate_from_it_by_the_roughness() {
        let sphere = SnowSample {
            grain_size: GrainSize { min_um: 500.0, max_um: 500.0, measure: SizeMeasure::GreatestExtension },
            sphericity: TruncatedNormal::exactly(1.0),
            facetness: TruncatedNormal::exactly(0.4),
            ..SnowSample::default()
        };
        let [diameter_um, greatest_um] = facet_diameters_um(&sphere);
        assert!((diameter_um - greatest_um).abs() < 1e-12);
        let points = 100_001;
        // Equal areas between the radii of a disc, in order.
        let slope = |point: i32| 0.5 * diameter_um * (f64::from(point) / f64::from(points)).sqrt() / 250.0;
        assert!((slope(points / 2) - 0.1).abs() < 1e-6, "{}", slope(points / 2));
    }
}
