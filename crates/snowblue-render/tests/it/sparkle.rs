//! Sparkle in pictures: it keeps the mean, stays on the snow, and depends neither on the seed nor on how a picture is
//! divided.

use glam::Vec3A;
use snowblue_base::Count;
use snowblue_render::film::Film;
use snowblue_render::render::{RenderControl, accumulator, all_samples, render_all, render_missing};
use snowblue_render::scene::camera::View;
use snowblue_render::scene::film::ImageSize;
use snowblue_render::{Aovs, Integrator, SampleBlock};

use crate::snow::{prepared, scene_of_few_grains};

/// A picture: the elevation of the light and of the eye, and the azimuth between them, in degrees; the distance in m,
/// and the height of the picture in degrees.
#[derive(Debug, Clone, Copy)]
struct Geometry {
    light_deg: f32,
    eye_deg: f32,
    azimuth_deg: f32,
    distance_m: f32,
    height_deg: f32,
}

const SIDE_LIGHT: Geometry =
    Geometry { light_deg: 30.0, eye_deg: 40.0, azimuth_deg: 80.0, distance_m: 1.0, height_deg: 8.0 };

/// The snow of the tests. Facets of 40 µm send some 10⁴ glints from each m², of which a picture has some hundreds.
fn snow(sparkle: &str) -> String {
    let facetness = if sparkle.contains("facetness") { "" } else { "facetness = 0.5\n" };
    format!("[material.snow]\ntype = \"snow\"\ngrain_size_um = [500, 700]\n{facetness}{sparkle}\n")
}

const FACETS: &str = "sparkle = { facet_size_um = 40 }";

/// A block of snow whose top is at z = 0.
const BLOCK: &str = "shape = \"box\"\nsize = [0.6, 0.6, 0.05]\nposition = [0, 0, -0.025]";

/// Parallel light from the direction x.
fn parallel_light(geometry: Geometry) -> String {
    let (sin, cos) = geometry.light_deg.to_radians().sin_cos();
    format!("[[light]]\ntype = \"directional\"\ndirection = [{}, 0, {}]\nirradiance_w_m2 = 1", -cos, -sin)
}

/// The block in parallel light.
fn integrator(method: &str, sparkle: &str, geometry: Geometry) -> Integrator {
    integrator_of(method, &snow(sparkle), (BLOCK, &parallel_light(geometry)), geometry)
}

/// A body of snow in a light.
fn integrator_of(method: &str, snow: &str, (body, light): (&str, &str), geometry: Geometry) -> Integrator {
    let text = format!("{snow}[[object]]\n{body}\nmaterial = \"snow\"\n{light}\n[light_field]\nnodes = 2000\n");
    let mut scene = scene_of_few_grains(method, &text, &[]);
    scene.set_image_size(ImageSize { width: 64, height: 64 });
    scene.set_samples_per_pixel(Count::of(4));
    let mut integrator = prepared(&scene, None);
    look(&mut integrator, geometry, Vec3A::ZERO);
    integrator
}

/// Points the camera at the middle of the top of the block, with everything moved.
fn look(integrator: &mut Integrator, geometry: Geometry, offset: Vec3A) {
    let (sin, cos) = geometry.eye_deg.to_radians().sin_cos();
    let (y, x) = geometry.azimuth_deg.to_radians().sin_cos();
    let position = Vec3A::new(x * cos, y * cos, sin) * geometry.distance_m + offset;
    let view = View { position, look_at: offset, up: Vec3A::Z, vertical_fov_deg: geometry.height_deg };
    assert!(integrator.set_view(&view));
}

fn luminances(film: &Film) -> Vec<f64> {
    film.pixels().iter().map(|pixel| pixel.y).collect()
}

/// What sparkle adds to the luminance of each pixel, over the mean without it: the samples are the same otherwise.
fn changes(with: &Integrator, without: &Integrator) -> Vec<f64> {
    let [with, without] = [with, without].map(|integrator| luminances(&render_all(integrator, &|_| {}).film));
    let mean = without.iter().sum::<f64>() / without.len() as f64;
    with.iter().zip(&without).map(|(with, without)| (with - without) / mean).collect()
}

/// The mean and its standard error, by blocks of 8 by 8 pixels of an image of 64 by 64: facets cross the edges of
/// pixels.
fn mean_of_blocks(values: &[f64]) -> [f64; 2] {
    let block = |index: usize| {
        let (row, column) = (index / 8 * 8, index % 8 * 8);
        let pixels = (0..64).map(|pixel| values[(row + pixel / 8) * 64 + column + pixel % 8]);
        pixels.sum::<f64>() / 64.0
    };
    let means: Vec<f64> = (0..64).map(block).collect();
    let mean = means.iter().sum::<f64>() / 64.0;
    let variance = means.iter().map(|one| (one - mean).powi(2)).sum::<f64>() / 63.0;
    [mean, (variance / 64.0).sqrt()]
}

