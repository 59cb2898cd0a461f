//! Invertible affine transforms from object space to scene space.
//!
//! An affine transform maps lines to lines, keeps the order of points on a line, and scales all lengths along a line
//! by one factor. Distances are therefore in metres of the scene, however an object is stretched. Normals are
//! transformed by the inverse transpose (Pharr, Jakob & Humphreys 2023, section 3.9.4).

use glam::{Affine3A, DAffine3, DMat3, DVec3, Mat3A, Vec3A};

use crate::bounds::Bounds;
use crate::ray::Ray;
use snowblue_base::narrow;

/// An origin near a point, from which single precision suffices: the coordinates rounded to 1000, in m or in the unit
/// of a file. It is 0 for most scenes and files, and for a point that is not finite.
pub fn origin_near(point: DVec3) -> DVec3 {
    const STEP: f64 = 1000.0;
    if point.is_finite() { (point / STEP).round() * STEP } else { DVec3::ZERO }
}

/// An affine transform with its inverse.
#[derive(Debug, Clone, Copy)]
pub struct Transform {
    to_scene: Affine3A,
    to_object: Affine3A,
    /// The map to object space, for the origins of rays.
    exact_to_object: DAffine3,
    normal_to_scene: Mat3A,
    /// An upper bound of the factor by which lengths grow on the way to object space.
    stretch_to_object: f32,
}

/// A ray in object space.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ObjectRay {
    /// The ray, with a unit direction in object space.
    pub(crate) ray: Ray,
    /// Length in object space of one metre along the ray.
    pub(crate) length_per_m: f32,
}

impl Transform {
    /// A transform from object space to scene space, in m; none if the map is singular.
    pub fn new(to_scene: &DAffine3) -> Option<Self> {
        let to_object = to_scene.inverse();
        let finite = to_scene.is_finite() && to_object.is_finite() && to_scene.matrix3.determinant().abs() > 0.0;
        let normal_to_scene: DMat3 = to_object.matrix3.transpose();
        finite.then(|| Self {
            to_scene: to_scene.as_affine3a(),
            to_object: to_object.as_affine3a(),
            exact_to_object: to_object,
            normal_to_scene: normal_to_scene.as_mat3().into(),
            stretch_to_object: narrow(stretch(&to_object.matrix3)),
        })
    }

    /// The map from object space to scene space.
    pub fn scene_map(&self) -> Affine3A {
        self.to_scene
    }

    /// Transforms a ray to object space.
    #[inline]
    pub(crate) fn ray_to_object(&self, ray: &Ray) -> ObjectRay {
        let direction = self.to_object.transform_vector3a(ray.direction);
        let length_per_m = direction.length();
        let exact = self.exact_to_object.transform_point3(ray.origin.as_dvec3() + ray.remainder.as_dvec3());
        let origin = exact.as_vec3a();
        let remainder = (exact - origin.as_dvec3()).as_vec3a();
        ObjectRay { ray: Ray { origin, direction: direction / length_per_m, remainder }, length_per_m }
    }

    /// Transforms a point to object space.
    #[inline]
    pub(crate) fn point_to_object(&self, point: Vec3A) -> Vec3A {
        self.to_object.transform_point3a(point)
    }

    /// An upper bound of the length in object space of one metre in any direction; exact without shear or unequal
    /// scales.
    #[inline]
    pub(crate) fn greatest_stretch_to_object(&self) -> f32 {
        self.stretch_to_object
    }

    /// Transforms a point to scene space.
    #[inline]
    pub fn point_to_scene(&self, point: Vec3A) -> Vec3A {
        self.to_scene.transform_point3a(point)
    }

    /// Transforms a normal to scene space; the result is not normalised.
    #[inline]
    pub fn normal_to_scene(&self, normal: Vec3A) -> Vec3A {
        self.normal_to_scene * normal
    }

    /// Volume in scene space of a unit volume in object space.
    pub fn volume_scale(&self) -> f64 {
        self.to_scene.matrix3.determinant().abs().into()
    }

    /// Axis-aligned bounds in scene space of a box in object space.
    pub fn bounds_to_scene(&self, bounds: &Bounds) -> Bounds {
        Bounds::of(bounds.corners().into_iter().map(|corner| self.point_to_scene(corner).into()))
    }
}

/// An upper bound of the norm of a matrix M: the root of the greatest sum of magnitudes in a row of MᵀM.
pub(crate) fn stretch(matrix: &DMat3) -> f64 {
    let square = matrix.transpose() * *matrix;
    let row_sum = |axis: usize| square.row(axis).abs().element_sum();
    (0..3).map(row_sum).fold(0.0, f64::max).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};

    #[test]
    fn lengths_points_and_normals_are_consistent() {
        let stretch = DVec3::new(2.0, 0.5, -3.0);
        let map =
            DAffine3::from_scale_rotation_translation(stretch, DQuat::from_rotation_y(0.7), DVec3::new(0.3, -1.0, 2.0));
        let transform = Transform::new(&map).unwrap();
        assert!((transform.volume_scale() - 3.0).abs() < 1e-6);
        let ray = Ray::new(Vec3A::new(0.1, 0.2, 0.3), Vec3A::new(0.48, -0.6, 0.64));
        let ObjectRay { ray: object_ray, length_per_m } = transform.ray_to_object(&ray);
        let near = transform.point_to_scene(object_ray.at(0.5));
        let far = transform.point_to_scene(object_ray.at(0.5 + length_per_m));
        assert!(((far - near) - ray.direction).length() < 1e-6, "one metre in scene space");
        // A normal stays perpendicular to its surface.
        let (tangent, normal) = (Vec3A::new(1.0, 1.0, 0.0), Vec3A::new(1.0, -1.0, 0.4));
        let scene_tangent = transform.point_to_scene(tangent) - transform.point_to_scene(Vec3A::ZERO);
        assert!(transform.normal_to_scene(normal).dot(scene_tangent).abs() < 1e-6);
    }

    #[test]
    fn a_singular_map_is_no_transform() {
        assert!(Transform::new(&DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))).is_none());
    }
}
