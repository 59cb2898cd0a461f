//! Rendering: rows of pixels in parallel, a few samples of each pixel at a time.
//!
//! [`render`] renders a whole image; most programs need nothing else. To render a part of an image or AOVs, or to stop
//! and resume, make an [`accumulator`] and add samples with [`render_missing`]:
//!
//! ```no_run
//! # use snowblue_render::render::{RenderControl, accumulator, all_samples, render_missing};
//! # use snowblue_render::{Aovs, Integrator, RenderError, SampleBlock, Scene};
//! # fn render_left_columns(scene: &Scene) -> Result<(), RenderError> {
//! let integrator = Integrator::prepare(scene)?;
//! let left = SampleBlock { columns: 0..10, ..all_samples(scene) };
//! let aovs = Aovs { normal: true, ..Aovs::default() };
//! let mut sums = accumulator(scene, aovs, &left.window());
//! render_missing(&integrator, &left, &mut sums, RenderControl::default());
//! let image = sums.film();
//! # Ok(())
//! # }
//! ```
//!
//! A sample depends only on the scene, its pixel and its number, and a [`FilmAccumulator`] does not depend on the
//! order of the samples. So an image has the same bits on any number of threads, in one run or several, from one file
//! or from parts. With a noise target, each part of an image, and each run that resumes from a file, decides by
//! itself which pixels are done. Then the bits depend neither on the number of threads nor on interrupts of one run.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use snowblue_geometry::ray::Ray;

use crate::error::RenderError;
use crate::film::Film;
use crate::film::accumulator::{FilmAccumulator, Row};
use crate::film::aov::{Aov, Aovs};
use crate::film::cryptomatte::Matte;
use crate::film::image_file::write_png;
use crate::film::noise::{decide, repeat};
use crate::film::pixel_accumulator::PixelAccumulator;
use crate::film::resumable_file::POSITION_ORIGIN;
use crate::film::window::{SampleBlock, Window, range_length};
use crate::integrators::{Integrator, Preparation};
use crate::raster::PixelPosition;
use snowblue_scene::camera::PerspectiveCamera;
use snowblue_scene::description::SceneDescription;
use snowblue_scene::film::{Development, Exposure};
use snowblue_scene::progress::{Phase, Progress, Report};
use snowblue_scene::queries::Statistics;
use snowblue_scene::sampling::{PixelPattern, PixelSampler, Sampler};
use snowblue_scene::spectrum::Spectrum;
use snowblue_scene::{Scene, Views};

/// Samples of all pixels in one pass, within the limits of [`SAMPLES_PER_PIXEL_AND_PASS`].
const SAMPLES_PER_PASS: u64 = 1 << 20;
/// Fewest and most samples of a pixel in one pass. A pixel accumulator holds 2¹³ samples between two flushes.
/// `hybrid` and the reference take the fewest, because their samples are slow and an interrupt waits for the end of a
/// pixel. A noise target also takes the fewest, because the noise is compared with the target before each pass.
const SAMPLES_PER_PIXEL_AND_PASS: [u64; 2] = [16, 1 << 12];
/// Greatest number of samples of a pixel in one pass with a noise target.
const MAX_SAMPLES_BETWEEN_DECISIONS: u32 = 256;

/// Callbacks of a rendering. Any thread calls them.
#[derive(Clone, Copy)]
pub struct RenderControl<'a> {
    /// Receives the progress, once for each row of pixels in each pass: samples of all pixels together.
    pub report: Report<'a>,
    /// Returns whether to stop. Pixels that have begun are finished.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

/// Ignores the progress and never stops.
impl Default for RenderControl<'_> {
    fn default() -> Self {
        Self { report: &|_| {}, stop: &|| false }
    }
}

/// A rendered image.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendering {
    /// The image.
    pub film: Film,
    /// Exposure and tone curve of the scene, for a PNG of the image.
    pub development: Development,
    /// Counts of rays, and of lines through meshes that are not watertight.
    pub statistics: Statistics,
}

/// Prepares the integrator of a scene and renders the whole image, on the threads of the current rayon pool.
///
/// # Errors
///
/// As [`Integrator::prepare`].
pub fn render(scene: &Scene) -> Result<Rendering, RenderError> {
    let preparation = Preparation { views: Some(Views::Camera), ..Preparation::default() };
    Ok(render_all(&Integrator::prepare_with(scene, preparation)?, &|_| {}))
}

