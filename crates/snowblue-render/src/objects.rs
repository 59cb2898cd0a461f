//! The things in a scene and the three questions asked of them: what does a ray hit first, is a light hidden, and
//! how does a line run through one object.

use std::time::Duration;

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::ray::RayHit;
use obvhs::{Boundable, BvhBuildParams};

use crate::bounds::{Bounds, finite_inverse};
use crate::cuboid::Cuboid;
use crate::mesh::Mesh;
use crate::ray::{Crossing, Ray, ShapeHit};

/// Up to this number objects are tried one by one; more get a hierarchy.
const FEW_OBJECTS: usize = 6;

/// How far before its origin a ray enters the hierarchy of objects, in m: boxes nearer than 1e-4 are ignored there.
const RUN_UP_M: f32 = 1e-3;

/// A surface in the scene.
#[derive(Debug)]
pub enum Shape {
    /// A box.
    Cuboid(Cuboid),
    /// A triangle mesh; for snow it should be watertight.
    Mesh(Mesh),
}

/// A shape made of a material.
#[derive(Debug)]
pub struct Object {
    /// Its surface.
    pub shape: Shape,
    /// Index of its material in the scene.
    pub material: usize,
}

/// What a ray hits first.
#[derive(Debug, Clone, Copy)]
pub struct Surface {
    /// Index of the object.
    pub object: usize,
    /// Index of its material.
    pub material: usize,
    /// The point hit.
    pub point: Vec3A,
    /// Unit normal on the side from which the ray came: the outward one, as long as rays stay out of solids.
    pub normal: Vec3A,
    /// Unit direction of the ray.
    pub direction: Vec3A,
}

/// All objects of a scene.
#[derive(Debug)]
pub struct Objects {
    objects: Vec<Object>,
    bounds: Vec<Bounds>,
    hierarchy: Option<CwBvh>,
}

impl Shape {
    /// The axis-parallel box around it.
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Cuboid(cuboid) => cuboid.bounds(),
            Self::Mesh(mesh) => mesh.bounds(),
        }
    }

    fn first_hit(&self, ray: &Ray, limit_m: f32) -> Option<ShapeHit> {
        match self {
            Self::Cuboid(cuboid) => cuboid.first_hit(ray, limit_m),
            Self::Mesh(mesh) => mesh.first_hit(ray, limit_m),
        }
    }

    fn blocks(&self, ray: &Ray, limit_m: f32) -> bool {
        match self {
            Self::Cuboid(cuboid) => cuboid.blocks(ray, limit_m),
            Self::Mesh(mesh) => mesh.blocks(ray, limit_m),
        }
    }
}

struct PaddedBounds(Bounds);

impl Boundable for PaddedBounds {
    fn aabb(&self) -> Aabb {
        Aabb::new(self.0.low, self.0.high)
    }
}

impl Objects {
    /// Gathers the objects, and builds the hierarchy over them if they are many.
    pub fn new(objects: Vec<Object>) -> Self {
        let bounds: Vec<Bounds> = objects.iter().map(|object| object.shape.bounds()).collect();
        let hierarchy = (objects.len() > FEW_OBJECTS).then(|| {
            let scene = bounds.iter().map(Bounds::greatest_coordinate).fold(0.0, f32::max);
            let padded: Vec<_> = bounds.iter().map(|one| PaddedBounds(one.padded(scene * 1e-5))).collect();
            build_cwbvh(&padded, BvhBuildParams::medium_build(), &mut Duration::default())
        });
        Self { objects, bounds, hierarchy }
    }

    /// The objects, in the order of the scene.
    pub fn list(&self) -> &[Object] {
        &self.objects
    }

