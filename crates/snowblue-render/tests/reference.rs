//! Light from grain to grain in a scene is the engines' light in a slab, and keeps the laws in other shapes.

#![allow(clippy::unwrap_used, clippy::cast_possible_truncation, reason = "tests may panic, and rays are single")]

mod snow;

use std::f64::consts::{PI, TAU};
use std::sync::Mutex;

use glam::Vec3A;
use snow::{Estimate, SNOW, estimate, scene, seen, simple_law};
use snowblue_database::CompressedTable;
use snowblue_database::table::Attribute;
use snowblue_render::images::raster::ImageSize;
use snowblue_render::render::render;
use snowblue_render::scene::Scene;
use snowblue_render::scene::file::SceneFile;
use snowblue_stat::{sidak_level, t_p_value};
use snowblue_transport::ordinates::{OrdinatesOptions, solve, solve_stack};
use snowblue_transport::rng::Stream;
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::{Incidence, Radiometry, Slab};
use snowblue_transport::stack::{Layer, Stack};

/// Probability that a test here fails though nothing is wrong, were its seeds not fixed.
const LEVEL: f64 = 1e-3;

/// Wavelengths that are looked at: 400, 550 and 700 nm.
const BANDS: [usize; 3] = [0, 15, 30];

/// A table that tells whose ice it is of; its curves do not count here.
fn table() -> CompressedTable {
    let ice = Attribute::new("ice_constants", "Warren & Brandt 2008");
    CompressedTable { metadata: vec![ice], ..simple_law() }
}

/// A scene of snow in which light walks, with a picture of one pixel.
fn walked(text: &str) -> Scene {
    scene(&format!("type = \"reference\"\n{SNOW}{text}"), &table(), &[])
}

/// The slab of a box that is wide enough to have no sides.
fn slab(thickness_cm: f64, incidences: &[Incidence]) -> Vec<Radiometry> {
    let slab = Slab {
        sample: SnowSample::default(),
        thicknesses_cm: vec![thickness_cm],
        incidences: incidences.to_vec(),
        wavelengths_nm: vec![400.0, 550.0, 700.0],
    };
    solve(&slab, &OrdinatesOptions::default()).unwrap()
}

/// A level box from z = 0 upwards.
fn level(thickness_m: f64) -> String {
    format!(
        "[[object]]\nshape = \"box\"\nsize = [2, 2, {thickness_m}]\nposition = [0, 0, {}]\nmaterial = \"snow\"\n",
        0.5 * thickness_m
    )
}

const SKY: &str = "[environment]\nradiance_w_m2_sr = 1\nilluminant = \"E\"\n";

/// Probability of an estimate at least as far from an expectation with an error of its own.
fn p_value(found: &Estimate, expected: f64, standard_error: f64) -> f64 {
    t_p_value((found.mean - expected) / found.standard_error.hypot(standard_error).max(1e-6 * expected), 15.0)
}

/// An eye that sees the middle of the level z = 0 or of the top of a box from an angle.
fn eye(target: Vec3A, angle_deg: f64, up: f32) -> Vec3A {
    let angle = angle_deg.to_radians() as f32;
    target + Vec3A::new(angle.sin(), 0.0, up * angle.cos()) * 3.0
}

/// An interrupt is heard after a row of a pass, so passes of slow samples are short however small the picture is.
#[test]
fn no_pass_has_more_than_16_samples_of_a_pixel() {
    let mut scene = walked(&format!("{}{SKY}", level(0.002)));
    scene.set_samples_per_pixel(100);
    let told = Mutex::new(vec![0]);
    render(&scene, &|at| told.lock().unwrap().push(at.samples_done));
    let told = told.into_inner().unwrap();
    assert!(told.windows(2).all(|pair| pair[1] - pair[0] <= 16) && told.ends_with(&[100]), "{told:?}");
}

/// Under a sky of radiance 1 a slab has the radiance R + T of a beam from the eye: what its snow does not absorb.
#[test]
fn a_slab_under_an_even_sky_returns_what_it_does_not_absorb() {
    let angles_deg = [0.0, 40.0, 80.0];
    let kept = slab(2.0, &angles_deg.map(|angle_deg| Incidence::Beam { angle_deg }));
    let mut scene = walked(&format!("{}{SKY}", level(0.02)));
    for (angle_deg, kept) in angles_deg.into_iter().zip(kept.chunks(3)) {
        let target = Vec3A::new(0.0, 0.0, 0.02);
        let found = estimate(&mut scene, eye(target, angle_deg, 1.0), target, 64, BANDS);
        for (found, kept) in found.iter().zip(kept) {
            let expected = 1.0 - kept.absorptance.value;
            // Chance pays for the least absorbed wavelength: of 1024 samples few or none end.
            let rare = (kept.absorptance.value / 1024.0).sqrt();
            let p = p_value(found, expected, kept.absorptance.standard_error.hypot(rare));
            assert!(p > sidak_level(LEVEL, 9), "{angle_deg}°, {} nm: {found:?} {expected}", kept.wavelength_nm);
            assert!(found.standard_error < 0.02);
        }
    }
}

