//! Images as light: tristimulus values per pixel, exact sums over samples, AOVs and image files.
//!
//! XYZ is relative: Y = 1 is the luminance of equal-energy light of 1 W m⁻² sr⁻¹ over 400–700 nm. This is some 235
//! cd/m²: 683 lm/W times 0.345, the mean of ȳ on the wavelength grid. There is no chromatic adaptation: D65 light on a
//! grey surface is neutral in sRGB, whose white point is D65, and other light keeps its colour. In false colour (see
//! [`FalseColor`](crate::FalseColor)) Y = 1 is white light of 1 W m⁻² sr⁻¹ over the table's wavelengths.

pub mod accumulator;
pub mod aov;
pub mod channels;
pub mod image_file;
pub(crate) mod noise;
pub(crate) mod pixel_accumulator;
pub mod residual_filter;
pub mod resumable_file;
pub mod sample_block;
pub mod window;

use snowblue_color::{LinearRgb, Xyz};

use snowblue_scene::film::Exposure;
use snowblue_scene::film::ImageSize;

/// A finished image, row by row from the upper left.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    size: ImageSize,
    pixels: Vec<Xyz>,
    /// Whether each pixel shows a lamp or the sun; empty if none does.
    shows_emitter: Vec<bool>,
}

impl Film {
    /// An image of the given pixels, row by row from the upper left.
    ///
    /// # Panics
    ///
    /// When the number of pixels is not that of the size.
    pub fn new(size: ImageSize, pixels: Vec<Xyz>) -> Self {
        assert_eq!(pixels.len(), size.pixel_count(), "one value per pixel");
        Self { size, pixels, shows_emitter: Vec::new() }
    }

    /// The image, of which some pixels show a lamp or the sun.
    pub(crate) fn with_emitters(self, shows_emitter: Vec<bool>) -> Self {
        assert_eq!(shows_emitter.len(), self.pixels.len(), "one value per pixel");
        let is_any = shows_emitter.contains(&true);
        Self { shows_emitter: if is_any { shows_emitter } else { Vec::new() }, ..self }
    }

    /// Size in pixels.
    pub fn size(&self) -> ImageSize {
        self.size
    }

    /// Tristimulus values, row by row from the upper left.
    pub fn pixels(&self) -> &[Xyz] {
        &self.pixels
    }

    /// The pixels that an automatic exposure depends on: all but those that show a lamp or the sun, which is some
    /// thousand times as bright as what it lights.
    pub fn metered_pixels(&self) -> impl Iterator<Item = Xyz> {
        let shows_emitter = |index: usize| self.shows_emitter.get(index).copied().unwrap_or(false);
        self.pixels.iter().enumerate().filter(move |(index, _)| !shows_emitter(*index)).map(|(_, pixel)| *pixel)
    }

    /// The factor by which radiance is multiplied for display.
    pub fn display_factor(&self, exposure: Exposure) -> f64 {
        exposure.display_factor(self.metered_pixels().map(LinearRgb::from_xyz))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn automatic_exposure_maps_the_99th_percentile_close_to_white() {
        let pixels: Vec<Xyz> =
            (0..200).map(|k| LinearRgb { r: f64::from(k), g: f64::from(k), b: f64::from(k) }.xyz()).collect();
        let film = Film::new(ImageSize { width: 200, height: 1 }, pixels);
        assert!((film.display_factor(Exposure::Auto) - 0.9 / 198.0).abs() < 1e-9);
        assert!((film.display_factor(Exposure::Stops(-2.0)) - 0.25).abs() < 1e-12);
        let bright: Vec<bool> = (0..200).map(|k| k >= 100).collect();
        assert!((film.with_emitters(bright).display_factor(Exposure::Auto) - 0.9 / 99.0).abs() < 1e-9);
        let black = Film::new(ImageSize { width: 1, height: 1 }, vec![Xyz::default()]);
        assert!((black.display_factor(Exposure::Auto) - 1.0).abs() < 1e-12);
    }
}
