//! Colours that a screen cannot show become colours that it can, of the same hue to the eye and the same luminance.
//!
//! In Oklab a colour loses chroma at constant hue: between its own place, at t = 1, and the grey of its lightness, at
//! t = 0, the cube roots of (l, m, s) are 1 + t d, up to a factor that gives back the luminance. Step by step t shrinks
//! by the cube root of the share that the straight way to grey in linear RGB would keep (chroma is a cube root of light),
//! and what is left after the last step, a trace, goes the straight way. So everything is continuous: the border itself,
//! sought on a line of constant hue, is not, since such lines leave the gamut beside the blue primary by 5·10⁻⁴ of the
//! brightest channel and come back.
//!
//! That chroma alone is reduced, in a space of constant hues, is the way of CSS Color Module Level 4, section 13, and of
//! B. Ottosson 2021, *sRGB gamut clipping*, <https://bottosson.github.io/posts/gamutclipping/>. They hold the lightness of
//! Oklab; here it is the luminance, since that is what was computed.
//!
//! The straight way alone holds the dominant wavelength instead, and hues turn on it: by 7° in Oklab and 4° in IPT for
//! light through 60 cm of snow, against 0.04° and 0.6° on this one (`tests/gamut.rs`).

use crate::matrix::{Matrix, Vector, compose, dot, product};
use crate::oklab::{CONES_TO_XYZ, away_from_grey};
use crate::rgb::{LinearRgb, RgbSpace, xyz_to_rgb};

const CONES_TO_RGB: Matrix = compose(xyz_to_rgb(RgbSpace::Srgb), CONES_TO_XYZ);

/// With so many steps the hue of monochromatic light turns by at most 0.35°, and that of deep snow by 0.04°.
const STEPS: usize = 16;

impl LinearRgb {
    /// A colour without negative channels: the same luminance and hue, and of the chroma as much as a screen has.
    ///
    /// A colour without a negative channel stays as it is, also one above 1, which is a matter of exposure; a light
    /// that is stronger by a factor becomes a colour that is stronger by this factor. A colour without positive
    /// luminance, which no light has, becomes black.
    ///
    /// Deep water and snow are too blue for a screen:
    /// ```
    /// # use snowblue_color::{LinearRgb, Oklab, Observer};
    /// let deep_blue = LinearRgb::from_xyz(Observer::Cie1931.matching(470.0)?);
    /// assert!(deep_blue.r < 0.0);
    /// let shown = deep_blue.into_gamut();
    /// assert!(shown.r >= 0.0 && shown.g >= 0.0 && shown.b > shown.g);
    /// assert!((shown.luminance() / deep_blue.luminance() - 1.0).abs() < 1e-12);
    /// let hue_deg = |colour: LinearRgb| Oklab::from_xyz(colour.xyz()).hue_deg();
    /// assert!((hue_deg(shown) - hue_deg(deep_blue)).abs() < 0.2);
    /// # Ok::<(), snowblue_color::ColorError>(())
    /// ```
    #[must_use]
    pub fn into_gamut(self) -> LinearRgb {
        if self.r >= 0.0 && self.g >= 0.0 && self.b >= 0.0 {
            return self;
        }
        let luminance = self.luminance();
        if luminance <= 0.0 {
            return LinearRgb::default();
        }
        lose_chroma(self, luminance, share_above_0)
    }

    /// A colour that a screen can show, all channels in 0–1: the same luminance and hue, and of the chroma as much as
    /// there is at this luminance.
    ///
    /// What a screen can show stays as it is. Light of luminance 1 and more becomes white, light without positive
    /// luminance black.
    ///
    /// A screen has no blue as light as half of its white, so that bright blue light turns pale:
    /// ```
    /// # use snowblue_color::LinearRgb;
    /// let blue = LinearRgb { r: 0.0, g: 0.2, b: 0.5 }.displayable();
    /// let bright = LinearRgb { r: 0.0, g: 0.6, b: 1.5 }.displayable();
    /// assert!(blue.r < 1e-9 && bright.r > 0.2 && bright.b <= 1.0);
    /// ```
    #[must_use]
    pub fn displayable(self) -> LinearRgb {
        let shown = |channel: f64| (0.0..=1.0).contains(&channel);
        if shown(self.r) && shown(self.g) && shown(self.b) {
            return self;
        }
        let luminance = self.luminance();
        if luminance <= 0.0 {
            return LinearRgb::default();
        }
        if luminance >= 1.0 {
            return LinearRgb { r: 1.0, g: 1.0, b: 1.0 };
        }
        let share = |colour, grey| share_above_0(colour, grey).min(share_below_1(colour, grey));
        let LinearRgb { r, g, b } = lose_chroma(self, luminance, share);
        // Rounding may leave a channel just above 1.
        LinearRgb { r: r.min(1.0), g: g.min(1.0), b: b.min(1.0) }
    }
}

