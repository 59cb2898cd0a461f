//! Statistics of errors.

/// ΔE*ab below which an average observer sees no difference (Varsa & Baranoski 2024, after Kravchenko et al. 2017).
pub const PERCEPTIBLE_DELTA_E: f64 = 2.3;

/// Statistics of one measure over all curves or points.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// Largest value.
    pub worst: f64,
    /// Number of the curve or point with the largest value.
    pub worst_curve: usize,
    /// 99th percentile.
    pub percentile_99: f64,
    /// Mean.
    pub mean: f64,
}

/// Worst, 99th percentile (nearest rank) and mean; zeros if there are no values.
pub(super) fn spread(values: impl Iterator<Item = f64>) -> Spread {
    let mut ranked: Vec<(f64, usize)> = values.enumerate().map(|(i, value)| (value, i)).collect();
    if ranked.is_empty() {
        return Spread { worst: 0.0, worst_curve: 0, percentile_99: 0.0, mean: 0.0 };
    }
    let mean = ranked.iter().map(|(value, _)| value).sum::<f64>() / ranked.len() as f64;
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (worst, worst_curve) = ranked[ranked.len() - 1];
    let rank = (ranked.len() * 99).div_ceil(100) - 1;
    Spread { worst, worst_curve, percentile_99: ranked[rank].0, mean }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_of_a_hundred_numbers_is_exact() {
        let spread = spread((0..100).rev().map(f64::from));
        assert_eq!((spread.worst_curve, spread.worst.to_bits()), (0, 99.0_f64.to_bits()));
        assert!((spread.percentile_99 - 98.0).abs() < 1e-12 && (spread.mean - 49.5).abs() < 1e-12);
    }
}
