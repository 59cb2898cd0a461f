//! A slab under every kind of light: L = T E / π within noise, for the path modes that are exact for a slab.
//!
//! The transmittance is analytic, so ∫ T(θ) L cos θ dω over a light is a smooth integral. The midpoint rule evaluates
//! it over the surface of the light, independently of the renderer's sampling.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, Vec3A};
use snowblue_render::scene::spectrum::light_spectrum::LightSpectrum;
use snowblue_stat::sidak_level;

use crate::snow::{Estimate, SNOW, analytic_table, estimate, extinction_per_cm, integrator, pcasnow};

/// Thickness of the slab on the plane z = 0, in m.
const THICKNESS_M: f64 = 0.2;

/// Indices of the first, middle and last wavelength.
const BANDS: [usize; 3] = [0, 15, 30];

/// Probability of a false alarm, over random seeds.
const LEVEL: f64 = 1e-3;

/// A light of D65, as scene text and as a formula.
struct Case {
    name: &'static str,
    light: &'static str,
    /// Path modes that are exact under this light.
    paths: &'static [&'static str],
    /// ∫ T(θ) dE from below at a point of the plane z = 0, per unit of the light's power; T takes θ in degrees.
    transmitted: fn(DVec3, &dyn Fn(f64) -> f64) -> f64,
    /// Power in the unit of the scene text.
    power: f64,
}

const CASES: [Case; 6] = [
    Case {
        name: "point",
        light: "[[light]]\ntype = \"point\"\nposition = [0.1, -0.2, -0.8]\nradiant_intensity_w_sr = 10\n",
        paths: &["normal", "view"],
        transmitted: |exit, transmittance| {
            let to_light = DVec3::new(0.1, -0.2, -0.8) - exit;
            from_direction(to_light, transmittance) / to_light.length_squared()
        },
        power: 10.0,
    },
    Case {
        name: "directional",
        light: "[[light]]\ntype = \"directional\"\ndirection = [0.6, 0, 0.8]\nirradiance_w_m2 = 3\n",
        paths: &["normal", "view", "brightest"],
        transmitted: |_, transmittance| from_direction(DVec3::new(-0.6, 0.0, -0.8), transmittance),
        power: 3.0,
    },
    Case {
        name: "sphere",
        light: "[[light]]\ntype = \"sphere\"\nposition = [0.3, 0.2, -1]\nradius = 0.5\nradiance_w_m2_sr = 2\n",
        paths: &["normal", "view"],
        transmitted: |exit, transmittance| from_sphere(exit, DVec3::new(0.3, 0.2, -1.0), 0.5, transmittance),
        power: 2.0,
    },
    Case {
        // So far away that on lines to the light the depth grows faster than the distance decreases.
        name: "distant sphere",
        light: "[[light]]\ntype = \"sphere\"\nposition = [4, 3, -30]\nradius = 3\nradiance_w_m2_sr = 20\n",
        paths: &["normal", "view", "brightest"],
        transmitted: |exit, transmittance| from_sphere(exit, DVec3::new(4.0, 3.0, -30.0), 3.0, transmittance),
        power: 20.0,
    },
    Case {
        name: "rectangle",
        light: "[[light]]\ntype = \"rectangle\"\nposition = [0.4, -0.3, -0.7]\nlook_at = [0.4, -0.3, 0]\n\
            up = [0, 1, 0]\n\
            size = [1.2, 0.5]\nradiance_w_m2_sr = 2\n",
        paths: &["normal", "view"],
        transmitted: |exit, transmittance| from_rectangle(exit, DVec3::new(0.4, -0.3, -0.7), 1.2, 0.5, transmittance),
        power: 2.0,
    },
    Case {
        name: "sky",
        light: "[environment]\nradiance_w_m2_sr = 1\n",
        paths: &["normal", "view", "brightest"],
        transmitted: |_, transmittance| {
            let steps = 20_000;
            let term = |step: i32| {
                let angle = (f64::from(step) + 0.5) * FRAC_PI_2 / f64::from(steps);
                TAU * transmittance(angle.to_degrees()) * angle.cos() * angle.sin()
            };
            (0..steps).map(term).sum::<f64>() * FRAC_PI_2 / f64::from(steps)
        },
        power: 1.0,
    },
];

/// T(θ) cos θ for light from a direction, which need not be normalized.
fn from_direction(to_light: DVec3, transmittance: &dyn Fn(f64) -> f64) -> f64 {
    let cos = -to_light.z / to_light.length();
    transmittance(cos.acos().to_degrees()) * cos
}

