//! Colours that a screen cannot show become the nearest ones of the same luminance that it can.
//!
//! The colours of one luminance that a screen can show are a convex polygon in linear RGB. Of its border a colour gets
//! the point with the least weighted difference in Oklab, (C − C₀)² + (4 H)², where C and H are the parts of (a, b) along
//! and across the hue of the colour, and C₀ is its chroma. To clip to the least difference, with chroma counting least, is
//! the way of N. Katoh & M. Ito 1996, *Gamut mapping for computer generated images (II)*, Proc. 4th Color Imaging
//! Conference, 126, doi:10.2352/CIC.1996.4.1.art00034, in CIELAB. Other than there, the luminance is held, since that is
//! what was computed, and the weight is our own choice. CSS Color Module Level 4, section 13, goes another way: it
//! reduces chroma at constant hue and lightness of Oklab, up to a clip that is close enough.
//!
//! The search is of the kind of Gauss and Newton: it starts on the straight way to grey, takes Oklab as linear about the
//! best place so far, and goes to the nearest point of the polygon, which is exact on straight edges. The nearest point
//! of a convex set moves continuously, and so does the outcome after a fixed number of steps.
//!
//! **Why hue may turn.** Beside the blue primary the border runs nearly along a line of constant hue. Who holds the hue
//! exactly has to jump there: a light just outside of `#0000ff` would lose half of its chroma. Weight 4 turns the hue of
//! daylight through 1–100 cm of snow by at most 5° in Oklab and 6° in IPT, against 8° and 14° on the straight way to grey,
//! and spreads no neighbouring lights by more than a factor of 10 (`tests/gamut.rs`).

use crate::matrix::{Matrix, Vector, compose, dot, multiply, product, transpose};
use crate::oklab::{ROOTS_TO_LAB, XYZ_TO_CONES};
use crate::rgb::{LinearRgb, RgbSpace, rgb_to_xyz};

/// Luminances of the primaries at 1, which sum to 1.
const PRIMARIES: Vector = rgb_to_xyz(RgbSpace::Srgb)[1];
/// From the luminances that a colour has in red, green and blue to the responses of the cones.
const TO_CONES: Matrix = transpose(SLOPES_OF_CONES);
/// How the responses of the cones grow with the luminance in red (first row), green and blue.
const SLOPES_OF_CONES: Matrix = slopes_of_cones();

/// How many times a turn of hue counts as much as an equal loss of chroma. More keeps hues better and spreads neighbours
/// more: 2 turns the light of deep snow by 9° and spreads lights by a factor of 3, 10 turns it by 1° and spreads by 30.
const HUE_WEIGHT: f64 = 4.0;

/// A third step changes the chroma of snow's light by less than 1 %.
const STEPS: usize = 2;

impl LinearRgb {
    /// The nearest colour without negative channels, of the same luminance and nearly the same hue.
    ///
    /// A colour without a negative channel stays as it is, also one above 1, which is a matter of exposure; a light
    /// that is stronger by a factor becomes a colour that is stronger by this factor. A colour without positive
    /// luminance, which no light has, becomes black.
    ///
    /// Deep water and snow are too blue for a screen:
    /// ```
    /// # use snowblue_color::{LinearRgb, Oklab, Xyz};
    /// let deep_blue = LinearRgb::from_xyz(Xyz { x: 0.0011, y: 0.00105, z: 0.00494 });
    /// assert!(deep_blue.r < 0.0);
    /// let shown = deep_blue.into_gamut();
    /// assert!(shown.r >= 0.0 && shown.g >= 0.0 && shown.b > shown.g);
    /// assert!((shown.luminance() / deep_blue.luminance() - 1.0).abs() < 1e-12);
    /// let hue_deg = |colour: LinearRgb| Oklab::from_xyz(colour.xyz()).hue_deg();
    /// assert!((hue_deg(shown) - hue_deg(deep_blue)).abs() < 3.0);
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
        mapped(self, luminance, f64::INFINITY)
    }

    /// The nearest colour that a screen can show, all channels in 0–1, of the same luminance and nearly the same hue.
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
        let LinearRgb { r, g, b } = mapped(self, luminance, 1.0 / luminance);
        // Rounding may leave a channel just above 1.
        LinearRgb { r: r.min(1.0), g: g.min(1.0), b: b.min(1.0) }
    }
}

