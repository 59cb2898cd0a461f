//! Boxes in any orientation, exact: a line meets one in two points or none (Kay & Kajiya 1986, "Ray tracing complex
//! scenes", doi:10.1145/15922.15916, the slab method, in the box's own coordinates).

use glam::{BVec3A, Mat3A, Vec3A};

use crate::geometry::bounds::{Bounds, finite_inverse};
use crate::geometry::ray::{Crossing, Ray, ShapeHit};
use crate::geometry::texture_coordinates::TextureCoordinates;

/// A solid box.
#[derive(Debug, Clone, Copy)]
pub struct Cuboid {
    centre: Vec3A,
    half_size: Vec3A,
    /// Columns: the box's axes in the scene.
    axes: Mat3A,
    /// The same as rows: from the scene to the box.
    to_local: Mat3A,
    /// Whether the box's axes are those of the scene, as those of most boxes are.
    is_upright: bool,
}

/// Where a line goes through the three pairs of planes in which the faces lie, in the box's coordinates and in m along it.
struct Slabs {
    enter_m: Vec3A,
    leave_m: Vec3A,
}

impl Cuboid {
    /// A box of given full size around `centre`, both in m, turned by the rotation matrix `axes`.
    pub fn new(centre: Vec3A, size: Vec3A, axes: Mat3A) -> Self {
        Self { centre, half_size: size * 0.5, axes, to_local: axes.transpose(), is_upright: axes == Mat3A::IDENTITY }
    }

    /// The axis-parallel box around it.
    pub fn bounds(&self) -> Bounds {
        let reach = self.axes.x_axis.abs() * self.half_size.x
            + self.axes.y_axis.abs() * self.half_size.y
            + self.axes.z_axis.abs() * self.half_size.z;
        Bounds { low: self.centre - reach, high: self.centre + reach }
    }

    /// Volume in m³.
    pub fn volume_m3(&self) -> f64 {
        let size = 2.0 * self.half_size.as_dvec3();
        size.x * size.y * size.z
    }

    /// The first hit beyond the ray's origin and nearer than `limit_m`.
    #[inline]
    pub fn first_hit(&self, ray: &Ray, limit_m: f32) -> Option<ShapeHit> {
        let local = self.own(ray);
        let slabs = self.slabs(&local);
        let distance_m = slabs.ahead_m(limit_m)?;
        let [entered, left] = [slabs.enter_m, slabs.leave_m].map(|planes_m| planes_m.cmpeq(Vec3A::splat(distance_m)));
        let (met, outward) = if entered.any() { (entered, -local.direction) } else { (left, local.direction) };
        let side = Vec3A::ONE.copysign(outward);
        let point = Vec3A::select(met, side * self.half_size, local.at(distance_m));
        Some(ShapeHit::plain(distance_m, self.centre + self.turned(point), self.turned(one_of(met, side))))
    }

    /// Whether its surface lies beyond the ray's origin and nearer than `limit_m`.
    #[inline]
    pub fn occludes(&self, ray: &Ray, limit_m: f32) -> bool {
        self.slabs(&self.own(ray)).ahead_m(limit_m).is_some()
    }

    /// The two crossings of the whole line of the ray, in its order and with unit normals, if it meets the box.
    ///
    /// A cube's longest line is its space diagonal, √3 times its edge:
    /// ```
    /// # use snowblue_render::{cuboid::Cuboid, ray::Ray};
    /// # use glam::{Mat3A, Vec3A};
    /// let cube = Cuboid::new(Vec3A::ZERO, Vec3A::ONE, Mat3A::IDENTITY);
    /// let ray = Ray { origin: Vec3A::splat(-2.0), direction: Vec3A::ONE.normalize() };
    /// let [enter, leave] = cube.crossings(&ray).unwrap();
    /// assert!((leave.distance_m - enter.distance_m - 3f32.sqrt()).abs() < 1e-6);
    /// ```
    #[inline]
    pub fn crossings(&self, ray: &Ray) -> Option<[Crossing; 2]> {
        let local = self.own(ray);
        let slabs = self.slabs(&local);
        let (near_m, far_m) = slabs.span_m()?;
        let side = Vec3A::ONE.copysign(local.direction);
        let inward = one_of(slabs.enter_m.cmpeq(Vec3A::splat(near_m)), -side);
        let outward = one_of(slabs.leave_m.cmpeq(Vec3A::splat(far_m)), side);
        Some([Crossing::new(near_m, self.turned(inward)), Crossing::new(far_m, self.turned(outward))])
    }

    /// The place for textures of a point on it whose normal is that of the side that is seen.
    pub(crate) fn texture_coordinates(&self, point: Vec3A, normal: Vec3A) -> TextureCoordinates {
        TextureCoordinates::on_box(self.to_local * (point - self.centre), self.to_local * normal)
    }

    #[inline]
    fn own(&self, ray: &Ray) -> Ray {
        let origin = ray.origin - self.centre;
        if self.is_upright {
            return Ray { origin, direction: ray.direction };
        }
        Ray { origin: self.to_local * origin, direction: self.to_local * ray.direction }
    }

    /// A vector of the box in the scene.
    #[inline]
    fn turned(&self, local: Vec3A) -> Vec3A {
        if self.is_upright { local } else { self.axes * local }
    }

    /// Where a line goes through the planes of the faces.
    #[inline]
    fn slabs(&self, local: &Ray) -> Slabs {
        let inverse = finite_inverse(local.direction);
        let middle = -local.origin * inverse;
        let reach = self.half_size * inverse.abs();
        Slabs { enter_m: middle - reach, leave_m: middle + reach }
    }
}

impl Slabs {
    /// Where the line enters the box and leaves it, if it meets it.
    #[inline]
    fn span_m(&self) -> Option<(f32, f32)> {
        let (near_m, far_m) = (self.enter_m.max_element(), self.leave_m.min_element());
        (near_m < far_m).then_some((near_m, far_m))
    }

    /// Where the line meets the box first, beyond its origin and nearer than `limit_m`.
    #[inline]
    fn ahead_m(&self, limit_m: f32) -> Option<f32> {
        let (near_m, far_m) = self.span_m()?;
        let distance_m = if near_m > 0.0 { near_m } else { far_m };
        (distance_m > 0.0 && distance_m < limit_m).then_some(distance_m)
    }
}

/// The unit vector along one of some axes, of which there is at least one, on a side: an edge belongs to one face alone, and all
/// normals of a face have the same bits.
#[inline]
fn one_of(axes: BVec3A, side: Vec3A) -> Vec3A {
    const FIRST_OF: [Vec3A; 8] = [Vec3A::X, Vec3A::X, Vec3A::Y, Vec3A::X, Vec3A::Z, Vec3A::X, Vec3A::Y, Vec3A::X];
    let axis = FIRST_OF[axes.bitmask() as usize % 8];
    axis * axis.dot(side)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{EulerRot, Vec3};

    use crate::geometry::mesh_bvh::MeshBvh;
    use crate::geometry::triangle_mesh::TriangleMesh;

    /// The twelve triangles of the same box.
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
            let ray = Ray { origin: Vec3A::from(centre) + side - direction * 2.0, direction };
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
                // The rounding of coordinates of a few metres, longer along the line the more obliquely it passes.
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
            let inside = Ray { origin: hit.point + 1e-3 * direction, direction };
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
