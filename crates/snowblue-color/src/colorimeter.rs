//! From spectra to tristimulus values, with weights computed once.
//!
//! X = Σ v E x̄ / Σ E ȳ, and likewise Y and Z, over the given wavelengths (CIE 015:2018, with k = 1 / Σ E ȳ): v is the
//! spectrum (a ratio to the bare light), E the power of the illuminant, and x̄ ȳ z̄ are the colour-matching functions.

use crate::error::ColorError;
use crate::illuminant::Illuminant;
use crate::observer::Observer;
use crate::xyz::Xyz;

/// Converts spectra on fixed wavelengths to tristimulus values, for one observer and one illuminant.
///
/// The bare light has Y = 1 and keeps its own chromaticity:
/// ```
/// # use snowblue_color::{Colorimeter, Illuminant, Observer};
/// let lamp = Colorimeter::new(Observer::Cie1931, Illuminant::A, &[450.0, 550.0, 650.0])?;
/// let bare = lamp.xyz(&[1.0, 1.0, 1.0]);
/// assert!((bare.y - 1.0).abs() < 1e-15);
/// assert!(bare.x > bare.z);
/// # Ok::<(), snowblue_color::ColorError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Colorimeter {
    wavelengths_nm: Vec<f64>,
    weights: Vec<Xyz>,
}

impl Colorimeter {
    /// Computes the weights for spectra on these wavelengths, in nm.
    ///
    /// The sum approximates an integral only if the wavelengths are evenly spaced.
    ///
    /// # Errors
    /// If the wavelengths do not increase or lie outside a table, or if X, Y or Z of the bare light is 0.
    pub fn new(observer: Observer, illuminant: Illuminant, wavelengths_nm: &[f64]) -> Result<Colorimeter, ColorError> {
        for pair in wavelengths_nm.windows(2) {
            if pair[1] <= pair[0] {
                return Err(ColorError::NotIncreasing { wavelength_nm: pair[1], previous_nm: pair[0] });
            }
        }
        let mut weights = Vec::with_capacity(wavelengths_nm.len());
        for &wavelength_nm in wavelengths_nm {
            weights.push(observer.color_matching(wavelength_nm)? * illuminant.relative_power(wavelength_nm)?);
        }
        let Xyz { x, y, z } = sum(weights.iter().copied());
        if x <= 0.0 || y <= 0.0 || z <= 0.0 {
            return Err(ColorError::NoWhite { x, y, z, count: wavelengths_nm.len() });
        }
        for weight in &mut weights {
            *weight = *weight * y.recip();
        }
        Ok(Colorimeter { wavelengths_nm: wavelengths_nm.to_vec(), weights })
    }

    /// The wavelengths of the spectra, in nm.
    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.wavelengths_nm
    }

    /// Contribution of each wavelength to the tristimulus values, per unit of the spectrum.
    ///
    /// The luminance of a spectrum is its dot product with `y` of the weights.
    pub fn weights(&self) -> &[Xyz] {
        &self.weights
    }

    /// Relative tristimulus values of a spectrum. A spectrum of ones gives Y = 1.
    ///
    /// # Panics
    /// If there is not one value per wavelength.
    pub fn xyz(&self, values: &[f64]) -> Xyz {
        assert_eq!(values.len(), self.weights.len(), "a spectrum needs one value per wavelength of the colorimeter");
        sum(self.weights.iter().zip(values).map(|(&weight, &value)| weight * value))
    }

    /// Tristimulus values of the bare light, with Y = 1.
    pub fn white(&self) -> Xyz {
        sum(self.weights.iter().copied())
    }
}

fn sum(terms: impl Iterator<Item = Xyz>) -> Xyz {
    terms.fold(Xyz::default(), |sum, term| sum + term)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn colorimeter(illuminant: Illuminant, wavelengths_nm: &[f64]) -> Result<Colorimeter, ColorError> {
        Colorimeter::new(Observer::Cie1931, illuminant, wavelengths_nm)
    }

    #[test]
    fn sums_follow_the_equation() {
        let wavelengths_nm = [450.0, 552.5, 650.0];
        let values = [0.3, 0.2, 0.1];
        let (mut numerator, mut denominator) = (0.0, 0.0);
        for (wavelength_nm, value) in wavelengths_nm.into_iter().zip(values) {
            let power = Illuminant::D65.relative_power(wavelength_nm).unwrap();
            let matching = Observer::Cie1931.color_matching(wavelength_nm).unwrap();
            numerator += value * power * matching.z;
            denominator += power * matching.y;
        }
        let d65 = colorimeter(Illuminant::D65, &wavelengths_nm).unwrap();
        assert!((d65.xyz(&values).z - numerator / denominator).abs() < 1e-15);
        let luminance: f64 = d65.weights().iter().zip(values).map(|(weight, value)| weight.y * value).sum();
        assert!((d65.xyz(&values).y - luminance).abs() < 1e-15);
    }

    /// z̄ is 0 above 650 nm, so Z of white is 0 on red wavelengths alone and CIELAB is undefined.
    #[test]
    fn a_bare_light_without_white_is_rejected() {
        let message = colorimeter(Illuminant::E, &[660.0, 700.0]).unwrap_err().to_string();
        assert!(message.contains("Z = 0 (relative) on 2 wavelengths, but each must be above 0"), "{message}");
        assert!(matches!(colorimeter(Illuminant::E, &[]), Err(ColorError::NoWhite { count: 0, .. })));
        let dark: Illuminant = "LED-B2".parse().unwrap();
        assert!(matches!(colorimeter(dark, &[380.0, 385.0]), Err(ColorError::NoWhite { .. })));
    }

    #[test]
    fn decreasing_or_untabulated_wavelengths_are_rejected() {
        let message = colorimeter(Illuminant::E, &[450.0, 450.0]).unwrap_err().to_string();
        assert_eq!(message, "wavelengths must increase, but 450 nm follows 450 nm");
        assert!(matches!(colorimeter(Illuminant::E, &[450.0, f64::NAN]), Err(ColorError::OutsideTable { .. })));
        assert!(matches!(colorimeter(Illuminant::D65, &[450.0, 800.0]), Err(ColorError::OutsideTable { .. })));
    }

    #[test]
    #[should_panic(expected = "one value per wavelength")]
    fn a_spectrum_of_another_length_panics() {
        colorimeter(Illuminant::E, &[450.0, 550.0]).unwrap().xyz(&[1.0]);
    }
}
