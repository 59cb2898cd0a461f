//! Numbers with derivatives, for forward-mode differentiation (Wengert 1964, doi:10.1145/355586.364791).
//!
//! Code that is generic over [`Real`] computes values with `f64`, and values with derivatives with [`Dual`]. A
//! [`Dual`] has the derivatives by several variables, so that exponentials are computed once for all of them.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// Number of derivatives of a [`Dual`].
pub(crate) const LANES: usize = 4;

/// A real number, perhaps with derivatives.
pub(crate) trait Real:
    Copy
    + Debug
    + PartialEq
    + 'static
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// The number without its derivatives.
    fn value(self) -> f64;
    /// Whether the number and its derivatives are 0.
    fn is_zero(self) -> bool;
    fn ln(self) -> Self;
    fn exp(self) -> Self;
    fn exp_m1(self) -> Self;
    fn sqrt(self) -> Self;
    fn sinh(self) -> Self;
    fn cosh(self) -> Self;
    fn tanh(self) -> Self;
    /// (1 − e^{−x})/x for x ≥ 0, the mean of e^{−xs} over 0 < s < 1.
    fn mean_decay(self) -> Self;
}

/// A number and its derivatives by some variables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Dual {
    value: f64,
    derivatives: [f64; LANES],
}

impl Real for f64 {
    fn value(self) -> f64 {
        self
    }

    fn is_zero(self) -> bool {
        self.abs() <= 0.0
    }

    fn ln(self) -> Self {
        self.ln()
    }

    fn exp(self) -> Self {
        self.exp()
    }

    fn exp_m1(self) -> Self {
        self.exp_m1()
    }

    fn sqrt(self) -> Self {
        self.sqrt()
    }

    fn sinh(self) -> Self {
        self.sinh()
    }

    fn cosh(self) -> Self {
        self.cosh()
    }

    fn tanh(self) -> Self {
        self.tanh()
    }

    fn mean_decay(self) -> Self {
        if self < 1e-8 { 1.0 - 0.5 * self } else { -(-self).exp_m1() / self }
    }
}

impl Dual {
    pub(crate) fn new(value: f64, derivatives: [f64; LANES]) -> Self {
        Self { value, derivatives }
    }

    pub(crate) fn derivatives(&self) -> &[f64; LANES] {
        &self.derivatives
    }

    /// Sum of the squares of all derivatives.
    pub(crate) fn squared_gradient(&self) -> f64 {
        self.derivatives.iter().map(|derivative| derivative * derivative).sum()
    }

    /// A function of this number with the given value and derivative.
    ///
    /// A function that no longer changes has the derivative 0 even where its argument is infinite.
    fn chain(self, value: f64, derivative: f64) -> Self {
        let through = |inner: f64| if derivative.abs() <= 0.0 { 0.0 } else { derivative * inner };
        Self { value, derivatives: self.derivatives.map(through) }
    }

    fn combined(value: f64, of: impl Fn(usize) -> f64) -> Self {
        Self { value, derivatives: std::array::from_fn(of) }
    }
}

impl Real for Dual {
    fn value(self) -> f64 {
        self.value
    }

    fn is_zero(self) -> bool {
        self.value.is_zero() && self.derivatives.into_iter().all(Real::is_zero)
    }

    fn ln(self) -> Self {
        self.chain(self.value.ln(), 1.0 / self.value)
    }

    fn exp(self) -> Self {
        let value = self.value.exp();
        self.chain(value, value)
    }

    fn exp_m1(self) -> Self {
        self.chain(self.value.exp_m1(), self.value.exp())
    }

    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        self.chain(value, 0.5 / value)
    }

    fn sinh(self) -> Self {
        self.chain(self.value.sinh(), self.value.cosh())
    }

    fn cosh(self) -> Self {
        self.chain(self.value.cosh(), self.value.sinh())
    }

    fn tanh(self) -> Self {
        let value = self.value.tanh();
        self.chain(value, (1.0 - value) * (1.0 + value))
    }

    fn mean_decay(self) -> Self {
        let (x, value) = (self.value, self.value.mean_decay());
        // The closed form is a difference of nearly equal numbers where x is small; the next term of the series is
        // below 10⁻¹³ of the first.
        let derivative = if x < 0.01 {
            -0.5 + x * (1.0 / 3.0 - x * (1.0 / 8.0 - x * (1.0 / 30.0 - x * (1.0 / 144.0 - x / 840.0))))
        } else {
            ((-x).exp() - value) / x
        };
        self.chain(value, derivative)
    }
}