/// Moves a colour towards the grey of its luminance, where `share` tells how much of the straight way from grey to a
/// colour can be shown.
fn lose_chroma(colour: LinearRgb, luminance: f64, share: impl Fn(LinearRgb, f64) -> f64) -> LinearRgb {
    // A colour without lightness, which no light has, has no way but the straight one.
    let Some(direction) = away_from_grey(colour.xyz()) else {
        return straight(colour, luminance, share(colour, luminance));
    };
    let (mut kept, mut moved) = (1.0, colour);
    for _ in 0..STEPS {
        kept *= share(moved, luminance).cbrt();
        moved = of_hue(direction, kept, luminance);
    }
    straight(moved, luminance, share(moved, luminance))
}

/// The colour of a luminance that is a share of the way from grey in a direction of Oklab.
fn of_hue(direction: Vector, share: f64, luminance: f64) -> LinearRgb {
    let cones = direction.map(|step| (1.0 + share * step).powi(3));
    let factor = luminance / dot(CONES_TO_XYZ[1], cones);
    let [r, g, b] = product(CONES_TO_RGB, cones).map(|channel| channel * factor);
    LinearRgb { r, g, b }
}

/// A share of the straight way in linear RGB from a grey to a colour of the same luminance.
fn straight(colour: LinearRgb, grey: f64, share: f64) -> LinearRgb {
    // Rounding may leave the lowest channel just below 0.
    let channel = |value: f64| (grey + share * (value - grey)).max(0.0);
    LinearRgb { r: channel(colour.r), g: channel(colour.g), b: channel(colour.b) }
}

/// How much of the straight way from grey to a colour has no negative channel.
fn share_above_0(colour: LinearRgb, grey: f64) -> f64 {
    let lowest = colour.r.min(colour.g).min(colour.b);
    if lowest >= 0.0 { 1.0 } else { grey / (grey - lowest) }
}

/// How much of the straight way from a grey below 1 to a colour has no channel above 1.
fn share_below_1(colour: LinearRgb, grey: f64) -> f64 {
    let greatest = colour.r.max(colour.g).max(colour.b);
    if greatest <= 1.0 { 1.0 } else { (1.0 - grey) / (greatest - grey) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rgb(r: f64, g: f64, b: f64) -> LinearRgb {
        LinearRgb { r, g, b }
    }

    #[test]
    fn what_a_screen_can_show_stays() {
        for colour in [rgb(0.0, 0.0, 0.0), rgb(1.0, 1.0, 1.0), rgb(0.0, 0.5, 1.0), rgb(0.2, 0.3, 0.1)] {
            assert_eq!(colour.into_gamut(), colour);
            assert_eq!(colour.displayable(), colour);
        }
        let bright = rgb(0.0, 0.5, 2.0);
        assert_eq!(bright.into_gamut(), bright);
    }

    #[test]
    fn no_light_is_black_and_glare_is_white() {
        for colour in [rgb(-1.0, 0.0, 0.1), rgb(-1e-300, 0.0, 0.0)] {
            assert_eq!(colour.into_gamut(), LinearRgb::default());
            assert_eq!(colour.displayable(), LinearRgb::default());
        }
        assert_eq!(rgb(1.0, 1.2, 9.0).displayable(), rgb(1.0, 1.0, 1.0));
        // Luminance without lightness in Oklab: no light has it.
        let LinearRgb { r, g, b } = rgb(1.0, 0.1, -9.0).into_gamut();
        assert!(r >= 0.0 && g >= 0.0 && b >= 0.0, "{r} {g} {b}");
    }

    #[test]
    fn exposure_does_not_change_the_colour() {
        let dim = rgb(-0.003, 0.002, 0.009);
        let bright = rgb(-0.3, 0.2, 0.9);
        let (dim, bright) = (dim.into_gamut(), bright.into_gamut());
        for (dim, bright) in [(dim.r, bright.r), (dim.g, bright.g), (dim.b, bright.b)] {
            assert!((100.0 * dim - bright).abs() < 1e-11, "{dim} {bright}");
        }
    }
}
