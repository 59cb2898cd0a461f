//! Scalar functions of optical depth that keep their relative precision where they are tiny or degenerate.

use crate::dual::Real;
use crate::quadrature::Quadrature;

/// tanh(kτ/2)/k, which is τ/2 at k = 0, with tanh(kτ/2); τ may be infinite.
pub(super) fn tanh_over_rate<T: Real>(k: T, depth: T) -> (T, T) {
    let x = k * 0.5 * depth;
    let tanh = x.tanh();
    let over_rate = if depth.value().is_infinite() {
        T::from(1.0) / k
    } else {
        depth * 0.5 * if x.value() < 1e-4 { T::from(1.0) - x * x / 3.0 } else { tanh / x }
    };
    (over_rate, tanh)
}

/// k/sinh(kτ), which is 1/τ at k = 0 and does not overflow.
pub(super) fn rate_over_sinh<T: Real>(k: T, depth: T) -> T {
    let x = k * depth;
    if x.value() < 1e-4 {
        return (T::from(1.0) - x * x / 6.0) / depth;
    }
    k * -2.0 * (-x).exp() / (x * -2.0).exp_m1()
}

/// sinh(kτ)/k, which is τ at k = 0.
pub(super) fn sinh_over_rate<T: Real>(k: T, depth: T) -> T {
    let x = k * depth;
    if x.value() < 1e-4 { depth * (x * x / 6.0 + 1.0) } else { x.sinh() / k }
}

/// ∫₀^τ e^{−qs} cosh(ks) q ds and ∫₀^τ e^{−qs} sinh(ks)/k q ds, for k < 1 ≤ q.
pub(super) fn hyperbolic_integrals<T: Real>(k: T, depth: T, q: T, unscattered: T) -> (T, T) {
    let sinh_over_k = sinh_over_rate(k, depth);
    let (cosh, norm) = ((k * depth).cosh(), q / (q * q - k * k));
    let first = norm * (q - unscattered * (q * cosh + k * k * sinh_over_k));
    let second = norm * (T::from(1.0) - unscattered * (cosh + q * sinh_over_k));
    (first, second)
}

/// ∫₀^τ e^{−qs} e^{−ks} q ds and ∫₀^τ e^{−qs} e^{−k(τ−s)} q ds; q = k is a regular point, and τ may be infinite.
pub(super) fn exponential_integrals<T: Real>(k: T, depth: T, q: T) -> (T, T) {
    let near = -q / (q + k) * (-(q + k) * depth).exp_m1();
    if depth.value().is_infinite() {
        return (near, T::from(0.0));
    }
    let (low, high) = if q.value() < k.value() { (q, k) } else { (k, q) };
    (near, q * depth * (-low * depth).exp() * ((high - low) * depth).mean_decay())
}

/// E₃(τ) = ∫₀¹ μ e^{−τ/μ} dμ by Gauss–Legendre in u with μ = u², scaled so that the tail keeps its relative precision.
pub(super) fn third_exponential_integral(tau: f64) -> f64 {
    transmitted_integral(tau, |_| 1.0)
}

/// ∫₀¹ μ e^{−τ/μ} f(μ) dμ, as [`third_exponential_integral`].
pub(super) fn transmitted_integral(tau: f64, factor: impl Fn(f64) -> f64) -> f64 {
    if tau.is_infinite() {
        return 0.0;
    }
    // With 1/μ = 1 + t: E₃ = e^{−τ} ∫₀^∞ e^{−τt} (1 + t)⁻³ dt, and t = y/((1 + τ)(1 − y)) brings the range to (0, 1).
    let rule = Quadrature::half_range(48);
    let integral: f64 = rule
        .cosines
        .iter()
        .zip(&rule.weights)
        .map(|(y, weight)| {
            let t = y / ((1.0 + tau) * (1.0 - y));
            let jacobian = 1.0 / ((1.0 + tau) * (1.0 - y) * (1.0 - y));
            weight * jacobian * (-tau * t).exp() * factor(1.0 / (1.0 + t)) / (1.0 + t).powi(3)
        })
        .sum();
    (-tau).exp() * integral
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_integral_matches_abramowitz_and_stegun_table_5_4() {
        // E₃(0) = 1/2 exactly; E₃(1) = 0.1096920 (Table 5.4, 7 figures); E₃(5) from E₁(5) = 0.001148296 by recurrence.
        for (tau, expected, tolerance) in [(0.0, 0.5, 1e-12), (1.0, 0.109_692_0, 5e-8), (5.0, 8.778e-4, 5e-8)] {
            assert!((third_exponential_integral(tau) - expected).abs() < tolerance, "{tau}");
        }
    }

    #[test]
    fn integrals_agree_at_the_degenerate_point_and_between_forms() {
        let (k, depth) = (0.4, 2.0);
        for q in [1.0, 1.7, 30.0] {
            let (cosh, sinh) = hyperbolic_integrals(k, depth, q, (-q * depth).exp());
            let (near, far) = exponential_integrals(k, depth, q);
            assert!((cosh - k * sinh - near).abs() < 1e-14, "e^(−ks) = cosh − sinh");
            let growing = (k * depth).exp() * far;
            assert!((cosh + k * sinh - growing).abs() < 1e-14, "e^(ks) = cosh + sinh");
        }
        let (_, exact) = exponential_integrals(2.0, depth, 2.0);
        assert!((exact - 4.0 * (-4.0_f64).exp()).abs() < 1e-16);
    }
}
