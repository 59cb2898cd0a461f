//! A sky that is the same in all directions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::light::emitter::{Emitter, LightType};
use crate::light::keys::{LightKeys, Radiance};
use crate::light::techniques::Light;
use crate::spectrum::Spectrum;
use crate::spectrum::light_spectrum::LightSpectrum;
use crate::values::visible;
use snowblue_base::{KeyError, KeyPath, Number, narrow};

/// The strength of a uniform sky.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SkyGlow {
    /// Its radiance over 400–700 nm, in W/(m² sr).
    pub radiance_w_m2_sr: Number<Radiance>,
    /// Whether it is visible to the camera.
    #[serde(default = "visible")]
    pub visible: bool,
}

/// A sky of the same radiance in W m⁻² sr⁻¹ in all directions.
#[derive(Debug, Clone, Copy)]
struct UniformSky(Spectrum);

impl LightKeys for SkyGlow {
    fn light(&self, _: &KeyPath, spectrum: &LightSpectrum) -> Result<Light, KeyError> {
        let emission = spectrum.unit * narrow(self.radiance_w_m2_sr.get());
        Ok(Light::new(UniformSky(emission)).with_visibility(self.visible))
    }
}

impl Emitter for UniformSky {
    fn name(&self) -> &'static str {
        "sky"
    }

    fn light_type(&self) -> LightType {
        LightType::UniformInfinite
    }

    fn uniform(&self) -> Option<&Spectrum> {
        Some(&self.0)
    }
}
