//! The light that looks white in a picture.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use snowblue_base::{Number, ParameterRange, quantities};
use snowblue_color::{ColorError, Illuminant, temperature};

use crate::values::{AnyOf, Notations};

quantities! {
    /// Correlated colour temperature.
    pub ColorTemperature =
        ParameterRange::new("colour temperature", *temperature::RANGE_K.start(), *temperature::RANGE_K.end(), "K");
}

/// The light in which a white surface is neutral in a picture.
///
/// Colours are adapted from it to the white of sRGB, D65, as eyes and cameras do
/// ([`ChromaticAdaptation`](snowblue_color::ChromaticAdaptation)).
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema)]
#[schemars(with = "AnyOf<String, Number<ColorTemperature>>")]
pub enum WhiteBalance {
    /// That of a CIE illuminant. For D65 colours stay as they are.
    Illuminant(Illuminant),
    /// That of a correlated colour temperature in K: [daylight or a black body](snowblue_color::temperature).
    Temperature(f64),
    /// That of all skies, the sun and distant lamps on level ground.
    Sky,
}

impl Default for WhiteBalance {
    fn default() -> Self {
        Self::Illuminant(Illuminant::D65)
    }
}

/// The name of an illuminant, a temperature such as `6500K`, or `sky`.
impl fmt::Display for WhiteBalance {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Illuminant(illuminant) => illuminant.fmt(formatter),
            Self::Temperature(kelvin) => write!(formatter, "{kelvin}K"),
            Self::Sky => formatter.write_str("sky"),
        }
    }
}

impl FromStr for WhiteBalance {
    type Err = ColorError;

    fn from_str(text: &str) -> Result<Self, ColorError> {
        let kelvin = || text.strip_suffix(['K', 'k']).unwrap_or(text).trim_end().parse().ok();
        match text {
            "sky" => Ok(Self::Sky),
            _ => match kelvin() {
                Some(kelvin) => temperature::check(kelvin).map(Self::Temperature),
                None => text.parse().map(Self::Illuminant),
            },
        }
    }
}

/// A number of kelvins, or a text.
impl Serialize for WhiteBalance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Temperature(kelvin) => serializer.serialize_f64(*kelvin),
            Self::Illuminant(_) | Self::Sky => serializer.collect_str(self),
        }
    }
}

impl<'de> Deserialize<'de> for WhiteBalance {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Notations::<ColorTemperature, 0, _> {
            expected: "an illuminant, a temperature in K or \"sky\"",
            number: Some(|kelvin| Self::Temperature(kelvin.get())),
            word: Some(|word| word.parse().map_err(|error: ColorError| error.to_string())),
            list: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn temperatures_are_read_with_and_without_their_unit() {
        for text in ["6500", "6500K", "6500 K", "6500k"] {
            assert_eq!(text.parse(), Ok(WhiteBalance::Temperature(6500.0)), "{text}");
        }
        for white in [WhiteBalance::Temperature(3200.5), WhiteBalance::Sky, WhiteBalance::default()] {
            assert_eq!(white.to_string().parse(), Ok(white));
        }
        for text in ["500", "nan", "D66", "K", "6500 °C"] {
            assert!(text.parse::<WhiteBalance>().is_err(), "{text}");
        }
    }
}
