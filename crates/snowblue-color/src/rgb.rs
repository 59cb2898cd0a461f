//! RGB: light as a mixture of three primaries, linear, and encoded with 8 bits per channel as in PNG files and HTML.
//!
//! The matrices are derived from the primaries and the white, since the matrices printed in the standards are
//! rounded. With (x, y, z)/y of the primaries as the columns of P, the white W = P s determines the scales s, and XYZ
//! = P diag(s) RGB (SMPTE RP 177:1993).

use std::fmt;
use std::ops::{AddAssign, Mul};
use std::str::FromStr;

use crate::error::ColorError;
use crate::matrix::{Matrix, Vector, inverse, multiply, product, transpose};
use crate::transfer::{decode_srgb, encode_rec2020, encode_srgb};
use crate::xyz::{ChromaticAdaptation, Chromaticity, Xyy, Xyz};

/// D65 as defined by sRGB and Rec. 2020.
const D65: Chromaticity = Chromaticity { x: 0.3127, y: 0.3290 };

/// An RGB space: three primaries and a white.
///
/// Conversions do not adapt to the white: D65 in [`RgbSpace::AcesCg`], whose white is about D60, is slightly blue
/// rather than 1, 1, 1. To map the white of a scene to 1, 1, 1, apply a
/// [`ChromaticAdaptation`] to the tristimulus values first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RgbSpace {
    /// sRGB: primaries of Rec. 709, white D65 (IEC 61966-2-1:1999, ITU-R BT.709-6).
    Srgb,
    /// Rec. 2020, wide-gamut television: white D65 (ITU-R BT.2020-2).
    Rec2020,
    /// ACEScg, a working space for film rendering: primaries AP1, white about D60 (Academy S-2014-004).
    AcesCg,
}

/// Chromaticities of the primaries of an [`RgbSpace`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Primaries {
    /// Red.
    pub red: Chromaticity,
    /// Green.
    pub green: Chromaticity,
    /// Blue.
    pub blue: Chromaticity,
}

/// Linear amounts of the three primaries of an [`RgbSpace`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rgb {
    /// Red.
    pub r: f64,
    /// Green.
    pub g: f64,
    /// Blue.
    pub b: f64,
}

/// Linear sRGB: proportional to the light of a screen's three primaries. 1, 1, 1 is white.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LinearRgb {
    /// Red.
    pub r: f64,
    /// Green.
    pub g: f64,
    /// Blue.
    pub b: f64,
}

impl Primaries {
    /// Tristimulus values of one unit of red, green and blue, where one unit of each gives a white of luminance 1; none
    /// if the white does not lie between the primaries.
    pub fn units(self, white: Chromaticity) -> Option<[Xyz; 3]> {
        let units = transpose(self.matrix(at_unit_luminance(white))).map(|[x, y, z]| Xyz { x, y, z });
        // Imaginary primaries may have a negative luminance. The comparison also fails for NaN.
        units.iter().all(|Xyz { x, y, z }| x + y + z > 0.0).then_some(units)
    }

    /// Linear sRGB of one unit of red, green and blue in a space of a white, adapted to the white of sRGB; none if the
    /// white does not lie between the primaries, or is no white of broadband light.
    ///
    /// White is white in every space:
    /// ```
    /// # use snowblue_color::RgbSpace;
    /// let film = RgbSpace::AcesCg;
    /// let [red, green, blue] = film.primaries().in_srgb(film.white().chromaticity()).unwrap();
    /// assert!((red.r + green.r + blue.r - 1.0).abs() < 1e-12);
    /// // The red of film is outside the gamut of screens.
    /// assert!(red.r > 1.7 && red.g < 0.0);
    /// ```
    pub fn in_srgb(self, white: Chromaticity) -> Option<[LinearRgb; 3]> {
        let units = self.units(white)?;
        let from_white = Xyy { chromaticity: white, luminance: 1.0 }.xyz();
        let adaptation = ChromaticAdaptation { from_white, to_white: RgbSpace::Srgb.white() };
        adaptation.is_possible().then(|| units.map(|unit| LinearRgb::from_xyz(adaptation.apply(unit))))
    }

