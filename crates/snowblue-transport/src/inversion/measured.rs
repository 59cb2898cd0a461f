//! Measured spectra, their errors, and residuals in units of those.
//!
//! Errors that correlate over a distance L of wavelengths, ⟨ε_i ε_j⟩ = σ_i σ_j exp(−|λ_i − λ_j|/L), are a Markov chain
//! in the order of wavelengths. With z = ε/σ and ρ_i = exp(−(λ_i − λ_{i−1})/L),
//!
//! ```text
//! u_i = (z_i − ρ_i z_{i−1})/√(1 − ρ_i²)
//! ```
//!
//! are independent with unit variance (Uhlenbeck & Ornstein 1930, doi:10.1103/PhysRev.36.823), so that no covariance is
//! inverted. A common error of scale is an element of the state.

use snowblue_base::ParameterRange;

use super::error::InversionError;
use crate::TransportError;

pub(super) const ALBEDO_DEVIATION_RANGE: ParameterRange =
    ParameterRange { quantity: "standard deviation of the albedo", least: 1e-6, greatest: 1e6, unit: "" };
/// A transmittance may be far below 1, and its error a fraction of it.
pub(super) const TRANSMITTANCE_DEVIATION_RANGE: ParameterRange =
    ParameterRange { quantity: "standard deviation of the transmittance", least: 1e-18, greatest: 1e6, unit: "" };
const SCALE_ERROR_RANGE: ParameterRange =
    ParameterRange { quantity: "scale error", least: 0.0, greatest: 1.0, unit: "" };
/// Least error of scale beside 0.
const LEAST_SCALE_ERROR: f64 = 1e-6;
const CORRELATION_RANGE: ParameterRange =
    ParameterRange { quantity: "correlation length", least: 0.0, greatest: 1e4, unit: "nm" };

/// A measured albedo or transmittance at each wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Values; NaN where there is none.
    pub values: Vec<f64>,
    /// Standard deviation of each value.
    pub standard_deviations: Vec<f64>,
    /// Standard deviation of the logarithm of a factor that all values have in common, such as that of a calibration.
    pub scale_error: f64,
    /// Distance over which the errors of neighbouring wavelengths correlate, in nm: the correlation falls by e.
    pub correlation_nm: f64,
}

/// The values of a spectrum in the order of their wavelengths.
#[derive(Debug, Clone)]
pub(super) struct Data {
    points: Vec<Point>,
}

#[derive(Debug, Clone, Copy)]
struct Point {
    /// Place among the wavelengths.
    place: usize,
    value: f64,
    standard_deviation: f64,
    /// ρ.
    correlation: f64,
}

impl Measured {
    /// Checks all but the values that are missing.
    pub(super) fn check(
        &self,
        values: &ParameterRange,
        deviations: &ParameterRange,
        wavelengths_nm: &[f64],
    ) -> Result<(), InversionError> {
        for (quantity, numbers) in [(values.quantity, &self.values), (deviations.quantity, &self.standard_deviations)] {
            if numbers.len() != wavelengths_nm.len() {
                let expected = "as many as there are wavelengths";
                return Err(TransportError::Count { quantity, count: numbers.len(), expected }.into());
            }
        }
        SCALE_ERROR_RANGE.check(self.scale_error).map_err(TransportError::from)?;
        if self.scale_error > 0.0 && self.scale_error < LEAST_SCALE_ERROR {
            let (quantity, rule) = (SCALE_ERROR_RANGE.quantity, "must be 0 or at least 1e-6");
            return Err(TransportError::Combination { quantity, rule }.into());
        }
        CORRELATION_RANGE.check(self.correlation_nm).map_err(TransportError::from)?;
        for (place, value) in self.present() {
            let check = values.check(value).and_then(|()| deviations.check(self.standard_deviations[place]));
            check.map_err(|error| InversionError::at_wavelength(place, error))?;
        }
        let data = self.data(wavelengths_nm);
        match data.points.iter().skip(1).find(|point| point.correlation >= 1.0) {
            Some(point) => {
                let quantity = "wavelength";
                let rule = "is given twice, so that the errors of its values would be equal";
                Err(InversionError::at_wavelength(point.place, TransportError::Combination { quantity, rule }))
            }
            None => Ok(()),
        }
    }

