//! Exposure: factors applied to linear light before display.

use crate::rgb::LinearRgb;

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
        let mut brightest: Vec<f64> = pixels.into_iter().map(brightest_channel).collect();
        let last = brightest.len().checked_sub(1)?;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a fraction of a length")]
        let rank = ((self.fraction * brightest.len() as f64) as usize).min(last);
        let (_, &mut quantile, _) = brightest.select_nth_unstable_by(rank, f64::total_cmp);
        (quantile > 0.0).then(|| self.level / quantile)
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

    #[test]
    fn a_black_or_empty_image_is_unchanged() {
        assert!((auto(1.0, 0.9, []) - 1.0).abs() < 1e-15);
        assert!((auto(0.99, 0.9, [grey(0.0), grey(0.0)]) - 1.0).abs() < 1e-15);
    }
}