    /// From amounts of the primaries to tristimulus values, where one unit of each is the white.
    const fn matrix(self, white: Vector) -> Matrix {
        let Self { red, green, blue } = self;
        let [x, y, z] = transpose([at_unit_luminance(red), at_unit_luminance(green), at_unit_luminance(blue)]);
        let scales = product(inverse([x, y, z]), white);
        [multiply(x, scales), multiply(y, scales), multiply(z, scales)]
    }
}

impl RgbSpace {
    /// All spaces.
    pub const ALL: [RgbSpace; 3] = [RgbSpace::Srgb, RgbSpace::Rec2020, RgbSpace::AcesCg];

    /// Chromaticities of the primaries.
    pub const fn primaries(self) -> Primaries {
        const fn at(x: f64, y: f64) -> Chromaticity {
            Chromaticity { x, y }
        }
        match self {
            RgbSpace::Srgb => Primaries { red: at(0.64, 0.33), green: at(0.30, 0.60), blue: at(0.15, 0.06) },
            RgbSpace::Rec2020 => Primaries { red: at(0.708, 0.292), green: at(0.170, 0.797), blue: at(0.131, 0.046) },
            RgbSpace::AcesCg => Primaries { red: at(0.713, 0.293), green: at(0.165, 0.830), blue: at(0.128, 0.044) },
        }
    }

    /// The white, RGB = 1, 1, 1, with luminance 1.
    pub const fn white(self) -> Xyz {
        let chromaticity = match self {
            RgbSpace::Srgb | RgbSpace::Rec2020 => D65,
            RgbSpace::AcesCg => Chromaticity { x: 0.32168, y: 0.33767 },
        };
        let [x, y, z] = at_unit_luminance(chromaticity);
        Xyz { x, y, z }
    }

    /// Converts from tristimulus values. Negative amounts are outside the gamut.
    ///
    /// The blue below half a metre of snow is outside the sRGB gamut, but inside the Rec. 2020 gamut:
    /// ```
    /// # use snowblue_color::{RgbSpace, Xyz};
    /// let below_half_a_metre = Xyz { x: 0.091, y: 0.1, z: 0.355 };
    /// assert!(RgbSpace::Srgb.from_xyz(below_half_a_metre).r < 0.0);
    /// assert!(RgbSpace::Rec2020.from_xyz(below_half_a_metre).r > 0.0);
    /// ```
    pub fn from_xyz(self, xyz: Xyz) -> Rgb {
        let [r, g, b] = product(XYZ_TO_RGB[self as usize], [xyz.x, xyz.y, xyz.z]);
        Rgb { r, g, b }
    }

    /// Converts to tristimulus values.
    pub fn xyz(self, Rgb { r, g, b }: Rgb) -> Xyz {
        let [x, y, z] = product(RGB_TO_XYZ[self as usize], [r, g, b]);
        Xyz { x, y, z }
    }

    /// Code value of one channel, 0–1, from its linear amount, 0–1. ACEScg is stored linear.
    pub fn encode_channel(self, linear: f64) -> f64 {
        match self {
            RgbSpace::Srgb => encode_srgb(linear),
            RgbSpace::Rec2020 => encode_rec2020(linear),
            RgbSpace::AcesCg => linear,
        }
    }
}

impl fmt::Display for RgbSpace {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            RgbSpace::Srgb => "sRGB",
            RgbSpace::Rec2020 => "Rec. 2020",
            RgbSpace::AcesCg => "ACEScg",
        })
    }
}

impl LinearRgb {
    /// Converts from tristimulus values. Negative channels are outside the gamut.
    pub fn from_xyz(xyz: Xyz) -> LinearRgb {
        let Rgb { r, g, b } = RgbSpace::Srgb.from_xyz(xyz);
        LinearRgb { r, g, b }
    }

    /// Converts to tristimulus values.
    pub fn xyz(self) -> Xyz {
        RgbSpace::Srgb.xyz(Rgb { r: self.r, g: self.g, b: self.b })
    }

