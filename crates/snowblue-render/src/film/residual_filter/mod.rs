//! The noise filter: light is smooth where a baseline, an estimate with little noise, contains all edges.
//!
//! A sample of a surface is the sum of a baseline, which has little noise, and a residual, the sample less the
//! baseline. At snow the baseline is the radiance that the light field gives at the surface. A sky that is not an
//! image enters it by the irradiance that the light field stores at its cells. At other surfaces the baseline is the
//! reflected light of lamps and of the sun, and the light of open skies and bright snow that the surface would
//! reflect if little hid them. The residual is smooth where the surface and its illumination are smooth. So the
//! filter replaces the residual of a pixel by a mean over a neighbourhood, relative to the baseline and over pixels
//! of similar normal, distance and baseline (a joint bilateral filter by the à-trous scheme: Dammertz, Sewtz, Hanika
//! & Lensch 2010, *Edge-avoiding à-trous wavelet transform for fast global illumination filtering*, HPG).
//!
//! Pixels of similar noise also count more: walks near edges are noisy, and their residual differs from the residual
//! of even snow. Each level doubles the neighbourhood. Each pixel takes the first level at which the standard error
//! of its residual, estimated from the variance of the samples, is below 0.7 % of its light. So the neighbourhood
//! shrinks as samples are added, and the image converges to the unfiltered image. The variance of a pixel is a
//! geometric mean over the nearest pixels, because the variance of few samples is itself noisy. Where pixels are
//! averaged, the greater of this variance and the variance of each pixel's own samples counts, so that a single large
//! sample does not remain as a dot.
//!
//! The residual is not smooth everywhere: the baseline of other surfaces ignores occluders of skies and snow, and the
//! baseline of snow has large errors near edges. A pixel stops before a neighbourhood whose mean contradicts the mean
//! of a smaller neighbourhood (the method of Lepski 1991, *On a problem of adaptive estimation in Gaussian white
//! noise*, Theory of Probability and its Applications 35, 454). The smallest neighbourhood is taken without a test.
//! Snow is tested only where its noise is known: a single walk can give so large a sample that a mean of few samples
//! is no evidence.
//!
//! Some pixels have too few similar neighbours, as at silhouettes and the edges of shadows. Among few samples a
//! single walk then makes a white dot, or a black dot because differences of walks can be negative. Where the noise
//! is large, or a single pixel is noisy, the filter therefore changes the residual so that the pixel is no brighter
//! and no darker than its neighbours. The excess is spread over the pixels around it, so that the total light of the
//! image does not change.
//!
//! The filter works on the sums of an image, at the end. So a resumed or merged image equals an image that is
//! rendered in one run. A part of an image is filtered by itself.

use rayon::prelude::*;
use snowblue_base::narrow;

use crate::film::accumulator::{FilmAccumulator, PixelSums};
use crate::film::aov::{Aovs, ResidualLayout};
use crate::film::window::{near, square_around};

