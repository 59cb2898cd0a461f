//! Measured spectra at wavelengths or in bands, their errors, and residuals in units of the errors.
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
//!
//! The value in a band is the mean of the spectrum, v = Σ_λ w_λ v_λ, with the weights w of the wavelengths of the
//! band. The derivative of the value is the mean of the derivatives with these weights. Errors of bands correlate by
//! the mean wavelength of each band, Σ_λ w_λ λ.

use std::str::FromStr;

use nalgebra::DMatrix;
use snowblue_base::ParameterRange;

use crate::error::{InversionError, TransportError, find_by_name};

/// Greatest deviation of the sum of the weights of a band from 1: rounding of one weight for each wavelength.
const WEIGHT_SUM_TOLERANCE: f64 = 1e-9;
/// Least standard deviation of an albedo.
const MIN_ALBEDO_DEVIATION: f64 = 1e-6;
/// Least standard deviation of transmitted light, which may be far below 1 with an error of a fraction of its value.
const MIN_TRANSMITTED_DEVIATION: f64 = 1e-18;
const MAX_DEVIATION: f64 = 1e6;
/// Least measured value of all quantities: white references err, and so does a dark signal.
const MIN_VALUE: f64 = -0.5;
/// Greatest correlation of errors. Values with a greater correlation share one wavelength, except for the rounding of
/// mean wavelengths.
const MAX_CORRELATION: f64 = 1.0 - 1e-12;
const SCALE_ERROR_RANGE: ParameterRange =
    ParameterRange { quantity: "scale error", least: 0.0, greatest: 1.0, unit: "" };
/// Least scale error above 0.
const MIN_SCALE_ERROR: f64 = 1e-6;
const CORRELATION_RANGE: ParameterRange =
    ParameterRange { quantity: "correlation length", least: 0.0, greatest: 1e4, unit: "nm" };

/// A measured quantity, over the incident flux.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The fraction of the light that the snow and the ground reflect.
    Albedo,
    /// The fraction of the light that arrives at the ground.
    Transmittance,
    /// Flux downwards at depths.
    Down,
    /// Flux upwards at depths.
    Up,
    /// Net flux at depths.
    Net,
    /// Fluence rate at depths.
    Fluence,
}

/// The wavelengths, or the bands of a sensor.
#[derive(Debug, Clone)]
pub(super) struct Channels<'a> {
    /// Wavelength of each channel; for a band, the mean wavelength.
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

    /// The expected number of values, as stated by the error for a wrong number.
    pub(super) fn expected(&self, at_depths: bool) -> &'static str {
        match (self.bands.is_some(), at_depths) {
            (false, false) => "as many as there are wavelengths",
            (false, true) => "as many as there are depths and wavelengths",
            (true, false) => "as many as there are bands",
            (true, true) => "as many as there are depths and bands",
        }
    }

    /// The error for two channels with correlated errors at one wavelength.
    pub(super) fn given_twice(&self) -> TransportError {
        let (quantity, rule) = if self.bands.is_some() {
            ("mean wavelength of a band", "is that of another, so that the errors of their values would be equal")
        } else {
            ("wavelength", "is given twice, so that the errors of its values would be equal")
        };
        TransportError::Combination { quantity, rule }
    }

    /// Indices of the wavelengths that a channel needs.
    pub(super) fn wavelengths_of(&self, channel: usize) -> Vec<usize> {
        let weighted = |weights: &Vec<f64>| (0..weights.len()).filter(|place| weights[*place] > 0.0).collect();
        self.bands.map_or_else(|| vec![channel], |bands| weighted(&bands[channel]))
    }

    /// The channels that spectra at the wavelengths of the ascending indices `used` determine, and the weight of each
    /// of these wavelengths in each of these channels, row by row. There are no weights where the channels are the
    /// wavelengths.
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

/// A measured quantity at each wavelength or in each band, and at each depth if the quantity belongs to depths.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// The measured quantity.
    pub quantity: Quantity,
    /// Depths below the surface, in cm; none for an albedo or a transmittance.
    pub depths_cm: Vec<f64>,
    /// Values at each depth, then each wavelength or band; NaN for a missing value.
    pub values: Vec<f64>,
    /// Standard deviation of each value.
    pub standard_deviations: Vec<f64>,
    /// Standard deviation of the logarithm of a common factor of all values, such as a calibration factor.
    pub scale_error: f64,
    /// Distance over which the errors of neighbouring wavelengths, or mean wavelengths of bands, correlate, in nm: the
    /// correlation falls by e.
    pub correlation_nm: f64,
}

