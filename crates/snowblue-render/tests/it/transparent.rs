//! Light through panes of glass and through surfaces with an opacity below 1.

use glam::Vec3A;
use snowblue_base::Count;
use snowblue_render::scene::spectrum::Spectrum;
use snowblue_stat::sidak_level;

use crate::snow::{SNOW, analytic_table, estimate, prepared, radiance, scene_by, scene_of_few_grains};

const METHODS: [&str; 4] = ["hybrid", "diffusion", "reference", "pcasnow"];

/// A rectangle of 4 m × 4 m at z = 0.
const RECTANGLE: &str = "v -2 -2 0\nv 2 -2 0\nv 2 2 0\nv -2 2 0\nf 1 2 3 4\n";

fn rectangle() -> [(&'static str, String); 1] {
    [("rectangle.obj", RECTANGLE.to_owned())]
}

/// A horizontal rectangle at a height in m, of a material.
fn screen(height_m: f64, material: &str) -> String {
    format!(
        "[material.screen]\n{material}\n[[object]]\nmesh = \"rectangle.obj\"\nposition = [0, 0, {height_m}]\n\
         material = \"screen\"\n"
    )
}

/// A uniform sky of radiance 1.
const SKY: &str = "[environment]\nradiance_w_m2_sr = 1\nilluminant = \"E\"\n";

const BLOCK: &str = "[[object]]\nshape = \"box\"\nsize = [0.4, 0.4, 0.2]\nmaterial = \"snow\"\n";

/// Light from above and the side.
const SUN: &str =
    "[[light]]\ntype = \"directional\"\ndirection = [-0.6, 0, -0.8]\nirradiance_w_m2 = 10\nilluminant = \"E\"\n";

fn mean(spectrum: &Spectrum) -> f64 {
    spectrum.0.iter().map(|value| f64::from(*value)).sum::<f64>() / spectrum.0.len() as f64
}

/// Seen from below, at normal incidence and at 60° to the normal, by both path tracers.
fn each_pane(background: &str, expected: impl Fn(f64) -> f64) {
    let pane = screen(0.0, "type = \"glass\"\nrefractive_index = 1.7");
    for method in ["pcasnow", "reference"] {
        let mut integrator = prepared(&scene_by(method, &format!("{pane}{SKY}{background}"), &rectangle()), None);
        for cos in [1.0_f32, 0.5] {
            let eye = Vec3A::new((1.0 - cos * cos).sqrt(), 0.0, -cos);
            let [found, ..] = estimate(&mut integrator, eye, Vec3A::ZERO, 256, [0, 1, 2]);
            let [sky, ..] =
                estimate(&mut integrator, Vec3A::new(9.0, 0.0, -9.0), Vec3A::new(18.0, 0.0, -9.0), 1, [0, 1, 2]);
            let expected = sky.mean * expected(f64::from(cos));
            let p_value = found.p_value(expected);
            assert!(p_value > sidak_level(1e-6, 8), "{method}, cos {cos}: {found:?} for {expected}");
        }
    }
}

/// T of one pane of index 1.7, by both polarisations (Stokes 1860).
fn transmittance(cos: f64) -> f64 {
    let n: f64 = 1.7;
    let refracted = (1.0 - (1.0 - cos * cos) / (n * n)).sqrt();
    let [s, p] = [(cos, n * refracted), (n * cos, refracted)].map(|(a, b)| ((a - b) / (a + b)).powi(2));
    0.5 * ((1.0 - s) / (1.0 + s) + (1.0 - p) / (1.0 + p))
}

#[test]
fn a_pane_transmits_by_the_law_of_stokes_and_mirrors_the_rest() {
    assert!((transmittance(1.0) - 2.0 * 1.7 / (1.7 * 1.7 + 1.0)).abs() < 1e-12);
    // The sky on both sides.
    each_pane("", |_| 1.0);
    // Black in the mirror, and then black behind the pane.
    let black = |height_m: f64| {
        format!(
            "[material.black]\ntype = \"diffuse\"\nreflectance = 0\n[[object]]\nshape = \"plane\"\n\
             position = [0, 0, {height_m}]\nmaterial = \"black\"\n"
        )
    };
    each_pane(&black(-5.0), transmittance);
    each_pane(&black(5.0), |cos| 1.0 - transmittance(cos));
}

/// Radiances of the top and a side of a block of snow under the sun and a sky, seen from above, past what stands there.
fn of_block(method: &str, text: &str) -> [f64; 2] {
    let text = format!("{SNOW}{BLOCK}{SUN}{text}");
    let mut scene = scene_of_few_grains(method, &text, &rectangle());
    scene.set_samples_per_pixel(Count::of(64));
    let mut integrator = prepared(&scene, (method == "pcasnow").then(analytic_table).as_ref());
    [Vec3A::new(0.05, 0.03, 0.1), Vec3A::new(0.2, 0.02, 0.03)]
        .map(|target| mean(&radiance(&mut integrator, Vec3A::new(0.9, 0.3, 1.4), target)))
}

#[test]
fn snow_behind_what_does_not_hinder_light_is_as_without() {
    for method in METHODS {
        let without = of_block(method, "");
        for material in ["type = \"diffuse\"\nreflectance = 1\nopacity = 0", "type = \"glass\"\nrefractive_index = 1"] {
            let with = of_block(method, &screen(0.8, material));
            for (with, without) in with.into_iter().zip(without) {
                assert!(
                    without > 0.0 && (with / without - 1.0).abs() < 1e-3,
                    "{method}, {material}: {with} for {without}"
                );
            }
        }
    }
}

#[test]
fn an_opacity_takes_its_share_of_the_light() {
    for method in METHODS {
        // The sun comes through the screen, and the camera is below it.
        let without = of_block(method, "");
        let with = of_block(method, &screen(1.6, "type = \"diffuse\"\nreflectance = 0\nopacity = 0.3"));
        for (with, without) in with.into_iter().zip(without) {
            assert!((with / (0.7 * without) - 1.0).abs() < 1e-3, "{method}: {with} for 0.7 of {without}");
        }
        // A pane takes what it mirrors.
        let with = of_block(method, &screen(1.6, "type = \"glass\"\nrefractive_index = 1.7"));
        let share = transmittance(0.8);
        for (with, without) in with.into_iter().zip(without) {
            // The pane mirrors light of the snow back to the snow.
            let gained = with / (share * without) - 1.0;
            assert!((-1e-3..0.02).contains(&gained), "{method}: {with} for {share} of {without}");
        }
    }
}

#[test]
fn a_wide_screen_takes_its_share_of_the_sky() {
    let ceiling = "[material.screen]\ntype = \"diffuse\"\nreflectance = 0\nopacity = 0.4\n\
        [[object]]\nshape = \"plane\"\nposition = [0, 0, 1.6]\nmaterial = \"screen\"\n";
    let floor = "[material.floor]\ntype = \"diffuse\"\nreflectance = 0\n[[object]]\nshape = \"plane\"\n\
        position = [0, 0, -0.1001]\nmaterial = \"floor\"\n";
    let text = |ceiling: &str| format!("{SNOW}{BLOCK}{floor}{SKY}{ceiling}");
    for method in METHODS {
        let of_top = |text: &str| {
            let mut scene = scene_of_few_grains(method, text, &[]);
            scene.set_max_bounces(Count::of(4));
            let mut integrator = prepared(&scene, (method == "pcasnow").then(analytic_table).as_ref());
            let [_, green, _] =
                estimate(&mut integrator, Vec3A::new(0.9, 0.3, 1.4), Vec3A::new(0.0, 0.0, 0.1), 128, [2, 15, 28]);
            green
        };
        let (without, with) = (of_top(&text("")), of_top(&text(ceiling)));
        let error = with.standard_error.hypot(0.6 * without.standard_error).hypot(2e-3 * without.mean);
        let difference = (with.mean - 0.6 * without.mean).abs();
        assert!(difference < 5.0 * error, "{method}: {with:?} for 0.6 of {without:?}");
    }
}

#[test]
fn the_alpha_of_a_texture_is_an_opacity() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("leaf.png");
    let mut encoder = png::Encoder::new(std::fs::File::create(&path).unwrap(), 2, 1);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_image_data(&[0, 0, 0, 0, 0, 0, 0, 255]).unwrap();
    // Two columns of a metre: no alpha at x = −0.5, and full alpha at x = 0.5.
    let text = format!(
        "[material.floor]\ntype = \"diffuse\"\nreflectance = 1\n[[object]]\nshape = \"plane\"\nmaterial = \"floor\"\n\
         [material.leaf]\ntype = \"diffuse\"\ntexture = {path:?}\ntexture_scale_m = 2\nopacity = 0.5\n\
         [[object]]\nshape = \"plane\"\nposition = [0, 0, 1]\nmaterial = \"leaf\"\n{SUN}"
    );
    for method in ["pcasnow", "reference"] {
        let mut integrator = prepared(&scene_by(method, &text, &[]), None);
        let mut at = |x: f32| mean(&radiance(&mut integrator, Vec3A::new(0.0, -0.5, 0.5), Vec3A::new(x, 0.0, 0.0)));
        let [clear, middle, leaf] = [-0.5, 0.0, 0.5].map(|x| at(x - 0.75));
        assert!((leaf / clear - 0.5).abs() < 1e-3 && (middle / clear - 0.75).abs() < 1e-3, "{clear} {middle} {leaf}");
    }
}