/// Target of the standard error of the residual, relative to the light.
const TARGET: f32 = 0.007;
/// For each level, ratio of the variance of its means to the variance of means over independent pixels, on a plane of
/// equal pixels. Neighbours share samples, which raises the ratio. The last level has a neighbourhood of ±62 pixels.
const SHARED_VARIANCE: [f32; 5] = [1.0, 2.727, 3.196, 3.307, 3.335];
/// Weights along a row or a column.
const KERNEL: [f32; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];
/// Number of weights on each side of the middle weight.
const REACH: usize = KERNEL.len() / 2;
/// Deviations at which a weight falls by e^{−½}: of the normal, and of the logarithm of the baseline.
const NORMAL_DEVIATION: f32 = 0.35;
const BASELINE_DEVIATION: f32 = 0.5;
/// Deviation of the fraction of snow at which a weight falls by e^{−½}: the residual of snow differs in kind from the
/// residual of other surfaces.
const SNOW_DEVIATION: f32 = 0.2;
/// Fraction of snow from which on a pixel counts as snow.
const MAINLY: f32 = 0.5;
/// Deviation of the logarithm of the noise, which grows near edges, at which a weight falls by e^{−½}.
const ERROR_DEVIATION: f32 = 1.0;
/// Deviation of the distance at which a weight falls by e^{−½}: a multiple of the change of distance on a plane
/// through the neighbouring pixels, plus a fraction of the distance.
const SLOPE_DEVIATION: f32 = 2.0;
const DISTANCE_DEVIATION: f32 = 0.002;
/// Number of standard errors by which the mean over a neighbourhood may differ from the mean over a smaller
/// neighbourhood, for snow and for other surfaces.
const SNOW_CONFIDENCE: f32 = 3.0;
const CONFIDENCE: f32 = 2.0;
/// Difference of two such means of snow, relative to the baseline, that is no contradiction. Without this tolerance,
/// rare samples of even snow in the sun leave faint dots.
const SLACK: f32 = 0.1;
/// Standard error of the nearest pixels, relative to the baseline and increased for few samples, below which the
/// means of snow are compared.
const KNOWN_ERROR: f32 = 0.5;
/// Smallest relative error of a residual that is distinguished from 0.
const MIN_ERROR: f32 = 1e-4;
/// The geometric mean of variances of few samples is less than their arithmetic mean, by a factor of about 1 +
/// `SAMPLES_OF_DOUBT` / number of samples, found by trial on walks.
const SAMPLES_OF_DOUBT: f32 = 16.0;
/// Variance of a pixel whose sums are saturated, which counts as unknown.
const MAX_VARIANCE: f32 = 1e20;
/// Greatest factor by which a residual grows with the baseline.
const MAX_SCALE: f32 = 4.0;
/// Standard error relative to the light above which a pixel that is brighter or darker than all eight pixels around
/// it is an outlier.
const OUTLIER_ERROR: f32 = 0.25;
/// Standard error of the pixel's own samples, relative to the light, above which such a pixel is an outlier where the
/// pixels around it have so little noise that none is filtered.
const LONE_OUTLIER_ERROR: f32 = 5.0 * TARGET;
/// The excess of an outlier is spread over so many pixels around it that it changes them by this fraction of their
/// standard error, which counts as at least [`TARGET`]. The numbers of pixels on each side are tried in turn until
/// they suffice.
const MAX_SPREAD: f32 = 0.5;
const SPREAD_PIXELS: [usize; 5] = [1, 2, 4, 8, 16];
/// Fraction of a pixel's samples that hit snow with a light field, from which on only this snow determines the
/// colour.
const FULL_COVERAGE: f32 = 0.999;
/// Baselines below this fraction of the greatest baseline count as equally dark.
const DARK: f32 = 1e-6;

/// Changes that the filter makes to an image.
pub(crate) struct Filtered {
    /// Number of values of a pixel: X, Y and Z, and the wavelengths of the spectrum if the image has one.
    values: usize,
    /// Change of the mean of each value of each pixel.
    changes: Vec<f32>,
    /// Standard error of each pixel relative to its luminance, after the filter; not finite where the luminance is 0.
    noise: Vec<f32>,
}

/// Memory that the filter needs, in bytes per pixel of an image: guides, and four levels.
pub fn bytes_per_pixel(aovs: Aovs) -> u64 {
    let bytes = |layout: ResidualLayout| {
        let level = size_of::<Luminance>() + layout.values * size_of::<f32>();
        size_of::<PixelSums>() + size_of::<Guide>() + 4 * level + 4 * size_of::<f32>()
    };
    aovs.residual_layout().map_or(0, bytes) as u64
}

/// Properties of a pixel that the filter compares.
#[derive(Clone, Copy)]
struct Guide {
    /// Mean normal of the surface; zero for a pixel without one.
    normal: [f32; 3],
    /// Logarithm of the mean baseline.
    log_baseline: f32,
    /// Mean distance of the surface in m, and its change from pixel to pixel along the surface, across and down.
    distance_m: f32,
    slope_m: [f32; 2],
    /// Logarithm of the relative standard error of the residual.
    log_error: f32,
    /// Fraction of the samples of surfaces that hit snow with a light field.
    snow: f32,
    /// Whether the pixel shows a surface.
    is_filtered: bool,
}

/// An image of residuals, one level of the filter.
#[derive(Clone)]
struct Level {
    /// Mean values of the residual over the samples of each pixel.
    residual: Vec<f32>,
    /// Baseline and variance of the mean luminance of the residual, for each pixel.
    luminance: Vec<Luminance>,
}

