//! Triangle meshes: first hit, blocked or not, and all crossings along a line.
//!
//! Walks through the hierarchy and the triangle test, which has no cracks, do not know front from back. Both are made fit for
//! exact counting here: every query first moves its start to the mesh's bounding box, so that rounding is that of the mesh's size
//! and not of its distance, and the boxes of the hierarchy are padded by more than that rounding.

use glam::{Vec2, Vec3, Vec3A};

use crate::bvh::bvh8::{Bvh8, BvhRay};
use crate::geometry::bounds::Bounds;
use crate::geometry::ray::{Crossing, MeshLocation, Ray, ShapeHit, narrow};
use crate::geometry::triangle::{FourTriangles, ShearedRay, TriangleHit};
use crate::geometry::triangle_mesh::TriangleMesh;

/// Padding of the hierarchy's boxes as a share of the mesh's greatest coordinate and size: 16 units in the last
/// place, where a box test rounds three times.
const BOX_PADDING: f32 = 16.0 * f32::EPSILON;

/// A surface of triangles in coordinates of its own; distances along rays are in their unit.
#[derive(Debug)]
pub struct Mesh {
    /// The triangles as the file has them.
    source: TriangleMesh,
    /// The triangles of the hierarchy's leaves.
    leaves: Vec<FourTriangles>,
    hierarchy: Bvh8,
    bounds: Bounds,
}

impl Mesh {
    /// Builds the hierarchy over triangles.
    ///
    /// # Panics
    ///
    /// When there is no triangle, or a coordinate is not finite: the file readers refuse both.
    pub fn new(source: TriangleMesh) -> Self {
        assert!(!source.indices.is_empty(), "a mesh has at least one triangle");
        let triangles = || (0..source.indices.len()).map(|triangle| source.corners(triangle));
        let tight = Bounds::of(triangles().flatten());
        let padding = BOX_PADDING * (tight.greatest_coordinate() + tight.diagonal_m());
        let hierarchy = {
            let padded: Vec<_> = triangles().map(|corners| Bounds::of(corners.into_iter()).padded(padding)).collect();
            Bvh8::over(&padded)
        };
        let four = |leaf| FourTriangles::new(hierarchy.things(leaf).map(|triangle| source.corners(triangle)));
        let leaves = (0..hierarchy.leaf_count()).map(four).collect();
        Self { source, leaves, hierarchy, bounds: tight.padded(padding) }
    }

    /// The indexed triangles.
    pub fn triangles(&self) -> &TriangleMesh {
        &self.source
    }

    /// Texture coordinates at a place, if the file has them.
    pub fn uv(&self, place: &MeshLocation) -> Option<Vec2> {
        self.source.indices[place.triangle as usize]
            .iter()
            .zip(place.weights)
            .try_fold(Vec2::ZERO, |sum, (&at, weight)| Some(sum + *self.source.uv.get(at as usize)? * weight))
    }

    /// A further value of the file's vertices at a place, by its name there.
    pub fn attribute(&self, name: &str, place: &MeshLocation) -> Option<f32> {
        let values = self.source.attributes.get(name)?;
        let corners = self.source.indices[place.triangle as usize];
        Some(corners.iter().zip(place.weights).map(|(&at, weight)| values[at as usize] * weight).sum())
    }

