//! The Lambertian ground below the snow.

use std::sync::Arc;

use snowblue_base::spectrum_csv::{SpectrumError, read_one};

use crate::TransportError;
use crate::optics::SpectralTable;
use crate::parameters::GROUND_ALBEDO;

/// Albedo of a Lambertian ground, 0–1. Snow on ground of the albedo 0 acts as a free slab.
///
/// ```
/// use snowblue_transport::GroundAlbedo;
///
/// let soil = GroundAlbedo::spectrum(vec![400.0, 800.0], vec![0.1, 0.3])?;
/// assert!((soil.at(600.0) - 0.2).abs() < 1e-15);
/// assert_eq!(GroundAlbedo::from(0.2).at(600.0), 0.2);
/// # Ok::<(), snowblue_transport::TransportError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum GroundAlbedo {
    /// The albedo at all wavelengths.
    Grey(f64),
    /// A spectrum, linear between its wavelengths.
    Spectrum(GroundSpectrum),
}

/// The albedo of a ground at ascending wavelengths.
#[derive(Debug, Clone, PartialEq)]
pub struct GroundSpectrum(Arc<SpectralTable>);

impl From<f64> for GroundAlbedo {
    fn from(albedo: f64) -> Self {
        Self::Grey(albedo)
    }
}

impl GroundAlbedo {
    /// The albedo at each of some wavelengths in nm.
    ///
    /// # Errors
    /// If there is no wavelength, or not one albedo for each; if wavelengths do not ascend; if an albedo is not 0–1.
    pub fn spectrum(wavelengths_nm: Vec<f64>, albedos: Vec<f64>) -> Result<Self, TransportError> {
        let wrong = |rule| TransportError::Combination { quantity: "wavelength of the ground albedo", rule };
        if wavelengths_nm.is_empty() || wavelengths_nm.len() != albedos.len() {
            return Err(wrong("is missing, or has no albedo"));
        }
        if !wavelengths_nm.iter().all(|nm| nm.is_finite()) || !wavelengths_nm.is_sorted_by(|a, b| a < b) {
            return Err(wrong("does not ascend"));
        }
        albedos.iter().try_for_each(|albedo| GROUND_ALBEDO.range.check(*albedo))?;
        Ok(Self::Spectrum(GroundSpectrum(Arc::new(SpectralTable::of_columns(&[wavelengths_nm, albedos])))))
    }

    /// Reads the spectrum of a CSV file with the columns `wavelength_nm` and `albedo`, whose names may be missing.
    ///
    /// # Errors
    /// Names the first line that is wrong.
    pub fn read(text: &str) -> Result<Self, SpectrumError> {
        let spectrum = read_one(text, "albedo", GROUND_ALBEDO.range)?;
        Self::spectrum(spectrum.wavelengths_nm, spectrum.values)
            .map_err(|error| SpectrumError { line: None, reason: error.to_string() })
    }

    /// The albedo at a wavelength.
    ///
    /// # Panics
    /// Outside the spectrum.
    #[must_use]
    pub fn at(&self, wavelength_nm: f64) -> f64 {
        match self {
            Self::Grey(albedo) => *albedo,
            Self::Spectrum(GroundSpectrum(table)) => table.at(wavelength_nm).linear(1),
        }
    }

    /// Whether the ground reflects at any wavelength.
    #[must_use]
    pub fn reflects(&self) -> bool {
        match self {
            Self::Grey(albedo) => *albedo > 0.0,
            Self::Spectrum(GroundSpectrum(table)) => table.greatest(1) > 0.0,
        }
    }

    /// Checks the albedo.
    pub(crate) fn check(&self) -> Result<(), TransportError> {
        match self {
            Self::Grey(albedo) => Ok(GROUND_ALBEDO.range.check(*albedo)?),
            // It was checked when it was made.
            Self::Spectrum(_) => Ok(()),
        }
    }

    /// Checks that the albedo is known at some wavelengths.
    pub(crate) fn check_wavelengths(&self, wavelengths_nm: &[f64]) -> Result<(), TransportError> {
        let Self::Spectrum(GroundSpectrum(table)) = self else { return Ok(()) };
        let known = table.wavelength_range();
        Ok(wavelengths_nm.iter().try_for_each(|nm| known.check("wavelength above the ground", *nm))?)
    }

    /// The bits of all its numbers, by which equal grounds are found.
    pub(crate) fn bits(&self) -> Vec<u64> {
        match self {
            Self::Grey(albedo) => vec![albedo.to_bits()],
            Self::Spectrum(GroundSpectrum(table)) => table.numbers().map(f64::to_bits).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spectrum_of_one_wavelength_holds_there_only() {
        let ground = GroundAlbedo::spectrum(vec![500.0], vec![0.25]).unwrap();
        assert!((ground.at(500.0) - 0.25).abs() < 1e-15 && ground.reflects());
        assert_eq!(ground.check_wavelengths(&[500.0]), Ok(()));
        let message = ground.check_wavelengths(&[500.0, 510.0]).unwrap_err().to_string();
        assert_eq!(message, "wavelength above the ground is 510 nm, but must lie in 500–500 nm");
    }

    #[test]
    fn wrong_spectra_are_refused() {
        for (wavelengths_nm, albedos, words) in [
            (vec![], vec![], "is missing"),
            (vec![400.0, 500.0], vec![0.1], "is missing"),
            (vec![500.0, 400.0], vec![0.1, 0.1], "does not ascend"),
            (vec![400.0, f64::NAN], vec![0.1, 0.1], "does not ascend"),
            (vec![400.0, 500.0], vec![0.1, 1.1], "ground albedo is 1.1, but must lie in 0–1"),
        ] {
            let message = GroundAlbedo::spectrum(wavelengths_nm, albedos).unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
    }
}
