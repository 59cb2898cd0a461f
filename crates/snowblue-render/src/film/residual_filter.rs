//! The filter of random walks and of samples of a sky: light in snow is smooth where the light field at the surface has
//! taken all edges.
//!
//! A sample of snow is the sum of two parts: the reading of the light field at the surface, which has little noise, and
//! the residual, what the walk, or by `diffusion` the samples of a sky, find more or less than that. In the reading a
//! sky, not an image of one, has the irradiance that the light field knows at its cells. The residual is small, and as
//! smooth as the surface and its light. So its mean over the neighbourhood of a pixel replaces that of the pixel:
//! relative to the reading, over pixels of like normal, distance and reading (a joint bilateral filter by the à-trous
//! scheme: Dammertz, Sewtz, Hanika & Lensch 2010, *Edge-avoiding à-trous wavelet transform for fast global illumination
//! filtering*, HPG).
//!
//! Pixels of like noise count more, too: near edges walks are noisy, and their residual is not that of even snow. Each
//! level doubles the neighbourhood. Each pixel takes the first level at which the standard error of its residual is
//! below 1 % of its reading, by the variance of the samples. So the neighbourhood shrinks as samples come, and the
//! picture converges to that of the samples alone.
//!
//! Some pixels find too few like pixels, as at silhouettes and the edges of shadows, and a single walk of few samples
//! makes a dot there: a white one, or a black one, since differences of walks may be negative. Where the noise is
//! large, a pixel is therefore made no brighter and no darker than the snow next to it, by another residual. What is
//! taken away or added is spread over the snow around, so that the light of the image stays the same.
//!
//! The filter works on the sums of an image, at the end. What is resumed or merged is the same as what is rendered at
//! once; a part of an image is filtered by itself.

use rayon::prelude::*;
use snowblue_geometry::ray::narrow;

use crate::film::accumulator::{FilmAccumulator, PixelSums};
use crate::film::aov::{Aovs, ResidualLayout};

/// Standard error of the residual, relative to the reading, that is aimed at.
const TARGET: f32 = 0.01;
/// For each level, the variance of its means over that of means of independent pixels: neighbours share samples. It is
/// that of a plane of like pixels. The last level has a neighbourhood of ±62 pixels.
const SHARED_VARIANCE: [f32; 5] = [1.0, 2.727, 3.196, 3.307, 3.335];
/// Weights along a row or a column.
const KERNEL: [f32; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];
/// Deviations at which a weight falls by e^{−½}: of normals, and of the logarithm of the reading.
const NORMAL_DEVIATION: f32 = 0.35;
const READING_DEVIATION: f32 = 0.5;
/// The same of the fraction of snow: its residual is of another kind than that of other surfaces.
const SNOW_DEVIATION: f32 = 0.2;
/// The same of the logarithm of the noise, which grows near edges.
const ERROR_DEVIATION: f32 = 1.0;
/// The same of the distance, as a multiple of that of a plane through the neighbouring pixels, and of the distance.
const SLOPE_DEVIATION: f32 = 2.0;
const DISTANCE_DEVIATION: f32 = 0.002;
/// Standard errors by which the mean over a neighbourhood may differ from that over a smaller one.
const CONFIDENCE: f32 = 6.0;
/// Least error of a residual that is told from none.
const LEAST_ERROR: f32 = 1e-4;
/// The geometric mean of variances of few samples is less than their mean: by about a factor of 1 + this number over
/// that of samples, found by trial on walks.
const SAMPLES_OF_DOUBT: f32 = 16.0;
/// A variance that counts as unknown, of sums that are saturated.
const GREATEST_VARIANCE: f32 = 1e20;
/// Weights below this are none.
const LEAST_WEIGHT: f32 = 1e-4;
/// Most that a residual grows with the reading.
const MOST_SCALE: f32 = 4.0;
/// Standard error relative to the reading above which a pixel of snow that is brighter or darker than all eight around
/// it is an outlier.
const OUTLIER_ERROR: f32 = 0.25;
/// What is spread changes the pixels around an outlier by this fraction of their standard error, which counts as 1 % of
/// their light at least; more pixels on each side take part until they suffice.
const MOST_SPREAD: f32 = 0.5;
const SPREAD_PIXELS: [usize; 5] = [1, 2, 4, 8, 16];
/// Fraction of the samples of a pixel that hit snow from which on nothing else counts in its colour.
const FULL_COVERAGE: f32 = 0.999;
/// Readings below this fraction of the brightest count as equally dark.
const DARK: f32 = 1e-6;