#[derive(Clone, Copy, Default)]
struct Luminance {
    baseline: f32,
    /// Luminance that errors are relative to: at snow the baseline, at other surfaces the light, which can be far
    /// below the baseline.
    scale: f32,
    /// Variance in which single large samples nearby count little.
    variance: f32,
    /// Variance estimated from the samples of each pixel.
    variance_of_samples: f32,
}

impl Luminance {
    /// The relative standard error of the residual.
    fn error(self) -> f32 {
        self.relative(self.variance)
    }

    /// The logarithm of the relative standard error, limited to the range between [`MIN_ERROR`] and its reciprocal.
    fn log_error(self) -> f32 {
        self.error().clamp(MIN_ERROR, MIN_ERROR.recip()).ln()
    }

    /// The relative standard error, in which single large samples nearby count fully.
    fn greater_error(self) -> f32 {
        self.relative(self.greater_variance())
    }

    fn relative(self, variance: f32) -> f32 {
        variance.sqrt() / self.scale.max(f32::MIN_POSITIVE)
    }

    /// The variance in which single large samples count fully.
    fn greater_variance(self) -> f32 {
        self.variance.max(self.variance_of_samples)
    }
}

impl Filtered {
    /// Filters the residuals of an image; none if the image has no sums of residuals.
    pub(crate) fn new(film: &FilmAccumulator) -> Option<Self> {
        Self::but_for(film, &[])
    }

