//! Instances: shared meshes placed in the scene.

use std::sync::Arc;

use glam::Vec3A;

use crate::bounds::Bounds;
use crate::mesh_bvh::MeshBvh;
use crate::ray::{Crossing, MeshLocation, Ray, ShapeHit};
use crate::transform::Transform;

/// A mesh placed in the scene. Rays are transformed to object space, and hits back to scene space.
#[derive(Debug, Clone)]
pub struct Instance {
    mesh: Arc<MeshBvh>,
    transform: Transform,
}

impl Instance {
    /// Places a mesh by a transform to scene space, in m.
    pub fn new(mesh: Arc<MeshBvh>, transform: Transform) -> Self {
        Self { mesh, transform }
    }

    /// The mesh in object space.
    pub fn mesh(&self) -> &Arc<MeshBvh> {
        &self.mesh
    }

    /// The transform to scene space, in m.
    pub fn transform(&self) -> &Transform {
        &self.transform
    }

    /// Axis-aligned bounds in scene space.
    pub fn bounds(&self) -> Bounds {
        self.transform.bounds_to_scene(&self.mesh.bounds())
    }

    /// The first hit beyond the ray's origin and nearer than `limit_m`.
    pub fn first_hit(&self, ray: &Ray, limit_m: f32) -> Option<ShapeHit> {
        let object_ray = self.transform.ray_to_object(ray);
        let hit = self.mesh.first_hit(&object_ray.ray, limit_m * object_ray.length_per_m)?;
        Some(ShapeHit {
            distance_m: hit.distance_m / object_ray.length_per_m,
            point: self.transform.point_to_scene(hit.point),
            normal: self.transform.normal_to_scene(hit.normal).normalize(),
            location: hit.location,
        })
    }

    /// The interpolated unit vertex normal in scene space, on either side; none where the face is flat.
    ///
    /// Normals are interpolated in object space and then transformed by the inverse transpose.
    pub fn shading_normal(&self, location: &MeshLocation) -> Option<Vec3A> {
        self.transform.normal_to_scene(self.mesh.shading_normal(location)?).try_normalize()
    }

    /// Whether the ray hits the mesh beyond its origin and nearer than `limit_m`.
    pub fn occludes(&self, ray: &Ray, limit_m: f32) -> bool {
        let object_ray = self.transform.ray_to_object(ray);
        self.mesh.occludes(&object_ray.ray, limit_m * object_ray.length_per_m)
    }

    /// Whether any triangle is nearer to a point than `distance_m`.
    pub(crate) fn is_near(&self, point: Vec3A, distance_m: f32) -> bool {
        self.mesh.is_near(&self.transform, point, distance_m)
    }

    /// The point of the surface that is nearest to a point by the measure of object space.
    pub(crate) fn nearest(&self, point: Vec3A) -> ShapeHit {
        let hit = self.mesh.nearest(self.transform.point_to_object(point));
        let on_surface = self.transform.point_to_scene(hit.point);
        ShapeHit {
            distance_m: on_surface.distance(point),
            point: on_surface,
            normal: self.transform.normal_to_scene(hit.normal).normalize_or_zero(),
            location: hit.location,
        }
    }

    /// Adds all crossings of the ray's line, in any order.
    pub fn crossings(&self, ray: &Ray, crossings: &mut Vec<Crossing>) {
        self.crossings_from(ray, f32::NEG_INFINITY, crossings);
    }

    /// Adds all crossings of the ray's line from `from_m` on, in any order.
    pub fn crossings_from(&self, ray: &Ray, from_m: f32, crossings: &mut Vec<Crossing>) {
        let object_ray = self.transform.ray_to_object(ray);
        let first = crossings.len();
        self.mesh.crossings(&object_ray.ray, from_m * object_ray.length_per_m, crossings);
        for crossing in &mut crossings[first..] {
            crossing.distance_m /= object_ray.length_per_m;
            crossing.normal = self.transform.normal_to_scene(crossing.normal);
        }
    }
}
