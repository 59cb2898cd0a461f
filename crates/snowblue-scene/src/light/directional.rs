//! Parallel light.

use glam::Vec3A;
use serde::{Deserialize, Serialize};
use snowblue_geometry::ray::narrow;

use crate::description::range::{DIRECTION, Range, unit_vector};
use crate::description::value::{numbers, point};
use crate::light::emitter::{Bounds, Emitter};
use crate::light::keys::LightKeys;
use crate::light::techniques::Light;
use crate::spectrum::Spectrum;
use crate::spectrum::light_spectrum::LightSpectrum;
use snowblue_base::{KeyError, KeyPath};

/// Parallel light.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DirectionalLightDescription {
    /// The direction in which it shines, of any length.
    #[serde(deserialize_with = "numbers")]
    pub direction: [f64; 3],
    /// Its irradiance on a plane that it meets at a right angle over 400–700 nm, in W/m².
    pub irradiance_w_m2: f64,
}

/// A distant light that shines in one direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DirectionalLight {
    /// Unit direction from the scene towards the light.
    pub(crate) to_light: Vec3A,
    /// Irradiance of a surface that faces it, in W/m².
    pub(crate) emission: Spectrum,
}

impl LightKeys for DirectionalLightDescription {
    fn light(&self, path: &KeyPath, spectrum: &LightSpectrum) -> Result<Light, KeyError> {
        let path_to_direction = path.key("direction");
        DIRECTION.check_all(&path_to_direction, &self.direction)?;
        Range::power("W/m²").check(&path.key("irradiance_w_m2"), self.irradiance_w_m2)?;
        let reason = "is [0, 0, 0], but must not be zero";
        let direction = unit_vector(&path_to_direction, point(self.direction), reason)?;
        let emission = spectrum.unit * narrow(self.irradiance_w_m2);
        Ok(Light::new(DirectionalLight { to_light: -direction, emission }))
    }
}

impl Emitter for DirectionalLight {
    fn name(&self) -> &'static str {
        "directional"
    }

    fn bounds(&self) -> Bounds {
        Bounds::Direction(self.to_light)
    }

    fn uniform(&self) -> Option<&Spectrum> {
        Some(&self.emission)
    }
}
