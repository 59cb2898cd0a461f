//! A rectangular area light, sampled by the solid angle that it subtends.
//!
//! Sampling follows Ureña, Fajardo & King (2013), "An area-preserving parametrization for spherical rectangles",
//! Computer Graphics Forum 32(4), 59–66, doi:10.1111/cgf.12151. The first number cuts off a fraction of the solid
//! angle Ω, which gives the horizontal coordinate. The second number is linear in the height on the sphere along this
//! cut. The density is p(ω) = 1/Ω. The code uses double precision because Ω is a small difference of angles. If Ω is
//! too small even for double precision, points are uniform over the area.

use std::f32::consts::FRAC_1_PI;
use std::f64::consts::PI;

use glam::{DVec3, Vec3A};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_geometry::ray::Ray;

use crate::light::emitter::{Emitter, LightType};
use crate::light::keys::{LightKeys, LightSize, Radiance};
use crate::light::sample::{EmitterPoint, LightOrigin};
use crate::light::techniques::Light;
use crate::spectrum::Spectrum;
use crate::spectrum::light_spectrum::LightSpectrum;
use crate::values::{Coordinate, Direction, point, upwards, visible};
use snowblue_base::{KeyError, KeyPath, Number, Numbers, narrow};

/// Solid angle below which points are uniform over the area, in sr. The sum of angles has an error of some 1e-15.
const MIN_SOLID_ANGLE_SR: f64 = 1e-10;

/// A rectangle that emits from one side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RectangleLightDescription {
    /// Its centre, in m.
    pub position: Numbers<Coordinate, 3>,
    /// A point that it faces, in m.
    pub look_at: Numbers<Coordinate, 3>,
    /// The direction of its height, made perpendicular to the direction that it faces; of any length.
    #[serde(default = "upwards")]
    pub up: Numbers<Direction, 3>,
    /// Width and height, in m.
    pub size: Numbers<LightSize, 2>,
    /// Its radiance over 400–700 nm, in W/(m² sr).
    pub radiance_w_m2_sr: Number<Radiance>,
    /// Whether it is visible to the camera.
    #[serde(default = "visible")]
    pub visible: bool,
}

/// A rectangle that emits from one side with the same radiance in all directions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RectangleLight {
    centre: Vec3A,
    across: Vec3A,
    up: Vec3A,
    normal: Vec3A,
    half_width_m: f32,
    half_height_m: f32,
    /// Radiance in W m⁻² sr⁻¹.
    emission: Spectrum,
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
    /// 2π minus the angles at the left corners.
    corners: f64,
}

impl LightKeys for RectangleLightDescription {
    fn light(&self, path: &KeyPath, spectrum: &LightSpectrum) -> Result<Light, KeyError> {
        let light = RectangleLight::new(self, spectrum);
        let light = light
            .ok_or_else(|| path.key("look_at").error("must not lie at the light's position or along its up axis"))?;
        Ok(Light::new(light).with_visibility(self.visible))
    }

    fn is_visible_emitter(&self) -> bool {
        self.visible
    }
}

impl RectangleLight {
    /// The light with such keys; none if the light faces its own centre or the direction of `up`.
    pub(super) fn new(keys: &RectangleLightDescription, spectrum: &LightSpectrum) -> Option<Self> {
        let (centre, look_at, up) = (point(keys.position), point(keys.look_at), point(keys.up));
        let [width_m, height_m] = keys.size.get().map(narrow);
        let normal = (look_at - centre).try_normalize()?;
        let across = normal.cross(up.try_normalize()?);
        let across = (across.length() > 1e-6).then(|| across.normalize())?;
        Some(Self {
            centre,
            across,
            up: across.cross(normal),
            normal,
            half_width_m: 0.5 * width_m,
            half_height_m: 0.5 * height_m,
            emission: spectrum.unit * narrow(keys.radiance_w_m2_sr.get()),
        })
    }

    fn area_m2(&self) -> f32 {
        4.0 * self.half_width_m * self.half_height_m
    }

    fn view(&self, from: Vec3A) -> Option<View> {
        let axes = [self.across, self.up, self.normal].map(Vec3A::as_dvec3);
        let origin = from.as_dvec3();
        let [x, y, z] = axes.map(|axis| axis.dot(self.centre.as_dvec3() - origin));
        // The viewer is behind the rectangle.
        if z >= 0.0 {
            return None;
        }
        let (half_width, half_height) = (f64::from(self.half_width_m), f64::from(self.half_height_m));
        let (x0, x1, y0, y1) = (x - half_width, x + half_width, y - half_height, y + half_height);
        // Among the normals of the planes of adjacent edges, one normal has no x-component and the next normal has no
        // y-component. Therefore the angles between them follow from the z-components.
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

impl Emitter for RectangleLight {
    fn name(&self) -> &'static str {
        "rectangle"
    }

    fn light_type(&self) -> LightType {
        LightType::Area { centre: self.centre, spread_m2: self.area_m2() * FRAC_1_PI }
    }

    fn points_before(&self, distance_m: f32) -> Vec<Vec3A> {
        const PLACES: [f32; 3] = [-0.98, 0.0, 0.98];
        let [across, up] = [self.across * self.half_width_m, self.up * self.half_height_m];
        let middle = self.centre + self.normal * distance_m;
        PLACES.iter().flat_map(|u| PLACES.map(|v| middle + across * *u + up * v)).collect()
    }

    fn uniform(&self) -> Option<&Spectrum> {
        Some(&self.emission)
    }

    /// A point on the rectangle, uniform in the direction from `from`; none from behind.
    fn sample_li(&self, from: Vec3A, [u, v]: [f32; 2]) -> Option<LightOrigin> {
        let position = match self.view(from) {
            Some(view) if view.solid_angle_sr > MIN_SOLID_ANGLE_SR => view.sample(f64::from(u), f64::from(v)),
            Some(_) => {
                self.centre
                    + self.across * (self.half_width_m * (2.0 * u - 1.0))
                    + self.up * (self.half_height_m * (2.0 * v - 1.0))
            }
            None => return None,
        };
        Some(LightOrigin::Emitter(EmitterPoint { position, normal: self.normal }))
    }

    fn pdf_li(&self, from: Vec3A, origin: &LightOrigin) -> f32 {
        match self.view(from) {
            Some(view) if view.solid_angle_sr > MIN_SOLID_ANGLE_SR => narrow(view.solid_angle_sr.recip()),
            Some(_) => origin.area_per_solid_angle(from) / self.area_m2(),
            None => 0.0,
        }
    }

    fn hit(&self, ray: &Ray, limit_m: f32) -> Option<LightOrigin> {
        let approach = -self.normal.dot(ray.direction);
        let distance_m = self.normal.dot(ray.origin - self.centre) / approach;
        let position = ray.at(distance_m);
        let aside = position - self.centre;
        let inside =
            aside.dot(self.across).abs() <= self.half_width_m && aside.dot(self.up).abs() <= self.half_height_m;
        (approach > 0.0 && distance_m > 0.0 && distance_m < limit_m && inside)
            .then_some(LightOrigin::Emitter(EmitterPoint { position, normal: self.normal }))
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
