//! The samples of one pixel on their way into its [sums](crate::film::accumulator), by arithmetic that is quick.

use snowblue_color::{LinearRgb, Xyz};

use crate::film::accumulator::SQUARE_UNITS;
use crate::film::aov::{Aov, Aovs};
use crate::film::sensor::{Colour, Sensor};
use crate::spectrum::{SAMPLES, Spectrum};

/// Greatest sum of the magnitudes of a sample's wavelengths.
const GREATEST_SAMPLE: f32 = (1u64 << 33) as f32;

/// A sum on its way, in two halves that ordinary integers hold: units of 2⁻¹⁶ and what remains, in units of 2⁻⁶⁴.
#[derive(Debug, Clone, Copy, Default)]
struct Running {
    high: i64,
    low: i64,
}

impl Running {
    /// Adds a value of magnitude below 2³³, at most 2¹³ times before the sum is folded.
    #[inline]
    fn add(&mut self, value: f32) {
        const HIGH_UNITS: f64 = (1u64 << 16) as f64;
        const LOW_UNITS: f64 = (1u64 << 48) as f64;
        let scaled = f64::from(value) * HIGH_UNITS;
        let (whole, high) = rounded(scaled);
        // Exact: both are multiples of the last place of `scaled`, and their difference is smaller.
        let (_, low) = rounded((scaled - whole) * LOW_UNITS);
        self.high += high;
        self.low += low;
    }

    /// Adds what has gathered to a sum and starts anew.
    #[inline]
    fn fold(&mut self, sum: &mut i128) {
        *sum = sum.saturating_add((i128::from(self.high) << 48) + i128::from(self.low));
        *self = Self::default();
    }
}

/// The nearest whole number to one of magnitude below 2⁵¹, as a float and as an integer: in 1.5 · 2⁵² + x the last place is 1,
/// so the sum rounds, and its bits count from those of 1.5 · 2⁵². A cast would do, but Rust's casts ask for numbers out of range.
#[inline]
fn rounded(value: f64) -> (f64, i64) {
    const ONES: f64 = 1.5 * (1u64 << 52) as f64;
    let moved = value + ONES;
    (moved - ONES, moved.to_bits().wrapping_sub(ONES.to_bits()).cast_signed())
}

/// Whether a sample can be added up; false for what is not a number, too.
fn is_usable(sample: Colour) -> bool {
    sample.w < GREATEST_SAMPLE
}

/// The sums of one pixel on their way.
#[derive(Debug)]
pub(crate) struct PixelAccumulator {
    channels: Aovs,
    xyz: [Running; 3],
    spectrum: [Running; SAMPLES],
    squares: [i128; 3],
    /// Of each feature how many samples had it, and its values.
    features: [(i128, [Running; 3]); 4],
    /// Samples that were no usable number.
    pub(crate) unusable: u64,
}

impl PixelAccumulator {
    pub(crate) fn new(channels: Aovs) -> Self {
        Self {
            channels,
            xyz: Default::default(),
            spectrum: [Running::default(); SAMPLES],
            squares: [0; 3],
            features: Default::default(),
            unusable: 0,
        }
    }

    /// Adds one sample of the light.
    #[inline]
    pub(crate) fn add(&mut self, sensor: &Sensor, radiance: &Spectrum) {
        let sample = sensor.sample(radiance);
        self.add_colour(sample);
        if self.channels.spectrum && is_usable(sample) {
            for (sum, &value) in self.spectrum.iter_mut().zip(&radiance.0) {
                sum.add(value);
            }
        }
    }

