//! Size and exposure of an image.

use std::fmt;
use std::num::ParseFloatError;
use std::str::FromStr;

/// Size and brightness of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmSettings {
    /// Pixels from left to right.
    pub width: u32,
    /// Pixels from top to bottom.
    pub height: u32,
    /// Brightness of the PNG.
    pub exposure: Exposure,
}

/// How radiance becomes brightness in a PNG; EXR files keep radiance as it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Exposure {
    /// The brightest percent of the pixels comes close to white.
    #[default]
    Auto,
    /// Radiance times 2^stops: at 0 stops, a luminance of 1 (that of 1 W m⁻² sr⁻¹ of equal-energy light over
    /// 400–700 nm) is white.
    Stops(f64),
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

/// Reads what [`Display`](fmt::Display) wrote, to the same bits.
impl FromStr for Exposure {
    type Err = ParseFloatError;

    fn from_str(text: &str) -> Result<Self, ParseFloatError> {
        if text == "auto" { Ok(Self::Auto) } else { text.parse().map(Self::Stops) }
    }
}
