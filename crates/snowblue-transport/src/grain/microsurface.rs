//! The rough surface of a grain: a random walk on a Smith microsurface with GGX slopes.
//!
//! Light enters a random height field of facets, is reflected or refracted at each facet it hits, and continues until
//! it leaves to one side (Heitz, Hanika, d'Eon & Dachsbacher 2016, doi:10.1145/2897824.2925943). Unlike a random tilt
//! of the normal, this conserves energy and étendue. Facets are drawn from the normals visible along the ray by
//! spherical caps (Dupuy & Benyoub 2023, doi:10.1111/cgf.14867).
//!
//! Only the order of heights matters to a walk, so a height h is stored as ln C₁(h), the logarithm of the fraction of
//! the surface below it: 0 lies above all facets, −∞ below all facets. Below the surface the walk runs upside down,
//! with 1 − C₁ in place of C₁.

use glam::DVec3;

use crate::rng::{Stream, unit_circle};

/// Below this roughness a surface is treated as smooth.
pub(crate) const SMOOTH_BELOW_ROUGHNESS: f64 = 1e-4;

/// Light after an interface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Outcome {
    /// Direction of travel in the frame of the interface; z > 0 on the side of incidence.
    pub(crate) direction: DVec3,
    /// Whether it was transmitted to the other side.
    pub(crate) transmitted: bool,
}

/// Reflects or transmits light that travels along `direction` (z < 0) at an interface of roughness α.
///
/// `relative_index` is the refractive index of the far side over the refractive index of the near side.
#[inline]
pub(crate) fn interact(direction: DVec3, roughness: f64, relative_index: f64, stream: &mut Stream) -> Outcome {
    let step = Step { index: relative_index, inverse: 1.0 / relative_index };
    if roughness < SMOOTH_BELOW_ROUGHNESS {
        let hit = hit_facet(direction, DVec3::Z, step, stream);
        return Outcome { direction: hit.direction, transmitted: hit.refracted };
    }
    walk(direction, roughness, step, stream)
}

/// Light after a facet.
#[derive(Debug, Clone, Copy)]
struct FacetHit {
    direction: DVec3,
    refracted: bool,
}

/// A step of the refractive index: far over near side, and near over far.
#[derive(Debug, Clone, Copy)]
struct Step {
    index: f64,
    inverse: f64,
}

/// The random walk: move to a height, leave or hit a facet, turn upside down after each refraction.
///
/// Smith's Λ for GGX slopes is ½(r/|z| − 1) for directions that go up and −½(r/|z| + 1) for directions that go down,
/// with r² = α²(x² + y²) + z² (Heitz 2014, JCGT 3(2), eq. 72). r is the length of the direction in the stretched
/// space, in which the facets form a hemisphere.
fn walk(mut direction: DVec3, roughness: f64, mut step: Step, stream: &mut Stream) -> Outcome {
    let mut beyond = false;
    let mut log_height = 0.0;
    loop {
        let stretched = DVec3::new(roughness * direction.x, roughness * direction.y, direction.z);
        let length = stretched.length();
        // ln C₁ grows by −ln u/Λ.
        let z = direction.z.abs();
        let twice = -2.0 * z * stream.uniform().ln();
        log_height += if direction.z > 0.0 { twice / (length - z) } else { -twice / (length + z) };
        if log_height >= 0.0 {
            let z = if beyond { -direction.z } else { direction.z };
            return Outcome { direction: direction.with_z(z), transmitted: beyond };
        }
        let facet = visible_normal(stretched * (-1.0 / length), roughness, stream);
        let hit = hit_facet(direction, facet, step, stream);
        direction = hit.direction;
        if hit.refracted {
            direction.z = -direction.z;
            log_height = (-f64::exp_m1(log_height)).ln();
            step = Step { index: step.inverse, inverse: step.index };
            beyond = !beyond;
        }
    }
}

/// Reflects or refracts light at a facet, chosen by the Fresnel reflectance.
///
/// The reflectance of [`crate::optics::fresnel`] is compared with a random number, multiplied out to avoid divisions.
#[inline]
fn hit_facet(direction: DVec3, facet: DVec3, step: Step, stream: &mut Stream) -> FacetHit {
    let chance = stream.uniform();
    let incidence = (-direction.dot(facet)).clamp(0.0, 1.0);
    let square = 1.0 - (1.0 - incidence * incidence) * (step.inverse * step.inverse);
    let refraction = square.max(0.0).sqrt();
    let (s, s_sum) = (incidence - step.index * refraction, incidence + step.index * refraction);
    let (p, p_sum) = (step.index * incidence - refraction, step.index * incidence + refraction);
    let reflected = (s * p_sum) * (s * p_sum) + (p * s_sum) * (p * s_sum);
    let refracted = square > 0.0 && 2.0 * chance * (s_sum * p_sum) * (s_sum * p_sum) >= reflected;
    let scattered = if refracted {
        direction * step.inverse + facet * (incidence * step.inverse - refraction)
    } else {
        direction + facet * (2.0 * incidence)
    };
    FacetHit { direction: renormalized(scattered), refracted }
}

/// Normalises a nearly unit vector by one step of Newton's method; without it refraction out of ice multiplies the
/// error by n².
#[inline]
pub(crate) fn renormalized(v: DVec3) -> DVec3 {
    v * (1.5 - 0.5 * v.length_squared())
}

/// Normal of a facet, drawn from the normals visible along a unit direction in the stretched space.
#[inline]
fn visible_normal(stretched: DVec3, roughness: f64, stream: &mut Stream) -> DVec3 {
    let (cos_phi, sin_phi) = unit_circle(stream.uniform());
    let z = 1.0 - stream.uniform() * (1.0 + stretched.z);
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let half = DVec3::new(radius * cos_phi, radius * sin_phi, z) + stretched;
    DVec3::new(roughness * half.x, roughness * half.y, half.z.max(f64::MIN_POSITIVE)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::fresnel;

    /// The comparison without divisions reflects with the Fresnel reflectance.
    #[test]
    fn facets_have_the_fresnel_reflectance() {
        for (index, cosine) in [(1.31, 0.7), (1.31, 0.05), (1.0 / 1.31, 0.8), (1.0 / 1.31, 0.6), (1.0, 0.5)] {
            let expected = fresnel(cosine, index).reflectance;
            let direction = DVec3::new((1.0_f64 - cosine * cosine).sqrt(), 0.0, -cosine);
            let step = Step { index, inverse: 1.0 / index };
            let count = 100_000;
            let reflected = (0..count)
                .filter(|ray| !hit_facet(direction, DVec3::Z, step, &mut Stream::new(8, *ray)).refracted)
                .count();
            let sigma = (expected * (1.0 - expected) / count as f64).sqrt();
            assert!((reflected as f64 / count as f64 - expected).abs() <= 4.0 * sigma, "{index} {cosine}");
        }
    }

    /// Refraction obeys Snell's law and keeps the direction a unit vector.
    #[test]
    fn refraction_obeys_snell() {
        let direction = DVec3::new(0.6, 0.0, -0.8);
        let step = Step { index: 1.31, inverse: 1.0 / 1.31 };
        let hits = (0..50).map(|ray| hit_facet(direction, DVec3::Z, step, &mut Stream::new(9, ray)));
        let refracted = hits.into_iter().find(|hit| hit.refracted).unwrap().direction;
        assert!((refracted.x - 0.6 / 1.31).abs() < 1e-15 && (refracted.length() - 1.0).abs() < 1e-15);
    }
}
