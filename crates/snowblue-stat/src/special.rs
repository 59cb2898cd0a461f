//! The incomplete gamma and beta functions. Equation numbers are those of the NIST Digital Library of Mathematical
//! Functions (DLMF), <https://dlmf.nist.gov>.

use std::f64::consts::TAU;

/// Q(a, x) = Γ(a, x)/Γ(a) for a > 0, x ≥ 0: one minus the series 8.7.1, or the even part of the continued fraction
/// 8.9.2.
pub(crate) fn upper_gamma_ratio(a: f64, x: f64) -> f64 {
    if x.is_infinite() {
        return 0.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x > a + 1.0 {
        return front * continued_fraction(|n| n * (a - n), |n| x - a + 2.0 * n - 1.0);
    }
    let (mut term, mut sum, mut denominator) = (1.0 / a, 1.0 / a, a);
    while term > 1e-17 * sum {
        denominator += 1.0;
        term *= x / denominator;
        sum += term;
    }
    1.0 - front * sum
}

/// Iₓ(a, b) for a, b > 0 and x = 1 − y: the continued fraction 8.17.22, after the reflection 8.17.4 where that
/// converges faster.
pub(crate) fn beta_ratio(a: f64, b: f64, x: f64, y: f64) -> f64 {
    let swap = x > (a + 1.0) / (a + b + 2.0);
    let (a, b, x, y) = if swap { (b, a, y, x) } else { (a, b, x, y) };
    let front = (a * x.ln() + b * y.ln() + ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b)).exp() / a;
    let numerator = |n: f64| {
        let m = (n / 2.0).floor();
        let factor = if n % 2.0 < 0.5 { m * (b - m) } else { -(a + m) * (a + b + m) };
        factor * x / ((a + n - 1.0) * (a + n))
    };
    let ratio = front * continued_fraction(numerator, |_| 1.0);
    if swap { 1.0 - ratio } else { ratio }
}

/// ln Γ(x) for x > 0: Stirling's series 5.11.1 for x ≥ 10, with the recurrence 5.5.1 below.
fn ln_gamma(x: f64) -> f64 {
    let (mut shifted, mut product) = (x, 1.0);
    while shifted < 10.0 {
        product *= shifted;
        shifted += 1.0;
    }
    let denominators = [12.0, -360.0, 1260.0, -1680.0, 1188.0, -360_360.0 / 691.0];
    let (mut series, mut power) = (0.0, shifted);
    for denominator in denominators {
        series += 1.0 / (denominator * power);
        power *= shifted * shifted;
    }
    (shifted - 0.5) * shifted.ln() - shifted + 0.5 * TAU.ln() + series - f64::ln(product)
}

/// 1/(b₁ + a₁/(b₂ + a₂/(b₃ + …))) by the modified Lentz algorithm (Thompson & Barnett 1986, J. Comput. Phys. 64, 490).
fn continued_fraction(a: impl Fn(f64) -> f64, b: impl Fn(f64) -> f64) -> f64 {
    const TINY: f64 = 1e-300;
    let nonzero = |value: f64| if value.abs() < TINY { TINY } else { value };
    let (mut value, mut c, mut d, mut factor, mut n) = (TINY, TINY, 0.0, 0.0_f64, 0.0);
    while (factor - 1.0).abs() > 1e-15 {
        n += 1.0;
        let above = if n > 1.0 { a(n - 1.0) } else { 1.0 };
        d = nonzero(b(n) + above * d).recip();
        c = nonzero(b(n) + above / c);
        factor = c * d;
        value *= factor;
    }
    value
}
