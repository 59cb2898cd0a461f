//! Exposure: factors applied to linear light before display, and the level at which a white of some luminance is shown.
//!
//! **White in dim light looks darker than white in the sun.** An adapted eye does not make up for all of the
//! difference. Cones respond to a white of the luminance L, in cd/m², by
//!
//! > A(L) = x / (x + 27.13), x = F^0.42, F = 0.2 k⁴ L + 0.1 (1 − k⁴)² L^(1/3), k = 1 / (L + 1)
//!
//! This is CIECAM02 (CIE 159:2004, *A colour appearance model for colour management systems*), with an adapting
//! luminance of a fifth of white, its usual value. A picture shows white at the level A(L) relative to white in the
//! sun. In daylight the level is about proportional to L^0.14.

use crate::rgb::LinearRgb;

/// Luminance of snow in the sun in cd/m². Sun and sky give level ground some 65 klx at an elevation of the sun of 35°,
/// and steeper slopes as much in a lower sun.
pub const SUNLIT_SNOW_CD_M2: f64 = 20_000.0;

/// The level at which a white of a luminance in cd/m² is shown, relative to white in the sun: at most 1.
///
/// Snow below an overcast sky is shown half a stop darker than in the sun, at dusk one to two stops:
/// ```
/// # use snowblue_color::exposure::level_of_white;
/// let stops = |luminance_cd_m2| level_of_white(luminance_cd_m2).log2();
/// assert!((stops(2000.0) + 0.44).abs() < 0.01);
/// assert!((stops(100.0) + 1.02).abs() < 0.01);
/// assert!((stops(2.0) + 1.80).abs() < 0.01);
/// ```
pub fn level_of_white(luminance_cd_m2: f64) -> f64 {
    (response_to_white(luminance_cd_m2) / response_to_white(SUNLIT_SNOW_CD_M2)).min(1.0)
}

/// Response of cones to a white of a luminance in cd/m², relative to its upper limit.
fn response_to_white(luminance_cd_m2: f64) -> f64 {
    let compressed = luminance_level_factor(luminance_cd_m2).powf(0.42);
    compressed / (compressed + 27.13)
}

/// The factor F of CIECAM02 for a luminance of white in cd/m².
fn luminance_level_factor(white_cd_m2: f64) -> f64 {
    let dark = (white_cd_m2 + 1.0).recip().powi(4);
    0.2 * dark * white_cd_m2 + 0.1 * (1.0 - dark).powi(2) * white_cd_m2.cbrt()
}

/// The value below which a fraction of the values lies, 0–1; none if there are no values.
pub fn quantile(values: impl IntoIterator<Item = f64>, fraction: f64) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    let last = values.len().checked_sub(1)?;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a fraction of a length")]
    let rank = ((fraction * values.len() as f64) as usize).min(last);
    Some(*values.select_nth_unstable_by(rank, f64::total_cmp).1)
}

/// The value below which a fraction of the weights of the values lies, 0–1; none if there are no values.
fn weighted_quantile(values: impl IntoIterator<Item = (f64, f64)>, fraction: f64) -> Option<f64> {
    let mut values: Vec<(f64, f64)> = values.into_iter().collect();
    values.sort_unstable_by(|(one, _), (other, _)| one.total_cmp(other));
    let wanted = fraction * values.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut below = 0.0;
    let found = values.iter().find(|(_, weight)| {
        below += weight;
        below > wanted
    });
    found.or(values.last()).map(|(value, _)| *value)
}

/// Greatest exposure, in stops; the least is its negative.
pub const MAX_STOPS: f64 = 100.0;

/// Factor of an exposure in stops. Each stop doubles the light.
///
/// ```
/// # use snowblue_color::exposure;
/// assert!((exposure::factor(-2.0) - 0.25).abs() < 1e-15);
/// ```
pub fn factor(stops: f64) -> f64 {
    stops.exp2()
}

/// Automatic exposure: a quantile of the pixels is brought to a level, where 1 is the brightest displayable value.
///
/// A pixel counts by its brightest channel after gamut mapping rather than by its luminance: a screen's blue has only
/// 7 % of the luminance of white, and blue light exposed by luminance would be too bright to be blue.
///
/// ```
/// # use snowblue_color::{LinearRgb, exposure::AutoExposure};
/// let dim_blue = LinearRgb { r: 0.0, g: 0.01, b: 0.03 };
/// let exposure = AutoExposure { fraction: 1.0, level: 0.9 };
/// assert!((exposure.factor([dim_blue]) - 0.9 / 0.03).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AutoExposure {
    /// Fraction of the pixels, 0–1, that stays below the level. With 1 the brightest pixel reaches the level; with
    /// 0.99 one percent of the pixels may exceed the level.
    pub fraction: f64,
    /// Level that this quantile is brought to.
    pub level: f64,
}

