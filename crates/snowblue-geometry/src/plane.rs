//! Infinite planes, for floors and walls. They are not solids.

use glam::{Mat3A, Vec3A};

use crate::ray::{Ray, ShapeHit};
use crate::texture_coordinates::TextureCoordinates;

/// Greatest distance of a hit, in m. Coordinates there are still accurate to a metre.
const HORIZON_M: f32 = 1e7;

/// An infinite plane.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    point: Vec3A,
    normal: Vec3A,
    /// Its axes in scene space, as columns.
    axes: Mat3A,
}

impl Plane {
    /// The plane through `point`, in m, whose normal is the third of the unit vectors `axes`.
    pub fn new(point: Vec3A, axes: Mat3A) -> Self {
        Self { point, normal: axes.z_axis, axes }
    }

    /// The hit beyond the ray's origin and nearer than `limit_m`.
    pub fn first_hit(&self, ray: &Ray, limit_m: f32) -> Option<ShapeHit> {
        let distance_m = self.distance_m(ray, limit_m)?;
        let near = ray.at(distance_m);
        // Project onto the plane: rounding moves distant points off it.
        let point = near - self.normal * (near - self.point).dot(self.normal);
        Some(ShapeHit::plain(distance_m, point, self.normal))
    }

    /// Whether the ray hits the plane beyond its origin and nearer than `limit_m`.
    pub fn occludes(&self, ray: &Ray, limit_m: f32) -> bool {
        self.distance_m(ray, limit_m).is_some()
    }

    /// Whether a point lies on the side from which the normal points away.
    pub fn is_behind(&self, point: Vec3A) -> bool {
        (point - self.point).dot(self.normal) < 0.0
    }

    /// Texture coordinates of a point on the plane, seen from the side of its normal.
    pub fn texture_coordinates(&self, point: Vec3A) -> TextureCoordinates {
        let to_local = self.axes.transpose();
        TextureCoordinates::on_box(to_local * (point - self.point), to_local * self.normal)
    }

    fn distance_m(&self, ray: &Ray, limit_m: f32) -> Option<f32> {
        let distance_m = (self.point - ray.origin - ray.remainder).dot(self.normal) / ray.direction.dot(self.normal);
        (distance_m > 0.0 && distance_m < limit_m.min(HORIZON_M)).then_some(distance_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_floor_is_hit_from_above_and_below_but_not_by_parallel_rays() {
        let floor = Plane::new(Vec3A::new(0.0, 0.0, 2.0), Mat3A::IDENTITY);
        let down = Ray::new(Vec3A::new(1.0, 1.0, 5.0), Vec3A::new(0.6, 0.0, -0.8));
        let hit = floor.first_hit(&down, 9.0).unwrap();
        assert!((hit.distance_m - 3.75).abs() < 1e-6 && (hit.point - Vec3A::new(3.25, 1.0, 2.0)).length() < 1e-6);
        assert!(floor.first_hit(&down, 3.7).is_none() && !floor.occludes(&down, 3.7) && floor.occludes(&down, 3.8));
        assert!(floor.occludes(&Ray::new(Vec3A::ZERO, Vec3A::Z), 2.1));
        assert!(floor.first_hit(&Ray::new(Vec3A::ZERO, Vec3A::X), f32::INFINITY).is_none());
        assert!(floor.first_hit(&Ray::new(Vec3A::ZERO, Vec3A::NEG_Z), f32::INFINITY).is_none());
    }
}
