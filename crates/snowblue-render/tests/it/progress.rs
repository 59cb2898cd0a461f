//! Phases of the work come in their order, and their steps grow.

use std::sync::Mutex;

use snowblue_base::Count;
use snowblue_render::bake::BakeOptions;
use snowblue_render::files::FilesInMemory;
use snowblue_render::film::Film;
use snowblue_render::render::{render_all, render_coarse};
use snowblue_render::scene::film::ImageSize;
use snowblue_render::{Integrator, Phase, Preparation, Progress};

use crate::snow::parsed;

/// Two blocks that see each other, under lamps of two spectra.
const BLOCKS: &str = r#"
    [camera]
    position = [0, -2, 0.5]
    look_at = [0, 0, 0.1]
    [film]
    width = 6
    height = 5
    [integrator]
    type = "diffusion"
    samples_per_pixel = 2
    [light_field]
    step_mm = 20
    [material.snow]
    type = "snow"
    [[light]]
    type = "point"
    illuminant = "D65"
    position = [0, -1, 1]
    radiant_intensity_w_sr = 10
    [[light]]
    type = "point"
    illuminant = "A"
    position = [1, -1, 1]
    radiant_intensity_w_sr = 10
    [[object]]
    shape = "box"
    size = [0.2, 0.2, 0.2]
    position = [-0.15, 0, 0.1]
    material = "snow"
    [[object]]
    shape = "box"
    size = [0.2, 0.2, 0.2]
    position = [0.15, 0, 0.1]
    material = "snow"
"#;

#[test]
fn phases_come_in_their_order_and_their_steps_are_done() {
    let reported = Mutex::new(Vec::new());
    let report = |at: Progress| reported.lock().unwrap().push(at);
    let scene = parsed(BLOCKS).build(&FilesInMemory::default()).unwrap();
    let integrator =
        Integrator::prepare_with(&scene, Preparation { report: &report, ..Preparation::default() }).unwrap();
    let field = integrator.light_field().unwrap().statistics();
    render_all(&integrator, &report);
    let mut seen = reported.lock().unwrap().clone();
    let all = [Phase::Snow, Phase::Cells, Phase::Light, Phase::Samples];
    assert!(seen.is_sorted_by_key(|at| at.phase));
    for phase in all {
        let of_phase: Vec<&Progress> = seen.iter().filter(|at| at.phase == phase).collect();
        assert!(!of_phase.is_empty(), "{phase:?}");
        let is_counted = phase != Phase::Light;
        assert!(of_phase.iter().all(|at| at.done <= at.total || !is_counted), "{of_phase:?}");
    }
    // Rows of samples do not finish in order.
    seen.retain(|at| at.phase < Phase::Samples);
    assert!(seen.is_sorted_by_key(|at| (at.phase, at.done)));
    // The last step of the light is the last solution. There is a solve for each group of wavelengths.
    let last = seen.last().unwrap();
    assert_eq!(last.phase, Phase::Light);
    assert_eq!(field.solves, last.done * field.groups as u64);
    assert_eq!((field.bodies, field.lights), (2, 2));
    // Each body has a solution in every round, and one after them for each light.
    assert_eq!(last.done, 2 * (2 + field.rounds));
    assert!(field.rounds >= 2 && field.iterations > field.solves && field.rays > 0, "{field:?}");

    reported.lock().unwrap().clear();
    integrator.bake(BakeOptions::default(), &report).unwrap();
    let lamps = |done| Progress { phase: Phase::Lamps, done, total: 2 };
    let mut seen = reported.into_inner().unwrap();
    seen.dedup();
    assert_eq!(seen, [lamps(0), lamps(1), lamps(2)]);
}

/// The first picture is that of the scene, with fewer pixels and coarse cells. Its error has no bound; what the test
/// would see is another scene, light or unit.
#[test]
fn a_first_picture_is_coarse_and_like_the_last() {
    let mut scene = parsed(BLOCKS).build(&FilesInMemory::default()).unwrap();
    scene.set_image_size(ImageSize { width: 64, height: 48 });
    let reported = Mutex::new(Vec::new());
    let coarse = render_coarse(&scene, &|at| reported.lock().unwrap().push(at.phase)).unwrap().unwrap();
    assert!(reported.into_inner().unwrap().iter().all(|phase| *phase == Phase::Preview));
    assert_eq!(coarse.film.size(), scene.film().size());
    // The same samples, so that they differ by the cells, the rounds of light and the rays through grains alone.
    scene.set_image_size(ImageSize { width: 16, height: 12 });
    scene.set_samples_per_pixel(Count::of(1));
    let whole = Integrator::prepare(&scene).unwrap();
    let mean = |film: &Film| film.pixels().iter().map(|xyz| xyz.y).sum::<f64>() / film.pixels().len() as f64;
    let [first, last] = [&coarse.film, &render_all(&whole, &|_| {}).film].map(mean);
    assert!((first / last - 1.0).abs() < 0.15, "{first} {last}");
    // PCASnow has no cells.
    let pcasnow = BLOCKS.replace("diffusion", "pcasnow");
    let scene = parsed(pcasnow).build(&FilesInMemory::default()).unwrap();
    assert!(render_coarse(&scene, &|_| {}).unwrap().is_none());
}