    /// Filters the residuals of an image faster: the changes and the noise of pixels that are `done` are not needed.
    /// No pixel is done if `done` is empty.
    pub(crate) fn but_for(film: &FilmAccumulator, done: &[bool]) -> Option<Self> {
        let layout = film.aovs().residual_layout()?;
        let width = film.window().size().width as usize;
        let pixels = film.all_pixels();
        let counts: Vec<u32> = pixels.iter().map(PixelSums::count).collect();
        let values = layout.values;
        let mut filter = Filter { width, values, guides: guides(&pixels, layout, width) };
        let start = Level::of(&pixels, layout);
        let Level { residual: mut changes, mut luminance } = filter.run(&start, &counts, done);
        let coverage: Vec<f32> = pixels.par_iter().map(|pixel| pixel.mean(layout.count)).collect();
        let rest_of = |pixel: usize| {
            let residual = &start.residual[pixel * values..][..values];
            residual.iter().enumerate().map(|(k, residual)| pixels[pixel].mean(k) - residual).collect()
        };
        filter.spread_outliers([&start.luminance, &luminance], (&coverage, done), &rest_of, &mut changes);
        // A huge outlier can make the light of other pixels negative, if no pixel around can take its excess. A pixel
        // whose own light is not negative then keeps its own residual.
        let own_light = |pixel: usize| start.luminance[pixel].baseline + start.residual[pixel * values + 1];
        let results = changes.par_chunks_exact_mut(values).zip(&mut luminance).enumerate();
        results.for_each(|(pixel, (residual, luminance))| {
            if start.luminance[pixel].baseline + residual[1] < 0.0 && own_light(pixel) >= 0.0 {
                residual.copy_from_slice(&start.residual[pixel * values..][..values]);
                *luminance = start.luminance[pixel];
            }
        });
        let noise = pixels.par_iter().zip(&luminance).zip(&start.luminance).zip(changes.par_chunks_exact(values));
        let noise = noise.zip(start.residual.par_chunks_exact(values));
        let noise = noise.map(|((((pixel, after), before), residual), own)| {
            let rest = narrow(pixel.mean_xyz().y) - own[1];
            let rest_variance = pixel.variance_of_mean(layout.rest_square, rest.into());
            // The residual is a multiple of the baseline, which is part of the rest.
            let scale = if before.baseline > 0.0 && rest > 0.0 { 1.0 + residual[1] / rest } else { 1.0 };
            (rest_variance * scale * scale + after.variance).sqrt() / (rest + residual[1]).max(0.0)
        });
        let noise = noise.collect();
        changes.par_iter_mut().zip(&start.residual).for_each(|(change, own)| *change -= own);
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
    fn of(pixels: &[PixelSums], layout: ResidualLayout) -> Self {
        let mut residual = vec![0.0; pixels.len() * layout.values];
        residual.par_chunks_exact_mut(layout.values).zip(pixels).for_each(|(residual, pixel)| {
            residual.iter_mut().enumerate().for_each(|(k, value)| *value = pixel.mean(layout.residual + k));
        });
        let luminance = |pixel: &PixelSums| {
            let (baseline, residual) = (pixel.mean(layout.baseline).max(0.0), pixel.exact_mean(layout.residual + 1));
            let variance = pixel.variance_of_mean(layout.residual_square, residual).min(MAX_VARIANCE);
            Luminance { baseline, scale: baseline, variance, variance_of_samples: variance }
        };
        Self { residual, luminance: pixels.par_iter().map(luminance).collect() }
    }
}

/// The properties of each pixel that the filter compares.
fn guides(pixels: &[PixelSums], layout: ResidualLayout, width: usize) -> Vec<Guide> {
    let of_surface = |pixel: &PixelSums, offset: usize| pixel.quotient(offset, layout.count);
    let is_filtered = |pixel: &PixelSums| pixel.at(layout.count) > 0;
    let baselines: Vec<f32> = pixels.par_iter().map(|pixel| of_surface(pixel, layout.baseline)).collect();
    let dark = DARK * baselines.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
    let distances: Vec<Option<f32>> =
        pixels.par_iter().map(|pixel| is_filtered(pixel).then(|| of_surface(pixel, layout.distance))).collect();
    // The smaller of the changes to the neighbours on both sides, which lies on the surface and not across its edge.
    let slope = |index: usize, step: usize, has_before: bool, has_after: bool| {
        let before = has_before.then(|| distances[index - step]).flatten();
        let after = has_after.then(|| distances.get(index + step).copied().flatten()).flatten();
        let change = |other: f32| (other - distances[index].unwrap_or(other)).abs();
        before.into_iter().chain(after).map(change).fold(f32::INFINITY, f32::min)
    };
    let guide = |(index, (pixel, baseline)): (usize, (&PixelSums, &f32))| {
        let (column, row) = (index % width, index / width);
        let slopes = [slope(index, 1, column > 0, column + 1 < width), slope(index, width, row > 0, true)];
        Guide {
            normal: [0, 1, 2].map(|k| of_surface(pixel, layout.normal + k)),
            log_baseline: baseline.max(dark).ln(),
            distance_m: distances[index].unwrap_or(0.0),
            slope_m: slopes.map(|slope| if slope.is_finite() { slope } else { 0.0 }),
            log_error: 0.0,
            snow: of_surface(pixel, layout.snow),
            is_filtered: is_filtered(pixel),
        }
    };
    pixels.par_iter().zip(&baselines).enumerate().map(guide).collect()
}

impl Guide {
    fn is_snow(&self) -> bool {
        self.snow >= MAINLY
    }