/// What the filter changes of an image.
pub(crate) struct Filtered {
    /// Number of values of a pixel: X, Y and Z, and the wavelengths of the spectrum if the image has one.
    values: usize,
    /// What is added to the mean of each value of each pixel.
    changes: Vec<f32>,
    /// Standard error of each pixel relative to its luminance, after the filter; no finite number if that is 0.
    noise: Vec<f32>,
}

/// Memory of the filter at work, in bytes for each pixel of an image: guides, and four levels.
pub fn bytes_per_pixel(aovs: Aovs) -> u64 {
    let bytes = |layout: ResidualLayout| {
        let level = size_of::<Luminance>() + layout.values * size_of::<f32>();
        size_of::<PixelSums>() + size_of::<Guide>() + 4 * level + 4 * size_of::<f32>()
    };
    aovs.residual_layout().map_or(0, bytes) as u64
}

/// What the filter compares of a pixel.
#[derive(Clone, Copy)]
struct Guide {
    /// Mean normal of the snow; zero for a pixel without snow.
    normal: [f32; 3],
    /// Logarithm of the mean reading.
    log_reading: f32,
    /// Mean distance of the snow in m, and its change from pixel to pixel along the surface, across and down.
    distance_m: f32,
    slope_m: [f32; 2],
    /// Logarithm of the standard error of the residual relative to the reading.
    log_error: f32,
    /// Fraction of the samples of surfaces that hit snow with a light field.
    snow: f32,
    /// Whether the pixel shows a surface.
    is_filtered: bool,
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

    /// Its logarithm, between those of no error and of no reading.
    fn log_error(self) -> f32 {
        self.error().clamp(LEAST_ERROR, LEAST_ERROR.recip()).ln()
    }
}

impl Filtered {
    /// Filters the residuals of an image; none if it has no such sums.
    pub(crate) fn new(film: &FilmAccumulator) -> Option<Self> {
        let layout = film.aovs().residual_layout()?;
        let width = film.window().size().width as usize;
        let pixels = film.all_pixels();
        let counts: Vec<u32> = pixels.iter().map(PixelSums::count).collect();
        let values = layout.values;
        let mut filter = Filter { width, values, guides: guides(&pixels, layout, width) };
        let start = Level::of(&pixels, layout);
        let Level { residual: mut changes, luminance } = filter.run(&start, &counts);
        let coverage: Vec<f32> = pixels.iter().map(|pixel| pixel.mean(layout.count)).collect();
        let rest_of = |pixel: usize| {
            let residual = &start.residual[pixel * values..][..values];
            residual.iter().enumerate().map(|(k, residual)| pixels[pixel].mean(k) - residual).collect()
        };
        filter.spread_outliers([&start.luminance, &luminance], &coverage, &rest_of, &mut changes);
        let noise = pixels.par_iter().zip(&luminance).zip(&start.luminance).zip(changes.par_chunks_exact(values));
        let noise = noise.zip(start.residual.par_chunks_exact(values));
        let noise = noise.map(|((((pixel, after), before), residual), own)| {
            let rest = narrow(pixel.mean_xyz().y) - own[1];
            let rest_variance = pixel.variance_of_mean(layout.rest_square, rest.into());
            // The residual is a multiple of the reading, which is part of the rest.
            let scale = if before.reading > 0.0 && rest > 0.0 { 1.0 + residual[1] / rest } else { 1.0 };
            (rest_variance * scale * scale + after.variance).sqrt() / (rest + residual[1]).max(0.0)
        });
        let noise = noise.collect();
        changes.iter_mut().zip(&start.residual).for_each(|(change, own)| *change -= own);
        Some(Self { values, changes, noise })
    }

    /// What is added to X, Y and Z, and then the wavelengths, of a pixel of the window, row by row; nothing without a
    /// filter.
    pub(crate) fn changes(filtered: Option<&Self>, pixel: usize) -> &[f32] {
        filtered.map_or(&[], |filtered| &filtered.changes[pixel * filtered.values..][..filtered.values])
    }

