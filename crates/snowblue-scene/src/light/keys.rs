//! The common interface of the keys of all kinds of lights in a scene file.

use snowblue_base::{KeyError, KeyPath, ParameterRange, quantities};

use crate::light::techniques::Light;
use crate::spectrum::light_spectrum::LightSpectrum;

/// Greatest strength of a light, in any unit.
const MAX_STRENGTH: f64 = 1e12;

quantities! {
    /// A side or a radius of an area light.
    pub LightSize = ParameterRange::new("size", 1e-6, 1e5, "m");
    /// The radiance of an area light or a sky.
    pub Radiance = ParameterRange::new("radiance", 0.0, MAX_STRENGTH, "W/(m² sr)");
    /// The radiant intensity of a point.
    pub RadiantIntensity = ParameterRange::new("radiant intensity", 0.0, MAX_STRENGTH, "W/sr");
    /// The irradiance of a surface.
    pub Irradiance = ParameterRange::new("irradiance", 0.0, MAX_STRENGTH, "W/m²");
    /// A factor of the light of a sky.
    pub SkyScale = ParameterRange::new("scale", 1e-9, 1e9, "");
    /// A channel of a pixel of a sky.
    pub PixelValue = ParameterRange::new("value", 1e-9, MAX_STRENGTH, "");
}

/// The keys of one kind of light, without the keys of its spectrum.
pub(crate) trait LightKeys {
    /// The light with a spectrum.
    ///
    /// # Errors
    ///
    /// When values do not fit together.
    fn light(&self, path: &KeyPath, spectrum: &LightSpectrum) -> Result<Light, KeyError>;

    /// Whether the camera may see the light as a lamp. Such a light must have an extent.
    fn is_visible_emitter(&self) -> bool {
        false
    }
}
