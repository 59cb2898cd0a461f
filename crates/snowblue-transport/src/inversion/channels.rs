//! Where values are measured: at wavelengths, or in bands.
//!
//! The value in a band is the mean of the spectrum with the weights w of its wavelengths, v = Σ_λ w_λ v_λ, and so is
//! its derivative. Its place among the wavelengths is the mean one, Σ_λ w_λ λ, by which errors correlate.

use nalgebra::DMatrix;

use super::error::InversionError;
use crate::TransportError;

/// How far the sum of the weights of a band may be from 1: rounding of as many as there are wavelengths.
const WEIGHT_SUM_TOLERANCE: f64 = 1e-9;

/// The wavelengths, or the bands of a sensor.
#[derive(Debug, Clone)]
pub(super) struct Channels<'a> {
    /// Of each channel; of a band the mean one.
    pub(super) wavelengths_nm: Vec<f64>,
    /// The weight of each wavelength in each band, if there are bands.
    pub(super) bands: Option<&'a [Vec<f64>]>,
}

impl<'a> Channels<'a> {
    pub(super) fn new(wavelengths_nm: &[f64], bands: Option<&'a [Vec<f64>]>) -> Self {
        let mean = |weights: &Vec<f64>| weights.iter().zip(wavelengths_nm).map(|(weight, nm)| weight * nm).sum();
        let own_nm = bands.map(|bands| bands.iter().map(mean).collect());
        Self { wavelengths_nm: own_nm.unwrap_or_else(|| wavelengths_nm.to_vec()), bands }
    }

    pub(super) fn len(&self) -> usize {
        self.wavelengths_nm.len()
    }

    /// What the error of a wrong number of values says.
    pub(super) fn expected(&self, at_depths: bool) -> &'static str {
        match (self.bands.is_some(), at_depths) {
            (false, false) => "as many as there are wavelengths",
            (false, true) => "as many as there are depths and wavelengths",
            (true, false) => "as many as there are bands",
            (true, true) => "as many as there are depths and bands",
        }
    }

    /// What is wrong where two channels with correlated errors have the same wavelength.
    pub(super) fn given_twice(&self) -> TransportError {
        let (quantity, rule) = if self.bands.is_some() {
            ("mean wavelength of a band", "is that of another, so that the errors of their values would be equal")
        } else {
            ("wavelength", "is given twice, so that the errors of its values would be equal")
        };
        TransportError::Combination { quantity, rule }
    }

    /// The places of the wavelengths that a channel needs.
    pub(super) fn wavelengths_of(&self, channel: usize) -> Vec<usize> {
        let weighted = |weights: &Vec<f64>| (0..weights.len()).filter(|place| weights[*place] > 0.0).collect();
        self.bands.map_or_else(|| vec![channel], |bands| weighted(&bands[channel]))
    }

    /// The channels that spectra at the wavelengths of some ascending places determine, and the weight of each of these
    /// wavelengths in each of them, row by row; none where the channels are the wavelengths.
    pub(super) fn solved(&self, used: &[usize]) -> (Vec<usize>, Option<DMatrix<f64>>) {
        let Some(bands) = self.bands else { return (used.to_vec(), None) };
        let is_whole = |band: &usize| self.wavelengths_of(*band).iter().all(|place| used.binary_search(place).is_ok());
        let whole: Vec<usize> = (0..bands.len()).filter(is_whole).collect();
        let weights = DMatrix::from_fn(whole.len(), used.len(), |i, k| bands[whole[i]][used[k]]);
        (whole, Some(weights))
    }
}

/// Checks the weights of some wavelengths in bands.
pub(super) fn check_bands(bands: &[Vec<f64>], wavelengths: usize) -> Result<(), InversionError> {
    if bands.is_empty() {
        return Err(TransportError::Missing { quantity: "band" }.into());
    }
    for (band, weights) in bands.iter().enumerate() {
        let (quantity, count) = ("weight of a band", weights.len());
        let wrong = if count != wavelengths {
            Some(TransportError::Count { quantity, count, expected: "as many as there are wavelengths" })
        } else if !weights.iter().all(|weight| weight.is_finite() && *weight >= 0.0) {
            Some(TransportError::Combination { quantity, rule: "must not be negative" })
        } else if (weights.iter().sum::<f64>() - 1.0).abs() > WEIGHT_SUM_TOLERANCE {
            Some(TransportError::Combination { quantity: "sum of the weights of a band", rule: "must be 1" })
        } else {
            None
        };
        wrong.map_or(Ok(()), |error| Err(InversionError::at_wavelength(band, error)))?;
    }
    Ok(())
}
