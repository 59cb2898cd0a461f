//! Conjugate gradients with Jacobi's preconditioner (Saad 2003, *Iterative Methods for Sparse Linear Systems*,
//! algorithm 9.1), for four systems at once.

use rayon::prelude::*;
use wide::{f32x4, f64x4};

use crate::system::System;
use crate::vectors::{ROWS_PER_TASK, narrow, ratio, sum, sum_mut, wide};

/// Greatest number of iterations. Fifty to two hundred are usual.
const MAX_ITERATIONS: u64 = 2000;

/// Solves the systems for one right-hand side each, from a start. The iteration ends when the residual, in the norm of
/// the preconditioner, is small relative to the right-hand side or to the residual of the start. Returns the solutions
/// and the number of iterations.
pub(crate) fn solve(
    system: &System,
    right: &[f32x4],
    start: Option<Vec<f32x4>>,
    [tolerance, residual_left]: [f64; 2],
) -> (Vec<f32x4>, u64) {
    let count = system.len();
    let inverse = &system.inverse_diagonal;
    let mut values = start.unwrap_or_else(|| vec![f32x4::ZERO; count]);
    let mut residual = vec![f32x4::ZERO; count];
    residual.par_chunks_mut(ROWS_PER_TASK).enumerate().for_each(|(task, residual)| {
        for (k, residual) in residual.iter_mut().enumerate() {
            let row = task * ROWS_PER_TASK + k;
            *residual = right[row] - system.row_product(row, &values);
        }
    });
    let mut direction: Vec<f32x4> =
        residual.iter().zip(inverse).map(|(residual, inverse)| *residual * *inverse).collect();
    let mut product = vec![f32x4::ZERO; count];
    let mut norm = sum(&residual, |row, residual| squared(*residual, inverse[row]));
    let goal = sum(right, |row, right| squared(*right, inverse[row])) * f64x4::splat(tolerance * tolerance);
    let goal = goal.max(norm * f64x4::splat(residual_left * residual_left));
    let mut iterations = 0;
    while norm.simd_gt(goal).any() && iterations < MAX_ITERATIONS {
        let energy = sum_mut(&mut product, |row, product| {
            *product = system.row_product(row, &direction);
            wide(*product) * wide(direction[row])
        });
        let step = narrow(ratio(norm, energy));
        values.par_chunks_mut(ROWS_PER_TASK).zip(direction.par_chunks(ROWS_PER_TASK)).for_each(
            |(values, direction)| {
                values.iter_mut().zip(direction).for_each(|(value, direction)| *value += step * *direction);
            },
        );
        let next = sum_mut(&mut residual, |row, residual| {
            *residual -= step * product[row];
            squared(*residual, inverse[row])
        });
        let share = narrow(ratio(next, norm));
        norm = next;
        direction.par_chunks_mut(ROWS_PER_TASK).enumerate().for_each(|(task, direction)| {
            let first = task * ROWS_PER_TASK;
            for (k, direction) in direction.iter_mut().enumerate() {
                *direction = residual[first + k] * inverse[first + k] + share * *direction;
            }
        });
        iterations += 1;
    }
    (values, iterations)
}

fn squared(value: f32x4, inverse: f32x4) -> f64x4 {
    wide(value * value * inverse)
}
