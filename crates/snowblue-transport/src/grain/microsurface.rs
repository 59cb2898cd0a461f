//! The rough surface of a grain: a random walk on a Smith microsurface with GGX slopes.
//!
//! Light falls among the facets of a random height field, is reflected or refracted at each facet it meets, and walks
//! on until it leaves to one side (Heitz, Hanika, d'Eon & Dachsbacher 2016, doi:10.1145/2897824.2925943). Nothing is
//! lost and étendue is kept, unlike with a random tilt of the normal. Facets are drawn from those visible along the
//! ray by spherical caps (Dupuy & Benyoub 2023, doi:10.1111/cgf.14867).
//!
//! Only the order of heights matters to a walk, so a height h is carried as ln C₁(h), the logarithm of the share of the
//! surface below it: 0 is above all facets, −∞ below all. Under the surface the same walk runs upside down, with
//! C₁ → 1 − C₁.

use glam::DVec3;

use crate::rng::{Stream, unit_circle};

/// Below this roughness a surface is treated as smooth.
pub const SMOOTH_BELOW_ROUGHNESS: f64 = 1e-4;

/// Where light went at an interface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Direction of travel in the frame of the interface: z > 0 on the side the light came from.
    pub direction: DVec3,
    /// Whether it passed to the other side.
    pub transmitted: bool,
}

/// Sends light that travels along `direction` (z < 0) through an interface of the given roughness α.
///
/// `relative_index` is the index of the far side over that of the near side.
#[inline]
pub fn interact(direction: DVec3, roughness: f64, relative_index: f64, stream: &mut Stream) -> Outcome {
    let step = Step { index: relative_index, inverse: 1.0 / relative_index };
    if roughness < SMOOTH_BELOW_ROUGHNESS {
        let (direction, transmitted) = meet_facet(direction, DVec3::Z, step, stream);
        return Outcome { direction, transmitted };
    }
    walk(direction, roughness, step, stream)
}

/// A step of the refractive index: far over near side, and near over far.
#[derive(Debug, Clone, Copy)]
struct Step {
    index: f64,
    inverse: f64,
}

/// The random walk itself: move to a height, leave or meet a facet, turn upside down after each refraction.
///
/// Smith's Λ for GGX slopes is ½(r/|z| − 1) for directions that go up and −½(r/|z| + 1) for those that go down, with r²
/// = α²(x² + y²) + z² (Heitz 2014, JCGT 3(2), eq. 72): the length of the direction in the space where facets are those
/// of a hemisphere.
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
        let (scattered, refracted) = meet_facet(direction, facet, step, stream);
        direction = scattered;
        if refracted {
            direction.z = -direction.z;
            log_height = (-f64::exp_m1(log_height)).ln();
            step = Step { index: step.inverse, inverse: step.index };
            beyond = !beyond;
        }
    }
}

/// Fresnel's choice at a facet: the new direction, and whether the light was refracted.
///
/// The reflectance of [`crate::optics::fresnel`] is compared with a random number without the divisions.
#[inline]
fn meet_facet(direction: DVec3, facet: DVec3, step: Step, stream: &mut Stream) -> (DVec3, bool) {
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
    (renormalized(scattered), refracted)
}

/// A nearly unit vector made unit by one step of Newton's method; refraction out of ice would let its error grow by n².
#[inline]
pub(crate) fn renormalized(v: DVec3) -> DVec3 {
    v * (1.5 - 0.5 * v.length_squared())
}

/// Normal of a facet, drawn from those that a unit direction in the stretched space sees.
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

    /// The choice without divisions is Fresnel's reflectance.
    #[test]
    fn facets_reflect_as_fresnel_says() {
        for (index, cosine) in [(1.31, 0.7), (1.31, 0.05), (1.0 / 1.31, 0.8), (1.0 / 1.31, 0.6), (1.0, 0.5)] {
            let expected = fresnel(cosine, index).reflectance;
            let direction = DVec3::new((1.0_f64 - cosine * cosine).sqrt(), 0.0, -cosine);
            let step = Step { index, inverse: 1.0 / index };
            let count = 100_000;
            let reflected =
                (0..count).filter(|ray| !meet_facet(direction, DVec3::Z, step, &mut Stream::new(8, *ray)).1).count();
            let sigma = (expected * (1.0 - expected) / count as f64).sqrt();
            assert!((reflected as f64 / count as f64 - expected).abs() <= 4.0 * sigma, "{index} {cosine}");
        }
    }

    /// Refraction obeys Snell's law and keeps the direction a unit vector.
    #[test]
    fn refraction_obeys_snell() {
        let direction = DVec3::new(0.6, 0.0, -0.8);
        let step = Step { index: 1.31, inverse: 1.0 / 1.31 };
        let refracted = (0..50).map(|ray| meet_facet(direction, DVec3::Z, step, &mut Stream::new(9, ray)));
        let (refracted, _) = refracted.into_iter().find(|(_, refracted)| *refracted).unwrap();
        assert!((refracted.x - 0.6 / 1.31).abs() < 1e-15 && (refracted.length() - 1.0).abs() < 1e-15);
    }
}
