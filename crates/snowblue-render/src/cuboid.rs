//! Boxes in any orientation, exact: a line meets one in two points or none (Kay & Kajiya 1986, "Ray tracing complex
//! scenes", doi:10.1145/15922.15916, the slab method, in the box's own coordinates).

use glam::{Mat3A, Vec3A};

use crate::bounds::{Bounds, finite_inverse};
use crate::ray::{Crossing, Ray, ShapeHit};
use crate::surface_texture::TexturePlace;

/// A solid box.
#[derive(Debug, Clone, Copy)]
pub struct Cuboid {
    centre: Vec3A,
    half_size: Vec3A,
    /// Columns: the box's axes in the scene.
    axes: Mat3A,
    /// The same as rows: from the scene to the box.
    to_local: Mat3A,
}

/// Where a line goes through one of the six faces, in the box's coordinates.
struct Face {
    distance_m: f32,
    axis: usize,
    sign: f32,
}

impl Cuboid {
    /// A box of given full size around `centre`, both in m, turned by the rotation matrix `axes`.
    pub fn new(centre: Vec3A, size: Vec3A, axes: Mat3A) -> Self {
        Self { centre, half_size: size * 0.5, axes, to_local: axes.transpose() }
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
    pub fn first_hit(&self, ray: &Ray, limit_m: f32) -> Option<ShapeHit> {
        let local = self.own(ray);
        let [near, far] = self.faces(&local)?;
        let face = if near.distance_m > 0.0 { near } else { far };
        if face.distance_m <= 0.0 || face.distance_m >= limit_m {
            return None;
        }
        let mut point = local.at(face.distance_m);
        point[face.axis] = face.sign * self.half_size[face.axis];
        Some(ShapeHit::plain(face.distance_m, self.centre + self.axes * point, self.normal(&face)))
    }

    /// Whether its surface lies beyond the ray's origin and nearer than `limit_m`.
    pub fn blocks(&self, ray: &Ray, limit_m: f32) -> bool {
        let within = |distance_m: f32| distance_m > 0.0 && distance_m < limit_m;
        self.faces(&self.own(ray)).is_some_and(|[near, far]| within(near.distance_m) || within(far.distance_m))
    }

    /// Adds the two crossings of the whole line of the ray, if it meets the box.
    ///
    /// A cube's longest line is its space diagonal, √3 times its edge:
    /// ```
    /// # use snowblue_render::{cuboid::Cuboid, ray::Ray};
    /// # use glam::{Mat3A, Vec3A};
    /// let cube = Cuboid::new(Vec3A::ZERO, Vec3A::ONE, Mat3A::IDENTITY);
    /// let mut crossings = Vec::new();
    /// cube.crossings(&Ray { origin: Vec3A::splat(-2.0), direction: Vec3A::ONE.normalize() }, &mut crossings);
    /// let length_m = crossings[1].distance_m - crossings[0].distance_m;
    /// assert!((length_m - 3f32.sqrt()).abs() < 1e-6);
    /// ```
    pub fn crossings(&self, ray: &Ray, crossings: &mut Vec<Crossing>) {
        if let Some(faces) = self.faces(&self.own(ray)) {
            crossings.extend(faces.map(|face| Crossing::new(face.distance_m, self.normal(&face))));
        }
    }

    /// The place for textures of a point on it whose normal is that of the side that is seen.
    pub(crate) fn texture_place(&self, point: Vec3A, normal: Vec3A) -> TexturePlace {
        TexturePlace::on_box(self.to_local * (point - self.centre), self.to_local * normal)
    }

    #[inline]
    fn own(&self, ray: &Ray) -> Ray {
        Ray { origin: self.to_local * (ray.origin - self.centre), direction: self.to_local * ray.direction }
    }

    fn normal(&self, face: &Face) -> Vec3A {
        self.axes.col(face.axis) * face.sign
    }

    /// The face through which the line comes in and the one through which it goes out.
    #[inline]
    fn faces(&self, local: &Ray) -> Option<[Face; 2]> {
        let inverse = finite_inverse(local.direction);
        let middle = -local.origin * inverse;
        let reach = self.half_size * inverse.abs();
        let (enter, leave) = (middle - reach, middle + reach);
        let near = enter.max_element();
        let far = leave.min_element();
        if near >= far {
            return None;
        }
        let near_axis = enter.max_position();
        let far_axis = leave.min_position();
        Some([
            Face { distance_m: near, axis: near_axis, sign: -local.direction[near_axis].signum() },
            Face { distance_m: far, axis: far_axis, sign: local.direction[far_axis].signum() },
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{EulerRot, Vec3};

    use crate::mesh::Mesh;
    use crate::triangles::Triangles;

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
        let mesh = Mesh::new(Triangles::loose(&triangles(centre, size, axes)));
        let (mut exact, mut traced) = (Vec::new(), Vec::new());
        let mut met = 0;
        for k in 0..5000 {
            let turn = 2.399_963 * k as f32;
            let z = 1.0 - 2.0 * (k as f32 + 0.5) / 5000.0;
            let direction = Vec3A::new((1.0 - z * z).sqrt() * turn.cos(), (1.0 - z * z).sqrt() * turn.sin(), z);
            let side = direction.any_orthonormal_vector() * (0.35 * (k % 17) as f32 / 17.0);
            let ray = Ray { origin: Vec3A::from(centre) + side - direction * 2.0, direction };
            exact.clear();
            traced.clear();
            cuboid.crossings(&ray, &mut exact);
            mesh.crossings(&ray, &mut traced);
            assert_eq!(exact.len(), traced.len(), "line {k}");
            if exact.is_empty() {
                assert!(cuboid.first_hit(&ray, 9.0).is_none() && !cuboid.blocks(&ray, 9.0));
                continue;
            }
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
            assert!(hit.normal.dot(direction) < 0.0 && cuboid.blocks(&ray, 9.0));
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
