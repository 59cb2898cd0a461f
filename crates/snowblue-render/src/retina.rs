//! From spectra to colours: those that an eye sees, or false ones.
//!
//! A false colour takes the light of three wavelengths, of the infrared too, for red, green and blue. The wavelengths of
//! the picture are then those of the table, whichever they are, and all lights shine alike at each of them, so that what
//! reflects or transmits all wavelengths alike is grey.

use snowblue_color::{Colorimeter, Illuminant, LinearRgb, Observer, Xyz};

use crate::error::RenderError;
use crate::ray::narrow;
use crate::spectrum::{SAMPLES, Spectrum, wavelengths_nm};

/// The wavelengths that a false colour shows as red, green and blue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FalseColor {
    /// Shown as red, in nm.
    pub red_nm: f64,
    /// Shown as green, in nm.
    pub green_nm: f64,
    /// Shown as blue, in nm.
    pub blue_nm: f64,
}

/// Turns sums of spectra into tristimulus values.
#[derive(Debug)]
pub(crate) struct Retina {
    weights: [Xyz; SAMPLES],
}

impl Retina {
    /// The CIE 1931 observer on the grid of 400–700 nm.
    ///
    /// # Panics
    ///
    /// Never: the observer's table covers the grid.
    pub(crate) fn eye() -> Self {
        let colorimeter = Colorimeter::new(Observer::Cie1931, Illuminant::E, &wavelengths_nm())
            .expect("the observer's table covers 400–700 nm");
        let mut weights = [Xyz::default(); SAMPLES];
        weights.copy_from_slice(colorimeter.weights());
        Self { weights }
    }

    /// Three wavelengths as the light of a screen's primaries, linear between the wavelengths of a table.
    ///
    /// # Errors
    ///
    /// When the table has not as many wavelengths as a [`Spectrum`], or does not reach those of the colour.
    pub(crate) fn false_color(colour: FalseColor, wavelengths_nm: &[f64]) -> Result<Self, RenderError> {
        if wavelengths_nm.len() != SAMPLES {
            let count = wavelengths_nm.len();
            let reason = format!("false colour needs a table of {SAMPLES} wavelengths, but this one has {count}");
            return Err(RenderError::Override(reason));
        }
        let mut weights = [LinearRgb::default(); SAMPLES];
        let FalseColor { red_nm, green_nm, blue_nm } = colour;
        for (nm, share) in hat(wavelengths_nm, red_nm)? {
            weights[nm].r += share;
        }
        for (nm, share) in hat(wavelengths_nm, green_nm)? {
            weights[nm].g += share;
        }
        for (nm, share) in hat(wavelengths_nm, blue_nm)? {
            weights[nm].b += share;
        }
        Ok(Self { weights: weights.map(LinearRgb::xyz) })
    }

    /// Tristimulus values of a radiance.
    pub(crate) fn xyz(&self, radiance: &Spectrum) -> Xyz {
        let terms = self.weights.iter().zip(&radiance.0).map(|(&weight, &value)| weight * f64::from(value));
        terms.fold(Xyz::default(), |sum, term| sum + term)
    }

    /// Luminance of one unit at each wavelength.
    pub(crate) fn luminance(&self) -> Spectrum {
        Spectrum(self.weights.map(|weight| narrow(weight.y)))
    }
}

/// The wavelengths on both sides of a wavelength, by their place, with their shares.
fn hat(wavelengths_nm: &[f64], at_nm: f64) -> Result<[(usize, f64); 2], RenderError> {
    let last = SAMPLES - 1;
    let (low_nm, high_nm) = (wavelengths_nm[0], wavelengths_nm[last]);
    if !(low_nm..=high_nm).contains(&at_nm) {
        let reason = format!("false colour at {at_nm} nm, but the table holds {low_nm}–{high_nm} nm");
        return Err(RenderError::Override(reason));
    }
    let above = wavelengths_nm.partition_point(|nm| *nm <= at_nm).min(last);
    let share = (at_nm - wavelengths_nm[above - 1]) / (wavelengths_nm[above] - wavelengths_nm[above - 1]);
    Ok([(above - 1, 1.0 - share), (above, share)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::LampSpectrum;

    #[test]
    fn equal_energy_of_one_watt_has_luminance_one_and_daylight_is_neutral() {
        let retina = Retina::eye();
        assert!((retina.xyz(&Spectrum::ONE).y - 1.0).abs() < 1e-12);
        assert!((retina.luminance().dot(&Spectrum::ONE) - 1.0).abs() < 1e-6);
        let daylight = LampSpectrum::illuminant(Illuminant::D65).unwrap();
        let LinearRgb { r, g, b } = LinearRgb::from_xyz(retina.xyz(&daylight.relative));
        // What 10 nm steps and the ends at 400 and 700 nm leave out of D65.
        for channel in [r, g, b] {
            assert!((channel - 1.0).abs() < 0.01, "{r} {g} {b}");
        }
    }

    #[test]
    fn false_colours_take_three_wavelengths_and_keep_white() {
        let table: Vec<f64> = (0..31).map(|k| 400.0 + 40.0 * f64::from(k)).collect();
        let colour = FalseColor { red_nm: 1600.0, green_nm: 850.0, blue_nm: 400.0 };
        let retina = Retina::false_color(colour, &table).unwrap();
        let seen = |spectrum: &Spectrum| LinearRgb::from_xyz(retina.xyz(spectrum));
        let ramp = Spectrum(std::array::from_fn(|k| k as f32));
        for (spectrum, expected) in [(Spectrum::ONE, [1.0, 1.0, 1.0]), (ramp, [30.0, 11.25, 0.0])] {
            let LinearRgb { r, g, b } = seen(&spectrum);
            for (channel, expected) in [r, g, b].into_iter().zip(expected) {
                assert!((channel - expected).abs() < 1e-9, "{r} {g} {b}");
            }
        }
    }

    #[test]
    fn false_colours_lie_within_the_table() {
        let colour = FalseColor { red_nm: 1030.0, green_nm: 860.0, blue_nm: 550.0 };
        let message = Retina::false_color(colour, &wavelengths_nm()).unwrap_err().to_string();
        assert_eq!(message, "false colour at 1030 nm, but the table holds 400–700 nm");
        assert!(Retina::false_color(colour, &[400.0, 1100.0]).unwrap_err().to_string().contains("31 wavelengths"));
    }
}