/// A first picture of a scene, if there is one ([`Integrator::prepare_coarse`]), in the size of its image and with its
/// exposure, on the threads of the current rayon pool.
///
/// # Errors
///
/// As [`Integrator::prepare`]: a body of snow may need finer cells.
pub fn render_coarse(scene: &Scene, report: Report) -> Result<Option<Rendering>, RenderError> {
    let Some(integrator) = Integrator::prepare_coarse(scene, report)? else { return Ok(None) };
    let coarse = render_all(&integrator, &|at| report(Progress { phase: Phase::Preview, ..at }));
    let exposure = Exposure::Stops(coarse.film.display_factor(coarse.development).log2());
    let development = Development { exposure, ..coarse.development };
    Ok(Some(Rendering { film: coarse.film.resized(scene.film().size()), development, ..coarse }))
}

/// Renders the whole image of the scene of an integrator, on the threads of the current rayon pool.
///
/// Any thread reports after each row of each pass. Rows do not finish in order.
pub fn render_all(integrator: &Integrator, report: Report) -> Rendering {
    let scene = integrator.scene();
    let target = all_samples(scene);
    let mut accumulator = accumulator(scene, Aovs::default(), &target.window());
    let control = RenderControl { report, ..RenderControl::default() };
    let statistics = render_missing(integrator, &target, &mut accumulator, control);
    Rendering { film: accumulator.film(), development: scene.film().development(), statistics }
}

impl Rendering {
    /// Writes the image as PNG, with exposure and tone curve of the scene.
    ///
    /// # Errors
    ///
    /// If the file cannot be written.
    pub fn write_png(&self, path: impl AsRef<Path>) -> Result<(), RenderError> {
        let software = concat!("snowblue ", env!("CARGO_PKG_VERSION"));
        write_png(&self.film, self.development, &[("Software", software)], path.as_ref())
    }
}

/// An accumulator without samples for a window of a scene's image. It has the AOVs that the scene needs.
pub fn accumulator(scene: &Scene, aovs: Aovs, window: &Window) -> FilmAccumulator {
    let aovs = with_needed(aovs, scene.description());
    let mut accumulator = FilmAccumulator::new(scene.film().size(), window, aovs);
    let objects = || scene.objects().list().iter().map(|object| &*object.name);
    let attributes = aovs.mattes().flat_map(|matte| match matte {
        Matte::Object => matte.attributes(objects()),
        Matte::Material => matte.attributes(scene.material_names().iter().map(String::as_str)),
    });
    let [x, y, z] = scene.local_origin().to_array();
    let origin = aovs.position.then(|| (POSITION_ORIGIN.to_owned(), format!("{x} {y} {z}")));
    accumulator.attributes = attributes.chain(origin).collect();
    accumulator
}

/// The AOVs that are asked for, and the AOVs that the scene needs: the variance with a noise target; for automatic
/// exposure the emitter, if the camera may see lamps or a sun, and the snow, if there is any; and the sums of
/// residuals, if the image is filtered.
pub fn with_needed(aovs: Aovs, scene: &SceneDescription) -> Aovs {
    Aovs {
        variance: aovs.variance || scene.integrator.noise_target.is_some(),
        emitter: aovs.emitter || scene.has_visible_emitters(),
        snow: aovs.snow || scene.has_snow(),
        residual: scene.is_filtered(),
        ..aovs
    }
}

/// All samples of all pixels of a scene's image.
pub fn all_samples(scene: &Scene) -> SampleBlock {
    SampleBlock {
        columns: 0..scene.film().width.get(),
        rows: 0..scene.film().height.get(),
        samples: 0..scene.integrator().samples_per_pixel.get(),
    }
}

