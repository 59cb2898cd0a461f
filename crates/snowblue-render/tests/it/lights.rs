//! Area lights and skies against closed forms, directly and through snow.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::Vec3A;
use snowblue_base::Count;
use snowblue_color::LinearRgb;
use snowblue_render::film::Film;
use snowblue_render::film::channels::channels;
use snowblue_render::film::image_file::write_exr;
use snowblue_render::render::{RenderControl, accumulator, all_samples, render_missing};
use snowblue_render::scene::film::ImageSize;
use snowblue_render::scene::light::Panorama;
use snowblue_render::scene::spectrum::light_spectrum::LightSpectrum;
use snowblue_render::{Aovs, Integrator};
use snowblue_stat::{Moments, sidak_level, z_p_value};

use crate::snow::{SNOW, analytic_table, extinction_per_cm, integrator, pcasnow, prepared, radiance, scene, scene_by};

/// Thickness of the slab, in cm.
const DEPTH_CM: f64 = 20.0;

/// A slab on the plane z = 0 with reflectance 0, and its lights, for PCASnow with some keys.
fn slab(keys: &str, lights: &str) -> Integrator {
    let text = format!(
        "{}{SNOW}[[object]]\nshape = \"box\"\nsize = [1000, 1000, 0.2]\nposition = [0, 0, 0.1]\n\
         material = \"snow\"\n{lights}",
        pcasnow(&format!("reflectance = 0\n{keys}"))
    );
    integrator(&text, Some(&analytic_table()), &[])
}

fn sky(illuminant: &str) -> String {
    format!("[environment]\nradiance_w_m2_sr = 1\nilluminant = \"{illuminant}\"\n")
}

/// 10 nm times the sum of the spectral channels is the power of the light.
#[test]
fn spectral_channels_add_up_to_the_power() {
    for illuminant in ["E", "A", "D65"] {
        let integrator = integrator(&format!("{}{}", pcasnow(""), sky(illuminant)), Some(&analytic_table()), &[]);
        let (scene, aovs) = (integrator.scene(), Aovs { spectrum: true, ..Aovs::default() });
        let mut sums = accumulator(scene, aovs, &all_samples(scene).window());
        render_missing(&integrator, &all_samples(scene), &mut sums, RenderControl::default());
        let spectral = channels(&sums).into_iter().filter(|channel| channel.name.starts_with("S0."));
        let values: Vec<f32> = spectral.map(|channel| channel.values[0]).collect();
        assert_eq!(values.len(), 31);
        let total = 10.0 * values.iter().sum::<f32>();
        assert!((total - 1.0).abs() < 1e-5, "{illuminant}: {total}");
    }
}

/// Moments of 16 independent images of one pixel, at three wavelengths.
fn repeated(integrator: &mut Integrator, eye: Vec3A, target: Vec3A, samples: u32) -> [Moments; 3] {
    integrator.set_samples_per_pixel(samples);
    let mut moments = [Moments::default(); 3];
    for seed in 1..=16 {
        integrator.set_seed(seed);
        let light = radiance(integrator, eye, target);
        for (moment, k) in moments.iter_mut().zip([0, 15, 30]) {
            moment.push(f64::from(light.0[k]));
        }
    }
    moments
}

/// Tests the means at a level of 1e-3 for all three. `exact` is the relative rounding error of an exact result.
fn assert_agrees(moments: &[Moments; 3], expected: [f64; 3], exact: f64, what: &str) {
    for (moment, expected) in moments.iter().zip(expected) {
        let off = (moment.mean() - expected).abs();
        // A normal distribution is close enough to t with 15 degrees of freedom: Sobol points make errors far smaller.
        let p = z_p_value(off / moment.standard_error().max(1e-30));
        let (mean, error) = (moment.mean(), moment.standard_error());
        assert!(off < exact * expected || p > sidak_level(1e-3, 3), "{what}: {mean} ± {error} for {expected}");
    }
}