/// The nearest colour that has no channel below 0 or above `greatest` times its luminance.
fn mapped(colour: LinearRgb, luminance: f64, greatest: f64) -> LinearRgb {
    // The search is about chromaticity: at luminance 1, dim light cannot underflow.
    let parts = multiply([colour.r, colour.g, colour.b], PRIMARIES).map(|part| part / luminance);
    let shown = nearest(parts, PRIMARIES.map(|primary| primary * greatest));
    let [r, g, b] = [0, 1, 2].map(|primary| shown[primary] / PRIMARIES[primary]);
    LinearRgb { r, g, b } * luminance
}

/// The nearest colour that can be shown to a colour that cannot, as luminances in red, green and blue, which sum to 1
/// and lie from 0 to `tops`.
fn nearest(colour: Vector, tops: Vector) -> Vector {
    let wanted = roots(colour);
    let weights = chroma_and_hue(wanted);
    let mut shown = straight(colour, tops);
    for _ in 0..STEPS {
        let here = roots(shown);
        let root_slopes = here.map(|root| 1.0 / (3.0 * root * root));
        let slopes = weights.map(|row| product(SLOPES_OF_CONES, multiply(row, root_slopes)));
        let target =
            [0, 1].map(|part| dot(weights[part], wanted) - dot(weights[part], here) + dot(slopes[part], shown));
        shown = nearest_on_border(slopes, target, tops);
    }
    shown
}

/// Cube roots of the cones' responses, above 0 for all that a screen can show.
fn roots(colour: Vector) -> Vector {
    product(TO_CONES, colour).map(f64::cbrt)
}

/// From cube roots to the parts of (a, b) along and across the hue of a colour, weighted.
fn chroma_and_hue(roots: Vector) -> [Vector; 2] {
    let [_, to_a, to_b] = ROOTS_TO_LAB;
    let (a, b) = (dot(to_a, roots), dot(to_b, roots));
    let chroma = a.hypot(b);
    let (cos, sin) = (a / chroma, b / chroma);
    let sum = |of_a: f64, of_b: f64| [0, 1, 2].map(|cone| of_a * to_a[cone] + of_b * to_b[cone]);
    [sum(cos, sin), sum(-HUE_WEIGHT * sin, HUE_WEIGHT * cos)]
}

/// Where the straight way from a colour to grey enters what can be shown.
fn straight(colour: Vector, tops: Vector) -> Vector {
    let mut share: f64 = 1.0;
    for ((part, grey), top) in colour.into_iter().zip(PRIMARIES).zip(tops) {
        if part < 0.0 {
            share = share.min(grey / (grey - part));
        } else if part > top {
            share = share.min((top - grey) / (part - grey));
        }
    }
    // Rounding may leave a part just below 0.
    [0, 1, 2].map(|part| (PRIMARIES[part] + share * (colour[part] - PRIMARIES[part])).max(0.0))
}

/// The point x of the border with the least distance of (slopes · x) to `target`.
fn nearest_on_border(slopes: [Vector; 2], target: [f64; 2], tops: Vector) -> Vector {
    let mut best = (f64::INFINITY, [0.0; 3]);
    for (fixed, level) in [(0, 0.0), (1, 0.0), (2, 0.0), (0, tops[0]), (1, tops[1]), (2, tops[2])] {
        // Along an edge one part stays, a second runs, and the third is the rest of the luminance.
        let (running, resting) = ((fixed + 1) % 3, (fixed + 2) % 3);
        let rest = 1.0 - level;
        let (from, to) = ((rest - tops[resting]).max(0.0), rest.min(tops[running]));
        if from > to {
            continue;
        }
        let off = [0, 1].map(|row| target[row] - slopes[row][fixed] * level - slopes[row][resting] * rest);
        let step = slopes.map(|slope| slope[running] - slope[resting]);
        let along = (off[0] * step[0] + off[1] * step[1]) / (step[0] * step[0] + step[1] * step[1]);
        let along = along.clamp(from, to);
        let left = [off[0] - along * step[0], off[1] - along * step[1]];
        let distance = left[0] * left[0] + left[1] * left[1];
        if distance < best.0 {
            let mut point = [0.0; 3];
            (point[fixed], point[running], point[resting]) = (level, along, rest - along);
            best = (distance, point);
        }
    }
    best.1
}

const fn slopes_of_cones() -> Matrix {
    let [red, green, blue] = transpose(compose(XYZ_TO_CONES, rgb_to_xyz(RgbSpace::Srgb)));
    let [of_red, of_green, of_blue] = PRIMARIES;
    [multiply(red, [1.0 / of_red; 3]), multiply(green, [1.0 / of_green; 3]), multiply(blue, [1.0 / of_blue; 3])]
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
