//! Cubic interpolation between unevenly spaced knots: the Lagrange polynomial through the four nearest knots, two on
//! either side (de Boor 2001, *A Practical Guide to Splines*, ch. I).
//!
//! Where neighbouring gaps differ by more than a factor of [`MAX_GAP_RATIO`], a cubic would oscillate, so a straight
//! line replaces it. The interpolation is continuous, exact for cubics and at its knots, and needs no end conditions.
//! It is linear in the values, so interpolating coefficients is the same as interpolating the logarithms of the spectra
//! that they represent.

/// Largest ratio of neighbouring gaps for which a cubic is used.
const MAX_GAP_RATIO: f64 = 2.5;

/// Weights of the neighbouring knots at `x`: of all knots if there are fewer than four, of one knot where `x` is that
/// knot.
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
