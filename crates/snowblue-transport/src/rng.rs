//! Random streams of rays.
//!
//! A ray's stream depends on (seed, ray number) alone, so any thread may trace the ray. The generator is PCG's 128-bit
//! multiplicative one (O'Neill 2014), seeded by SplitMix64 (Steele, Lea & Flood 2014, doi:10.1145/2714064.2660195).

use std::f64::consts::TAU;

use rand_core::Rng as _;
use rand_pcg::Pcg64Mcg;

/// The random stream of one ray.
#[derive(Debug, Clone)]
pub struct Stream {
    generator: Pcg64Mcg,
    /// The first numbers, from a low-discrepancy point, in reverse order.
    point: [f32; POINT_DIMENSIONS],
    point_left: usize,
}

/// Dimensions of the low-discrepancy point that a stream may start with.
pub(crate) const POINT_DIMENSIONS: usize = 16;

impl Stream {
    /// The stream of ray `ray` under `seed`.
    #[must_use]
    pub fn new(seed: u64, ray: u64) -> Self {
        let high = split_mix_64(seed ^ split_mix_64(ray));
        let low = split_mix_64(high ^ ray.rotate_left(32) ^ seed);
        let generator = Pcg64Mcg::new((u128::from(high) << 64) | u128::from(low));
        Self { generator, point: [0.0; POINT_DIMENSIONS], point_left: 0 }
    }

    /// The stream of ray `ray` under `seed`, with its first numbers from point `index` of an Owen-scrambled Sobol'
    /// sequence (Burley 2020, JCGT 9(4)).
    pub(crate) fn on_sequence(seed: u64, ray: u64, index: u32, scramble: u32) -> Self {
        let mut point = [0.0; POINT_DIMENSIONS];
        for (set, four) in point.rchunks_mut(4).enumerate() {
            let mut coordinates = sobol_burley::sample_4d(index, u32::try_from(set).unwrap_or(0), scramble);
            coordinates.reverse();
            four.copy_from_slice(&coordinates);
        }
        Self { point, point_left: POINT_DIMENSIONS, ..Self::new(seed, ray) }
    }

    /// A seed for further streams of ray `ray` under `seed`.
    #[must_use]
    pub fn key(seed: u64, ray: u64) -> u64 {
        split_mix_64(seed ^ split_mix_64(!ray))
    }

    /// A uniform number in the open interval (0, 1).
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        /// The sequence has 23 bits.
        const HALF_CELL: f64 = 0.5 / 8_388_608.0;
        /// The greatest number is 1 − 2⁻⁵³, which a double holds.
        const HALF_STEP: f64 = 1.0 / (1_u64 << 53) as f64;
        if self.point_left > 0 {
            self.point_left -= 1;
            return f64::from(self.point[self.point_left]) + HALF_CELL;
        }
        (self.generator.next_u64() >> 12) as f64 * (2.0 * HALF_STEP) + HALF_STEP
    }
}

/// Cosine and sine of a fraction of a full turn, 0–1, to rounding.
///
/// The fraction is exact in its quadrant, so no range reduction is needed: Taylor series to the 15th and 14th power,
/// with a remainder below 10⁻¹⁵ at an eighth of a turn.
#[inline]
pub(crate) fn unit_circle(turn: f64) -> (f64, f64) {
    // A cast truncates without a function call.
    #[expect(clippy::cast_possible_truncation, reason = "0.5 ≤ argument < 5")]
    let quadrant = (4.0 * turn + 0.5) as i32;
    let x = (turn - 0.25 * f64::from(quadrant)) * TAU;
    let y = x * x;
    let odd = [-1.0 / 1_307_674_368_000.0, 1.0 / 6_227_020_800.0, -1.0 / 39_916_800.0, 1.0 / 362_880.0, -1.0 / 5040.0];
    let even = [-1.0 / 87_178_291_200.0, 1.0 / 479_001_600.0, -1.0 / 3_628_800.0, 1.0 / 40_320.0, -1.0 / 720.0];
    let series = |terms: [f64; 5]| terms.into_iter().fold(0.0, |sum, term| sum * y + term);
    let sine = x * (1.0 + y * (-1.0 / 6.0 + y * (1.0 / 120.0 + y * series(odd))));
    let cosine = 1.0 + y * (-0.5 + y * (1.0 / 24.0 + y * series(even)));
    // Quadrant 4 equals quadrant 0.
    let swap = quadrant & 1 == 1;
    let (a, b) = if swap { (sine, cosine) } else { (cosine, sine) };
    let cosine_sign = if quadrant == 1 || quadrant == 2 { -1.0 } else { 1.0 };
    let sine_sign = if quadrant == 2 || quadrant == 3 { -1.0 } else { 1.0 };
    (cosine_sign * a, sine_sign * b)
}

/// The output of SplitMix64 one step after `state` (Steele, Lea & Flood 2014): a bijective hash of 64 bits.
///
/// Hashes of consecutive numbers are statistically independent, so that the hash makes independent seeds:
/// ```
/// # use snowblue_transport::rng::split_mix_64;
/// let differing_bits = (split_mix_64(1) ^ split_mix_64(2)).count_ones();
/// assert!((16..48).contains(&differing_bits));
/// ```
#[must_use]
pub fn split_mix_64(state: u64) -> u64 {
    let mut z = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn split_mix_matches_its_reference_sequence() {
        // First output of SplitMix64 from state 0 in the authors' program.
        assert_eq!(split_mix_64(0), 0xe220_a839_7b1d_cdaf);
    }

    #[test]
    fn unit_circle_is_cosine_and_sine() {
        for i in 0..=4000 {
            let turn = f64::from(i) / 4000.0;
            let (cosine, sine) = unit_circle(turn);
            let (expected_sine, expected_cosine) = (TAU * turn).sin_cos();
            // Rounding of 2π times the fraction.
            assert!((cosine - expected_cosine).abs() < 2e-15 && (sine - expected_sine).abs() < 2e-15, "{turn}");
        }
    }

    #[test]
    fn neighbouring_rays_are_uncorrelated() {
        // The mean of u·u' over 10⁵ pairs is 1/4 with standard deviation √(7/144)/√10⁵ = 7e-4; 4 σ.
        let count = 100_000;
        let sum: f64 = (0..count).map(|ray| Stream::new(1, ray).uniform() * Stream::new(1, ray + 1).uniform()).sum();
        assert!((sum / count as f64 - 0.25).abs() < 2.8e-3);
    }

    #[test]
    fn uniform_numbers_exclude_the_ends() {
        let mut stream = Stream::new(3, 0);
        assert!((0..100_000).map(|_| stream.uniform()).all(|u| u > 0.0 && u < 1.0));
    }
}
