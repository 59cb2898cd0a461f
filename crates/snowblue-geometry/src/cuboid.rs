//! Oriented boxes, by the slab method in object space (Kay & Kajiya 1986, "Ray tracing complex scenes",
//! doi:10.1145/15922.15916). A line crosses a box twice or not at all.

use glam::{BVec3A, Mat3A, Vec3A};

use crate::bounds::{Bounds, Interval, finite_inverse};
use crate::ray::{Crossing, Ray, ShapeHit};
use crate::texture_coordinates::TextureCoordinates;
use crate::triangle_mesh::TriangleMesh;

/// A solid box.
#[derive(Debug, Clone, Copy)]
pub struct Cuboid {
    centre: Vec3A,
    half_size: Vec3A,
    /// The axes of the box in scene space, as columns.
    axes: Mat3A,
    /// The transpose: from scene space to object space.
    to_object: Mat3A,
    /// Whether the axes of the box are the axes of the scene, which saves the rotations.
    is_axis_aligned: bool,
}

/// Distances at which a line enters and leaves the three slabs between opposite faces, in m.
struct Slabs {
    enter_m: Vec3A,
    leave_m: Vec3A,
}

impl Cuboid {
    /// A box of a full size around `centre`, both in m, rotated by the matrix `axes`.
    pub fn new(centre: Vec3A, size: Vec3A, axes: Mat3A) -> Self {
        Self {
            centre,
            half_size: size * 0.5,
            axes,
            to_object: axes.transpose(),
            is_axis_aligned: axes == Mat3A::IDENTITY,
        }
    }

    /// Axis-aligned bounds.
    pub fn bounds(&self) -> Bounds {
        let half_extent = self.axes.x_axis.abs() * self.half_size.x
            + self.axes.y_axis.abs() * self.half_size.y
            + self.axes.z_axis.abs() * self.half_size.z;
        Bounds { low: self.centre - half_extent, high: self.centre + half_extent }
    }

    /// The corner on the sides of these signs.
    pub fn corner(&self, signs: Vec3A) -> Vec3A {
        self.centre + self.axes * (self.half_size * signs)
    }

    /// Its surface, two triangles for each side, which face outwards.
    pub fn triangles(&self) -> TriangleMesh {
        const SIDES: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let sign = |bits: u32, axis: u32| if bits >> axis & 1 == 0 { -1.0 } else { 1.0 };
        let corner = |bits: u32| self.corner(Vec3A::new(sign(bits, 0), sign(bits, 1), sign(bits, 2))).into();
        let indices = SIDES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        TriangleMesh { positions: (0..8).map(corner).collect(), indices, ..TriangleMesh::default() }
    }

    /// Its axes and its middle.
    pub(crate) fn frame(&self) -> (Mat3A, Vec3A) {
        (self.axes, self.centre)
    }

    /// Volume in m³.
    pub fn volume_m3(&self) -> f64 {
        let size = 2.0 * self.half_size.as_dvec3();
        size.x * size.y * size.z
    }

    /// The first hit beyond the ray's origin and nearer than `limit_m`.
    #[inline]
    pub fn first_hit(&self, ray: &Ray, limit_m: f32) -> Option<ShapeHit> {
        let local = self.ray_to_object(ray);
        let slabs = self.slabs(&local);
        let distance_m = slabs.first_hit_m(limit_m)?;
        let [entered, left] = [slabs.enter_m, slabs.leave_m].map(|planes_m| planes_m.cmpeq(Vec3A::splat(distance_m)));
        let (met, outward) = if entered.any() { (entered, -local.direction) } else { (left, local.direction) };
        let side = Vec3A::ONE.copysign(outward);
        let point = Vec3A::select(met, side * self.half_size, local.at(distance_m));
        Some(ShapeHit::plain(
            distance_m,
            self.centre + self.rotate_to_scene(point),
            self.rotate_to_scene(face_normal(met, side)),
        ))
    }

    /// Whether the ray hits the surface beyond its origin and nearer than `limit_m`.
    #[inline]
    pub fn occludes(&self, ray: &Ray, limit_m: f32) -> bool {
        self.slabs(&self.ray_to_object(ray)).first_hit_m(limit_m).is_some()
    }