/// The values at each depth in the order of their wavelengths.
#[derive(Debug, Clone)]
pub(super) struct Data {
    points: Vec<Point>,
}

#[derive(Debug, Clone, Copy)]
struct Point {
    /// Index of the value: over the depths and, fastest, the channels.
    place: usize,
    value: f64,
    standard_deviation: f64,
    /// ρ.
    correlation: f64,
}

impl Quantity {
    /// Every quantity.
    pub const ALL: [Self; 6] = [Self::Albedo, Self::Transmittance, Self::Down, Self::Up, Self::Net, Self::Fluence];

    /// Its name, as in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::Transmittance => "transmittance",
            Self::Down => "down",
            Self::Up => "up",
            Self::Net => "net",
            Self::Fluence => "fluence",
        }
    }

    /// Whether it is a flux at depths.
    #[must_use]
    pub fn is_at_depth(self) -> bool {
        !matches!(self, Self::Albedo | Self::Transmittance)
    }

    /// The range of the values. Values in percent are out of range, except for a fluence rate.
    #[must_use]
    pub fn range(self) -> ParameterRange {
        let greatest = match self {
            Self::Albedo => 1.5,
            // The transmittance exceeds 1 over a bright ground, but hardly 1.3.
            Self::Transmittance => 2.0,
            Self::Down | Self::Up | Self::Net => 3.0,
            // 1/cos θ of a beam that nothing has scattered.
            Self::Fluence => 1e4,
        };
        ParameterRange { quantity: self.name(), least: MIN_VALUE, greatest, unit: "" }
    }

    /// The range of the standard deviations of its values.
    fn deviation_range(self) -> ParameterRange {
        let (quantity, least) = match self {
            Self::Albedo => ("standard deviation of the albedo", MIN_ALBEDO_DEVIATION),
            Self::Transmittance => ("standard deviation of the transmittance", MIN_TRANSMITTED_DEVIATION),
            Self::Down => ("standard deviation of the flux down", MIN_TRANSMITTED_DEVIATION),
            Self::Up => ("standard deviation of the flux up", MIN_TRANSMITTED_DEVIATION),
            Self::Net => ("standard deviation of the net flux", MIN_TRANSMITTED_DEVIATION),
            Self::Fluence => ("standard deviation of the fluence rate", MIN_TRANSMITTED_DEVIATION),
        };
        ParameterRange { quantity, least, greatest: MAX_DEVIATION, unit: "" }
    }
}

impl FromStr for Quantity {
    type Err = TransportError;

    fn from_str(name: &str) -> Result<Self, TransportError> {
        find_by_name("quantity", name, &Self::ALL, Self::name)
    }
}

impl Measured {
    /// Checks all but missing values. The depths are checked against the snow together with its layers.
    pub(super) fn check(&self, channels: &Channels<'_>) -> Result<(), InversionError> {
        let Self { quantity, depths_cm, .. } = self;
        if quantity.is_at_depth() == depths_cm.is_empty() {
            let rule = if depths_cm.is_empty() { "needs depths" } else { "has no depths" };
            return Err(TransportError::Combination { quantity: quantity.name(), rule }.into());
        }
        let (values, deviations) = (quantity.range(), quantity.deviation_range());
        for (quantity, numbers) in [(values.quantity, &self.values), (deviations.quantity, &self.standard_deviations)] {
            if numbers.len() != self.rows() * channels.len() {
                let expected = channels.expected(!depths_cm.is_empty());
                return Err(TransportError::Count { quantity, count: numbers.len(), expected }.into());
            }
        }
        SCALE_ERROR_RANGE.check(self.scale_error).map_err(TransportError::from)?;
        if self.scale_error > 0.0 && self.scale_error < MIN_SCALE_ERROR {
            let (quantity, rule) = (SCALE_ERROR_RANGE.quantity, "must be 0 or at least 1e-6");
            return Err(TransportError::Combination { quantity, rule }.into());
        }
        CORRELATION_RANGE.check(self.correlation_nm).map_err(TransportError::from)?;
        let located = |place: usize, error: TransportError| InversionError {
            depth_cm: self.depths_cm.get(place / channels.len()).copied(),
            ..InversionError::at_wavelength(place % channels.len(), error)
        };
        for (place, value) in self.present() {
            let check = values.check(value).and_then(|()| deviations.check(self.standard_deviations[place]));
            check.map_err(|error| located(place, error.into()))?;
        }
        match self.data(channels).points.iter().find(|point| point.correlation > MAX_CORRELATION) {
            Some(point) => Err(located(point.place, channels.given_twice())),
            None => Ok(()),
        }
    }

