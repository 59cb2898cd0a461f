//! Cubic interpolation: natural splines, and the Lagrange polynomial through the nearest knots.
//!
//! **Natural cubic splines** over the thickness of snow, for several components at once. Between knots y is cubic with
//! a continuous second derivative, which is 0 at both ends (de Boor 2001, *A Practical Guide to Splines*, ch. IV).
//!
//! **The Lagrange polynomial** through the four nearest of unevenly spaced knots, two on either side (de Boor, ch.
//! I). Where neighbouring gaps differ by more than a factor of [`MAX_GAP_RATIO`], a cubic would oscillate, so a
//! straight line replaces it. The interpolation is continuous, exact for cubics and at its knots, and needs no end
//! conditions.
//!
//! Both are linear in the values at the knots, so interpolating coefficients is equivalent to interpolating the
//! spectra, or the logarithms of the spectra, that the coefficients represent.

use wide::f32x8;

/// Weights of the values and second derivatives at two neighbouring knots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Piece {
    /// The knot below.
    pub(crate) knot: usize,
    /// Weights of the values at both knots.
    pub(crate) values: [f32; 2],
    /// Weights of the second derivatives at both knots.
    pub(crate) curvatures: [f32; 2],
}

/// Ascending knots with fast interval look-up. Comparing with every knot is faster than a search for so few knots.
#[derive(Debug, Clone)]
pub(crate) struct Knots {
    first: f32,
    last: f32,
    /// The intervals between neighbouring knots.
    intervals: Vec<Interval>,
    /// All knots but the first and the last, eight at a time, padded with NaN, since no number is above NaN.
    inner: Vec<f32x8>,
}

/// The interval between two neighbouring knots.
#[derive(Debug, Clone, Copy)]
struct Interval {
    start: f32,
    width: f32,
    inverse_width: f32,
}

/// A position between the knots.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Position {
    /// The knot below.
    pub(crate) knot: usize,
    /// Distance from that knot to the next.
    pub(crate) width: f32,
    /// Fraction of that distance; above 1 or below 0 outside the knots.
    pub(crate) fraction: f32,
}

impl Knots {
    pub(crate) fn new(knots: &[f64]) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "look-ups run in single precision")]
        let knots: Vec<f32> = knots.iter().map(|knot| *knot as f32).collect();
        let interval = |pair: &[f32]| {
            let width = pair[1] - pair[0];
            Interval { start: pair[0], width, inverse_width: width.recip() }
        };
        let intervals: Vec<Interval> = knots.windows(2).map(interval).collect();
        let inner: Vec<f32> = intervals.iter().skip(1).map(|interval| interval.start).collect();
        let padded = |some: &[f32]| f32x8::new(std::array::from_fn(|lane| some.get(lane).copied().unwrap_or(f32::NAN)));
        let inner = inner.chunks(8).map(padded).collect();
        Self { first: knots[0], last: knots[knots.len() - 1], intervals, inner }
    }

    pub(crate) fn len(&self) -> usize {
        self.intervals.len() + 1
    }

    pub(crate) fn first(&self) -> f32 {
        self.first
    }

    pub(crate) fn last(&self) -> f32 {
        self.last
    }

    /// The interval that contains `x`. The first and the last interval extend beyond the ends. Needs two knots or more.
    #[inline]
    pub(crate) fn position(&self, x: f32) -> Position {
        let x8 = f32x8::splat(x);
        let knots_below = self.inner.iter().map(|eight| eight.simd_le(x8).to_bitmask().trailing_ones());
        let knot = knots_below.sum::<u32>() as usize;
        let interval = &self.intervals[knot];
        Position { knot, width: interval.width, fraction: (x - interval.start) * interval.inverse_width }
    }
}

const SIXTH: f32 = 1.0 / 6.0;