fn correlation(one: &[f64], other: &[f64]) -> f64 {
    let count = one.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
    let means = [mean(one), mean(other)];
    let product = |a: &[f64], b: &[f64], means: [f64; 2]| {
        a.iter().zip(b).map(|(a, b)| (a - means[0]) * (b - means[1])).sum::<f64>()
    };
    product(one, other, means) / (product(one, one, [means[0]; 2]) * product(other, other, [means[1]; 2])).sqrt()
}

/// The mean picture is that without sparkle: within 4 standard errors. Between the glints it is darker by the smooth
/// term, of which the errors are less than a quarter, so that it would show if glints were missing. Pixels hold a third
/// of a facet that mirrors the light, or fewer, so that a glint is some three times the smooth term, or more.
fn assert_same_mean(place: &str, with: &Integrator, without: &Integrator) {
    let changes = changes(with, without);
    let [mean, error] = mean_of_blocks(&changes);
    assert!(mean.abs() < 4.0 * error, "{place}: {mean} ± {error}");
    let mut sorted = changes;
    sorted.sort_by(f64::total_cmp);
    let smooth = -sorted[sorted.len() / 20];
    assert!(error < 0.25 * smooth, "{place}: {smooth} {error}");
    assert!(sorted[sorted.len() - 1] > 2.0 * smooth, "{place}: no glint");
}

/// In five geometries and by each integrator, the mean picture is that without sparkle.
#[test]
fn the_mean_is_that_of_smooth_snow() {
    let geometries = [
        SIDE_LIGHT,
        Geometry { light_deg: 15.0, eye_deg: 25.0, azimuth_deg: 180.0, ..SIDE_LIGHT },
        Geometry { light_deg: 60.0, eye_deg: 85.0, azimuth_deg: 10.0, distance_m: 2.0, height_deg: 5.0 },
        Geometry { light_deg: 40.0, eye_deg: 30.0, azimuth_deg: 140.0, height_deg: 10.0, ..SIDE_LIGHT },
        Geometry { light_deg: 20.0, eye_deg: 60.0, azimuth_deg: 40.0, distance_m: 0.6, height_deg: 12.0 },
    ];
    for geometry in geometries {
        for method in ["pcasnow", "diffusion"] {
            let [with, without] = [FACETS, ""].map(|sparkle| integrator(method, sparkle, geometry));
            assert_same_mean(&format!("{method} {geometry:?}"), &with, &without);
        }
    }
}

/// The same in the light of a sun's disc and of a lamp, on a mesh with normals for shading, and in wet snow.
#[test]
fn the_mean_is_that_of_smooth_snow_in_lights_of_every_kind() {
    let sun = "[sky]\nsun = { elevation_deg = 30, azimuth_deg = 90 }";
    let lamp = "[[light]]\ntype = \"sphere\"\nposition = [1.3, 0, 0.75]\nradius = 0.02\nradiance_w_m2_sr = 1";
    let drift = "shape = \"drift\"\nsize = [0.6, 0.6, 0.05]\nmounds = [[0.05, 0, 0.03, 0.1]]\nposition = [0, 0, -0.06]";
    let wet = "water_saturation = 0.3\n";
    for (name, body, light, keys) in
        [("sun", BLOCK, sun, ""), ("lamp", BLOCK, lamp, ""), ("drift", drift, sun, ""), ("wet", BLOCK, sun, wet)]
    {
        let [with, without] = [FACETS, ""]
            .map(|sparkle| integrator_of("diffusion", &format!("{}{keys}", snow(sparkle)), (body, light), SIDE_LIGHT));
        assert_same_mean(name, &with, &without);
    }
}

/// The filter of `hybrid` neither sees nor spreads sparkle: it is that of the light field, to rounding. So it is
/// without the filter: in parallel light both have the same samples of the snow's surface.
#[test]
fn hybrid_has_the_sparkle_of_the_light_field() {
    let of = |method: &str, keys: &str| {
        let [with, without] = [FACETS, ""].map(|sparkle| {
            // The text before goes on with the table of the integrator.
            let snow = format!("{keys}{}", snow(sparkle));
            let integrator = integrator_of(method, &snow, (BLOCK, &parallel_light(SIDE_LIGHT)), SIDE_LIGHT);
            luminances(&render_all(&integrator, &|_| {}).film)
        });
        with.into_iter().zip(without).map(|(with, without)| with - without).collect::<Vec<_>>()
    };
    let diffusion = of("diffusion", "");
    let greatest = diffusion.iter().copied().fold(0.0, f64::max);
    for keys in ["", "filter = false\n"] {
        for (one, other) in of("hybrid", keys).iter().zip(&diffusion) {
            assert!((one - other).abs() < 1e-5 * greatest, "{keys}: {one} {other} {greatest}");
        }
    }
}

