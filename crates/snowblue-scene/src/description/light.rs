//! Lights as data.

use serde::{Deserialize, Serialize};
use snowblue_color::Illuminant;

use crate::light::LightSource;
use crate::light::image::ImageSkyDescription;
use crate::light::keys::LightKeys;
use crate::light::uniform_sky::SkyGlow;
use crate::notation::text;
use crate::spectrum::light_spectrum::LightSpectrum;
use snowblue_base::{KeyError, KeyPath};

/// The spectrum of a light.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum LampDescription {
    /// That of a CIE illuminant.
    #[serde(rename = "illuminant", serialize_with = "text::serialize")]
    Illuminant(Illuminant),
    /// From a CSV file with the columns `wavelength_nm,value`.
    #[serde(rename = "spectrum")]
    File(String),
}

impl Default for LampDescription {
    /// Daylight, D65.
    fn default() -> Self {
        Self::Illuminant(Illuminant::D65)
    }
}

/// The keys of a light's spectrum.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LampKeys {
    #[serde(default, deserialize_with = "text::deserialize_some")]
    illuminant: Option<Illuminant>,
    spectrum: Option<String>,
}

impl LampKeys {
    /// Names of the keys.
    pub(crate) const NAMES: [&str; 2] = ["illuminant", "spectrum"];

    /// The spectrum that they describe; none if both are there.
    pub(crate) fn lamp(self) -> Option<LampDescription> {
        match (self.illuminant, self.spectrum) {
            (None, None) => Some(LampDescription::default()),
            (Some(illuminant), None) => Some(LampDescription::Illuminant(illuminant)),
            (None, Some(file)) => Some(LampDescription::File(file)),
            (Some(_), Some(_)) => None,
        }
    }
}

/// A light with a position or a direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LightDescription {
    /// The shape of its spectrum.
    #[serde(flatten)]
    pub lamp: LampDescription,
    /// Its geometry and strength.
    #[serde(flatten)]
    pub source: LightSource,
}

impl LightDescription {
    /// Checks the ranges of all values.
    pub(super) fn check(&self, path: &KeyPath) -> Result<(), KeyError> {
        self.source.keys().light(path, &LightSpectrum::EQUAL_ENERGY).map(drop)
    }
}

impl From<LightSource> for LightDescription {
    /// A light of daylight, D65.
    fn from(source: LightSource) -> Self {
        Self { lamp: LampDescription::default(), source }
    }
}

/// Light from all directions.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum EnvironmentDescription {
    /// The same from everywhere.
    Uniform(UniformSkyDescription),
    /// That of an image.
    Image(ImageSkyDescription),
}

impl EnvironmentDescription {
    /// Checks the ranges of all values.
    pub(super) fn check(&self, path: &KeyPath) -> Result<(), KeyError> {
        match self {
            Self::Uniform(sky) => sky.glow.light(path, &LightSpectrum::EQUAL_ENERGY).map(drop),
            Self::Image(sky) => sky.check(path),
        }
    }
}

/// Light that is the same from all directions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UniformSkyDescription {
    /// The shape of its spectrum.
    #[serde(flatten)]
    pub lamp: LampDescription,
    /// Its strength.
    #[serde(flatten)]
    pub glow: SkyGlow,
}