/// The weights at `x`, which is at or above the first knot. Beyond the last knot the spline continues as a straight
/// line.
#[inline]
pub(crate) fn piece(knots: &Knots, x: f32) -> Piece {
    let Position { knot, width, fraction: t } = knots.position(x);
    if t > 1.0 {
        let beyond = (t - 1.0) * width * width * SIXTH;
        return Piece { knot, values: [1.0 - t, t], curvatures: [beyond, 0.0] };
    }
    let s = 1.0 - t;
    let scale = width * width * SIXTH;
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

/// Largest ratio of neighbouring gaps for which a cubic is used.
const MAX_GAP_RATIO: f64 = 2.5;

/// Weights of the neighbouring knots at `x`: weights of all knots if there are fewer than four, and of a single knot
/// where `x` is that knot.
pub(crate) fn weights(knots: &[f64], x: f64) -> Vec<(usize, f64)> {
    let points = knots.len().min(4);
    let below = knots.partition_point(|knot| *knot <= x);
    let first = below.saturating_sub(2).min(knots.len() - points);
    let near = first..first + points;
    let gaps: Vec<f64> = knots[near.clone()].windows(2).map(|two| two[1] - two[0]).collect();
    let uneven = gaps.windows(2).any(|two| two[0].max(two[1]) > MAX_GAP_RATIO * two[0].min(two[1]));
    let near = if uneven {
        let below = below.clamp(1, knots.len() - 1);
        below - 1..below + 1
    } else {
        near
    };
    let weight = |i: usize| {
        let others = near.clone().filter(|j| *j != i);
        others.map(|j| (x - knots[j]) / (knots[i] - knots[j])).product::<f64>()
    };
    near.clone().map(|i| (i, weight(i))).filter(|(_, weight)| weight.abs() > 0.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evaluate(knots: &[f64], values: &[f64], x: f32) -> f32 {
        #[expect(clippy::cast_possible_truncation, reason = "a test in single precision")]
        let single = |v: &[f64]| v.iter().map(|v| *v as f32).collect::<Vec<_>>();
        let (second, y) = (single(&curvatures(knots, values)), single(values));
        let piece = piece(&Knots::new(knots), x);
        let k = piece.knot;
        piece.values[0] * y[k]
            + piece.values[1] * y[k + 1]
            + piece.curvatures[0] * second[k]
            + piece.curvatures[1] * second[k + 1]
    }

    #[test]
    fn spline_through_a_line_is_the_line() {
        let knots: Vec<f64> = vec![0.0, 0.3, 1.1, 2.0];
        let line: Vec<f64> = knots.iter().map(|x| 1.0 - 2.0 * x).collect();
        for x in [0.0, 0.2, 0.7, 1.9, 2.0, 5.0_f32] {
            assert!((evaluate(&knots, &line, x) - (1.0 - 2.0 * x)).abs() < 1e-5, "not a line at {x}");
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
    fn spline_is_continuous_at_its_knots() {
        let (knots, values) = ([0.0, 1.0, 3.0, 4.0], [1.0, -2.0, 0.5, 3.0]);
        for (x, y) in [(0.0, 1.0), (1.0, -2.0), (3.0, 0.5), (4.0, 3.0_f32)] {
            for nudge in [-1e-5, 1e-5_f32] {
                if x + nudge > 0.0 {
                    assert!((evaluate(&knots, &values, x + nudge) - y).abs() < 2e-4);
                }
            }
        }
    }

    const KNOTS: [f64; 6] = [0.0, 1.0, 2.5, 4.0, 6.0, 9.0];

    #[test]
    fn interpolation_is_exact_for_cubics() {
        let cubic = |x: f64| 1.0 - 2.0 * x + 0.5 * x * x - 0.1 * x.powi(3);
        for x in [0.0, 0.4, 1.7, 2.9, 4.0, 8.5] {
            let found: f64 = weights(&KNOTS, x).iter().map(|(i, weight)| weight * cubic(KNOTS[*i])).sum();
            assert!((found - cubic(x)).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn weight_is_one_at_a_knot() {
        for (i, x) in KNOTS.into_iter().enumerate() {
            assert_eq!(weights(&KNOTS, x), [(i, 1.0)]);
        }
        // A straight line, since the gaps are 1 and 99.
        assert_eq!(weights(&[0.0, 1.0, 100.0], 50.5), [(1, 0.5), (2, 0.5)]);
        assert_eq!(weights(&KNOTS[..1], 7.0), [(0, 1.0)]);
        assert_eq!(weights(&KNOTS[..2], 0.25), [(0, 0.75), (1, 0.25)]);
    }
}
