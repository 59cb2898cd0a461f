//! The reference integrator agrees with the discrete ordinates of slabs, and conserves energy in other shapes.

use std::f64::consts::{PI, TAU};
use std::sync::Mutex;

use glam::Vec3A;
use snowblue_base::Count;
use snowblue_render::Integrator;
use snowblue_render::SceneFile;
use snowblue_render::render::render_all;
use snowblue_render::scene::Scene;
use snowblue_stat::{sidak_level, t_p_value};
use snowblue_transport::ordinates::{OrdinatesOptions, solve, solve_stack};
use snowblue_transport::rng::Stream;
use snowblue_transport::sample::SnowSample;
use snowblue_transport::slab::{Incidence, Radiometry, Slab};
use snowblue_transport::stack::{Layer, Stack};

use crate::snow::{self, Estimate, SNOW, estimate, prepared, radiance, scene_by, scene_of_many_grains};

/// Probability of a false alarm per test, over random seeds.
const LEVEL: f64 = 1e-3;

/// Indices of 400, 550 and 700 nm.
const BANDS: [usize; 3] = [0, 15, 30];

/// A scene for the reference integrator, with an image of one pixel.
fn reference_scene(text: &str) -> Scene {
    scene_by("reference", &format!("{SNOW}{text}"), &[])
}

fn reference(text: &str) -> Integrator {
    prepared(&reference_scene(text), None)
}

/// Radiometry of an infinite slab, for a box that is wide enough.
fn slab(thickness_cm: f64, incidences: &[Incidence]) -> Vec<Radiometry> {
    let slab = Slab {
        sample: SnowSample::default(),
        thicknesses_cm: vec![thickness_cm],
        incidences: incidences.to_vec(),
        wavelengths_nm: vec![400.0, 550.0, 700.0],
    };
    solve(&slab, &OrdinatesOptions::default()).unwrap()
}

/// A box from z = 0 upwards.
fn level(thickness_m: f64) -> String {
    format!(
        "[[object]]\nshape = \"box\"\nsize = [2, 2, {thickness_m}]\nposition = [0, 0, {}]\nmaterial = \"snow\"\n",
        0.5 * thickness_m
    )
}

const SKY: &str = "[environment]\nradiance_w_m2_sr = 1\nilluminant = \"E\"\n";

/// The p-value of an estimate against an expectation that has a standard error too.
fn p_value(found: &Estimate, expected: f64, standard_error: f64) -> f64 {
    t_p_value((found.mean - expected) / found.standard_error.hypot(standard_error).max(1e-6 * expected), 15.0)
}

/// A camera position at an angle to the vertical above (`up` = 1) or below (−1) a target.
fn eye(target: Vec3A, angle_deg: f64, up: f32) -> Vec3A {
    let angle = angle_deg.to_radians() as f32;
    target + Vec3A::new(angle.sin(), 0.0, up * angle.cos()) * 3.0
}

/// Rendering stops after a row of a pass, so passes of slow samples must be short even for small images.
#[test]
fn no_pass_has_more_than_16_samples_of_a_pixel() {
    let mut integrator = reference(&format!("{}{SKY}", level(0.002)));
    integrator.set_samples_per_pixel(100);
    let reported = Mutex::new(vec![0]);
    render_all(&integrator, &|at| reported.lock().unwrap().push(at.done));
    let reported = reported.into_inner().unwrap();
    assert!(reported.windows(2).all(|pair| pair[1] - pair[0] <= 16) && reported.ends_with(&[100]), "{reported:?}");
}

/// Under a sky of radiance 1 a slab has the radiance R + T, by reciprocity that of a beam from the camera.
#[test]
fn a_slab_under_a_uniform_sky_returns_what_it_does_not_absorb() {
    let angles_deg = [0.0, 40.0, 80.0];
    let kept = slab(2.0, &angles_deg.map(|angle_deg| Incidence::Beam { angle_deg }));
    let mut integrator = reference(&format!("{}{SKY}", level(0.02)));
    for (angle_deg, kept) in angles_deg.into_iter().zip(kept.chunks(3)) {
        let target = Vec3A::new(0.0, 0.0, 0.02);
        let found = estimate(&mut integrator, eye(target, angle_deg, 1.0), target, 64, BANDS);
        for (found, kept) in found.iter().zip(kept) {
            let expected = 1.0 - kept.fluxes.absorptance.value;
            // Absorption at the least absorbed wavelength is by Russian roulette: few or none of 1024 paths end.
            let rare = (kept.fluxes.absorptance.value / 1024.0).sqrt();
            let p = p_value(found, expected, kept.fluxes.absorptance.standard_error.hypot(rare));
            assert!(p > sidak_level(LEVEL, 9), "{angle_deg}°, {} nm: {found:?} {expected}", kept.wavelength_nm);
            assert!(found.standard_error < 0.02);
        }
    }
}

