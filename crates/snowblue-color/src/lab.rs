//! CIELAB 1976: a colour space in which distances are roughly perceptual.
//!
//! L* = 116 f(Y/Yₙ) − 16, a* = 500 (f(X/Xₙ) − f(Y/Yₙ)), b* = 200 (f(Y/Yₙ) − f(Z/Zₙ)), with f the cube root above
//! (6/29)³ and its tangent below (CIE 015:2018; ISO/CIE 11664-4:2019).

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
}