/// Adds the samples of a block that the accumulator lacks, on the threads of the current rayon pool, until all are
/// done or `control.stop` returns true. Another call continues.
///
/// # Panics
///
/// If the block reaches beyond the accumulator's window, or begins with another sample than the accumulator, or if the
/// integrator was prepared for a bake of a scene without a camera.
pub fn render_missing(
    integrator: &Integrator,
    target: &SampleBlock,
    accumulator: &mut FilmAccumulator,
    control: RenderControl,
) -> Statistics {
    accumulator.begin_at(target.samples.start);
    let total = accumulator.missing_count(target);
    let all_done = AtomicU64::new(0);
    let report_row = |row: Progress| {
        let done = all_done.fetch_add(row.done, Ordering::Relaxed) + row.done;
        (control.report)(Progress { done, total, ..row });
    };
    let control = RenderControl { report: &report_row, ..control };
    let fewest_per_pass = samples_per_pixel_and_pass(integrator.scene(), target);
    let noise_target = integrator.scene().integrator().noise_target;
    let mut statistics = Statistics::default();
    let fewest = accumulator.counts_of(target).min();
    let mut start = fewest.map_or(target.samples.end, |count| target.samples.start.saturating_add(count));
    while start < target.samples.end && !(control.stop)() {
        let done = start - target.samples.start;
        if let Some(noise) = noise_target {
            decide(accumulator, target, done, noise.get());
        }
        // A decision takes as long as some samples of all pixels, so each pass doubles the number of samples.
        let most_per_pass = if noise_target.is_some() { MAX_SAMPLES_BETWEEN_DECISIONS } else { fewest_per_pass };
        let per_pass = done.min(most_per_pass).max(fewest_per_pass);
        let end = target.samples.start.saturating_add(pass_end(done, per_pass));
        let pass = SampleBlock { samples: target.samples.start..end.min(target.samples.end), ..target.clone() };
        statistics = statistics.plus(render_pass(RowRenderer { integrator }, &pass, accumulator, control));
        start = end;
    }
    statistics
}

fn samples_per_pixel_and_pass(scene: &Scene, target: &SampleBlock) -> u32 {
    let [fewest, most] = SAMPLES_PER_PIXEL_AND_PASS;
    let count = if scene.integrator().noise_target.is_some() || scene.integrator().kind.has_walks() {
        fewest
    } else {
        let pixels = target.window().size().pixel_count() as u64;
        (SAMPLES_PER_PASS / pixels.max(1)).clamp(fewest, most)
    };
    u32::try_from(count).unwrap_or(u32::MAX)
}

/// Number of samples of a pixel after the pass that begins with `done` samples. The first passes are short, for an
/// early preview of the whole image.
fn pass_end(done: u32, per_pass: u32) -> u32 {
    match done {
        0 => 1,
        1..4 => 4,
        _ => (done / per_pass * per_pass).saturating_add(per_pass),
    }
}

/// Adds the samples of a block that are missing, row by row.
fn render_pass(
    renderer: RowRenderer,
    pass: &SampleBlock,
    accumulator: &mut FilmAccumulator,
    control: RenderControl,
) -> Statistics {
    let (aovs, window) = (accumulator.aovs(), accumulator.window().clone());
    let done = std::mem::take(&mut accumulator.decision.done);
    let rows = accumulator.par_rows_mut(pass).map(|row| {
        let has_all = row.counts.iter().all(|count| *count >= range_length(&pass.samples));
        if has_all || (control.stop)() {
            return Statistics::default();
        }
        let first = (row.number - window.rows.start) * window.size().width + pass.columns.start - window.columns.start;
        let done = done.get(first as usize..).unwrap_or_default();
        let statistics = renderer.render((row, done), pass, aovs, control.stop);
        let done = statistics.samples;
        (control.report)(Progress { phase: Phase::Samples, done, total: done });
        statistics
    });
    let statistics = rows.reduce(Statistics::default, Statistics::plus);
    accumulator.decision.done = done;
    statistics
}

/// Renders rows of an image.
#[derive(Clone, Copy)]
struct RowRenderer<'a> {
    integrator: &'a Integrator,
}

