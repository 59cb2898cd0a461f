//! Adaptive sampling: pixels whose noise has fallen to a target need no further samples.
//!
//! All pixels count an equal number of samples. Once a pixel needs no more samples, each further sample repeats its
//! mean, and the sums of squares grow so that the variance of the mean does not change. So an image with a noise
//! target can be merged and resumed as any other image. The noise of a pixel is the noise of its own samples, or the
//! noise that remains after the [filter](crate::film::residual_filter).

use rayon::prelude::*;
use snowblue_base::narrow;
use snowblue_color::{LinearRgb, Xyz};

use crate::film::accumulator::{Decision, FilmAccumulator, PixelSums, SQUARE_UNITS, UNITS};
use crate::film::aov::Aovs;
use crate::film::pixel_accumulator::square_units;
use crate::film::residual_filter::Filtered;
use crate::film::window::{SampleBlock, near, square_around};

/// Fewest samples of a pixel that is done: with fewer samples, a rare bright path may be missing. The filter also has
/// the samples of the neighbours.
const MIN_SAMPLES: u32 = 32;
const MIN_FILTERED_SAMPLES: u32 = 4;
/// Number of samples below which a filtered pixel is done only if the noise of all pixels around it is also low, and
/// their light nearly equal: the variance of few samples may be too small by chance.
const MIN_SAMPLES_NEAR_NOISE: u32 = 16;

/// Decides which pixels need no further samples, before a pass over a block that begins at `samples` samples per
/// pixel. A pass that continues after an interrupt keeps its decision. If the decision is lost, all pixels of the
/// pass get their samples.
pub(crate) fn decide(film: &mut FilmAccumulator, block: &SampleBlock, samples: u32, target: f64) {
    let is_start = film.counts_of(block).all(|count| count == samples);
    let is_decided = film.decision.samples == samples && film.decision.target.to_bits() == target.to_bits();
    if is_decided && !(is_start && film.decision.done.is_empty()) {
        return;
    }
    let done = if is_start { done_pixels(film, target) } else { Vec::new() };
    film.decision = Decision { samples, target, done };
}

/// Whether each pixel of the window is done because its relative noise is at most `target`. With the filter a pixel
/// that was done before stays done. A black pixel is done if it shows no surface, and its neighbours show no surface
/// and no light; otherwise rare paths may still find light.
fn done_pixels(film: &FilmAccumulator, target: f64) -> Vec<bool> {
    // False for the noise of a black pixel, which is not a number.
    let is_low = |noise: f32| f64::from(noise) <= target;
    let pixels = film.all_pixels();
    let before: &[bool] = if film.decision.target.to_bits() == target.to_bits() { &film.decision.done } else { &[] };
    if pixels.iter().all(|pixel| pixel.count() < MIN_FILTERED_SAMPLES) {
        return vec![false; pixels.len()];
    }
    // The filter is read at pixels that are not done, and at the pixels around them.
    let open: Vec<bool> = before.iter().map(|done| !done).collect();
    let read = near(&open, 1, film.window().size().width as usize);
    let unread: Vec<bool> = read.into_iter().map(|read| !read).collect();
    let Some(filtered) = Filtered::but_for(film, &unread) else {
        let is_done = |pixel: &PixelSums| pixel.count() >= MIN_SAMPLES && is_low(own_noise(pixel));
        return pixels.par_iter().map(is_done).collect();
    };
    let light = |(index, pixel): (usize, &PixelSums)| pixel.filtered_xyz(Filtered::changes(Some(&filtered), index)).y;
    let light: Vec<f64> = pixels.par_iter().enumerate().map(light).collect();
    let (noise, near_anything) = (filtered.noise(), anything_near(film));
    let size = film.window().size();
    let size = [size.width, size.height].map(|length| length as usize);
    let is_done = |pixel: usize| {
        let samples = pixels[pixel].count();
        if samples < MIN_FILTERED_SAMPLES {
            return false;
        }
        if before.get(pixel) == Some(&true) || noise[pixel].is_nan() && !near_anything[pixel] {
            return true;
        }
        if samples >= MIN_SAMPLES_NEAR_NOISE {
            return is_low(noise[pixel]);
        }
        // All samples of a pixel may have missed an edge that crosses the pixel. The standard error is then at most
        // half of the difference across the edge, divided by the square root of the number of samples.
        let around = || square_around(pixel, 1, size);
        let [least, most] = around().fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], other| {
            [least.min(light[other]), most.max(light[other])]
        });
        let by_edges = 0.5 * (most - least) / f64::from(samples).sqrt();
        by_edges <= target * light[pixel] && around().all(|other| is_low(noise[other]))
    };
    (0..pixels.len()).into_par_iter().map(is_done).collect()
}

