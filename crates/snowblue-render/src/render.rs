//! A scene rendered: rows in parallel, each pixel by itself.
//!
//! A pixel's value depends on the scene and the pixel's place alone, and its samples are added in their order; so the
//! picture has the same bits on any number of threads.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;
use snowblue_color::Xyz;

use crate::film::Film;
use crate::path::PathTracer;
use crate::probe::Statistics;
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::spectrum::Spectrum;

/// How far a rendering has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Rows of pixels that are finished.
    pub rows_done: u32,
    /// Rows of the picture.
    pub rows: u32,
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
/// `progress` is called after each row, from any of the threads; rows are not finished in order.
pub fn render(scene: &Scene, progress: &(dyn Fn(Progress) + Sync)) -> Rendering {
    let rows = scene.film.height;
    let rows_done = AtomicU32::new(0);
    let finished: Vec<(Vec<Xyz>, Statistics)> = (0..rows)
        .into_par_iter()
        .map(|row| {
            let finished = render_row(scene, row);
            let rows_done = rows_done.fetch_add(1, Ordering::Relaxed) + 1;
            progress(Progress { rows_done, rows });
            finished
        })
        .collect();
    let mut pixels = Vec::with_capacity(scene.film.width as usize * rows as usize);
    let mut statistics = Statistics::default();
    for (row, counts) in finished {
        pixels.extend(row);
        statistics = statistics.plus(counts);
    }
    Rendering { film: Film::new(scene.film.width, rows, pixels), statistics }
}

/// The mean radiance that arrives at one pixel, in W m⁻² sr⁻¹ as a band density: the same samples as in the picture.
pub fn pixel_radiance(scene: &Scene, column: u32, row: u32) -> Spectrum {
    sampled_radiance(scene, &mut PathTracer::new(scene), column, row)
}

fn render_row(scene: &Scene, row: u32) -> (Vec<Xyz>, Statistics) {
    let mut tracer = PathTracer::new(scene);
    let pixels = (0..scene.film.width)
        .map(|column| scene.retina.xyz(&sampled_radiance(scene, &mut tracer, column, row)))
        .collect();
    (pixels, tracer.statistics())
}

/// The mean radiance over the area of a pixel (a box filter).
fn sampled_radiance(scene: &Scene, tracer: &mut PathTracer, column: u32, row: u32) -> Spectrum {
    let (width, height) = (scene.film.width, scene.film.height);
    let samples = scene.integrator.samples_per_pixel;
    let mut sum = Spectrum::ZERO;
    for sample in 0..samples {
        let mut sampler = Sampler::new(scene.integrator.seed, row * width + column, sample);
        let [across, down, ..] = sampler.next_four();
        let ray = scene.camera.ray((column as f32 + across) / width as f32, (row as f32 + down) / height as f32);
        sum += tracer.radiance(&ray, &mut sampler);
    }
    sum * (samples as f32).recip()
}