    /// The two crossings of the ray's line, in order and with unit normals.
    ///
    /// The longest chord of a cube is its space diagonal, √3 times its edge:
    /// ```
    /// # use snowblue_geometry::{cuboid::Cuboid, ray::Ray};
    /// # use glam::{Mat3A, Vec3A};
    /// let cube = Cuboid::new(Vec3A::ZERO, Vec3A::ONE, Mat3A::IDENTITY);
    /// let ray = Ray::new(Vec3A::splat(-2.0), Vec3A::ONE.normalize());
    /// let [enter, leave] = cube.crossings(&ray).unwrap();
    /// assert!((leave.distance_m - enter.distance_m - 3f32.sqrt()).abs() < 1e-6);
    /// ```
    #[inline]
    pub fn crossings(&self, ray: &Ray) -> Option<[Crossing; 2]> {
        let local = self.ray_to_object(ray);
        let slabs = self.slabs(&local);
        let Interval { start_m: near_m, end_m: far_m } = slabs.inside()?;
        let side = Vec3A::ONE.copysign(local.direction);
        let inward = face_normal(slabs.enter_m.cmpeq(Vec3A::splat(near_m)), -side);
        let outward = face_normal(slabs.leave_m.cmpeq(Vec3A::splat(far_m)), side);
        let [inward, outward] = [inward, outward].map(|normal| self.rotate_to_scene(normal));
        Some([Crossing::new(near_m, inward, true), Crossing::new(far_m, outward, false)])
    }

    /// Whether a point inside is farther than `depth_m` from all faces.
    #[inline]
    pub(crate) fn holds_deeply(&self, point: Vec3A, depth_m: f32) -> bool {
        let local = self.to_object * (point - self.centre);
        (self.half_size - local.abs()).min_element() > depth_m
    }

    /// The point of the surface that is nearest to a point.
    pub(crate) fn nearest(&self, point: Vec3A) -> ShapeHit {
        let local = self.to_object * (point - self.centre);
        let within = local.clamp(-self.half_size, self.half_size);
        let to_faces = self.half_size - within.abs();
        let axis = (0..3).min_by(|one, other| to_faces[*one].total_cmp(&to_faces[*other])).unwrap_or_default();
        let (mut nearest, mut normal) = (within, Vec3A::ZERO);
        normal[axis] = 1.0_f32.copysign(local[axis]);
        nearest[axis] = self.half_size[axis] * normal[axis];
        let on_surface = self.centre + self.rotate_to_scene(nearest);
        ShapeHit::plain(on_surface.distance(point), on_surface, self.rotate_to_scene(normal))
    }

    /// Texture coordinates of a point on the surface, with a normal on either side.
    pub fn texture_coordinates(&self, point: Vec3A, normal: Vec3A) -> TextureCoordinates {
        let (point, normal) = (self.to_object * (point - self.centre), self.to_object * normal);
        TextureCoordinates::on_box(point, if normal.dot(point) < 0.0 { -normal } else { normal })
    }

    #[inline]
    fn ray_to_object(&self, ray: &Ray) -> Ray {
        let origin = ray.origin - self.centre;
        if self.is_axis_aligned {
            return Ray { origin, ..*ray };
        }
        let [origin, direction, remainder] =
            [origin, ray.direction, ray.remainder].map(|vector| self.to_object * vector);
        Ray { origin, direction, remainder }
    }

    /// Rotates a vector to scene space.
    #[inline]
    fn rotate_to_scene(&self, local: Vec3A) -> Vec3A {
        if self.is_axis_aligned { local } else { self.axes * local }
    }

    /// The slabs along a line.
    #[inline]
    fn slabs(&self, local: &Ray) -> Slabs {
        let inverse = finite_inverse(local.direction);
        // Relative to the centre, the difference of nearly equal coordinates is exact.
        let far = self.half_size.copysign(inverse);
        let distance_m = |plane: Vec3A| (plane - local.origin - local.remainder) * inverse;
        Slabs { enter_m: distance_m(-far), leave_m: distance_m(far) }
    }
}

impl Slabs {
    /// The interval in which the line is inside the box.
    #[inline]
    fn inside(&self) -> Option<Interval> {
        let (start_m, end_m) = (self.enter_m.max_element(), self.leave_m.min_element());
        (start_m < end_m).then_some(Interval { start_m, end_m })
    }

    /// The first hit beyond the origin and nearer than `limit_m`.
    #[inline]
    fn first_hit_m(&self, limit_m: f32) -> Option<f32> {
        let Interval { start_m: near_m, end_m: far_m } = self.inside()?;
        let distance_m = if near_m > 0.0 { near_m } else { far_m };
        (distance_m > 0.0 && distance_m < limit_m).then_some(distance_m)
    }
}

