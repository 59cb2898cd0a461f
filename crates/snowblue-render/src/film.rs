//! The picture as light: tristimulus values per pixel.
//!
//! XYZ is relative: Y = 1 is the luminance of equal-energy light of 1 W m⁻² sr⁻¹ over 400–700 nm (times 683 lm/W and
//! the mean of ȳ on the grid, about 0.345, that is some 235 cd/m²). No chromatic adaptation: D65 light on a grey
//! surface is neutral in sRGB, whose white D65 is, and light of another colour keeps it. In false colour (see
//! [`FalseColor`](crate::FalseColor)) Y = 1 is white light of 1 W m⁻² sr⁻¹ over the table's wavelengths.

use snowblue_color::{LinearRgb, Xyz};

use crate::scene::Exposure;

/// Share of the pixels that automatic exposure leaves below [`AUTO_LEVEL`].
const AUTO_SHARE: f64 = 0.99;

/// Where automatic exposure puts the brightest channel of that pixel, with 1 the brightest that a screen can show.
const AUTO_LEVEL: f64 = 0.9;

/// A finished picture, row by row from the upper left.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    pixels: Vec<Xyz>,
}

impl Film {
    /// A picture of given pixels.
    ///
    /// # Panics
    ///
    /// When there are not `width · height` pixels.
    pub fn new(width: u32, height: u32, pixels: Vec<Xyz>) -> Self {
        assert_eq!(pixels.len(), width as usize * height as usize, "one value per pixel");
        Self { width, height, pixels }
    }

    /// Pixels from left to right.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels from top to bottom.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Tristimulus values, row by row from the upper left.
    pub fn pixels(&self) -> &[Xyz] {
        &self.pixels
    }

    /// The factor by which radiance is multiplied for display.
    ///
    /// `Auto` looks at each pixel's brightest channel, after mapping into the gamut, rather than its luminance: a
    /// screen's blue has only 7 % of the luminance of white, and a blue picture set by luminance would be too bright
    /// to be blue. A black picture stays as it is.
    pub fn display_factor(&self, exposure: Exposure) -> f64 {
        match exposure {
            Exposure::Stops(stops) => stops.exp2(),
            Exposure::Auto => {
                let mut brightest: Vec<f64> = self.pixels.iter().map(|&xyz| greatest_channel(xyz)).collect();
                brightest.sort_unstable_by(f64::total_cmp);
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
                let place = (AUTO_SHARE * brightest.len() as f64) as usize;
                match brightest.get(place.min(brightest.len().saturating_sub(1))) {
                    Some(&level) if level > 0.0 => AUTO_LEVEL / level,
                    _ => 1.0,
                }
            }
        }
    }
}

fn greatest_channel(xyz: Xyz) -> f64 {
    let shown = LinearRgb::from_xyz(xyz).into_gamut();
    shown.r.max(shown.g).max(shown.b)
}

/// A displayable colour, all channels in 0–1, for linear light of any colour and brightness.
///
/// Light too saturated for a screen moves to the grey of its luminance until no channel is negative
/// ([`LinearRgb::into_gamut`]); light too bright in one channel, until that channel is 1. Luminance and hue stay.
/// What is brighter than white is white.
pub fn displayable(light: LinearRgb) -> LinearRgb {
    let shown = light.into_gamut();
    let greatest = shown.r.max(shown.g).max(shown.b);
    if greatest <= 1.0 {
        return shown;
    }
    let grey = shown.luminance();
    if grey >= 1.0 {
        return LinearRgb { r: 1.0, g: 1.0, b: 1.0 };
    }
    let saturation = (1.0 - grey) / (greatest - grey);
    let towards_grey = |channel: f64| (grey + saturation * (channel - grey)).clamp(0.0, 1.0);
    LinearRgb { r: towards_grey(shown.r), g: towards_grey(shown.g), b: towards_grey(shown.b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn automatic_exposure_brings_the_brightest_percent_near_white() {
        let pixels: Vec<Xyz> =
            (0..200).map(|k| LinearRgb { r: f64::from(k), g: f64::from(k), b: f64::from(k) }.xyz()).collect();
        let film = Film::new(200, 1, pixels);
        assert!((film.display_factor(Exposure::Auto) - 0.9 / 198.0).abs() < 1e-9);
        assert!((film.display_factor(Exposure::Stops(-2.0)) - 0.25).abs() < 1e-12);
        let black = Film::new(1, 1, vec![Xyz::default()]);
        assert!((black.display_factor(Exposure::Auto) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn displayable_colours_keep_luminance_until_they_are_white() {
        for light in [
            LinearRgb { r: -0.2, g: 0.4, b: 1.4 },
            LinearRgb { r: 0.1, g: 0.3, b: 3.0 },
            LinearRgb { r: 2.0, g: -0.1, b: 0.0 },
        ] {
            let shown = displayable(light);
            for channel in [shown.r, shown.g, shown.b] {
                assert!((0.0..=1.0).contains(&channel), "{shown:?}");
            }
            assert!((shown.luminance() - light.luminance()).abs() < 1e-9, "{light:?} {shown:?}");
        }
        let glare = displayable(LinearRgb { r: 1.0, g: 1.2, b: 9.0 });
        assert!((glare.luminance() - 1.0).abs() < 1e-12);
    }
}