/// Whether each pixel of the window or one of the eight pixels around it shows a surface or light.
fn anything_near(film: &FilmAccumulator) -> Vec<bool> {
    let layout = film.aovs().residual_layout();
    let shows_anything =
        |pixel: &PixelSums| layout.is_some_and(|layout| pixel.at(layout.count) > 0) || pixel.mean_xyz().y > 0.0;
    let shows_anything: Vec<bool> = film.all_pixels().par_iter().map(shows_anything).collect();
    near(&shows_anything, 1, film.window().size().width as usize)
}

/// The standard error of red, green and blue, weighted as in the luminance, relative to the luminance.
fn own_noise(pixel: &PixelSums) -> f32 {
    let luminance = |[r, g, b]: [f64; 3]| LinearRgb { r, g, b }.luminance();
    narrow(luminance(pixel.variance().map(f64::from)).sqrt() / pixel.mean_xyz().y.max(0.0))
}

/// Adds `more` samples, which repeat the mean, to the sums of a pixel with `count` samples.
pub(crate) fn repeat(sums: &mut [i128], aovs: Aovs, [count, more]: [u64; 2]) {
    let mean = |offset: usize| sums[offset] as f64 / UNITS / count as f64;
    let LinearRgb { r, g, b } = LinearRgb::from_xyz(Xyz { x: mean(0), y: mean(1), z: mean(2) });
    let rgb = aovs
        .squares_offset()
        .into_iter()
        .flat_map(|offset| [r, g, b].into_iter().enumerate().map(move |(k, mean)| (offset + k, mean)));
    let residual = aovs.residual_layout().into_iter().flat_map(|layout| {
        let residual = mean(layout.residual + 1);
        [(layout.residual_square, residual), (layout.rest_square, mean(1) - residual)]
    });
    let squares: Vec<(usize, i128)> = rgb
        .chain(residual)
        .map(|(offset, mean)| (offset, repeated_square(sums[offset], mean, [count, more])))
        .collect();
    let (before, after) = (i128::from(count), i128::from(count) + i128::from(more));
    for sum in sums.iter_mut() {
        *sum = *sum / before * after + *sum % before * after / before;
    }
    squares.into_iter().for_each(|(offset, square)| sums[offset] = square);
}

