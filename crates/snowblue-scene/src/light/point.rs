//! A point that shines in all directions alike.

use glam::Vec3A;
use serde::{Deserialize, Serialize};
use snowblue_geometry::ray::narrow;

use crate::description::range::{COORDINATE, Range};
use crate::description::value::{numbers, point};
use crate::light::emitter::{Bounds, Emitter, InnerLamp};
use crate::light::keys::LightKeys;
use crate::light::techniques::Light;
use crate::spectrum::Spectrum;
use crate::spectrum::light_spectrum::LightSpectrum;
use snowblue_base::{KeyError, KeyPath};

/// A light that shines from a point in all directions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointLightDescription {
    /// Its position, in m.
    #[serde(deserialize_with = "numbers")]
    pub position: [f64; 3],
    /// Its radiant intensity over 400–700 nm, in W/sr.
    pub radiant_intensity_w_sr: f64,
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
    fn light(&self, path: &KeyPath, spectrum: &LightSpectrum) -> Result<Light, KeyError> {
        COORDINATE.check_all(&path.key("position"), &self.position)?;
        Range::power("W/sr").check(&path.key("radiant_intensity_w_sr"), self.radiant_intensity_w_sr)?;
        let emission = spectrum.unit * narrow(self.radiant_intensity_w_sr);
        Ok(Light::new(PointLight { position: point(self.position), emission }))
    }
}

impl Emitter for PointLight {
    fn name(&self) -> &'static str {
        "point"
    }

    fn bounds(&self) -> Bounds {
        Bounds::Point(self.position, None)
    }

    fn uniform(&self) -> Option<&Spectrum> {
        Some(&self.emission)
    }

    fn inner_lamp(&self) -> Option<InnerLamp> {
        Some(InnerLamp { position: self.position, radius_m: 0.0, intensity: self.emission })
    }
}