impl AutoExposure {
    /// Brings the brightest of a few colours close to white.
    pub const OF_COLORS: Self = Self { fraction: 1.0, level: 0.9 };

    /// Exposure factor for some pixels; 1 if there are none or the quantile is black.
    pub fn factor(self, pixels: impl IntoIterator<Item = LinearRgb>) -> f64 {
        self.factor_of_any(pixels).unwrap_or(1.0)
    }

    /// Exposure factor for some pixels; none if there are none or the quantile is black.
    pub fn factor_of_any(self, pixels: impl IntoIterator<Item = LinearRgb>) -> Option<f64> {
        self.factor_of_level(quantile(pixels.into_iter().map(brightest_channel), self.fraction)?)
    }

    /// Exposure factor for the light of some areas, which count by their size; none if there are none or the quantile
    /// is black.
    pub fn factor_of_areas(self, areas: impl IntoIterator<Item = (LinearRgb, f64)>) -> Option<f64> {
        let levels = areas.into_iter().map(|(light, area)| (brightest_channel(light), area));
        self.factor_of_level(weighted_quantile(levels, self.fraction)?)
    }

    fn factor_of_level(self, level: f64) -> Option<f64> {
        (level > 0.0).then(|| self.level / level)
    }
}

fn brightest_channel(pixel: LinearRgb) -> f64 {
    let mapped = pixel.into_gamut();
    mapped.r.max(mapped.g).max(mapped.b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(level: f64) -> LinearRgb {
        LinearRgb { r: level, g: level, b: level }
    }

    fn auto(fraction: f64, level: f64, pixels: impl IntoIterator<Item = LinearRgb>) -> f64 {
        AutoExposure { fraction, level }.factor(pixels)
    }

    #[test]
    fn the_fraction_stays_below_the_level() {
        let pixels = || (0..200).rev().map(|level| grey(f64::from(level)));
        assert!((auto(0.99, 0.9, pixels()) - 0.9 / 198.0).abs() < 1e-9);
        assert!((auto(1.0, 0.8, pixels()) - 0.8 / 199.0).abs() < 1e-9);
    }

    /// Factors of the worked examples of CIECAM02 for adapting luminances of 318.31 and 31.83 cd/m², a fifth of white.
    #[test]
    fn the_factor_has_its_published_values() {
        assert!((luminance_level_factor(5.0 * 318.31) - 1.17).abs() < 0.005);
        assert!((luminance_level_factor(5.0 * 31.83) - 0.54).abs() < 0.005);
    }

    #[test]
    fn white_is_darker_in_less_light_and_never_brighter_than_in_the_sun() {
        let levels: Vec<f64> = (-40..=60).map(|step| level_of_white((0.25 * f64::from(step)).exp2())).collect();
        for pair in levels.windows(2) {
            assert!(pair[0] < pair[1] || pair == [1.0; 2], "{pair:?}");
        }
        assert!(level_of_white(0.0).abs() < 1e-15 && level_of_white(1e9) <= 1.0);
    }

    #[test]
    fn areas_count_by_their_size() {
        let exposure = AutoExposure { fraction: 0.9, level: 1.0 };
        let whole = |sizes: &[(f64, f64)]| {
            exposure.factor_of_areas(sizes.iter().map(|(level, size)| (grey(*level), *size))).unwrap()
        };
        // A large bright area beside many small dark ones, and the same area in pieces.
        let small = [(1.0, 0.05); 16];
        let (one, pieces) = ([&small[..], &[(4.0, 0.2)]].concat(), [&small[..], &[(4.0, 0.1); 2]].concat());
        assert!((whole(&one) - 0.25).abs() < 1e-12 && (whole(&pieces) - whole(&one)).abs() < 1e-12);
        assert!((auto(0.9, 1.0, one[..16].iter().map(|(level, _)| grey(*level))) - 1.0).abs() < 1e-12);
        assert_eq!(exposure.factor_of_areas([]), None);
    }

    #[test]
    fn a_black_or_empty_image_is_unchanged() {
        assert!((auto(1.0, 0.9, []) - 1.0).abs() < 1e-15);
        assert!((auto(0.99, 0.9, [grey(0.0), grey(0.0)]) - 1.0).abs() < 1e-15);
    }
}
