//! From a spectrum to tristimulus values, by weights computed once.
//!
//! X = Σ v E x̄ / Σ E ȳ, and so Y and Z, over the given wavelengths: v the spectrum (a ratio to the bare light), E the
//! illuminant's power, x̄ ȳ z̄ the observer (CIE 015:2018, with k = 1 / Σ E ȳ).

use crate::error::ColorError;
use crate::illuminant::Illuminant;
use crate::observer::Observer;
use crate::xyz::Xyz;

/// Turns spectra on fixed wavelengths into the tristimulus values that an observer sees under an illuminant.
///
/// The bare light has Y = 1 and keeps its own hue:
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
    /// Computes the weights for the wavelengths at which spectra will be given.
    ///
    /// The sum stands for an integral if the wavelengths are evenly spaced; it is the same plain sum if they are not.
    ///
    /// # Errors
    /// If the wavelengths do not increase or leave a table, or if the bare light has no X, Y or Z on them.
    pub fn new(observer: Observer, illuminant: Illuminant, wavelengths_nm: &[f64]) -> Result<Colorimeter, ColorError> {
        for pair in wavelengths_nm.windows(2) {
            if pair[1] <= pair[0] {
                return Err(ColorError::NotIncreasing { wavelength_nm: pair[1], previous_nm: pair[0] });
            }
        }
        let mut weights = Vec::with_capacity(wavelengths_nm.len());
        for &wavelength_nm in wavelengths_nm {
            weights.push(observer.matching(wavelength_nm)? * illuminant.relative_power(wavelength_nm)?);
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

    /// What each wavelength adds to the tristimulus values per unit of the spectrum.
    ///
    /// The luminance of a spectrum is its scalar product with the `y` of the weights.
    pub fn weights(&self) -> &[Xyz] {
        &self.weights
    }

    /// Tristimulus values of a spectrum, relative: 1 everywhere gives Y = 1.
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

    fn three_samples(illuminant: Illuminant, wavelengths_nm: &[f64]) -> Result<Colorimeter, ColorError> {
        Colorimeter::new(Observer::Cie1931, illuminant, wavelengths_nm)
    }

    #[test]
    fn sums_are_those_of_the_equation() {
        let wavelengths_nm = [450.0, 552.5, 650.0];
        let values = [0.3, 0.2, 0.1];
        let (mut numerator, mut denominator) = (0.0, 0.0);
        for (wavelength_nm, value) in wavelengths_nm.into_iter().zip(values) {
            let power = Illuminant::D65.relative_power(wavelength_nm).unwrap();
            let matching = Observer::Cie1931.matching(wavelength_nm).unwrap();
            numerator += value * power * matching.z;
            denominator += power * matching.y;
        }
        let colorimeter = three_samples(Illuminant::D65, &wavelengths_nm).unwrap();
        assert!((colorimeter.xyz(&values).z - numerator / denominator).abs() < 1e-15);
        let luminance: f64 = colorimeter.weights().iter().zip(values).map(|(weight, value)| weight.y * value).sum();
        assert!((colorimeter.xyz(&values).y - luminance).abs() < 1e-15);
    }

    /// z̄ ends at 650 nm, so red wavelengths alone leave Z of white at 0 and CIELAB undefined.
    #[test]
    fn wavelengths_without_white_are_refused() {
        let message = three_samples(Illuminant::E, &[660.0, 700.0]).unwrap_err().to_string();
        assert!(message.contains("Z = 0 (relative) on 2 wavelengths, but each must be above 0"), "{message}");
        assert!(matches!(three_samples(Illuminant::E, &[]), Err(ColorError::NoWhite { count: 0, .. })));
        let dark: Illuminant = "LED-B2".parse().unwrap();
        assert!(matches!(three_samples(dark, &[380.0, 385.0]), Err(ColorError::NoWhite { .. })));
    }

    #[test]
    fn wavelengths_that_go_back_or_leave_the_tables_are_refused() {
        let message = three_samples(Illuminant::E, &[450.0, 450.0]).unwrap_err().to_string();
        assert_eq!(message, "wavelengths must increase, but 450 nm follows 450 nm");
        assert!(matches!(three_samples(Illuminant::E, &[450.0, f64::NAN]), Err(ColorError::OutsideTable { .. })));
        assert!(matches!(three_samples(Illuminant::D65, &[450.0, 800.0]), Err(ColorError::OutsideTable { .. })));
    }

    #[test]
    #[should_panic(expected = "one value per wavelength")]
    fn a_spectrum_of_another_length_is_a_defect() {
        three_samples(Illuminant::E, &[450.0, 550.0]).unwrap().xyz(&[1.0]);
    }
}
