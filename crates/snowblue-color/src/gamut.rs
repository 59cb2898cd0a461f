//! Gamut mapping: replaces colours outside the sRGB gamut by similar colours of equal luminance.
//!
//! The displayable colours of one luminance form a convex polygon in linear RGB. A colour outside is mapped to the
//! point of the polygon's boundary with the least weighted difference in Oklab, (C − C₀)² + (4 H)², where C and H are
//! the components of (a, b) along and across the hue of the colour, and C₀ is its chroma. Clipping to the least
//! difference with a low weight for chroma follows N. Katoh & M. Ito 1996, *Gamut mapping for computer generated
//! images (II)*, Proc. 4th Color Imaging Conference, 126, doi:10.2352/CIC.1996.4.1.art00034, who work in CIELAB.
//! Unlike Katoh & Ito, we keep the luminance, since luminance is the computed quantity, and the weight is our choice.
//! CSS Color Module Level 4, section 13, differs: it reduces chroma at constant Oklab hue and lightness until a clip
//! is close enough.
//!
//! The search is a Gauss–Newton iteration. It starts where the straight line to grey enters the gamut, linearises Oklab
//! around the current estimate, and moves to the nearest point of the polygon, which is exact on straight edges. The
//! nearest point of a convex set is a continuous function of the colour, and so is the result of a fixed number of
//! steps.
//!
//! **Why the hue may shift.** Next to the blue primary the gamut boundary runs nearly along a line of constant hue. A
//! mapping with exact hue is discontinuous there: a light just outside `#0000ff` would lose half of its chroma. With
//! weight 4 the hue of daylight through 1–100 cm of snow shifts by at most 5° in Oklab and 6° in IPT, compared to 8°
//! and 14° on the straight line to grey, and the distance of neighbouring lights grows by at most a factor of 10
//! (`tests/it/gamut.rs`).

use crate::matrix::{Matrix, Vector, compose, dot, multiply, product, transpose};
use crate::oklab::{ROOTS_TO_LAB, XYZ_TO_CONES};
use crate::rgb::{LinearRgb, RgbSpace, rgb_to_xyz};

/// Luminances of the primaries, which sum to 1.
pub(crate) const PRIMARY_LUMINANCES: Vector = rgb_to_xyz(RgbSpace::Srgb)[1];
/// From the luminances of the red, green and blue components of a colour to cone responses.
const COMPONENTS_TO_CONES: Matrix = transpose(CONE_SLOPES);
/// Derivatives of the cone responses by the luminance of the red component (first row), of green and of blue.
pub(crate) const CONE_SLOPES: Matrix = cone_slopes();

/// Weight of a hue shift relative to an equal loss of chroma. A larger weight preserves hue better, but separates
/// neighbours more: 2 shifts the hue of deep snow by 9° and separates lights by a factor of 3, 10 shifts it by 1° and
/// separates by 30.
pub(crate) const HUE_WEIGHT: f64 = 4.0;

/// Number of Gauss–Newton steps. A third step changes the chroma of light through snow by less than 1 %.
pub(crate) const STEPS: usize = 2;