/// The same on white ground that touches the snow.
#[test]
fn snow_on_white_ground_agrees_with_a_stack_on_white_ground() {
    let stack = Stack {
        layers: vec![Layer::snow(SnowSample::default(), 2.0)],
        ground_albedo: 1.0.into(),
        depths_cm: vec![],
        incidences: vec![Incidence::Beam { angle_deg: 30.0 }],
        wavelengths_nm: vec![400.0, 550.0, 700.0],
    };
    let known = solve_stack(&stack, &OrdinatesOptions::default()).unwrap();
    let ground = "[material.ground]\ntype = \"diffuse\"\nreflectance = 1\n[[object]]\nshape = \"plane\"\n\
        material = \"ground\"\n";
    let mut scene = reference_scene(&format!("{}{SKY}{ground}", level(0.02)));
    scene.set_max_bounces(Count::of(10_000));
    let mut integrator = prepared(&scene, None);
    let target = Vec3A::new(0.0, 0.0, 0.02);
    let found = estimate(&mut integrator, eye(target, 30.0, 1.0), target, 64, BANDS);
    for (found, known) in found.iter().zip(&known) {
        let expected = known.whole.fluxes.reflectance;
        // Russian roulette as above.
        let rare = ((1.0 - expected.value) / 1024.0).sqrt();
        let p = p_value(found, expected.value, expected.standard_error.hypot(rare));
        assert!(p > sidak_level(LEVEL, 3), "{found:?} {expected:?}");
    }
}

/// Under a directional light the cosine-weighted mean radiance below is T/π times the irradiance, and above R/π. The
/// light is sampled by next-event estimation, so this tests the phase function and shadow rays in snow.
#[test]
fn a_slab_under_a_directional_light_agrees_with_discrete_ordinates() {
    let known = slab(0.2, &[Incidence::Beam { angle_deg: 60.0 }]);
    let lamp = "[[light]]\ntype = \"directional\"\ndirection = [0.8660254, 0, -0.5]\nirradiance_w_m2 = 2\n\
        illuminant = \"E\"\n";
    let scene = scene_of_many_grains("reference", &format!("{SNOW}{}{lamp}", level(0.002)), &[]);
    let mut integrator = prepared(&scene, None);
    integrator.set_samples_per_pixel(64);
    for above in [false, true] {
        let target = Vec3A::new(0.0, 0.0, if above { 0.002 } else { 0.0 });
        // Below the slab a phase function that is 5 % too large must be five standard errors off.
        let (directions, most_error) = if above { (64, 0.02) } else { (256, 0.009) };
        let picture = |picture: u64| {
            let mut sum = [0.0; 3];
            for direction in 0..directions {
                let mut stream = Stream::new(picture, direction);
                let (square, turn) = (stream.uniform(), TAU * stream.uniform());
                let (up, side) = ((1.0 - square).sqrt() * if above { 1.0 } else { -1.0 }, square.sqrt());
                let towards = Vec3A::new((side * turn.cos()) as f32, (side * turn.sin()) as f32, up as f32);
                integrator.set_seed((picture * directions + direction) as u32);
                let radiance = radiance(&mut integrator, target + towards * 3.0, target);
                sum.iter_mut()
                    .zip(BANDS)
                    .for_each(|(sum, k)| *sum += f64::from(radiance.0[k]) * PI / directions as f64);
            }
            sum
        };
        let pictures: Vec<[f64; 3]> = (1..=16).map(picture).collect();
        for (k, known) in known.iter().enumerate() {
            let found = Estimate::of(pictures.iter().map(|picture| picture[k]));
            // 2 W/m² across the beam are 1 W/m² on the slab. Light without interaction, e^{−14}, is negligible.
            let expected = if above { known.fluxes.reflectance } else { known.fluxes.transmittance };
            let p = p_value(&found, expected.value, expected.standard_error);
            assert!(p > sidak_level(LEVEL, 6), "above: {above}: {found:?} {expected:?}");
            assert!(found.standard_error < most_error * expected.value, "{found:?}");
        }
    }
}

