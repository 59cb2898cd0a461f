//! Fast sums over a few samples of one pixel, before they go into the [film accumulator](crate::film::accumulator).

use snowblue_color::{LinearRgb, Xyz};

use crate::film::accumulator::SQUARE_UNITS;
use crate::film::aov::{Aov, Aovs, ResidualLayout, SPECTRUM_OFFSET};
use crate::integrators::FilteredSample;
use snowblue_scene::film::sensor::{Sensor, SensorSample};
use snowblue_scene::spectrum::{SAMPLES, Spectrum};

/// Upper limit of the sum of the magnitudes of a sample's wavelengths.
const MAX_MAGNITUDE: f32 = (1u64 << 33) as f32;

/// A sum split into two 64-bit integers: units of 2⁻¹⁶ and the remainder in units of 2⁻⁶⁴.
#[derive(Debug, Clone, Copy, Default)]
struct SplitSum {
    high: i64,
    low: i64,
}

impl SplitSum {
    /// Adds a value of magnitude below 2³³, at most 2¹³ times between two flushes.
    #[inline]
    fn add(&mut self, value: f32) {
        const HIGH_UNITS: f64 = (1u64 << 16) as f64;
        const LOW_UNITS: f64 = (1u64 << 48) as f64;
        let scaled = f64::from(value) * HIGH_UNITS;
        let high = Rounded::of(scaled);
        // Exact: both are multiples of the last place of `scaled`, and their difference is smaller.
        let low = Rounded::of((scaled - high.float) * LOW_UNITS);
        self.high += high.integer;
        self.low += low.integer;
    }

    /// Adds this sum to `sum` and resets it to 0.
    #[inline]
    fn flush(&mut self, sum: &mut i128) {
        *sum = sum.saturating_add((i128::from(self.high) << 48) + i128::from(self.low));
        *self = Self::default();
    }
}

/// A whole number, as a float and as an integer.
struct Rounded {
    float: f64,
    integer: i64,
}

impl Rounded {
    /// The whole number nearest to a value of magnitude below 2⁵¹. Around 1.5 · 2⁵² the last place of a float is 1:
    /// adding 1.5 · 2⁵² rounds the value, and the difference of the bits is the integer. Faster than a cast, which must
    /// saturate.
    #[inline]
    fn of(value: f64) -> Self {
        const OFFSET: f64 = 1.5 * (1u64 << 52) as f64;
        let shifted = value + OFFSET;
        let integer = shifted.to_bits().wrapping_sub(OFFSET.to_bits()).cast_signed();
        Self { float: shifted - OFFSET, integer }
    }
}

/// Whether a sample can be added. False for a sample that is not a number.
fn is_usable(sample: SensorSample) -> bool {
    sample.magnitude() < MAX_MAGNITUDE
}

/// Sums over a few samples of one pixel.
#[derive(Debug)]
pub(crate) struct PixelAccumulator {
    aovs: Aovs,
    xyz: [SplitSum; 3],
    spectrum: [SplitSum; SAMPLES],
    squares: [i128; 3],
    residual: ResidualSums,
    first_hit: [AovSums; Aov::COUNT],
    /// Samples that are not finite, or too bright.
    pub(crate) unusable_samples: u64,
}

/// Sums for the filter, as in [`ResidualLayout`].
#[derive(Debug, Default)]
struct ResidualSums {
    values: Vec<SplitSum>,
    square: i128,
    rest_square: i128,
    /// Numbers of samples that meet a surface, and that hit snow with a light field, in units of 2⁻⁶⁴.
    count: i128,
    snow: i128,
    baseline: SplitSum,
    normal: [SplitSum; 3],
    distance: SplitSum,
}

/// Sums of one AOV.
#[derive(Debug, Clone, Copy, Default)]
struct AovSums {
    /// Number of samples that have the AOV, in units of 2⁻⁶⁴.
    count: i128,
    values: [SplitSum; 3],
}

impl PixelAccumulator {
    pub(crate) fn new(aovs: Aovs) -> Self {
        Self {
            aovs,
            xyz: Default::default(),
            spectrum: [SplitSum::default(); SAMPLES],
            squares: [0; 3],
            residual: ResidualSums {
                values: vec![SplitSum::default(); aovs.residual_layout().map_or(0, |layout| layout.values)],
                ..ResidualSums::default()
            },
            first_hit: Default::default(),
            unusable_samples: 0,
        }
    }

