//! Spectra for colours: light of images, paints by their red, green and blue.
//!
//! r R(λ) + g G(λ) + b B(λ), where R, G and B are the smoothest spectra that add up to 1 and have, under D65, the colours
//! of sRGB's primaries (Mallett & Yuksel 2019, doi:10.2312/sr.20191216). Every colour within the gamut is met, none
//! is negative anywhere, and what has no channel above 1 reflects nowhere more than it gets. White is D65 as the
//! sum over 400–700 nm sees it: within 1 % of sRGB's.

use snowblue_color::{Illuminant, LinearRgb};

use crate::geometry::ray::narrow;
use crate::spectrum::Spectrum;
use crate::spectrum::lamp::LampSpectrum;

/// Turns linear sRGB into spectra.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Upsampling {
    primaries: [Spectrum; 3],
}

impl Upsampling {
    /// Of what reflects light: grey is the same share at all wavelengths.
    ///
    /// # Panics
    ///
    /// Never: the embedded table has been checked by a test.
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

    /// Of light: grey is daylight of D65.
    ///
    /// # Panics
    ///
    /// Never: D65 covers 400–700 nm.
    pub(crate) fn daylight() -> Self {
        let daylight = LampSpectrum::illuminant(Illuminant::D65).expect("D65 covers 400–700 nm").relative;
        Self { primaries: Self::reflectance().primaries.map(|primary| primary * daylight) }
    }

    /// The luminance of each primary alike at all wavelengths, for false colours.
    pub(crate) fn grey() -> Self {
        let of = |r, g, b| Spectrum::constant(narrow(LinearRgb { r, g, b }.luminance()));
        Self { primaries: [of(1.0, 0.0, 0.0), of(0.0, 1.0, 0.0), of(0.0, 0.0, 1.0)] }
    }

    /// The spectrum of a colour, of the luminance of the colour.
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
    use snowblue_color::{Colorimeter, Lab, Observer};

    fn eye(illuminant: Illuminant) -> Colorimeter {
        Colorimeter::new(Observer::Cie1931, illuminant, &wavelengths_nm()).unwrap()
    }

    /// Colours on a grid over the whole gamut, its corners with them.
    fn gamut() -> impl Iterator<Item = [f64; 3]> {
        let channel = |number: usize| (number % 6) as f64 / 5.0;
        (0..216).map(move |k| [k / 36, k / 6, k].map(channel))
    }

    #[test]
    fn light_keeps_its_colour_and_grey_is_daylight() {
        let upsampling = Upsampling::daylight();
        let daylight = LampSpectrum::illuminant(Illuminant::D65).unwrap().relative;
        for (grey, sample) in upsampling.spectrum([0.5; 3]).0.iter().zip(daylight.0) {
            assert!((grey / sample - 0.5).abs() < 1e-6);
        }
        for [r, g, b] in gamut() {
            let spectrum = upsampling.spectrum([r, g, b].map(narrow));
            assert!(spectrum.0.iter().all(|&sample| sample >= 0.0));
            let back = LinearRgb::from_xyz(eye(Illuminant::E).xyz(&spectrum.0.map(f64::from)));
            // The white of D65 on 10 nm steps from 400 to 700 nm is off sRGB's by .8 % in blue, and less elsewhere.
            for (found, expected) in [(back.r, r), (back.g, g), (back.b, b)] {
                assert!((found - expected).abs() < 0.01 * expected.max(1e-3), "{r} {g} {b}: {back:?}");
            }
        }
    }

    #[test]
    fn paint_of_any_colour_has_it_under_daylight_and_reflects_no_more_than_it_gets() {
        let upsampling = Upsampling::reflectance();
        let eye = eye(Illuminant::D65);
        for [r, g, b] in gamut() {
            let paint = upsampling.spectrum([r, g, b].map(narrow));
            // Rounding: red, green and blue add up to 1 in six decimals each.
            assert!(paint.0.iter().all(|&share| (0.0..=1.000_001).contains(&share)), "{r} {g} {b}");
            let screen = Lab::from_xyz(LinearRgb { r, g, b }.xyz(), LinearRgb { r: 1.0, g: 1.0, b: 1.0 }.xyz());
            let painted = Lab::from_xyz(eye.xyz(&paint.0.map(f64::from)), eye.white());
            let difference = screen.delta_e_1976(painted);
            assert!(difference < 0.5, "{r} {g} {b}: ΔE {difference}");
        }
    }
}