/// The same on white ground that the snow touches: light that leaves below comes back.
#[test]
fn snow_on_white_ground_returns_what_the_stack_returns() {
    let stack = Stack {
        layers: vec![Layer { sample: SnowSample::default(), thickness_cm: 2.0 }],
        ground_albedo: 1.0,
        depths_cm: vec![],
        incidences: vec![Incidence::Beam { angle_deg: 30.0 }],
        wavelengths_nm: vec![400.0, 550.0, 700.0],
    };
    let known = solve_stack(&stack, &OrdinatesOptions::default()).unwrap();
    let ground = "[material.ground]\ntype = \"diffuse\"\nreflectance = 1\n[[object]]\nshape = \"plane\"\nmaterial = \"ground\"\n";
    let mut scene = walked(&format!("{}{SKY}{ground}", level(0.02)));
    scene.set_max_bounces(10_000);
    let target = Vec3A::new(0.0, 0.0, 0.02);
    let found = estimate(&mut scene, eye(target, 30.0, 1.0), target, 64, BANDS);
    for (found, known) in found.iter().zip(&known) {
        let expected = known.whole.reflectance;
        // As above: chance pays for the least absorbed wavelength.
        let rare = ((1.0 - expected.value) / 1024.0).sqrt();
        let p = p_value(found, expected.value, expected.standard_error.hypot(rare));
        assert!(p > sidak_level(LEVEL, 3), "{found:?} {expected:?}");
    }
}

/// A distant lamp above: the radiance below, averaged over directions by their cosine, is T/π of its irradiance, and that
/// above R/π. The lamp is joined by force, so that this holds the phase function and the shadow of snow to account.
#[test]
fn a_slab_under_a_distant_lamp_passes_and_reflects_what_the_engines_say() {
    let known = slab(0.2, &[Incidence::Beam { angle_deg: 60.0 }]);
    let lamp = "[[light]]\ntype = \"directional\"\ndirection = [0.8660254, 0, -0.5]\nirradiance_w_m2 = 2\nilluminant = \"E\"\n";
    let mut scene = walked(&format!("{}{lamp}", level(0.002)));
    scene.set_samples_per_pixel(64);
    for above in [false, true] {
        let target = Vec3A::new(0.0, 0.0, if above { 0.002 } else { 0.0 });
        // Below it is to be exact: a phase function that is a twentieth too great is then five standard errors off.
        let (directions, most_error) = if above { (64, 0.02) } else { (256, 0.009) };
        let picture = |picture: u64| {
            let mut sum = [0.0; 3];
            for direction in 0..directions {
                let mut stream = Stream::new(picture, direction);
                let (square, turn) = (stream.uniform(), TAU * stream.uniform());
                let (up, side) = ((1.0 - square).sqrt() * if above { 1.0 } else { -1.0 }, square.sqrt());
                let towards = Vec3A::new((side * turn.cos()) as f32, (side * turn.sin()) as f32, up as f32);
                scene.set_seed((picture * directions + direction) as u32);
                let radiance = seen(&mut scene, target + towards * 3.0, target);
                sum.iter_mut()
                    .zip(BANDS)
                    .for_each(|(sum, k)| *sum += f64::from(radiance.0[k]) * PI / directions as f64);
            }
            sum
        };
        let pictures: Vec<[f64; 3]> = (1..=16).map(picture).collect();
        for (k, known) in known.iter().enumerate() {
            let found = Estimate::of(pictures.iter().map(|picture| picture[k]));
            // 2 W/m² across the beam are 1 W/m² on the level. What meets no grain, e^{−14}, is not seen.
            let expected = if above { known.reflectance } else { known.transmittance };
            let p = p_value(&found, expected.value, expected.standard_error);
            assert!(p > sidak_level(LEVEL, 6), "above: {above}: {found:?} {expected:?}");
            assert!(found.standard_error < most_error * expected.value, "{found:?}");
        }
    }
}

/// A lamp that paths meet by themselves lights snow as one that they are joined to. A ball of radiance L and radius a
/// shines like a point of I = π a² L on what faces it; where its light comes from differs by (a/r)².
#[test]
fn a_small_ball_that_is_met_and_a_point_that_is_joined_shine_alike() {
    let ball = "[[light]]\ntype = \"sphere\"\nposition = [0, 0, 0.5]\nradius = 0.1\nradiance_w_m2_sr = 1\nilluminant = \"E\"\n";
    let point = format!(
        "[[light]]\ntype = \"point\"\nposition = [0, 0, 0.5]\nradiant_intensity_w_sr = {}\nilluminant = \"E\"\n",
        PI * 0.01
    );
    let target = Vec3A::new(0.0, 0.0, 0.02);
    let [met, joined] = [(ball, 1024), (&point, 256)].map(|(lamp, samples)| {
        let mut scene = walked(&format!("{}{lamp}", level(0.02)));
        estimate(&mut scene, eye(target, 70.0, 1.0), target, samples, BANDS)
    });
    for (met, joined) in met.iter().zip(&joined) {
        let systematic = 0.25 * (0.1_f64 / 0.48).powi(2) * joined.mean;
        let error = met.standard_error.hypot(joined.standard_error);
        assert!((met.mean - joined.mean).abs() < 4.0 * error + systematic, "{met:?} {joined:?}");
        assert!(error < 0.08 * joined.mean, "{met:?} {joined:?}");
    }
}

