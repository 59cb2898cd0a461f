//! A picture depends on its scene and seed, and on nothing else.

#![allow(clippy::unwrap_used, clippy::cast_possible_truncation, reason = "tests may panic, and rays are single")]

mod snow;

use std::path::Path;
use std::sync::Mutex;

use snow::{load, simple_law};
use snowblue_render::render::{Progress, Rendering, pixel_radiance, render};
use snowblue_render::scene::Scene;

fn shipped() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/block_30cm.toml");
    let mut scene = load(&path, &simple_law());
    (scene.film.width, scene.film.height) = (48, 40);
    scene.integrator.samples_per_pixel = 4;
    scene
}

fn on_threads(threads: usize, scene: &Scene) -> Rendering {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| render(scene, &|_| {}))
}

#[test]
fn one_thread_and_many_give_the_same_picture() {
    let mut scene = shipped();
    let one = on_threads(1, &scene);
    assert_eq!(one, on_threads(5, &scene));
    assert!(one.film.pixels().iter().any(|xyz| xyz.y > 0.0));
    assert_eq!(one.statistics.camera_rays, 48 * 40 * 4);
    scene.integrator.seed += 1;
    assert_ne!(one, on_threads(1, &scene));
}

#[test]
fn a_pixel_alone_is_the_pixel_in_the_picture() {
    let scene = shipped();
    let picture = render(&scene, &|_| {}).film;
    let weights = snowblue_color::Colorimeter::new(
        snowblue_color::Observer::Cie1931,
        snowblue_color::Illuminant::E,
        &snowblue_render::spectrum::wavelengths_nm(),
    )
    .unwrap();
    for (column, row) in [(0, 39), (20, 20), (47, 25)] {
        let alone = weights.xyz(&pixel_radiance(&scene, column, row).0.map(f64::from));
        assert_eq!(alone, picture.pixels()[(row * 48 + column) as usize]);
    }
}

#[test]
fn every_row_is_announced_once() {
    let rows = Mutex::new(Vec::new());
    let note = |Progress { rows_done, rows: all }: Progress| {
        assert_eq!(all, 40);
        rows.lock().unwrap().push(rows_done);
    };
    render(&shipped(), &note);
    let mut rows = rows.into_inner().unwrap();
    rows.sort_unstable();
    assert_eq!(rows, (1..=40).collect::<Vec<_>>());
}
