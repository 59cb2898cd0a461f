//! sRGB as files and screens carry it: encoded, with 8 bits a channel.
//!
//! code = 12.92 v up to v = 0.0031308, else 1.055 v^(1/2.4) − 0.055 (IEC 61966-2-1:1999).

use std::fmt;
use std::str::FromStr;

use crate::error::ColorError;
use crate::rgb::LinearRgb;

/// Encoded sRGB with 8 bits a channel, as in PNG files. It is written and read as in HTML: `#rrggbb`.
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
    /// The 8-bit colour, rounded; what is below 0 or above 1 is shown as 0 or 1.
    ///
    /// Channels below 0 shift the hue when cut off: apply [`LinearRgb::displayable`] first.
    ///
    /// The eye tells dark tones apart better than light ones, so half of the codes serve the darkest fifth of the light:
    /// ```
    /// # use snowblue_color::{LinearRgb, Srgb8};
    /// assert_eq!(Srgb8::encode(LinearRgb { r: 0.0, g: 0.2159, b: 1.0 }).to_string(), "#0080ff");
    /// ```
    pub fn encode(colour: LinearRgb) -> Srgb8 {
        Srgb8 { r: encode_8_bit(colour.r), g: encode_8_bit(colour.g), b: encode_8_bit(colour.b) }
    }

    /// The linear colour that the codes stand for.
    pub fn decode(self) -> LinearRgb {
        let decode = |code: u8| decode_channel(f64::from(code) / 255.0);
        LinearRgb { r: decode(self.r), g: decode(self.g), b: decode(self.b) }
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
        let [_, r, g, b] = code.ok_or_else(|| ColorError::NotHex { text: text.to_owned() })?.to_be_bytes();
        Ok(Srgb8 { r, g, b })
    }
}

/// Code value of one channel, 0–1, from its linear value (IEC 61966-2-1).
pub fn encode_channel(linear: f64) -> f64 {
    if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Linear value of one channel from its code value, 0–1: the inverse of [`encode_channel`].
pub fn decode_channel(code: f64) -> f64 {
    if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

#[allow(clippy::cast_possible_truncation, reason = "the value is rounded and lies in 0–255")]
fn encode_8_bit(linear: f64) -> u8 {
    (255.0 * encode_channel(linear.clamp(0.0, 1.0))).round() as u8
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

    /// The standard's constants are rounded: its branches miss each other by 3e-8 where they meet.
    #[test]
    fn encoding_and_decoding_are_inverse() {
        for step in 0..=1000 {
            let linear = f64::from(step) / 1000.0;
            let back = decode_channel(encode_channel(linear));
            assert!((back - linear).abs() < 1e-7, "{linear} {back}");
        }
        assert!((encode_channel(0.0031308) - encode_channel(0.003_130_800_1)).abs() < 1e-7);
    }

    #[test]
    fn encoding_stops_at_black_and_white() {
        let [r, g, b] = [-0.1, 1.1, 1e9];
        assert_eq!(Srgb8::encode(LinearRgb { r, g, b }).to_string(), "#00ffff");
    }

    #[test]
    fn hex_is_strict() {
        let [r, g, b] = [0x8f, 0xb8, 0xde];
        assert_eq!("#8Fb8dE".parse(), Ok(Srgb8 { r, g, b }));
        for text in ["8fb8de", "#8fb8d", "#8fb8de0", "#+fb8de", "#8fb8dé", ""] {
            assert_eq!(text.parse::<Srgb8>(), Err(ColorError::NotHex { text: text.to_owned() }));
        }
    }
}
