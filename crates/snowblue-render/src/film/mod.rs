//! Images as light: tristimulus values per pixel, exact sums over samples, AOVs and image files.
//!
//! XYZ is relative: Y = 1 is the luminance of equal-energy light of 1 W m⁻² sr⁻¹ over 400–700 nm. This is some 235
//! cd/m²: 683 lm/W times 0.345, the mean of ȳ on the wavelength grid. There is no chromatic adaptation: D65 light on a
//! grey surface is neutral in sRGB, whose white point is D65, and other light keeps its colour.

pub mod accumulator;
pub mod aov;
pub mod channels;
pub(crate) mod cryptomatte;
pub mod finished_file;
pub mod image_file;
pub(crate) mod noise;
pub(crate) mod pixel_accumulator;
pub mod residual_filter;
pub mod resumable_file;
pub mod window;

use snowblue_color::{ChromaticAdaptation, LinearRgb, Xyz};

use snowblue_scene::film::{Development, ImageSize};

/// A finished image, row by row from the upper left.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    size: ImageSize,
    pixels: Vec<Xyz>,
    /// The contents of each pixel; empty if they are not known.
    shown: Vec<Shown>,
}

/// Contents of a pixel, for automatic exposure and the edges of snow.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Shown {
    /// The fraction of the samples that see snow.
    pub(crate) snow: f32,
    /// Whether any sample sees a lamp or the sun.
    pub(crate) emitter: bool,
}

impl Film {
    /// An image of the given pixels, row by row from the upper left.
    ///
    /// # Panics
    ///
    /// When the number of pixels does not match the size.
    pub fn new(size: ImageSize, pixels: Vec<Xyz>) -> Self {
        assert_eq!(pixels.len(), size.pixel_count(), "one value per pixel");
        Self { size, pixels, shown: Vec::new() }
    }

    /// The image, with the contents of each pixel.
    pub(crate) fn with_shown(self, shown: Vec<Shown>) -> Self {
        assert_eq!(shown.len(), self.pixels.len(), "one value per pixel");
        Self { shown, ..self }
    }

    /// The image after some adaptations, one after the other, as for another light that looks white.
    #[must_use]
    pub fn adapted(self, adaptations: &[ChromaticAdaptation]) -> Self {
        let adapted = |xyz| adaptations.iter().fold(xyz, |xyz, adaptation| adaptation.apply(xyz));
        Self { pixels: self.pixels.into_iter().map(adapted).collect(), ..self }
    }

    /// The image with another number of pixels, interpolated linearly.
    #[must_use]
    pub fn resized(&self, size: ImageSize) -> Self {
        // The two pixels around the middle of a new pixel along an axis, and the share of the second.
        let around = |place: u32, side: u32, own_side: u32| {
            let at = (f64::from(place) + 0.5) / f64::from(side) * f64::from(own_side) - 0.5;
            let at = at.clamp(0.0, f64::from(own_side - 1));
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the image")]
            let first = at as usize;
            ([first, (first + 1).min(own_side as usize - 1)], at.fract())
        };
        let row_length = self.size.width as usize;
        let places = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
        let resized = places.map(|(x, y)| {
            let (columns, right) = around(x, size.width, self.size.width);
            let (rows, lower) = around(y, size.height, self.size.height);
            let in_row = |row: usize| {
                let [left, next] = columns.map(|column| self.pixels[row * row_length + column]);
                left * (1.0 - right) + next * right
            };
            let [upper, next] = rows.map(in_row);
            upper * (1.0 - lower) + next * lower
        });
        Self::new(size, resized.collect())
    }

    /// Size in pixels.
    pub fn size(&self) -> ImageSize {
        self.size
    }

    /// Tristimulus values, row by row from the upper left.
    pub fn pixels(&self) -> &[Xyz] {
        &self.pixels
    }

    /// The pixels that an automatic exposure depends on: all except pixels that show a lamp or the sun, which is some
    /// thousand times as bright as the surfaces that it lights.
    pub fn metered_pixels(&self) -> impl Iterator<Item = Xyz> {
        self.showing(|shown| !shown.emitter)
    }

    /// The pixels that show snow in half of their samples at least, and no lamp.
    pub fn snow_pixels(&self) -> impl Iterator<Item = Xyz> + Clone {
        self.showing(|shown| shown.snow >= 0.5 && !shown.emitter)
    }

    fn showing(&self, is_meant: impl Fn(Shown) -> bool + Clone) -> impl Iterator<Item = Xyz> + Clone {
        let pixels = self.pixels.iter().enumerate();
        pixels.filter(move |(index, _)| is_meant(self.shown(*index))).map(|(_, pixel)| *pixel)
    }