impl RowRenderer<'_> {
    /// Adds the samples of a block that are missing from a row, until `stop` returns true, and returns the counts. A
    /// pixel that has begun is finished. Pixels that are `done` repeat their samples.
    fn render(
        &self,
        (row, done): (Row, &[bool]),
        pass: &SampleBlock,
        aovs: Aovs,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Statistics {
        let scene = self.integrator.scene();
        let mut tracer = self.integrator.tracer(!aovs.spectrum);
        let mut first_hits = aovs.need_first_hit().then(|| self.integrator.first_hits());
        let mut accumulator = PixelAccumulator::new(aovs);
        let mut pattern = PixelPattern::new(scene.integrator().seed, 0..0);
        let mut samples_done = 0;
        // Beside alpha, a sample without a surface is black.
        let is_shown = |distance_m: Option<f32>| !aovs.alpha || distance_m.is_some();
        let mattes = row.mattes.iter_mut().map(Some).chain(std::iter::repeat_with(|| None));
        let pixels = row.sums.chunks_exact_mut(aovs.sum_count()).zip(row.counts).zip(mattes);
        let done = done.iter().copied().chain(std::iter::repeat(false));
        for ((column, ((sums, count), mut mattes)), is_done) in pass.columns.clone().zip(pixels).zip(done) {
            let samples = pass.samples.start + *count..pass.samples.end;
            if samples.is_empty() {
                continue;
            }
            if stop() {
                break;
            }
            let before = u64::from(*count);
            *count += range_length(&samples);
            samples_done += u64::from(range_length(&samples));
            if is_done {
                repeat(sums, aovs, [before, range_length(&samples).into()]);
                continue;
            }
            if pattern.samples != samples {
                pattern = PixelPattern::new(scene.integrator().seed, samples.clone());
            }
            let pixel = Pixel::new(scene, &pattern, column, row.number);
            for sample in samples {
                let (ray, mut sampler) = (pixel.camera_ray(sample), pixel.sampler(sample));
                let (sees_snow, sees_surface) = if aovs.spectrum {
                    let sample = tracer.radiance(&ray, &mut sampler);
                    if is_shown(sample.distance_m) {
                        accumulator.add_radiance(scene.sensor(), &sample.radiance, sample.filtered.as_ref());
                    }
                    (sample.sees_snow, sample.distance_m.is_some())
                } else {
                    let sample = tracer.response(scene, &ray, &mut sampler);
                    if is_shown(sample.distance_m) {
                        accumulator.add_sample(sample.radiance, sample.filtered.as_ref());
                    }
                    (sample.sees_snow, sample.distance_m.is_some())
                };
                accumulator.add_aov(Aov::Snow, [f32::from(sees_snow), 0.0, 0.0]);
                accumulator.add_aov(Aov::Alpha, [f32::from(sees_surface), 0.0, 0.0]);
                if let Some(first_hits) = &mut first_hits {
                    first_hits.add(&ray, &mut accumulator, mattes.as_deref_mut(), aovs);
                }
            }
            accumulator.flush(sums);
        }
        let unusable_samples = accumulator.unusable_samples;
        Statistics { samples: samples_done, unusable_samples, ..tracer.statistics() }
    }
}

/// Mean radiance of one pixel, in W m⁻² sr⁻¹ as a band density, from the same samples as in the image, without the
/// filter of random walks.
///
/// # Panics
///
/// As [`render_missing`].
pub fn pixel_radiance(integrator: &Integrator, pixel: PixelPosition) -> Spectrum {
    let scene = integrator.scene();
    let (mut tracer, mut sum) = (integrator.tracer(false), Spectrum::ZERO);
    let samples = scene.integrator().samples_per_pixel.get();
    let pattern = PixelPattern::new(scene.integrator().seed, 0..samples);
    let pixel = Pixel::new(scene, &pattern, pixel.x, pixel.y);
    for sample in 0..samples {
        sum += tracer.radiance(&pixel.camera_ray(sample), &mut pixel.sampler(sample)).radiance;
    }
    sum * (samples as f32).recip()
}

/// One pixel of a scene's image.
struct Pixel<'scene> {
    camera: &'scene PerspectiveCamera,
    pattern: &'scene PixelPattern,
    shift: [u32; 2],
    sampler: PixelSampler,
    column: f32,
    row: f32,
    /// Size of the image in pixels.
    width: f32,
    height: f32,
}

impl<'scene> Pixel<'scene> {
    fn new(scene: &'scene Scene, pattern: &'scene PixelPattern, column: u32, row: u32) -> Self {
        let number = row * scene.film().width.get() + column;
        Self {
            camera: scene.camera().expect("an integrator for pictures has a camera"),
            pattern,
            shift: pattern.shift(number),
            sampler: PixelSampler::new(scene.integrator().seed, number),
            column: column as f32,
            row: row as f32,
            width: scene.film().width.get() as f32,
            height: scene.film().height.get() as f32,
        }
    }

    /// The camera ray of a sample, uniform over the area of the pixel (a box filter) and over the lens.
    #[inline]
    fn camera_ray(&self, sample: u32) -> Ray {
        let [across, down] = self.pattern.position(self.shift, sample);
        let (across, down) = ((self.column + across) / self.width, (self.row + down) / self.height);
        self.camera.lens_ray(across, down, self.pattern.lens_numbers(self.shift, sample))
    }

    /// The random numbers of a sample's path.
    #[inline]
    fn sampler(&self, sample: u32) -> Sampler {
        self.sampler.sampler(sample)
    }
}
