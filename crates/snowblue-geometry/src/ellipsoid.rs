//! Spheres and ellipsoids: the unit sphere under an affine map.
//!
//! In the coordinates of the unit sphere, a line o + t·d is nearest to the centre at t₀ = −o·d / d², in f = o + t₀ d,
//! and crosses the sphere at t₀ ± √((1 − f²) / d²). The form with f avoids cancellation for distant origins (Haines,
//! Günther & Akenine-Möller 2019, "Precision improvements for ray/sphere intersection", Ray Tracing Gems, chapter 7,
//! doi:10.1007/978-1-4842-4427-2_7). The arithmetic is in double precision.

use glam::{Affine3A, DAffine3, DVec3, Vec3A};

use crate::bounds::Bounds;
use crate::ray::{Crossing, Ray, ShapeHit, SurfacePoint};
use crate::texture_coordinates::TextureCoordinates;
use crate::transform::stretch;
use crate::triangle_mesh::TriangleMesh;
use snowblue_base::narrow;

/// A solid sphere or ellipsoid.
#[derive(Debug, Clone, Copy)]
pub struct Ellipsoid {
    to_scene: DAffine3,
    to_unit: DAffine3,
    /// A lower bound of its radii, in m; exact for a sphere.
    least_radius_m: f64,
}

impl Ellipsoid {
    /// The image of the unit sphere under a map to scene space, in m; none if the map is singular.
    pub fn new(to_scene: DAffine3) -> Option<Self> {
        let to_unit = to_scene.inverse();
        (to_scene.is_finite() && to_unit.is_finite()).then(|| Self {
            to_scene,
            to_unit,
            least_radius_m: stretch(&to_unit.matrix3).recip(),
        })
    }

    /// The map from the unit sphere to the scene.
    pub(crate) fn scene_map(&self) -> Affine3A {
        self.to_scene.as_affine3a()
    }

    /// Axis-aligned bounds.
    pub fn bounds(&self) -> Bounds {
        // The extent along an axis is the length of the matrix row: the support function of the ellipsoid.
        let rows = self.to_scene.matrix3.transpose();
        let reach = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        let centre = self.to_scene.translation;
        Bounds { low: (centre - reach).as_vec3a(), high: (centre + reach).as_vec3a() }
    }

    /// Whether a point inside is farther than `depth_m` from the surface: exactly for a sphere, and never too early for
    /// an ellipsoid.
    #[inline]
    pub(crate) fn holds_deeply(&self, point: Vec3A, depth_m: f32) -> bool {
        let unit = self.to_unit.transform_point3(point.as_dvec3());
        (1.0 - unit.length()) * self.least_radius_m > f64::from(depth_m)
    }

    /// The surface point that is the image of a point of the unit sphere.
    pub fn surface_point(&self, unit: DVec3) -> SurfacePoint {
        let point = self.to_scene.transform_point3(unit).as_vec3a();
        SurfacePoint { point, normal: self.normal(unit).as_vec3a().normalize() }
    }

    /// The surface point on the line from the centre through a point.
    pub fn project(&self, point: Vec3A) -> SurfacePoint {
        self.surface_point(self.to_unit.transform_point3(point.as_dvec3()).normalize_or(DVec3::Z))
    }

    /// The icosahedron with its corners on the surface, whose triangles face outwards.
    pub fn icosahedron(&self) -> TriangleMesh {
        let golden = 0.5 * (1.0 + 5f64.sqrt());
        let corner = |number: usize| {
            let [one, other] = [1, 2].map(|bit| if number & bit == 0 { 1.0 } else { -1.0 });
            let corner = [0.0, one, other * golden];
            DVec3::from_array(std::array::from_fn(|axis| corner[(axis + number / 4) % 3]))
        };
        let directions: Vec<DVec3> = (0..12).map(|number| corner(number).normalize()).collect();
        // Its edges are the shortest distances between corners: 1.05 on the unit sphere. The next distances are 1.70.
        let are_neighbours = |a: usize, b: usize| directions[a].distance(directions[b]) < 1.3;
        let mirrors = self.to_scene.matrix3.determinant() < 0.0;
        let mut indices = Vec::with_capacity(20);
        for a in 0..12 {
            for b in a + 1..12 {
                for c in b + 1..12 {
                    if are_neighbours(a, b) && are_neighbours(b, c) && are_neighbours(c, a) {
                        let [one, two, three] = [a, b, c].map(|corner| directions[corner]);
                        let faces_outwards = (two - one).cross(three - one).dot(one + two + three) > 0.0;
                        let turned = if faces_outwards == mirrors { [a, c, b] } else { [a, b, c] };
                        indices.push(turned.map(|vertex| u32::try_from(vertex).unwrap_or_default()));
                    }
                }
            }
        }
        let positions = directions.iter().map(|unit| self.surface_point(*unit).point.into()).collect();
        TriangleMesh { positions, indices, ..TriangleMesh::default() }
    }

    /// Volume in m³.
    pub fn volume_m3(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.to_scene.matrix3.determinant().abs()
    }

    /// The first hit beyond the ray's origin and nearer than `limit_m`.
    pub fn first_hit(&self, ray: &Ray, limit_m: f32) -> Option<ShapeHit> {
        let chord = self.intersect(ray)?;
        let distance_m = chord.first_hit_m(limit_m)?;
        let unit_point = chord.at(distance_m);
        let point = self.to_scene.transform_point3(unit_point).as_vec3a();
        Some(ShapeHit::plain(narrow(distance_m), point, self.normal(unit_point).as_vec3a().normalize()))
    }