/// The unit normal along the first of the selected axes, of which there is at least one. A hit on an edge thus
/// belongs to one face, and all normals of a face are bit for bit equal.
#[inline]
fn face_normal(axes: BVec3A, side: Vec3A) -> Vec3A {
    const FIRST_OF: [Vec3A; 8] = [Vec3A::X, Vec3A::X, Vec3A::Y, Vec3A::X, Vec3A::Z, Vec3A::X, Vec3A::Y, Vec3A::X];
    let axis = FIRST_OF[axes.bitmask() as usize % 8];
    axis * axis.dot(side)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{EulerRot, Vec3};

    use crate::mesh_bvh::MeshBvh;
    use crate::triangle_mesh::TriangleMesh;

    /// The twelve triangles of a box.
    fn triangles(centre: Vec3, size: Vec3, axes: Mat3A) -> Vec<[Vec3; 3]> {
        let corner = |bits: usize| {
            let sign = Vec3::from_array([1, 2, 4].map(|bit| if bits & bit == 0 { -0.5 } else { 0.5 }));
            centre + axes * (sign * size)
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|bits| bits.map(corner)).collect()
    }

    #[test]
    fn slabs_and_triangles_agree_from_every_direction() {
        let (centre, size) = (Vec3::new(0.3, -0.2, 0.4), Vec3::new(0.6, 0.3, 0.5));
        let axes = Mat3A::from_euler(EulerRot::XYZ, 0.4, -0.7, 1.1);
        let cuboid = Cuboid::new(centre.into(), size.into(), axes);
        let mesh = MeshBvh::new(TriangleMesh::from_triangles(&triangles(centre, size, axes)));
        let (mut traced, mut met) = (Vec::new(), 0);
        for k in 0..5000 {
            let turn = 2.399_963 * k as f32;
            let z = 1.0 - 2.0 * (k as f32 + 0.5) / 5000.0;
            let direction = Vec3A::new((1.0 - z * z).sqrt() * turn.cos(), (1.0 - z * z).sqrt() * turn.sin(), z);
            let side = direction.any_orthonormal_vector() * (0.35 * (k % 17) as f32 / 17.0);
            let ray = Ray::new(Vec3A::from(centre) + side - direction * 2.0, direction);
            traced.clear();
            mesh.crossings(&ray, f32::NEG_INFINITY, &mut traced);
            let exact = cuboid.crossings(&ray);
            assert_eq!(traced.len(), if exact.is_some() { 2 } else { 0 }, "line {k}");
            let Some(exact) = exact else {
                assert!(cuboid.first_hit(&ray, 9.0).is_none() && !cuboid.occludes(&ray, 9.0));
                continue;
            };
            met += 1;
            traced.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
            for (one, other) in exact.iter().zip(&traced) {
                // Rounding of coordinates of a few metres, divided by the cosine for oblique lines.
                let cos = one.normal.dot(direction).abs();
                assert!((one.distance_m - other.distance_m).abs() * cos < 2e-6, "line {k}");
                assert!(one.normal.dot(other.normal.normalize()).abs() > 0.999_99, "line {k}");
            }
            let hit = cuboid.first_hit(&ray, 9.0).unwrap();
            let traced_hit = mesh.first_hit(&ray, 9.0).unwrap();
            let apart = hit.point - traced_hit.point;
            assert!(apart.dot(hit.normal).abs() < 4e-7, "both points lie on the face");
            assert!(apart.length() * hit.normal.dot(direction).abs() < 2e-6, "line {k}");
            assert!(hit.normal.dot(direction) < 0.0 && cuboid.occludes(&ray, 9.0));
            let inside = Ray::new(hit.point + 1e-3 * direction, direction);
            if let Some(out) = cuboid.first_hit(&inside, 9.0) {
                assert!(
                    out.normal.dot(exact[1].normal) > 0.999_99
                        && (out.distance_m + 1e-3 + hit.distance_m - exact[1].distance_m).abs() < 1e-5
                );
            }
        }
        assert!(met > 3000, "{met}");
    }

    #[test]
    fn bounds_touch_the_corners() {
        let quarter = Mat3A::from_rotation_z(std::f32::consts::FRAC_PI_4);
        let bounds = Cuboid::new(Vec3A::X, Vec3A::splat(2.0), quarter).bounds();
        assert!((bounds.high - Vec3A::new(1.0 + 2f32.sqrt(), 2f32.sqrt(), 1.0)).length() < 1e-6);
    }
}