impl LinearRgb {
    /// The nearest colour without negative channels. Luminance is kept, and hue nearly.
    ///
    /// Colours without a negative channel do not change, even with channels above 1, which are a matter of exposure.
    /// Scaling the input scales the result. A colour without positive luminance becomes black; light always has
    /// positive luminance.
    ///
    /// The blue of deep water and snow is outside the sRGB gamut:
    /// ```
    /// # use snowblue_color::{LinearRgb, Oklab, Xyz};
    /// let deep_blue = LinearRgb::from_xyz(Xyz { x: 0.0011, y: 0.00105, z: 0.00494 });
    /// assert!(deep_blue.r < 0.0);
    /// let mapped = deep_blue.into_gamut();
    /// assert!(mapped.r >= 0.0 && mapped.g >= 0.0 && mapped.b > mapped.g);
    /// assert!((mapped.luminance() / deep_blue.luminance() - 1.0).abs() < 1e-12);
    /// let hue_deg = |colour: LinearRgb| Oklab::from_xyz(colour.xyz()).hue_deg();
    /// assert!((hue_deg(mapped) - hue_deg(deep_blue)).abs() < 3.0);
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
        map_to_gamut(self, luminance, f64::INFINITY)
    }

    /// The nearest displayable colour, with all channels in 0–1. Luminance is kept, and hue nearly.
    ///
    /// Displayable colours do not change. Luminance 1 and above becomes white, a luminance of 0 and below black.
    ///
    /// No displayable blue is half as bright as white, so bright blue light becomes pale:
    /// ```
    /// # use snowblue_color::LinearRgb;
    /// let blue = LinearRgb { r: 0.0, g: 0.2, b: 0.5 }.displayable();
    /// let bright = LinearRgb { r: 0.0, g: 0.6, b: 1.5 }.displayable();
    /// assert!(blue.r < 1e-9 && bright.r > 0.2 && bright.b <= 1.0);
    /// ```
    #[must_use]
    pub fn displayable(self) -> LinearRgb {
        let in_range = |channel: f64| (0.0..=1.0).contains(&channel);
        if in_range(self.r) && in_range(self.g) && in_range(self.b) {
            return self;
        }
        let luminance = self.luminance();
        if luminance <= 0.0 {
            return LinearRgb::default();
        }
        if luminance >= 1.0 {
            return LinearRgb { r: 1.0, g: 1.0, b: 1.0 };
        }
        let LinearRgb { r, g, b } = map_to_gamut(self, luminance, 1.0 / luminance);
        // Rounding may leave a channel just above 1.
        LinearRgb { r: r.min(1.0), g: g.min(1.0), b: b.min(1.0) }
    }
}

/// The nearest colour with channels from 0 to `greatest` times its luminance.
fn map_to_gamut(colour: LinearRgb, luminance: f64, greatest: f64) -> LinearRgb {
    // The search runs at luminance 1, so that dim light does not underflow.
    let components =
        multiply([colour.r, colour.g, colour.b], PRIMARY_LUMINANCES).map(|component| component / luminance);
    let mapped = nearest_in_gamut(components, PRIMARY_LUMINANCES.map(|primary| primary * greatest));
    let [r, g, b] = [0, 1, 2].map(|channel| mapped[channel] / PRIMARY_LUMINANCES[channel]);
    LinearRgb { r, g, b } * luminance
}

/// Maps a colour outside the gamut. Colours are luminances of their red, green and blue components, which sum to 1;
/// inside the gamut they lie between 0 and `limits`.
fn nearest_in_gamut(colour: Vector, limits: Vector) -> Vector {
    let wanted = cone_roots(colour);
    let weights = chroma_and_hue_weights(wanted);
    let mut mapped = desaturated(colour, limits);
    for _ in 0..STEPS {
        let roots = cone_roots(mapped);
        let root_slopes = roots.map(|root| 1.0 / (3.0 * root * root));
        let slopes = weights.map(|row| product(CONE_SLOPES, multiply(row, root_slopes)));
        let target = [0, 1].map(|row| dot(weights[row], wanted) - dot(weights[row], roots) + dot(slopes[row], mapped));
        mapped = nearest_on_boundary(slopes, target, limits);
    }
    mapped
}

/// Cube roots of the cone responses, which are positive inside the gamut.
fn cone_roots(colour: Vector) -> Vector {
    product(COMPONENTS_TO_CONES, colour).map(f64::cbrt)
}

/// Weights of the cube roots in the chroma of a colour (first row) and in the weighted hue shift from it (second row).
fn chroma_and_hue_weights(roots: Vector) -> [Vector; 2] {
    let [_, to_a, to_b] = ROOTS_TO_LAB;
    let (a, b) = (dot(to_a, roots), dot(to_b, roots));
    let chroma = a.hypot(b);
    let (cos, sin) = (a / chroma, b / chroma);
    let sum = |a_weight: f64, b_weight: f64| [0, 1, 2].map(|cone| a_weight * to_a[cone] + b_weight * to_b[cone]);
    [sum(cos, sin), sum(-HUE_WEIGHT * sin, HUE_WEIGHT * cos)]
}

