//! A scene rendered: rows in parallel, a few samples of all pixels at a time.
//!
//! A sample depends on the scene, its pixel and its number alone, and [`FilmAccumulator`] do not depend on the order in which samples
//! come. So a picture has the same bits on any number of threads, in one go or in many, from one file or from parts.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use wide::f32x4;

use crate::film::Film;
use crate::film::accumulator::FilmAccumulator;
use crate::film::aov::Aovs;
use crate::film::pixel_accumulator::PixelAccumulator;
use crate::film::sample_block::SampleBlock;
use crate::film::window::Window;
use crate::geometry::lanes::{LANES, LaneMask, RayPacket4, first_lanes, lanes};
use crate::integrators::Integrator;
use crate::integrators::direct::DirectLight;
use crate::integrators::first_hit::add_first_hit;
use crate::sampling::{PixelPattern, Sampler};
use crate::scene::queries::{SceneQueries, Statistics};
use crate::scene::{IntegratorKind, Scene};
use crate::spectrum::Spectrum;

/// Samples of a pass over the pixels, all together, where that is not too few or too many of each pixel.
const PASS: u64 = 1 << 20;
/// Fewest and most samples of each pixel in a pass. Sums hold 2¹³ between two foldings. The reference takes the fewest: its
/// samples are slow, and nobody waits for more than a row of them.
const PASS_PER_PIXEL: (u64, u64) = (16, 1 << 12);

/// How far a rendering has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Samples that are done, of all pixels together.
    pub samples_done: u64,
    /// Samples that are to be done.
    pub samples: u64,
}

/// What goes on beside a rendering. Both are called from any of the threads, once for each row of pixels in each pass.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Is told how far the work has come.
    pub progress: &'a (dyn Fn(Progress) + Sync),
    /// Says whether to stop; rows that are begun are finished then.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

/// A picture and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendering {
    /// The picture.
    pub film: Film,
    /// Counts of rays, and of lines through meshes that are not watertight.
    pub statistics: Statistics,
}

/// Renders the whole picture, on the threads of the current rayon pool.
///
/// `progress` is called after each row of each pass, from any of the threads; rows are not finished in order.
pub fn render(scene: &Scene, progress: &(dyn Fn(Progress) + Sync)) -> Rendering {
    let whole = whole(scene);
    let mut sums = accumulator(scene, Aovs::default(), &whole.window());
    let statistics = render_missing(scene, &whole, &mut sums, Watch { progress, stop: &|| false });
    Rendering { film: sums.film(), statistics }
}

/// An accumulator without samples for a window of a scene's image.
pub fn accumulator(scene: &Scene, aovs: Aovs, window: &Window) -> FilmAccumulator {
    FilmAccumulator::new(scene.film.size(), window, aovs, scene.sensor.wavelengths_nm())
}

/// All pixels of a scene's picture, with all its samples.
pub fn whole(scene: &Scene) -> SampleBlock {
    SampleBlock {
        columns: 0..scene.film.width,
        rows: 0..scene.film.height,
        samples: 0..scene.integrator.samples_per_pixel,
    }
}

/// Adds those samples of a portion of the picture that are not in the sums yet, on the threads of the current rayon pool,
/// until it is done or told to stop. What is still missing then the sums' coverage tells, and another call goes on from there.
///
/// # Panics
///
/// When the sums have no room for the portion.
pub fn render_missing(scene: &Scene, target: &SampleBlock, sums: &mut FilmAccumulator, watch: Watch) -> Statistics {
    let missing = sums.coverage().missing_from(target);
    let samples = missing.iter().map(SampleBlock::count).sum();
    let (done, mut statistics) = (AtomicU64::new(0), Statistics::default());
    let progress = |count| {
        let samples_done = done.fetch_add(count, Ordering::Relaxed) + count;
        (watch.progress)(Progress { samples_done, samples });
    };
    let direct = if sums.aovs().spectrum { None } else { DirectLight::of(scene) };
    let pixels = target.window().size().pixel_count() as u64;
    let per_pass = match scene.integrator.kind {
        IntegratorKind::Reference => PASS_PER_PIXEL.0,
        IntegratorKind::PcaSnow => {
            let (fewest, most) = PASS_PER_PIXEL;
            (PASS / pixels.max(1)).clamp(fewest, most).next_multiple_of(LANES as u64)
        }
    };
    let per_pass = u32::try_from(per_pass).unwrap_or(u32::MAX);
    let mut start = missing.iter().map(|portion| portion.samples.start).min().unwrap_or(target.samples.end);
    while start < target.samples.end && !(watch.stop)() {
        let end = pass_end(start, per_pass);
        let pass = SampleBlock { samples: start..end, ..target.clone() };
        let parts: Vec<SampleBlock> = missing.iter().filter_map(|portion| portion.intersection(&pass)).collect();
        statistics = statistics.plus(render_pass(
            (scene, direct.as_ref()),
            &parts,
            sums,
            Watch { progress: &|at| progress(at.samples_done), ..watch },
        ));
        start = end;
    }
    statistics
}

/// Where the pass that begins with a sample ends. The first passes are short, so that there is a whole picture soon, if a
/// rough one.
fn pass_end(start: u32, per_pass: u32) -> u32 {
    match start {
        0 => 1,
        1..4 => 4,
        _ => (start / per_pass * per_pass).saturating_add(per_pass),
    }
}

