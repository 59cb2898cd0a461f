//! From coefficients to a spectrum: C' V'ᵀ, followed by the exponential in log space.

use crate::pca::{Components, MAX_COMPONENTS};

/// Coefficients of any table in whole registers; unused entries are 0.
pub type PaddedCoefficients = [f32; PADDED_COMPONENTS];

/// Length of [`PaddedCoefficients`]: the most components of a table and one entry for a factor's logarithm.
pub const PADDED_COMPONENTS: usize = MAX_COMPONENTS + 1;

/// Wavelengths that are rebuilt together: four SSE2 registers with independent sums.
const BLOCK: usize = 16;

/// A scale of a spectrum, in two parts that multiply.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    pub(super) factor: f32,
    pub(super) log2: f32,
}

/// V' in blocks of wavelengths: [block][component][wavelength], zero beyond the last wavelength.
#[derive(Debug, Clone)]
pub(super) struct Basis {
    count: usize,
    blocks: Vec<[f32; BLOCK]>,
}

impl Basis {
    /// The basis of some components, times `scale`.
    pub(super) fn new(components: &Components, scale: f64) -> Self {
        let count = components.count;
        let wavelengths = components.basis.len() / count;
        let entry = |wavelength: usize, component: usize| {
            if wavelength < wavelengths { scaled(components.basis[wavelength * count + component], scale) } else { 0.0 }
        };
        let block = |first: usize, component: usize| {
            std::array::from_fn::<f32, BLOCK, _>(|lane| entry(first + lane, component))
        };
        let firsts = (0..wavelengths).step_by(BLOCK);
        let blocks = firsts.flat_map(|first| (0..count).map(move |component| block(first, component))).collect();
        Self { count, blocks }
    }

    /// Σ c v at each wavelength.
    #[inline]
    pub(super) fn linear(&self, coefficients: &PaddedCoefficients, spectrum: &mut [f32]) {
        self.rebuild(coefficients, 0.0, spectrum, |sum| sum);
    }

    /// `scale.factor` 2^(`scale.log2` + Σ c v) at each wavelength.
    #[inline]
    pub(super) fn powers_of_two(&self, coefficients: &PaddedCoefficients, scale: Scale, spectrum: &mut [f32]) {
        self.rebuild(coefficients, scale.log2, spectrum, |sum| scale.factor * power_of_two(sum));
    }

    /// 2^Σ c v at each wavelength, at most 1: transmittance does not exceed 1.
    #[inline]
    pub(super) fn transmittance(&self, coefficients: &PaddedCoefficients, spectrum: &mut [f32]) {
        self.rebuild(coefficients, 0.0, spectrum, |sum| power_of_two(if sum < 0.0 { sum } else { 0.0 }));
    }

    #[inline(always)]
    fn rebuild(&self, coefficients: &PaddedCoefficients, first: f32, spectrum: &mut [f32], leave: impl Fn(f32) -> f32) {
        let sums = |shapes: &[[f32; BLOCK]]| {
            let mut sums = [first; BLOCK];
            for (coefficient, shape) in coefficients.iter().zip(shapes) {
                sums.iter_mut().zip(shape).for_each(|(sum, value)| *sum += coefficient * value);
            }
            sums.map(&leave)
        };
        let mut blocks = self.blocks.chunks_exact(self.count);
        let mut whole = spectrum.chunks_exact_mut(BLOCK);
        for (values, shapes) in whole.by_ref().zip(blocks.by_ref()) {
            values.copy_from_slice(&sums(shapes));
        }
        if let Some(shapes) = blocks.next() {
            let rest = whole.into_remainder();
            rest.copy_from_slice(&sums(shapes)[..rest.len()]);
        }
    }
}

/// 2^x of four numbers.
#[inline(always)]
pub(super) fn four_powers_of_two(mut four: [f32; 4]) -> [f32; 4] {
    for x in &mut four {
        *x = power_of_two(*x);
    }
    four
}

/// 2^x for x < 127, with a relative error of 2·10⁻⁷; 0 below the normal range of single precision, 10⁻³⁸.
///
/// The integer part goes into the exponent bits. The rest, within ± ½, goes through a polynomial: the series of
/// e^(x ln 2) with its last terms adjusted for a uniform error.
#[inline(always)]
fn power_of_two(x: f32) -> f32 {
    /// Adding this to a number below 2²² leaves its nearest integer in the last bits.
    const ROUNDING: f32 = 12_582_912.0;
    /// Bits of 1.0, whose exponent is 0.
    const ONE: u32 = 0x3F80_0000;
    const MIN: f32 = -127.0;
    // Faster than f32::max, which handles NaN.
    let x = if x > MIN { x } else { MIN };
    let rounded = x + ROUNDING;
    let rest = x - (rounded - ROUNDING);
    let [a, b, c, d, e] = POLYNOMIAL;
    let power = 1.0 + rest * (a + rest * (b + rest * (c + rest * (d + rest * e))));
    power * f32::from_bits((rounded.to_bits() << 23).wrapping_add(ONE))
}

/// Coefficients of 2^x − 1 over ± ½, from the first power of x.
#[expect(clippy::approx_constant, reason = "near ln 2, but adjusted for the truncated series")]
const POLYNOMIAL: [f32; 5] = [0.693_147, 0.240_222_42, 0.055_507_336, 0.009_671_513, 0.001_326_472_7];

#[expect(clippy::cast_possible_truncation, reason = "look-ups run in single precision")]
fn scaled(value: f32, scale: f64) -> f32 {
    (f64::from(value) * scale) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_two_are_accurate_and_underflow_to_zero() {
        let mut x = -125.9_f32;
        while x < 20.0 {
            let exact = f64::from(x).exp2();
            assert!((f64::from(power_of_two(x)) / exact - 1.0).abs() < 2e-7, "{x}");
            x += 0.000_37;
        }
        assert!(power_of_two(0.0).to_bits() == 1.0_f32.to_bits());
        for tiny in [-127.0, -1e4, f32::NEG_INFINITY, f32::NAN] {
            assert!(power_of_two(tiny).to_bits() == 0, "{tiny}");
        }
    }
}
