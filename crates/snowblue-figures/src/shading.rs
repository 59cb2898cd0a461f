//! Colours of the light behind snow: wavelengths, observers, exposures and textured swatches.

use snowblue_color::{ColorError, Colorimeter, Illuminant, LinearRgb, Observer, Xyz};
use snowblue_render::RenderError;
use snowblue_render::film::image_file;
use snowblue_render::scene::film::ImageSize;

use crate::swatch;

/// Evenly spaced wavelengths, in nm.
pub(crate) fn wavelengths_nm(first: u32, last: u32, step: usize) -> Vec<f64> {
    (first..=last).step_by(step).map(f64::from).collect()
}

/// The CIE 1931 observer under D65.
pub(crate) fn daylight(wavelengths_nm: &[f64]) -> Result<Colorimeter, ColorError> {
    under(Illuminant::D65, wavelengths_nm)
}

/// The CIE 1931 observer under an illuminant.
pub(crate) fn under(illuminant: Illuminant, wavelengths_nm: &[f64]) -> Result<Colorimeter, ColorError> {
    Colorimeter::new(Observer::Cie1931, illuminant, wavelengths_nm)
}

/// A swatch of a light times a factor, with the grey texture of snow, as the bytes of a PNG file.
pub(crate) fn textured_png(light: Xyz, factor: f64, size: ImageSize) -> Result<Vec<u8>, RenderError> {
    let picture = swatch::swatch(LinearRgb::from_xyz(light * factor), size, Some(1));
    image_file::png_bytes(&picture, &[])
}

/// The exposure, as a factor, that brings the brightest of all lights near white.
pub(crate) fn common_exposure(lights: impl Iterator<Item = Xyz>) -> f64 {
    let colours: Vec<LinearRgb> = lights.map(LinearRgb::from_xyz).collect();
    swatch::automatic_exposure(&colours)
}