    /// Number of depths; 1 of an albedo or a transmittance.
    pub(super) fn rows(&self) -> usize {
        if self.quantity.is_at_depth() { self.depths_cm.len() } else { 1 }
    }

    /// Indices and values of the measurements that are not missing.
    pub(super) fn present(&self) -> impl Iterator<Item = (usize, f64)> {
        self.values.iter().copied().enumerate().filter(|(_, value)| !value.is_nan())
    }

    /// Whether there is a value in a channel. Each row has one value for each channel.
    pub(super) fn has_data_at(&self, channel: usize) -> bool {
        let channels = self.values.len() / self.rows();
        self.values.iter().skip(channel).step_by(channels).any(|value| !value.is_nan())
    }

    pub(super) fn data(&self, channels: &Channels<'_>) -> Data {
        let mut present: Vec<(usize, f64)> = self.present().collect();
        let key = |place: usize| (place / channels.len(), channels.wavelengths_nm[place % channels.len()]);
        present.sort_by(|(a, _), (b, _)| {
            let ((row, nm), (other_row, other_nm)) = (key(*a), key(*b));
            row.cmp(&other_row).then(nm.total_cmp(&other_nm))
        });
        let before = std::iter::once(None).chain(present.iter().map(|(place, _)| Some(*place)));
        let point = |(before, (place, value)): (Option<usize>, &(usize, f64))| {
            let (row, nm) = key(*place);
            // Errors at different depths are independent.
            let before = before.map(key).filter(|(row_before, _)| *row_before == row);
            let distance_nm = before.map_or(f64::INFINITY, |(_, nm_before)| nm - nm_before);
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

    /// Measured values less the values of a model, in units of the errors. `model` gives the value at an index.
    pub(super) fn residuals<'d>(&'d self, model: impl Fn(usize) -> f64 + 'd) -> impl Iterator<Item = f64> + 'd {
        self.decorrelated(move |point| point.value - model(point.place))
    }

    /// The derivative of the model at each index, in units of the errors.
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
    use nalgebra::{DMatrix, DVector};

    use super::*;

    /// |u|² = zᵀ C⁻¹ z with the dense inverse of the correlations, for unsorted wavelengths with one missing.
    #[test]
    fn residuals_are_those_of_the_inverse_covariance() {
        let channels = Channels::new(&[700.0, 400.0, 450.0, 900.0, 430.0], None);
        let values = vec![0.9, 0.95, f64::NAN, 0.7, 0.96];
        let standard_deviations = vec![0.01, 0.02, f64::NAN, 0.005, 0.01];
        let measured = Measured {
            quantity: Quantity::Albedo,
            depths_cm: Vec::new(),
            values,
            standard_deviations,
            scale_error: 0.0,
            correlation_nm: 80.0,
        };
        let data = measured.data(&channels);
        let sum: f64 = data.residuals(|place| 0.9 + 0.01 * place as f64).map(|u| u * u).sum();
        let places = [0, 1, 3, 4];
        let covariance = DMatrix::from_fn(4, 4, |i, j| {
            let (i, j) = (places[i], places[j]);
            let [a, b] = [i, j].map(|place: usize| measured.standard_deviations[place]);
            a * b * (-(channels.wavelengths_nm[i] - channels.wavelengths_nm[j]).abs() / 80.0).exp()
        });
        let off = DVector::from_fn(4, |i, _| measured.values[places[i]] - 0.9 - 0.01 * places[i] as f64);
        let expected = off.dot(&(covariance.try_inverse().unwrap() * &off));
        assert!((sum / expected - 1.0).abs() < 1e-12, "{sum} {expected}");
        assert_eq!(data.len(), 4);
    }
}
