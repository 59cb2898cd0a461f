//! Sums over vectors of four systems at once, and quotients of such sums.

use rayon::prelude::*;
use wide::{f32x4, f64x4};

/// Number of rows of a task. Tasks are summed in a fixed order, so sums do not depend on the number of threads.
pub(crate) const ROWS_PER_TASK: usize = 1 << 10;

pub(crate) fn wide(value: f32x4) -> f64x4 {
    f64x4::from(value.to_array().map(f64::from))
}

#[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
pub(crate) fn narrow(value: f64x4) -> f32x4 {
    f32x4::from(value.to_array().map(|value| value as f32))
}

/// A quotient; 0 where the divisor is not positive, as for a system that is solved exactly.
pub(crate) fn ratio(dividend: f64x4, divisor: f64x4) -> f64x4 {
    let (dividend, divisor) = (dividend.to_array(), divisor.to_array());
    f64x4::from(std::array::from_fn(|k| if divisor[k] > 0.0 { dividend[k] / divisor[k] } else { 0.0 }))
}

/// A sum over rows in an order that does not depend on the number of threads.
pub(crate) fn sum(vector: &[f32x4], term: impl Fn(usize, &f32x4) -> f64x4 + Sync) -> f64x4 {
    let task = |(task, chunk): (usize, &[f32x4])| {
        let terms = chunk.iter().enumerate().map(|(k, value)| term(task * ROWS_PER_TASK + k, value));
        terms.fold(f64x4::ZERO, |sum, term| sum + term)
    };
    let parts: Vec<f64x4> = vector.par_chunks(ROWS_PER_TASK).enumerate().map(task).collect();
    parts.into_iter().fold(f64x4::ZERO, |sum, part| sum + part)
}

/// The sum as by [`sum`], for terms that change the rows.
pub(crate) fn sum_mut(vector: &mut [f32x4], term: impl Fn(usize, &mut f32x4) -> f64x4 + Sync) -> f64x4 {
    let task = |(task, chunk): (usize, &mut [f32x4])| {
        let terms = chunk.iter_mut().enumerate().map(|(k, value)| term(task * ROWS_PER_TASK + k, value));
        terms.fold(f64x4::ZERO, |sum, term| sum + term)
    };
    let parts: Vec<f64x4> = vector.par_chunks_mut(ROWS_PER_TASK).enumerate().map(task).collect();
    parts.into_iter().fold(f64x4::ZERO, |sum, part| sum + part)
}
