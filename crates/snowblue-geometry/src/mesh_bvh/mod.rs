//! Ray queries on a triangle mesh through its bounding volume hierarchy: first hit, occlusion, and all crossings of a
//! line.
//!
//! Crossings must be counted exactly. The triangle test is watertight and accepts either orientation. A query from
//! outside of the mesh's bounds moves its origin to the bounds, so that rounding errors scale with the size of the mesh
//! and not with its distance, and the boxes of the hierarchy are padded by more than these errors.

use glam::{Vec2, Vec3, Vec3A};

use crate::bounds::{Bounds, Interval};
use crate::bvh::{Bvh8, BvhRay};
use crate::ray::{Crossing, MeshLocation, Ray, ShapeHit};
use crate::transform::Transform;
use crate::triangle::{FourTriangles, ShearedRay, TriangleHit};
use crate::triangle_mesh::TriangleMesh;
use snowblue_base::narrow;

/// Padding of boxes, as a fraction of the mesh's greatest coordinate and diagonal: 16 units in the last place, where a
/// box test rounds three times.
const BOX_PADDING: f32 = 16.0 * f32::EPSILON;

/// A triangle mesh with its bounding volume hierarchy, in object space. Distances are in its unit of length.
#[derive(Debug)]
pub struct MeshBvh {
    triangles: TriangleMesh,
    /// The triangles of each leaf, for testing four at a time.
    leaves: Vec<FourTriangles>,
    bvh: Bvh8,
    bounds: Bounds,
}

impl MeshBvh {
    /// Builds the hierarchy.
    ///
    /// # Panics
    ///
    /// When there are no triangles or a coordinate is not finite. The mesh readers reject both.
    pub fn new(triangles: TriangleMesh) -> Self {
        assert!(!triangles.indices.is_empty(), "a mesh has at least one triangle");
        let corners = || (0..triangles.indices.len()).map(|triangle| triangles.corners(triangle));
        let tight = Bounds::of(corners().flatten());
        let padding = BOX_PADDING * (tight.greatest_coordinate() + tight.diagonal_m());
        let bvh = {
            let padded: Vec<_> = corners().map(|corners| Bounds::of(corners.into_iter()).padded(padding)).collect();
            Bvh8::build(&padded)
        };
        let four = |leaf| FourTriangles::new(bvh.primitives(leaf).map(|triangle| triangles.corners(triangle)));
        let leaves = (0..bvh.leaf_count()).map(four).collect();
        Self { triangles, leaves, bvh, bounds: tight.padded(padding) }
    }

    /// The indexed triangles.
    pub fn triangles(&self) -> &TriangleMesh {
        &self.triangles
    }

    /// Interpolated texture coordinates, if the mesh has them.
    pub fn uv(&self, location: &MeshLocation) -> Option<Vec2> {
        self.triangles.indices[location.triangle as usize]
            .iter()
            .zip(location.weights)
            .try_fold(Vec2::ZERO, |sum, (&at, weight)| Some(sum + *self.triangles.uv.get(at as usize)? * weight))
    }

    /// The interpolated unit vertex normal in object space; none where the face is flat.
    pub fn shading_normal(&self, location: &MeshLocation) -> Option<Vec3A> {
        let vertices = self.triangles.indices[location.triangle as usize];
        self.triangles.normals.at(location.triangle, vertices, location.weights).map(Vec3A::from)
    }

    /// An interpolated vertex attribute, by its name in the mesh file.
    pub fn attribute(&self, name: &str, location: &MeshLocation) -> Option<f32> {
        let values = self.triangles.attributes.get(name)?;
        let vertices = self.triangles.indices[location.triangle as usize];
        Some(vertices.iter().zip(location.weights).map(|(&at, weight)| values[at as usize] * weight).sum())
    }

