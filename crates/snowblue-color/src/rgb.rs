//! Linear RGB: light as a mixture of three primaries.
//!
//! The matrices are not the standards', which are rounded, but follow from the primaries and the white: with the
//! primaries' (x, y, z)/y as the columns of P, white W = P s fixes the scales s, and XYZ = P diag(s) RGB
//! (SMPTE RP 177:1993).

use std::fmt;
use std::ops::Mul;

use crate::matrix::{self, Matrix, Vector, inverse, multiply, product};
use crate::srgb;
use crate::xyz::{Chromaticity, Xyz};

/// D65 as sRGB and Rec. 2020 define it.
const D65: Chromaticity = Chromaticity { x: 0.3127, y: 0.3290 };

/// A set of primaries and its white.
///
/// No conversion adapts the eye: light keeps its tristimulus values, and D65 in [`RgbSpace::AcesCg`], whose white is
/// about D60, is not 1, 1, 1 but a little blue. Where a program expects the white of a scene at 1, 1, 1, adapt the
/// tristimulus values first ([`Xyz::adapted`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RgbSpace {
    /// sRGB, the primaries of Rec. 709 with D65 (IEC 61966-2-1:1999, ITU-R BT.709-6).
    Srgb,
    /// Wide-gamut television with D65 (ITU-R BT.2020-2).
    Rec2020,
    /// The space in which films are rendered: primaries AP1, white about D60 (Academy S-2014-004).
    AcesCg,
}

/// Amounts of the three primaries of an [`RgbSpace`]; they mean nothing without it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rgb {
    /// Red.
    pub r: f64,
    /// Green.
    pub g: f64,
    /// Blue.
    pub b: f64,
}

/// Linear sRGB: proportional to the light of a screen's three primaries; 1, 1, 1 is its white.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LinearRgb {
    /// Red.
    pub r: f64,
    /// Green.
    pub g: f64,
    /// Blue.
    pub b: f64,
}

impl RgbSpace {
    /// Every space there is.
    pub const ALL: [RgbSpace; 3] = [RgbSpace::Srgb, RgbSpace::Rec2020, RgbSpace::AcesCg];

    /// Chromaticities of red, green and blue, in this order.
    pub const fn primaries(self) -> (Chromaticity, Chromaticity, Chromaticity) {
        const fn at(x: f64, y: f64) -> Chromaticity {
            Chromaticity { x, y }
        }
        match self {
            RgbSpace::Srgb => (at(0.64, 0.33), at(0.30, 0.60), at(0.15, 0.06)),
            RgbSpace::Rec2020 => (at(0.708, 0.292), at(0.170, 0.797), at(0.131, 0.046)),
            RgbSpace::AcesCg => (at(0.713, 0.293), at(0.165, 0.830), at(0.128, 0.044)),
        }
    }

    /// The white, 1, 1, 1, with luminance 1.
    pub const fn white(self) -> Xyz {
        let chromaticity = match self {
            RgbSpace::Srgb | RgbSpace::Rec2020 => D65,
            RgbSpace::AcesCg => Chromaticity { x: 0.32168, y: 0.33767 },
        };
        let [x, y, z] = of_luminance_1(chromaticity);
        Xyz { x, y, z }
    }

    /// The mixture of primaries with these tristimulus values; amounts below 0 lie outside the gamut.
    ///
    /// The blue of the deepest snow is too vivid for a screen, but not for wide-gamut television:
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

    /// The tristimulus values of a mixture of these primaries.
    pub fn xyz(self, Rgb { r, g, b }: Rgb) -> Xyz {
        let [x, y, z] = product(RGB_TO_XYZ[self as usize], [r, g, b]);
        Xyz { x, y, z }
    }

