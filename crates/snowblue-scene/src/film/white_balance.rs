//! The light that looks white in a picture.

use std::fmt;
use std::str::FromStr;

use snowblue_color::{ColorError, Illuminant};

/// The light in which a white surface is neutral in a picture.
///
/// Colours are adapted from it to the white of sRGB, D65, as eyes and cameras do
/// ([`ChromaticAdaptation`](snowblue_color::ChromaticAdaptation)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WhiteBalance {
    /// That of a CIE illuminant. For D65 colours stay as they are.
    Illuminant(Illuminant),
    /// That of all skies, the sun and distant lamps on level ground.
    Sky,
}

impl Default for WhiteBalance {
    fn default() -> Self {
        Self::Illuminant(Illuminant::D65)
    }
}

/// The name of an illuminant, or `sky`.
impl fmt::Display for WhiteBalance {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Illuminant(illuminant) => illuminant.fmt(formatter),
            Self::Sky => formatter.write_str("sky"),
        }
    }
}

impl FromStr for WhiteBalance {
    type Err = ColorError;

    fn from_str(text: &str) -> Result<Self, ColorError> {
        if text == "sky" { Ok(Self::Sky) } else { text.parse().map(Self::Illuminant) }
    }
}