/// 2 ∫ T(θ) cos θ sin θ dθ by the midpoint rule, for the analytic T over `length(θ)` in cm.
fn diffuse_transmittance(k: usize, length_cm: impl Fn(f64) -> f64) -> f64 {
    let steps = 20_000;
    let term = |step: i32| {
        let angle = (f64::from(step) + 0.5) * FRAC_PI_2 / f64::from(steps);
        let transmittance =
            (-extinction_per_cm(k) * length_cm(angle) * (1.0 + angle.to_degrees().min(89.0) / 100.0)).exp();
        2.0 * transmittance * angle.cos() * angle.sin()
    };
    (0..steps).map(term).sum::<f64>() * FRAC_PI_2 / f64::from(steps)
}

#[test]
fn a_slab_under_a_uniform_sky_has_its_diffuse_transmittance() {
    let (eye, target) = (Vec3A::new(2.0, 0.0, 1.2), Vec3A::new(0.0, 0.0, 0.2));
    let cos_view = 1.0 / 5f64.sqrt();
    for (path, seen_along) in [("normal", 1.0), ("brightest", 1.0), ("view", cos_view)] {
        let expected = [0, 15, 30].map(|k| diffuse_transmittance(k, |_| DEPTH_CM / seen_along));
        let mut slab = slab(&format!("path = \"{path}\""), &sky("E"));
        assert_agrees(&repeated(&mut slab, eye, target, 256), expected, 1e-4, path);
    }
    // On lines to the sky the depth grows with the angle. The table ends at 1 m of snow.
    let expected = [0, 15, 30].map(|k| diffuse_transmittance(k, |angle| (DEPTH_CM / angle.cos()).min(100.0)));
    let found = repeated(&mut slab("path = \"light\"", &sky("E")), eye, target, 1024);
    for (moment, expected) in found.iter().zip(expected) {
        // Beyond 1 m, from 78° on, the table is extrapolated. These directions contribute less than 3 %.
        assert!((moment.mean() / expected - 1.0).abs() < 0.03, "light: {moment:?} for {expected}");
    }
}

#[test]
fn a_white_image_sky_is_a_uniform_sky_of_daylight() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("white.exr");
    let white = LinearRgb { r: 1.0, g: 1.0, b: 1.0 }.xyz();
    write_exr(&Film::new(ImageSize { width: 16, height: 8 }, vec![white; 128]), &[], &path).unwrap();
    let image = format!("[environment]\nimage = \"{}\"\nscale = 2\n", path.display());
    let shape = LightSpectrum::illuminant("D65".parse().unwrap()).unwrap().relative;
    for (path, samples) in [("normal", 256), ("brightest", 256)] {
        let mut slab = slab(&format!("path = \"{path}\""), &image);
        let expected = [0, 15, 30].map(|k| 2.0 * diffuse_transmittance(k, |_| DEPTH_CM) * f64::from(shape.0[k]));
        let found = repeated(&mut slab, Vec3A::new(2.0, 0.0, 1.2), Vec3A::new(0.0, 0.0, 0.2), samples);
        assert_agrees(&found, expected, 1e-3, path);
    }
}

/// Luminance alone is grey; luminance with chroma, or depth, is no sky.
#[test]
fn a_sky_of_luminance_alone_is_grey_and_other_channels_are_named() {
    use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, channels: &[&str]| {
        let path = folder.path().join(name);
        let channel = |name: &&str| AnyChannel::new(*name, FlatSamples::F32((0..8).map(|k| k as f32).collect()));
        let channels = AnyChannels::sort(channels.iter().map(channel).collect());
        Image::from_channels((4, 2), channels).write().to_file(&path).unwrap();
        Panorama::read(&|path: &str| std::fs::read(path), path.to_str().unwrap(), None, None)
    };
    let grey = write("grey.exr", &["Y"]).unwrap();
    assert_eq!((grey.width, grey.height), (4, 2));
    for (k, pixel) in grey.pixels.iter().enumerate() {
        let value = k as f64;
        assert_eq!(*pixel, LinearRgb { r: value, g: value, b: value });
    }
    assert_eq!(write("grey_alpha.exr", &["A", "Y"]).unwrap(), grey);
    for (channels, found) in [(&["Y", "RY", "BY"][..], "BY, RY, Y"), (&["Z"], "Z"), (&["R", "G"], "G, R")] {
        let message = write("other.exr", channels).unwrap_err().to_string();
        let expected = format!("the channels are {found}, but must include R, G and B, or be Y alone");
        assert!(message.contains("other.exr") && message.contains(&expected), "{message}");
    }
}

