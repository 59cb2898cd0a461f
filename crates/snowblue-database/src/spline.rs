//! Natural cubic splines over the thickness of snow, for several components at once.
//!
//! Between knots y is cubic with continuous second derivative, and that derivative is 0 at both ends (de Boor 2001,
//! *A Practical Guide to Splines*, ch. IV). The spline is linear in the values at the knots, so that interpolating l'
//! coefficients is the same as interpolating the spectra that they stand for.

use wide::f32x8;

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

/// Ascending knots to look places up between. Where there are so few, to compare with all is quicker than to search.
#[derive(Debug, Clone)]
pub(crate) struct Knots {
    ends: (f32, f32),
    /// From each knot but the last to the next.
    ways: Vec<Way>,
    /// All knots but the first and the last, eight at a time, filled up with infinity.
    inner: Vec<f32x8>,
}

/// From one knot to the next.
#[derive(Debug, Clone, Copy)]
struct Way {
    start: f32,
    width: f32,
    per_width: f32,
}

impl Knots {
    pub(crate) fn new(knots: &[f64]) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "look-ups run in single precision")]
        let knots: Vec<f32> = knots.iter().map(|knot| *knot as f32).collect();
        let way = |two: &[f32]| Way { start: two[0], width: two[1] - two[0], per_width: (two[1] - two[0]).recip() };
        let ways: Vec<Way> = knots.windows(2).map(way).collect();
        let inner: Vec<f32> = ways.iter().skip(1).map(|way| way.start).collect();
        let eight =
            |some: &[f32]| f32x8::new(std::array::from_fn(|lane| some.get(lane).copied().unwrap_or(f32::INFINITY)));
        Self { ends: (knots[0], knots[knots.len() - 1]), ways, inner: inner.chunks(8).map(eight).collect() }
    }

    pub(crate) fn len(&self) -> usize {
        self.ways.len() + 1
    }

    /// The first and the last.
    pub(crate) fn ends(&self) -> (f32, f32) {
        self.ends
    }

    /// The knot below `x`, how far it is from there to the next, and which share of that way `x` has gone; the first and
    /// the last way go on beyond the ends. There must be two knots or more.
    #[inline]
    pub(crate) fn place(&self, x: f32) -> (usize, f32, f32) {
        let everywhere = f32x8::splat(x);
        let up_to = self.inner.iter().map(|eight| eight.simd_le(everywhere).to_bitmask().trailing_ones());
        let below = up_to.sum::<u32>() as usize;
        let way = &self.ways[below];
        (below, way.width, (x - way.start) * way.per_width)
    }
}

const SIXTH: f32 = 1.0 / 6.0;

/// The piece that holds at `x`, at or above the first knot; beyond the last knot it goes on in a straight line.
#[inline]
pub(crate) fn piece(knots: &Knots, x: f32) -> Piece {
    let (knot, width, t) = knots.place(x);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn at(knots: &[f64], values: &[f64], x: f32) -> f32 {
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
