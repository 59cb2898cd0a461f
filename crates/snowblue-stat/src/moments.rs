//! Mean and variance in one pass without cancellation (Welford 1962, Technometrics 4, 419).

/// Running mean and variance.
#[derive(Debug, Clone, Copy, Default)]
pub struct Moments {
    count: u64,
    mean: f64,
    sum_of_squares: f64,
}

impl Moments {
    /// Adds a sample.
    pub fn push(&mut self, sample: f64) {
        self.count += 1;
        let deviation = sample - self.mean;
        self.mean += deviation / self.count as f64;
        self.sum_of_squares += deviation * (sample - self.mean);
    }

    /// Number of samples.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Mean of the samples; 0 without samples.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Unbiased estimate of the population variance; NaN for fewer than two samples.
    pub fn variance(&self) -> f64 {
        self.sum_of_squares / (self.count as f64 - 1.0).max(0.0)
    }

    /// Standard error of the mean; NaN for fewer than two samples.
    pub fn standard_error(&self) -> f64 {
        (self.variance() / self.count as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_offset_does_not_change_the_variance() {
        let mut moments = Moments::default();
        assert!(moments.variance().is_nan() && moments.standard_error().is_nan());
        for sample in [4.0, 7.0, 13.0, 16.0] {
            moments.push(1e9 + sample);
        }
        assert_eq!((moments.count(), moments.mean(), moments.variance()), (4, 1e9 + 10.0, 30.0));
        assert!((moments.standard_error() - 7.5_f64.sqrt()).abs() < 1e-14);
    }
}
