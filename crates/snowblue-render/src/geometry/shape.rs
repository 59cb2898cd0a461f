//! The kinds of surfaces, and the three questions asked of any of them.

use crate::geometry::bounds::Bounds;
use crate::geometry::cuboid::Cuboid;
use crate::geometry::ellipsoid::Ellipsoid;
use crate::geometry::instance::Instance;
use crate::geometry::mesh::Mesh;
use crate::geometry::plane::Plane;
use crate::geometry::ray::{Crossing, Ray, ShapeHit};

/// A surface in the scene.
#[derive(Debug)]
pub enum Shape {
    /// A box.
    Cuboid(Cuboid),
    /// A sphere, or one stretched.
    Ellipsoid(Ellipsoid),
    /// An endless plane, which is no solid.
    Plane(Plane),
    /// A triangle mesh; for snow it should be watertight.
    Mesh(Instance),
}

impl Shape {
    /// The axis-parallel box around it, unless it is endless.
    pub fn bounds(&self) -> Option<Bounds> {
        match self {
            Self::Cuboid(cuboid) => Some(cuboid.bounds()),
            Self::Ellipsoid(ellipsoid) => Some(ellipsoid.bounds()),
            Self::Plane(_) => None,
            Self::Mesh(instance) => Some(instance.bounds()),
        }
    }

    /// Its mesh, if it is one.
    pub fn mesh(&self) -> Option<&Mesh> {
        match self {
            Self::Mesh(instance) => Some(instance.mesh()),
            Self::Cuboid(_) | Self::Ellipsoid(_) | Self::Plane(_) => None,
        }
    }

    /// The first hit beyond the ray's origin and nearer than `limit_m`.
    #[inline(always)]
    pub fn first_hit(&self, ray: &Ray, limit_m: f32) -> Option<ShapeHit> {
        match self {
            Self::Cuboid(cuboid) => cuboid.first_hit(ray, limit_m),
            Self::Ellipsoid(ellipsoid) => ellipsoid.first_hit(ray, limit_m),
            Self::Plane(plane) => plane.first_hit(ray, limit_m),
            Self::Mesh(instance) => instance.first_hit(ray, limit_m),
        }
    }

    /// Whether it lies beyond the ray's origin and nearer than `limit_m`.
    #[inline]
    pub fn occludes(&self, ray: &Ray, limit_m: f32) -> bool {
        match self {
            Self::Cuboid(cuboid) => cuboid.occludes(ray, limit_m),
            Self::Ellipsoid(ellipsoid) => ellipsoid.occludes(ray, limit_m),
            Self::Plane(plane) => plane.occludes(ray, limit_m),
            Self::Mesh(instance) => instance.occludes(ray, limit_m),
        }
    }

    /// The two crossings of the whole line of the ray with a box or an ellipsoid, in its order and with unit normals, if it meets it.
    #[inline]
    pub(crate) fn pair(&self, ray: &Ray) -> Option<[Crossing; 2]> {
        match self {
            Self::Cuboid(cuboid) => cuboid.crossings(ray),
            Self::Ellipsoid(ellipsoid) => ellipsoid.crossings(ray),
            Self::Plane(_) | Self::Mesh(_) => None,
        }
    }

    /// Adds every crossing of the whole line of the ray with a solid; a plane is none and adds nothing.
    pub fn crossings(&self, ray: &Ray, crossings: &mut Vec<Crossing>) {
        match self {
            Self::Mesh(instance) => instance.crossings(ray, crossings),
            Self::Cuboid(_) | Self::Ellipsoid(_) | Self::Plane(_) => {
                crossings.extend(self.pair(ray).into_iter().flatten())
            }
        }
    }
}