    /// Luminance Y; 1 for white.
    pub fn luminance(self) -> f64 {
        self.xyz().y
    }
}

/// Scales the light by a factor.
impl Mul<f64> for LinearRgb {
    type Output = LinearRgb;

    fn mul(self, factor: f64) -> LinearRgb {
        LinearRgb { r: self.r * factor, g: self.g * factor, b: self.b * factor }
    }
}

/// Adds light.
impl AddAssign for LinearRgb {
    fn add_assign(&mut self, other: LinearRgb) {
        (self.r, self.g, self.b) = (self.r + other.r, self.g + other.g, self.b + other.b);
    }
}

/// Matrices in the order of [`RgbSpace::ALL`].
static RGB_TO_XYZ: [Matrix; 3] =
    [rgb_to_xyz(RgbSpace::Srgb), rgb_to_xyz(RgbSpace::Rec2020), rgb_to_xyz(RgbSpace::AcesCg)];
static XYZ_TO_RGB: [Matrix; 3] =
    [xyz_to_rgb(RgbSpace::Srgb), xyz_to_rgb(RgbSpace::Rec2020), xyz_to_rgb(RgbSpace::AcesCg)];

pub(crate) const fn rgb_to_xyz(space: RgbSpace) -> Matrix {
    let Xyz { x, y, z } = space.white();
    space.primaries().matrix([x, y, z])
}

const fn xyz_to_rgb(space: RgbSpace) -> Matrix {
    inverse(rgb_to_xyz(space))
}

/// (x, y, 1 − x − y)/y.
const fn at_unit_luminance(Chromaticity { x, y }: Chromaticity) -> Vector {
    [x / y, 1.0, (1.0 - x - y) / y]
}

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
    /// Vision distinguishes dark tones better than light tones, so half of the codes cover the darkest fifth of the
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

    fn assert_chromaticity(xyz: Xyz, expected: Chromaticity) {
        let found = xyz.chromaticity();
        assert!((found.x - expected.x).abs() < 1e-15, "{found:?}");
        assert!((found.y - expected.y).abs() < 1e-15, "{found:?}");
    }

    #[test]
    fn rgb_round_trips() {
        for space in RgbSpace::ALL {
            let back = space.from_xyz(space.xyz(Rgb { r: 0.1, g: -0.2, b: 3.0 }));
            let differences = [back.r - 0.1, back.g + 0.2, back.b - 3.0];
            assert!(differences.iter().all(|difference| difference.abs() < 1e-14), "{space}: {back:?}");
        }
    }

    #[test]
    fn white_and_primaries_have_their_chromaticities() {
        for space in RgbSpace::ALL {
            let Primaries { red, green, blue } = space.primaries();
            assert_chromaticity(space.xyz(Rgb { r: 0.5, g: 0.0, b: 0.0 }), red);
            assert_chromaticity(space.xyz(Rgb { r: 0.0, g: 0.5, b: 0.0 }), green);
            assert_chromaticity(space.xyz(Rgb { r: 0.0, g: 0.0, b: 0.5 }), blue);
            let white = space.xyz(Rgb { r: 1.0, g: 1.0, b: 1.0 });
            assert_chromaticity(white, space.white().chromaticity());
            assert!((white.y - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn linear_rgb_is_srgb() {
        let colour = Xyz { x: 0.3, y: 0.2, z: 0.4 };
        let Rgb { r, g, b } = RgbSpace::Srgb.from_xyz(colour);
        assert_eq!(LinearRgb::from_xyz(colour), LinearRgb { r, g, b });
        assert!((LinearRgb { r, g, b }.luminance() - 0.2).abs() < 1e-15);
    }

    #[test]
    fn black_and_white_encode_to_0_and_1() {
        for space in RgbSpace::ALL {
            assert!(space.encode_channel(0.0).abs() < 1e-15);
            assert!((space.encode_channel(1.0) - 1.0).abs() < 1e-14);
        }
    }

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
