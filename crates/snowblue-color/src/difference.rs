//! Colour differences: as given, and at equal luminance.
//!
//! Light transmitted by snow is dim, and CIELAB differences of dim colours are small. After visual adaptation or an
//! exposure the same lights are easy to distinguish. The difference is therefore also computed at a common luminance.

use crate::lab::Lab;
use crate::xyz::Xyz;

/// Luminance of middle grey, where L* = 50.
pub const MIDDLE_GREY: f64 = 0.184_186_5;

/// Differences of two lights relative to the same white: ΔE*ab, and once CIEDE2000.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColorDifference {
    /// ΔE*ab of the lights as given.
    pub as_given: f64,
    /// ΔE*ab with the first light scaled to the luminance of the second.
    pub at_equal_luminance: f64,
    /// ΔE*ab with both lights scaled to L* = 50: the difference in hue and chroma.
    pub at_middle_grey: f64,
    /// CIEDE2000 with both lights scaled to L* = 50.
    pub at_middle_grey_2000: f64,
}

impl ColorDifference {
    /// Difference from a black light, which has no chromaticity.
    pub const INFINITE: Self = Self {
        as_given: f64::INFINITY,
        at_equal_luminance: f64::INFINITY,
        at_middle_grey: f64::INFINITY,
        at_middle_grey_2000: f64::INFINITY,
    };

    /// Difference of two lights, neither of which is black.
    ///
    /// A neutral filter does not change the hue:
    /// ```
    /// # use snowblue_color::{ColorDifference, Xyz};
    /// let white = Xyz { x: 0.95, y: 1.0, z: 1.09 };
    /// let blue = Xyz { x: 0.2, y: 0.25, z: 0.6 };
    /// let filtered = ColorDifference::between(blue * 0.5, blue, white);
    /// assert!(filtered.as_given > 10.0 && filtered.at_middle_grey < 1e-9);
    /// ```
    #[must_use]
    pub fn between(first: Xyz, second: Xyz, white: Xyz) -> Self {
        let lab = |xyz: Xyz| Lab::from_xyz(xyz, white);
        let [first_grey, second_grey] = [first, second].map(|light| lab(light.with_luminance(MIDDLE_GREY)));
        Self {
            as_given: lab(first).delta_e_1976(lab(second)),
            at_equal_luminance: lab(first.with_luminance(second.y)).delta_e_1976(lab(second)),
            at_middle_grey: first_grey.delta_e_1976(second_grey),
            at_middle_grey_2000: first_grey.delta_e_2000(second_grey),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Xyz = Xyz { x: 0.9, y: 1.0, z: 1.2 };

    #[test]
    fn middle_grey_has_half_the_lightness_of_white() {
        assert!((Lab::from_xyz(WHITE * MIDDLE_GREY, WHITE).l - 50.0).abs() < 1e-4);
    }

    #[test]
    fn dim_lights_differ_less_than_exposed_ones() {
        let dim = [Xyz { x: 0.004, y: 0.005, z: 0.012 }, Xyz { x: 0.004, y: 0.005, z: 0.016 }];
        let found = ColorDifference::between(dim[0], dim[1], WHITE);
        assert!((found.as_given - found.at_equal_luminance).abs() < 1e-12);
        assert!(found.at_middle_grey > 2.0 * found.as_given, "{found:?}");
    }
}
