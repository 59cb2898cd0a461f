//! The light that looks white in a picture.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use snowblue_base::{Number, ParameterRange, quantities};
use snowblue_color::{ChromaticAdaptation, ColorError, Illuminant, Xyz, temperature};

use crate::film::sensor::Sensor;
use crate::spectrum::Spectrum;
use crate::spectrum::light_spectrum::LightSpectrum;
use crate::values::{AnyOf, Notations};

quantities! {
    /// Correlated colour temperature.
    pub ColorTemperature =
        ParameterRange::new("colour temperature", *temperature::RANGE_K.start(), *temperature::RANGE_K.end(), "K");
}

/// The light in which a white surface is neutral in a picture.
///
/// Colours are adapted from it to the white of sRGB, D65, as eyes and cameras do.
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

impl WhiteBalance {
    /// The relative spectrum of the light; none for the light of the sky, which a scene has.
    pub(crate) fn spectrum(self) -> Result<Option<Spectrum>, ColorError> {
        let light = match self {
            Self::Illuminant(illuminant) => LightSpectrum::illuminant(illuminant)?,
            Self::Temperature(kelvin) => LightSpectrum::of_temperature(kelvin)?,
            Self::Sky => return Ok(None),
        };
        Ok(Some(light.relative))
    }
}

/// The light that looks white in a picture, and the light of its sky, with which another light can look white later.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PictureWhite {
    /// The light that looks white.
    pub white: WhiteBalance,
    /// Tristimulus values of the light of the sky on level ground, at luminance 1; none without a sky, or if its colour
    /// is outside of sRGB.
    pub sky: Option<Xyz>,
}

impl PictureWhite {
    /// The adaptations, one after the other, after which another light looks white.
    ///
    /// # Errors
    ///
    /// When a light has a colour outside of sRGB, or the light of the sky is not known.
    pub fn changed_to(self, white: WhiteBalance) -> Result<[ChromaticAdaptation; 2], String> {
        let sensor = Sensor::cie_1931();
        let xyz = |white: WhiteBalance| match white.spectrum().map_err(|error| error.to_string())? {
            None => self.sky.ok_or_else(|| {
                "the colour of the light of the sky is not known: the file has no attribute snowblueSky".to_owned()
            }),
            Some(light) => {
                sensor.white_xyz(&light).ok_or_else(|| format!("the light {white} has a colour outside of sRGB"))
            }
        };
        let (display, own, new) = (sensor.own_white_xyz(), xyz(self.white)?, xyz(white)?);
        Ok([(display, own), (new, display)].map(|(from_white, to_white)| ChromaticAdaptation { from_white, to_white }))
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

    /// A picture for one light and then for another is the picture for the other.
    #[test]
    fn a_white_can_be_changed_later() {
        let spectrum = Spectrum(std::array::from_fn(|k| 1.0 + (0.4 * k as f32).sin()));
        let sky = LightSpectrum::of_temperature(12_000.0).unwrap().relative;
        let seen = |white: WhiteBalance| {
            let light = white.spectrum().unwrap().unwrap_or(sky);
            Sensor::cie_1931().balanced(&light).unwrap().xyz(&spectrum)
        };
        let whites = ["D65", "A", "5000K", "sky"].map(|name| name.parse::<WhiteBalance>().unwrap());
        for own in whites {
            let picture = PictureWhite { white: own, sky: Sensor::cie_1931().white_xyz(&sky) };
            for other in whites {
                let changed = picture.changed_to(other).unwrap().into_iter().fold(seen(own), |xyz, to| to.apply(xyz));
                let expected = seen(other);
                for (found, expected) in [(changed.x, expected.x), (changed.y, expected.y), (changed.z, expected.z)] {
                    assert!((found / expected - 1.0).abs() < 1e-5, "{own} to {other}: {found} {expected}");
                }
            }
        }
        let without_sky = PictureWhite::default();
        assert!(without_sky.changed_to(WhiteBalance::Sky).unwrap_err().contains("sky is not known"));
    }

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