    /// Axis-aligned bounds, padded for ray queries.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The first hit beyond the ray's origin and nearer than `limit_m`. If two triangles are hit at equal distance,
    /// as at a fold, the triangle of lower index counts.
    pub fn first_hit(&self, ray: &Ray, limit_m: f32) -> Option<ShapeHit> {
        let query = MeshQuery::new(self, ray, Interval { start_m: 0.0, end_m: limit_m })?;
        let mut nearest_m = limit_m - query.start_m;
        let mut found = None;
        self.bvh.traverse_ordered(&query.bvh_ray, |leaf| {
            query.intersect(&self.leaves[leaf], |slot, hit| {
                let distance_m = narrow(hit.distance_m);
                let has_lower_index = |(leaf_found, slot_found, _)| {
                    distance_m <= nearest_m
                        && self.bvh.primitive(leaf, slot) < self.bvh.primitive(leaf_found, slot_found)
                };
                let is_nearest = distance_m < nearest_m || found.is_some_and(has_lower_index);
                if query.is_beyond_origin(hit.distance_m) && is_nearest {
                    nearest_m = distance_m;
                    found = Some((leaf, slot, hit.weights));
                }
            });
            nearest_m
        });
        let (leaf, slot, weights) = found?;
        let corners = self.leaves[leaf].corners(slot);
        let [u, v, w] = weights.map(narrow);
        Some(ShapeHit {
            distance_m: nearest_m + query.start_m,
            point: (corners[0] * u + corners[1] * v + corners[2] * w).into(),
            normal: area_normal(&corners).normalize(),
            location: MeshLocation { triangle: self.bvh.primitive(leaf, slot), weights: [u, v, w] },
        })
    }

    /// Whether the ray hits the mesh beyond its origin and nearer than `limit_m`.
    pub fn occludes(&self, ray: &Ray, limit_m: f32) -> bool {
        let Some(query) = MeshQuery::new(self, ray, Interval { start_m: 0.0, end_m: limit_m }) else {
            return false;
        };
        let mut occluded = false;
        self.bvh.traverse(&query.bvh_ray, |leaf| {
            query.intersect(&self.leaves[leaf], |_, hit| {
                occluded |= query.is_beyond_origin(hit.distance_m) && narrow(hit.distance_m) < limit_m - query.start_m;
            });
            occluded
        });
        occluded
    }

    /// Whether any triangle is nearer to a point than `distance_m`. The point is in scene space.
    pub fn is_near(&self, transform: &Transform, point: Vec3A, distance_m: f32) -> bool {
        let in_object = transform.point_to_object(point);
        let mut is_near = false;
        let in_object_units = distance_m * transform.greatest_stretch_to_object();
        self.bvh.visit_near(in_object, in_object_units, |leaf| {
            let four = &self.leaves[leaf];
            is_near = (0..self.bvh.primitives(leaf).count()).any(|slot| {
                let corners = four.corners(slot).map(|corner| transform.point_to_scene(corner.into()));
                square_distance_to_triangle(point, &corners) < distance_m * distance_m
            });
            if is_near { -1.0 } else { in_object_units }
        });
        is_near
    }

    /// The point of the surface that is nearest to a point, both in object space.
    pub(crate) fn nearest(&self, point: Vec3A) -> ShapeHit {
        let mut nearest = (f32::INFINITY, 0, 0);
        // A first guess, which grows until a triangle is within it.
        let mut distance = self.bounds.diagonal_m() / 1024.0;
        while nearest.0 > distance * distance {
            distance *= 2.0;
            self.bvh.visit_near(point, distance, |leaf| {
                let four = &self.leaves[leaf];
                for slot in 0..self.bvh.primitives(leaf).count() {
                    let square = square_distance_to_triangle(point, &four.corners(slot).map(Vec3A::from));
                    if square < nearest.0 {
                        nearest = (square, leaf, slot);
                    }
                }
                nearest.0.sqrt().min(distance)
            });
        }
        let (square, leaf, slot) = nearest;
        let corners = self.leaves[leaf].corners(slot);
        let weights = weights_nearest(point, &corners.map(Vec3A::from));
        let [u, v, w] = weights;
        ShapeHit {
            distance_m: square.sqrt(),
            point: (corners[0] * u + corners[1] * v + corners[2] * w).into(),
            normal: area_normal(&corners).normalize_or_zero(),
            location: MeshLocation { triangle: self.bvh.primitive(leaf, slot), weights },
        }
    }

    /// Adds all crossings of the ray's line from `from_m` on, which may be negative, in any order.
    pub fn crossings(&self, ray: &Ray, from_m: f32, crossings: &mut Vec<Crossing>) {
        let Some(query) = MeshQuery::new(self, ray, Interval { start_m: from_m, end_m: f32::INFINITY }) else {
            return;
        };
        self.bvh.traverse(&query.bvh_ray, |leaf| {
            let four = &self.leaves[leaf];
            query.intersect(four, |slot, hit| {
                let distance_m = narrow(hit.distance_m + f64::from(query.start_m));
                if distance_m >= from_m {
                    crossings.push(Crossing::new(distance_m, area_normal(&four.corners(slot)), hit.is_entry));
                }
            });
            false
        });
    }
}

