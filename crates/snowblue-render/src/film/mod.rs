//! The picture as light: tristimulus values per pixel.
//!
//! XYZ is relative: Y = 1 is the luminance of equal-energy light of 1 W m⁻² sr⁻¹ over 400–700 nm (times 683 lm/W and
//! the mean of ȳ on the grid, about 0.345, that is some 235 cd/m²). No chromatic adaptation: D65 light on a grey
//! surface is neutral in sRGB, whose white D65 is, and light of another colour keeps it. In false colour (see
//! [`FalseColor`](crate::FalseColor)) Y = 1 is white light of 1 W m⁻² sr⁻¹ over the table's wavelengths.

pub mod accumulator;
pub mod aov;
pub mod exposure;
pub mod image_file;
pub mod part_file;
pub(crate) mod pixel_accumulator;
pub mod provenance;
pub mod sample_block;
pub(crate) mod sensor;

use snowblue_color::exposure::AutoExposure;
use snowblue_color::{LinearRgb, Xyz};

use crate::film::exposure::Exposure;

/// Automatic exposure lets the brightest percent of pixels be glaring: lamps and highlights.
const AUTO_FRACTION: f64 = 0.99;

/// To where automatic exposure brings the brightest of the other pixels, with 1 the brightest that a screen can show.
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
    pub fn display_factor(&self, exposure: Exposure) -> f64 {
        match exposure {
            Exposure::Stops(stops) => snowblue_color::exposure::factor(stops),
            Exposure::Auto => AutoExposure { fraction: AUTO_FRACTION, level: AUTO_LEVEL }
                .factor(self.pixels.iter().copied().map(LinearRgb::from_xyz)),
        }
    }
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
}
