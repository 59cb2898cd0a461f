//! The noise filter: it averages the part of the light that a baseline, an estimate with little noise, lacks.
//!
//! A sample of a surface is the sum of a baseline b, which has little noise, and a residual r, the sample less the
//! baseline. At snow the baseline is the radiance that the light field gives at the surface; a sky that is not an image
//! enters it by the irradiance that the light field stores at its cells. At other surfaces the baseline is the
//! reflected light of lamps and of the sun, and the light of open skies and bright snow that the surface would reflect
//! if little hid them. The ratio r/b is smooth where the surface and its illumination are smooth. So the filter
//! replaces the residual of a pixel by a mean over a neighbourhood.
//!
//! **The mean.** Level 0 is the pixel itself. Each further level averages 5 × 5 pixels of the level before, at twice
//! the distance (the à-trous scheme: Dammertz, Sewtz, Hanika & Lensch 2010, *Edge-avoiding à-trous wavelet transform
//! for fast global illumination filtering*, HPG). The residual of a pixel becomes b Σwr/Σwb. A weight w falls with the
//! difference of normals, of ln b and of distances from the camera; snow and other surfaces have no weight for each
//! other.
//!
//! **The width.** A pixel takes the levels in turn, and stops before the first level that changes the light by more
//! than noise: its mean of r/b differs from the pixel itself by more than 3σ, where σ is the standard error, or the
//! changes of r/b from the level before have a mean square over the pixels around that exceeds the variance that the
//! level takes away. The square of the change and the variance estimate the error of a level (Rousselle, Knaus &
//! Zwicker 2011, *Adaptive sampling and reconstruction using greedy error minimization*, ACM TOG 30(6), 159). A single
//! pixel whose mean differs by chance therefore does not stop. A level that makes the light negative is passed over. A
//! pixel whose light is less than its standard error takes the next level in any case, and in the end the mean of the
//! pixels around it. So the neighbourhood follows the noise: as samples are added, σ falls, edges of the residual
//! appear, and the image converges to the unfiltered image.
//!
//! **Outliers.** The variance of a pixel is the greater one of the variance of its own samples and the mean variance
//! of the pixels around it. A single large sample therefore makes no dot: its pixel has a large σ and takes the mean
//! around it, and so do the pixels around it, which receive its light. Few samples n have missed the rarest large ones,
//! so that σ² counts 1 + 16/n times.
//!
//! **The noise that is left** is the standard error of the mean. Where a later level contradicts a mean of several
//! pixels, its variance counts twice: the mean may also be wrong by as much as its standard error.
//!
//! The filter works on the sums of an image, at the end. So a resumed or merged image equals an image that is
//! rendered in one run. A part of an image is filtered by itself. `scripts/bench_filter` measures the errors of the
//! filter.

use rayon::prelude::*;
use snowblue_base::narrow;

use crate::film::accumulator::{FilmAccumulator, PixelSums};
use crate::film::aov::{Aovs, ResidualLayout};
use crate::film::window::{near, square_around};

/// Weights along a row or a column: the refinement mask of the cubic B-spline, with which the means of each level have
/// the weights of a cubic B-spline.
const KERNEL: [f32; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];
/// For each level, ratio of the variance of its means to the variance of means over independent pixels, on a plane of
/// equal pixels. Neighbours share samples, which raises the ratio: without it, wide levels would seem to have a tenth
/// of their noise. The last level has a neighbourhood of ±62 pixels.
const SHARED_VARIANCE: [f32; 5] = [1.0, 2.727, 3.196, 3.307, 3.335];
/// Deviation of the normal at which a weight falls to e^{−½}. A greater one mixes the faces of a block along its
/// edges, a smaller one leaves curved snow noisy.
const NORMAL_DEVIATION: f32 = 0.3;
/// Deviation of ln b at which a weight falls to e^{−½}. A greater one mixes light into shadows, a smaller one leaves
/// noise where light falls off.
const BASELINE_DEVIATION: f32 = 1.0;
/// Deviation of the distance from the camera, beyond its change on a plane through the neighbouring pixels, at which a
/// weight falls to e^{−½}: a fraction of the distance. Without it, light passes between surfaces that lie one behind
/// the other.
const DISTANCE_DEVIATION: f32 = 0.005;
/// Number of standard errors by which the mean of a level may differ from the pixel itself. A smaller one leaves single
/// pixels of even noise as they are, a greater one blurs what only the residual shows, such as seams and contact
/// shadows.
const SAMPLE_CONFIDENCE: f32 = 3.0;
/// Number of samples whose variance counts twice. A smaller one leaves faint dots in pictures of few samples, a greater
/// one blurs them. Repeated samples of a pixel that is done count as samples.
const SAMPLES_OF_DOUBT: f32 = 16.0;
/// Number of levels over which variances are averaged: pixels up to 6 pixels away. Fewer lose light, because distant
/// pixels do not take part in a rare large sample; more blur edges.
const VARIANCE_LEVELS: usize = 2;