/// The point where the straight line from a colour to grey enters the gamut.
fn desaturated(colour: Vector, limits: Vector) -> Vector {
    let mut fraction: f64 = 1.0;
    for ((component, grey), limit) in colour.into_iter().zip(PRIMARY_LUMINANCES).zip(limits) {
        if component < 0.0 {
            fraction = fraction.min(grey / (grey - component));
        } else if component > limit {
            fraction = fraction.min((limit - grey) / (component - grey));
        }
    }
    // Rounding may leave a component just below 0.
    [0, 1, 2].map(|channel| {
        let grey = PRIMARY_LUMINANCES[channel];
        (grey + fraction * (colour[channel] - grey)).max(0.0)
    })
}

/// The point x of the gamut boundary that minimises the distance of (slopes · x) to `target`.
fn nearest_on_boundary(slopes: [Vector; 2], target: [f64; 2], limits: Vector) -> Vector {
    let mut least_distance = f64::INFINITY;
    let mut nearest = [0.0; 3];
    for (fixed, level) in [(0, 0.0), (1, 0.0), (2, 0.0), (0, limits[0]), (1, limits[1]), (2, limits[2])] {
        // On an edge of the polygon one component is fixed, one varies, and the third is the remaining luminance.
        let (varying, remaining) = ((fixed + 1) % 3, (fixed + 2) % 3);
        let rest = 1.0 - level;
        let (from, to) = ((rest - limits[remaining]).max(0.0), rest.min(limits[varying]));
        if from > to {
            continue;
        }
        let offset = [0, 1].map(|row| target[row] - slopes[row][fixed] * level - slopes[row][remaining] * rest);
        let step = slopes.map(|slope| slope[varying] - slope[remaining]);
        let along = (offset[0] * step[0] + offset[1] * step[1]) / (step[0] * step[0] + step[1] * step[1]);
        let along = along.clamp(from, to);
        let residual = [offset[0] - along * step[0], offset[1] - along * step[1]];
        let distance = residual[0] * residual[0] + residual[1] * residual[1];
        if distance < least_distance {
            least_distance = distance;
            (nearest[fixed], nearest[varying], nearest[remaining]) = (level, along, rest - along);
        }
    }
    nearest
}

const fn cone_slopes() -> Matrix {
    let [red, green, blue] = transpose(compose(XYZ_TO_CONES, rgb_to_xyz(RgbSpace::Srgb)));
    let [red_luminance, green_luminance, blue_luminance] = PRIMARY_LUMINANCES;
    [
        multiply(red, [1.0 / red_luminance; 3]),
        multiply(green, [1.0 / green_luminance; 3]),
        multiply(blue, [1.0 / blue_luminance; 3]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rgb(r: f64, g: f64, b: f64) -> LinearRgb {
        LinearRgb { r, g, b }
    }

    #[test]
    fn displayable_colours_do_not_change() {
        for colour in [rgb(0.0, 0.0, 0.0), rgb(1.0, 1.0, 1.0), rgb(0.0, 0.5, 1.0), rgb(0.2, 0.3, 0.1)] {
            assert_eq!(colour.into_gamut(), colour);
            assert_eq!(colour.displayable(), colour);
        }
        let bright = rgb(0.0, 0.5, 2.0);
        assert_eq!(bright.into_gamut(), bright);
    }

    #[test]
    fn zero_luminance_becomes_black_and_high_luminance_white() {
        for colour in [rgb(-1.0, 0.0, 0.1), rgb(-1e-300, 0.0, 0.0)] {
            assert_eq!(colour.into_gamut(), LinearRgb::default());
            assert_eq!(colour.displayable(), LinearRgb::default());
        }
        assert_eq!(rgb(1.0, 1.2, 9.0).displayable(), rgb(1.0, 1.0, 1.0));
        // Positive luminance with negative cone responses, which no light has.
        let LinearRgb { r, g, b } = rgb(1.0, 0.1, -9.0).into_gamut();
        assert!(r >= 0.0 && g >= 0.0 && b >= 0.0, "{r} {g} {b}");
    }

    #[test]
    fn mapping_commutes_with_exposure() {
        let dim = rgb(-0.003, 0.002, 0.009);
        let bright = rgb(-0.3, 0.2, 0.9);
        let (dim, bright) = (dim.into_gamut(), bright.into_gamut());
        for (dim, bright) in [(dim.r, bright.r), (dim.g, bright.g), (dim.b, bright.b)] {
            assert!((100.0 * dim - bright).abs() < 1e-11, "{dim} {bright}");
        }
    }
}