    /// Whether the ray hits the surface beyond its origin and nearer than `limit_m`.
    pub fn occludes(&self, ray: &Ray, limit_m: f32) -> bool {
        self.intersect(ray).is_some_and(|chord| chord.first_hit_m(limit_m).is_some())
    }

    /// The two crossings of the ray's line, in order and with unit normals.
    ///
    /// The longest chord of a sphere is its diameter, in every direction:
    /// ```
    /// # use snowblue_geometry::{ellipsoid::Ellipsoid, ray::Ray};
    /// # use glam::{DAffine3, DVec3, Vec3A};
    /// let ball = Ellipsoid::new(DAffine3::from_scale(DVec3::splat(0.5))).unwrap();
    /// let ray = Ray::new(Vec3A::splat(3.0), Vec3A::NEG_ONE.normalize());
    /// let [enter, leave] = ball.crossings(&ray).unwrap();
    /// assert!((leave.distance_m - enter.distance_m - 1.0).abs() < 1e-6);
    /// ```
    pub fn crossings(&self, ray: &Ray) -> Option<[Crossing; 2]> {
        let chord = self.intersect(ray)?;
        let crossing = |distance_m: f64, is_entry: bool| {
            let normal = self.normal(chord.at(distance_m)).as_vec3a().normalize();
            Crossing::new(narrow(distance_m), normal, is_entry)
        };
        let [enter_m, leave_m] = chord.distances_m;
        Some([crossing(enter_m, true), crossing(leave_m, false)])
    }

    /// Texture coordinates of a point on the surface.
    pub fn texture_coordinates(&self, point: Vec3A) -> TextureCoordinates {
        TextureCoordinates::on_sphere(self.to_unit.transform_point3(point.as_dvec3()).as_vec3a())
    }

    /// The chord of the ray's line, if it crosses the ellipsoid.
    fn intersect(&self, ray: &Ray) -> Option<UnitSphereChord> {
        let origin = self.to_unit.transform_point3(ray.origin.as_dvec3() + ray.remainder.as_dvec3());
        let direction = self.to_unit.transform_vector3(ray.direction.as_dvec3());
        let per_m_squared = direction.length_squared();
        let nearest_m = -origin.dot(direction) / per_m_squared;
        let nearest = origin + nearest_m * direction;
        let discriminant = 1.0 - nearest.length_squared();
        (discriminant > 0.0).then(|| {
            let half_chord_m = (discriminant / per_m_squared).sqrt();
            UnitSphereChord { origin, direction, distances_m: [nearest_m - half_chord_m, nearest_m + half_chord_m] }
        })
    }

    /// The normal in scene space at a point of the unit sphere.
    fn normal(&self, unit_point: DVec3) -> DVec3 {
        self.to_unit.matrix3.transpose() * unit_point
    }
}

/// A line that crosses the unit sphere, in its coordinates, with distances along the ray in scene space.
struct UnitSphereChord {
    origin: DVec3,
    direction: DVec3,
    distances_m: [f64; 2],
}

impl UnitSphereChord {
    /// The first crossing beyond the origin and nearer than `limit_m`.
    fn first_hit_m(&self, limit_m: f32) -> Option<f64> {
        let first = self.distances_m.into_iter().find(|&distance_m| distance_m > 0.0);
        first.filter(|&distance_m| narrow(distance_m) < limit_m)
    }

    /// The point on the unit sphere at a crossing.
    fn at(&self, distance_m: f64) -> DVec3 {
        (self.origin + distance_m * self.direction).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn hits_lie_on_the_surface_and_normals_are_gradients() {
        let half = DVec3::new(0.5, 0.2, 0.8);
        let centre = DVec3::new(1.0, -2.0, 0.5);
        let turn = DQuat::from_rotation_z(0.6);
        let ball = Ellipsoid::new(DAffine3::from_scale_rotation_translation(half, turn, centre)).unwrap();
        for k in 0..200 {
            let angle = 0.1 * f64::from(k);
            let origin = centre + DVec3::new(3.0 * angle.cos(), 3.0 * angle.sin(), 0.02 * f64::from(k - 100));
            let target = centre + turn * DVec3::new(0.1, -0.05, 0.2);
            let ray = Ray::new(origin.as_vec3a(), (target - origin).normalize().as_vec3a().normalize());
            let hit = ball.first_hit(&ray, f32::INFINITY).unwrap();
            let local = turn.inverse() * (hit.point.as_dvec3() - centre);
            // (x/a)² + (y/b)² + (z/c)² = 1, with rounding errors of coordinates near 3 m and a semi-axis of 0.2 m.
            assert!(((local / half).length_squared() - 1.0).abs() < 1e-5);
            let gradient = (turn * (local / (half * half))).normalize();
            assert!(hit.normal.as_dvec3().dot(gradient) > 1.0 - 1e-6);
            assert!(hit.normal.dot(ray.direction) < 0.0);
            assert!(ball.occludes(&ray, hit.distance_m + 1e-4) && !ball.occludes(&ray, hit.distance_m - 1e-4));
        }
    }

    #[test]
    fn bounds_touch_the_surface_and_the_volume_scales() {
        let turn = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_4);
        let ball = Ellipsoid::new(DAffine3::from_scale_rotation_translation(DVec3::new(2.0, 1.0, 1.0), turn, DVec3::X));
        let ball = ball.unwrap();
        // √((2² + 1²) / 2) along x and y.
        let reach = 2.5f32.sqrt();
        assert!((ball.bounds().high - Vec3A::new(1.0 + reach, reach, 1.0)).length() < 1e-6);
        assert!((ball.volume_m3() - 8.0 / 3.0 * std::f64::consts::PI).abs() < 1e-12);
    }
}