/// A ray whose origin, if it was outside of the mesh's bounds, was moved to the bounds.
struct MeshQuery {
    /// Distance from the original origin to the new origin.
    start_m: f32,
    bvh_ray: BvhRay,
    sheared: ShearedRay,
}

impl MeshQuery {
    /// Prepares an interval of a ray; none if it misses the bounds.
    #[inline]
    fn new(mesh: &MeshBvh, ray: &Ray, interval: Interval) -> Option<Self> {
        let within = mesh.bounds.intersect(ray, interval)?;
        // The point of the interval that is nearest to the origin.
        let start_m = 0.0_f32.clamp(within.start_m, within.end_m);
        let mut moved = *ray;
        moved.advance(start_m);
        // If the interval starts before the bounds, the moved ray has no start: by rounding, the origin of a distant
        // ray may be moved into the bounds.
        let from_m = if within.start_m > interval.start_m { f32::NEG_INFINITY } else { interval.start_m - start_m };
        let moved_interval = Interval { start_m: from_m, end_m: interval.end_m - start_m };
        Some(Self { start_m, bvh_ray: BvhRay::new(&moved, moved_interval), sheared: ShearedRay::new(&moved) })
    }

    /// Calls `found` for each of a leaf's triangles that the line crosses.
    #[inline(always)]
    fn intersect(&self, four: &FourTriangles, mut found: impl FnMut(usize, TriangleHit)) {
        let mut candidates = self.sheared.candidates(four);
        while candidates != 0 {
            let slot = candidates.trailing_zeros() as usize;
            candidates &= candidates - 1;
            if let Some(hit) = self.sheared.intersect(&four.corners(slot)) {
                found(slot, hit);
            }
        }
    }

    /// Whether a distance from the new origin lies beyond the original origin.
    fn is_beyond_origin(&self, distance_m: f64) -> bool {
        distance_m + f64::from(self.start_m) > 0.0
    }
}

/// Square of the distance from a point to a triangle (Ericson 2005, *Real-Time Collision Detection*, section 5.1.5).
fn square_distance_to_triangle(point: Vec3A, [a, b, c]: &[Vec3A; 3]) -> f32 {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (along_ab, along_ac) = (ab.dot(ap), ac.dot(ap));
    if along_ab <= 0.0 && along_ac <= 0.0 {
        return ap.length_squared();
    }
    let bp = point - b;
    let (b_ab, b_ac) = (ab.dot(bp), ac.dot(bp));
    if b_ab >= 0.0 && b_ac <= b_ab {
        return bp.length_squared();
    }
    let cp = point - c;
    let (c_ab, c_ac) = (ab.dot(cp), ac.dot(cp));
    if c_ac >= 0.0 && c_ab <= c_ac {
        return cp.length_squared();
    }
    let beyond_ab = along_ab * b_ac - b_ab * along_ac;
    if beyond_ab <= 0.0 && along_ab >= 0.0 && b_ab <= 0.0 {
        return (ap - ab * (along_ab / (along_ab - b_ab))).length_squared();
    }
    let beyond_ac = c_ab * along_ac - along_ab * c_ac;
    if beyond_ac <= 0.0 && along_ac >= 0.0 && c_ac <= 0.0 {
        return (ap - ac * (along_ac / (along_ac - c_ac))).length_squared();
    }
    let beyond_bc = b_ab * c_ac - c_ab * b_ac;
    if beyond_bc <= 0.0 && b_ac >= b_ab && c_ab >= c_ac {
        let share = (b_ac - b_ab) / ((b_ac - b_ab) + (c_ab - c_ac));
        return (bp - (c - b) * share).length_squared();
    }
    let normal = ab.cross(ac);
    let along = normal.dot(ap);
    along * along / normal.length_squared()
}

/// Barycentric weights of the point of a triangle below a point, moved into the triangle.
fn weights_nearest(point: Vec3A, [a, b, c]: &[Vec3A; 3]) -> [f32; 3] {
    let normal = (*b - *a).cross(*c - *a);
    let share = |from: Vec3A, to: Vec3A| (to - from).cross(point - from).dot(normal).max(0.0);
    let [u, v, w] = [share(*b, *c), share(*c, *a), share(*a, *b)];
    let sum = u + v + w;
    if sum > 0.0 { [u, v, w].map(|share| share / sum) } else { [1.0, 0.0, 0.0] }
}

/// Normal by the order of the corners, with a length of twice the area.
fn area_normal(corners: &[Vec3; 3]) -> Vec3A {
    (corners[1] - corners[0]).cross(corners[2] - corners[0]).into()
}

#[cfg(test)]
mod tests;