    /// Standard error of each pixel relative to its luminance; no finite number if that is 0.
    pub(crate) fn into_noise(self) -> Vec<f32> {
        self.noise
    }
}

impl Level {
    fn of(pixels: &[PixelSums], layout: ResidualLayout) -> Self {
        let residual = pixels.iter().flat_map(|pixel| (0..layout.values).map(|k| pixel.mean(layout.residual + k)));
        let variance = |pixel: &PixelSums| {
            let mean = pixel.mean(layout.residual + 1);
            pixel.variance_of_mean(layout.residual_square, mean.into()).min(GREATEST_VARIANCE)
        };
        let luminance =
            |pixel: &PixelSums| Luminance { reading: pixel.mean(layout.reading).max(0.0), variance: variance(pixel) };
        Self { residual: residual.collect(), luminance: pixels.iter().map(luminance).collect() }
    }
}

/// What the filter compares of each pixel.
fn guides(pixels: &[PixelSums], layout: ResidualLayout, width: usize) -> Vec<Guide> {
    let of_surface = |pixel: &PixelSums, offset: usize| pixel.quotient(offset, layout.count);
    let is_filtered = |pixel: &PixelSums| pixel.at(layout.count) > 0;
    let readings = pixels.iter().map(|pixel| of_surface(pixel, layout.reading));
    let dark = DARK * readings.clone().fold(f32::MIN_POSITIVE, f32::max);
    let distances: Vec<Option<f32>> =
        pixels.iter().map(|pixel| is_filtered(pixel).then(|| of_surface(pixel, layout.distance))).collect();
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
            normal: [0, 1, 2].map(|k| of_surface(pixel, layout.normal + k)),
            log_reading: reading.max(dark).ln(),
            distance_m: distances[index].unwrap_or(0.0),
            slope_m: slopes.map(|slope| if slope.is_finite() { slope } else { 0.0 }),
            log_error: 0.0,
            snow: of_surface(pixel, layout.snow),
            is_filtered: is_filtered(pixel),
        }
    };
    let readings: Vec<f32> = readings.collect();
    pixels.par_iter().zip(readings).enumerate().map(guide).collect()
}

