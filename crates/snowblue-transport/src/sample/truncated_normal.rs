//! Truncated normal distributions, for the sphericity and the facetness of grains.

use snowblue_base::{ParameterRange, RangeError};

use crate::TransportError;
use crate::parameters::{FACETNESS, SPHERICITY};
use crate::quadrature::Quadrature;

/// Ranges of the sphericity, and of its standard deviation before truncation.
pub(super) const SPHERICITY_RANGES: [ParameterRange; 2] =
    [SPHERICITY.range, ParameterRange::new("standard deviation of sphericity", 0.0, 10.0, "")];
/// Ranges of the facetness, and of its standard deviation before truncation.
pub(super) const FACETNESS_RANGES: [ParameterRange; 2] =
    [FACETNESS.range, ParameterRange::new("standard deviation of facetness", 0.0, 10.0, "")];

/// Standard deviation of the facetness that a mean represents (the paper's Table S1).
const MEAN_FACETNESS_DEVIATION: f64 = 0.075;
/// Half-width of the facetness range that a mean represents (the paper's Table S1).
const MEAN_FACETNESS_HALF_RANGE: f64 = 0.1;

/// A normal distribution truncated to a range. Mean and standard deviation are the values before truncation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TruncatedNormal {
    /// Least value.
    pub min: f64,
    /// Greatest value.
    pub max: f64,
    /// Mean before truncation.
    pub mean: f64,
    /// Standard deviation before truncation; 0 for a single value.
    pub standard_deviation: f64,
}

impl TruncatedNormal {
    /// A single value.
    #[must_use]
    pub fn exactly(value: f64) -> Self {
        Self { min: value, max: value, mean: value, standard_deviation: 0.0 }
    }

    /// The facetness distribution that a mean represents: mean ± 0.1 within 0–1, standard deviation 0.075.
    #[must_use]
    pub fn facetness_around(mean: f64) -> Self {
        Self {
            min: (mean - MEAN_FACETNESS_HALF_RANGE).max(FACETNESS.range.least),
            max: (mean + MEAN_FACETNESS_HALF_RANGE).min(FACETNESS.range.greatest),
            mean,
            standard_deviation: MEAN_FACETNESS_DEVIATION,
        }
    }

    /// The facetness that numbers state: a mean, as in [`facetness_around`](Self::facetness_around), or least and
    /// greatest value, mean and standard deviation.
    ///
    /// # Errors
    /// For another count of numbers, and for values out of range.
    pub fn facetness(numbers: &[f64]) -> Result<Self, TransportError> {
        let expected = "a mean (0.3), or min, max, mean and standard deviation (0.2, 0.4, 0.3, 0.075)";
        Self::stated(numbers, Self::facetness_around, &FACETNESS_RANGES, expected)
    }

    /// The sphericity that numbers state: one value, or least and greatest value, mean and standard deviation.
    ///
    /// # Errors
    /// For another count of numbers, and for values out of range.
    pub fn sphericity(numbers: &[f64]) -> Result<Self, TransportError> {
        let expected = "one value (0.8), or min, max, mean and standard deviation (0.7, 0.9, 0.8, 0.1)";
        Self::stated(numbers, Self::exactly, &SPHERICITY_RANGES, expected)
    }

    fn stated(
        numbers: &[f64],
        alone: fn(f64) -> Self,
        ranges: &[ParameterRange; 2],
        expected: &'static str,
    ) -> Result<Self, TransportError> {
        let stated = match *numbers {
            [value] => alone(value),
            [min, max, mean, standard_deviation] => Self { min, max, mean, standard_deviation },
            _ => {
                let (quantity, count) = (ranges[0].quantity, numbers.len());
                return Err(TransportError::Count { quantity, count, expected });
            }
        };
        stated.check(ranges)?;
        Ok(stated)
    }

    /// Quantiles of the distribution weighted by `weight`.
    pub(crate) fn weighted(&self, weight: impl Fn(f64) -> f64) -> Quantiles {
        let (low, high) = self.support();
        Quantiles::new(low, high, |x| self.relative_density(x) * weight(x))
    }

