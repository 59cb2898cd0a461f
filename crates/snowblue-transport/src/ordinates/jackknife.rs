//! Standard errors from a grain tally, by the jackknife over its batches (Quenouille 1956,
//! doi:10.1093/biomet/43.3-4.353).

use crate::medium::BATCHES;
use crate::slab::Estimate;

/// A result from all batches of a tally, and from all but each one.
pub(super) struct Jackknife<T> {
    whole: T,
    parts: Vec<T>,
}

impl<T> Jackknife<T> {
    /// Computes `result` with all batches, then without each.
    pub(super) fn new(result: impl Fn(Option<usize>) -> T) -> Self {
        Self { whole: result(None), parts: (0..BATCHES).map(|batch| result(Some(batch))).collect() }
    }

    /// Computes `result` with all batches only: standard errors are NaN.
    pub(super) fn without_errors(result: impl Fn(Option<usize>) -> T) -> Self {
        Self { whole: result(None), parts: Vec::new() }
    }

    /// The result of all batches.
    pub(super) fn whole(&self) -> &T {
        &self.whole
    }

    /// A quantity of the result with its standard error, √((B − 1)/B Σ (v_b − v̄)²).
    pub(super) fn estimate(&self, quantity: impl Fn(&T) -> f64) -> Estimate {
        let parts: Vec<f64> = self.parts.iter().map(&quantity).collect();
        let count = parts.len() as f64;
        let mean = parts.iter().sum::<f64>() / count;
        let squares: f64 = parts.iter().map(|part| (part - mean).powi(2)).sum();
        Estimate { value: quantity(&self.whole), standard_error: ((count - 1.0) / count * squares).sqrt() }
    }
}