/// Two parts of one body that touch are the whole.
#[test]
fn a_body_in_two_parts_is_one() {
    let lamp =
        "[[light]]\ntype = \"point\"\nposition = [0.02, 0.3, 0.04]\nradiant_intensity_w_sr = 1\nilluminant = \"E\"\n";
    let part = |size_m: f64, at_m: f64, body: &str| {
        format!(
            "[[object]]\nshape = \"box\"\nsize = [{size_m}, 0.02, 0.06]\nposition = [{at_m}, 0, 0]\nmaterial = \"snow\"\n{body}"
        )
    };
    let body = "body = \"wall\"\n";
    let whole = part(0.08, 0.0, "");
    let parts = part(0.03, -0.025, body) + &part(0.05, 0.015, body);
    let (eye, target) = (Vec3A::new(-0.3, -1.0, 0.4), Vec3A::new(-0.005, -0.01, 0.01));
    let [one, two] = [whole, parts].map(|objects| {
        let mut scene = walked(&format!("{objects}{lamp}"));
        estimate(&mut scene, eye, target, 512, BANDS)
    });
    for (one, two) in one.iter().zip(&two) {
        let p = p_value(one, two.mean, two.standard_error);
        assert!(p > sidak_level(LEVEL, 3), "{one:?} {two:?}");
        assert!(one.standard_error < 0.15 * one.mean, "{one:?}");
    }
}

/// A ball of snow under an even sky is nearly as bright as the sky in the blue, wherever it is seen, and never brighter.
#[test]
fn a_ball_of_snow_under_an_even_sky_loses_only_what_it_absorbs() {
    let ball = "[[object]]\nshape = \"sphere\"\nradius = 0.03\nmaterial = \"snow\"\n";
    let mut scene = walked(&format!("{ball}{SKY}"));
    for target in [Vec3A::ZERO, Vec3A::new(0.0, 0.0, 0.0299)] {
        let [blue, _, red] = estimate(&mut scene, Vec3A::new(0.0, -1.0, 0.0), target, 64, BANDS);
        // Chance lets paths pay the least absorption, so that each of them ends with 0 or less than the sky's.
        assert!(
            blue.mean < 1.0 + 4.0 * blue.standard_error && blue.mean > 0.99 - 4.0 * blue.standard_error,
            "{blue:?}"
        );
        assert!(red.mean < blue.mean && red.mean > 0.8, "{red:?}");
    }
}

#[test]
fn one_thread_and_many_give_the_same_picture() {
    let lamp = "[[light]]\ntype = \"point\"\nposition = [0, 0.3, 0]\nradiant_intensity_w_sr = 1\n";
    let mut scene = walked(&format!(
        "[[object]]\nshape = \"sphere\"\nradius = 0.02\nposition = [0, -8.9, 0]\nmaterial = \"snow\"\n{lamp}"
    ));
    scene.set_image_size(ImageSize { width: 12, height: 10 });
    scene.set_samples_per_pixel(3);
    let on_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render(&scene, &|_| {}))
    };
    let one = on_threads(1);
    assert_eq!(one, on_threads(3));
    assert!(one.film.pixels().iter().any(|xyz| xyz.y > 0.0));
}

#[test]
fn what_a_walk_cannot_honour_is_refused() {
    let refused = |text: &str, table: &CompressedTable| {
        let text = format!("{}type = \"reference\"\n{text}", snow::CAMERA);
        SceneFile::parse(text, "scene.toml").unwrap().build(table).unwrap_err().to_string()
    };
    let with = |more: &str| format!("{SNOW}{more}{SKY}");
    let message = refused(&with("reflectance = 0.9\n"), &table());
    assert!(message.ends_with("material.snow.reflectance is not for the reference integrator"), "{message}");
    let message = refused(&with("emission = \"relative\"\n"), &table());
    assert!(message.contains("material.snow.emission"), "{message}");
    let message = refused(&with(""), &simple_law());
    assert!(message.contains("ice_constants"), "{message}");
    let other = SNOW.replace("[material.snow]", "[material.other]");
    let part = |material: &str| {
        format!("[[object]]\nshape = \"sphere\"\nradius = 1\nmaterial = \"{material}\"\nbody = \"one\"\n")
    };
    let message = refused(&format!("{SNOW}{other}{}{}{SKY}", part("snow"), part("other")), &table());
    assert!(message.contains("body \"one\""), "{message}");
}
