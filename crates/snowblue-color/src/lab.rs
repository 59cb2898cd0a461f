//! CIELAB 1976, a colour space in which distances are roughly perceptual, and colour differences of lights as given
//! and at equal luminance.
//!
//! L* = 116 f(Y/Yₙ) − 16, a* = 500 (f(X/Xₙ) − f(Y/Yₙ)), b* = 200 (f(Y/Yₙ) − f(Z/Zₙ)), with f the cube root above
//! (6/29)³ and its tangent below (CIE 015:2018; ISO/CIE 11664-4:2019).
//!
//! Light transmitted by snow is dim, and CIELAB differences of dim colours are small. After visual adaptation or an
//! exposure these lights are easy to distinguish. The difference is therefore also computed at a common luminance.
//!
//! CIEDE2000 is perceptually more uniform than ΔE*ab, mainly for saturated colours and blues: G. Sharma, W. Wu & E. N.
//! Dalal 2005, *The CIEDE2000 color-difference formula: implementation notes, supplementary test data, and mathematical
//! observations*, Color Res. Appl. 30, 21, doi:10.1002/col.20070, equations 2–22; ISO/CIE 11664-6:2022. The parametric
//! factors k_L, k_C and k_H are 1.

use crate::xyz::Xyz;

/// A colour relative to a white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lab {
    /// Lightness L*: 0 black, 100 white.
    pub l: f64,
    /// a*: green (below 0) to red.
    pub a: f64,
    /// b*: blue (below 0) to yellow.
    pub b: f64,
}

impl Lab {
    /// The colour of tristimulus values for an observer adapted to `white`.
    ///
    /// A surface that reflects 18.4 % of the light has half the lightness of white:
    /// ```
    /// # use snowblue_color::{Lab, Xyz};
    /// let white = Xyz { x: 0.95, y: 1.0, z: 1.09 };
    /// assert!((Lab::from_xyz(white * 0.184, white).l - 50.0).abs() < 0.1);
    /// ```
    ///
    /// # Panics
    /// If X, Y or Z of `white` is not above 0. The white of a [`Colorimeter`](crate::Colorimeter) never panics.
    pub fn from_xyz(xyz: Xyz, white: Xyz) -> Lab {
        assert!(white.x > 0.0 && white.y > 0.0 && white.z > 0.0, "{white:?} is no white");
        let (x, y, z) = (compress(xyz.x / white.x), compress(xyz.y / white.y), compress(xyz.z / white.z));
        Lab { l: 116.0 * y - 16.0, a: 500.0 * (x - y), b: 200.0 * (y - z) }
    }

    /// The tristimulus values of this colour under `white`: the inverse of [`from_xyz`](Self::from_xyz).
    pub fn xyz(self, white: Xyz) -> Xyz {
        let y = (self.l + 16.0) / 116.0;
        let (x, z) = (y + self.a / 500.0, y - self.b / 200.0);
        Xyz { x: white.x * expand(x), y: white.y * expand(y), z: white.z * expand(z) }
    }

    /// Chroma C*ab, the distance from grey. Saturated colours have a high chroma.
    pub fn chroma(self) -> f64 {
        self.a.hypot(self.b)
    }

    /// Hue angle h_ab in degrees, in [0, 360): 0 red, 90 yellow, 180 green, 270 blue. 0 for grey.
    pub fn hue_deg(self) -> f64 {
        let hue = self.b.atan2(self.a).to_degrees().rem_euclid(360.0);
        // `rem_euclid` rounds tiny negative angles to 360.
        if hue < 360.0 { hue } else { 0.0 }
    }

    /// CIE 1976 colour difference ΔE*ab, the Euclidean distance. About 2.3 is just noticeable (Mahy, Van Eycken &
    /// Oosterlinck 1994, Color Res. Appl. 19, 105).
    pub fn delta_e_1976(self, other: Lab) -> f64 {
        (self.l - other.l).hypot(self.a - other.a).hypot(self.b - other.b)
    }
}

