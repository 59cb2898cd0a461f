//! Scenes under sun and sky: irradiances of level ground, soft shadows, and where the sun stands.

use std::f64::consts::PI;

use glam::Vec3A;
use snowblue_base::{Count, Numbers};
use snowblue_color::LinearRgb;
use snowblue_render::files::FilesInMemory;
use snowblue_render::render::{render, render_all};
use snowblue_render::scene::Scene;
use snowblue_render::scene::description::SceneDescription;
use snowblue_sky::{ClearSky, SUN_RADIUS_RAD, WAVELENGTHS_NM, air_extinction_per_m};
use snowblue_stat::{Moments, sidak_level, z_p_value};

use crate::snow::{SNOW, analytic_table, prepared, radiance, scene, scene_by};

/// White ground that reflects half of the light.
const GROUND: &str = "[material.ground]\ntype = \"diffuse\"\nreflectance = 0.5\n\
                      [[object]]\nshape = \"plane\"\nmaterial = \"ground\"\n";

fn under(sky: &str, method: &str, objects: &str) -> Scene {
    scene_by(method, &format!("{sky}{GROUND}{objects}"), &[])
}

/// The irradiance of the ground at a point over 10 nm at some wavelengths, in W/m², by independent pictures.
fn irradiance(scene: &Scene, at: Vec3A, samples: u32) -> [Moments; 3] {
    let mut integrator = prepared(scene, None);
    integrator.set_samples_per_pixel(samples);
    let mut moments = [Moments::default(); 3];
    for seed in 1..=16 {
        integrator.set_seed(seed);
        let light = radiance(&mut integrator, at + Vec3A::new(0.3, -0.4, 1.0), at);
        for (moment, k) in moments.iter_mut().zip([2, 14, 30]) {
            moment.push(f64::from(light.0[k]) * PI / 0.5);
        }
    }
    moments
}

/// `bias` is the relative error that interpolation may make.
fn assert_agrees(moments: &[Moments; 3], expected: [f64; 3], bias: f64, what: &str) {
    for (moment, expected) in moments.iter().zip(expected) {
        let (mean, error) = (moment.mean(), moment.standard_error());
        let off = ((mean - expected).abs() - bias * expected).max(0.0);
        let p = z_p_value(off / error.max(1e-30));
        assert!(p > sidak_level(1e-3, 3) || off <= 0.0, "{what}: {mean} ± {error} for {expected}");
    }
}

#[test]
fn level_ground_has_the_irradiance_of_the_model() {
    let sky = "[sky]\nsun = { elevation_deg = 35, azimuth_deg = 120 }\nturbidity = 4\nground_albedo = 0.3\n";
    let model = ClearSky::new(35.0, 4.0, &[0.3; WAVELENGTHS_NM.len()]).unwrap();
    let expected = [420.0, 540.0, 700.0]
        .map(|nm| 310.0 * (model.sun_irradiance(nm) * 35f64.to_radians().sin() + model.sky_irradiance(nm)));
    for (method, samples) in [("pcasnow", 64), ("hybrid", 64), ("reference", 256)] {
        let found = irradiance(&under(sky, method, ""), Vec3A::ZERO, samples);
        // The sun's profile is linear between 32 steps, and its elevation that of the centre.
        assert_agrees(&found, expected, 1e-3, method);
        assert!(found.iter().all(|one| one.standard_error() < 0.02 * one.mean()), "{method}: {found:?}");
    }
}

#[test]
fn an_overcast_sky_gives_the_irradiance_that_was_asked_for() {
    let sky = "[sky]\ntype = \"overcast\"\nirradiance_w_m2 = 100\nilluminant = \"E\"\n";
    let found = irradiance(&under(sky, "pcasnow", ""), Vec3A::ZERO, 64);
    assert_agrees(&found, [100.0; 3], 1e-5, "overcast");
    // Three times as bright at the zenith as at the horizon.
    let mut integrator = prepared(&under(sky, "pcasnow", ""), None);
    let mut look =
        |towards: Vec3A| f64::from(radiance(&mut integrator, Vec3A::new(0.0, 0.0, 2.0), Vec3A::Z * 2.0 + towards).0[9]);
    let zenith = look(Vec3A::new(1e-3, 0.0, 1.0));
    assert!((zenith / (100.0 * 9.0 / (7.0 * PI)) - 1.0).abs() < 1e-3, "{zenith}");
    assert!((look(Vec3A::new(1.0, 0.0, 1e-3)) / zenith - 1.0 / 3.0).abs() < 2e-3);
}

