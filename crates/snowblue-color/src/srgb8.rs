//! Encoded sRGB with 8 bits per channel, as in PNG files and HTML.

use std::fmt;
use std::str::FromStr;

use crate::error::ColorError;
use crate::rgb::LinearRgb;
use crate::transfer::{decode_srgb, encode_srgb};

/// Encoded sRGB with 8 bits per channel. Formats and parses as in HTML: `#rrggbb`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Srgb8 {
    /// Red.
    pub r: u8,
    /// Green.
    pub g: u8,
    /// Blue.
    pub b: u8,
}

impl Srgb8 {
    /// The nearest 8-bit colour. Channels are clamped to 0–1.
    ///
    /// Clamping negative channels shifts the hue: apply [`LinearRgb::displayable`] first.
    ///
    /// Vision distinguishes dark tones better than light ones, so half of the codes cover the darkest fifth of the
    /// range:
    /// ```
    /// # use snowblue_color::{LinearRgb, Srgb8};
    /// assert_eq!(Srgb8::encode(LinearRgb { r: 0.0, g: 0.2159, b: 1.0 }).to_string(), "#0080ff");
    /// ```
    pub fn encode(colour: LinearRgb) -> Srgb8 {
        Srgb8 { r: encode_channel(colour.r), g: encode_channel(colour.g), b: encode_channel(colour.b) }
    }

    /// The linear colour of these code values.
    pub fn decode(self) -> LinearRgb {
        let decode = |code: u8| decode_srgb(f64::from(code) / 255.0);
        LinearRgb { r: decode(self.r), g: decode(self.g), b: decode(self.b) }
    }
}

impl LinearRgb {
    /// The colour, mapped into the gamut of sRGB, as `#rrggbb`.
    #[must_use]
    pub fn display_hex(self) -> String {
        Srgb8::encode(self.displayable()).to_string()
    }
}

impl fmt::Display for Srgb8 {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(&format!("#{:02x}{:02x}{:02x}", self.r, self.g, self.b))
    }
}

impl FromStr for Srgb8 {
    type Err = ColorError;

    fn from_str(text: &str) -> Result<Srgb8, ColorError> {
        let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6);
        let digits = digits.filter(|digits| digits.bytes().all(|digit| digit.is_ascii_hexdigit()));
        let code = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok());
        let [_, r, g, b] = code.ok_or_else(|| ColorError::InvalidHex { text: text.to_owned() })?.to_be_bytes();
        Ok(Srgb8 { r, g, b })
    }
}

#[allow(clippy::cast_possible_truncation, reason = "the value is rounded and lies in 0–255")]
fn encode_channel(linear: f64) -> u8 {
    (255.0 * encode_srgb(linear.clamp(0.0, 1.0))).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_codes_survive_decoding_and_encoding() {
        for code in 0..=u8::MAX {
            let colour = Srgb8 { r: code, g: 255 - code, b: 7 };
            assert_eq!(Srgb8::encode(colour.decode()), colour);
            assert_eq!(colour.to_string().parse(), Ok(colour));
        }
    }

    #[test]
    fn encoding_clamps_to_black_and_white() {
        let [r, g, b] = [-0.1, 1.1, 1e9];
        assert_eq!(Srgb8::encode(LinearRgb { r, g, b }).to_string(), "#00ffff");
    }

    #[test]
    fn hex_is_strict() {
        let [r, g, b] = [0x8f, 0xb8, 0xde];
        assert_eq!("#8Fb8dE".parse(), Ok(Srgb8 { r, g, b }));
        for text in ["8fb8de", "#8fb8d", "#8fb8de0", "#+fb8de", "#8fb8dé", ""] {
            assert_eq!(text.parse::<Srgb8>(), Err(ColorError::InvalidHex { text: text.to_owned() }));
        }
    }
}