    /// Code value of one channel, 0–1, from its linear amount, 0–1.
    ///
    /// By IEC 61966-2-1 for sRGB and by the camera's curve of ITU-R BT.2020-2 (table 4, unrounded constants) for
    /// Rec. 2020. ACEScg is stored linear.
    pub fn encode_channel(self, linear: f64) -> f64 {
        const ALPHA: f64 = 1.099_296_826_809_44;
        const BETA: f64 = 0.018_053_968_510_807;
        match self {
            RgbSpace::Srgb => srgb::encode_channel(linear),
            RgbSpace::Rec2020 if linear < BETA => 4.5 * linear,
            RgbSpace::Rec2020 => ALPHA * linear.powf(0.45) - (ALPHA - 1.0),
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
    /// The mixture of primaries with these tristimulus values; channels below 0 lie outside the gamut.
    pub fn from_xyz(xyz: Xyz) -> LinearRgb {
        let Rgb { r, g, b } = RgbSpace::Srgb.from_xyz(xyz);
        LinearRgb { r, g, b }
    }

    /// The tristimulus values.
    pub fn xyz(self) -> Xyz {
        RgbSpace::Srgb.xyz(Rgb { r: self.r, g: self.g, b: self.b })
    }

    /// Luminance Y, 1 for the screen's white.
    pub fn luminance(self) -> f64 {
        self.xyz().y
    }
}

/// Light made stronger by a factor.
impl Mul<f64> for LinearRgb {
    type Output = LinearRgb;

    fn mul(self, factor: f64) -> LinearRgb {
        LinearRgb { r: self.r * factor, g: self.g * factor, b: self.b * factor }
    }
}

/// One matrix a space, in the order of [`RgbSpace::ALL`].
static RGB_TO_XYZ: [Matrix; 3] =
    [rgb_to_xyz(RgbSpace::Srgb), rgb_to_xyz(RgbSpace::Rec2020), rgb_to_xyz(RgbSpace::AcesCg)];
static XYZ_TO_RGB: [Matrix; 3] =
    [xyz_to_rgb(RgbSpace::Srgb), xyz_to_rgb(RgbSpace::Rec2020), xyz_to_rgb(RgbSpace::AcesCg)];

pub(crate) const fn rgb_to_xyz(space: RgbSpace) -> Matrix {
    let (red, green, blue) = space.primaries();
    let [x, y, z] = matrix::transpose([of_luminance_1(red), of_luminance_1(green), of_luminance_1(blue)]);
    let white = space.white();
    let scales = product(inverse([x, y, z]), [white.x, white.y, white.z]);
    [multiply(x, scales), multiply(y, scales), multiply(z, scales)]
}

pub(crate) const fn xyz_to_rgb(space: RgbSpace) -> Matrix {
    inverse(rgb_to_xyz(space))
}

/// (x, y, 1 − x − y)/y.
const fn of_luminance_1(Chromaticity { x, y }: Chromaticity) -> Vector {
    [x / y, 1.0, (1.0 - x - y) / y]
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
    fn there_and_back_is_the_same_colour() {
        for space in RgbSpace::ALL {
            let back = space.from_xyz(space.xyz(Rgb { r: 0.1, g: -0.2, b: 3.0 }));
            let differences = [back.r - 0.1, back.g + 0.2, back.b - 3.0];
            assert!(differences.iter().all(|difference| difference.abs() < 1e-14), "{space}: {back:?}");
        }
    }

    #[test]
    fn white_and_primaries_are_themselves() {
        for space in RgbSpace::ALL {
            let (red, green, blue) = space.primaries();
            assert_chromaticity(space.xyz(Rgb { r: 0.5, g: 0.0, b: 0.0 }), red);
            assert_chromaticity(space.xyz(Rgb { r: 0.0, g: 0.5, b: 0.0 }), green);
            assert_chromaticity(space.xyz(Rgb { r: 0.0, g: 0.0, b: 0.5 }), blue);
            let white = space.xyz(Rgb { r: 1.0, g: 1.0, b: 1.0 });
            assert_chromaticity(white, space.white().chromaticity());
            assert!((white.y - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn linear_rgb_is_that_of_a_screen() {
        let colour = Xyz { x: 0.3, y: 0.2, z: 0.4 };
        let Rgb { r, g, b } = RgbSpace::Srgb.from_xyz(colour);
        assert_eq!(LinearRgb::from_xyz(colour), LinearRgb { r, g, b });
        assert!((LinearRgb { r, g, b }.luminance() - 0.2).abs() < 1e-15);
    }

    /// BT.2020-2 chooses α and β so that both branches meet, with one slope.
    #[test]
    fn codes_run_from_0_to_1_without_a_step() {
        for space in RgbSpace::ALL {
            assert!(space.encode_channel(0.0).abs() < 1e-15);
            assert!((space.encode_channel(1.0) - 1.0).abs() < 1e-14);
        }
        let joint = 0.018_053_968_510_807;
        let code = |linear: f64| RgbSpace::Rec2020.encode_channel(linear);
        assert!((code(joint) - 4.5 * joint).abs() < 1e-14);
        assert!(((code(joint + 1e-6) - code(joint)) / 1e-6 - 4.5).abs() < 1e-3);
    }
}