impl From<f64> for Dual {
    fn from(value: f64) -> Self {
        Self { value, derivatives: [0.0; LANES] }
    }
}

impl Add for Dual {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::combined(self.value + other.value, |i| self.derivatives[i] + other.derivatives[i])
    }
}

impl Sub for Dual {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::combined(self.value - other.value, |i| self.derivatives[i] - other.derivatives[i])
    }
}

impl Mul for Dual {
    type Output = Self;

    #[expect(clippy::suspicious_arithmetic_impl, reason = "the product rule")]
    fn mul(self, other: Self) -> Self {
        Self::combined(self.value * other.value, |i| {
            self.derivatives[i] * other.value + self.value * other.derivatives[i]
        })
    }
}

impl Div for Dual {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let (quotient, inverse) = (self.value / other.value, 1.0 / other.value);
        Self::combined(quotient, |i| (self.derivatives[i] - quotient * other.derivatives[i]) * inverse)
    }
}

impl Neg for Dual {
    type Output = Self;

    fn neg(self) -> Self {
        Self::combined(-self.value, |i| -self.derivatives[i])
    }
}

impl AddAssign for Dual {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Add<f64> for Dual {
    type Output = Self;

    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl Sub<f64> for Dual {
    type Output = Self;

    fn sub(self, other: f64) -> Self {
        Self { value: self.value - other, ..self }
    }
}

impl Mul<f64> for Dual {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self::combined(self.value * factor, |i| self.derivatives[i] * factor)
    }
}

impl Div<f64> for Dual {
    type Output = Self;

    fn div(self, divisor: f64) -> Self {
        Self::combined(self.value / divisor, |i| self.derivatives[i] / divisor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64) -> Dual {
        Dual::new(x, [1.0, -2.0, 0.0, 0.0])
    }

    /// A function with its derivative at a place.
    type Known = (fn(Dual) -> Dual, f64, f64);

    #[test]
    fn derivatives_are_those_of_calculus() {
        let x = 0.7_f64;
        let functions: [Known; 10] = [
            (|x| x * x * x, x.powi(3), 3.0 * x * x),
            (|x| Dual::from(2.0) / x - x, 2.0 / x - x, -2.0 / (x * x) - 1.0),
            (|x| -(x * 3.0 + 1.0) / 2.0, -(3.0 * x + 1.0) / 2.0, -1.5),
            (|x| x.exp() - 1.0, x.exp() - 1.0, x.exp()),
            (Dual::exp_m1, x.exp_m1(), x.exp()),
            (Dual::ln, x.ln(), 1.0 / x),
            (Dual::sqrt, x.sqrt(), 0.5 / x.sqrt()),
            (|x| x.sinh() + x.cosh(), x.exp(), x.exp()),
            (Dual::tanh, x.tanh(), 1.0 / x.cosh().powi(2)),
            (Dual::mean_decay, (1.0 - (-x).exp()) / x, ((-x).exp() * (1.0 + x) - 1.0) / (x * x)),
        ];
        for (place, (function, value, derivative)) in functions.into_iter().enumerate() {
            let found = function(at(x));
            assert!((found.value() - value).abs() < 1e-15, "{place}: {found:?}");
            // A few roundings of numbers near 1.
            assert!((found.derivatives()[0] - derivative).abs() < 1e-14, "{place}: {found:?}, {derivative}");
            assert!((found.derivatives()[1] + 2.0 * derivative).abs() < 2e-14, "{place}: {found:?}");
        }
    }

    /// The arguments where series and closed form meet, and where the closed form alone would have no correct digit.
    #[test]
    fn the_mean_decay_has_a_derivative_at_every_argument() {
        let slope = |x: f64| at(x).mean_decay().derivatives()[0];
        // The closed form rounds by 10⁻¹⁶/x².
        assert!((slope(0.01 - 1e-14) / slope(0.01) - 1.0).abs() < 1e-11);
        assert!((slope(1e-9) + 0.5).abs() < 1e-9 && (slope(0.0) + 0.5).abs() < 1e-16);
    }

    #[test]
    fn what_no_longer_changes_has_no_derivative() {
        let endless = Dual::new(f64::INFINITY, [f64::INFINITY, f64::NAN, 0.0, 0.0]);
        assert_eq!((-endless).exp(), Dual::from(0.0));
        assert_eq!(endless.tanh(), Dual::from(1.0));
    }
}
