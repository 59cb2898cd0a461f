//! Light transmitted and reflected by slabs of snow, against T E / π and R E / π.

use std::f64::consts::PI;
use std::path::Path;

use glam::Vec3A;
use snowblue_base::Count;
use snowblue_database::PcaSnow;
use snowblue_render::scene::film::ImageSize;
use snowblue_render::scene::spectrum::{SAMPLES, Spectrum};

use crate::snow::{
    self, PointLamp, SNOW, analytic_table, computed_table, curves, integrator, load, pcasnow, point_light, prepared,
    radiance, scene, with_light_at,
};

/// Relative rounding error of about ten operations in single precision: distance, cosine, arc cosine, look-up and
/// exponential. The look-up multiplies its error by ln T, up to 12.
const ROUNDING: f64 = 3e-5;

/// A slab on the plane z = 0, wide enough to be infinite.
fn slab(thickness_m: f64, keys: &str) -> String {
    format!(
        "{}{SNOW}[[object]]\nshape = \"box\"\nsize = [100, 100, {thickness_m}]\nposition = [0, 0, {}]\n\
         material = \"snow\"\n[[light]]\ntype = \"point\"\nposition = [0.1, -0.2, -0.8]\nradiant_intensity_w_sr = 10\n",
        pcasnow(keys),
        0.5 * thickness_m
    )
}

fn transmittance(curves: &PcaSnow, thickness_cm: f64, angle_deg: f64) -> [f32; SAMPLES] {
    let mut values = [0.0; SAMPLES];
    curves.transmittance(thickness_cm as f32, angle_deg as f32, &mut values);
    values
}

fn reflectance(curves: &PcaSnow, thickness_cm: f64, angle_deg: f64) -> [f32; SAMPLES] {
    let mut values = [0.0; SAMPLES];
    curves.reflectance(thickness_cm as f32, angle_deg as f32, &mut values);
    values
}

/// Angle in degrees and irradiance per radiant intensity of a light at a point of a plane z = const.
fn arrival(light: &PointLamp, point: Vec3A) -> (f64, f64) {
    let to_light = (light.position - point).as_dvec3();
    let cos = to_light.z.abs() / to_light.length();
    (cos.acos().to_degrees(), cos / to_light.length_squared())
}

fn assert_close(seen: &Spectrum, expected: [f64; SAMPLES], what: &str) {
    for (k, (&one, other)) in seen.0.iter().zip(expected).enumerate() {
        assert!((f64::from(one) / other - 1.0).abs() < ROUNDING, "{what}, sample {k}: {one} for {other}");
    }
}

#[test]
fn a_slab_transmits_t_e_over_pi_in_every_direction() {
    let table = computed_table();
    let curves = curves(&table);
    for thickness_m in [0.05, 0.3] {
        let mut integrator = integrator(&slab(thickness_m, "path = \"normal\""), Some(&table), &[]);
        for (x, y) in [(0.0, 0.0), (0.1, -0.2), (0.7, 0.3), (-1.5, 2.0), (9.0, 0.0)] {
            let top = Vec3A::new(x, y, thickness_m as f32);
            let lamp = point_light(integrator.scene());
            let (angle_deg, per_intensity) = arrival(&lamp, Vec3A::new(x, y, 0.0));
            let fraction = transmittance(&curves, 100.0 * thickness_m, angle_deg);
            let intensity = lamp.intensity;
            let expected =
                std::array::from_fn(|k| f64::from(fraction[k]) * f64::from(intensity.0[k]) * per_intensity / PI);
            for eye in [Vec3A::new(0.0, 0.0, 2.0), Vec3A::new(3.0, -1.0, 0.5), Vec3A::new(x - 4.0, y, 0.4)] {
                assert_close(
                    &radiance(&mut integrator, eye, top),
                    expected,
                    &format!("{thickness_m} m at {x}, {y} from {eye}"),
                );
            }
        }
    }
}

#[test]
fn the_brightest_path_through_a_slab_from_a_distant_light_is_the_normal_path() {
    let table = computed_table();
    let [mut brightest, mut normal] = ["", "path = \"normal\""].map(|keys| {
        let scene = with_light_at(&scene(&slab(0.3, keys), &[]), Vec3A::new(3.0, 0.0, -40.0), &[]);
        prepared(&scene, Some(&table))
    });
    for x in [-3.0, 0.0, 1.0] {
        let (eye, target) = (Vec3A::new(0.5, 0.5, 3.0), Vec3A::new(x, 0.2, 0.3));
        assert_eq!(radiance(&mut brightest, eye, target), radiance(&mut normal, eye, target));
    }
}