    /// Places and values of those that are not missing.
    pub(super) fn present(&self) -> impl Iterator<Item = (usize, f64)> {
        self.values.iter().copied().enumerate().filter(|(_, value)| !value.is_nan())
    }

    pub(super) fn data(&self, wavelengths_nm: &[f64]) -> Data {
        let mut present: Vec<(usize, f64)> = self.present().collect();
        present.sort_by(|(a, _), (b, _)| wavelengths_nm[*a].total_cmp(&wavelengths_nm[*b]));
        let before = std::iter::once(None).chain(present.iter().map(|(place, _)| Some(*place)));
        let point = |(before, (place, value)): (Option<usize>, &(usize, f64))| {
            let distance_nm = before.map_or(f64::INFINITY, |before| wavelengths_nm[*place] - wavelengths_nm[before]);
            Point {
                place: *place,
                value: *value,
                standard_deviation: self.standard_deviations[*place],
                // Without a length errors are independent, also at one wavelength.
                correlation: if self.correlation_nm > 0.0 { (-distance_nm / self.correlation_nm).exp() } else { 0.0 },
            }
        };
        Data { points: before.zip(&present).map(point).collect() }
    }
}

impl Data {
    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// Measured values less those of a model, which has one at each place, in units of their errors.
    pub(super) fn residuals<'d>(&'d self, model: impl Fn(usize) -> f64 + 'd) -> impl Iterator<Item = f64> + 'd {
        self.decorrelated(move |point| point.value - model(point.place))
    }

    /// The derivative of the model at each place, in units of the errors.
    pub(super) fn derivatives<'d>(&'d self, model: impl Fn(usize) -> f64 + 'd) -> impl Iterator<Item = f64> + 'd {
        self.decorrelated(move |point| model(point.place))
    }

    fn decorrelated<'d>(&'d self, of: impl Fn(&Point) -> f64 + 'd) -> impl Iterator<Item = f64> + 'd {
        let mut before = 0.0;
        self.points.iter().map(move |point| {
            let own = of(point) / point.standard_deviation;
            let rho = point.correlation;
            (own - rho * std::mem::replace(&mut before, own)) / ((1.0 - rho) * (1.0 + rho)).sqrt()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    /// |u|² = zᵀ C⁻¹ z with the dense inverse of the correlations, for unsorted wavelengths with one missing.
    #[test]
    fn residuals_are_those_of_the_inverse_covariance() {
        let wavelengths_nm = [700.0, 400.0, 450.0, 900.0, 430.0];
        let values = vec![0.9, 0.95, f64::NAN, 0.7, 0.96];
        let standard_deviations = vec![0.01, 0.02, f64::NAN, 0.005, 0.01];
        let measured = Measured { values, standard_deviations, scale_error: 0.0, correlation_nm: 80.0 };
        let data = measured.data(&wavelengths_nm);
        let sum: f64 = data.residuals(|place| 0.9 + 0.01 * place as f64).map(|u| u * u).sum();
        let places = [0, 1, 3, 4];
        let covariance = DMatrix::from_fn(4, 4, |i, j| {
            let (i, j) = (places[i], places[j]);
            let [a, b] = [i, j].map(|place: usize| measured.standard_deviations[place]);
            a * b * (-(wavelengths_nm[i] - wavelengths_nm[j]).abs() / 80.0).exp()
        });
        let off = DVector::from_fn(4, |i, _| measured.values[places[i]] - 0.9 - 0.01 * places[i] as f64);
        let expected = off.dot(&(covariance.try_inverse().unwrap() * &off));
        assert!((sum / expected - 1.0).abs() < 1e-12, "{sum} {expected}");
        assert_eq!(data.len(), 4);
    }
}
