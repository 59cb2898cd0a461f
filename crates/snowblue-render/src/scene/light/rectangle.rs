//! A rectangular area light, sampled by the solid angle that it subtends.
//!
//! Ureña, Fajardo & King (2013), "An area-preserving parametrization for spherical rectangles", Computer Graphics Forum
//! 32(4), 59–66, doi:10.1111/cgf.12151: the first number cuts off a fraction of the solid angle Ω, which gives the
//! horizontal coordinate; the second is linear in the height on the sphere along that cut. p(ω) = 1/Ω. It uses double
//! precision because Ω is a small difference of angles. From so far away that even this fails, points are uniform over
//! the area.

use std::f64::consts::PI;

use glam::{DVec3, Vec3A};
use snowblue_geometry::ray::{Ray, narrow};

use super::EmitterPoint;

/// Solid angle below which points are uniform over the area, in sr. The sum of angles has an error of some 1e-15.
const LEAST_SOLID_ANGLE_SR: f64 = 1e-10;

/// A rectangle that emits from one side with the same radiance in all directions.
#[derive(Debug, Clone, Copy)]
pub struct RectangleLight {
    centre: Vec3A,
    across: Vec3A,
    up: Vec3A,
    normal: Vec3A,
    half_width_m: f32,
    half_height_m: f32,
}

/// Position and size of a rectangle.
#[derive(Debug, Clone, Copy)]
pub struct RectanglePlace {
    /// Centre in m.
    pub centre: Vec3A,
    /// A point that it faces, in m.
    pub look_at: Vec3A,
    /// Direction of its height, of any length; made perpendicular to the facing direction.
    pub up: Vec3A,
    /// Width in m.
    pub width_m: f32,
    /// Height in m.
    pub height_m: f32,
}

/// A rectangle as seen from a point, in axes along its sides and its normal. Its plane has a negative `z`.
struct View {
    axes: [DVec3; 3],
    origin: DVec3,
    low: [f64; 2],
    high: [f64; 2],
    z: f64,
    solid_angle_sr: f64,
    /// z-components of the unit normals of the planes through the viewer and the lower and the upper edge.
    edges: [f64; 2],
    /// 2π less the angles at the left corners.
    corners: f64,
}

impl RectangleLight {
    /// A rectangle that faces `look_at`; none if that is its centre or lies in the direction of `up`.
    pub fn new(place: &RectanglePlace) -> Option<Self> {
        let normal = (place.look_at - place.centre).try_normalize()?;
        let across = normal.cross(place.up.try_normalize()?);
        let across = (across.length() > 1e-6).then(|| across.normalize())?;
        Some(Self {
            centre: place.centre,
            across,
            up: across.cross(normal),
            normal,
            half_width_m: 0.5 * place.width_m,
            half_height_m: 0.5 * place.height_m,
        })
    }

    /// Area in m².
    pub(super) fn area_m2(&self) -> f32 {
        4.0 * self.half_width_m * self.half_height_m
    }

    /// Centre in m.
    pub(super) fn centre(&self) -> Vec3A {
        self.centre
    }

    /// A point on it, uniform in the direction from `from`; none from behind.
    pub(super) fn sample(&self, from: Vec3A, [u, v]: [f32; 2]) -> Option<EmitterPoint> {
        let position = match self.view(from) {
            Some(view) if view.solid_angle_sr > LEAST_SOLID_ANGLE_SR => view.sample(f64::from(u), f64::from(v)),
            Some(_) => {
                self.centre
                    + self.across * (self.half_width_m * (2.0 * u - 1.0))
                    + self.up * (self.half_height_m * (2.0 * v - 1.0))
            }
            None => return None,
        };
        Some(EmitterPoint { position, normal: self.normal })
    }

    /// Density of [`sample`](Self::sample), in 1/sr; `area_m2_sr` is the area per solid angle at the sampled point.
    pub(super) fn density_per_sr(&self, from: Vec3A, area_m2_sr: f32) -> f32 {
        match self.view(from) {
            Some(view) if view.solid_angle_sr > LEAST_SOLID_ANGLE_SR => narrow(view.solid_angle_sr.recip()),
            Some(_) => area_m2_sr / self.area_m2(),
            None => 0.0,
        }
    }

    /// Where a ray hits its emitting side, before `limit_m`.
    pub(super) fn hit(&self, ray: &Ray, limit_m: f32) -> Option<EmitterPoint> {
        let approach = -self.normal.dot(ray.direction);
        let distance_m = self.normal.dot(ray.origin - self.centre) / approach;
        let position = ray.at(distance_m);
        let aside = position - self.centre;
        let inside =
            aside.dot(self.across).abs() <= self.half_width_m && aside.dot(self.up).abs() <= self.half_height_m;
        (approach > 0.0 && distance_m > 0.0 && distance_m < limit_m && inside)
            .then_some(EmitterPoint { position, normal: self.normal })
    }

    fn view(&self, from: Vec3A) -> Option<View> {
        let axes = [self.across, self.up, self.normal].map(Vec3A::as_dvec3);
        let origin = from.as_dvec3();
        let [x, y, z] = axes.map(|axis| axis.dot(self.centre.as_dvec3() - origin));
        // The viewer is behind it.
        if z >= 0.0 {
            return None;
        }
        let (half_width, half_height) = (f64::from(self.half_width_m), f64::from(self.half_height_m));
        let (x0, x1, y0, y1) = (x - half_width, x + half_width, y - half_height, y + half_height);
        // Of the normals of the planes of adjacent edges one has no x- and the other no y-component, so the angles
        // between them follow from the z-components.
        let edge = |offset: f64| -offset / z.hypot(offset);
        let (bottom, right, top, left) = (edge(y0), edge(x1), edge(y1), edge(x0));
        let corner = |a: f64, b: f64| (-a * b).clamp(-1.0, 1.0).acos();
        let angles = [corner(bottom, -right), corner(-right, -top), corner(-top, left), corner(left, bottom)];
        Some(View {
            axes,
            origin,
            low: [x0, y0],
            high: [x1, y1],
            z,
            solid_angle_sr: angles[0] + angles[1] - (2.0 * PI - angles[2] - angles[3]),
            edges: [bottom, -top],
            corners: 2.0 * PI - angles[2] - angles[3],
        })
    }
}

impl View {
    /// The point of the rectangle for two numbers in [0, 1).
    fn sample(&self, u: f64, v: f64) -> Vec3A {
        let [bottom, top] = self.edges;
        // The cut that leaves a fraction u of the solid angle on its left.
        let turn = u * self.solid_angle_sr + self.corners;
        let slope = (turn.cos() * bottom - top) / turn.sin();
        let cut = (1.0 / slope.hypot(bottom)).copysign(slope).clamp(-1.0, 1.0);
        let x = (-cut * self.z / (1.0 - cut * cut).max(1e-30).sqrt()).clamp(self.low[0], self.high[0]);
        let distance = x.hypot(self.z);
        let height = |y: f64| y / distance.hypot(y);
        let (low, high) = (height(self.low[1]), height(self.high[1]));
        let at = low + v * (high - low);
        let y = if at * at < 1.0 - 1e-12 { at * distance / (1.0 - at * at).sqrt() } else { self.high[1] };
        let y = y.clamp(self.low[1], self.high[1]);
        (self.origin + self.axes[0] * x + self.axes[1] * y + self.axes[2] * self.z).as_vec3a()
    }
}
