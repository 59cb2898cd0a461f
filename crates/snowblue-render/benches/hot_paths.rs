//! Samples of an image, on one thread: `cargo bench -p snowblue-render`.

#![allow(clippy::unwrap_used, reason = "a benchmark may panic")]

use std::path::Path;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use snowblue_base::Count;
use snowblue_render::render::render_all;
use snowblue_render::scene::film::ImageSize;
use snowblue_render::{Integrator, Scene};

fn main() {
    divan::main();
}

/// Width and height of the image in pixels.
const SIDE: u32 = 90;
/// Samples per pixel.
const SAMPLES: u32 = 16;

/// The shipped block of the paper's figure, with direct light only and with 8 bounces.
#[divan::bench(args = [0, 8])]
fn sample_of_the_block(bencher: Bencher, max_bounces: u32) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/block_30cm.toml");
    let mut scene = Scene::load(&path).unwrap();
    scene.set_image_size(ImageSize { width: SIDE, height: SIDE });
    scene.set_samples_per_pixel(Count::of(SAMPLES));
    scene.set_max_bounces(Count::of(max_bounces));
    let integrator = Integrator::prepare(&scene).unwrap();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    bencher
        .counter(ItemsCount::new(SIDE * SIDE * SAMPLES))
        .bench_local(|| one.install(|| render_all(black_box(&integrator), &|_| {})));
}