/// Number of weights on each side of the middle weight.
const REACH: usize = KERNEL.len() / 2;

/// Changes that the filter makes to an image.
pub(crate) struct Filtered {
    /// Number of values of a pixel: X, Y and Z, and the wavelengths of the spectrum if the image has one.
    values: usize,
    /// Change of the mean of each value of each pixel.
    changes: Vec<f32>,
    /// Standard error of each pixel relative to its luminance, after the filter; not finite where the luminance is 0.
    noise: Vec<f32>,
}

/// Memory that the filter needs, in bytes per pixel of an image: references to the sums, guides, four levels, and the
/// intervals, changes and marks of pixels.
pub fn bytes_per_pixel(aovs: Aovs) -> u64 {
    let bytes = |layout: ResidualLayout| {
        let level = size_of::<Luminance>() + layout.values * size_of::<f32>();
        size_of::<PixelSums>() + size_of::<Guide>() + 4 * level + 8 * size_of::<f32>()
    };
    aovs.residual_layout().map_or(0, bytes) as u64
}

/// Surface that a pixel shows.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Surface {
    None,
    /// At least half of the samples of surfaces hit snow with a light field.
    Snow,
    Other,
}

/// Properties of a pixel that the filter compares.
#[derive(Clone, Copy)]
struct Guide {
    surface: Surface,
    /// Mean normal of the surface.
    normal: [f32; 3],
    /// Logarithm of the mean baseline.
    log_baseline: f32,
    /// Mean distance of the surface in m, and its change from pixel to pixel along the surface, across and down.
    distance_m: f32,
    slope_m: [f32; 2],
}

/// An image of residuals, one level of the filter.
#[derive(Clone)]
struct Level {
    /// Mean values of the residual over the samples of each pixel.
    residual: Vec<f32>,
    luminance: Vec<Luminance>,
}

/// Luminances of a pixel.
#[derive(Clone, Copy, Default)]
struct Luminance {
    baseline: f32,
    /// Variance of the mean luminance of the residual.
    variance: f32,
}

impl Luminance {
    /// Factor that makes residuals relative to the baseline. Without a baseline, residuals are absolute.
    fn unit(self) -> f32 {
        if self.baseline > 0.0 { self.baseline.recip() } else { 1.0 }
    }

    /// Whether the light of a pixel with a residual is less than its standard error.
    fn is_unknown(self, residual: f32) -> bool {
        self.baseline + residual < self.variance.sqrt()
    }

    /// Standard error of the residual, relative to the baseline.
    fn error(self) -> f32 {
        self.unit() * self.variance.sqrt()
    }
}

impl Filtered {
    /// Filters the residuals of an image; none if the image has no sums of residuals.
    pub(crate) fn new(film: &FilmAccumulator) -> Option<Self> {
        Self::but_for(film, &[])
    }

    /// Filters the residuals of an image faster: pixels that are `done` keep their own samples, and their changes and
    /// noise must not be used. No pixel is done if `done` is empty.
    pub(crate) fn but_for(film: &FilmAccumulator, done: &[bool]) -> Option<Self> {
        let layout = film.aovs().residual_layout()?;
        let values = layout.values;
        let width = film.window().size().width as usize;
        let pixels = film.all_pixels();
        let filter = Filter { width, values, guides: guides(&pixels, layout, width) };
        let samples = Level::of(&pixels, layout);
        let Level { residual: mut changes, luminance } = filter.run(&samples, &pixels, done);
        let noise = pixels.par_iter().zip(&luminance).zip(&samples.luminance).zip(changes.par_chunks_exact(values));
        let noise = noise.zip(samples.residual.par_chunks_exact(values));
        let noise = noise.map(|((((pixel, after), before), residual), own)| {
            let rest = narrow(pixel.mean_xyz().y) - own[1];
            let rest_variance = pixel.variance_of_mean(layout.rest_square, rest.into());
            // The residual is a multiple of the baseline, which is part of the rest.
            let scale = if before.baseline > 0.0 && rest > 0.0 { 1.0 + residual[1] / rest } else { 1.0 };
            (rest_variance * scale * scale + after.variance).sqrt() / (rest + residual[1]).max(0.0)
        });
        let noise = noise.collect();
        changes.par_iter_mut().zip(&samples.residual).for_each(|(change, own)| *change -= own);
        Some(Self { values, changes, noise })
    }

