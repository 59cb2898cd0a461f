//! Chebyshev polynomials of two arguments (Press et al. 2007, Numerical Recipes, section 5.8).

use std::f64::consts::PI;

/// Σ c T_i(x) T_j(y), for x and y of −1 to 1.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chebyshev2 {
    /// Coefficients of three polynomials together: [degree in x][degree in y][polynomial].
    pub(super) rows: Vec<Vec<[f64; 3]>>,
}

/// Extrema of the Chebyshev polynomial of degree 2 (degree + 1). Every second one is a node of an interpolation of
/// `degree`, and the others lie between the nodes and at the ends.
pub(super) fn nodes_and_middles(degree: usize) -> Vec<f64> {
    let last = 2 * (degree + 1);
    (0..=last).map(|k| (PI * fraction(k, last)).cos()).collect()
}

impl Chebyshev2 {
    /// Interpolates values at the points of [`nodes_and_middles`], [x][y], of which it takes the nodes.
    pub(super) fn interpolate(values: &[Vec<[f64; 3]>]) -> Self {
        let nodes = |count: usize| count / 2;
        let (nx, ny) = (nodes(values.len()), nodes(values[0].len()));
        let weight = |order: usize, node: usize, count: usize| {
            let scale = if order == 0 { 1.0 } else { 2.0 };
            scale * (PI * fraction(order * (2 * node + 1), 2 * count)).cos() / fraction(count, 1)
        };
        let coefficient = |i: usize, j: usize| {
            let mut sums = [0.0; 3];
            for (x, row) in values.iter().skip(1).step_by(2).enumerate() {
                for (y, value) in row.iter().skip(1).step_by(2).enumerate() {
                    let weight = weight(i, x, nx) * weight(j, y, ny);
                    sums.iter_mut().zip(value).for_each(|(sum, value)| *sum += weight * value);
                }
            }
            sums
        };
        Self { rows: (0..nx).map(|i| (0..ny).map(|j| coefficient(i, j)).collect()).collect() }
    }

    /// The three sums at a point.
    pub(super) fn at(&self, x: f64, y: f64) -> [f64; 3] {
        let polynomials = |argument: f64, count: usize| -> Vec<f64> {
            let next = |pair: &mut [f64; 2]| {
                let [current, following] = *pair;
                *pair = [following, 2.0 * argument * following - current];
                Some(current)
            };
            std::iter::repeat_n((), count).scan([1.0, argument], |pair, ()| next(pair)).collect()
        };
        let (in_x, in_y) = (polynomials(x, self.rows.len()), polynomials(y, self.rows[0].len()));
        let mut sums = [0.0; 3];
        for (row, px) in self.rows.iter().zip(in_x) {
            for (coefficients, py) in row.iter().zip(&in_y) {
                sums.iter_mut().zip(coefficients).for_each(|(sum, coefficient)| *sum += coefficient * px * py);
            }
        }
        sums
    }
}

#[expect(clippy::cast_precision_loss, reason = "small numbers")]
fn fraction(numerator: usize, denominator: usize) -> f64 {
    numerator as f64 / denominator as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_is_its_own_interpolation() {
        let polynomial = |x: f64, y: f64| [1.0 + x * y, x.powi(3) - 2.0 * y * y, 0.5];
        let (xs, ys) = (nodes_and_middles(3), nodes_and_middles(2));
        let values: Vec<Vec<_>> = xs.iter().map(|x| ys.iter().map(|y| polynomial(*x, *y)).collect()).collect();
        let interpolated = Chebyshev2::interpolate(&values);
        for (x, y) in [(-1.0, 0.3), (0.77, -0.9), (0.1, 1.0)] {
            for (ours, exact) in interpolated.at(x, y).iter().zip(polynomial(x, y)) {
                assert!((ours - exact).abs() < 1e-14, "{ours} {exact} at {x} {y}");
            }
        }
    }
}
