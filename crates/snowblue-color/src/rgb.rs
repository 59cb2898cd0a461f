//! Linear sRGB, the light of a screen, and how colours are brought into its gamut.
//!
//! IEC 61966-2-1:1999. The matrix is not the standard's, which is rounded to four digits, but follows from its primaries
//! and white: with the primaries' (x, y, z)/y as the columns of P, white W = P s fixes the scales s, and
//! XYZ = P diag(s) RGB (SMPTE RP 177:1993).

use crate::xyz::{Chromaticity, Xyz};

type Matrix = [[f64; 3]; 3];

/// Red, green and blue of sRGB (the primaries of ITU-R BT.709).
const PRIMARIES: [Chromaticity; 3] =
    [Chromaticity { x: 0.64, y: 0.33 }, Chromaticity { x: 0.30, y: 0.60 }, Chromaticity { x: 0.15, y: 0.06 }];
/// D65 as sRGB defines it.
const WHITE: Chromaticity = Chromaticity { x: 0.3127, y: 0.3290 };
const RGB_TO_XYZ: Matrix = rgb_to_xyz();
const XYZ_TO_RGB: Matrix = inverse(RGB_TO_XYZ);

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

impl LinearRgb {
    /// The mixture of primaries with these tristimulus values; channels below 0 lie outside the gamut.
    pub fn from_xyz(xyz: Xyz) -> LinearRgb {
        let [r, g, b] = product(XYZ_TO_RGB, [xyz.x, xyz.y, xyz.z]);
        LinearRgb { r, g, b }
    }

    /// The tristimulus values.
    pub fn xyz(self) -> Xyz {
        let [x, y, z] = product(RGB_TO_XYZ, [self.r, self.g, self.b]);
        Xyz { x, y, z }
    }

    /// Luminance Y, 1 for the screen's white.
    pub fn luminance(self) -> f64 {
        self.xyz().y
    }

    /// The nearest colour on the way to grey that a screen can show.
    ///
    /// A saturated colour has channels below 0. It moves along the straight line in linear RGB towards the grey of the
    /// same luminance, until its lowest channel is 0: luminance and the direction of the hue stay, only saturation is
    /// lost. A colour without a negative channel stays as it is, also one above 1, which is a matter of exposure. A
    /// colour without positive luminance, which no light has, becomes black.
    ///
    /// Deep water and snow are too blue for a screen; their luminance is kept:
    /// ```
    /// # use snowblue_color::{LinearRgb, Observer};
    /// let deep_blue = LinearRgb::from_xyz(Observer::Cie1931.matching(470.0)?);
    /// assert!(deep_blue.r < 0.0);
    /// let shown = deep_blue.into_gamut();
    /// assert!(shown.r >= 0.0 && shown.g >= 0.0 && shown.b > shown.g);
    /// assert!((shown.luminance() / deep_blue.luminance() - 1.0).abs() < 1e-12);
    /// # Ok::<(), snowblue_color::ColorError>(())
    /// ```
    #[must_use]
    pub fn into_gamut(self) -> LinearRgb {
        let lowest = self.r.min(self.g).min(self.b);
        if lowest >= 0.0 {
            return self;
        }
        let grey = self.luminance();
        if grey <= 0.0 {
            return LinearRgb::default();
        }
        let saturation = grey / (grey - lowest);
        // Rounding may leave the lowest channel just below 0.
        let move_to_grey = |channel: f64| (grey + saturation * (channel - grey)).max(0.0);
        LinearRgb { r: move_to_grey(self.r), g: move_to_grey(self.g), b: move_to_grey(self.b) }
    }
}

const fn rgb_to_xyz() -> Matrix {
    let [red, green, blue] = [of_luminance_1(PRIMARIES[0]), of_luminance_1(PRIMARIES[1]), of_luminance_1(PRIMARIES[2])];
    let primaries = [[red[0], green[0], blue[0]], [red[1], green[1], blue[1]], [red[2], green[2], blue[2]]];
    let scales = product(inverse(primaries), of_luminance_1(WHITE));
    let [x, y, z] = primaries;
    [multiply(x, scales), multiply(y, scales), multiply(z, scales)]
}

