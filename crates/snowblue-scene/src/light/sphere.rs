//! A spherical area light, sampled by the cone of directions that it subtends.
//!
//! At a distance d from its centre, a sphere of radius R subtends a cone of half-angle α, with sin α = R/d.
//! Directions in the cone are uniform: p(ω) = 1 / (2π (1 − cos α)). The point on the sphere follows without a
//! difference of large numbers. With the angle θ at the viewer, the angle β of the point at the centre is given by
//! cos β = sin²θ / sin α + cos θ √(1 − sin²θ / sin²α) (Pharr, Jakob & Humphreys 2023, section 6.2.4).

use std::f32::consts::TAU;

use glam::Vec3A;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_geometry::ray::Ray;

use crate::light::emitter::{Emitter, InnerLamp, LightType};
use crate::light::keys::{LightKeys, LightSize, Radiance};
use crate::light::sample::{EmitterPoint, LightOrigin};
use crate::light::techniques::Light;
use crate::spectrum::Spectrum;
use crate::spectrum::light_spectrum::LightSpectrum;
use crate::values::{Coordinate, point, visible};
use snowblue_base::{KeyError, KeyPath, Number, Numbers, narrow};

/// A sphere that emits uniformly.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereLightDescription {
    /// Its centre, in m.
    pub position: Numbers<Coordinate, 3>,
    /// Its radius, in m.
    pub radius: Number<LightSize>,
    /// Its radiance over 400–700 nm, in W/(m² sr).
    pub radiance_w_m2_sr: Number<Radiance>,
    /// Whether it is visible to the camera.
    #[serde(default = "visible")]
    pub visible: bool,
}

/// A sphere that emits outwards with the same radiance in all directions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SphereLight {
    /// Its centre, in m.
    pub(crate) centre: Vec3A,
    /// Its radius, in m.
    pub(crate) radius_m: f32,
    /// Its radiance, in W m⁻² sr⁻¹.
    pub(crate) emission: Spectrum,
}

/// The cone of directions towards a sphere, of half-angle α.
struct SubtendedCone {
    /// sin² α.
    sin_squared: f32,
    /// 1 − cos α.
    one_minus_cos: f32,
}

impl LightKeys for SphereLightDescription {
    fn light(&self, _: &KeyPath, spectrum: &LightSpectrum) -> Result<Light, KeyError> {
        let emission = spectrum.unit * narrow(self.radiance_w_m2_sr.get());
        let light = SphereLight { centre: point(self.position), radius_m: narrow(self.radius.get()), emission };
        Ok(Light::new(light).with_visibility(self.visible))
    }

    fn is_visible_emitter(&self) -> bool {
        self.visible
    }
}

impl SphereLight {
    /// The cone that the sphere subtends at a point; none from inside.
    fn cone(&self, point: Vec3A) -> Option<SubtendedCone> {
        let sin_squared = self.radius_m * self.radius_m / point.distance_squared(self.centre);
        let one_minus_cos = sin_squared / (1.0 + (1.0 - sin_squared).sqrt());
        (sin_squared < 1.0).then_some(SubtendedCone { sin_squared, one_minus_cos })
    }
}

impl Emitter for SphereLight {
    fn name(&self) -> &'static str {
        "sphere"
    }

    fn light_type(&self) -> LightType {
        LightType::Area { centre: self.centre, spread_m2: self.radius_m * self.radius_m }
    }

    fn uniform(&self) -> Option<&Spectrum> {
        Some(&self.emission)
    }

    /// A visible point of the sphere, uniform in the direction from `from`.
    fn sample_li(&self, from: Vec3A, [u, v]: [f32; 2]) -> Option<LightOrigin> {
        let SubtendedCone { sin_squared: max_sin_squared, one_minus_cos } = self.cone(from)?;
        let below_one = u * one_minus_cos;
        let sin_squared = below_one * (2.0 - below_one);
        let cos_centre = sin_squared / max_sin_squared.sqrt()
            + (1.0 - below_one) * (1.0 - sin_squared / max_sin_squared).max(0.0).sqrt();
        let towards = (from - self.centre).normalize();
        let (side, ahead) = towards.any_orthonormal_pair();
        let (sin_turn, cos_turn) = (TAU * v).sin_cos();
        let sin_centre = (1.0 - cos_centre * cos_centre).max(0.0).sqrt();
        let normal =
            (side * (sin_centre * cos_turn) + ahead * (sin_centre * sin_turn) + towards * cos_centre).normalize();
        Some(LightOrigin::Emitter(EmitterPoint { position: self.centre + normal * self.radius_m, normal }))
    }

    fn pdf_li(&self, from: Vec3A, _origin: &LightOrigin) -> f32 {
        self.cone(from).map_or(0.0, |cone| (TAU * cone.one_minus_cos).recip())
    }

    /// Rays hit the sphere only from outside.
    fn hit(&self, ray: &Ray, limit_m: f32) -> Option<LightOrigin> {
        let way = self.centre - ray.origin;
        let along = way.dot(ray.direction);
        let aside_squared = (way - ray.direction * along).length_squared();
        let half_squared = self.radius_m * self.radius_m - aside_squared;
        let distance_m = along - half_squared.max(0.0).sqrt();
        (half_squared > 0.0 && distance_m > 0.0 && distance_m < limit_m).then(|| {
            let normal = (ray.at(distance_m) - self.centre).normalize();
            LightOrigin::Emitter(EmitterPoint { position: self.centre + normal * self.radius_m, normal })
        })
    }

    fn inner_lamp(&self) -> Option<InnerLamp> {
        Some(InnerLamp::sphere(self.centre, self.radius_m, self.emission))
    }
}
