//! A point that shines into a cone.

use glam::Vec3A;
use serde::{Deserialize, Serialize};
use snowblue_geometry::ray::narrow;

use crate::description::range::{COORDINATE, Range, unit_vector};
use crate::description::value::{numbers, point};
use crate::light::emitter::{Bounds, Emitter};
use crate::light::keys::LightKeys;
use crate::light::sample::SpotCone;
use crate::light::techniques::Light;
use crate::spectrum::Spectrum;
use crate::spectrum::light_spectrum::LightSpectrum;
use snowblue_base::{KeyError, KeyPath};

/// A light that shines from a point into a cone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpotLightDescription {
    /// Its position, in m.
    #[serde(deserialize_with = "numbers")]
    pub position: [f64; 3],
    /// A point on the axis of the cone, in m.
    #[serde(deserialize_with = "numbers")]
    pub look_at: [f64; 3],
    /// Its radiant intensity in the middle of the cone over 400–700 nm, in W/sr.
    pub radiant_intensity_w_sr: f64,
    /// Angle from the axis within which it is brightest, in degrees.
    #[serde(default = "SpotLightDescription::default_inner_cone_deg")]
    pub inner_cone_deg: f64,
    /// Angle from the axis beyond which it is dark, in degrees.
    #[serde(default = "SpotLightDescription::default_outer_cone_deg")]
    pub outer_cone_deg: f64,
}

/// A spot.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SpotLight {
    /// Its position, in m.
    pub(crate) position: Vec3A,
    /// Where it shines.
    pub(crate) cone: SpotCone,
    /// Its radiant intensity along the axis, in W/sr.
    pub(crate) emission: Spectrum,
}

impl SpotLightDescription {
    fn default_inner_cone_deg() -> f64 {
        0.0
    }

    fn default_outer_cone_deg() -> f64 {
        45.0
    }
}

impl LightKeys for SpotLightDescription {
    fn light(&self, path: &KeyPath, spectrum: &LightSpectrum) -> Result<Light, KeyError> {
        const OUTER_CONE: Range = Range::new(0.1, 90.0, "deg");
        COORDINATE.check_all(&path.key("position"), &self.position)?;
        COORDINATE.check_all(&path.key("look_at"), &self.look_at)?;
        Range::power("W/sr").check(&path.key("radiant_intensity_w_sr"), self.radiant_intensity_w_sr)?;
        OUTER_CONE.check(&path.key("outer_cone_deg"), self.outer_cone_deg)?;
        Range::new(0.0, self.outer_cone_deg, "deg").check(&path.key("inner_cone_deg"), self.inner_cone_deg)?;
        let position = point(self.position);
        let axis = point(self.look_at) - position;
        let axis = unit_vector(&path.key("look_at"), axis, "must not be the light's position")?;
        let cone = SpotCone::new(axis, narrow(self.inner_cone_deg), narrow(self.outer_cone_deg));
        let emission = spectrum.unit * narrow(self.radiant_intensity_w_sr);
        Ok(Light::new(SpotLight { position, cone, emission }))
    }
}

impl Emitter for SpotLight {
    fn name(&self) -> &'static str {
        "spot"
    }

    fn bounds(&self) -> Bounds {
        Bounds::Point(self.position, Some(self.cone))
    }

    fn uniform(&self) -> Option<&Spectrum> {
        Some(&self.emission)
    }
}