/// (x, y, 1 − x − y)/y.
const fn of_luminance_1(Chromaticity { x, y }: Chromaticity) -> [f64; 3] {
    [x / y, 1.0, (1.0 - x - y) / y]
}

const fn multiply(left: [f64; 3], right: [f64; 3]) -> [f64; 3] {
    [left[0] * right[0], left[1] * right[1], left[2] * right[2]]
}

const fn dot(left: [f64; 3], right: [f64; 3]) -> f64 {
    left[0] * right[0] + left[1] * right[1] + left[2] * right[2]
}

const fn cross(left: [f64; 3], right: [f64; 3]) -> [f64; 3] {
    [
        left[1] * right[2] - left[2] * right[1],
        left[2] * right[0] - left[0] * right[2],
        left[0] * right[1] - left[1] * right[0],
    ]
}

const fn product(matrix: Matrix, vector: [f64; 3]) -> [f64; 3] {
    [dot(matrix[0], vector), dot(matrix[1], vector), dot(matrix[2], vector)]
}

/// Its columns are the cross products of the rows, over the determinant.
const fn inverse([first, second, third]: Matrix) -> Matrix {
    let [a, b, c] = [cross(second, third), cross(third, first), cross(first, second)];
    let determinant = dot(first, a);
    [
        [a[0] / determinant, b[0] / determinant, c[0] / determinant],
        [a[1] / determinant, b[1] / determinant, c[1] / determinant],
        [a[2] / determinant, b[2] / determinant, c[2] / determinant],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rgb(r: f64, g: f64, b: f64) -> LinearRgb {
        LinearRgb { r, g, b }
    }

    fn assert_chromaticity(colour: LinearRgb, expected: Chromaticity) {
        let found = colour.xyz().chromaticity();
        assert!((found.x - expected.x).abs() < 1e-15, "{found:?}");
        assert!((found.y - expected.y).abs() < 1e-15, "{found:?}");
    }

    #[test]
    fn there_and_back_is_the_same_colour() {
        let back = LinearRgb::from_xyz(rgb(0.1, -0.2, 3.0).xyz());
        let differences = [back.r - 0.1, back.g + 0.2, back.b - 3.0];
        assert!(differences.iter().all(|difference| difference.abs() < 1e-14), "{back:?}");
    }

    #[test]
    fn white_is_d65_and_primaries_are_themselves() {
        assert_chromaticity(rgb(1.0, 1.0, 1.0), WHITE);
        assert_chromaticity(rgb(0.5, 0.0, 0.0), PRIMARIES[0]);
        assert_chromaticity(rgb(0.0, 0.5, 0.0), PRIMARIES[1]);
        assert_chromaticity(rgb(0.0, 0.0, 0.5), PRIMARIES[2]);
        assert!((rgb(1.0, 1.0, 1.0).luminance() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn gamut_mapping_keeps_luminance_and_hue() {
        let colour = rgb(-0.3, 0.2, 0.9);
        let shown = colour.into_gamut();
        assert!(shown.r >= 0.0 && shown.r < 1e-16, "{shown:?}");
        assert!(shown.g > 0.0 && shown.b < colour.b, "{shown:?}");
        assert!((shown.luminance() - colour.luminance()).abs() < 1e-15);
        // The hue: the ratio of the distances between channels.
        let hue = |colour: LinearRgb| (colour.g - colour.r) / (colour.b - colour.r);
        assert!((hue(shown) - hue(colour)).abs() < 1e-14);
    }

    #[test]
    fn gamut_mapping_leaves_what_a_screen_can_show() {
        let bright = rgb(0.0, 0.5, 2.0);
        assert_eq!(bright.into_gamut(), bright);
    }

    #[test]
    fn negative_luminance_becomes_black() {
        assert_eq!(rgb(-1.0, 0.0, 0.1).into_gamut(), LinearRgb::default());
    }
}
