//! How much two lights differ: as they are, and in hue and chroma alone.
//!
//! Light through snow is dim, and CIELAB tells dim colours hardly apart; an eye that has adapted, or an exposure, tells
//! them apart again. So the difference is also taken with both lights brought to one luminance.

use crate::lab::Lab;
use crate::xyz::Xyz;

/// Luminance of middle grey, where L* = 50.
pub const MIDDLE_GREY: f64 = 0.184_186_5;

/// ΔE*ab of two lights before the same white, and once CIEDE2000.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// As they are.
    pub whole: f64,
    /// The first brought to the luminance of the second.
    pub at_equal_luminance: f64,
    /// Both brought to L* = 50, as by an exposure: hue and chroma.
    pub at_middle_grey: f64,
    /// The same by CIEDE2000.
    pub at_middle_grey_2000: f64,
}

impl Difference {
    /// That of darkness, which has no colour to compare.
    pub const INFINITE: Self = Self {
        whole: f64::INFINITY,
        at_equal_luminance: f64::INFINITY,
        at_middle_grey: f64::INFINITY,
        at_middle_grey_2000: f64::INFINITY,
    };

    /// The difference of one light from another, neither of which is dark.
    ///
    /// A grey filter changes no hue:
    /// ```
    /// # use snowblue_color::{Difference, Xyz};
    /// let white = Xyz { x: 0.95, y: 1.0, z: 1.09 };
    /// let blue = Xyz { x: 0.2, y: 0.25, z: 0.6 };
    /// let filtered = Difference::between(blue * 0.5, blue, white);
    /// assert!(filtered.whole > 10.0 && filtered.at_middle_grey < 1e-9);
    /// ```
    #[must_use]
    pub fn between(one: Xyz, other: Xyz, white: Xyz) -> Self {
        let lab = |xyz: Xyz| Lab::from_xyz(xyz, white);
        let (one_grey, other_grey) = (lab(exposed(one, MIDDLE_GREY)), lab(exposed(other, MIDDLE_GREY)));
        Self {
            whole: lab(one).delta_e_1976(lab(other)),
            at_equal_luminance: lab(exposed(one, other.y)).delta_e_1976(lab(other)),
            at_middle_grey: one_grey.delta_e_1976(other_grey),
            at_middle_grey_2000: one_grey.delta_e_2000(other_grey),
        }
    }
}

/// A light brought to a luminance.
#[must_use]
pub fn exposed(light: Xyz, luminance: f64) -> Xyz {
    light * (luminance / light.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Xyz = Xyz { x: 0.9, y: 1.0, z: 1.2 };

    #[test]
    fn middle_grey_is_half_way() {
        assert!((Lab::from_xyz(WHITE * MIDDLE_GREY, WHITE).l - 50.0).abs() < 1e-4);
    }

    #[test]
    fn dim_lights_differ_less_than_exposed_ones() {
        let dim = [Xyz { x: 0.004, y: 0.005, z: 0.012 }, Xyz { x: 0.004, y: 0.005, z: 0.016 }];
        let found = Difference::between(dim[0], dim[1], WHITE);
        assert!((found.whole - found.at_equal_luminance).abs() < 1e-12);
        assert!(found.at_middle_grey > 2.0 * found.whole, "{found:?}");
    }
}
