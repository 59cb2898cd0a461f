//! From coefficients to a spectrum: C' V'ᵀ, and out of log space.

use crate::pca::{Components, MOST_COMPONENTS};

/// Room for the coefficients of any table, for one number more, and for whole registers.
pub type Lanes = [f32; LANES];
/// How many numbers that are.
pub(super) const LANES: usize = MOST_COMPONENTS + 1;

/// Wavelengths that are rebuilt together: four registers of plain SSE2, whose sums do not wait for one another.
const BLOCK: usize = 16;

/// V', some wavelengths at a time, and for each of these blocks the components; beyond the last wavelength it is 0.
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
    pub(super) fn linear(&self, coefficients: &Lanes, spectrum: &mut [f32]) {
        self.rebuild(coefficients, 0.0, spectrum, |sum| sum);
    }

    /// `factor` 2^(`first` + Σ c v) at each wavelength.
    #[inline]
    pub(super) fn powers_of_two(&self, coefficients: &Lanes, (first, factor): (f32, f32), spectrum: &mut [f32]) {
        self.rebuild(coefficients, first, spectrum, |sum| factor * power_of_two(sum));
    }

    /// 2^Σ c v at each wavelength, but 1 at the most: what passes is a share of what comes.
    #[inline]
    pub(super) fn shares(&self, coefficients: &Lanes, spectrum: &mut [f32]) {
        self.rebuild(coefficients, 0.0, spectrum, |sum| power_of_two(if sum < 0.0 { sum } else { 0.0 }));
    }

    #[inline(always)]
    fn rebuild(&self, coefficients: &Lanes, first: f32, spectrum: &mut [f32], leave: impl Fn(f32) -> f32) {
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

/// 2^x within 2·10⁻⁷ of itself for x < 127; 0 below the normal numbers of single precision, 10⁻³⁸.
///
/// A whole power goes into the exponent's bits, the rest, within ± ½, into a polynomial: the series of e^(x ln 2) with
/// its last terms changed so that the error is even.
#[inline(always)]
fn power_of_two(x: f32) -> f32 {
    /// Added to a number below 2²², this leaves its nearest whole number in the last bits.
    const ROUNDING: f32 = 12_582_912.0;
    /// Bits of 1, an exponent of 0.
    const ONE: u32 = 0x3F80_0000;
    const LEAST: f32 = -127.0;
    // Not f32::max, which would look for NaN.
    let x = if x > LEAST { x } else { LEAST };
    let rounded = x + ROUNDING;
    let rest = x - (rounded - ROUNDING);
    let [a, b, c, d, e] = POLYNOMIAL;
    let power = 1.0 + rest * (a + rest * (b + rest * (c + rest * (d + rest * e))));
    power * f32::from_bits((rounded.to_bits() << 23).wrapping_add(ONE))
}

/// 2^x − 1 over ± ½, by powers of x from the first.
#[expect(clippy::approx_constant, reason = "the first is near ln 2, but not it: the series is cut off")]
const POLYNOMIAL: [f32; 5] = [0.693_147, 0.240_222_42, 0.055_507_336, 0.009_671_513, 0.001_326_472_7];

#[expect(clippy::cast_possible_truncation, reason = "look-ups run in single precision")]
fn scaled(value: f32, scale: f64) -> f32 {
    (f64::from(value) * scale) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every power in its range, against double precision.
    #[test]
    fn powers_of_two_are_near_and_end_in_nothing() {
        let mut x = -125.9_f32;
        while x < 20.0 {
            let exact = f64::from(x).exp2();
            assert!((f64::from(power_of_two(x)) / exact - 1.0).abs() < 2e-7, "{x}");
            x += 0.000_37;
        }
        assert!(power_of_two(0.0).to_bits() == 1.0_f32.to_bits());
        for nothing in [-127.0, -1e4, f32::NEG_INFINITY, f32::NAN] {
            assert!(power_of_two(nothing).to_bits() == 0, "{nothing}");
        }
    }
}