#[test]
fn a_convex_box_under_a_white_sky_has_the_radiance_of_its_reflectance() {
    let floor = "[material.grey]\ntype = \"diffuse\"\nreflectance = 0.7\n\
        [[object]]\nshape = \"box\"\nsize = [1, 2, 3]\nrotation_deg = [20, 30, 40]\nmaterial = \"grey\"\n";
    let mut scene = scene(&format!("{floor}{}", sky("E")), &[]);
    for max_bounces in [0, 5] {
        scene.set_max_bounces(Count::of(max_bounces));
        let mut integrator = prepared(&scene, None);
        for eye in [Vec3A::new(5.0, 1.0, 2.0), Vec3A::new(-3.0, 4.0, -4.0)] {
            // A single path is exact: rays from a convex body reach the sky.
            let surface = radiance(&mut integrator, eye, Vec3A::ZERO);
            let beyond = radiance(&mut integrator, eye, eye * 2.0);
            for k in 0..31 {
                assert!((surface.0[k] - 0.7).abs() < 1e-6 && (beyond.0[k] - 1.0).abs() < 1e-6);
            }
        }
    }
}

#[test]
fn a_wide_slab_under_a_sky_has_r_plus_diffuse_t() {
    let text = format!(
        "{SNOW}[[object]]\nshape = \"box\"\nsize = [1000, 1000, 0.01]\nposition = [0, 0, -1]\n\
         material = \"snow\"\n{}",
        sky("E")
    );
    let mut slab = integrator(&text, Some(&analytic_table()), &[]);
    let expected = [0, 15, 30].map(|k| 0.25 + diffuse_transmittance(k, |_| 1.0));
    let found = repeated(&mut slab, Vec3A::new(1.0, 0.0, 0.0), Vec3A::NEG_Z, 256);
    assert_agrees(&found, expected, 1e-4, "furnace");
}

#[test]
fn small_area_lights_equal_point_lights_through_snow() {
    let point =
        "[[light]]\ntype = \"point\"\nposition = [0.1, -0.2, -0.8]\nilluminant = \"A\"\nradiant_intensity_w_sr = ";
    // I = L A with A the projected area. The rectangle faces the exit.
    let ball = "type = \"sphere\"\nradius = 0.004";
    let panel = |exit: &str| format!("type = \"rectangle\"\nsize = [0.008, 0.005]\nlook_at = {exit}");
    let (eye, target) = (Vec3A::new(2.0, 0.5, 1.2), Vec3A::new(0.3, 0.2, 0.2));
    for (path, lamp, area_m2) in [
        ("normal", ball.to_owned(), PI * 1.6e-5),
        ("light", ball.to_owned(), PI * 1.6e-5),
        ("brightest", ball.to_owned(), PI * 1.6e-5),
        ("normal", panel("[0.3, 0.2, 0.0]"), 4e-5),
        ("light", panel("[0.3, 0.2, 0.2]"), 4e-5),
    ] {
        let keys = format!("path = \"{path}\"");
        let extended =
            format!("[[light]]\n{lamp}\nposition = [0.1, -0.2, -0.8]\nilluminant = \"A\"\nradiance_w_m2_sr = 1e5\n");
        let single = radiance(&mut slab(&keys, &format!("{point}{}\n", 1e5 * area_m2)), eye, target);
        let found = repeated(&mut slab(&keys, &extended), eye, target, 64);
        for (moment, k) in found.iter().zip([0, 15, 30]) {
            let ratio = moment.mean() / f64::from(single.0[k]);
            // `normal`: the error is of the order (4 mm / 92 cm)². `light`: the near side of the sphere is up to R
            // closer to both ends of the line, which changes the ratio of squared distances by up to 2 R (1/92 cm −
            // 1/110 cm) = 1.5e-3. `brightest`: the part of the sphere that is visible from one of the two exits only
            // adds (1 − cos δ)/2 = 2e-3, where δ is the angle between them.
            let most = match path {
                "normal" => 1e-4,
                "light" => 1.5e-3,
                _ => 3.5e-3,
            };
            assert!((ratio - 1.0).abs() < most, "{path} {lamp}: {ratio}");
        }
    }
}

