//! Where values are measured: at wavelengths, or in bands.
//!
//! The value in a band is the mean of the spectrum with the weights w of its wavelengths, v = Σ_λ w_λ v_λ, and so is
//! its derivative. Its place among the wavelengths is the mean one, Σ_λ w_λ λ, by which errors correlate.

use nalgebra::DMatrix;

use super::error::InversionError;
use super::problem::Inversion;
use crate::TransportError;

/// How far the sum of the weights of a band may be from 1: rounding of as many as there are wavelengths.
const WEIGHT_SUM_TOLERANCE: f64 = 1e-9;

/// The wavelengths, or the bands of a sensor.
#[derive(Debug, Clone)]
pub(super) struct Channels {
    /// Of each channel; of a band the mean one.
    pub(super) wavelengths_nm: Vec<f64>,
    pub(super) are_bands: bool,
}

impl Channels {
    pub(super) fn len(&self) -> usize {
        self.wavelengths_nm.len()
    }

    /// What the error of a wrong number of values says.
    pub(super) fn expected(&self, at_depths: bool) -> &'static str {
        match (self.are_bands, at_depths) {
            (false, false) => "as many as there are wavelengths",
            (false, true) => "as many as there are depths and wavelengths",
            (true, false) => "as many as there are bands",
            (true, true) => "as many as there are depths and bands",
        }
    }

    /// What is wrong where two channels with correlated errors have the same wavelength.
    pub(super) fn given_twice(&self) -> TransportError {
        let (quantity, rule) = if self.are_bands {
            ("mean wavelength of a band", "is that of another, so that the errors of their values would be equal")
        } else {
            ("wavelength", "is given twice, so that the errors of its values would be equal")
        };
        TransportError::Combination { quantity, rule }
    }
}

impl Inversion {
    pub(super) fn channel_count(&self) -> usize {
        self.bands.as_ref().map_or(self.wavelengths_nm.len(), Vec::len)
    }

    pub(super) fn channels(&self) -> Channels {
        let mean = |weights: &Vec<f64>| weights.iter().zip(&self.wavelengths_nm).map(|(weight, nm)| weight * nm).sum();
        match &self.bands {
            None => Channels { wavelengths_nm: self.wavelengths_nm.clone(), are_bands: false },
            Some(bands) => Channels { wavelengths_nm: bands.iter().map(mean).collect(), are_bands: true },
        }
    }

    pub(super) fn check_bands(&self) -> Result<(), InversionError> {
        let Some(bands) = &self.bands else { return Ok(()) };
        if bands.is_empty() {
            return Err(TransportError::Missing { quantity: "band" }.into());
        }
        for (band, weights) in bands.iter().enumerate() {
            let (quantity, count) = ("weight of a band", weights.len());
            let wrong = if count != self.wavelengths_nm.len() {
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

    /// The wavelengths that a channel needs.
    pub(super) fn wavelengths_of(&self, channel: usize) -> Vec<usize> {
        match &self.bands {
            None => vec![channel],
            Some(bands) => (0..self.wavelengths_nm.len()).filter(|place| bands[channel][*place] > 0.0).collect(),
        }
    }

    /// The channels that spectra at some wavelengths determine, and the weight of each of these wavelengths in each of
    /// them, row by row; none where the channels are the wavelengths.
    pub(super) fn solved_channels(&self, used: &[usize]) -> (Vec<usize>, Option<DMatrix<f64>>) {
        let Some(bands) = &self.bands else { return (used.to_vec(), None) };
        let mut is_used = vec![false; self.wavelengths_nm.len()];
        used.iter().for_each(|place| is_used[*place] = true);
        let is_whole = |band: &usize| self.wavelengths_of(*band).into_iter().all(|place| is_used[place]);
        let whole: Vec<usize> = (0..bands.len()).filter(is_whole).collect();
        let weights = DMatrix::from_fn(whole.len(), used.len(), |i, k| bands[whole[i]][used[k]]);
        (whole, Some(weights))
    }
}