    /// Adds the radiance of a sample, with its values for the filter.
    #[inline]
    pub(crate) fn add_radiance(
        &mut self,
        sensor: &Sensor,
        radiance: &Spectrum,
        filtered: Option<&FilteredSample<Spectrum>>,
    ) {
        let sample = sensor.sample(radiance);
        let filtered_sample = filtered.map(|filtered| filtered.map(|spectrum| sensor.sample(spectrum)));
        if !self.add_sample(sample, filtered_sample.as_ref()) || !self.aovs.spectrum {
            return;
        }
        for (sum, &value) in self.spectrum.iter_mut().zip(&radiance.0) {
            sum.add(value);
        }
        if let (Some(filtered), [_, _, _, sums @ ..]) = (filtered, &mut *self.residual.values) {
            sums.iter_mut().zip(&filtered.residual.0).for_each(|(sum, value)| sum.add(*value));
        }
    }

    /// Adds a sample without its spectrum, with its values for the filter. Returns whether it is usable.
    #[inline]
    pub(crate) fn add_sample(&mut self, sample: SensorSample, filtered: Option<&FilteredSample<SensorSample>>) -> bool {
        if !is_usable(sample) || filtered.is_some_and(|one| !is_usable(one.residual) || !is_usable(one.baseline)) {
            self.unusable_samples += 1;
            return false;
        }
        if self.aovs.residual {
            self.residual.add(sample, filtered);
        }
        // A black sample adds nothing.
        if sample.magnitude() <= 0.0 {
            return true;
        }
        let xyz = sample.xyz();
        for (sum, value) in self.xyz.iter_mut().zip(xyz) {
            sum.add(value);
        }
        if self.aovs.variance {
            let [x, y, z] = xyz.map(f64::from);
            let LinearRgb { r, g, b } = LinearRgb::from_xyz(Xyz { x, y, z });
            for (sum, value) in self.squares.iter_mut().zip([r, g, b]) {
                *sum = sum.saturating_add(square_units(value * value));
            }
        }
        true
    }

    /// Adds an AOV of a sample if the layout has it and all values are usable.
    pub(crate) fn add_aov(&mut self, aov: Aov, values: [f32; 3]) {
        if self.aovs.contains(aov) && values.iter().all(|value| value.abs() < MAX_MAGNITUDE) {
            let sums = &mut self.first_hit[aov as usize];
            sums.count += 1i128 << 64;
            sums.values.iter_mut().zip(values).for_each(|(sum, value)| sum.add(value));
        }
    }

    /// Adds all sums to the sums of the pixel and resets them to 0.
    #[inline]
    pub(crate) fn flush(&mut self, sums: &mut [i128]) {
        for (split, sum) in self.xyz.iter_mut().zip(&mut *sums) {
            split.flush(sum);
        }
        if self.aovs == Aovs::default() {
            return;
        }
        if self.aovs.spectrum {
            self.spectrum.iter_mut().zip(&mut sums[SPECTRUM_OFFSET..]).for_each(|(split, sum)| split.flush(sum));
        }
        if let Some(offset) = self.aovs.squares_offset() {
            for (square, sum) in self.squares.iter_mut().zip(&mut sums[offset..]) {
                *sum = sum.saturating_add(std::mem::take(square));
            }
        }
        if let Some(layout) = self.aovs.residual_layout() {
            self.residual.flush(layout, sums);
        }
        for aov in self.aovs.of_first_surface() {
            if let Some(offset) = self.aovs.offset(aov) {
                let AovSums { count, values } = &mut self.first_hit[aov as usize];
                sums[offset] += std::mem::take(count);
                let values = &mut values[..aov.channel_names().len()];
                values.iter_mut().zip(&mut sums[offset + 1..]).for_each(|(split, sum)| split.flush(sum));
            }
        }
    }
}

impl ResidualSums {
    /// Adds a sample, with its values for the filter.
    #[inline]
    fn add(&mut self, sample: SensorSample, filtered: Option<&FilteredSample<SensorSample>>) {
        let residual_y = filtered.map_or(0.0, |filtered| filtered.residual.luminance());
        let rest_y = f64::from(sample.luminance() - residual_y);
        self.rest_square = self.rest_square.saturating_add(square_units(rest_y * rest_y));
        let Some(FilteredSample { residual, baseline, is_snow, normal, distance_m }) = filtered else { return };
        self.values.iter_mut().zip(residual.xyz()).for_each(|(sum, value)| sum.add(value));
        let residual_y = f64::from(residual_y);
        self.square = self.square.saturating_add(square_units(residual_y * residual_y));
        self.count += 1i128 << 64;
        self.snow += if *is_snow { 1i128 << 64 } else { 0 };
        self.baseline.add(baseline.luminance());
        self.normal.iter_mut().zip(normal.to_array()).for_each(|(sum, value)| sum.add(value));
        self.distance.add(distance_m.min(MAX_MAGNITUDE.next_down()));
    }