    /// ⟨f⟩ over the distribution.
    pub(crate) fn mean_of(&self, f: impl Fn(f64) -> f64) -> f64 {
        let (low, high) = self.support();
        if low >= high {
            return f(low);
        }
        let rule = Quadrature::half_range(48);
        let (mut sum, mut norm) = (0.0, 0.0);
        for (node, weight) in rule.cosines.iter().zip(&rule.weights) {
            let x = low + node * (high - low);
            let probability = weight * self.relative_density(x);
            sum += probability * f(x);
            norm += probability;
        }
        sum / norm
    }

    /// The part of the range that holds all but 10⁻¹⁵ of the distribution.
    fn support(&self) -> (f64, f64) {
        let reach = 8.0 * self.standard_deviation;
        (self.min.max(self.mean - reach), self.max.min(self.mean + reach))
    }

    fn relative_density(&self, x: f64) -> f64 {
        (-0.5 * ((x - self.mean) / self.standard_deviation).powi(2)).exp()
    }

    /// Checks values and standard deviation by their ranges.
    pub(super) fn check(&self, [range, deviations]: &[ParameterRange; 2]) -> Result<(), RangeError> {
        range.check(self.mean)?;
        range.check_interval(self.min, self.max)?;
        ParameterRange { least: self.min, greatest: self.max, ..*range }.check(self.mean)?;
        deviations.check(self.standard_deviation)
    }
}

/// The inverse of a cumulative distribution at equal steps of probability, linear between them.
#[derive(Debug, Clone)]
pub(crate) struct Quantiles(Vec<f64>);

impl Quantiles {
    /// Tabulates a density, which need not be normalised.
    pub(crate) fn new(low: f64, high: f64, density: impl Fn(f64) -> f64) -> Self {
        if low >= high {
            return Self(vec![low]);
        }
        const CELLS: usize = 8192;
        const STEPS: usize = 1024;
        let at = |i: usize| low + (high - low) * i as f64 / CELLS as f64;
        let mut cumulative = vec![0.0];
        for i in 0..CELLS {
            cumulative.push(cumulative[i] + 0.5 * (density(at(i)) + density(at(i + 1))));
        }
        let mut values = vec![low];
        let mut cell = 0;
        for step in 1..STEPS {
            let target = cumulative[CELLS] * step as f64 / STEPS as f64;
            while cumulative[cell + 1] < target {
                cell += 1;
            }
            let inside = (target - cumulative[cell]) / (cumulative[cell + 1] - cumulative[cell]);
            values.push(at(cell) + inside * (at(cell + 1) - at(cell)));
        }
        values.push(high);
        Self(values)
    }

    /// The value below which the fraction `uniform` of the distribution lies.
    #[inline]
    pub(crate) fn at(&self, uniform: f64) -> f64 {
        let last = self.0.len() - 1;
        if last == 0 {
            return self.0[0];
        }
        let place = uniform * last as f64;
        // A probability in (0, 1) times 1024 fits any integer.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ place ≤ 1024")]
        let cell = (place as usize).min(last - 1);
        self.0[cell] + (place - cell as f64) * (self.0[cell + 1] - self.0[cell])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_and_means_agree() {
        let distribution = TruncatedNormal { min: 0.7, max: 0.9, mean: 0.8, standard_deviation: 0.1 };
        let quantiles = distribution.weighted(|x| x * x);
        let count = 10_000;
        let mean =
            (0..count).map(|i| quantiles.at((f64::from(i) + 0.5) / f64::from(count))).sum::<f64>() / f64::from(count);
        let expected = distribution.mean_of(|x| x.powi(3)) / distribution.mean_of(|x| x * x);
        // Linear interpolation on 1024 steps of a smooth density.
        assert!((mean - expected).abs() < 1e-7, "{mean} {expected}");
    }
}
