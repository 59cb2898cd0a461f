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

use std::f64::consts::TAU;

use glam::DVec3;

use crate::fresnel::fresnel;
use crate::rng::Stream;

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
    if roughness < SMOOTH_BELOW_ROUGHNESS {
        let (direction, transmitted) = meet_facet(direction, DVec3::Z, relative_index, stream);
        return Outcome { direction, transmitted };
    }
    walk(direction, roughness, relative_index, stream)
}

/// The random walk itself: move to a height, leave or meet a facet, turn upside down after each refraction.
fn walk(mut direction: DVec3, roughness: f64, mut relative_index: f64, stream: &mut Stream) -> Outcome {
    let mut beyond = false;
    let mut log_height = 0.0;
    loop {
        log_height -= stream.uniform().ln() / shadowing(direction, roughness);
        if log_height >= 0.0 {
            let z = if beyond { -direction.z } else { direction.z };
            return Outcome { direction: direction.with_z(z), transmitted: beyond };
        }
        let facet = visible_normal(-direction, roughness, stream);
        let (scattered, refracted) = meet_facet(direction, facet, relative_index, stream);
        direction = scattered;
        if refracted {
            direction.z = -direction.z;
            log_height = (-f64::exp_m1(log_height)).ln();
            relative_index = 1.0 / relative_index;
            beyond = !beyond;
        }
    }
}

/// Fresnel's choice at a facet: the new direction, and whether the light was refracted.
#[inline]
fn meet_facet(direction: DVec3, facet: DVec3, relative_index: f64, stream: &mut Stream) -> (DVec3, bool) {
    let cosine = (-direction.dot(facet)).clamp(0.0, 1.0);
    let split = fresnel(cosine, relative_index);
    let refracted = stream.uniform() >= split.reflectance;
    let scattered = if refracted {
        direction / relative_index + facet * (cosine / relative_index - split.cos_refraction)
    } else {
        direction + facet * (2.0 * cosine)
    };
    (scattered.normalize(), refracted)
}

/// Smith's Λ for GGX slopes (Heitz 2014, JCGT 3(2), eq. 72), also for directions that go down, where it is −1 − Λ(up).
#[inline]
fn shadowing(direction: DVec3, roughness: f64) -> f64 {
    let z_squared = direction.z * direction.z;
    let root = (1.0 + roughness * roughness * (1.0 - z_squared).max(0.0) / z_squared).sqrt();
    if direction.z > 0.0 { 0.5 * (root - 1.0) } else { -0.5 * (root + 1.0) }
}

/// Normal of a facet, drawn from those that `towards` sees.
#[inline]
fn visible_normal(towards: DVec3, roughness: f64, stream: &mut Stream) -> DVec3 {
    let stretched = DVec3::new(roughness * towards.x, roughness * towards.y, towards.z).normalize();
    let (sin_phi, cos_phi) = (TAU * stream.uniform()).sin_cos();
    let z = 1.0 - stream.uniform() * (1.0 + stretched.z);
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let half = DVec3::new(radius * cos_phi, radius * sin_phi, z) + stretched;
    DVec3::new(roughness * half.x, roughness * half.y, half.z.max(f64::MIN_POSITIVE)).normalize()
}
