//! The filter of random walks: light in snow is smooth where the light field at the surface has taken all edges.
//!
//! A sample of snow by a random walk has the sum of two parts: the reading of the light field at the surface, which has
//! little noise, and the residual, what the walk finds more or less than that. The residual is small, and as smooth as
//! the surface and its light. So its mean over the neighbourhood of a pixel replaces that of the pixel: relative to the
//! reading, over pixels of like normal, distance and reading (a joint bilateral filter by the à-trous scheme: Dammertz,
//! Sewtz, Hanika & Lensch 2010, *Edge-avoiding à-trous wavelet transform for fast global illumination filtering*, HPG).
//!
//! Each level doubles the neighbourhood. Each pixel takes the first level at which the standard error of its residual
//! is below [`TARGET`] of its reading, by the variance of the samples. So the neighbourhood shrinks as samples come, and
//! the picture converges to that of the walks alone.
//!
//! The filter works on the sums of an image, at the end. What is resumed or merged is the same as what is rendered at
//! once; a part of an image is filtered by itself.

use rayon::prelude::*;
use snowblue_geometry::ray::narrow;

use crate::film::accumulator::{FilmAccumulator, PixelSums};
use crate::film::aov::ResidualLayout;

/// Standard error of the residual, relative to the reading, that is aimed at.
const TARGET: f32 = 0.01;
/// Most levels. The last has a neighbourhood of ±62 pixels.
const LEVELS: u32 = 5;
/// Weights along a row or a column.
const KERNEL: [f32; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];
/// Deviations at which a weight falls by e^{−½}: of normals, and of logarithms of the reading.
const NORMAL_DEVIATION: f32 = 0.35;
const READING_DEVIATION: f32 = 0.5;
/// The same of the distance, as a multiple of that of a plane through the neighbouring pixels, and of the distance.
const SLOPE_DEVIATION: f32 = 2.0;
const DISTANCE_DEVIATION: f32 = 0.002;
/// Most that a residual grows with the reading.
const MOST_SCALE: f32 = 4.0;
/// Readings below this fraction of the brightest count as equally dark.
const DARK: f32 = 1e-6;

/// What the filter changes of an image.
pub(crate) struct Filtered {
    /// Number of values of a pixel: X, Y and Z, and the wavelengths of the spectrum if the image has one.
    values: usize,
    /// What is added to the mean of each value of each pixel.
    changes: Vec<f32>,
    /// Standard error of each pixel relative to its luminance, after the filter; of black pixels not a number.
    noise: Vec<f32>,
}

/// What the filter compares of a pixel.
#[derive(Clone, Copy)]
struct Guide {
    /// Mean normal of the snow; zero for a pixel without snow.
    normal: [f32; 3],
    /// Logarithm of the mean reading.
    log_reading: f32,
    /// Mean distance of the snow in m, and the greatest change of it from pixel to pixel along the surface, across and
    /// down.
    distance_m: f32,
    slope_m: [f32; 2],
    is_snow: bool,
}

/// An image of residuals, one level of the filter.
#[derive(Clone)]
struct Level {
    /// The values of the residual, per sample of the pixel.
    residual: Vec<f32>,
    /// Reading and variance of the mean luminance of the residual, likewise.
    luminance: Vec<Luminance>,
}

#[derive(Clone, Copy, Default)]
struct Luminance {
    reading: f32,
    variance: f32,
}

impl Luminance {
    /// The standard error of the residual relative to the reading.
    fn error(self) -> f32 {
        self.variance.sqrt() / self.reading.max(f32::MIN_POSITIVE)
    }
}

impl Filtered {
    /// Filters the residuals of an image; none if it has no such sums.
    pub(crate) fn new(film: &FilmAccumulator) -> Option<Self> {
        let layout = film.aovs().residual_layout()?;
        let width = film.window().size().width as usize;
        let pixels: Vec<PixelSums> = film.window().rows.clone().flat_map(|row| film.row(row)).collect();
        let filter = Filter { width, values: layout.values, guides: guides(&pixels, layout, width) };
        let start = Level::of(&pixels, layout);
        let Filter { values, .. } = filter;
        let Level { residual: mut changes, luminance } = filter.run(&start);
        let noise = pixels.par_iter().zip(&luminance).zip(&start.luminance).zip(changes.par_chunks_exact(values));
        let noise = noise.zip(start.residual.par_chunks_exact(values));
        let noise = noise.map(|((((pixel, after), before), residual), own)| {
            let rest = narrow(pixel.mean_xyz().y) - own[1];
            let rest_variance = pixel.variance_of_mean(layout.rest_square, rest.into());
            // The rest contains the reading, and the residual is a multiple of the reading.
            let scale = if before.reading > 0.0 { 1.0 + residual[1] / before.reading } else { 1.0 };
            (rest_variance * scale * scale + after.variance).sqrt() / (rest + residual[1]).max(0.0)
        });
        let noise = noise.collect();
        changes.iter_mut().zip(&start.residual).for_each(|(change, own)| *change -= own);
        Some(Self { values, changes, noise })
    }

