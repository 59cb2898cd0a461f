//! All kinds of shapes, with first hit, occlusion and crossings.

use glam::{Affine3A, Mat3A, Vec3A};

use crate::bounds::Bounds;
use crate::cuboid::Cuboid;
use crate::ellipsoid::Ellipsoid;
use crate::instance::Instance;
use crate::mesh_bvh::MeshBvh;
use crate::plane::Plane;
use crate::ray::{Crossing, MeshLocation, Ray, ShapeHit};

/// A shape in the scene. A clone shares its mesh.
#[derive(Debug, Clone)]
pub enum Shape {
    /// A box.
    Cuboid(Cuboid),
    /// A sphere or ellipsoid.
    Ellipsoid(Ellipsoid),
    /// An infinite plane, which is not a solid.
    Plane(Plane),
    /// A triangle mesh, which should be watertight if it is snow.
    Mesh(Instance),
}

impl Shape {
    /// Axis-aligned bounds; none for a plane.
    pub fn bounds(&self) -> Option<Bounds> {
        match self {
            Self::Cuboid(cuboid) => Some(cuboid.bounds()),
            Self::Ellipsoid(ellipsoid) => Some(ellipsoid.bounds()),
            Self::Plane(_) => None,
            Self::Mesh(instance) => Some(instance.bounds()),
        }
    }

    /// Unit axes and origin of coordinates that move and turn with the shape, without its scale: from a point p of the
    /// scene to axesᵀ (p − origin).
    pub fn frame(&self) -> (Mat3A, Vec3A) {
        let of_map = |matrix: Mat3A, origin: Vec3A| {
            let x = matrix.x_axis.normalize();
            let y = (matrix.y_axis - x * x.dot(matrix.y_axis)).normalize();
            (Mat3A::from_cols(x, y, x.cross(y)), origin)
        };
        match self {
            Self::Cuboid(cuboid) => cuboid.frame(),
            Self::Ellipsoid(ellipsoid) => {
                let Affine3A { matrix3, translation } = ellipsoid.scene_map();
                of_map(matrix3, translation)
            }
            Self::Plane(_) => (Mat3A::IDENTITY, Vec3A::ZERO),
            Self::Mesh(instance) => {
                let Affine3A { matrix3, translation } = instance.transform().scene_map();
                of_map(matrix3, translation)
            }
        }
    }

    /// The mesh, if the shape is a mesh.
    pub fn mesh(&self) -> Option<&MeshBvh> {
        match self {
            Self::Mesh(instance) => Some(instance.mesh()),
            Self::Cuboid(_) | Self::Ellipsoid(_) | Self::Plane(_) => None,
        }
    }

    /// Whether every line crosses the shape twice at most.
    #[inline]
    pub fn is_convex(&self) -> bool {
        matches!(self, Self::Cuboid(_) | Self::Ellipsoid(_))
    }

    /// The first hit beyond the ray's origin and nearer than `limit_m`.
    #[inline]
    pub fn first_hit(&self, ray: &Ray, limit_m: f32) -> Option<ShapeHit> {
        match self {
            Self::Cuboid(cuboid) => cuboid.first_hit(ray, limit_m),
            Self::Ellipsoid(ellipsoid) => ellipsoid.first_hit(ray, limit_m),
            Self::Plane(plane) => plane.first_hit(ray, limit_m),
            Self::Mesh(instance) => instance.first_hit(ray, limit_m),
        }
    }

    /// The unit normal for shading, at a hit of a ray with the normal of the visible side: the interpolated vertex
    /// normal of a mesh, turned to that side. The result is `normal` where there is no vertex normal, or where the
    /// vertex normal faces away from the ray's origin.
    #[inline]
    pub fn shading_normal(&self, location: &MeshLocation, normal: Vec3A, direction: Vec3A) -> Vec3A {
        let Self::Mesh(instance) = self else { return normal };
        let Some(smooth) = instance.shading_normal(location) else { return normal };
        let smooth = if smooth.dot(normal) < 0.0 { -smooth } else { smooth };
        if smooth.dot(normal) > 0.0 && smooth.dot(direction) < 0.0 { smooth } else { normal }
    }

    /// Whether the ray hits the shape beyond its origin and nearer than `limit_m`.
    #[inline]
    pub fn occludes(&self, ray: &Ray, limit_m: f32) -> bool {
        match self {
            Self::Cuboid(cuboid) => cuboid.occludes(ray, limit_m),
            Self::Ellipsoid(ellipsoid) => ellipsoid.occludes(ray, limit_m),
            Self::Plane(plane) => plane.occludes(ray, limit_m),
            Self::Mesh(instance) => instance.occludes(ray, limit_m),
        }
    }

    /// Whether a point inside is farther than `depth_m` from the surface. The point must be inside if the shape is a
    /// mesh.
    #[inline]
    pub fn holds_deeply(&self, point: Vec3A, depth_m: f32) -> bool {
        match self {
            Self::Cuboid(cuboid) => cuboid.holds_deeply(point, depth_m),
            Self::Ellipsoid(ellipsoid) => ellipsoid.holds_deeply(point, depth_m),
            Self::Plane(_) => false,
            Self::Mesh(instance) => !instance.is_near(point, depth_m),
        }
    }

    /// A point of the surface near a point: for a box or a mesh the nearest surface point, for an ellipsoid the
    /// surface point below the point. None for a plane.
    pub fn nearest(&self, point: Vec3A) -> Option<ShapeHit> {
        match self {
            Self::Cuboid(cuboid) => Some(cuboid.nearest(point)),
            Self::Ellipsoid(ellipsoid) => {
                let surface = ellipsoid.project(point);
                Some(ShapeHit::plain(surface.point.distance(point), surface.point, surface.normal))
            }
            Self::Plane(_) => None,
            Self::Mesh(instance) => Some(instance.nearest(point)),
        }
    }

    /// The two crossings of the ray's line with a box or ellipsoid, in order and with unit normals.
    #[inline]
    pub fn pair(&self, ray: &Ray) -> Option<[Crossing; 2]> {
        match self {
            Self::Cuboid(cuboid) => cuboid.crossings(ray),
            Self::Ellipsoid(ellipsoid) => ellipsoid.crossings(ray),
            Self::Plane(_) | Self::Mesh(_) => None,
        }
    }

    /// Adds all crossings of the ray's line with a solid. A plane adds none.
    pub fn crossings(&self, ray: &Ray, crossings: &mut Vec<Crossing>) {
        match self {
            Self::Mesh(instance) => instance.crossings(ray, crossings),
            Self::Cuboid(_) | Self::Ellipsoid(_) | Self::Plane(_) => {
                crossings.extend(self.pair(ray).into_iter().flatten())
            }
        }
    }
}