#[test]
fn the_edge_of_a_shadow_is_as_soft_as_the_sun_is_wide() {
    // A roof above x > 0, 10 m high, under the sun at the zenith, and a sky that is too faint to matter.
    let roof = "[[object]]\nshape = \"box\"\nsize = [20, 40, 0.02]\nposition = [10, 0, 10]\nmaterial = \"ground\"\n";
    let at = |x: f64| {
        let sky = "[sky]\nsun = { towards = [0, 0, 1] }\nturbidity = 1\nground_albedo = 0\n";
        let mut scene = under(sky, "pcasnow", roof);
        scene.set_max_bounces(Count::of(0));
        #[expect(clippy::cast_possible_truncation, reason = "a coordinate")]
        let light = irradiance(&scene, Vec3A::new(x as f32, 0.0, 0.0), 256);
        light[2].mean()
    };
    let penumbra_m = 10.0 * SUN_RADIUS_RAD;
    let (lit, half, dark) = (at(-1.1 * penumbra_m), at(0.0), at(1.1 * penumbra_m));
    // The sky lights all three nearly alike.
    assert!(((half - dark) / (lit - dark) - 0.5).abs() < 0.02, "{lit} {half} {dark}");
    let inner = (at(-0.6 * penumbra_m) - dark) / (lit - dark);
    // An even disc would show 1 − (arccos 0.6 − 0.6·0.8)/π = 0.858 of its light; with limb darkening more.
    assert!(inner > 0.865 && inner < 0.93, "{inner}");
}

#[test]
fn the_camera_sees_the_sun_where_it_stands() {
    let keys = [
        "elevation_deg = 30, azimuth_deg = 90",
        "towards = [1.7320508, 0, 1]",
        // The sun over Quito in the morning of an equinox.
        "latitude_deg = -0.18, longitude_deg = -78.47, date = \"2026-03-20\", time = \"08:20:50\", utc_offset_h = -5",
    ];
    for sun in keys {
        let mut integrator = prepared(&under(&format!("[sky]\nsun = {{ {sun} }}\n"), "pcasnow", ""), None);
        let mut look = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            #[expect(clippy::cast_possible_truncation, reason = "a direction")]
            let towards = Vec3A::new(cos as f32, 0.0, sin as f32);
            f64::from(radiance(&mut integrator, Vec3A::Z * 2.0, Vec3A::Z * 2.0 + towards * 10.0).0[15])
        };
        let (on, beside) = (look(30.0), look(31.0));
        assert!(on > 1000.0 * beside, "{sun}: {on} {beside}");
    }
    let hidden = under("[sky]\nsun = { elevation_deg = 30, azimuth_deg = 90 }\nvisible = false\n", "pcasnow", "");
    assert!(radiance(&mut prepared(&hidden, None), Vec3A::Z, Vec3A::new(1.7320508, 0.0, 2.0)).maximum() <= 0.0);
}

/// Grey ground is grey under the light that looks white, and not under others.
#[test]
fn white_balance_makes_ground_neutral() {
    let sun = "[sky]\nsun = { elevation_deg = 12, azimuth_deg = 120 }\n";
    let lamp = "[[light]]\ntype = \"directional\"\ndirection = [0, 0, -1]\nirradiance_w_m2 = 1\nilluminant = \"A\"\n";
    // D65 at 31 wavelengths is neutral within 0.4 %, and the sampled light of the sky has noise.
    for (lights, white, most) in [(sun, "sky", 0.02), (lamp, "sky", 0.005), (lamp, "A", 0.005), (sun, "D65", 0.0)] {
        let mut description = under(lights, "pcasnow", "").description().clone();
        description.film.white = white.parse().unwrap();
        description.camera.as_mut().unwrap().position = Numbers::of([0.0, -9.0, 5.0]);
        description.integrator.samples_per_pixel = Count::of(1024);
        let scene = description.build(&FilesInMemory::default()).unwrap();
        let film = render(&scene).unwrap().film;
        let LinearRgb { r, g, b } = LinearRgb::from_xyz(film.pixels()[0]);
        let off = (r / g - 1.0).abs().max((b / g - 1.0).abs());
        if most > 0.0 {
            assert!(off < most, "{white}: {r} {g} {b}");
        } else {
            assert!(off > 0.1, "{white}: {r} {g} {b}");
        }
    }
}

/// A white balance gives some wavelengths a negative part of a colour, which tables of colours cannot hold. The redder
/// the light that looks white, the bluer is snow by PCASnow.
#[test]
fn snow_by_pcasnow_is_seen_with_a_white_balance() {
    let lamp = "[[light]]\ntype = \"directional\"\ndirection = [0, 0, 1]\nirradiance_w_m2 = 1\nilluminant = \"A\"\n";
    let block = "[[object]]\nshape = \"box\"\nsize = [16, 16, 0.2]\nmaterial = \"snow\"\n";
    let redness = ["A", "D50", "D65"].map(|white| {
        let mut description = scene(&format!("{SNOW}{block}{lamp}"), &[]).description().clone();
        description.film.white = white.parse().unwrap();
        description.camera.as_mut().unwrap().position = Numbers::of([0.0, -1.0, 5.0]);
        let scene = description.build(&FilesInMemory::default()).unwrap();
        let film = render_all(&prepared(&scene, Some(&analytic_table())), &|_| {}).film;
        let LinearRgb { r, b, .. } = LinearRgb::from_xyz(film.pixels()[0]);
        r / b
    });
    assert!(0.0 < redness[0] && 1.1 * redness[0] < redness[1] && 1.1 * redness[1] < redness[2], "{redness:?}");
}