    /// What is added to X, Y and Z, and then the wavelengths, of a pixel of the window, row by row.
    pub(crate) fn changes_of(&self, pixel: usize) -> &[f32] {
        &self.changes[pixel * self.values..][..self.values]
    }

    /// Standard error of each pixel relative to its luminance; of black pixels not a number.
    pub(crate) fn into_noise(self) -> Vec<f32> {
        self.noise
    }
}

impl Level {
    fn of(pixels: &[PixelSums], layout: ResidualLayout) -> Self {
        let residual = pixels.iter().flat_map(|pixel| (0..layout.values).map(|k| pixel.mean(layout.residual + k)));
        let luminance = |pixel: &PixelSums| Luminance {
            reading: pixel.mean(layout.reading).max(0.0),
            variance: pixel.variance_of_mean(layout.residual_square, pixel.mean(layout.residual + 1).into()),
        };
        Self { residual: residual.collect(), luminance: pixels.iter().map(luminance).collect() }
    }
}

/// What the filter compares of each pixel.
fn guides(pixels: &[PixelSums], layout: ResidualLayout, width: usize) -> Vec<Guide> {
    let of_snow = |pixel: &PixelSums, offset: usize| pixel.quotient(offset, layout.count);
    let is_snow = |pixel: &PixelSums| pixel.at(layout.count) > 0;
    let readings = pixels.iter().map(|pixel| of_snow(pixel, layout.reading));
    let dark = DARK * readings.clone().fold(f32::MIN_POSITIVE, f32::max);
    let distances: Vec<Option<f32>> =
        pixels.iter().map(|pixel| is_snow(pixel).then(|| of_snow(pixel, layout.distance))).collect();
    // The smaller change to the neighbours on both sides: on the surface, and not over its edge.
    let slope = |index: usize, step: usize, has_before: bool, has_after: bool| {
        let before = has_before.then(|| distances[index - step]).flatten();
        let after = has_after.then(|| distances.get(index + step).copied().flatten()).flatten();
        let change = |other: f32| (other - distances[index].unwrap_or(other)).abs();
        before.into_iter().chain(after).map(change).fold(f32::INFINITY, f32::min)
    };
    let guide = |(index, (pixel, reading)): (usize, (&PixelSums, f32))| {
        let (column, row) = (index % width, index / width);
        let slopes = [slope(index, 1, column > 0, column + 1 < width), slope(index, width, row > 0, true)];
        Guide {
            normal: [0, 1, 2].map(|k| of_snow(pixel, layout.normal + k)),
            log_reading: reading.max(dark).ln(),
            distance_m: distances[index].unwrap_or(0.0),
            slope_m: slopes.map(|slope| if slope.is_finite() { slope } else { 0.0 }),
            is_snow: is_snow(pixel),
        }
    };
    pixels.iter().zip(readings).enumerate().map(guide).collect()
}

impl Guide {
    /// How much the residual of another pixel, so many pixels across and down, counts for this one.
    #[inline]
    fn weight(&self, other: &Self, across: f32, down: f32) -> f32 {
        if !other.is_snow {
            return 0.0;
        }
        let square = |x: f32| x * x;
        let normals: f32 = self.normal.iter().zip(other.normal).map(|(one, other)| square(one - other)).sum();
        let readings = square(self.log_reading - other.log_reading);
        let plane_m = self.slope_m[0] * across.abs() + self.slope_m[1] * down.abs();
        let deviation_m = SLOPE_DEVIATION * plane_m + DISTANCE_DEVIATION * self.distance_m;
        let distances = square((self.distance_m - other.distance_m) / deviation_m.max(f32::MIN_POSITIVE));
        let sum = normals / square(NORMAL_DEVIATION) + readings / square(READING_DEVIATION) + distances;
        (-0.5 * sum).exp()
    }
}

/// The filter at work.
struct Filter {
    width: usize,
    values: usize,
    guides: Vec<Guide>,
}