/// A sphere of radiance L and radius a, which paths hit, is equivalent to a point light of I = π a² L, which is sampled
/// by next-event estimation, to first order in (a/r)².
#[test]
fn a_small_sphere_that_paths_hit_equals_a_point_light() {
    let ball = "[[light]]\ntype = \"sphere\"\nposition = [0, 0, 0.5]\nradius = 0.1\nradiance_w_m2_sr = 1\n\
        illuminant = \"E\"\n";
    let point = format!(
        "[[light]]\ntype = \"point\"\nposition = [0, 0, 0.5]\nradiant_intensity_w_sr = {}\nilluminant = \"E\"\n",
        PI * 0.01
    );
    let target = Vec3A::new(0.0, 0.0, 0.02);
    let [hit, sampled] = [(ball, 1024), (&point, 256)].map(|(lamp, samples)| {
        let mut integrator = reference(&format!("{}{lamp}", level(0.02)));
        estimate(&mut integrator, eye(target, 70.0, 1.0), target, samples, BANDS)
    });
    for (hit, sampled) in hit.iter().zip(&sampled) {
        let systematic = 0.25 * (0.1_f64 / 0.48).powi(2) * sampled.mean;
        let error = hit.standard_error.hypot(sampled.standard_error);
        assert!((hit.mean - sampled.mean).abs() < 4.0 * error + systematic, "{hit:?} {sampled:?}");
        assert!(error < 0.08 * sampled.mean, "{hit:?} {sampled:?}");
    }
}

#[test]
fn a_body_of_two_touching_parts_equals_the_whole() {
    let lamp =
        "[[light]]\ntype = \"point\"\nposition = [0.02, 0.3, 0.04]\nradiant_intensity_w_sr = 1\nilluminant = \"E\"\n";
    let part = |size_m: f64, at_m: f64, body: &str| {
        format!(
            "[[object]]\nshape = \"box\"\nsize = [{size_m}, 0.02, 0.06]\nposition = [{at_m}, 0, 0]\n\
             material = \"snow\"\n{body}"
        )
    };
    let body = "body = \"wall\"\n";
    let whole = part(0.08, 0.0, "");
    let parts = part(0.03, -0.025, body) + &part(0.05, 0.015, body);
    let (eye, target) = (Vec3A::new(-0.3, -1.0, 0.4), Vec3A::new(-0.005, -0.01, 0.01));
    let [one, two] = [whole, parts].map(|objects| {
        let mut integrator = reference(&format!("{objects}{lamp}"));
        estimate(&mut integrator, eye, target, 512, BANDS)
    });
    for (one, two) in one.iter().zip(&two) {
        let p = p_value(one, two.mean, two.standard_error);
        assert!(p > sidak_level(LEVEL, 3), "{one:?} {two:?}");
        assert!(one.standard_error < 0.15 * one.mean, "{one:?}");
    }
}

/// In the blue, where ice hardly absorbs, the sphere is nearly as bright as the sky, and never brighter.
#[test]
fn a_sphere_of_snow_under_a_uniform_sky_loses_only_what_it_absorbs() {
    let ball = "[[object]]\nshape = \"sphere\"\nradius = 0.03\nmaterial = \"snow\"\n";
    let mut integrator = reference(&format!("{ball}{SKY}"));
    for target in [Vec3A::ZERO, Vec3A::new(0.0, 0.0, 0.0299)] {
        let [blue, _, red] = estimate(&mut integrator, Vec3A::new(0.0, -1.0, 0.0), target, 64, BANDS);
        // Russian roulette ends paths at random, so single paths have a radiance of 0 or up to that of the sky.
        assert!(
            blue.mean < 1.0 + 4.0 * blue.standard_error && blue.mean > 0.99 - 4.0 * blue.standard_error,
            "{blue:?}"
        );
        assert!(red.mean < blue.mean && red.mean > 0.8, "{red:?}");
    }
}

#[test]
fn a_body_of_two_materials_is_an_error() {
    let other = SNOW.replace("[material.snow]", "[material.other]");
    let part = |material: &str| {
        format!("[[object]]\nshape = \"sphere\"\nradius = 1\nmaterial = \"{material}\"\nbody = \"one\"\n")
    };
    let camera = snow::camera_of("reference");
    let text = format!("{camera}{SNOW}{other}{}{}{SKY}", part("snow"), part("other"));
    let message = SceneFile::parse(text, "scene.toml").unwrap().build().unwrap_err().to_string();
    assert!(message.contains("body \"one\""), "{message}");
}