    /// Changes of X, Y and Z, and then of the wavelengths, of a pixel of the window, row by row; empty without a
    /// filter.
    pub(crate) fn changes(filtered: Option<&Self>, pixel: usize) -> &[f32] {
        filtered.map_or(&[], |filtered| &filtered.changes[pixel * filtered.values..][..filtered.values])
    }

    /// Standard error of each pixel relative to its luminance; not finite where the luminance is 0.
    pub(crate) fn noise(&self) -> &[f32] {
        &self.noise
    }
}

impl Level {
    /// The means and variances of the samples of each pixel.
    fn of(pixels: &[PixelSums], layout: ResidualLayout) -> Self {
        let mut residual = vec![0.0; pixels.len() * layout.values];
        residual.par_chunks_exact_mut(layout.values).zip(pixels).for_each(|(residual, pixel)| {
            residual.iter_mut().enumerate().for_each(|(k, value)| *value = pixel.mean(layout.residual + k));
        });
        let luminance = |pixel: &PixelSums| Luminance {
            baseline: pixel.mean(layout.baseline).max(0.0),
            // A finite variance that exceeds all others stands for unknown ones.
            variance: pixel
                .variance_of_mean(layout.residual_square, pixel.exact_mean(layout.residual + 1))
                .min(f32::MAX.sqrt()),
        };
        Self { residual, luminance: pixels.par_iter().map(luminance).collect() }
    }
}

/// The properties of each pixel that the filter compares.
fn guides(pixels: &[PixelSums], layout: ResidualLayout, width: usize) -> Vec<Guide> {
    let of_surface = |pixel: &PixelSums, offset: usize| pixel.quotient(offset, layout.count);
    let shows_surface = |pixel: &PixelSums| pixel.at(layout.count) > 0;
    let distances: Vec<Option<f32>> =
        pixels.par_iter().map(|pixel| shows_surface(pixel).then(|| of_surface(pixel, layout.distance))).collect();
    // The smaller of the changes to the neighbours on both sides, which lies on the surface and not across its edge.
    let slope = |index: usize, step: usize, has_before: bool, has_after: bool| {
        let before = has_before.then(|| distances[index - step]).flatten();
        let after = has_after.then(|| distances.get(index + step).copied().flatten()).flatten();
        let change = |other: f32| (other - distances[index].unwrap_or(other)).abs();
        before.into_iter().chain(after).map(change).reduce(f32::min).unwrap_or(0.0)
    };
    let guide = |(index, pixel): (usize, &PixelSums)| {
        let (column, row) = (index % width, index / width);
        let surface = match (shows_surface(pixel), of_surface(pixel, layout.snow) >= 0.5) {
            (false, _) => Surface::None,
            (true, true) => Surface::Snow,
            (true, false) => Surface::Other,
        };
        Guide {
            surface,
            normal: [0, 1, 2].map(|k| of_surface(pixel, layout.normal + k)),
            log_baseline: of_surface(pixel, layout.baseline).max(f32::MIN_POSITIVE).ln(),
            distance_m: distances[index].unwrap_or(0.0),
            slope_m: [slope(index, 1, column > 0, column + 1 < width), slope(index, width, row > 0, true)],
        }
    };
    pixels.par_iter().enumerate().map(guide).collect()
}

impl Guide {
    /// Weight that the residual of another pixel, `across` and `down` pixels away, has for this pixel.
    #[inline]
    fn weight(&self, other: &Self, across: f32, down: f32) -> f32 {
        if other.surface != self.surface {
            return 0.0;
        }
        let square = |x: f32| x * x;
        let normals: f32 = self.normal.iter().zip(other.normal).map(|(one, other)| square(one - other)).sum();
        let baselines = square(self.log_baseline - other.log_baseline);
        let plane_m = self.slope_m[0] * across + self.slope_m[1] * down;
        let deviation_m = plane_m + DISTANCE_DEVIATION * self.distance_m;
        let distances = square((self.distance_m - other.distance_m) / deviation_m.max(f32::MIN_POSITIVE));
        falloff(normals / square(NORMAL_DEVIATION) + baselines / square(BASELINE_DEVIATION) + distances)
    }
}

/// Weight for the sum x of the squares of relative deviations: e^{−x/2} to a few percent of 1, and 0 for x ≥ 16. Much
/// faster than an exponential.
#[inline]
fn falloff(sum: f32) -> f32 {
    let root = (1.0 - sum * (1.0 / 16.0)).max(0.0);
    let square = root * root;
    let fourth = square * square;
    fourth * fourth
}