impl Filter {
    /// The residual of each pixel, with its variance, after as many levels as it needs.
    fn run(&self, start: &Level) -> Level {
        let mut level = Level { luminance: self.with_smooth_variances(&start.luminance), ..start.clone() };
        let mut result = level.clone();
        let is_noisy = |(luminance, guide): (&Luminance, &Guide)| guide.is_snow && luminance.error() > TARGET;
        let mut needs: Vec<bool> = level.luminance.iter().zip(&self.guides).map(is_noisy).collect();
        for number in 0..LEVELS {
            if !needs.contains(&true) {
                break;
            }
            let next = self.next(&level, 1 << number);
            let results = result.residual.par_chunks_exact_mut(self.values).zip(&mut result.luminance);
            results.zip(&mut needs).enumerate().for_each(|(pixel, ((residual, luminance), need))| {
                if *need {
                    let own = start.luminance[pixel].reading;
                    *luminance = blend([&level, &next], pixel, own, residual);
                    *need = next.luminance[pixel].error() > TARGET;
                }
            });
            level = next;
        }
        result
    }

    /// The next level, by pixels that are so many apart.
    fn next(&self, level: &Level, step: usize) -> Level {
        let mut residual = vec![0.0; level.residual.len()];
        let pixels = residual.par_chunks_exact_mut(self.values).enumerate();
        let luminance = pixels.map(|(pixel, sums)| {
            let (mut total, mut luminance) = (0.0, Luminance::default());
            self.for_neighbours(pixel, step, |neighbour, weight| {
                total += weight;
                let Luminance { reading, variance } = level.luminance[neighbour];
                luminance.reading += weight * reading;
                luminance.variance += weight * weight * variance;
                let values = &level.residual[neighbour * self.values..];
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
            });
            let factor = if total > 0.0 { total.recip() } else { 0.0 };
            sums.iter_mut().for_each(|sum| *sum *= factor);
            Luminance { reading: luminance.reading * factor, variance: luminance.variance * factor * factor }
        });
        let luminance = luminance.collect();
        Level { residual, luminance }
    }

    /// Variances averaged over the nearest pixels: those of few samples are noisy themselves.
    fn with_smooth_variances(&self, luminance: &[Luminance]) -> Vec<Luminance> {
        let smooth = |(pixel, own): (usize, &Luminance)| {
            let (mut total, mut sum) = (0.0, 0.0);
            self.for_neighbours(pixel, 1, |neighbour, weight| {
                total += weight;
                sum += weight * luminance[neighbour].variance;
            });
            Luminance { variance: if total > 0.0 { sum / total } else { own.variance }, ..*own }
        };
        luminance.par_iter().enumerate().map(smooth).collect()
    }

    /// Calls `add` for the neighbours of a pixel of snow, so many apart, and itself, with their weights.
    #[inline]
    fn for_neighbours(&self, pixel: usize, step: usize, mut add: impl FnMut(usize, f32)) {
        let guide = &self.guides[pixel];
        if !guide.is_snow {
            return;
        }
        let (column, row, height) = (pixel % self.width, pixel / self.width, self.guides.len() / self.width);
        let places = |middle: usize, end: usize| {
            let place = move |tap: usize| (middle + tap * step).checked_sub(2 * step).filter(|place| *place < end);
            (0..KERNEL.len()).filter_map(move |tap| Some((place(tap)?, KERNEL[tap])))
        };
        for (y, down) in places(row, height) {
            for (x, across) in places(column, self.width) {
                let neighbour = y * self.width + x;
                let [dx, dy] = [x.abs_diff(column) as f32, y.abs_diff(row) as f32];
                let weight = guide.weight(&self.guides[neighbour], dx, dy);
                if weight > 0.0 {
                    add(neighbour, weight * across * down);
                }
            }
        }
    }
}

/// Sets the residual of a pixel between two levels, so that its error is the target if the second is below it.
fn blend(levels: [&Level; 2], pixel: usize, reading: f32, residual: &mut [f32]) -> Luminance {
    let luminance = levels.map(|level| level.luminance[pixel]);
    let errors = luminance.map(Luminance::error);
    let share = if errors[1] > TARGET { 1.0 } else { (errors[0] - TARGET) / (errors[0] - errors[1]) };
    // The residual is a multiple of the reading.
    let scale = luminance.map(
        |Luminance { reading: of_level, .. }| {
            if reading > 0.0 && of_level > 0.0 { (reading / of_level).min(MOST_SCALE) } else { 1.0 }
        },
    );
    let factors = [(1.0 - share) * scale[0], share * scale[1]];
    let values = residual.len();
    for (index, residual) in residual.iter_mut().enumerate() {
        let [first, second] = levels.map(|level| level.residual[pixel * values + index]);
        *residual = factors[0] * first + factors[1] * second;
    }
    let variance = factors[0] * factors[0] * luminance[0].variance + factors[1] * factors[1] * luminance[1].variance;
    Luminance { reading, variance }
}
