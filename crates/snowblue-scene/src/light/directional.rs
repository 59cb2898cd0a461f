//! Parallel light.

use glam::Vec3A;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::light::emitter::{Emitter, LightType};
use crate::light::keys::{Irradiance, LightKeys};
use crate::light::techniques::Light;
use crate::spectrum::Spectrum;
use crate::spectrum::light_spectrum::LightSpectrum;
use crate::values::{Direction, point, unit_vector};
use snowblue_base::{KeyError, KeyPath, Number, Numbers, narrow};

/// Parallel light.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DirectionalLightDescription {
    /// The direction in which it shines, of any length.
    pub direction: Numbers<Direction, 3>,
    /// Its irradiance on a plane that it meets at a right angle over 400–700 nm, in W/m².
    pub irradiance_w_m2: Number<Irradiance>,
}

/// A distant light that shines in one direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DirectionalLight {
    /// Unit direction from the scene towards the light.
    pub(crate) to_light: Vec3A,
    /// Irradiance of a surface that faces the light, in W/m².
    pub(crate) emission: Spectrum,
}

impl LightKeys for DirectionalLightDescription {
    fn light(&self, path: &KeyPath, spectrum: &LightSpectrum) -> Result<Light, KeyError> {
        let reason = "is [0, 0, 0], but must not be zero";
        let direction = unit_vector(&path.key("direction"), point(self.direction), reason)?;
        let emission = spectrum.unit * narrow(self.irradiance_w_m2.get());
        Ok(Light::new(DirectionalLight { to_light: -direction, emission }))
    }
}

impl Emitter for DirectionalLight {
    fn name(&self) -> &'static str {
        "directional"
    }

    fn light_type(&self) -> LightType {
        LightType::DeltaDirection(self.to_light)
    }

    fn uniform(&self) -> Option<&Spectrum> {
        Some(&self.emission)
    }
}