    fn shown(&self, pixel: usize) -> Shown {
        self.shown.get(pixel).copied().unwrap_or_default()
    }

    /// The fraction of the samples of a pixel that see snow.
    pub(crate) fn snow_fraction(&self, pixel: usize) -> f64 {
        self.shown(pixel).snow.into()
    }

    /// The factor by which radiance is multiplied for display.
    pub fn display_factor(&self, development: impl Into<Development>) -> f64 {
        let (all, snow) = (self.metered_pixels(), self.snow_pixels());
        development.into().display_factor(all.map(LinearRgb::from_xyz), snow.map(LinearRgb::from_xyz))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_color::ToneCurve;
    use snowblue_scene::film::Exposure;

    #[test]
    fn automatic_exposure_maps_the_99th_percentile_close_to_white() {
        let pixels: Vec<Xyz> =
            (0..200).map(|k| LinearRgb { r: f64::from(k), g: f64::from(k), b: f64::from(k) }.xyz()).collect();
        let film = Film::new(ImageSize { width: 200, height: 1 }, pixels);
        assert!((film.display_factor(Exposure::Auto) - 0.9 / 198.0).abs() < 1e-9);
        assert!((film.display_factor(Exposure::Stops(-2.0)) - 0.25).abs() < 1e-12);
        let shown = (0..200).map(|k| Shown { snow: 0.0, emitter: k >= 100 }).collect();
        assert!((film.with_shown(shown).display_factor(Exposure::Auto) - 0.9 / 99.0).abs() < 1e-9);
        let black = Film::new(ImageSize { width: 1, height: 1 }, vec![Xyz::default()]);
        assert!((black.display_factor(Exposure::Auto) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_resized_image_interpolates_linearly() {
        let level = |value: f64| Xyz { x: value, y: 2.0 * value, z: 3.0 * value };
        let film = Film::new(ImageSize { width: 2, height: 1 }, vec![level(1.0), level(3.0)]);
        let resized = film.resized(ImageSize { width: 8, height: 3 });
        let row = [1.0, 1.0, 1.25, 1.75, 2.25, 2.75, 3.0, 3.0].map(level);
        assert_eq!(resized, Film::new(ImageSize { width: 8, height: 3 }, [row; 3].concat()));
        assert_eq!(film.resized(film.size()), film);
    }

    #[test]
    fn sunlit_snow_is_displayed_as_white_snow_unless_highlights_would_be_lost() {
        let grey = |level: f64| LinearRgb { r: level, g: level, b: level }.xyz();
        let film = |snow: f64, sky: f64| {
            let pixels = (0..100).map(|k| grey(if k < 60 { snow } else { sky })).collect();
            let shown = (0..100).map(|k| Shown { snow: if k < 60 { 1.0 } else { 0.0 }, emitter: false }).collect();
            Film::new(ImageSize { width: 100, height: 1 }, pixels).with_shown(shown)
        };
        for (tone, snow, highlights) in
            [(ToneCurve::None, 0.8, 0.9), (ToneCurve::Filmic, 0.8, 0.9), (ToneCurve::Agx, 0.6, 0.75)]
        {
            let development = Development { exposure: Exposure::Auto, tone };
            let displayed = |film: &Film, level: f64| {
                tone.displayed(LinearRgb::from_xyz(grey(level * film.display_factor(development)))).luminance()
            };
            // A dim sky does not matter.
            for sky in [0.0, 50.0] {
                let level = displayed(&film(100.0, sky), 100.0);
                assert!((level - snow).abs() < 1e-9, "{tone}: {level}");
            }
            // Before a sky that is ten times as bright, the sky gets twice the light of highlights.
            let bright = film(100.0, 1000.0);
            let light = 1000.0 * bright.display_factor(development);
            assert!((light / (2.0 * tone.light_of(highlights)) - 1.0).abs() < 1e-9, "{tone}: {light}");
            // In less light snow is darker, by any tone curve: by half a stop to two stops down to 0.5 cd/m².
            let light = |level: f64| level * film(level, 0.0).display_factor(development);
            let darker = [8.0, 0.5, 0.01].map(|level| (light(level) / light(100.0)).log2());
            assert!(darker.is_sorted_by(|more, less| more > less), "{tone}: {darker:?}");
            assert!((-0.6..-0.3).contains(&darker[0]) && (-1.9..-1.5).contains(&darker[2]), "{tone}: {darker:?}");
        }
    }
}
