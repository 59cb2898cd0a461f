//! Weighted least squares by Levenberg's (1944) and Marquardt's (1963, doi:10.1137/0111030) damped steps.
//!
//! Each step solves (JᵀJ + λ diag JᵀJ) δ = −Jᵀr for residuals r in units of their standard errors, with J by forward
//! differences. Parameters are clamped to their ranges.

use nalgebra::{DMatrix, DVector};

/// A parameter to fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Parameter {
    /// Initial value.
    pub(crate) start: f64,
    /// Least value.
    pub(crate) least: f64,
    /// Greatest value.
    pub(crate) greatest: f64,
    /// Step of the finite differences.
    pub(crate) step: f64,
}

/// The minimum of the sum of squares.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Minimum {
    /// Parameters at the minimum.
    pub(crate) values: Vec<f64>,
    /// Sum of the squared residuals.
    pub(crate) sum_of_squares: f64,
    /// (JᵀJ)⁻¹, the covariance of the parameters if the residuals are independent with unit variance. A parameter at an
    /// end of its range counts as known: its row and column are 0.
    pub(crate) covariance: DMatrix<f64>,
}

const MOST_STEPS: usize = 60;
/// The search ends when the sum of squares falls by less than this fraction.
const GAIN: f64 = 1e-10;

/// Finds the parameters with the least sum of squared residuals.
pub(crate) fn least_squares(residuals: impl Fn(&[f64]) -> Vec<f64>, parameters: &[Parameter]) -> Minimum {
    let at = |values: &[f64]| DVector::from_vec(residuals(values));
    let mut values: Vec<f64> = parameters.iter().map(|parameter| parameter.start).collect();
    let mut now = at(&values);
    let mut damping = 1e-3;
    for _ in 0..MOST_STEPS {
        let (slopes, free) = differences(&at, &values, &now, parameters);
        let gradient = slopes.tr_mul(&now);
        let curvature = slopes.tr_mul(&slopes);
        let mut gained = None;
        while gained.is_none() && damping < 1e12 {
            let mut damped = curvature.clone();
            for i in 0..parameters.len() {
                damped[(i, i)] += damping * curvature[(i, i)];
                if !free[i] {
                    damped[(i, i)] += 1.0;
                }
            }
            let step = damped.cholesky().map(|factors| factors.solve(&gradient));
            let trial: Vec<f64> = step.map_or_else(
                || values.clone(),
                |step| {
                    (0..values.len())
                        .map(|i| (values[i] - step[i]).clamp(parameters[i].least, parameters[i].greatest))
                        .collect()
                },
            );
            let trial_residuals = at(&trial);
            if trial_residuals.norm_squared() < now.norm_squared() {
                gained = Some(1.0 - trial_residuals.norm_squared() / now.norm_squared());
                (values, now) = (trial, trial_residuals);
                damping *= 0.1;
            } else {
                damping *= 10.0;
            }
        }
        if gained.is_none_or(|gain| gain < GAIN) {
            break;
        }
    }
    let (slopes, free) = differences(&at, &values, &now, parameters);
    Minimum { covariance: covariance(&slopes, &free), sum_of_squares: now.norm_squared(), values }
}

/// The slopes of the residuals, and which parameters are free to move downhill; the slopes of the others are 0.
fn differences(
    at: &impl Fn(&[f64]) -> DVector<f64>,
    values: &[f64],
    now: &DVector<f64>,
    parameters: &[Parameter],
) -> (DMatrix<f64>, Vec<bool>) {
    let mut slopes = DMatrix::zeros(now.len(), values.len());
    let mut free = vec![true; values.len()];
    for (i, Parameter { least, greatest, step, .. }) in parameters.iter().enumerate() {
        let mut moved = values.to_vec();
        // A step beyond the greatest value goes down instead.
        let step = if values[i] + step > *greatest { -step } else { *step };
        moved[i] += step;
        let slope = (at(&moved) - now) / step;
        let downhill = -slope.dot(now);
        free[i] = !(values[i] <= *least && downhill < 0.0 || values[i] >= *greatest && downhill > 0.0);
        if free[i] {
            slopes.set_column(i, &slope);
        }
    }
    (slopes, free)
}

fn covariance(slopes: &DMatrix<f64>, free: &[bool]) -> DMatrix<f64> {
    let mut curvature = slopes.tr_mul(slopes);
    for (i, free) in free.iter().enumerate() {
        if !free {
            curvature[(i, i)] = 1.0;
        }
    }
    let mut inverse =
        curvature.try_inverse().unwrap_or_else(|| DMatrix::from_element(free.len(), free.len(), f64::NAN));
    for (i, free) in free.iter().enumerate() {
        if !free {
            inverse[(i, i)] = 0.0;
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(start: f64, least: f64) -> Parameter {
        Parameter { start, least, greatest: 9.0, step: 1e-6 }
    }

    /// Rosenbrock's (1960) function has its minimum at (1, 1).
    #[test]
    fn finds_the_minimum_of_rosenbrocks_function() {
        let valley = |x: &[f64]| vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]];
        let found = least_squares(valley, &[parameter(-1.2, -9.0), parameter(1.0, -9.0)]);
        assert!((found.values[0] - 1.0).abs() < 1e-4 && (found.values[1] - 1.0).abs() < 1e-4, "{found:?}");
    }

    /// A line y = 2 + 3x: the covariance is that of linear regression.
    #[test]
    fn covariance_is_that_of_linear_regression() {
        let line = |p: &[f64]| (0..5).map(|x| p[0] + p[1] * f64::from(x) - 2.0 - 3.0 * f64::from(x)).collect();
        let found = least_squares(line, &[parameter(0.0, -9.0), parameter(0.0, -9.0)]);
        // Σx = 10, Σx² = 30, n = 5: var(slope) = 5/50, var(offset) = 30/50, covariance −10/50.
        let expected = [[0.6, -0.2], [-0.2, 0.1]];
        for (i, row) in expected.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert!((found.covariance[(i, j)] - value).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn parameters_stay_in_their_ranges() {
        let pull = |p: &[f64]| vec![p[0] + 1.0, p[1] - 2.0];
        let found = least_squares(pull, &[parameter(3.0, 0.0), parameter(0.0, 0.0)]);
        assert!(found.values[0].abs() < f64::MIN_POSITIVE && (found.values[1] - 2.0).abs() < 1e-6);
        assert!(found.covariance[(0, 0)].abs() < f64::MIN_POSITIVE && found.covariance[(1, 1)] > 0.9);
    }
}
