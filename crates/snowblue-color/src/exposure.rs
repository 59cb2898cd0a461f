//! How much light a picture takes: factors on linear light before it is shown.

use crate::rgb::LinearRgb;

/// The factor of an exposure in stops, each of which doubles the light.
///
/// ```
/// # use snowblue_color::exposure;
/// assert!((exposure::factor(-2.0) - 0.25).abs() < 1e-15);
/// ```
pub fn factor(stops: f64) -> f64 {
    stops.exp2()
}

/// The factor that brings the brightest of some lights to a level, with 1 the brightest that a screen can show.
///
/// A `share` of the lights, 0–1, stays below the `level`: 1 means that the brightest of all comes to it, 0.99 that the
/// percent above may be glaring. Each light counts by its brightest channel, after mapping into the gamut, rather than by its
/// luminance: a screen's blue has only 7 % of the luminance of white, and blue light set by luminance would be too
/// bright to be blue. If what is brought to the level is black, or there are no lights, the factor is 1.
///
/// ```
/// # use snowblue_color::{LinearRgb, exposure};
/// let dim_blue = LinearRgb { r: 0.0, g: 0.01, b: 0.03 };
/// assert!((exposure::automatic([dim_blue], 1.0, 0.9) - 0.9 / 0.03).abs() < 1e-12);
/// ```
pub fn automatic(lights: impl IntoIterator<Item = LinearRgb>, share: f64, level: f64) -> f64 {
    let mut brightest: Vec<f64> = lights.into_iter().map(greatest_channel).collect();
    let Some(last) = brightest.len().checked_sub(1) else {
        return 1.0;
    };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
    let place = ((share * brightest.len() as f64) as usize).min(last);
    let (_, &mut found, _) = brightest.select_nth_unstable_by(place, f64::total_cmp);
    if found > 0.0 { level / found } else { 1.0 }
}

fn greatest_channel(light: LinearRgb) -> f64 {
    let shown = light.into_gamut();
    shown.r.max(shown.g).max(shown.b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(level: f64) -> LinearRgb {
        LinearRgb { r: level, g: level, b: level }
    }

    #[test]
    fn a_share_stays_below_the_level() {
        let lights = || (0..200).rev().map(|level| grey(f64::from(level)));
        assert!((automatic(lights(), 0.99, 0.9) - 0.9 / 198.0).abs() < 1e-9);
        assert!((automatic(lights(), 1.0, 0.8) - 0.8 / 199.0).abs() < 1e-9);
    }

    #[test]
    fn darkness_stays_as_it_is() {
        assert!((automatic([], 1.0, 0.9) - 1.0).abs() < 1e-15);
        assert!((automatic([grey(0.0), grey(0.0)], 0.99, 0.9) - 1.0).abs() < 1e-15);
    }
}
