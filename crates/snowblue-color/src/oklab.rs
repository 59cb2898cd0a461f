//! Oklab: a colour space in which lines of constant hue also look constant for blues.
//!
//! (l, m, s) = M₁ XYZ, (L, a, b) = M₂ (∛l, ∛m, ∛s) (B. Ottosson 2020, *A perceptual color space for image processing*,
//! <https://bottosson.github.io/posts/oklab/>). In linear RGB and in CIELAB, mixing blue with white shifts it towards
//! purple (the Abney effect); M₁ and M₂ were fitted to avoid this.
//!
//! The rows of the published M₁ are scaled by less than 5·10⁻⁴, so that the white of sRGB has L = 1, a = b = 0 up to
//! the rounding of M₂, 10⁻⁷.

use crate::matrix::{Matrix, inverse, multiply, product};
use crate::rgb::RgbSpace;
use crate::xyz::Xyz;

const PUBLISHED_XYZ_TO_CONES: Matrix = [
    [0.818_933_010_1, 0.361_866_742_4, -0.128_859_713_7],
    [0.032_984_543_6, 0.929_311_871_5, 0.036_145_638_7],
    [0.048_200_301_8, 0.264_366_269_1, 0.633_851_707_0],
];
/// From the cube roots of (l, m, s) to (L, a, b).
pub(crate) const ROOTS_TO_LAB: Matrix = [
    [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
    [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
    [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
];
/// From XYZ to (l, m, s), which is (1, 1, 1) for the white of sRGB.
pub(crate) const XYZ_TO_CONES: Matrix = xyz_to_cones();
const CONES_TO_XYZ: Matrix = inverse(XYZ_TO_CONES);
const LAB_TO_ROOTS: Matrix = inverse(ROOTS_TO_LAB);

/// A colour relative to the white of a screen, D65.
///
/// Scaling light by k scales L, a and b by ∛k, so hue and the ratio of chroma to lightness do not change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oklab {
    /// Lightness L: 0 is black, 1 is the white of sRGB.
    pub l: f64,
    /// a: green (below 0) to red.
    pub a: f64,
    /// b: blue (below 0) to yellow.
    pub b: f64,
}

impl Oklab {
    /// The colour of tristimulus values of the 2° observer, adapted to D65.
    pub fn from_xyz(xyz: Xyz) -> Oklab {
        let roots = product(XYZ_TO_CONES, [xyz.x, xyz.y, xyz.z]).map(f64::cbrt);
        let [l, a, b] = product(ROOTS_TO_LAB, roots);
        Oklab { l, a, b }
    }

    /// The tristimulus values, with Y = 1 for the white of sRGB.
    pub fn xyz(self) -> Xyz {
        let cones = product(LAB_TO_ROOTS, [self.l, self.a, self.b]).map(|root| root * root * root);
        let [x, y, z] = product(CONES_TO_XYZ, cones);
        Xyz { x, y, z }
    }

    /// Chroma, the distance from grey.
    pub fn chroma(self) -> f64 {
        self.a.hypot(self.b)
    }

    /// Hue angle in degrees, 0–360: about 30 red, 110 yellow, 140 green, 265 blue. Arbitrary for grey.
    pub fn hue_deg(self) -> f64 {
        self.b.atan2(self.a).to_degrees().rem_euclid(360.0)
    }
}

const fn xyz_to_cones() -> Matrix {
    let white = RgbSpace::Srgb.white();
    let [l, m, s] = product(PUBLISHED_XYZ_TO_CONES, [white.x, white.y, white.z]);
    let [row_l, row_m, row_s] = PUBLISHED_XYZ_TO_CONES;
    [multiply(row_l, [1.0 / l; 3]), multiply(row_m, [1.0 / m; 3]), multiply(row_s, [1.0 / s; 3])]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of Ottosson (2020), to three digits.
    #[test]
    fn published_examples_are_met() {
        for (xyz, lab) in [
            ([0.950, 1.000, 1.089], [1.000, 0.000, 0.000]),
            ([1.000, 0.000, 0.000], [0.450, 1.236, -0.019]),
            ([0.000, 1.000, 0.000], [0.922, -0.671, 0.263]),
            ([0.000, 0.000, 1.000], [0.153, -1.415, -0.449]),
        ] {
            let [x, y, z] = xyz;
            let Oklab { l, a, b } = Oklab::from_xyz(Xyz { x, y, z });
            for (found, expected) in [l, a, b].iter().zip(lab) {
                // Half the last digit; and scaling M₁ changes roots by a third of 5·10⁻⁴, times factors up to 2.4.
                assert!((found - expected).abs() < 5e-4 + 4e-4, "{xyz:?}: {found}, expected {expected}");
            }
        }
    }

    #[test]
    fn white_is_one_and_colours_return() {
        let white = Oklab::from_xyz(RgbSpace::Srgb.white());
        assert!((white.l - 1.0).abs() < 2e-7 && white.chroma() < 2e-7, "{white:?}");
        for xyz in [[0.2, 0.3, 0.9], [0.9, 0.5, 0.01], [1e-6, 2e-6, 3e-6], [0.4, 0.2, 0.0]] {
            let [x, y, z] = xyz;
            let back = Oklab::from_xyz(Xyz { x, y, z }).xyz();
            for (found, expected) in [back.x, back.y, back.z].iter().zip(xyz) {
                assert!((found - expected).abs() < 1e-14 + 1e-13 * y, "{xyz:?}: {back:?}");
            }
        }
    }
}
