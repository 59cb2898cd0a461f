//! Where a shape stands in the scene: an affine map from the shape's own coordinates, which may turn, stretch and
//! mirror it, and the ways through it for rays, points and normals.
//!
//! A line stays a line under an affine map, and its crossings keep their order; only lengths change, and alike all
//! along a line. So depths come out in metres of the scene, however a shape is stretched. Normals go with the transpose
//! of the inverse (Pharr, Jakob & Humphreys 2023, section 3.9.4).

use glam::{Affine3A, DAffine3, DMat3, Mat3A, Vec3A};

use crate::geometry::bounds::Bounds;
use crate::geometry::ray::Ray;

/// A place, a turn and a stretch, there and back.
#[derive(Debug, Clone, Copy)]
pub struct Placement {
    to_scene: Affine3A,
    to_shape: Affine3A,
    normal_to_scene: Mat3A,
}

/// A ray in a shape's own coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OwnRay {
    /// The ray, with a unit direction there.
    pub(crate) ray: Ray,
    /// Length there of one metre along the ray.
    pub(crate) per_m: f32,
}

impl Placement {
    /// The placement by a map from the shape's coordinates to the scene's, in m; none for a map that flattens it.
    pub fn new(to_scene: &DAffine3) -> Option<Self> {
        let to_shape = to_scene.inverse();
        let finite = to_scene.is_finite() && to_shape.is_finite() && to_scene.matrix3.determinant().abs() > 0.0;
        let normal_to_scene: DMat3 = to_shape.matrix3.transpose();
        finite.then(|| Self {
            to_scene: to_scene.as_affine3a(),
            to_shape: to_shape.as_affine3a(),
            normal_to_scene: normal_to_scene.as_mat3().into(),
        })
    }

    /// A ray of the scene in the shape's coordinates.
    #[inline]
    pub(crate) fn own(&self, ray: &Ray) -> OwnRay {
        let direction = self.to_shape.transform_vector3a(ray.direction);
        let per_m = direction.length();
        OwnRay { ray: Ray { origin: self.own_point(ray.origin), direction: direction / per_m }, per_m }
    }

    /// A point of the scene in the shape's coordinates.
    #[inline]
    pub(crate) fn own_point(&self, point: Vec3A) -> Vec3A {
        self.to_shape.transform_point3a(point)
    }

    /// A point of the shape in the scene.
    #[inline]
    pub fn point(&self, own: Vec3A) -> Vec3A {
        self.to_scene.transform_point3a(own)
    }

    /// A normal of the shape in the scene, of any length.
    #[inline]
    pub fn normal(&self, own: Vec3A) -> Vec3A {
        self.normal_to_scene * own
    }

    /// Volume in the scene of a unit of volume of the shape's coordinates.
    pub fn volume_factor(&self) -> f64 {
        self.to_scene.matrix3.determinant().abs().into()
    }

    /// The axis-parallel box in the scene around an axis-parallel box of the shape.
    pub fn bounds(&self, own: &Bounds) -> Bounds {
        Bounds::of(own.corners().into_iter().map(|corner| self.point(corner).into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};

    #[test]
    fn lengths_points_and_normals_go_there_and_back() {
        let stretch = DVec3::new(2.0, 0.5, -3.0);
        let map =
            DAffine3::from_scale_rotation_translation(stretch, DQuat::from_rotation_y(0.7), DVec3::new(0.3, -1.0, 2.0));
        let placement = Placement::new(&map).unwrap();
        assert!((placement.volume_factor() - 3.0).abs() < 1e-6);
        let ray = Ray { origin: Vec3A::new(0.1, 0.2, 0.3), direction: Vec3A::new(0.48, -0.6, 0.64) };
        let own = placement.own(&ray);
        let (near, far) = (placement.point(own.ray.at(0.5)), placement.point(own.ray.at(0.5 + own.per_m)));
        assert!(((far - near) - ray.direction).length() < 1e-6, "one metre stays one metre");
        // A normal stays perpendicular to its surface.
        let (side, normal) = (Vec3A::new(1.0, 1.0, 0.0), Vec3A::new(1.0, -1.0, 0.4));
        let moved = placement.point(side) - placement.point(Vec3A::ZERO);
        assert!(placement.normal(normal).dot(moved).abs() < 1e-6);
    }

    #[test]
    fn a_flattening_map_is_none() {
        assert!(Placement::new(&DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))).is_none());
    }
}
