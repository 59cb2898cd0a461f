//! A point that shines into a cone.

use glam::Vec3A;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::light::emitter::{Emitter, LightType};
use crate::light::keys::{LightKeys, RadiantIntensity};
use crate::light::sample::SpotCone;
use crate::light::techniques::Light;
use crate::spectrum::Spectrum;
use crate::spectrum::light_spectrum::LightSpectrum;
use crate::values::{Coordinate, point, unit_vector};
use snowblue_base::{KeyError, KeyPath, Number, Numbers, ParameterRange, narrow, quantities};

quantities! {
    /// The angle between the axis of a cone and its edge.
    pub OuterCone = ParameterRange::new("outer cone", 0.1, 90.0, "°");
    /// The angle between the axis of a cone and the edge of its brightest part.
    pub InnerCone = ParameterRange::new("inner cone", 0.0, 90.0, "°");
}

/// A light that shines from a point into a cone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpotLightDescription {
    /// Its position, in m.
    pub position: Numbers<Coordinate, 3>,
    /// A point on the axis of the cone, in m.
    pub look_at: Numbers<Coordinate, 3>,
    /// Its radiant intensity in the middle of the cone over 400–700 nm, in W/sr.
    pub radiant_intensity_w_sr: Number<RadiantIntensity>,
    /// Angle from the axis within which it is brightest, in degrees.
    #[serde(default)]
    pub inner_cone_deg: Number<InnerCone>,
    /// Angle from the axis beyond which it is dark, in degrees.
    #[serde(default = "SpotLightDescription::default_outer_cone_deg")]
    pub outer_cone_deg: Number<OuterCone>,
}

/// A spot light.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpotLight {
    /// Its position, in m.
    pub(crate) position: Vec3A,
    /// The cone in which the light shines.
    pub(crate) cone: SpotCone,
    /// Its radiant intensity along the axis, in W/sr.
    pub(crate) emission: Spectrum,
}

impl SpotLightDescription {
    fn default_outer_cone_deg() -> Number<OuterCone> {
        Number::of(45.0)
    }
}

impl LightKeys for SpotLightDescription {
    fn light(&self, path: &KeyPath, spectrum: &LightSpectrum) -> Result<Light, KeyError> {
        let [inner_deg, outer_deg] = [self.inner_cone_deg.get(), self.outer_cone_deg.get()];
        if inner_deg > outer_deg {
            let reason = format!("is {inner_deg}°, but must be at most the outer_cone_deg of {outer_deg}°");
            return Err(path.key("inner_cone_deg").error(reason));
        }
        let position = point(self.position);
        let axis = point(self.look_at) - position;
        let axis = unit_vector(&path.key("look_at"), axis, "must not be the light's position")?;
        let cone = SpotCone::new(axis, narrow(inner_deg), narrow(outer_deg));
        let emission = spectrum.unit * narrow(self.radiant_intensity_w_sr.get());
        Ok(Light::new(SpotLight { position, cone, emission }))
    }
}

impl Emitter for SpotLight {
    fn name(&self) -> &'static str {
        "spot"
    }

    fn light_type(&self) -> LightType {
        LightType::DeltaPosition(self.position, Some(self.cone))
    }

    fn uniform(&self) -> Option<&Spectrum> {
        Some(&self.emission)
    }
}