/// The sum of squares of `count` samples and `more` repeated samples for which the variance of the mean does not
/// change.
fn repeated_square(sum: i128, mean: f64, [count, more]: [u64; 2]) -> i128 {
    if sum == i128::MAX {
        return sum;
    }
    let (count, after) = (count as f64, (count + more) as f64);
    let variance = (sum as f64 / SQUARE_UNITS / count - mean * mean).max(0.0) / (count - 1.0);
    square_units(after * (variance * (after - 1.0) + mean * mean))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::pixel_accumulator::PixelAccumulator;
    use crate::integrators::FilteredSample;
    use glam::Vec3A;
    use snowblue_scene::film::ImageSize;
    use snowblue_scene::film::sensor::{Sensor, SensorSample};
    use snowblue_scene::spectrum::Spectrum;

    /// A pixel of `count` samples 1 ± `spread`; with `residual`, a pixel of snow with the residual ± `spread`.
    fn film(count: u32, spread: f32, residual: bool) -> FilmAccumulator {
        let aovs = Aovs { variance: true, residual, ..Aovs::default() };
        let block = SampleBlock { columns: 0..1, rows: 0..1, samples: 0..count };
        let mut film = FilmAccumulator::new(ImageSize { width: 1, height: 1 }, &block.window(), aovs);
        film.par_rows_mut(&block).for_each(|row| {
            let mut pixel = PixelAccumulator::new(aovs);
            for sample in 0..count {
                let found = if sample % 2 == 0 { -spread } else { spread };
                let [residual, baseline] = [found, 1.0].map(Spectrum::constant);
                let snow = FilteredSample { residual, baseline, is_snow: true, normal: Vec3A::Z, distance_m: 1.0 };
                let snow = Some(&snow).filter(|_| aovs.residual);
                pixel.add_radiance(&Sensor::cie_1931(), &Spectrum::constant(1.0 + found), snow);
            }
            pixel.flush(row.sums);
            row.counts[0] = count;
        });
        film
    }

    /// The film after `more` repeated samples.
    fn repeated(mut film: FilmAccumulator, count: u32, more: u32) -> FilmAccumulator {
        let aovs = film.aovs();
        film.par_rows_mut(&SampleBlock { columns: 0..1, rows: 0..1, samples: 0..count }).for_each(|row| {
            repeat(row.sums, aovs, [count.into(), more.into()]);
            row.counts[0] += more;
        });
        film
    }

    #[test]
    fn a_pixel_is_done_once_its_noise_is_below_the_target() {
        // The standard error of 64 samples of spread 0.4 is 0.05. A single pixel has no neighbours for the filter.
        for residual in [false, true] {
            assert_eq!(done_pixels(&film(64, 0.4, residual), 0.06), [true]);
            assert_eq!(done_pixels(&film(64, 0.4, residual), 0.04), [false]);
            let block = SampleBlock { columns: 0..1, rows: 0..1, samples: 0..128 };
            let decided = |count: u32| {
                let mut film = film(count, 0.4, residual);
                decide(&mut film, &block, count, 1.0);
                film.decision.done
            };
            assert_eq!(decided(64), [true]);
            let fewest = if residual { MIN_FILTERED_SAMPLES } else { MIN_SAMPLES };
            assert_eq!(decided(fewest - 1), [false], "too few samples");
            assert_eq!(decided(fewest), [true]);
        }
    }

    #[test]
    fn pixels_beside_edges_and_noise_need_more_than_the_fewest_samples() {
        // Bright snow beside dark snow, without noise except in one pixel.
        let block = SampleBlock { columns: 0..12, rows: 0..6, samples: 0..4 };
        let film_of = |samples: u32| {
            let aovs = Aovs { variance: true, residual: true, ..Aovs::default() };
            let mut film = FilmAccumulator::new(ImageSize { width: 12, height: 6 }, &block.window(), aovs);
            film.par_rows_mut(&block).for_each(|row| {
                let mut pixel = PixelAccumulator::new(aovs);
                for (column, sums) in row.sums.chunks_exact_mut(aovs.sum_count()).enumerate() {
                    for sample in 0..samples {
                        let light = if column < 4 { 1.0 } else { 1.5 };
                        // Noise outside the residual, which the filter does not reduce.
                        let noise = if (column, row.number) == (9, 3) && sample == 0 { 3.0 } else { 0.0 };
                        let [residual, baseline] = [0.0, light].map(Spectrum::constant);
                        let snow =
                            FilteredSample { residual, baseline, is_snow: true, normal: Vec3A::Z, distance_m: 1.0 };
                        pixel.add_radiance(&Sensor::cie_1931(), &Spectrum::constant(light + noise), Some(&snow));
                    }
                    pixel.flush(sums);
                }
                row.counts.fill(samples);
            });
            film
        };
        let of_few = done_pixels(&film_of(4), 0.02);
        for (pixel, done) in of_few.iter().enumerate() {
            let (column, row) = (pixel % 12, pixel / 12);
            let is_near = (3..5).contains(&column) || column.abs_diff(9) < 2 && row.abs_diff(3) < 2;
            assert_eq!(*done, !is_near, "{column} {row}");
        }
        // With more samples each pixel counts for itself.
        let mut film = film_of(16);
        let noisy = 3 * 12 + 9;
        let of_more = done_pixels(&film, 0.02);
        assert!(of_more.iter().enumerate().all(|(pixel, done)| *done == (pixel != noisy)), "{of_more:?}");
        // A pixel that is done stays done, but not for another target. A decision is not repeated.
        film.decision = Decision { samples: 4, target: 0.02, done: vec![true; 72] };
        assert!(!done_pixels(&film, 0.02).contains(&false));
        assert_eq!(done_pixels(&film, 0.01), of_more);
        let block = SampleBlock { columns: 0..12, rows: 0..6, samples: 0..64 };
        film.decision = Decision { samples: 16, target: 0.02, done: vec![false; 72] };
        decide(&mut film, &block, 16, 0.02);
        assert_eq!(film.decision.done, [false; 72]);
        decide(&mut film, &block, 16, 0.01);
        assert_eq!(film.decision.done, of_more);
    }

    #[test]
    fn repeated_samples_keep_the_mean_and_its_variance() {
        for residual in [false, true] {
            let before = film(64, 0.4, residual);
            let after = repeated(before.clone(), 64, 48);
            let [before, after] = [&before, &after].map(|film| film.row(0).next().unwrap());
            assert_eq!(after.count(), 112);
            assert!((after.mean_xyz().y / before.mean_xyz().y - 1.0).abs() < 1e-12);
            for (after, before) in after.variance().iter().zip(before.variance()) {
                assert!((after / before - 1.0).abs() < 1e-6, "{after} {before}");
            }
            let [before, after] = [&before, &after].map(|pixel| {
                let layout = Aovs { variance: true, residual, ..Aovs::default() }.residual_layout()?;
                let mean = pixel.mean(layout.residual + 1);
                Some((mean, pixel.variance_of_mean(layout.residual_square, mean.into())))
            });
            assert_eq!(before.is_some(), residual);
            if let (Some(before), Some(after)) = (before, after) {
                assert!((after.0 - before.0).abs() < 1e-9 && (after.1 / before.1 - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn black_pixels_are_done_only_away_from_surfaces() {
        let block = SampleBlock { columns: 0..5, rows: 0..4, samples: 0..32 };
        let is_done = |residual: bool| {
            let aovs = Aovs { variance: true, residual, ..Aovs::default() };
            let mut film = FilmAccumulator::new(ImageSize { width: 5, height: 4 }, &block.window(), aovs);
            film.par_rows_mut(&block).for_each(|row| {
                let mut pixel = PixelAccumulator::new(aovs);
                for (column, sums) in row.sums.chunks_exact_mut(aovs.sum_count()).enumerate() {
                    if (column, row.number) == (1, 1) {
                        let black = SensorSample::from_array([0.0; 4]);
                        let (residual, baseline, is_snow, normal) = (black, black, false, Vec3A::Z);
                        let filtered = FilteredSample { residual, baseline, is_snow, normal, distance_m: 1.0 };
                        pixel.add_sample(black, Some(&filtered));
                    }
                    pixel.flush(sums);
                }
                row.counts.fill(32);
            });
            done_pixels(&film, 0.01)
        };
        let near = |pixel: usize| pixel % 5 < 3 && pixel / 5 < 3;
        assert!(is_done(true).iter().enumerate().all(|(pixel, done)| *done != near(pixel)));
        assert!(!is_done(false).contains(&true), "surfaces are not counted");
    }
}
