//! Adaptive sampling: pixels whose noise has fallen to a target need no further samples.
//!
//! All pixels count the same number of samples. Where a pixel needs no more, each further sample repeats its mean, and
//! the sums of squares grow so that the variance of the mean stays what it was. So an image with a noise target can be
//! merged and resumed as any other, and the choice depends on the pixel's own samples alone.

use snowblue_color::LinearRgb;

use crate::film::accumulator::{Estimate, SQUARE_UNITS};
use crate::film::aov::Aovs;

/// Samples before which no pixel is done: with fewer, a rare bright path may be missing.
const FEWEST_SAMPLES: u64 = 32;

impl Estimate {
    /// The standard error of red, green and blue, weighted as in the luminance, relative to the luminance.
    fn noise(&self) -> f64 {
        let luminance = |[r, g, b]: [f64; 3]| LinearRgb { r, g, b }.luminance();
        luminance(self.variance).sqrt() / luminance(self.mean).max(0.0)
    }
}

/// Adds `more` samples to the sums of a pixel of `count` samples if its relative noise is not above `target`. Returns
/// whether it did. A black pixel is never done: rare paths may still find light.
pub(crate) fn repeat_if_done(sums: &mut [i128], aovs: Aovs, [count, more]: [u64; 2], target: f64) -> bool {
    let Some(offset) = aovs.squares_offset().filter(|_| count >= FEWEST_SAMPLES) else { return false };
    let estimate = Estimate::new(sums, &sums[offset..offset + 3], count);
    let is_saturated = sums[offset..offset + 3].contains(&i128::MAX);
    // False for the noise of a black pixel, which is not a number.
    let is_low = estimate.noise() <= target;
    if is_saturated || !is_low {
        return false;
    }
    let (before, after) = (i128::from(count), i128::from(count) + i128::from(more));
    for (index, sum) in sums.iter_mut().enumerate() {
        if !(offset..offset + 3).contains(&index) {
            *sum = *sum / before * after + *sum % before * after / before;
        }
    }
    let after = (count + more) as f64;
    for (k, square) in sums[offset..offset + 3].iter_mut().enumerate() {
        let (mean, variance) = (estimate.mean[k], estimate.variance[k]);
        #[expect(clippy::cast_possible_truncation, reason = "drops a fraction of a unit; large squares saturate")]
        let sum = (after * (variance * (after - 1.0) + mean * mean) * SQUARE_UNITS) as i128;
        *square = sum;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::pixel_accumulator::PixelAccumulator;
    use snowblue_scene::film::sensor::Sensor;
    use snowblue_scene::spectrum::Spectrum;

    const AOVS: Aovs = Aovs {
        spectrum: false,
        variance: true,
        normal: false,
        albedo: false,
        thickness: false,
        angle: false,
        emitter: false,
    };

    /// The sums of samples 1 ± `spread`.
    fn sums(count: u32, spread: f32) -> Vec<i128> {
        let (mut pixel, mut sums) = (PixelAccumulator::new(AOVS), vec![0; AOVS.sum_count()]);
        for sample in 0..count {
            let value = if sample % 2 == 0 { 1.0 - spread } else { 1.0 + spread };
            pixel.add_radiance(&Sensor::cie_1931(), &Spectrum::constant(value));
        }
        pixel.flush(&mut sums);
        sums
    }

    #[test]
    fn a_pixel_is_repeated_once_its_noise_is_below_the_target() {
        // The standard error of 64 samples of spread 0.4 is 0.05.
        for (target, is_done) in [(0.06, true), (0.04, false)] {
            let mut pixel = sums(64, 0.4);
            assert_eq!(repeat_if_done(&mut pixel, AOVS, [64, 16], target), is_done);
            assert_eq!(pixel == sums(64, 0.4), !is_done);
        }
        assert!(!repeat_if_done(&mut sums(16, 0.4), AOVS, [16, 16], 1.0), "too few samples");
    }

    #[test]
    fn repeated_samples_keep_the_mean_and_its_variance() {
        let mut pixel = sums(64, 0.4);
        let before = Estimate::new(&pixel, &pixel[3..], 64);
        assert!(repeat_if_done(&mut pixel, AOVS, [64, 48], 0.1));
        let after = Estimate::new(&pixel, &pixel[3..], 112);
        for k in 0..3 {
            assert!((after.mean[k] / before.mean[k] - 1.0).abs() < 1e-12);
            assert!((after.variance[k] / before.variance[k] - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn black_pixels_are_not_done() {
        assert!(!repeat_if_done(&mut [0; 6], AOVS, [32, 16], 0.01));
    }
}