/// Cube root of the ratio at which f changes from linear to the cube root.
const DELTA: f64 = 6.0 / 29.0;

/// f: the cube root, linear near 0.
fn compress(ratio: f64) -> f64 {
    if ratio > DELTA * DELTA * DELTA { ratio.cbrt() } else { ratio / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
}

/// The inverse of f.
fn expand(compressed: f64) -> f64 {
    if compressed > DELTA { compressed.powi(3) } else { 3.0 * DELTA * DELTA * (compressed - 4.0 / 29.0) }
}

/// Luminance of middle grey, where L* = 50.
pub const MIDDLE_GREY: f64 = 0.184_186_5;

/// Differences of two lights relative to one white: three in ΔE*ab, one in CIEDE2000.
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

    /// Difference of two lights. Neither light is black.
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

/// 25⁷. The scaling of a* fades out above a chroma of 25.
const CHROMA_25_7: f64 = 6_103_515_625.0;

impl Lab {
    /// CIEDE2000 colour difference ΔE₀₀ with k_L = k_C = k_H = 1. Symmetric in both colours.
    ///
    /// A given step in b* counts less between saturated colours:
    /// ```
    /// # use snowblue_color::Lab;
    /// let difference = |b| Lab { l: 50.0, a: 0.0, b }.delta_e_2000(Lab { l: 50.0, a: 0.0, b: b + 3.0 });
    /// assert!(difference(0.0) > 2.0 && difference(-80.0) < 1.0);
    /// ```
    pub fn delta_e_2000(self, other: Lab) -> f64 {
        let mean_chroma = 0.5 * (self.chroma() + other.chroma());
        let a_scale = 1.0 + 0.5 * (1.0 - chroma_ratio(mean_chroma).sqrt());
        let [first, second] = [self, other].map(|lab| Lab { a: a_scale * lab.a, ..lab });
        let (chroma_1, chroma_2) = (first.chroma(), second.chroma());
        let (hue_1, hue_2) = (first.hue_deg(), second.hue_deg());
        let grey = chroma_1 * chroma_2 <= 0.0;

        let hue_angle = if grey { 0.0 } else { hue_difference_deg(hue_1, hue_2) };
        let lightness_step = second.l - first.l;
        let chroma_step = chroma_2 - chroma_1;
        let hue_step = 2.0 * (chroma_1 * chroma_2).sqrt() * (0.5 * hue_angle).to_radians().sin();

        let chroma = 0.5 * (chroma_1 + chroma_2);
        let hue = if grey { hue_1 + hue_2 } else { mean_hue_deg(hue_1, hue_2) };
        let offset_2 = (0.5 * (first.l + second.l) - 50.0).powi(2);
        let lightness_term = lightness_step / (1.0 + 0.015 * offset_2 / (20.0 + offset_2).sqrt());
        let chroma_term = chroma_step / (1.0 + 0.045 * chroma);
        let hue_term = hue_step / (1.0 + 0.015 * chroma * hue_weight(hue));
        let rotation_deg = 60.0 * (-((hue - 275.0) / 25.0).powi(2)).exp();
        let rotation = -2.0 * chroma_ratio(chroma).sqrt() * rotation_deg.to_radians().sin();
        let square = lightness_term.powi(2) + chroma_term.powi(2) + hue_term.powi(2);
        (square + rotation * chroma_term * hue_term).sqrt()
    }
}

/// C⁷/(C⁷ + 25⁷).
fn chroma_ratio(chroma: f64) -> f64 {
    let power = chroma.powi(7);
    power / (power + CHROMA_25_7)
}

/// T of equation 15.
fn hue_weight(hue_deg: f64) -> f64 {
    let cos = |degrees: f64| degrees.to_radians().cos();
    1.0 - 0.17 * cos(hue_deg - 30.0) + 0.24 * cos(2.0 * hue_deg) + 0.32 * cos(3.0 * hue_deg + 6.0)
        - 0.20 * cos(4.0 * hue_deg - 63.0)
}

/// Signed difference of two hue angles, from −180° to 180°.
fn hue_difference_deg(from: f64, to: f64) -> f64 {
    match to - from {
        difference if difference > 180.0 => difference - 360.0,
        difference if difference < -180.0 => difference + 360.0,
        difference => difference,
    }
}

/// Mean hue on the shorter arc.
fn mean_hue_deg(first: f64, second: f64) -> f64 {
    let sum = first + second;
    match (first - second).abs() > 180.0 {
        false => 0.5 * sum,
        true if sum < 360.0 => 0.5 * (sum + 360.0),
        true => 0.5 * (sum - 360.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Xyz = Xyz { x: 0.9, y: 1.0, z: 1.2 };

    #[test]
    fn black_has_lightness_0_and_white_100() {
        assert_eq!(Lab::from_xyz(WHITE, WHITE), Lab { l: 100.0, a: 0.0, b: 0.0 });
        let black = Lab::from_xyz(Xyz::default(), WHITE);
        assert!(black.l.abs() < 1e-13 && black.a.abs() < 1e-13 && black.b.abs() < 1e-13, "{black:?}");
    }

    /// Near black, lightness is 903.3 Y (κ = 24389/27).
    #[test]
    fn dark_colours_are_linear() {
        assert!((Lab::from_xyz(WHITE * 1e-3, WHITE).l - 24389.0 / 27.0 * 1e-3).abs() < 1e-12);
        assert!((Lab::from_xyz(WHITE * 2e-3, WHITE).l - 24389.0 / 27.0 * 2e-3).abs() < 1e-12);
    }

    #[test]
    fn the_two_branches_join_smoothly() {
        let joint: f64 = 216.0 / 24389.0;
        let slope = |from: f64, to: f64| (compress(to) - compress(from)) / (to - from);
        assert!((compress(joint * (1.0 + 1e-12)) - compress(joint * (1.0 - 1e-12))).abs() < 1e-12);
        assert!((slope(joint * 0.999, joint) / slope(joint, joint * 1.001) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn lab_round_trips() {
        for xyz in [Xyz { x: 0.2, y: 0.3, z: 0.9 }, Xyz { x: 0.002, y: 0.001, z: 0.007 }, Xyz::default()] {
            let back = Lab::from_xyz(xyz, WHITE).xyz(WHITE);
            let differences = [back.x - xyz.x, back.y - xyz.y, back.z - xyz.z];
            assert!(differences.iter().all(|difference| difference.abs() < 1e-15), "{back:?}");
        }
    }

    #[test]
    fn chroma_and_hue_are_polar_coordinates() {
        let blue = Lab { l: 50.0, a: 3.0, b: -4.0 };
        assert!((blue.chroma() - 5.0).abs() < 1e-15);
        assert!((blue.hue_deg() - 306.869_897_645_844).abs() < 1e-12);
        assert!((Lab { a: -1.0, b: 0.0, ..blue }.hue_deg() - 180.0).abs() < 1e-12);
        assert!(Lab { a: 0.0, b: 0.0, ..blue }.hue_deg().abs() < 1e-12);
        assert!(Lab { a: 1.0, b: -1e-20, ..blue }.hue_deg().abs() < 1e-12, "an angle just below 0 must not become 360");
    }

    #[test]
    fn difference_is_a_distance() {
        let first = Lab { l: 50.0, a: 2.0, b: -7.0 };
        let second = Lab { l: 52.0, a: 5.0, b: -1.0 };
        assert!((first.delta_e_1976(second) - 7.0).abs() < 1e-14);
        assert!((second.delta_e_1976(first) - 7.0).abs() < 1e-14);
    }

    #[test]
    #[should_panic(expected = "is no white")]
    fn a_white_without_blue_panics() {
        Lab::from_xyz(WHITE, Xyz { z: 0.0, ..WHITE });
    }

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
