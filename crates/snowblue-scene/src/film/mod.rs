//! Size and exposure of an image, and the sensor that sees its light.

pub mod sensor;
pub mod white_balance;

use std::fmt;
use std::num::ParseFloatError;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use snowblue_color::LinearRgb;
use snowblue_color::exposure::{AutoExposure, factor};

use crate::film::sensor::FalseColor;
use crate::film::white_balance::WhiteBalance;
use crate::notation::{Notations, text};

/// Size of an image in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageSize {
    /// Pixels from left to right.
    pub width: u32,
    /// Pixels from top to bottom.
    pub height: u32,
}

impl ImageSize {
    /// Number of pixels.
    pub fn pixel_count(self) -> usize {
        self.width as usize * self.height as usize
    }
}

/// Size and exposure of an image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FilmSettings {
    /// Number of columns of pixels.
    pub width: u32,
    /// Number of rows of pixels.
    pub height: u32,
    /// Exposure of a PNG.
    pub exposure: Exposure,
    /// The light that looks white. In false colour all lights do.
    #[serde(with = "text")]
    pub white: WhiteBalance,
    /// Three wavelengths as red, green and blue, instead of the colours that an observer sees. Lights are then white.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub false_color: Option<FalseColor>,
}

impl Default for FilmSettings {
    fn default() -> Self {
        Self { width: 1080, height: 1080, exposure: Exposure::Auto, white: WhiteBalance::default(), false_color: None }
    }
}

impl FilmSettings {
    /// Size of the image in pixels.
    pub fn size(&self) -> ImageSize {
        ImageSize { width: self.width, height: self.height }
    }
}

/// The fraction of pixels that automatic exposure fits into the display's range. The rest, lights and highlights, may
/// clip.
const AUTO_FRACTION: f64 = 0.99;

/// The level to which automatic exposure maps the brightest of these pixels; 1 is the display's white.
const AUTO_LEVEL: f64 = 0.9;

/// The factor between radiance and linear RGB in a PNG. EXR files store radiance without exposure.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Exposure {
    /// The 99th percentile of the pixels is close to white. Pixels that show a lamp or the sun do not count.
    #[default]
    Auto,
    /// The factor is 2^stops. At 0 stops, a luminance of 1 (that of 1 W m⁻² sr⁻¹ of equal-energy light over
    /// 400–700 nm) is white.
    Stops(f64),
}

impl Exposure {
    /// The factor by which the radiance of some pixels is multiplied for display.
    pub fn display_factor(self, pixels: impl Iterator<Item = LinearRgb>) -> f64 {
        match self {
            Self::Stops(stops) => factor(stops),
            Self::Auto => AutoExposure { fraction: AUTO_FRACTION, level: AUTO_LEVEL }.factor(pixels),
        }
    }
}

/// Stops, or `auto`.
impl fmt::Display for Exposure {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Auto => formatter.write_str("auto"),
            Self::Stops(stops) => write!(formatter, "{stops}"),
        }
    }
}

/// Parses the output of [`Display`](fmt::Display) to the same bits.
impl FromStr for Exposure {
    type Err = ParseFloatError;

    fn from_str(text: &str) -> Result<Self, ParseFloatError> {
        if text == "auto" { Ok(Self::Auto) } else { text.parse().map(Self::Stops) }
    }
}

impl Serialize for Exposure {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => serializer.serialize_str("auto"),
            Self::Stops(stops) => serializer.serialize_f64(*stops),
        }
    }
}

impl<'de> Deserialize<'de> for Exposure {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Notations::<Self, 0> {
            expected: "\"auto\" or a number of stops",
            number: Some(Self::Stops),
            text: Some(|text| match text {
                "auto" => Ok(Self::Auto),
                other => Err(format!("is \"{other}\", but must be \"auto\" or a number of stops")),
            }),
            list: None,
        })
    }
}