    /// Weight that the residual of another pixel, `across` and `down` pixels away, has for this pixel.
    #[inline]
    fn weight(&self, other: &Self, across: f32, down: f32) -> f32 {
        if !other.is_filtered {
            return 0.0;
        }
        let square = |x: f32| x * x;
        let normals: f32 = self.normal.iter().zip(other.normal).map(|(one, other)| square(one - other)).sum();
        let baselines = square(self.log_baseline - other.log_baseline);
        let plane_m = self.slope_m[0] * across.abs() + self.slope_m[1] * down.abs();
        let deviation_m = SLOPE_DEVIATION * plane_m + DISTANCE_DEVIATION * self.distance_m;
        let distances = square((self.distance_m - other.distance_m) / deviation_m.max(f32::MIN_POSITIVE));
        let errors = square((self.log_error - other.log_error) / ERROR_DEVIATION);
        let snows = square((self.snow - other.snow) / SNOW_DEVIATION);
        let sum =
            normals / square(NORMAL_DEVIATION) + baselines / square(BASELINE_DEVIATION) + distances + errors + snows;
        falloff(sum)
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
    /// The residual of each pixel, with its variance, after as many levels as it needs.
    fn run(&mut self, start: &Level, counts: &[u32], done: &[bool]) -> Level {
        let luminance = self.with_smooth_variances(&self.with_scales(start), counts);
        let mut level = Level { luminance, ..start.clone() };
        for (guide, luminance) in self.guides.iter_mut().zip(&level.luminance) {
            guide.log_error = luminance.log_error();
        }
        let mut result = level.clone();
        let mut intervals = vec![[f32::NEG_INFINITY, f32::INFINITY]; level.luminance.len()];
        let is_noisy = |(luminance, guide): (&Luminance, &Guide)| guide.is_filtered && luminance.error() > TARGET;
        let mut needs: Vec<bool> = level.luminance.iter().zip(&self.guides).map(is_noisy).collect();
        needs.iter_mut().zip(done).for_each(|(need, done)| *need &= !done);
        let is_tested: Vec<bool> =
            needs.par_iter().enumerate().map(|(pixel, need)| *need && self.is_tested(start, counts, pixel)).collect();
        for (number, shared) in SHARED_VARIANCE.into_iter().enumerate() {
            if !needs.contains(&true) {
                break;
            }
            // Number of pixels that the later levels reach.
            let reach = (number + 1..SHARED_VARIANCE.len()).map(|later| REACH << later).sum();
            let is_read = near(&needs, reach, self.width);
            let next = self.next(&level, 1 << number, shared, &is_read);
            let results = result.residual.par_chunks_exact_mut(self.values).zip(&mut result.luminance);
            let results = results.zip(&mut needs).zip(&mut intervals).enumerate();
            results.for_each(|(pixel, (((residual, luminance), need), [low, high]))| {
                if !*need {
                    return;
                }
                let of_level = next.luminance[pixel];
                if is_tested[pixel] {
                    let unit = if of_level.baseline > 0.0 { of_level.baseline.recip() } else { 1.0 };
                    let mean = unit * next.residual[pixel * self.values + 1];
                    if mean < *low || mean > *high {
                        *need = false;
                        return;
                    }
                    let is_snow = self.guides[pixel].is_snow();
                    let (confidence, slack) = if is_snow { (SNOW_CONFIDENCE, SLACK) } else { (CONFIDENCE, 0.0) };
                    let reach = confidence * unit * of_level.greater_variance().sqrt() + slack;
                    [*low, *high] = [low.max(mean - reach), high.min(mean + reach)];
                }
                *luminance = blend([&level, &next], pixel, start.luminance[pixel].baseline, residual);
                *need = of_level.greater_error() > TARGET;
            });
            level = next;
        }
        result
    }

    /// Whether the means over neighbourhoods of a pixel are compared: at snow, only where the noise around the pixel
    /// is known to be small. The variances are averaged arithmetically, because a geometric mean hides one large
    /// sample.
    fn is_tested(&self, start: &Level, counts: &[u32], pixel: usize) -> bool {
        let variance = |other: usize| start.luminance[other].error().powi(2);
        !self.guides[pixel].is_snow()
            || self.mean_nearby(pixel, variance).is_some_and(|mean| (doubt(counts[pixel]) * mean).sqrt() < KNOWN_ERROR)
    }

    /// The next level, from pixels that are `step` pixels apart, with the factor `shared` of the variance. Only
    /// pixels that `is_read` marks have values.
    fn next(&self, level: &Level, step: usize, shared: f32, is_read: &[bool]) -> Level {
        let mut residual = vec![0.0; level.residual.len()];
        let pixels = residual.par_chunks_exact_mut(self.values).enumerate();
        let luminance = pixels.map(|(pixel, sums)| {
            let (mut total, mut sum, mut of_independent) = (0.0, Luminance::default(), [0.0; 2]);
            if !is_read[pixel] {
                return sum;
            }
            self.for_neighbours(pixel, step, |neighbour, weight| {
                total += weight;
                let Luminance { baseline, scale, variance, variance_of_samples } = level.luminance[neighbour];
                sum.baseline += weight * baseline;
                sum.scale += weight * scale;
                sum.variance += weight * variance;
                sum.variance_of_samples += weight * variance_of_samples;
                of_independent[0] += weight * weight * variance;
                of_independent[1] += weight * weight * variance_of_samples;
                let values = &level.residual[neighbour * self.values..];
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
            });
            let factor = if total > 0.0 { total.recip() } else { 0.0 };
            sums.iter_mut().for_each(|sum| *sum *= factor);
            let [variance, variance_of_samples] = [sum.variance, sum.variance_of_samples];
            let of_mean =
                |variance: f32, of_independent: f32| (variance * factor).min(of_independent * factor * factor * shared);
            Luminance {
                baseline: sum.baseline * factor,
                scale: sum.scale * factor,
                variance: of_mean(variance, of_independent[0]),
                variance_of_samples: of_mean(variance_of_samples, of_independent[1]),
            }
        });
        let luminance = luminance.collect();
        Level { residual, luminance }
    }

    /// The luminances with their scales: at surfaces other than snow, the mean light of the nearest pixels.
    fn with_scales(&self, start: &Level) -> Vec<Luminance> {
        let scaled = |(pixel, own): (usize, &Luminance)| {
            if self.guides[pixel].is_snow() {
                return *own;
            }
            let light = |pixel: usize| start.luminance[pixel].baseline + start.residual[pixel * self.values + 1];
            Luminance { scale: self.mean_nearby(pixel, light).map_or(own.scale, |light| light.max(0.0)), ..*own }
        };
        start.luminance.par_iter().enumerate().map(scaled).collect()
    }

    /// The luminances with relative variances averaged over the nearest pixels, because variances of few samples are
    /// noisy themselves. The mean is geometric, so that a noisy edge does not count for the even surface beside it.
    fn with_smooth_variances(&self, luminance: &[Luminance], counts: &[u32]) -> Vec<Luminance> {
        let log_errors: Vec<f32> = luminance.par_iter().map(|luminance| luminance.log_error()).collect();
        let smooth = |(pixel, own): (usize, &Luminance)| {
            let Some(log_error) = self.mean_nearby(pixel, |pixel| log_errors[pixel]) else { return *own };
            let error = log_error.exp() * own.scale;
            let variance = doubt(counts[pixel]) * error * error;
            Luminance { variance: if variance.is_finite() { variance } else { own.variance }, ..*own }
        };
        luminance.par_iter().enumerate().map(smooth).collect()
    }

    /// Reduces the residual of outliers, and spreads the excess over the pixels around them. The new residual of an
    /// outlier that shows only snow has the colour of the rest of the pixel, which `rest_of` gives. Pixels with the
    /// greatest error come first.
    fn spread_outliers(
        &self,
        levels: [&[Luminance]; 2],
        (coverage, done): (&[f32], &[bool]),
        rest_of: &dyn Fn(usize) -> Vec<f32>,
        residual: &mut [f32],
    ) {
        let [start, filtered] = levels;
        let values = self.values;
        let light_of = |residual: &[f32], pixel: usize| start[pixel].baseline + residual[pixel * values + 1];
        let error = |pixel: usize| filtered[pixel].error();
        let is_lone = |pixel: usize| error(pixel) <= TARGET && filtered[pixel].greater_error() > LONE_OUTLIER_ERROR;
        let is_doubtful =
            |pixel: &usize| error(*pixel) > OUTLIER_ERROR || is_lone(*pixel) || light_of(residual, *pixel) < 0.0;
        let is_filtered = |pixel: &usize| self.guides[*pixel].is_filtered && done.get(*pixel) != Some(&true);
        let mut doubtful: Vec<usize> = (0..filtered.len()).filter(is_filtered).filter(is_doubtful).collect();
        doubtful.sort_by(|one, other| error(*other).total_cmp(&error(*one)));
        for pixel in doubtful {
            let (baseline, light) = (start[pixel].baseline, light_of(residual, pixel));
            // Light per fraction of the pixel that shows a surface.
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
            // The light without the residual gives the colour, if all of it comes from snow.
            let rest = rest_of(pixel);
            let is_snow = coverage[pixel] * self.guides[pixel].snow >= FULL_COVERAGE;
            let excess: Vec<f32> = if rest[1] > 0.0 && is_snow {
                let factor = (likely - baseline) / rest[1];
                own.iter().zip(&rest).map(|(own, rest)| own - factor * rest).collect()
            } else {
                let share = if own[1].abs() > 0.0 { ((likely - baseline) / own[1]).clamp(0.0, 1.0) } else { 1.0 };
                own.iter().map(|own| (1.0 - share) * own).collect()
            };
            let size = excess.iter().take(3).fold(0.0, |size: f32, value| size.max(value.abs()));
            if size <= 0.0 {
                continue;
            }
            // Pixels take the excess in proportion to their own standard errors, so that even light hardly changes.
            let light = |residual: &[f32], other: usize| light_of(residual, other).max(0.0);
            let room = |residual: &[f32], other: usize| {
                let light = light(residual, other);
                filtered[other].variance.sqrt().max(TARGET * light).min(light)
            };
            let spread = |residual: &[f32], distance: usize| -> f32 {
                self.alike_around(pixel, distance).map(|other| room(residual, other)).sum()
            };
            let suffices = |distance: &usize| size <= MAX_SPREAD * spread(residual, *distance);
            let distance = SPREAD_PIXELS.into_iter().find(suffices).unwrap_or(SPREAD_PIXELS[SPREAD_PIXELS.len() - 1]);
            let total = spread(residual, distance);
            if total > 0.0 {
                for other in self.alike_around(pixel, distance) {
                    // The part of the excess that no neighbour can take stays in the pixel.
                    let share = (room(residual, other) / total).min(MAX_SPREAD * light(residual, other) / size);
                    for (value, excess) in excess.iter().enumerate() {
                        residual[other * values + value] += share * excess;
                        residual[pixel * values + value] -= share * excess;
                    }
                }
            }
        }
    }

    /// The other pixels in the square around a pixel, with `distance` pixels on each side, that are mainly snow if
    /// the pixel is mainly snow, and mainly other surfaces if not.
    fn alike_around(&self, pixel: usize, distance: usize) -> impl Iterator<Item = usize> {
        square_around(pixel, distance, [self.width, self.guides.len() / self.width])
            .filter(move |other| *other != pixel && self.guides[*other].is_filtered)
            .filter(move |other| self.guides[*other].is_snow() == self.guides[pixel].is_snow())
    }

    /// The weighted mean of a value over the nearest pixels; none for a pixel that shows no surface.
    fn mean_nearby(&self, pixel: usize, value: impl Fn(usize) -> f32) -> Option<f32> {
        let (mut total, mut sum) = (0.0, 0.0);
        self.for_neighbours(pixel, 1, |neighbour, weight| {
            total += weight;
            sum += weight * value(neighbour);
        });
        (total > 0.0).then(|| sum / total)
    }

    /// Calls `add` with the weights of a pixel and of its neighbours, `step` pixels apart, if the pixel shows a
    /// surface.
    #[inline]
    fn for_neighbours(&self, pixel: usize, step: usize, mut add: impl FnMut(usize, f32)) {
        let guide = &self.guides[pixel];
        if !guide.is_filtered {
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

/// Factor that corrects an averaged variance for the number of samples.
fn doubt(samples: u32) -> f32 {
    1.0 + SAMPLES_OF_DOUBT / (samples.max(1) as f32)
}

/// Sets the residual of a pixel to a mix of two levels that has the target error, if the second level has less error.
fn blend(levels: [&Level; 2], pixel: usize, baseline: f32, residual: &mut [f32]) -> Luminance {
    let luminance = levels.map(|level| level.luminance[pixel]);
    let errors = luminance.map(Luminance::greater_error);
    let share = if errors[1] > TARGET { 1.0 } else { (errors[0] - TARGET) / (errors[0] - errors[1]) };
    // The residual scales with the baseline.
    let scale =
        luminance.map(
            |Luminance { baseline: of_level, .. }| {
                if baseline > 0.0 && of_level > 0.0 { (baseline / of_level).min(MAX_SCALE) } else { 1.0 }
            },
        );
    let factors = [(1.0 - share) * scale[0], share * scale[1]];
    let values = residual.len();
    for (index, residual) in residual.iter_mut().enumerate() {
        let [first, second] = levels.map(|level| level.residual[pixel * values + index]);
        *residual = factors[0] * first + factors[1] * second;
    }
    // The second level contains the samples of the first level, so standard errors add.
    let error = factors[0] * luminance[0].variance.sqrt() + factors[1] * luminance[1].variance.sqrt();
    Luminance {
        baseline,
        scale: (1.0 - share) * luminance[0].scale + share * luminance[1].scale,
        variance: error * error,
        ..luminance[1]
    }
}

#[cfg(test)]
mod tests;