#[test]
fn irradiance_of_a_directional_light_is_proportional_to_the_cosine() {
    let sun = "[[light]]\ntype = \"directional\"\ndirection = [0.6, 0, 0.8]\nirradiance_w_m2 = 3\nilluminant = \"E\"\n";
    for path in ["normal", "brightest"] {
        let light = radiance(
            &mut slab(&format!("path = \"{path}\""), sun),
            Vec3A::new(0.0, 1.0, 2.0),
            Vec3A::new(0.0, 0.0, 0.2),
        );
        let angle_deg = 0.8f64.acos().to_degrees();
        for k in [0, 15, 30] {
            let expected = 3.0 * 0.8 / PI * (-extinction_per_cm(k) * DEPTH_CM * (1.0 + angle_deg / 100.0)).exp();
            assert!((f64::from(light.0[k]) / expected - 1.0).abs() < 3e-5, "{path}: {} for {expected}", light.0[k]);
        }
    }
}

#[test]
fn area_lights_are_visible_unless_visible_is_false() {
    let lamp =
        "[[light]]\ntype = \"sphere\"\nposition = [0, 0, 3]\nradius = 0.5\nilluminant = \"E\"\nradiance_w_m2_sr = 4\n";
    let (eye, target) = (Vec3A::new(0.0, -3.0, 3.0), Vec3A::new(0.0, 0.0, 3.0));
    let mut visible = slab("", lamp);
    assert!((radiance(&mut visible, eye, target).0[15] - 4.0).abs() < 1e-5);
    assert!(radiance(&mut visible, eye, Vec3A::new(0.0, 0.0, 3.6)).0[15] < 1e-6, "beside the light");
    let below = Vec3A::new(0.0, -3.0, -3.0);
    assert!(radiance(&mut visible, below, target).0[15] < 0.1, "the slab occludes it");
    let mut hidden = slab("", &format!("{lamp}visible = false\n"));
    assert!(radiance(&mut hidden, eye, target).0[15] < 1e-6);
}

#[test]
fn the_radiance_of_a_half_buried_light_is_bounded() {
    let lamp = "[[light]]\ntype = \"sphere\"\nposition = [0, 0, 0.2]\nradius = 0.05\nilluminant = \"E\"\n\
        radiance_w_m2_sr = 1\nvisible = false\n";
    for path in ["light", "brightest"] {
        let mut slab = slab(&format!("path = \"{path}\""), lamp);
        for target in [Vec3A::new(0.0, 0.0, 0.0), Vec3A::new(0.2, 0.1, 0.0), Vec3A::new(0.06, 0.0, 0.2)] {
            let eye = target + Vec3A::new(0.3, 0.2, if target.z > 0.1 { 2.0 } else { -2.0 });
            for moment in repeated(&mut slab, eye, target, 16) {
                // E is at most π L from the half outside the snow and π L from the half inside.
                assert!(moment.mean() < 2.0 && moment.variance().sqrt() < 0.5, "{path} at {target}: {moment:?}");
            }
        }
    }
}

/// A light on a wall and one 1e-5 m before it illuminate the floor equally and look the same.
#[test]
fn a_wall_does_not_occlude_a_light_on_it() {
    let room = |gap_m: f32| {
        format!(
            "[material.grey]\ntype = \"diffuse\"\nreflectance = 0.5\n[[object]]\nshape = \"box\"\nsize = [4, 1, 4]\n\
             position = [0, 1.5, 2]\nmaterial = \"grey\"\n[[object]]\nshape = \"plane\"\nmaterial = \"grey\"\n\
             [[light]]\ntype = \"rectangle\"\nposition = [0, {}, 1]\nlook_at = [0, -1, 1]\nsize = [1, 1]\n\
             illuminant = \"E\"\nradiance_w_m2_sr = 1\n",
            1.0 - gap_m
        )
    };
    let [on, before] = [0.0, 1e-5].map(|gap_m| {
        let mut scene = scene(&room(gap_m), &[]);
        scene.set_max_bounces(Count::of(1));
        let mut room = prepared(&scene, None);
        let lamp = radiance(&mut room, Vec3A::new(0.0, -1.0, 1.0), Vec3A::new(0.2, 1.0, 1.1));
        assert!(lamp.0[15] >= 1.0 - 1e-6, "the light, and the reflection of its wall: {lamp:?}");
        repeated(&mut room, Vec3A::new(0.0, -1.0, 1.0), Vec3A::new(0.1, 0.7, 0.0), 4096)
    });
    for (on, before) in on.iter().zip(&before) {
        let error = on.standard_error().hypot(before.standard_error());
        // The gap changes the solid angle by about 1e-5 / 0.3.
        assert!((on.mean() - before.mean()).abs() < 4.0 * error + 1e-4 * on.mean(), "{on:?} {before:?}");
    }
}