#[test]
fn mistakes_are_named() {
    let message = |sky: &str| {
        let text = format!(
            "[camera]\nposition = [0, -1, 1]\nlook_at = [0, 0, 0]\n[integrator]\ntype = \"pcasnow\"\n{GROUND}{sky}"
        );
        let file = snowblue_render::SceneFile::parse(text, "scene.toml");
        file.and_then(|file| file.build()).unwrap_err().to_string()
    };
    for (sky, expected) in [
        ("[sky]\n", "scene.toml:12: sky: missing field `sun`"),
        ("[sky]\ntype = \"cloudy\"\n", "scene.toml:13: sky.type is \"cloudy\", but must be one of clear, overcast"),
        (
            "[sky]\nsun = { elevation_deg = -3, azimuth_deg = 0 }\n",
            ": sky.sun elevation is -3°, but must lie in 0–90°: there is no model of twilight",
        ),
        ("[sky]\ntype = \"overcast\"\nsun = { elevation_deg = -3 }\n", ": sky.sun elevation is -3°, but must lie in"),
        ("[sky]\nsun = { elevation_deg = 30, latitude_deg = 3 }\n", "needs either `towards`, or `elevation_deg`"),
        ("[sky]\nsun = { towards = [0, 0, 0] }\n", "sky.sun.towards is [0, 0, 0], but must not be zero"),
        ("[sky]\nturbidity = 11\nsun = { elevation_deg = 30 }\n", "sky.turbidity is 11, but must lie in 1–10"),
        (
            "[sky]\nsun = { latitude_deg = 47, longitude_deg = 8, date = \"2026-02-30\", time = \"25:00\" }\n",
            "sky.sun.time is \"25:00\" on \"2026-02-30\"",
        ),
        (
            "[[light]]\ntype = \"point\"\nposition = [0, 0, 1]\nradiant_intensity_w_sr = 1\n[film]\nwhite = \"sky\"\n",
            "film.white is \"sky\", but there is no sky",
        ),
        ("[film]\nwhite = \"noon\"\n", "noon"),
        ("[sky]\ntype = \"overcast\"\n", "sky needs one of irradiance_w_m2, sun"),
        ("[sky]\ntype = \"overcast\"\nirradiance_w_m2 = 0\n", "sky.irradiance_w_m2 is 0"),
    ] {
        let found = message(sky);
        assert!(found.contains(expected) && !found.contains('\n'), "{sky}: {found}");
    }
}

#[test]
fn a_sky_is_written_as_it_is_read() {
    for sky in [
        "[sky]\nturbidity = 5\nground_albedo = 0.7\nscale = 2\nsun = { towards = [0, 1, 1] }\n",
        "[sky]\nsun = { latitude_deg = 47, longitude_deg = 8, date = \"2026-02-01\", time = \"12:00\" }\n",
        "[sky]\nsun = { latitude_deg = 47, longitude_deg = 8, date = 2026-02-01, time = 12:00:00 }\n",
        "[sky]\ntype = \"overcast\"\nsun = { elevation_deg = 10, azimuth_deg = 0 }\nvisible = false\n",
    ] {
        let read: SceneDescription = toml::from_str(&format!("{sky}{GROUND}")).unwrap();
        let again: SceneDescription = toml::from_str(&read.to_toml()).unwrap();
        assert!(read.sky.is_some() && read == again, "{}", read.to_toml());
    }
}

/// The radiance of black ground by its distance: towards the horizon it is the sky's, near by it is dark.
#[test]
fn air_hides_what_is_far_away() {
    let black =
        "[material.black]\ntype = \"diffuse\"\nreflectance = 0\n[[object]]\nshape = \"plane\"\nmaterial = \"black\"\n";
    let sky = "[sky]\nsun = { elevation_deg = 35, azimuth_deg = 180 }\nturbidity = 4\nground_albedo = 0.3\n\
               aerial_perspective = true\n";
    let model = ClearSky::new(35.0, 4.0, &[0.3; WAVELENGTHS_NM.len()]).unwrap();
    // Towards +x, across the direction of the sun.
    let horizon = |nm: f64| 310.0 * model.radiance(nm, 0.0, 0.0);
    for method in ["pcasnow", "hybrid", "reference"] {
        let mut integrator = prepared(&scene_by(method, &format!("{sky}{black}"), &[]), None);
        for x in [20.0, 2e3, 20e3] {
            let (eye, target) = (Vec3A::Z * 2.0, Vec3A::X * x);
            let seen = radiance(&mut integrator, eye, target);
            for (nm, k) in [(420.0, 2), (540.0, 14), (700.0, 30)] {
                let depth = air_extinction_per_m(4.0, nm) * f64::from(eye.distance(target));
                let expected = horizon(nm) * (1.0 - (-depth).exp());
                let error = f64::from(seen.0[k]) / expected - 1.0;
                // A direction in single precision leaves the distance an error of 1e-3 at 20 km.
                assert!(error.abs() < 2e-3, "{method}, {x} m, {nm} nm: {error}");
            }
        }
    }
}
