//! Spectral upsampling: spectra of RGB colours, for image lights and reflectances.
//!
//! The spectrum is r R(λ) + g G(λ) + b B(λ), where R, G and B are the smoothest spectra that add up to 1 and have,
//! under D65, the colours of sRGB's primaries (Mallett & Yuksel 2019, doi:10.2312/sr.20191216). The spectrum
//! reproduces every colour in the gamut. It is nowhere negative, and nowhere above 1 if no channel is above 1. White
//! is D65 restricted to 400–700 nm, within 1 % of the white of sRGB.

use snowblue_color::Illuminant;

use crate::spectrum::Spectrum;
use crate::spectrum::light_spectrum::LightSpectrum;

/// Converts linear sRGB to spectra.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Upsampling {
    primaries: [Spectrum; 3],
}

impl Upsampling {
    /// Upsampling for reflectances: a grey is constant over wavelength.
    ///
    /// # Panics
    ///
    /// Never: a test parses the embedded table.
    pub(crate) fn reflectance() -> Self {
        let mut primaries = [Spectrum::ZERO; 3];
        let rows = include_str!("../../data/rgb_basis.csv").lines().skip(1);
        for (nm, row) in rows.enumerate() {
            for (primary, field) in primaries.iter_mut().zip(row.split(',').skip(1)) {
                primary.0[nm] = field.parse().expect("the table holds numbers");
            }
        }
        Self { primaries }
    }

    /// Upsampling for lights: a grey has the spectrum of D65.
    ///
    /// # Panics
    ///
    /// Never: D65 covers 400–700 nm.
    pub(crate) fn daylight() -> Self {
        let daylight = LightSpectrum::illuminant(Illuminant::D65).expect("D65 covers 400–700 nm").relative;
        Self { primaries: Self::reflectance().primaries.map(|primary| primary * daylight) }
    }

    /// The spectrum of a colour, with the luminance of the colour.
    #[inline]
    pub(crate) fn spectrum(&self, [r, g, b]: [f32; 3]) -> Spectrum {
        let [red, green, blue] = &self.primaries;
        Spectrum(std::array::from_fn(|k| r * red.0[k] + g * green.0[k] + b * blue.0[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::wavelengths_nm;
    use snowblue_base::narrow;
    use snowblue_color::{Colorimeter, Lab, LinearRgb, Observer};

    fn observer(illuminant: Illuminant) -> Colorimeter {
        Colorimeter::new(Observer::Cie1931, illuminant, &wavelengths_nm()).unwrap()
    }

    /// The light of a colour has its chromaticity.
    #[test]
    fn lights_have_the_chromaticity_of_their_colour() {
        for rgb in [[1.0, 0.5, 0.25], [0.04, 0.02, 0.01]] {
            let light = LightSpectrum::of_spectrum(&Upsampling::daylight().spectrum(rgb)).unwrap();
            let xyz = observer(Illuminant::E).xyz(&light.relative.0.map(f64::from));
            let LinearRgb { r, g, b } = LinearRgb::from_xyz(xyz);
            // The white of D65 over 400–700 nm is the white of sRGB within 1 %.
            assert!((xyz.y - 1.0).abs() < 1e-6, "{xyz:?}");
            assert!((g / r / 0.5 - 1.0).abs() < 0.02 && (b / r / 0.25 - 1.0).abs() < 0.03, "{r} {g} {b}");
        }
        assert!(LightSpectrum::of_spectrum(&Upsampling::daylight().spectrum([0.0; 3])).is_none());
    }

    /// A grid of colours over the whole gamut, with its corners.
    fn gamut() -> impl Iterator<Item = [f64; 3]> {
        let channel = |number: usize| (number % 6) as f64 / 5.0;
        (0..216).map(move |k| [k / 36, k / 6, k].map(channel))
    }

    #[test]
    fn lights_keep_their_colour_and_grey_is_daylight() {
        let upsampling = Upsampling::daylight();
        let daylight = LightSpectrum::illuminant(Illuminant::D65).unwrap().relative;
        for (grey, sample) in upsampling.spectrum([0.5; 3]).0.iter().zip(daylight.0) {
            assert!((grey / sample - 0.5).abs() < 1e-6);
        }
        for [r, g, b] in gamut() {
            let spectrum = upsampling.spectrum([r, g, b].map(narrow));
            assert!(spectrum.0.iter().all(|&sample| sample >= 0.0));
            let back = LinearRgb::from_xyz(observer(Illuminant::E).xyz(&spectrum.0.map(f64::from)));
            // D65 in steps of 10 nm from 400 to 700 nm differs from sRGB's white by 0.8 % in blue, less elsewhere.
            for (found, expected) in [(back.r, r), (back.g, g), (back.b, b)] {
                assert!((found - expected).abs() < 0.01 * expected.max(1e-3), "{r} {g} {b}: {back:?}");
            }
        }
    }

    #[test]
    fn reflectances_keep_their_colour_under_daylight_and_are_at_most_one() {
        let upsampling = Upsampling::reflectance();
        let observer = observer(Illuminant::D65);
        for [r, g, b] in gamut() {
            let reflectance = upsampling.spectrum([r, g, b].map(narrow));
            // Red, green and blue add up to 1 within rounding to six decimals each.
            assert!(reflectance.0.iter().all(|&value| (0.0..=1.000_001).contains(&value)), "{r} {g} {b}");
            let screen = Lab::from_xyz(LinearRgb { r, g, b }.xyz(), LinearRgb { r: 1.0, g: 1.0, b: 1.0 }.xyz());
            let reflected = Lab::from_xyz(observer.xyz(&reflectance.0.map(f64::from)), observer.white());
            let difference = screen.delta_e_1976(reflected);
            assert!(difference < 0.5, "{r} {g} {b}: ΔE {difference}");
        }
    }
}
