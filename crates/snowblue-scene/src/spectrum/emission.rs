//! The spectrum of a light.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::KeyPath;
use snowblue_color::Illuminant;

use crate::error::SceneError;
use crate::sources::Sources;
use crate::spectrum::light_spectrum::LightSpectrum;
use crate::values::{beside, text};

/// The shape of the spectrum of a light: an illuminant of the CIE, or a file; daylight (D65) if neither is given.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EmissionSpectrum {
    /// An illuminant of the CIE: `D65`, `A`, `E`, …
    #[serde(
        default,
        serialize_with = "text::serialize_some",
        deserialize_with = "text::deserialize_some",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(with = "Option<String>")]
    pub illuminant: Option<Illuminant>,
    /// A CSV file with the columns `wavelength_nm,value`, instead of an illuminant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spectrum: Option<String>,
}

impl EmissionSpectrum {
    /// The keys.
    pub(crate) const KEYS: [&str; 2] = ["illuminant", "spectrum"];

    /// The spectrum of the light at a path.
    pub(crate) fn build(&self, path: &KeyPath, sources: &Sources) -> Result<LightSpectrum, SceneError> {
        match (self.illuminant, &self.spectrum) {
            (Some(_), Some(_)) => Err(path.key("spectrum").error(beside("illuminant")).into()),
            (None, Some(file)) => LightSpectrum::read(sources.files, file)
                .map_err(|error| sources.named(&path.key("spectrum"), file, error)),
            (illuminant, None) => {
                let illuminant = illuminant.unwrap_or(Illuminant::D65);
                LightSpectrum::illuminant(illuminant)
                    .map_err(|error| path.key("illuminant").error(format!("is \"{illuminant}\": {error}")).into())
            }
        }
    }
}