/// A rectangle just below the surface of snow.
#[test]
fn snow_does_not_increase_the_radiance_of_a_light_inside() {
    for depth_m in [1e-4, 1e-3, 5e-3] {
        let lamp = format!(
            "[[light]]\ntype = \"rectangle\"\nposition = [0, 0, {depth_m}]\nlook_at = [0, 0, -1]\nup = [0, 1, 0]\n\
             size = [0.3, 0.3]\nilluminant = \"E\"\nradiance_w_m2_sr = 1\nvisible = false\n"
        );
        let mut slab = slab("path = \"brightest\"", &lamp);
        for moment in repeated(&mut slab, Vec3A::new(0.1, 0.1, -1.0), Vec3A::ZERO, 256) {
            assert!(moment.mean() < 1.0 + 4.0 * moment.standard_error(), "{depth_m} m: {moment:?}");
        }
    }
}

/// A small sun in an image of the sky gives most of the light of a floor. Rays find it once in 180 times.
#[test]
fn a_small_sun_in_an_image_lights_a_floor_as_its_pixels_say() {
    const WIDTH: u32 = 64;
    const HEIGHT: u32 = 32;
    let value = |row: u32, column: u32| match (row, column) {
        (9 | 10, 30 | 31) => 3000.0,
        (0..16, _) => 0.3,
        _ => 0.0,
    };
    let pixel = |number: u32| {
        let value = value(number / WIDTH, number % WIDTH);
        LinearRgb { r: value, g: value, b: value }.xyz()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sunny.exr");
    let film = Film::new(ImageSize { width: WIDTH, height: HEIGHT }, (0..WIDTH * HEIGHT).map(pixel).collect());
    write_exr(&film, &[], &path).unwrap();
    // The sum over the pixels of the radiance, the cosine and the solid angle, over π and times the reflectance. The
    // interpolation between pixels moves light by a sixth of the square of a pixel, (π/32)², in rad²: 0.2 %.
    let share = |row: u32| {
        let polar = PI * (f64::from(row) + 0.5) / f64::from(HEIGHT);
        polar.cos() * polar.sin() * (PI / f64::from(HEIGHT)).powi(2)
    };
    let places = (0..HEIGHT / 2).flat_map(|row| (0..WIDTH).map(move |column| (row, column)));
    let irradiance: f64 = places.map(|(row, column)| value(row, column) * share(row)).sum();
    let shape = LightSpectrum::illuminant("D65".parse().unwrap()).unwrap().relative;
    let expected = [0, 15, 30].map(|k| 0.5 * irradiance / PI * f64::from(shape.0[k]));
    for method in ["reference", "hybrid"] {
        let text = format!(
            "[material.grey]\ntype = \"diffuse\"\nreflectance = 0.5\n\
             [[object]]\nshape = \"plane\"\nmaterial = \"grey\"\n[environment]\nimage = \"{}\"\n",
            path.display()
        );
        let mut floor = prepared(&scene_by(method, &text, &[]), None);
        let found = repeated(&mut floor, Vec3A::new(2.0, 0.0, 1.2), Vec3A::ZERO, 64);
        assert_agrees(&found, expected, 5e-3, method);
        // By chance, a sample has a standard deviation of 13 times the mean, and the mean of 1,024 an error of 0.4.
        for moment in &found {
            assert!(moment.standard_error() < 0.01 * moment.mean(), "{method}: {moment:?}");
        }
    }
}
