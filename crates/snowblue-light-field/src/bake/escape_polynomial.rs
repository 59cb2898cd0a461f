//! The escape function K(μ) as a polynomial, for shaders.

use std::f64::consts::PI;

use snowblue_transport::ordinates::HalfSpace;

/// Number of points at which the function is evaluated.
const POINTS: u32 = 64;
/// Number of points at which the polynomial is compared with the function.
const CHECKED_POINTS: u32 = 1000;

/// K(μ) = k₀ + k₁ μ + k₂ μ² + k₃ μ³ for cosines μ from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EscapePolynomial {
    /// The coefficients k₀ to k₃.
    pub coefficients: [f64; 4],
    /// The greatest difference to the escape function.
    pub greatest_error: f64,
}

impl EscapePolynomial {
    /// The sum of the first four Chebyshev polynomials of 2μ − 1, which is close to the best approximation.
    pub(super) fn of(half_space: &HalfSpace) -> Self {
        let mut chebyshev = [0.0; 4];
        for point in 0..POINTS {
            let angle = PI * (f64::from(point) + 0.5) / f64::from(POINTS);
            let value = half_space.escape(0.5 * (1.0 + angle.cos()));
            for (order, sum) in (0..).zip(&mut chebyshev) {
                *sum += value * (f64::from(order) * angle).cos() * 2.0 / f64::from(POINTS);
            }
        }
        let [c0, c1, c2, c3] = chebyshev;
        // T₂ = 2t² − 1 and T₃ = 4t³ − 3t, first by powers of t, then of μ with t = 2μ − 1.
        let [t0, t1, t2, t3] = [0.5 * c0 - c2, c1 - 3.0 * c3, 2.0 * c2, 4.0 * c3];
        let coefficients = [t0 - t1 + t2 - t3, 2.0 * t1 - 4.0 * t2 + 6.0 * t3, 4.0 * t2 - 12.0 * t3, 8.0 * t3];
        let mut polynomial = Self { coefficients, greatest_error: 0.0 };
        for point in 0..=CHECKED_POINTS {
            let cos = f64::from(point) / f64::from(CHECKED_POINTS);
            let error = (polynomial.at(cos) - half_space.escape(cos)).abs();
            polynomial.greatest_error = polynomial.greatest_error.max(error);
        }
        polynomial
    }

    /// K at the cosine of the angle between a direction and the normal, 0–1.
    #[must_use]
    pub fn at(&self, cos: f64) -> f64 {
        self.coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * cos + coefficient)
    }
}

#[cfg(test)]
mod tests {
    use snowblue_transport::PhaseFunction;

    use super::*;

    #[test]
    fn the_polynomial_is_near_the_function_and_keeps_its_flux() {
        let half_space = HalfSpace::new(&PhaseFunction::henyey_greenstein(0.75));
        let polynomial = EscapePolynomial::of(&half_space);
        assert!(polynomial.greatest_error < 0.03, "{polynomial:?}");
        // Between the points of the comparison the error is as great. It is greatest at grazing angles, at 0.
        let cosines = (0..CHECKED_POINTS).map(|point| (f64::from(point) + 0.5) / f64::from(CHECKED_POINTS));
        let errors = cosines.map(|cos| (polynomial.at(cos) - half_space.escape(cos)).abs());
        let between = errors.fold(0.0, f64::max);
        assert!(between <= polynomial.greatest_error && between > 0.9 * polynomial.greatest_error, "{between}");
        // 2∫ K μ dμ = 1.
        let [k0, k1, k2, k3] = polynomial.coefficients;
        let flux = 2.0 * (k0 / 2.0 + k1 / 3.0 + k2 / 4.0 + k3 / 5.0);
        assert!((flux - 1.0).abs() < 3e-3, "{flux}");
    }
}