/// Adds the samples of some portions to the sums, row by row, and notes which rows were done.
fn render_pass(
    (scene, direct): (&Scene, Option<&DirectLight>),
    parts: &[SampleBlock],
    sums: &mut FilmAccumulator,
    watch: Watch,
) -> Statistics {
    let (window, channels) = (sums.window().clone(), sums.aovs());
    let finished: Vec<Option<Statistics>> = sums
        .par_rows_mut()
        .zip(window.rows.clone())
        .map(|(row_sums, row)| {
            let here: Vec<&SampleBlock> = parts.iter().filter(|part| part.rows.contains(&row)).collect();
            if here.is_empty() || (watch.stop)() {
                return None;
            }
            let mut renderer = RowRenderer::new(scene, direct, channels);
            for part in &here {
                renderer.render(row, part, window.columns.start, row_sums);
            }
            let count = here.iter().map(|part| part.count() / u64::from(part.rows.end - part.rows.start)).sum();
            (watch.progress)(Progress { samples_done: count, samples: count });
            Some(renderer.statistics())
        })
        .collect();
    for (statistics, row) in finished.iter().zip(window.rows) {
        if statistics.is_some() {
            let here = parts.iter().filter(|part| part.rows.contains(&row));
            here.for_each(|part| sums.record(SampleBlock { rows: row..row + 1, ..part.clone() }));
        }
    }
    finished.into_iter().flatten().fold(Statistics::default(), Statistics::plus)
}

/// Renders pixels of one row.
struct RowRenderer<'scene> {
    scene: &'scene Scene,
    tracer: Integrator<'scene>,
    /// The short way for light, if colours are all that is asked for.
    direct: Option<&'scene DirectLight<'scene>>,
    /// Asks for what is seen first; it is no part of the path of light, and does not count.
    beside: Option<SceneQueries<'scene>>,
    pixel: PixelAccumulator,
    channels: Aovs,
}

impl<'scene> RowRenderer<'scene> {
    fn new(scene: &'scene Scene, direct: Option<&'scene DirectLight<'scene>>, channels: Aovs) -> Self {
        Self {
            scene,
            tracer: Integrator::new(scene),
            direct,
            beside: channels.need_first_hit().then(|| SceneQueries::new(&scene.objects)),
            pixel: PixelAccumulator::new(channels),
            channels,
        }
    }

    /// Adds a portion's samples of the pixels of a row to the sums of that row, which begin with a column.
    fn render(&mut self, row: u32, part: &SampleBlock, first_column: u32, row_sums: &mut [i128]) {
        let planes = self.channels.sum_count();
        let start = (part.columns.start - first_column) as usize * planes;
        let pattern = PixelPattern::new(self.scene.integrator.seed, part.samples.clone());
        for (column, sums) in part.columns.clone().zip(row_sums[start..].chunks_exact_mut(planes)) {
            let pixel = Pixel::new(self.scene, &pattern, column, row);
            for first in part.samples.clone().step_by(LANES) {
                let (rays, which) = (pixel.rays(first), first_lanes(part.samples.end - first));
                self.add(&pixel, first, &rays, which);
            }
            self.pixel.flush(sums);
        }
    }

    /// Adds four samples of a pixel, or as many as there are, from the first of them on.
    #[inline]
    fn add(&mut self, pixel: &Pixel, first: u32, rays: &RayPacket4, which: LaneMask) {
        if let Some(direct) = self.direct {
            let (colours, found) = self.tracer.colours(direct, rays, which);
            // What is dark adds nothing.
            lanes(found).for_each(|lane| self.pixel.add_sample(colours[lane]));
        } else {
            for (sample, lane) in (first..).zip(lanes(which)) {
                let radiance = self.tracer.radiance(&rays.lane(lane), &mut pixel.sampler(sample));
                self.pixel.add_radiance(&self.scene.sensor, &radiance);
            }
        }
        if let Some(probe) = &mut self.beside {
            for lane in lanes(which) {
                add_first_hit(self.scene, probe, &rays.lane(lane), &mut self.pixel, self.channels);
            }
        }
    }

    fn statistics(&self) -> Statistics {
        Statistics { unusable_samples: self.pixel.unusable_samples, ..self.tracer.statistics() }
    }
}

/// The mean radiance that arrives at one pixel, in W m⁻² sr⁻¹ as a band density: the same samples as in the picture.
pub fn pixel_radiance(scene: &Scene, column: u32, row: u32) -> Spectrum {
    let (mut tracer, mut sum) = (Integrator::new(scene), Spectrum::ZERO);
    let samples = scene.integrator.samples_per_pixel;
    let pattern = PixelPattern::new(scene.integrator.seed, 0..samples);
    let pixel = Pixel::new(scene, &pattern, column, row);
    for sample in 0..samples {
        sum += tracer.radiance(&pixel.rays(sample).lane(0), &mut pixel.sampler(sample));
    }
    sum * (samples as f32).recip()
}

/// One pixel of a scene's picture.
struct Pixel<'scene> {
    scene: &'scene Scene,
    pattern: &'scene PixelPattern,
    shift: [i32; 2],
    column: u32,
    row: u32,
}

impl<'scene> Pixel<'scene> {
    fn new(scene: &'scene Scene, pattern: &'scene PixelPattern, column: u32, row: u32) -> Self {
        Self { scene, pattern, shift: pattern.shift(row * scene.film.width + column), column, row }
    }

    /// The camera rays of a sample and of the next three, evenly over the area of the pixel (a box filter).
    #[inline]
    fn rays(&self, sample: u32) -> RayPacket4 {
        let (width, height) = (self.scene.film.width, self.scene.film.height);
        let [across, down] = self.pattern.places(self.shift, sample);
        let at = |place, first: u32, size: u32| (f32x4::splat(first as f32) + place) / f32x4::splat(size as f32);
        self.scene.camera.rays(at(across, self.column, width), at(down, self.row, height))
    }

    /// The random numbers of a sample's path.
    #[inline]
    fn sampler(&self, sample: u32) -> Sampler {
        Sampler::new(self.scene.integrator.seed, self.row * self.scene.film.width + self.column, sample)
    }
}
