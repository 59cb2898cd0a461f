//! A spherical area light, sampled by the cone of directions that it subtends.
//!
//! From a distance d of its centre a sphere of radius R subtends a cone of half-angle α, sin α = R/d. Directions in it
//! are uniform: p(ω) = 1 / (2π (1 − cos α)). The point on the sphere follows without a difference of large numbers:
//! with θ the angle at the viewer, its angle β at the centre has cos β = sin²θ / sin α + cos θ √(1 − sin²θ / sin²α)
//! (Pharr, Jakob & Humphreys 2023, section 6.2.4).

use std::f32::consts::TAU;

use glam::Vec3A;
use snowblue_geometry::ray::Ray;

use super::EmitterPoint;

/// A sphere that emits outwards with the same radiance in all directions.
#[derive(Debug, Clone, Copy)]
pub struct SphereLight {
    /// Centre in m.
    pub centre: Vec3A,
    /// Radius in m.
    pub radius_m: f32,
}

/// The cone of directions towards a sphere, of half-angle α.
struct SubtendedCone {
    /// sin² α.
    sin_squared: f32,
    /// 1 − cos α.
    one_minus_cos: f32,
}

impl SphereLight {
    /// The cone that it subtends at a point; none from inside.
    fn cone(&self, point: Vec3A) -> Option<SubtendedCone> {
        let sin_squared = self.radius_m * self.radius_m / point.distance_squared(self.centre);
        let one_minus_cos = sin_squared / (1.0 + (1.0 - sin_squared).sqrt());
        (sin_squared < 1.0).then_some(SubtendedCone { sin_squared, one_minus_cos })
    }

    /// A visible point, uniform in the direction from `from`.
    pub(super) fn sample(&self, from: Vec3A, [u, v]: [f32; 2]) -> Option<EmitterPoint> {
        let SubtendedCone { sin_squared: max_sin_squared, one_minus_cos } = self.cone(from)?;
        let below_one = u * one_minus_cos;
        let sin_squared = below_one * (2.0 - below_one);
        let cos_centre = sin_squared / max_sin_squared.sqrt()
            + (1.0 - below_one) * (1.0 - sin_squared / max_sin_squared).max(0.0).sqrt();
        let towards = (from - self.centre).normalize();
        let (side, ahead) = towards.any_orthonormal_pair();
        let (sin_turn, cos_turn) = (TAU * v).sin_cos();
        let sin_centre = (1.0 - cos_centre * cos_centre).max(0.0).sqrt();
        let normal =
            (side * (sin_centre * cos_turn) + ahead * (sin_centre * sin_turn) + towards * cos_centre).normalize();
        Some(EmitterPoint { position: self.centre + normal * self.radius_m, normal })
    }

    /// Density of [`sample`](Self::sample) within the cone, in 1/sr.
    pub(super) fn density_per_sr(&self, from: Vec3A) -> f32 {
        self.cone(from).map_or(0.0, |cone| (TAU * cone.one_minus_cos).recip())
    }

    /// Where a ray hits it from outside, before `limit_m`.
    pub(super) fn hit(&self, ray: &Ray, limit_m: f32) -> Option<EmitterPoint> {
        let way = self.centre - ray.origin;
        let along = way.dot(ray.direction);
        let aside_squared = (way - ray.direction * along).length_squared();
        let half_squared = self.radius_m * self.radius_m - aside_squared;
        let distance_m = along - half_squared.max(0.0).sqrt();
        (half_squared > 0.0 && distance_m > 0.0 && distance_m < limit_m).then(|| {
            let normal = (ray.at(distance_m) - self.centre).normalize();
            EmitterPoint { position: self.centre + normal * self.radius_m, normal }
        })
    }
}