/// What glints does not depend on the seed, although a pixel holds some two facets that mirror the light: 16 samples of
/// a pixel, each of the area of a pixel, see the same facets but for 2 % of the variance, as discs of that area do that
/// are thrown at points.
#[test]
fn crowded_facets_are_seen_by_every_seed() {
    let geometry = Geometry { height_deg: 10.0, ..SIDE_LIGHT };
    let of_seed = |seed: u32| {
        let [with, without] = ["sparkle = { facet_size_um = 20 }", ""].map(|sparkle| {
            let mut integrator = integrator("pcasnow", sparkle, geometry);
            integrator.set_samples_per_pixel(16);
            integrator.set_seed(seed);
            integrator
        });
        changes(&with, &without)
    };
    let [first, second] = [1, 2].map(of_seed);
    let found = correlation(&first, &second);
    assert!(found > 0.97, "{found}");
}

/// Facets lie on the snow: another seed and a camera that moves by a pixel find the same. A camera that moves by five
/// degrees finds others.
#[test]
fn facets_stay_where_they_are() {
    let [mut with, mut without] = [FACETS, ""].map(|sparkle| integrator("pcasnow", sparkle, SIDE_LIGHT));
    let mut of = |geometry: Geometry, offset: Vec3A, seed: u32| {
        for integrator in [&mut with, &mut without] {
            integrator.set_samples_per_pixel(64);
            integrator.set_seed(seed);
            look(integrator, geometry, offset);
        }
        changes(&with, &without)
    };
    let first = of(SIDE_LIGHT, Vec3A::ZERO, 1);
    // 64 samples leave 0.2 % of the variance to chance, as discs of the area of a pixel do that are thrown at points.
    let same = correlation(&first, &of(SIDE_LIGHT, Vec3A::ZERO, 2));
    assert!(same > 0.99, "{same}");
    // The camera moves by one pixel to the right: of 8° over 64 pixels, at 1 m. That turns mirrored light by 2.2 mrad,
    // a lobe of 6.5 mrad (0.47 λ/d): e^{−(2.2/6.5)²/4} = 0.97 of the correlation is left. Towards the upper and the
    // lower edge the snow is nearer and farther by some 8 %, and its facets move by as much of a pixel.
    let pixel_m = 2.0 * 4.0_f32.to_radians().tan() / 64.0;
    let (y, x) = SIDE_LIGHT.azimuth_deg.to_radians().sin_cos();
    let moved = of(SIDE_LIGHT, Vec3A::new(-y, x, 0.0) * pixel_m, 1);
    let [shifted, kept] = [(&moved, 0), (&first, 1)].map(|(values, skip)| {
        values.chunks_exact(64).flat_map(|row| row[skip..63 + skip].iter().copied()).collect::<Vec<f64>>()
    });
    let moved = correlation(&shifted, &kept);
    assert!(moved > 0.9, "{moved}");
    let turned = of(Geometry { azimuth_deg: SIDE_LIGHT.azimuth_deg + 5.0, ..SIDE_LIGHT }, Vec3A::ZERO, 1);
    // Independent pictures, in which a facet covers some four of 64 × 64 pixels: 4 standard errors.
    let turned = correlation(&first, &turned);
    assert!(turned.abs() < 4.0 * 2.0 / 64.0, "{turned}");
}

/// Crops and ranges of samples have the bits of the whole.
#[test]
fn parts_have_the_bits_of_the_whole() {
    let integrator = integrator("hybrid", FACETS, SIDE_LIGHT);
    let whole = render_all(&integrator, &|_| {}).film;
    let all = all_samples(integrator.scene());
    let mut sums = accumulator(integrator.scene(), Aovs::default(), &all.window());
    for samples in [0..1, 1..4] {
        for (columns, rows) in [(0..20, 0..64), (20..64, 0..13), (20..64, 13..64)] {
            let part = SampleBlock { columns, rows, samples: samples.clone() };
            let mut of_part = accumulator(integrator.scene(), Aovs::default(), &part.window());
            render_missing(&integrator, &part, &mut of_part, RenderControl::default());
            sums.add(&of_part).unwrap();
        }
    }
    assert_eq!(sums.film(), whole);
}

/// What a picture is made from names sparkle, and snow that cannot sparkle says so.
#[test]
fn provenance_and_notes_know_sparkle() {
    let of = |method: &str, sparkle: &str| integrator(method, sparkle, SIDE_LIGHT);
    let plain = of("pcasnow", "").provenance();
    assert!(plain.difference(&of("pcasnow", "sparkle = false").provenance()).is_none());
    let sparkling = of("pcasnow", "sparkle = true").provenance();
    assert!(plain.difference(&sparkling).is_some());
    assert!(sparkling.difference(&of("pcasnow", FACETS).provenance()).is_some());
    let notes = |integrator: Integrator| integrator.notes().join("\n");
    assert!(notes(of("reference", FACETS)).contains("material.snow: its sparkle is not drawn, because the reference"));
    // One value: a mean of 0 would stand for a range.
    let smooth = "facetness = [0, 0, 0, 0]\nsparkle = true";
    let smooth = of("pcasnow", smooth);
    assert!(notes(smooth).contains("material.snow: its sparkle is not drawn, because its grains have no flat facets"));
    assert!(!notes(of("pcasnow", FACETS)).contains("sparkle"));
}
