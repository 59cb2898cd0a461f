//! How much light a picture takes: factors on linear light before it is shown.

use crate::rgb::LinearRgb;

/// Share of the lights that automatic exposure leaves below [`AUTO_LEVEL`].
pub const AUTO_SHARE: f64 = 0.99;

/// Where automatic exposure puts the brightest channel of that light, with 1 the brightest that a screen can show.
pub const AUTO_LEVEL: f64 = 0.9;

/// The factor of an exposure in stops, each of which doubles the light.
///
/// ```
/// # use snowblue_color::exposure;
/// assert!((exposure::factor(-2.0) - 0.25).abs() < 1e-15);
/// ```
pub fn factor(stops: f64) -> f64 {
    stops.exp2()
}

/// The factor that brings the brightest percent of lights near the brightest that a screen can show.
///
/// It looks at each light's brightest channel, after mapping into the gamut, rather than at its luminance: a screen's
/// blue has only 7 % of the luminance of white, and blue light set by luminance would be too bright to be blue. Lights
/// of which so few shine that the percent is black, and no lights, stay as they are: the factor is 1.
///
/// ```
/// # use snowblue_color::{LinearRgb, exposure};
/// let dim_blue = LinearRgb { r: 0.0, g: 0.01, b: 0.03 };
/// assert!((exposure::automatic([dim_blue]) - 0.9 / 0.03).abs() < 1e-12);
/// ```
pub fn automatic(lights: impl IntoIterator<Item = LinearRgb>) -> f64 {
    let mut brightest: Vec<f64> = lights.into_iter().map(greatest_channel).collect();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
    let place = (AUTO_SHARE * brightest.len() as f64) as usize;
    if place >= brightest.len() {
        return 1.0;
    }
    let (_, &mut level, _) = brightest.select_nth_unstable_by(place, f64::total_cmp);
    if level > 0.0 { AUTO_LEVEL / level } else { 1.0 }
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
    fn the_brightest_percent_comes_near_white() {
        let lights = (0..200).rev().map(|level| grey(f64::from(level)));
        assert!((automatic(lights) - 0.9 / 198.0).abs() < 1e-9);
    }

    #[test]
    fn darkness_stays_as_it_is() {
        assert!((automatic([]) - 1.0).abs() < 1e-15);
        assert!((automatic([grey(0.0), grey(0.0)]) - 1.0).abs() < 1e-15);
    }
}
