//! A point that shines in all directions alike.

use glam::Vec3A;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::light::emitter::{Emitter, InnerLamp, LightType};
use crate::light::keys::{LightKeys, RadiantIntensity};
use crate::light::techniques::Light;
use crate::spectrum::Spectrum;
use crate::spectrum::light_spectrum::LightSpectrum;
use crate::values::{Coordinate, point};
use snowblue_base::{KeyError, KeyPath, Number, Numbers, narrow};

/// A light that shines from a point in all directions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointLightDescription {
    /// Its position, in m.
    pub position: Numbers<Coordinate, 3>,
    /// Its radiant intensity over 400–700 nm, in W/sr.
    pub radiant_intensity_w_sr: Number<RadiantIntensity>,
}

/// A point light.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PointLight {
    /// Its position, in m.
    pub(crate) position: Vec3A,
    /// Its radiant intensity, in W/sr.
    pub(crate) emission: Spectrum,
}

impl LightKeys for PointLightDescription {
    fn light(&self, _: &KeyPath, spectrum: &LightSpectrum) -> Result<Light, KeyError> {
        let emission = spectrum.unit * narrow(self.radiant_intensity_w_sr.get());
        Ok(Light::new(PointLight { position: point(self.position), emission }))
    }
}

impl Emitter for PointLight {
    fn name(&self) -> &'static str {
        "point"
    }

    fn light_type(&self) -> LightType {
        LightType::DeltaPosition(self.position, None)
    }

    fn uniform(&self) -> Option<&Spectrum> {
        Some(&self.emission)
    }

    fn inner_lamp(&self) -> Option<InnerLamp> {
        Some(InnerLamp { position: self.position, radius_m: 0.0, intensity: self.emission })
    }
}
