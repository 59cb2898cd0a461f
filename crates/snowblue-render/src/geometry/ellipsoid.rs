//! Spheres, exact, and what a stretch makes of them: the unit sphere under an affine map.
//!
//! In the sphere's own coordinates a line o + t·d has its foot at t₀ = −o·d / d², f = o + t₀ d from the centre, and
//! goes through the sphere at t₀ ± √((1 − f²) / d²). The foot keeps the small number 1 − f² free from the great
//! distance of o (Haines, Günther & Akenine-Möller 2019, "Precision improvements for ray/sphere intersection", Ray
//! Tracing Gems, chapter 7, doi:10.1007/978-1-4842-4427-2_7). All of it is double precision.

use glam::{DAffine3, DVec3, Vec3A};

use crate::geometry::bounds::Bounds;
use crate::geometry::ray::{Crossing, Ray, ShapeHit, narrow};
use crate::geometry::texture_coordinates::TextureCoordinates;

/// A solid sphere or ellipsoid.
#[derive(Debug, Clone, Copy)]
pub struct Ellipsoid {
    to_scene: DAffine3,
    to_unit: DAffine3,
}

impl Ellipsoid {
    /// What a map into the scene, in m, makes of the unit sphere about the origin; none for a map that flattens it.
    pub fn new(to_scene: DAffine3) -> Option<Self> {
        let to_unit = to_scene.inverse();
        (to_scene.is_finite() && to_unit.is_finite()).then_some(Self { to_scene, to_unit })
    }

    /// The axis-parallel box around it.
    pub fn bounds(&self) -> Bounds {
        // The support function of the image of the unit sphere: the length of a row of the matrix.
        let rows = self.to_scene.matrix3.transpose();
        let reach = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        let centre = self.to_scene.translation;
        Bounds { low: (centre - reach).as_vec3a(), high: (centre + reach).as_vec3a() }
    }

    /// Volume in m³.
    pub fn volume_m3(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.to_scene.matrix3.determinant().abs()
    }

    /// The first hit beyond the ray's origin and nearer than `limit_m`.
    pub fn first_hit(&self, ray: &Ray, limit_m: f32) -> Option<ShapeHit> {
        let line = self.line(ray)?;
        let distance_m = line.ahead_m(limit_m)?;
        let own = line.at(distance_m);
        let point = self.to_scene.transform_point3(own).as_vec3a();
        Some(ShapeHit::plain(narrow(distance_m), point, self.normal(own).as_vec3a().normalize()))
    }

    /// Whether its surface lies beyond the ray's origin and nearer than `limit_m`.
    pub fn occludes(&self, ray: &Ray, limit_m: f32) -> bool {
        self.line(ray).is_some_and(|line| line.ahead_m(limit_m).is_some())
    }

    /// The two crossings of the whole line of the ray, in its order and with unit normals, if it meets the sphere.
    ///
    /// The longest line in a ball is its diameter, from every direction:
    /// ```
    /// # use snowblue_render::{ellipsoid::Ellipsoid, ray::Ray};
    /// # use glam::{DAffine3, DVec3, Vec3A};
    /// let ball = Ellipsoid::new(DAffine3::from_scale(DVec3::splat(0.5))).unwrap();
    /// let ray = Ray { origin: Vec3A::splat(3.0), direction: Vec3A::NEG_ONE.normalize() };
    /// let [enter, leave] = ball.crossings(&ray).unwrap();
    /// assert!((leave.distance_m - enter.distance_m - 1.0).abs() < 1e-6);
    /// ```
    pub fn crossings(&self, ray: &Ray) -> Option<[Crossing; 2]> {
        let line = self.line(ray)?;
        let crossing =
            |distance_m| Crossing::new(narrow(distance_m), self.normal(line.at(distance_m)).as_vec3a().normalize());
        Some(line.distances_m.map(crossing))
    }

