//! A mesh in its place. The triangles and their hierarchy are there once, however many copies a scene shows; a ray is
//! taken into the mesh's own coordinates, and what it finds is brought back.

use std::sync::Arc;

use crate::geometry::bounds::Bounds;
use crate::geometry::mesh::Mesh;
use crate::geometry::placement::Placement;
use crate::geometry::ray::{Crossing, Ray, ShapeHit};

/// A placed mesh.
#[derive(Debug, Clone)]
pub struct Instance {
    mesh: Arc<Mesh>,
    placement: Placement,
}

impl Instance {
    /// A mesh in its own coordinates, and from there into the scene, in m.
    pub fn new(mesh: Arc<Mesh>, placement: Placement) -> Self {
        Self { mesh, placement }
    }

    /// The mesh in its own coordinates.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// From there into the scene, in m.
    pub fn placement(&self) -> &Placement {
        &self.placement
    }

    /// The axis-parallel box around it.
    pub fn bounds(&self) -> Bounds {
        self.placement.bounds(&self.mesh.bounds())
    }

    /// The first hit beyond the ray's origin and nearer than `limit_m`.
    pub fn first_hit(&self, ray: &Ray, limit_m: f32) -> Option<ShapeHit> {
        let own = self.placement.own(ray);
        let hit = self.mesh.first_hit(&own.ray, limit_m * own.per_m)?;
        Some(ShapeHit {
            distance_m: hit.distance_m / own.per_m,
            point: self.placement.point(hit.point),
            normal: self.placement.normal(hit.normal).normalize(),
            place: hit.place,
        })
    }

    /// Whether its surface lies beyond the ray's origin and nearer than `limit_m`.
    pub fn occludes(&self, ray: &Ray, limit_m: f32) -> bool {
        let own = self.placement.own(ray);
        self.mesh.occludes(&own.ray, limit_m * own.per_m)
    }

    /// Adds every crossing of the whole line of the ray, in no particular order.
    pub fn crossings(&self, ray: &Ray, crossings: &mut Vec<Crossing>) {
        self.crossings_from(ray, f32::NEG_INFINITY, crossings);
    }

    /// Adds every crossing of the line from `from_m` on, in no particular order.
    pub(crate) fn crossings_from(&self, ray: &Ray, from_m: f32, crossings: &mut Vec<Crossing>) {
        let own = self.placement.own(ray);
        let before = crossings.len();
        self.mesh.crossings(&own.ray, from_m * own.per_m, crossings);
        for crossing in &mut crossings[before..] {
            crossing.distance_m /= own.per_m;
            crossing.normal = self.placement.normal(crossing.normal);
        }
    }
}