    /// Adds all sums to the sums of the pixel and resets them to 0.
    fn flush(&mut self, layout: ResidualLayout, sums: &mut [i128]) {
        self.values.iter_mut().zip(&mut sums[layout.residual..]).for_each(|(split, sum)| split.flush(sum));
        for (square, offset) in
            [(&mut self.square, layout.residual_square), (&mut self.rest_square, layout.rest_square)]
        {
            sums[offset] = sums[offset].saturating_add(std::mem::take(square));
        }
        sums[layout.count] += std::mem::take(&mut self.count);
        sums[layout.snow] += std::mem::take(&mut self.snow);
        self.baseline.flush(&mut sums[layout.baseline]);
        self.normal.iter_mut().zip(&mut sums[layout.normal..]).for_each(|(split, sum)| split.flush(sum));
        self.distance.flush(&mut sums[layout.distance]);
    }
}

/// A square in units of a sum of squares.
#[expect(clippy::cast_possible_truncation, reason = "drops a fraction of a unit; large squares saturate")]
pub(crate) fn square_units(square: f64) -> i128 {
    (square * SQUARE_UNITS) as i128
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::accumulator::UNITS;

    /// The sum of some values, in units.
    fn sum(values: impl IntoIterator<Item = f32>) -> i128 {
        let (mut split, mut sum) = (SplitSum::default(), 0);
        values.into_iter().for_each(|value| split.add(value));
        split.flush(&mut sum);
        sum
    }

    #[test]
    fn sums_do_not_depend_on_order_or_grouping() {
        let values: Vec<f32> =
            (0..1000u32).map(|k| (k as f32 * 0.37).sin() * 10f32.powi((k % 19).cast_signed() - 11)).collect();
        let whole = sum(values.iter().copied());
        assert_eq!(whole, sum(values.iter().rev().copied()));
        assert_eq!(whole, values.chunks(7).map(|chunk| sum(chunk.iter().copied())).sum());
        let expected: f64 = values.iter().map(|&value| f64::from(value)).sum();
        assert!((whole as f64 / UNITS - expected).abs() < 1e-12 * expected.abs(), "{whole} {expected}");
    }

    #[test]
    fn values_are_rounded_to_the_nearest_unit() {
        for value in [0.0, 1.0, -1.0, 0.1, 1e-10, -3e-18, 5e-20, 2e9, 123_456.79] {
            // Scaling by a power of two is exact.
            #[expect(clippy::cast_possible_truncation, reason = "rounded")]
            let expected = (f64::from(value) * UNITS).round_ties_even() as i128;
            assert_eq!(sum([value]), expected, "{value}");
        }
        // The largest sum between two flushes.
        let largest = MAX_MAGNITUDE.next_down();
        assert_eq!(sum(std::iter::repeat_n(largest, 1 << 13)), ((1i128 << 33) - (1 << 9)) << (64 + 13));
    }

    #[test]
    fn unusable_samples_are_counted_and_black() {
        let sensor = Sensor::cie_1931();
        let mut pixel = PixelAccumulator::new(Aovs { variance: true, ..Aovs::default() });
        let mut radiance = Spectrum::ONE;
        for value in [f32::NAN, f32::INFINITY, -1e30, 1e10] {
            radiance.0[30] = value;
            pixel.add_radiance(&sensor, &radiance, None);
        }
        let mut sums = [0; 6];
        pixel.flush(&mut sums);
        assert_eq!((pixel.unusable_samples, sums), (4, [0; 6]));
    }

    #[test]
    fn sums_of_squares_saturate() {
        let sensor = Sensor::cie_1931();
        let mut pixel = PixelAccumulator::new(Aovs { variance: true, ..Aovs::default() });
        let mut sums = [0; 6];
        // The square of this sample fits once, but not five times.
        pixel.add_radiance(&sensor, &Spectrum::constant(3.4e7), None);
        pixel.flush(&mut sums);
        assert_eq!(pixel.unusable_samples, 0);
        let luminance = sums[1] as f64 / UNITS;
        assert!((luminance / 3.4e7 - 1.0).abs() < 1e-6 && sums[3] as f64 / SQUARE_UNITS > 0.9 * luminance * luminance);
        (0..4).for_each(|_| pixel.add_radiance(&sensor, &Spectrum::constant(3.4e7), None));
        pixel.flush(&mut sums);
        assert_eq!(sums[3], i128::MAX);
    }
}
