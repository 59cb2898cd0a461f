//! Natural cubic splines over the thickness of snow, for several components at once.
//!
//! Between knots y is cubic with continuous second derivative, and that derivative is 0 at both ends (de Boor 2001,
//! *A Practical Guide to Splines*, ch. IV). The spline is linear in the values at the knots, so that interpolating l'
//! coefficients is the same as interpolating the spectra that they stand for.

/// How much the values and second derivatives at two neighbouring knots count at some place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Piece {
    /// The knot below.
    pub(crate) knot: usize,
    /// Weights of the values at both knots.
    pub(crate) values: [f32; 2],
    /// Weights of the second derivatives at both knots.
    pub(crate) curvatures: [f32; 2],
}

/// The piece that holds at `x`, at or above the first knot; beyond the last knot it goes on in a straight line.
#[inline]
pub(crate) fn piece(knots: &[f32], x: f32) -> Piece {
    let last = knots.len() - 1;
    let knot = knots[1..last].partition_point(|other| *other <= x);
    let width = knots[knot + 1] - knots[knot];
    let t = (x - knots[knot]) / width;
    if t > 1.0 {
        let beyond = (t - 1.0) * width * width / 6.0;
        return Piece { knot, values: [1.0 - t, t], curvatures: [beyond, 0.0] };
    }
    let s = 1.0 - t;
    let scale = width * width / 6.0;
    Piece { knot, values: [s, t], curvatures: [scale * (s * s * s - s), scale * (t * t * t - t)] }
}

/// Second derivatives at the knots, 0 at both ends.
pub(crate) fn curvatures(knots: &[f64], values: &[f64]) -> Vec<f64> {
    let count = knots.len();
    let mut curvature = vec![0.0; count];
    let mut upper = vec![0.0; count];
    for i in 1..count - 1 {
        let (before, after) = (knots[i] - knots[i - 1], knots[i + 1] - knots[i]);
        let slopes = (values[i + 1] - values[i]) / after - (values[i] - values[i - 1]) / before;
        let pivot = 2.0 * (before + after) - before * upper[i - 1];
        upper[i] = after / pivot;
        curvature[i] = (6.0 * slopes - before * curvature[i - 1]) / pivot;
    }
    for i in (1..count - 1).rev() {
        curvature[i] -= upper[i] * curvature[i + 1];
    }
    curvature
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(knots: &[f64], values: &[f64], x: f32) -> f32 {
        #[expect(clippy::cast_possible_truncation, reason = "a test in single precision")]
        let single = |v: &[f64]| v.iter().map(|v| *v as f32).collect::<Vec<_>>();
        let (second, y) = (single(&curvatures(knots, values)), single(values));
        let piece = piece(&single(knots), x);
        let k = piece.knot;
        piece.values[0] * y[k]
            + piece.values[1] * y[k + 1]
            + piece.curvatures[0] * second[k]
            + piece.curvatures[1] * second[k + 1]
    }

    #[test]
    fn a_line_is_its_own_spline() {
        let knots: Vec<f64> = vec![0.0, 0.3, 1.1, 2.0];
        let line: Vec<f64> = knots.iter().map(|x| 1.0 - 2.0 * x).collect();
        for x in [0.0, 0.2, 0.7, 1.9, 2.0, 5.0_f32] {
            assert!((at(&knots, &line, x) - (1.0 - 2.0 * x)).abs() < 1e-5, "a line, also beyond the end");
        }
    }

    #[test]
    fn second_derivatives_solve_the_spline_equations() {
        let (knots, values) = ([0.0, 1.0, 3.0, 4.0, 7.0], [1.0, -2.0, 0.5, 3.0, 2.0]);
        let m = curvatures(&knots, &values);
        for i in 1..4 {
            let (h, k) = (knots[i] - knots[i - 1], knots[i + 1] - knots[i]);
            let left = h * m[i - 1] + 2.0 * (h + k) * m[i] + k * m[i + 1];
            let right = 6.0 * ((values[i + 1] - values[i]) / k - (values[i] - values[i - 1]) / h);
            assert!((left - right).abs() < 1e-12);
        }
        assert!(m[0].abs() < 1e-15 && m[4].abs() < 1e-15);
    }

    #[test]
    fn passes_through_its_knots_without_a_step() {
        let (knots, values) = ([0.0, 1.0, 3.0, 4.0], [1.0, -2.0, 0.5, 3.0]);
        for (x, y) in [(0.0, 1.0), (1.0, -2.0), (3.0, 0.5), (4.0, 3.0_f32)] {
            for nudge in [-1e-5, 1e-5_f32] {
                if x + nudge > 0.0 {
                    assert!((at(&knots, &values, x + nudge) - y).abs() < 2e-4);
                }
            }
        }
    }
}