#[test]
fn reflectance_of_front_light_is_that_of_the_depth_behind() {
    let table = computed_table();
    let curves = curves(&table);
    for path in ["normal", "light", "brightest"] {
        let mut scene = scene(&slab(0.04, &format!("path = \"{path}\"")), &[]);
        let above = point_light(&scene).position.with_z(1.0);
        scene = with_light_at(&scene, above, &[]);
        let mut integrator = prepared(&scene, Some(&table));
        for (x, y) in [(0.0, 0.0), (1.5, -0.3), (-6.0, 2.0)] {
            let top = Vec3A::new(x, y, 0.04);
            let (angle_deg, per_intensity) = arrival(&point_light(&scene), top);
            let fraction = reflectance(&curves, 4.0, angle_deg);
            let intensity = point_light(&scene).intensity;
            let expected =
                std::array::from_fn(|k| f64::from(fraction[k]) * f64::from(intensity.0[k]) * per_intensity / PI);
            assert_close(&radiance(&mut integrator, Vec3A::new(1.0, 2.0, 3.0), top), expected, path);
        }
    }
}

#[test]
fn a_slab_conserves_energy() {
    let table = computed_table();
    for thickness_m in [0.001, 0.01, 0.1, 0.5] {
        let mut integrator = integrator(&slab(thickness_m, "path = \"normal\""), Some(&table), &[]);
        for x in [0.1, 0.5, 1.5, 4.0, 20.0] {
            let (below, above) = (Vec3A::new(x, -0.2, 0.0), Vec3A::new(x, -0.2, thickness_m as f32));
            let reflected = radiance(&mut integrator, Vec3A::new(1.0, 0.0, -2.0), below);
            let through = radiance(&mut integrator, Vec3A::new(1.0, 0.0, 2.0), above);
            let lamp = point_light(integrator.scene());
            let (_, per_intensity) = arrival(&lamp, below);
            let intensity = lamp.intensity;
            for k in 0..SAMPLES {
                let given = f64::from(intensity.0[k]) * per_intensity;
                let returned = PI * f64::from(reflected.0[k] + through.0[k]);
                // Thin snow hardly absorbs, and the compressed table has an error of R + T of a few parts in 1e3.
                assert!(returned < 1.004 * given, "{thickness_m} m, x = {x}, sample {k}: {}", returned / given);
                assert!(returned > 0.5 * given, "{thickness_m} m, x = {x}, sample {k}: {}", returned / given);
            }
        }
    }
}

#[test]
fn radiance_of_a_light_inside_snow_falls_with_the_squared_distance() {
    let table = analytic_table();
    for path in ["light", "brightest"] {
        let scene = scene(&slab(0.5, &format!("path = \"{path}\"")), &[]);
        let mut integrator = prepared(&with_light_at(&scene, Vec3A::new(0.0, 0.0, 0.2), &[]), Some(&table));
        for x in [0.0f32, 0.2, 0.6] {
            let distance_m = f64::from(x).hypot(0.3);
            let intensity = point_light(integrator.scene()).intensity;
            let expected = std::array::from_fn(|k| {
                let fraction = (-snow::extinction_per_cm(k) * 100.0 * distance_m).exp();
                fraction * f64::from(intensity.0[k]) / (PI * distance_m * distance_m)
            });
            let seen = radiance(&mut integrator, Vec3A::new(0.3, 0.1, 2.0), Vec3A::new(x, 0.0, 0.5));
            assert_close(&seen, expected, path);
        }
    }
}

#[test]
fn an_opaque_object_behind_snow_occludes_the_light() {
    let table = analytic_table();
    let screen = "[material.black]\ntype = \"diffuse\"\nreflectance = 0\n[[object]]\nshape = \"box\"\n\
        size = [1, 1, 0.01]\nposition = [0.1, -0.2, -0.4]\nmaterial = \"black\"\n";
    let (eye, target) = (Vec3A::new(0.3, 0.1, 2.0), Vec3A::new(0.1, 0.0, 0.3));
    let mut shaded = integrator(&(slab(0.3, "path = \"normal\"") + screen), Some(&table), &[]);
    assert_eq!(radiance(&mut shaded, eye, target), Spectrum::ZERO);
}

#[test]
fn radiance_of_the_shipped_block_is_continuous_across_edges_and_nowhere_0() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/block_30cm.toml");
    let mut scene = load(&shipped);
    scene.set_image_size(ImageSize { width: 1, height: 1 });
    scene.set_samples_per_pixel(Count::of(1));
    scene.set_max_bounces(Count::of(0));
    let mut integrator = prepared(&scene, Some(&computed_table()));
    let eye = Vec3A::new(1.2, -1.6, 0.7);
    for height_m in [0.02, 0.2, 0.4, 0.59] {
        // Over the front and, from the edge at 0.6 m on, over the side, in steps of 0.5 mm.
        let mut before: Option<f64> = None;
        for step in 0..1750 {
            let along_m = (step as f32 + 0.5) * 0.0005;
            let target = if along_m < 0.6 {
                Vec3A::new(along_m - 0.3, -0.15, height_m)
            } else {
                Vec3A::new(0.3, along_m - 0.75, height_m)
            };
            let now = radiance(&mut integrator, eye, target).mean();
            assert!(now > 0.01, "{now} at {target}");
            if let Some(before) = before {
                // The steepest rise is at the far end, where the depth falls from 2 cm to 1.9 cm: about 2 % per step.
                let ratio = now / before;
                assert!((0.97..1.03).contains(&ratio), "{ratio} at {target}");
            }
            before = Some(now);
        }
    }
}