/// The integral over the cone of directions to a sphere.
fn from_sphere(exit: DVec3, centre: DVec3, radius_m: f64, transmittance: &dyn Fn(f64) -> f64) -> f64 {
    let (rings, turns) = (400, 96);
    let axis = (centre - exit).normalize();
    let (side, ahead) = axis.any_orthonormal_pair();
    let least_cos = (1.0 - radius_m * radius_m / centre.distance_squared(exit)).sqrt();
    let mut sum = 0.0;
    for ring in 0..rings {
        let cos = 1.0 - (1.0 - least_cos) * (f64::from(ring) + 0.5) / f64::from(rings);
        let sin = (1.0 - cos * cos).sqrt();
        for turn in 0..turns {
            let (up, across) = (TAU * f64::from(turn) / f64::from(turns)).sin_cos();
            sum += from_direction(axis * cos + side * (sin * across) + ahead * (sin * up), transmittance);
        }
    }
    sum * TAU * (1.0 - least_cos) / f64::from(rings * turns)
}

/// The integral over a horizontal rectangle that emits upwards, `width_m` along x.
fn from_rectangle(exit: DVec3, centre: DVec3, width_m: f64, depth_m: f64, transmittance: &dyn Fn(f64) -> f64) -> f64 {
    let (across, along) = (240, 100);
    let mut sum = 0.0;
    for i in 0..across {
        for j in 0..along {
            let (u, v) = ((f64::from(i) + 0.5) / f64::from(across), (f64::from(j) + 0.5) / f64::from(along));
            let to_light = centre + DVec3::new((u - 0.5) * width_m, (v - 0.5) * depth_m, 0.0) - exit;
            sum +=
                from_direction(to_light, transmittance) * -to_light.z / (to_light.length() * to_light.length_squared());
        }
    }
    sum * width_m * depth_m / f64::from(across * along)
}

/// Points of the upper side at various distances from the lights, each with a camera position above it.
fn points() -> impl Iterator<Item = (Vec3A, Vec3A)> {
    (0..12).map(|k| {
        let (sin, cos) = (2.399_963 * k as f32).sin_cos();
        let radius = 0.03 * 1.5f32.powi(k);
        let top = Vec3A::new(radius * cos, radius * sin, THICKNESS_M as f32);
        (top, top + Vec3A::new(0.3 * sin * k as f32, 0.2 * cos * k as f32, 1.0))
    })
}

#[test]
fn a_slab_has_its_analytic_radiance_under_every_light() {
    let tests: usize = CASES.iter().map(|case| case.paths.len() * points().count() * BANDS.len()).sum();
    let level = sidak_level(LEVEL, tests);
    let unit = LightSpectrum::illuminant("D65".parse().unwrap()).unwrap().unit;
    for case in &CASES {
        for path in case.paths {
            let text = format!(
                "{}{SNOW}[[object]]\nshape = \"box\"\nsize = [1000, 1000, {THICKNESS_M}]\n\
                 position = [0, 0, {}]\nmaterial = \"snow\"\n{}",
                pcasnow(&format!("reflectance = 0\npath = \"{path}\"")),
                0.5 * THICKNESS_M,
                case.light
            );
            let mut integrator = integrator(&text, Some(&analytic_table()), &[]);
            for (top, eye) in points() {
                let along = (top - eye).as_dvec3().normalize();
                let slant = if *path == "view" { -along / along.z } else { DVec3::NEG_Z };
                let exit = top.as_dvec3() + slant * THICKNESS_M;
                let depth_cm = 100.0 * THICKNESS_M * slant.length();
                for (k, found) in BANDS.into_iter().zip(estimate(&mut integrator, eye, top, 128, BANDS)) {
                    let transmittance =
                        |angle_deg: f64| (-extinction_per_cm(k) * depth_cm * (1.0 + angle_deg.min(89.0) / 100.0)).exp();
                    let exact = case.power * f64::from(unit.0[k]) * (case.transmitted)(exit, &transmittance) / PI;
                    let Estimate { mean, standard_error } = found;
                    let p = found.p_value(exact);
                    let what = format!("{} by {path} at {top}, sample {k}", case.name);
                    assert!(p > level, "{what}: {mean} ± {standard_error} for {exact}, p = {p:.1e}");
                    // Otherwise the test could not fail.
                    assert!(standard_error < 5e-3 * exact, "{what}: {mean} ± {standard_error}");
                }
            }
        }
    }
}
