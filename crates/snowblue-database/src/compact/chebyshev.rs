//! Chebyshev polynomials of two arguments (Press et al. 2007, Numerical Recipes, section 5.8).

use std::f64::consts::PI;

/// Σ c T_i(x) T_j(y), for x and y of −1 to 1.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chebyshev2 {
    /// Coefficients of three polynomials together: [degree in x][degree in y][polynomial]. Each row has at least one
    /// coefficient per polynomial, and its own greatest degree in y.
    pub(super) rows: Vec<Vec<[f64; 3]>>,
}

/// Extrema of the Chebyshev polynomial of degree 2 (degree + 1). Every second extremum is a node of an interpolation
/// of `degree`. The remaining extrema lie between the nodes and at the ends.
pub(super) fn nodes_and_middles(degree: usize) -> Vec<f64> {
    let last = 2 * (degree + 1);
    (0..=last).map(|k| (PI * fraction(k, last)).cos()).collect()
}

impl Chebyshev2 {
    /// Interpolates values at the points of [`nodes_and_middles`], [x][y]. Only the values at the nodes are used.
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

    /// One more than the greatest degree in y.
    pub(super) fn longest_row(&self) -> usize {
        self.rows.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// The polynomials with as few and as short coefficients as keep the sums within `tolerance` at all pairs of
    /// coordinates.
    ///
    /// Coefficients at the end of a row that are below a threshold are removed, and differences between the three
    /// polynomials below the threshold are removed too. All remaining coefficients are rounded to a thousandth of the
    /// tolerance. The threshold is the greatest threshold of a series that keeps the tolerance.
    pub(super) fn shortened(&self, tolerance: f64, points: [&[f64]; 2]) -> Self {
        const STEPS: u32 = 48;
        const STEPS_PER_OCTAVE: f64 = 4.0;
        let exact = self.at_all(points);
        let is_close = |short: &Self| {
            let sums = short.at_all(points);
            sums.iter().flatten().zip(exact.iter().flatten()).all(|(short, exact)| (short - exact).abs() <= tolerance)
        };
        let thresholds = (0..STEPS).map(|step| tolerance * (-f64::from(step) / STEPS_PER_OCTAVE).exp2());
        thresholds
            .map(|threshold| self.above(threshold, 1e-3 * tolerance))
            .find(is_close)
            .unwrap_or_else(|| self.clone())
    }

    /// The rows up to their last coefficients of at least a threshold, rounded to a power of ten of at most `unit`.
    /// Where the coefficients of the three polynomials differ from their middle by less than the threshold, the
    /// middle replaces them.
    fn above(&self, threshold: f64, unit: f64) -> Self {
        let scale = 10.0_f64.powf(-unit.log10().floor());
        let is_kept = |coefficients: &[f64; 3]| coefficients.iter().any(|value| value.abs() >= threshold);
        let length = |row: &[[f64; 3]]| row.iter().rposition(is_kept).map_or(0, |last| last + 1);
        let count = self.rows.iter().rposition(|row| length(row) > 0).map_or(1, |last| last + 1);
        let united = |&[x, y, z]: &[f64; 3]| {
            let (least, greatest) = (x.min(y).min(z), x.max(y).max(z));
            if greatest - least < 2.0 * threshold { [0.5 * (least + greatest); 3] } else { [x, y, z] }
        };
        let rounded = |coefficients: &[f64; 3]| united(coefficients).map(|value| (value * scale).round() / scale);
        let of_row = |row: &Vec<[f64; 3]>| row[..length(row).max(1)].iter().map(rounded).collect();
        Self { rows: self.rows[..count].iter().map(of_row).collect() }
    }

    /// The sums at all pairs of coordinates.
    fn at_all(&self, [xs, ys]: [&[f64]; 2]) -> Vec<[f64; 3]> {
        xs.iter().flat_map(|x| ys.iter().map(|y| self.at(*x, *y))).collect()
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
        let (in_x, in_y) = (polynomials(x, self.rows.len()), polynomials(y, self.longest_row()));
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

    /// A sum of decaying terms keeps its first terms, and the sum of the omitted terms is below the tolerance.
    #[test]
    fn few_coefficients_hold_a_tolerance() {
        let coefficient = |i: i32, j: i32| [0.5_f64.powi(i + 2 * j), 0.0, if i + j == 0 { 1.0 / 3.0 } else { 0.0 }];
        let full = Chebyshev2 { rows: (0..12).map(|i| (0..8).map(|j| coefficient(i, j)).collect()).collect() };
        let points = nodes_and_middles(20);
        let mut before = usize::MAX;
        for tolerance in [1e-3, 1e-2, 1e-1] {
            let short = full.shortened(tolerance, [&points, &points]);
            let count = short.rows.iter().map(Vec::len).sum();
            assert!(count < before, "{tolerance}: {count} {before}");
            before = count;
            for (x, y) in [(1.0, 1.0), (-0.4, 0.9), (0.1, -1.0)] {
                for (short, full) in short.at(x, y).iter().zip(full.at(x, y)) {
                    assert!((short - full).abs() <= tolerance, "{tolerance}: {short} {full} at {x} {y}");
                }
            }
        }
    }

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