    /// The place for textures of a point on it.
    pub(crate) fn texture_place(&self, point: Vec3A) -> TextureCoordinates {
        TextureCoordinates::on_sphere(self.to_unit.transform_point3(point.as_dvec3()).as_vec3a())
    }

    fn line(&self, ray: &Ray) -> Option<UnitLine> {
        let origin = self.to_unit.transform_point3(ray.origin.as_dvec3());
        let direction = self.to_unit.transform_vector3(ray.direction.as_dvec3());
        let per_m_squared = direction.length_squared();
        let middle_m = -origin.dot(direction) / per_m_squared;
        let foot = origin + middle_m * direction;
        let within = 1.0 - foot.length_squared();
        (within > 0.0).then(|| {
            let reach_m = (within / per_m_squared).sqrt();
            UnitLine { origin, direction, distances_m: [middle_m - reach_m, middle_m + reach_m] }
        })
    }

    fn normal(&self, own: DVec3) -> DVec3 {
        self.to_unit.matrix3.transpose() * own
    }
}

/// A line in the coordinates of the unit sphere that goes through it at two distances along the ray of the scene.
struct UnitLine {
    origin: DVec3,
    direction: DVec3,
    distances_m: [f64; 2],
}

impl UnitLine {
    /// Where it meets the sphere first, beyond its origin and nearer than `limit_m`.
    fn ahead_m(&self, limit_m: f32) -> Option<f64> {
        let ahead = self.distances_m.into_iter().find(|&distance_m| distance_m > 0.0);
        ahead.filter(|&distance_m| narrow(distance_m) < limit_m)
    }

    /// The point of the sphere's surface there.
    fn at(&self, distance_m: f64) -> DVec3 {
        (self.origin + distance_m * self.direction).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn a_stretched_ball_is_hit_on_its_surface_with_its_gradient_as_normal() {
        let half = DVec3::new(0.5, 0.2, 0.8);
        let centre = DVec3::new(1.0, -2.0, 0.5);
        let turn = DQuat::from_rotation_z(0.6);
        let ball = Ellipsoid::new(DAffine3::from_scale_rotation_translation(half, turn, centre)).unwrap();
        for k in 0..200 {
            let angle = 0.1 * f64::from(k);
            let eye = centre + DVec3::new(3.0 * angle.cos(), 3.0 * angle.sin(), 0.02 * f64::from(k - 100));
            let aim = centre + turn * DVec3::new(0.1, -0.05, 0.2);
            let ray = Ray { origin: eye.as_vec3a(), direction: (aim - eye).normalize().as_vec3a().normalize() };
            let hit = ball.first_hit(&ray, f32::INFINITY).unwrap();
            let own = turn.inverse() * (hit.point.as_dvec3() - centre);
            // (x/a)² + (y/b)² + (z/c)² = 1; single precision of coordinates near 3 m, against half an axis of 0.2 m.
            assert!(((own / half).length_squared() - 1.0).abs() < 1e-5);
            let gradient = (turn * (own / (half * half))).normalize();
            assert!(hit.normal.as_dvec3().dot(gradient) > 1.0 - 1e-6);
            assert!(hit.normal.dot(ray.direction) < 0.0);
            assert!(ball.occludes(&ray, hit.distance_m + 1e-4) && !ball.occludes(&ray, hit.distance_m - 1e-4));
        }
    }

    #[test]
    fn bounds_touch_the_surface_and_the_volume_is_that_of_the_stretch() {
        let turn = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_4);
        let ball = Ellipsoid::new(DAffine3::from_scale_rotation_translation(DVec3::new(2.0, 1.0, 1.0), turn, DVec3::X));
        let ball = ball.unwrap();
        // √((2² + 1²) / 2) along x and y.
        let reach = 2.5f32.sqrt();
        assert!((ball.bounds().high - Vec3A::new(1.0 + reach, reach, 1.0)).length() < 1e-6);
        assert!((ball.volume_m3() - 8.0 / 3.0 * std::f64::consts::PI).abs() < 1e-12);
    }
}
