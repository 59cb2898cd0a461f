//! Size of the flat facets that grains consist of, by grain size and facetness.
//!
//! A body of the radius of curvature R that is cut into flat facets of the diameter d has, at a point r from the middle
//! of a facet, a normal that deviates from that of the round body by the slope r/R. Points are uniform over a facet, so
//! the median slope is d/(2√2 R). The median slope of the microsurface of a grain is its roughness α (GGX: a share
//! t²/(α² + t²) of the slopes lies below t). Equal medians give
//!
//! ```text
//! d = 2√2 α R = √2 α D,   α = 0.25 f,
//! ```
//!
//! with the facetness f and the diameter D of the sphere that has the surface of the grain. A grain then has 2/α²
//! facets, whatever its size: 128 at f = 0.5. The model has no size of facets of its own, so this is our choice;
//! crystals with larger faces exist (hoar, new snow).

use std::f64::consts::PI;

use crate::grain::{ROUGHNESS_PER_FACETNESS, Spheroid};
use crate::sample::SnowSample;

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
    use crate::TruncatedNormal;
    use crate::grain::SizeMeasure;
    use crate::sample::GrainSize;

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