    /// Adds one sample of the light, by its colour alone.
    #[inline]
    pub(crate) fn add_colour(&mut self, sample: Colour) {
        if !is_usable(sample) {
            self.unusable += 1;
            return;
        }
        let xyz = [sample.x, sample.y, sample.z];
        for (sum, value) in self.xyz.iter_mut().zip(xyz) {
            sum.add(value);
        }
        if self.channels.variance {
            let [x, y, z] = xyz.map(f64::from);
            let LinearRgb { r, g, b } = LinearRgb::from_xyz(Xyz { x, y, z });
            for (sum, value) in self.squares.iter_mut().zip([r, g, b]) {
                #[expect(
                    clippy::cast_possible_truncation,
                    reason = "a fraction of a unit; too great a number saturates"
                )]
                let square = (value * value * SQUARE_UNITS) as i128;
                *sum = sum.saturating_add(square);
            }
        }
    }

    /// Adds what a sample told of a feature, if it is asked for; values that are no usable number do not count.
    pub(crate) fn add_feature(&mut self, feature: Aov, values: [f32; 3]) {
        if self.channels.has(feature) && values.iter().all(|value| value.abs() < GREATEST_SAMPLE) {
            let (count, sums) = &mut self.features[feature as usize];
            *count += 1i128 << 64;
            sums.iter_mut().zip(values).for_each(|(sum, value)| sum.add(value));
        }
    }

    /// Adds what has gathered to the sums of the pixel and starts anew.
    #[inline]
    pub(crate) fn fold(&mut self, sums: &mut [i128]) {
        for (running, sum) in self.xyz.iter_mut().zip(&mut *sums) {
            running.fold(sum);
        }
        if self.channels == Aovs::default() {
            return;
        }
        if self.channels.spectrum {
            self.spectrum.iter_mut().zip(&mut sums[3..]).for_each(|(running, sum)| running.fold(sum));
        }
        if let Some(place) = self.channels.squares() {
            for (gathered, sum) in self.squares.iter_mut().zip(&mut sums[place..]) {
                *sum = sum.saturating_add(std::mem::take(gathered));
            }
        }
        for feature in Aov::ALL {
            if let Some(place) = self.channels.place(feature) {
                let (count, values) = &mut self.features[feature as usize];
                sums[place] += std::mem::take(count);
                let values = &mut values[..feature.names().len()];
                values.iter_mut().zip(&mut sums[place + 1..]).for_each(|(running, sum)| running.fold(sum));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::accumulator::UNITS;

    /// The sum of some values, in units.
    fn sum(values: impl IntoIterator<Item = f32>) -> i128 {
        let (mut running, mut sum) = (Running::default(), 0);
        values.into_iter().for_each(|value| running.add(value));
        running.fold(&mut sum);
        sum
    }

    #[test]
    fn sums_do_not_depend_on_order_or_groups() {
        let values: Vec<f32> =
            (0..1000u32).map(|k| (k as f32 * 0.37).sin() * 10f32.powi((k % 19).cast_signed() - 11)).collect();
        let whole = sum(values.iter().copied());
        assert_eq!(whole, sum(values.iter().rev().copied()));
        assert_eq!(whole, values.chunks(7).map(|chunk| sum(chunk.iter().copied())).sum());
        let expected: f64 = values.iter().map(|&value| f64::from(value)).sum();
        assert!((whole as f64 / UNITS - expected).abs() < 1e-12 * expected.abs(), "{whole} {expected}");
    }

    #[test]
    fn values_are_rounded_to_the_unit() {
        for value in [0.0, 1.0, -1.0, 0.1, 1e-10, -3e-18, 5e-20, 2e9, 123_456.79] {
            // A float's own value, in units, is a float again, but for its rounding to a whole number.
            #[expect(clippy::cast_possible_truncation, reason = "rounded")]
            let expected = (f64::from(value) * UNITS).round_ties_even() as i128;
            assert_eq!(sum([value]), expected, "{value}");
        }
        // As many of the greatest as fit between two foldings.
        let greatest = GREATEST_SAMPLE.next_down();
        assert_eq!(sum(std::iter::repeat_n(greatest, 1 << 13)), ((1i128 << 33) - (1 << 9)) << (64 + 13));
    }

    #[test]
    fn what_is_not_a_number_is_counted_and_dark() {
        let sensor = Sensor::eye();
        let mut pixel = PixelAccumulator::new(Aovs { variance: true, ..Aovs::default() });
        let mut bad = Spectrum::ONE;
        for value in [f32::NAN, f32::INFINITY, -1e30, 1e10] {
            bad.0[30] = value;
            pixel.add(&sensor, &bad);
        }
        let mut sums = [0; 6];
        pixel.fold(&mut sums);
        assert_eq!((pixel.unusable, sums), (4, [0; 6]));
        // A bright sample, whose square fits once, but not five times.
        pixel.add(&sensor, &Spectrum::constant(3.4e7));
        pixel.fold(&mut sums);
        assert_eq!(pixel.unusable, 4);
        let luminance = sums[1] as f64 / UNITS;
        assert!((luminance / 3.4e7 - 1.0).abs() < 1e-6 && sums[3] as f64 / SQUARE_UNITS > 0.9 * luminance * luminance);
        (0..4).for_each(|_| pixel.add(&sensor, &Spectrum::constant(3.4e7)));
        pixel.fold(&mut sums);
        assert_eq!(sums[3], i128::MAX);
    }
}
