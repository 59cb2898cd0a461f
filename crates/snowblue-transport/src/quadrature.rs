//! Gauss–Legendre quadrature on (0, 1), one half-range of the double-Gauss rule.
//!
//! The nodes are the roots of the shifted Legendre polynomial P_N(2μ − 1), found by Newton's method from
//! Tricomi's estimate (Abramowitz & Stegun 1964, 25.4.30 and 22.16.6). Each hemisphere gets its own rule because
//! the radiance at a slab's face jumps at the horizon (Sykes 1951, doi:10.1093/mnras/111.4.377).

use std::f64::consts::PI;
use std::sync::OnceLock;

use crate::dual::Real;

/// Most nodes that a half-range rule may have.
pub(crate) const MAX_NODES: usize = 128;

static RULES: [OnceLock<Quadrature>; MAX_NODES] = [const { OnceLock::new() }; MAX_NODES];

/// Cosines in (0, 1), ascending, and their weights, which sum to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Quadrature {
    /// Cosines μ of the directions of one hemisphere.
    pub cosines: Vec<f64>,
    /// Weights; Σ w f(μ) is the integral of f over (0, 1), exact for polynomials of degree 2N − 1.
    pub weights: Vec<f64>,
}

impl Quadrature {
    /// The rule with `order` nodes in (0, 1), computed once and cached.
    ///
    /// ```
    /// # use snowblue_transport::quadrature::Quadrature;
    /// // ∫ μ dμ = 1/2 over (0, 1).
    /// let rule = Quadrature::half_range(8);
    /// let flux: f64 = rule.cosines.iter().zip(&rule.weights).map(|(mu, w)| mu * w).sum();
    /// assert!((flux - 0.5).abs() < 1e-15);
    /// ```
    ///
    /// # Panics
    /// If `order` is not in 1–128.
    #[must_use]
    pub fn half_range(order: usize) -> &'static Self {
        RULES[order - 1].get_or_init(|| Self::compute(order))
    }

    fn compute(order: usize) -> Self {
        let n = order as f64;
        let (mut cosines, mut weights) = (Vec::with_capacity(order), Vec::with_capacity(order));
        for i in (1..=order).rev() {
            let mut x = (1.0 - (n - 1.0) / (8.0 * n.powi(3))) * (PI * (4.0 * i as f64 - 1.0) / (4.0 * n + 2.0)).cos();
            let mut slope = 1.0;
            for _ in 0..8 {
                let (value, derivative) = legendre_with_derivative(order, x);
                slope = derivative;
                x -= value / derivative;
            }
            cosines.push(0.5 * (1.0 + x));
            weights.push(1.0 / ((1.0 - x * x) * slope * slope));
        }
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
        Self { cosines, weights }
    }

    /// Number of nodes in the half-range.
    #[must_use]
    pub fn order(&self) -> usize {
        self.cosines.len()
    }
}

/// P_n(x) and P_n'(x) for |x| < 1 by the three-term recurrence.
fn legendre_with_derivative(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut legendre) = (0.0, 1.0);
    for l in 0..n {
        let l = l as f64;
        (before, legendre) = (legendre, ((2.0 * l + 1.0) * x * legendre - l * before) / (l + 1.0));
    }
    (legendre, n as f64 * (x * legendre - before) / (x * x - 1.0))
}

/// P_0(x) … P_{count−1}(x), for |x| ≤ 1, into `values`.
pub(crate) fn legendre_polynomials<T: Real>(x: T, values: &mut [T]) {
    let (mut before, mut legendre) = (T::from(0.0), T::from(1.0));
    for (l, value) in values.iter_mut().enumerate() {
        *value = legendre;
        let l = l as f64;
        (before, legendre) = (legendre, (x * (2.0 * l + 1.0) * legendre - before * l) / (l + 1.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrates_polynomials_of_degree_2n_minus_1_exactly() {
        for order in [1, 2, 4, 8, 16, 32, 64] {
            let rule = Quadrature::half_range(order);
            assert!((rule.weights.iter().sum::<f64>() - 1.0).abs() < 4e-16 * order as f64);
            for degree in 0..2 * order {
                let sum: f64 = rule
                    .cosines
                    .iter()
                    .zip(&rule.weights)
                    .map(|(mu, w)| w * mu.powi(i32::try_from(degree).unwrap()))
                    .sum();
                // Rounding of `order` terms, each below 1.
                assert!((sum * (degree + 1) as f64 - 1.0).abs() < 1e-13 * (degree + 1) as f64, "{order} {degree}");
            }
        }
    }

    #[test]
    fn legendre_polynomials_match_their_closed_forms() {
        let x = 0.37_f64;
        let mut p = [0.0; 4];
        legendre_polynomials(x, &mut p);
        let closed = [1.0, x, 0.5 * (3.0 * x * x - 1.0), 0.5 * (5.0 * x.powi(3) - 3.0 * x)];
        for (value, expected) in p.iter().zip(closed) {
            assert!((value - expected).abs() < 1e-15);
        }
    }
}
