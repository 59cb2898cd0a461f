//! The spectrum of a light.

use std::fmt::Display;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::{KeyPath, Number};
use snowblue_color::Illuminant;

use crate::error::SceneError;
use crate::film::white_balance::ColorTemperature;
use crate::sources::Sources;
use crate::spectrum::light_spectrum::LightSpectrum;
use crate::spectrum::upsampling::Upsampling;
use crate::values::{ColorDescription, only_one, text};

/// The shape of the spectrum of a light, by one of four notations; daylight (D65) if none is given.
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
    /// A colour temperature, as of a bulb (2700 K) or of daylight (6500 K).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_k: Option<Number<ColorTemperature>>,
    /// The colour: `[r, g, b]` in linear sRGB, or "#rrggbb" in encoded sRGB. Its brightness does not matter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<ColorDescription>,
    /// A CSV file with the columns `wavelength_nm,value`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spectrum: Option<String>,
}

impl EmissionSpectrum {
    /// The keys.
    pub(crate) const KEYS: [&str; 4] = ["illuminant", "temperature_k", "color", "spectrum"];

    /// The spectrum of the light at a path.
    pub(crate) fn build(&self, path: &KeyPath, sources: &Sources) -> Result<LightSpectrum, SceneError> {
        let Self { illuminant, temperature_k, color, spectrum } = self;
        let wrong = |key: &str, error: &dyn Display| -> SceneError { path.key(key).error(error.to_string()).into() };
        let of_illuminant = |illuminant: Illuminant| {
            LightSpectrum::illuminant(illuminant)
                .map_err(|error| wrong("illuminant", &format!("is \"{illuminant}\": {error}")))
        };
        if *self == Self::default() {
            return of_illuminant(Illuminant::D65);
        }
        let of_temperature = |kelvin: Number<ColorTemperature>| {
            LightSpectrum::of_temperature(kelvin.get()).map_err(|error| wrong("temperature_k", &error))
        };
        let of_color = |color: ColorDescription| {
            let spectrum = Upsampling::daylight().spectrum(color.linear());
            LightSpectrum::of_spectrum(&spectrum).ok_or_else(|| wrong("color", &"is black, but must be a colour"))
        };
        let of_file = |file: &String| {
            LightSpectrum::read(sources.files, file).map_err(|error| sources.named(&path.key("spectrum"), file, error))
        };
        only_one(
            path,
            [
                ("illuminant", illuminant.map(of_illuminant)),
                ("temperature_k", temperature_k.map(of_temperature)),
                ("color", color.map(of_color)),
                ("spectrum", spectrum.as_ref().map(of_file)),
            ],
        )?
    }
}