    /// What the ray hits first.
    pub fn first_hit(&self, ray: &Ray) -> Option<Surface> {
        let mut nearest = f32::INFINITY;
        let mut found = None;
        self.visit(ray, f32::INFINITY, |index| {
            let Some(hit) = self.objects[index].shape.first_hit(ray, nearest) else {
                return f32::INFINITY;
            };
            nearest = hit.distance_m;
            found = Some((index, hit));
            nearest
        });
        let (object, hit) = found?;
        let facing = hit.normal.dot(ray.direction) <= 0.0;
        Some(Surface {
            object,
            material: self.objects[object].material,
            point: hit.point,
            normal: if facing { hit.normal } else { -hit.normal },
            direction: ray.direction,
        })
    }

    /// Whether anything lies on the ray nearer than `limit_m`.
    pub fn blocked(&self, ray: &Ray, limit_m: f32) -> bool {
        let mut blocked = false;
        self.visit(ray, limit_m, |index| {
            blocked = blocked || self.objects[index].shape.blocks(ray, limit_m);
            // Nothing can lie nearer than behind the origin: this ends the search.
            if blocked { f32::NEG_INFINITY } else { f32::INFINITY }
        });
        blocked
    }

    /// Collects every crossing of a line with one object's surface, in no particular order.
    pub fn crossings(&self, object: usize, ray: &Ray, crossings: &mut Vec<Crossing>) {
        crossings.clear();
        match &self.objects[object].shape {
            Shape::Cuboid(cuboid) => cuboid.crossings(ray, crossings),
            Shape::Mesh(mesh) => mesh.crossings(ray, crossings),
        }
    }

    /// Calls `try_object` for objects whose box the ray meets; it returns the distance up to which to look on.
    #[inline]
    fn visit(&self, ray: &Ray, limit_m: f32, mut try_object: impl FnMut(usize) -> f32) {
        let Some(hierarchy) = &self.hierarchy else {
            let mut nearest = limit_m;
            for (index, bounds) in self.bounds.iter().enumerate() {
                if bounds.span(ray, 0.0, nearest).is_some() {
                    nearest = nearest.min(try_object(index));
                }
            }
            return;
        };
        let box_ray = obvhs::ray::Ray {
            origin: ray.at(-RUN_UP_M),
            direction: ray.direction,
            inv_direction: finite_inverse(ray.direction),
            tmin: 0.0,
            tmax: limit_m + RUN_UP_M,
        };
        hierarchy.ray_traverse(box_ray, &mut RayHit::none(), |_, index| {
            try_object(hierarchy.primitive_indices[index] as usize) + RUN_UP_M
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Mat3A;

    fn row(count: usize) -> Objects {
        let cube =
            |k: usize| Shape::Cuboid(Cuboid::new(Vec3A::new(2.0 * k as f32, 0.0, 0.0), Vec3A::ONE, Mat3A::IDENTITY));
        Objects::new((0..count).map(|k| Object { shape: cube(k), material: k }).collect())
    }

    #[test]
    fn few_objects_and_many_answer_alike() {
        for count in [3, 40] {
            let objects = row(count);
            let from_left = Ray { origin: Vec3A::new(-5.0, 0.1, 0.2), direction: Vec3A::X };
            let hit = objects.first_hit(&from_left).unwrap();
            assert_eq!((hit.object, hit.material), (0, 0));
            assert!((hit.point.x + 0.5).abs() < 1e-6 && (hit.normal.x + 1.0).abs() < 1e-6);
            let last = (count - 1) as f32;
            let from_right = Ray { origin: Vec3A::new(2.0 * last + 5.0, 0.1, 0.2), direction: Vec3A::NEG_X };
            assert_eq!(objects.first_hit(&from_right).unwrap().object, count - 1);
            assert!(objects.blocked(&from_left, 4.6) && !objects.blocked(&from_left, 4.4));
            let between = Ray { origin: Vec3A::new(1.0, -3.0, 0.0), direction: Vec3A::Y };
            assert!(objects.first_hit(&between).is_none() && !objects.blocked(&between, 99.0));
        }
    }
}
