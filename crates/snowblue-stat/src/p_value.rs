//! p-values of common statistics, and the significance level for multiple tests.

use statrs::function::beta::beta_reg;
use statrs::function::gamma::gamma_ur;

/// Two-sided p-value of a standard normal statistic: that of χ² = z² with one degree of freedom.
///
/// One value in 22 deviates by more than two standard deviations, one in 370 by more than three:
/// ```
/// # use snowblue_stat::z_p_value;
/// assert!((1.0 / z_p_value(2.0) - 22.0).abs() < 0.1);
/// assert!((1.0 / z_p_value(3.0) - 370.4).abs() < 0.1);
/// ```
///
/// # Panics
/// If `z` is not a number.
pub fn z_p_value(z: f64) -> f64 {
    assert!(!z.is_nan(), "z is not a number");
    chi_squared_p_value(z * z, 1.0)
}

/// Two-sided p-value of Student's t: Iₓ(ν/2, ½) with x = ν/(ν + t²) (Abramowitz & Stegun 1964, equation 26.7.1).
///
/// # Panics
/// If `t` is not a number or `degrees_of_freedom` is not above 0.
pub fn t_p_value(t: f64, degrees_of_freedom: f64) -> f64 {
    assert!(!t.is_nan(), "t is not a number");
    assert!(degrees_of_freedom > 0.0, "degrees of freedom are {degrees_of_freedom}, but must be above 0");
    beta_reg(0.5 * degrees_of_freedom, 0.5, degrees_of_freedom / (degrees_of_freedom + t * t))
}

/// p-value of χ², the upper tail: Q(ν/2, χ²/2) (Abramowitz & Stegun 1964, equation 26.4.19).
///
/// # Panics
/// If `chi_squared` is negative or not a number, or `degrees_of_freedom` is not above 0.
pub fn chi_squared_p_value(chi_squared: f64, degrees_of_freedom: f64) -> f64 {
    assert!(chi_squared >= 0.0, "χ² is {chi_squared}, but must be at least 0");
    assert!(degrees_of_freedom > 0.0, "degrees of freedom are {degrees_of_freedom}, but must be above 0");
    match chi_squared {
        0.0 => 1.0,
        f64::INFINITY => 0.0,
        _ => gamma_ur(0.5 * degrees_of_freedom, 0.5 * chi_squared),
    }
}

/// Level of each of `tests` independent tests, such that all pass with probability 1 − `family_level` under the null
/// hypothesis: 1 − (1 − α)^(1/n) (Šidák 1967, J. Am. Stat. Assoc. 62, 626).
pub fn sidak_level(family_level: f64, tests: usize) -> f64 {
    -((-family_level).ln_1p() / tests as f64).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_p(found: f64, expected: f64, tolerance: f64) {
        assert!((found / expected - 1.0).abs() < tolerance, "{found}, expected {expected}");
    }

    /// Abramowitz & Stegun 1964, tables 26.1 and 26.2, doubled for both tails.
    #[test]
    fn normal_tails_match_published_values() {
        assert_p(z_p_value(1.0), 0.317_310_507_862_914, 1e-13);
        assert_p(z_p_value(-1.959_963_984_540_054), 0.05, 1e-13);
        assert_p(z_p_value(5.0), 2.0 * 2.866_515_719e-7, 1e-9);
        assert_p(z_p_value(10.0), 2.0 * 7.619_853_024e-24, 1e-9);
        assert!(z_p_value(0.0) >= 1.0 && z_p_value(f64::INFINITY) <= 0.0);
    }

    /// Abramowitz & Stegun 1964, table 26.10; half a unit of the last digit is up to 1.2e-3 of p.
    #[test]
    fn t_matches_published_values() {
        assert_p(t_p_value(12.706, 1.0), 0.05, 1.3e-3);
        assert_p(t_p_value(2.228, 10.0), 0.05, 1.3e-3);
        assert_p(t_p_value(2.750, 30.0), 0.01, 1.3e-3);
        assert_p(t_p_value(-1.0, 1.0), 0.5, 1e-14);
        assert_p(t_p_value(5.0, 2.0), 1.0 - 5.0 / 27.0_f64.sqrt(), 1e-13);
        assert_p(t_p_value(3.0, 1e6), z_p_value(3.0), 3e-5);
        assert!(t_p_value(0.0, 5.0) >= 1.0 && t_p_value(f64::INFINITY, 5.0) <= 0.0);
    }

    /// Abramowitz & Stegun 1964, table 26.8; half a unit of the last digit is up to 7e-5 of p.
    #[test]
    fn chi_squared_matches_published_values() {
        assert_p(chi_squared_p_value(3.84146, 1.0), 0.05, 1e-4);
        assert_p(chi_squared_p_value(0.710721, 4.0), 0.95, 1e-4);
        assert_p(chi_squared_p_value(124.342, 100.0), 0.05, 1e-4);
        assert_p(chi_squared_p_value(7.0, 2.0), (-3.5_f64).exp(), 1e-13);
        // The limit is normal under the cube-root transformation of Wilson & Hilferty 1931.
        let z = (1.002_f64.cbrt() - 1.0 + 2.0 / 9e6) / (2.0 / 9e6_f64).sqrt();
        assert_p(chi_squared_p_value(1.002e6, 1e6), 0.5 * z_p_value(z), 1e-5);
    }

    #[test]
    fn sidak_keeps_the_level_of_the_family() {
        assert_p(1.0 - (1.0 - sidak_level(0.01, 7)).powi(7), 0.01, 1e-12);
    }

    #[test]
    #[should_panic(expected = "z is not a number")]
    fn a_nan_statistic_panics() {
        z_p_value(f64::NAN);
    }
}
