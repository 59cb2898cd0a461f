//! Cubic interpolation between values at uneven places: the polynomial through the four nearest, two on either side
//! (Lagrange; de Boor 2001, *A Practical Guide to Splines*, ch. I).
//!
//! Where neighbouring gaps differ by more than [`MOST_UNEVEN`] times, a cubic would swing between the values: a straight
//! line takes its place. The interpolation is continuous, exact for cubics and at its knots, and needs no condition at its ends. It is linear in the values, so
//! that interpolating coefficients is the same as interpolating the logarithms of the spectra that they stand for.

/// Times that a gap may be wider than the next for a cubic.
const MOST_UNEVEN: f64 = 2.5;

/// How much the value at each neighbouring knot counts at `x`; where there are fewer than four knots, all of them count.
/// At a knot it alone does.
pub(crate) fn weights(knots: &[f64], x: f64) -> Vec<(usize, f64)> {
    let points = knots.len().min(4);
    let below = knots.partition_point(|knot| *knot <= x);
    let first = below.saturating_sub(2).min(knots.len() - points);
    let near = first..first + points;
    let gaps: Vec<f64> = knots[near.clone()].windows(2).map(|two| two[1] - two[0]).collect();
    let uneven = gaps.windows(2).any(|two| two[0].max(two[1]) > MOST_UNEVEN * two[0].min(two[1]));
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

    const KNOTS: [f64; 6] = [0.0, 1.0, 2.5, 4.0, 6.0, 9.0];

    #[test]
    fn a_cubic_is_met_everywhere() {
        let cubic = |x: f64| 1.0 - 2.0 * x + 0.5 * x * x - 0.1 * x.powi(3);
        for x in [0.0, 0.4, 1.7, 2.9, 4.0, 8.5] {
            let met: f64 = weights(&KNOTS, x).iter().map(|(i, weight)| weight * cubic(KNOTS[*i])).sum();
            assert!((met - cubic(x)).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn a_knot_counts_alone() {
        for (i, x) in KNOTS.into_iter().enumerate() {
            assert_eq!(weights(&KNOTS, x), [(i, 1.0)]);
        }
        // Between gaps of 1 and 99 a straight line.
        assert_eq!(weights(&[0.0, 1.0, 100.0], 50.5), [(1, 0.5), (2, 0.5)]);
        assert_eq!(weights(&KNOTS[..1], 7.0), [(0, 1.0)]);
        assert_eq!(weights(&KNOTS[..2], 0.25), [(0, 0.75), (1, 0.25)]);
    }
}