/// The filter at work.
struct Filter {
    width: usize,
    values: usize,
    guides: Vec<Guide>,
}

impl Filter {
    /// The residual of each pixel, with its variance, after as many levels as agree.
    fn run(&self, samples: &Level, pixels: &[PixelSums], done: &[bool]) -> Level {
        let mut level = Level { luminance: self.with_variances_around(samples), ..samples.clone() };
        let mut result = level.clone();
        let mut needs: Vec<bool> = self.guides.iter().map(|guide| guide.surface != Surface::None).collect();
        needs.iter_mut().zip(done).for_each(|(need, done)| *need &= !done);
        let doubt = |pixel: usize| 1.0 + SAMPLES_OF_DOUBT / pixels[pixel].count().max(1) as f32;
        // Means of r/b that do not contradict the pixel itself.
        let interval = |(pixel, luminance): (usize, &Luminance)| {
            let mean = luminance.unit() * level.residual[pixel * self.values + 1];
            let reach = SAMPLE_CONFIDENCE * doubt(pixel).sqrt() * luminance.error();
            [mean - reach, mean + reach]
        };
        let intervals: Vec<[f32; 2]> = level.luminance.par_iter().enumerate().map(interval).collect();
        for (number, shared) in SHARED_VARIANCE.into_iter().enumerate() {
            if !needs.contains(&true) {
                break;
            }
            // Number of pixels that the changes and the later levels reach.
            let reach = (number..SHARED_VARIANCE.len()).map(|level| REACH << level).sum();
            let is_read = near(&needs, reach, self.width);
            let wider = self.next(&level, 1 << number, shared, &is_read);
            let changes = match number {
                0 => vec![[0.0; 2]; needs.len()],
                _ => self.changes_around(&level, &wider, 1 << number, &is_read),
            };
            level = wider;
            let results = result.residual.par_chunks_exact_mut(self.values).zip(&mut result.luminance);
            let results = results.zip(&mut needs).zip(&intervals).zip(changes).enumerate();
            results.for_each(|(pixel, ((((residual, luminance), need), &[low, high]), [change, noise]))| {
                if !*need {
                    return;
                }
                let of_level = level.luminance[pixel];
                let means = &level.residual[pixel * self.values..][..self.values];
                let mean = of_level.unit() * means[1];
                let own = samples.luminance[pixel];
                let scale =
                    if own.baseline > 0.0 && of_level.baseline > 0.0 { own.baseline * of_level.unit() } else { 1.0 };
                // A level that makes the light negative is passed over.
                if own.baseline + scale * means[1] < 0.0 {
                    return;
                }
                let is_noise = change <= doubt(pixel) * noise;
                *need = luminance.is_unknown(residual[1]) || (low <= mean && mean <= high && is_noise);
                if *need {
                    residual.iter_mut().zip(means).for_each(|(residual, mean)| *residual = scale * mean);
                    luminance.variance = scale * scale * of_level.variance;
                } else if number > 0 {
                    luminance.variance *= 2.0;
                }
            });
        }
        self.mend_unknown(samples, done, &mut result);
        result
    }

    /// For each pixel, the mean square of the changes of r/b from a level to a wider level, and the mean variance that
    /// the wider level takes away, over pixels around that are `step` pixels apart.
    fn changes_around(&self, finer: &Level, wider: &Level, step: usize, is_read: &[bool]) -> Vec<[f32; 2]> {
        let change = |pixel: usize| {
            let [before, after] = [finer, wider].map(|level| {
                let luminance = level.luminance[pixel];
                (luminance.unit() * level.residual[pixel * self.values + 1], luminance.error().powi(2))
            });
            if is_read[pixel] { [(after.0 - before.0).powi(2), (before.1 - after.1).max(0.0)] } else { [0.0; 2] }
        };
        let changes: Vec<_> = (0..is_read.len()).into_par_iter().map(change).collect();
        self.means_around(&changes, step)
    }