    /// The axis-parallel box around it.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The first hit beyond the ray's origin and nearer than `limit_m`.
    pub(crate) fn first_hit(&self, ray: &Ray, limit_m: f32) -> Option<ShapeHit> {
        let query = Query::new(self, ray, 0.0, limit_m)?;
        let mut nearest_m = limit_m - query.start_m;
        let mut found = None;
        self.hierarchy.traverse_ordered(&query.course, |leaf| {
            query.cross(&self.leaves[leaf], |place, hit| {
                let distance_m = narrow(hit.distance_m);
                // Of two at one distance, at a fold, that of the lower number, in whichever order they come.
                let before = |(leaf_found, place_found, _)| {
                    distance_m <= nearest_m
                        && self.hierarchy.thing(leaf, place) < self.hierarchy.thing(leaf_found, place_found)
                };
                let is_nearest = distance_m < nearest_m || found.is_some_and(before);
                if query.beyond_origin(hit.distance_m) && is_nearest {
                    nearest_m = distance_m;
                    found = Some((leaf, place, hit.weights));
                }
            });
            nearest_m
        });
        let (leaf, place, weights) = found?;
        let corners = self.leaves[leaf].corners(place);
        let [u, v, w] = weights.map(narrow);
        Some(ShapeHit {
            distance_m: nearest_m + query.start_m,
            point: (corners[0] * u + corners[1] * v + corners[2] * w).into(),
            normal: area_normal(&corners).normalize(),
            place: MeshLocation { triangle: self.hierarchy.thing(leaf, place), weights: [u, v, w] },
        })
    }

    /// Whether anything lies beyond the ray's origin and nearer than `limit_m`.
    pub(crate) fn occludes(&self, ray: &Ray, limit_m: f32) -> bool {
        let Some(query) = Query::new(self, ray, 0.0, limit_m) else {
            return false;
        };
        let mut blocked = false;
        self.hierarchy.walk(&query.course, |leaf| {
            query.cross(&self.leaves[leaf], |_, hit| {
                blocked |= query.beyond_origin(hit.distance_m) && narrow(hit.distance_m) < limit_m - query.start_m;
            });
            blocked
        });
        blocked
    }

    /// Adds every crossing of the line of the ray from `from_m` on, be that before or behind its origin, in no particular order.
    pub(crate) fn crossings(&self, ray: &Ray, from_m: f32, crossings: &mut Vec<Crossing>) {
        let Some(query) = Query::new(self, ray, from_m, f32::INFINITY) else {
            return;
        };
        self.hierarchy.walk(&query.course, |leaf| {
            let four = &self.leaves[leaf];
            query.cross(four, |place, hit| {
                let distance_m = narrow(hit.distance_m + f64::from(query.start_m));
                if distance_m >= from_m {
                    crossings.push(Crossing::new(distance_m, area_normal(&four.corners(place))));
                }
            });
            false
        });
    }
}

/// A ray moved to the mesh's box; `start_m` is where, along the original ray.
struct Query {
    start_m: f32,
    course: BvhRay,
    sheared: ShearedRay,
}

impl Query {
    /// The part from `from_m` to `limit_m` of a ray, or none where it misses the box.
    #[inline]
    fn new(mesh: &Mesh, ray: &Ray, from_m: f32, limit_m: f32) -> Option<Self> {
        let (start_m, _) = mesh.bounds.span(ray, from_m, limit_m)?;
        let moved = Ray { origin: ray.at(start_m), direction: ray.direction };
        // Where the box alone bounds it, it is not cut there: from afar, the place where it was moved to may be inside the box
        // already, by rounding.
        let from = if start_m > from_m { f32::NEG_INFINITY } else { 0.0 };
        Some(Self { start_m, course: BvhRay::new(&moved, from, limit_m - start_m), sheared: ShearedRay::new(&moved) })
    }

    /// Calls `found` with those of a leaf's triangles that the line crosses, and where.
    #[inline(always)]
    fn cross(&self, four: &FourTriangles, mut found: impl FnMut(usize, TriangleHit)) {
        let mut may = self.sheared.may_cross(four);
        while may != 0 {
            let place = may.trailing_zeros() as usize;
            may &= may - 1;
            if let Some(hit) = self.sheared.intersect(&four.corners(place)) {
                found(place, hit);
            }
        }
    }

    fn beyond_origin(&self, distance_m: f64) -> bool {
        distance_m + f64::from(self.start_m) > 0.0
    }
}

/// Normal with the length of twice the area, by the order of the corners.
fn area_normal(corners: &[Vec3; 3]) -> Vec3A {
    (corners[1] - corners[0]).cross(corners[2] - corners[0]).into()
}

#[cfg(test)]
pub(crate) mod tests;