impl Guide {
    /// How much the residual of another pixel, so many pixels across and down, counts for this one.
    #[inline]
    fn weight(&self, other: &Self, across: f32, down: f32) -> f32 {
        if !other.is_filtered {
            return 0.0;
        }
        let square = |x: f32| x * x;
        let normals: f32 = self.normal.iter().zip(other.normal).map(|(one, other)| square(one - other)).sum();
        let readings = square(self.log_reading - other.log_reading);
        let plane_m = self.slope_m[0] * across.abs() + self.slope_m[1] * down.abs();
        let deviation_m = SLOPE_DEVIATION * plane_m + DISTANCE_DEVIATION * self.distance_m;
        let distances = square((self.distance_m - other.distance_m) / deviation_m.max(f32::MIN_POSITIVE));
        let errors = square((self.log_error - other.log_error) / ERROR_DEVIATION);
        let snows = square((self.snow - other.snow) / SNOW_DEVIATION);
        let sum =
            normals / square(NORMAL_DEVIATION) + readings / square(READING_DEVIATION) + distances + errors + snows;
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
    fn run(&mut self, start: &Level, counts: &[u32]) -> Level {
        let luminance = self.with_smooth_variances(&start.luminance, counts);
        let mut level = Level { luminance, ..start.clone() };
        for (guide, luminance) in self.guides.iter_mut().zip(&level.luminance) {
            guide.log_error = luminance.log_error();
        }
        let mut result = level.clone();
        let mut intervals = vec![[f32::NEG_INFINITY, f32::INFINITY]; level.luminance.len()];
        let is_noisy = |(luminance, guide): (&Luminance, &Guide)| guide.is_filtered && luminance.error() > TARGET;
        let mut needs: Vec<bool> = level.luminance.iter().zip(&self.guides).map(is_noisy).collect();
        for (number, shared) in SHARED_VARIANCE.into_iter().enumerate() {
            if !needs.contains(&true) {
                break;
            }
            let next = self.next(&level, 1 << number, shared);
            let results = result.residual.par_chunks_exact_mut(self.values).zip(&mut result.luminance);
            let results = results.zip(&mut needs).zip(&mut intervals).enumerate();
            results.for_each(|(pixel, (((residual, luminance), need), [low, high]))| {
                if !*need {
                    return;
                }
                // A mean over a larger neighbourhood that contradicts a smaller one has crossed what is no noise
                // (the method of Lepski 1991).
                let mean = next.residual[pixel * self.values + 1] / next.luminance[pixel].reading;
                let error = next.luminance[pixel].error();
                *need = !(mean < *low || mean > *high);
                if *need {
                    let own = start.luminance[pixel].reading;
                    *luminance = blend([&level, &next], pixel, own, residual);
                    [*low, *high] = [low.max(mean - CONFIDENCE * error), high.min(mean + CONFIDENCE * error)];
                    *need = error > TARGET;
                }
            });
            level = next;
        }
        result
    }

    /// The next level, by pixels that are so many apart, with its factor of the variance.
    fn next(&self, level: &Level, step: usize, shared: f32) -> Level {
        let mut residual = vec![0.0; level.residual.len()];
        let pixels = residual.par_chunks_exact_mut(self.values).enumerate();
        let luminance = pixels.map(|(pixel, sums)| {
            let (mut total, mut sum, mut of_independent) = (0.0, Luminance::default(), 0.0);
            self.for_neighbours(pixel, step, |neighbour, weight| {
                total += weight;
                let Luminance { reading, variance } = level.luminance[neighbour];
                sum.reading += weight * reading;
                sum.variance += weight * variance;
                of_independent += weight * weight * variance;
                let values = &level.residual[neighbour * self.values..];
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
            });
            let factor = if total > 0.0 { total.recip() } else { 0.0 };
            sums.iter_mut().for_each(|sum| *sum *= factor);
            let variance = (sum.variance * factor).min(of_independent * factor * factor * shared);
            Luminance { reading: sum.reading * factor, variance }
        });
        let luminance = luminance.collect();
        Level { residual, luminance }
    }

    /// Variances relative to the square of the reading, averaged over the nearest pixels: those of few samples are
    /// noisy themselves. The mean is geometric, so that a noisy edge does not count for the even snow beside it.
    fn with_smooth_variances(&self, luminance: &[Luminance], counts: &[u32]) -> Vec<Luminance> {
        let log_errors: Vec<f32> = luminance.iter().map(|luminance| luminance.log_error()).collect();
        let smooth = |(pixel, own): (usize, &Luminance)| {
            let (mut total, mut sum) = (0.0, 0.0);
            self.for_neighbours(pixel, 1, |neighbour, weight| {
                total += weight;
                sum += weight * log_errors[neighbour];
            });
            let error = (sum / total).exp() * own.reading;
            let doubt = 1.0 + SAMPLES_OF_DOUBT / (counts[pixel].max(1) as f32);
            let variance = doubt * error * error;
            Luminance { variance: if variance.is_finite() { variance } else { own.variance }, ..*own }
        };
        luminance.par_iter().enumerate().map(smooth).collect()
    }

    /// Reduces the residual of outliers, and spreads the difference over the snow around them. Where the noise is
    /// large and a pixel shows snow alone, the residual also has the colour of the rest of the pixel, which `rest_of`
    /// gives. Pixels of the greatest error come first.
    fn spread_outliers(
        &self,
        levels: [&[Luminance]; 2],
        coverage: &[f32],
        rest_of: &dyn Fn(usize) -> Vec<f32>,
        residual: &mut [f32],
    ) {
        let [start, filtered] = levels;
        let values = self.values;
        let light_of = |residual: &[f32], pixel: usize| start[pixel].reading + residual[pixel * values + 1];
        let error = |pixel: usize| Luminance { reading: start[pixel].reading, ..filtered[pixel] }.error();
        let is_doubtful = |pixel: &usize| error(*pixel) > OUTLIER_ERROR || light_of(residual, *pixel) < 0.0;
        let is_filtered = |pixel: &usize| self.guides[*pixel].is_filtered;
        let mut doubtful: Vec<usize> = (0..filtered.len()).filter(is_filtered).filter(is_doubtful).collect();
        doubtful.sort_by(|one, other| error(*other).total_cmp(&error(*one)));
        for pixel in doubtful {
            let (reading, light) = (start[pixel].reading, light_of(residual, pixel));
            // Light of what shows snow.
            let nearest = self.alike_around(pixel, 1).map(|other| light_of(residual, other) / coverage[other]);
            let nearest = nearest.filter(|light| *light > 0.0);
            let [least, most] =
                nearest.fold([f32::INFINITY, 0.0], |[least, most], light| [light.min(least), light.max(most)]);
            let likely = if least <= most {
                light.clamp(least * coverage[pixel], most * coverage[pixel])
            } else {
                light.max(0.0)
            };
            let own = &residual[pixel * values..][..values];
            // What is no residual gives the colour, if all of it is light of snow.
            let rest = rest_of(pixel);
            let excess: Vec<f32> = if rest[1] > 0.0 && coverage[pixel] >= FULL_COVERAGE {
                let factor = (likely - reading) / rest[1];
                own.iter().zip(&rest).map(|(own, rest)| own - factor * rest).collect()
            } else {
                let share = if own[1].abs() > 0.0 { ((likely - reading) / own[1]).clamp(0.0, 1.0) } else { 1.0 };
                own.iter().map(|own| (1.0 - share) * own).collect()
            };
            let size = excess.iter().take(3).fold(0.0, |size: f32, value| size.max(value.abs()));
            if size <= 0.0 {
                continue;
            }
            // Pixels take what is spread in proportion to their own standard errors, so that even snow stays as it is.
            let light = |residual: &[f32], other: usize| light_of(residual, other).max(0.0);
            let room = |residual: &[f32], other: usize| {
                let light = light(residual, other);
                filtered[other].variance.sqrt().max(TARGET * light).min(light)
            };
            let spread = |residual: &[f32], distance: usize| -> f32 {
                self.alike_around(pixel, distance).map(|other| room(residual, other)).sum()
            };
            let suffices = |distance: &usize| size <= MOST_SPREAD * spread(residual, *distance);
            let distance = SPREAD_PIXELS.into_iter().find(suffices).unwrap_or(SPREAD_PIXELS[SPREAD_PIXELS.len() - 1]);
            let total = spread(residual, distance);
            if total > 0.0 {
                for other in self.alike_around(pixel, distance) {
                    // What finds no room stays.
                    let share = (room(residual, other) / total).min(MOST_SPREAD * light(residual, other) / size);
                    for (value, excess) in excess.iter().enumerate() {
                        residual[other * values + value] += share * excess;
                        residual[pixel * values + value] -= share * excess;
                    }
                }
            }
        }
    }

    /// The other pixels in the square around a pixel, with so many on each side, that are mainly snow or mainly not, as
    /// it is.
    fn alike_around(&self, pixel: usize, distance: usize) -> impl Iterator<Item = usize> {
        let (width, height) = (self.width, self.guides.len() / self.width);
        let range = |middle: usize, end: usize| middle.saturating_sub(distance)..(middle + distance + 1).min(end);
        let columns = range(pixel % width, width);
        range(pixel / width, height)
            .flat_map(move |row| columns.clone().map(move |column| row * width + column))
            .filter(move |other| *other != pixel && self.guides[*other].is_filtered)
            .filter(move |other| (self.guides[*other].snow - self.guides[pixel].snow).abs() < 0.5)
    }

    /// Calls `add` for the neighbours of a pixel of snow, so many apart, and itself, with their weights.
    #[inline]
    fn for_neighbours(&self, pixel: usize, step: usize, mut add: impl FnMut(usize, f32)) {
        let guide = &self.guides[pixel];
        if !guide.is_filtered {
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
                if weight > LEAST_WEIGHT {
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
    // The second level holds the samples of the first.
    let error = factors[0] * luminance[0].variance.sqrt() + factors[1] * luminance[1].variance.sqrt();
    Luminance { reading, variance: error * error }
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;
    use snowblue_color::Xyz;
    use snowblue_scene::film::ImageSize;
    use snowblue_scene::film::sensor::SensorSample;
    use snowblue_transport::rng::Stream;

    use super::*;
    use crate::film::pixel_accumulator::PixelAccumulator;
    use crate::film::sample_block::SampleBlock;
    use crate::integrators::FilteredSample;

    const SIZE: ImageSize = ImageSize { width: 24, height: 16 };

    /// An image whose snow has a reading of 2 and a residual that a function of the column and a random number gives.
    /// The normal turns at column 12, and the last four columns show no snow but a radiance of 1.
    fn film(samples: u32, residual: impl Fn(u32, f32) -> f32 + Sync) -> FilmAccumulator {
        film_of(samples, |column, number| [residual(column, number); 3])
    }

    /// The same with a residual of three values.
    fn film_of(samples: u32, residual: impl Fn(u32, f32) -> [f32; 3] + Sync) -> FilmAccumulator {
        let aovs = Aovs { residual: true, ..Aovs::default() };
        let block = SampleBlock { columns: 0..SIZE.width, rows: 0..SIZE.height, samples: 0..samples };
        let mut film = FilmAccumulator::new(SIZE, &block.window(), aovs, &[0.0; 31]);
        let colour = |[x, y, z]: [f32; 3]| SensorSample::from_array([x, y, z, x.abs() + y.abs() + z.abs()]);
        let grey = |value: f32| colour([value; 3]);
        film.par_rows_mut(&block).for_each(|row| {
            let mut pixel = PixelAccumulator::new(aovs);
            for (column, sums) in (0..SIZE.width).zip(row.sums.chunks_exact_mut(aovs.sum_count())) {
                let mut stream = Stream::new(row.number.into(), column.into());
                for _ in 0..samples {
                    let residual = residual(column, narrow(stream.uniform()));
                    let normal = if column < 12 { Vec3A::Z } else { Vec3A::X };
                    let snow = (column < 20).then_some(FilteredSample {
                        residual: colour(residual),
                        reading: grey(2.0),
                        is_snow: true,
                        normal,
                        distance_m: 1.0,
                    });
                    let of_snow = colour(residual.map(|residual| 2.0 + residual));
                    pixel.add_sample(if column < 20 { of_snow } else { grey(1.0) }, snow.as_ref());
                }
                pixel.flush(sums);
                row.counts[column as usize] = samples;
            }
        });
        film
    }

    /// Luminances of a row.
    fn row(film: &FilmAccumulator, row: usize) -> Vec<f64> {
        let width = SIZE.width as usize;
        film.film().pixels()[row * width..][..width].iter().map(|pixel| pixel.y).collect()
    }

    #[test]
    fn noise_is_averaged_over_like_snow_and_not_over_an_edge() {
        let mean = |column: u32| if column < 12 { 0.2 } else { -0.4 };
        let film = film(16, |column, number| mean(column) + 2.0 * (number - 0.5));
        // The standard error of a pixel is 2/√12/√16 = .14.
        for (column, luminance) in (0..SIZE.width).zip(row(&film, 8)) {
            let expected = if column < 20 { f64::from(2.0 + mean(column)) } else { 1.0 };
            let error = (luminance - expected).abs();
            // Five times the error that is aimed at.
            assert!(error < 5.0 * f64::from(TARGET) * 2.0, "column {column}: {luminance} for {expected}");
            assert!(column < 20 || error < 1e-12, "no snow is not changed");
        }
    }

    /// One walk in some hundred finds far less than the others: its pixel would be black.
    #[test]
    fn outliers_are_spread_and_the_light_stays() {
        let film = film(4, |_, number| if number < 0.003 { -60.0 } else { 0.0 });
        let raw: Vec<f64> = film.all_pixels().iter().map(|pixel| pixel.mean_xyz().y).collect();
        let filtered: Vec<f64> = film.film().pixels().iter().map(|pixel| pixel.y).collect();
        let [before, after] = [&raw, &filtered].map(|picture| picture.iter().copied().fold(f64::INFINITY, f64::min));
        assert!(before < 0.0, "{before}");
        // Not more than half of the light for each of a few outliers.
        assert!(after > 0.5, "{after}");
        let [before, after] = [&raw, &filtered].map(|picture| picture.iter().sum::<f64>());
        // Rounding in single precision.
        assert!((after / before - 1.0).abs() < 1e-5, "{after} {before}");
    }

    /// The pixels around have no room for all that an outlier has, and none of them becomes black.
    #[test]
    fn large_outliers_make_no_other_pixel_dark() {
        let film = film(4, |column, number| if column < 4 && number < 0.01 { -2000.0 } else { 0.0 });
        let raw: Vec<f64> = film.all_pixels().iter().map(|pixel| pixel.mean_xyz().y).collect();
        let filtered: Vec<f64> = film.film().pixels().iter().map(|pixel| pixel.y).collect();
        let outliers = raw.iter().filter(|light| **light < 0.0).count();
        assert!(outliers > 0);
        let dark = filtered.iter().zip(&raw).filter(|(after, before)| **after < 0.0 && **before > 0.0).count();
        assert_eq!(dark, 0);
    }

    /// Snow has half the light of its reading. A walk of few finds far less, but more red: its pixel would be magenta.
    #[test]
    fn outliers_have_the_colour_of_the_snow() {
        let film = film_of(4, |_, number| if number < 0.003 { [30.0, -60.0, 20.0] } else { [-1.0; 3] });
        let raw: Vec<Xyz> = film.all_pixels().iter().map(PixelSums::mean_xyz).collect();
        let filtered = film.film();
        let is_snow = |index: &usize| index % (SIZE.width as usize) < 20;
        let most_red = |pixels: &mut dyn Iterator<Item = Xyz>| pixels.map(|xyz| xyz.x / xyz.y).fold(0.0, f64::max);
        let indices = || (0..raw.len()).filter(is_snow);
        assert!(indices().any(|index| raw[index].y < 0.0 && raw[index].x > 5.0));
        assert!(indices().all(|index| filtered.pixels()[index].y > 0.0));
        assert!(most_red(&mut indices().map(|index| filtered.pixels()[index])) < 1.6);
        let [before, after]: [f64; 2] =
            [indices().map(|index| raw[index].x).sum(), indices().map(|index| filtered.pixels()[index].x).sum()];
        // Rounding in single precision.
        assert!((after / before - 1.0).abs() < 1e-5, "{after} {before}");
    }

    #[test]
    fn residuals_without_noise_stay_as_they_are() {
        let film = film(4, |column, _| 0.1 * (column % 3) as f32);
        for (column, luminance) in (0..20u32).zip(row(&film, 3)) {
            assert!((luminance - 2.0 - 0.1 * f64::from(column % 3)).abs() < 1e-6, "{luminance}");
        }
    }

    #[test]
    fn the_filter_states_the_noise_that_is_left() {
        let film = film(16, |_, number| 2.0 * (number - 0.5));
        let noise = Filtered::new(&film).unwrap().into_noise();
        let errors = film.film();
        let pixels = || errors.pixels().iter().zip(&noise).enumerate().filter(|(k, _)| k % 24 < 20);
        let [square, stated] = pixels().fold([0.0, 0.0], |[square, stated], (_, (pixel, noise))| {
            [square + (pixel.y / 2.0 - 1.0).powi(2), stated + f64::from(*noise).powi(2)]
        });
        // Neighbouring pixels share most of their samples: 320 pixels are some 20 independent values, and the borders
        // have fewer neighbours.
        let ratio = (square / stated).sqrt();
        assert!((0.5..1.7).contains(&ratio), "{ratio}");
        assert!(noise.iter().enumerate().all(|(k, noise)| k % 24 < 20 || *noise == 0.0), "constant pixels have none");
    }

    #[test]
    fn one_sample_and_pixels_without_samples_give_finite_colours() {
        let one = film(1, |_, number| number - 0.5);
        assert!(row(&one, 5).iter().all(|luminance| luminance.is_finite() && *luminance > 0.0));
        let block = SampleBlock { columns: 0..SIZE.width, rows: 0..4, samples: 0..1 };
        let mut some = one.clone();
        some.par_rows_mut(&block).for_each(|row| {
            row.sums.fill(0);
            row.counts.fill(0);
        });
        assert!(row(&some, 2).iter().all(|luminance| *luminance == 0.0), "no samples are black");
        assert!(row(&some, 10).iter().all(|luminance| luminance.is_finite()));
    }
}