    /// Gives the pixels that are still unknown, as at edges without like pixels, the mean r/b of the eight pixels
    /// around them that show like surfaces.
    fn mend_unknown(&self, samples: &Level, done: &[bool], result: &mut Level) {
        let size = [self.width, self.guides.len() / self.width];
        let residuals = result.residual.par_chunks_exact_mut(self.values).zip(&result.luminance).enumerate();
        residuals.for_each(|(pixel, (residual, luminance))| {
            let surface = self.guides[pixel].surface;
            if surface == Surface::None || done.get(pixel) == Some(&true) || !luminance.is_unknown(residual[1]) {
                return;
            }
            let own = &samples.residual[pixel * self.values..][..self.values];
            let of_samples = samples.luminance[pixel];
            if of_samples.variance < luminance.variance && !of_samples.is_unknown(own[1]) {
                residual.copy_from_slice(own);
                return;
            }
            let (mut baseline, mut sums) = (0.0, vec![0.0; self.values]);
            for other in square_around(pixel, 1, size).filter(|other| *other != pixel) {
                if self.guides[other].surface == surface {
                    baseline += samples.luminance[other].baseline;
                    let values = &samples.residual[other * self.values..];
                    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
                }
            }
            if baseline > 0.0 && baseline + sums[1] > 0.0 {
                let scale = luminance.baseline / baseline;
                residual.iter_mut().zip(&sums).for_each(|(residual, sum)| *residual = scale * sum);
            }
        });
    }

    /// The luminances, in which the variance of a pixel is at least the mean variance of the pixels around it, relative
    /// to the baseline.
    fn with_variances_around(&self, samples: &Level) -> Vec<Luminance> {
        let mut means: Vec<_> = samples.luminance.iter().map(|luminance| [luminance.error().powi(2)]).collect();
        for level in 0..VARIANCE_LEVELS {
            means = self.means_around(&means, 1 << level);
        }
        let greater = |(own, [mean]): (&Luminance, &[f32; 1])| Luminance {
            variance: own.variance.max(mean / own.unit().powi(2)),
            ..*own
        };
        samples.luminance.iter().zip(&means).map(greater).collect()
    }

    /// The means of values over pixels around each pixel, `step` pixels apart.
    fn means_around<const N: usize>(&self, values: &[[f32; N]], step: usize) -> Vec<[f32; N]> {
        let mean = |pixel: usize| {
            let (mut total, mut sums) = (0.0, [0.0; N]);
            self.for_neighbours(pixel, step, |neighbour, weight| {
                total += weight;
                sums.iter_mut().zip(values[neighbour]).for_each(|(sum, value)| *sum += weight * value);
            });
            if total > 0.0 { sums.map(|sum| sum / total) } else { sums }
        };
        (0..values.len()).into_par_iter().map(mean).collect()
    }

    /// The next level, from pixels that are `step` pixels apart, with the factor `shared` of the variance. Only
    /// pixels that `is_read` marks have values.
    fn next(&self, level: &Level, step: usize, shared: f32, is_read: &[bool]) -> Level {
        let mut residual = vec![0.0; level.residual.len()];
        let pixels = residual.par_chunks_exact_mut(self.values).enumerate();
        let luminance = pixels.map(|(pixel, sums)| {
            let (mut total, mut sum, mut variance_if_independent) = (0.0, Luminance::default(), 0.0);
            if !is_read[pixel] {
                return sum;
            }
            self.for_neighbours(pixel, step, |neighbour, weight| {
                total += weight;
                let Luminance { baseline, variance } = level.luminance[neighbour];
                sum.baseline += weight * baseline;
                sum.variance += weight * variance;
                variance_if_independent += weight * weight * variance;
                let values = &level.residual[neighbour * self.values..];
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
            });
            let factor = if total > 0.0 { total.recip() } else { 0.0 };
            sums.iter_mut().for_each(|sum| *sum *= factor);
            // The variance of a mean is at most the mean of the variances.
            let variance = (sum.variance * factor).min(variance_if_independent * factor * factor * shared);
            Luminance { baseline: sum.baseline * factor, variance }
        });
        let luminance = luminance.collect();
        Level { residual, luminance }
    }

    /// Calls `add` with the weights of a pixel and of its neighbours, `step` pixels apart, if the pixel shows a
    /// surface.
    #[inline]
    fn for_neighbours(&self, pixel: usize, step: usize, mut add: impl FnMut(usize, f32)) {
        let guide = &self.guides[pixel];
        if guide.surface == Surface::None {
            return;
        }
        let (column, row, height) = (pixel % self.width, pixel / self.width, self.guides.len() / self.width);
        for (down, of_row) in KERNEL.into_iter().enumerate() {
            let y = (row + down * step).wrapping_sub(REACH * step);
            if y >= height {
                continue;
            }
            for (across, of_column) in KERNEL.into_iter().enumerate() {
                let x = (column + across * step).wrapping_sub(REACH * step);
                if x >= self.width {
                    continue;
                }
                let neighbour = y * self.width + x;
                let [dx, dy] = [across, down].map(|tap| (tap.abs_diff(REACH) * step) as f32);
                let weight = guide.weight(&self.guides[neighbour], dx, dy);
                if weight > 0.0 {
                    add(neighbour, weight * of_row * of_column);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
