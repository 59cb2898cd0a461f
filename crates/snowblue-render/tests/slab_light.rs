//! A slab under every kind of light: L = T E / π within noise, at many points, through every path that is exact there.
//!
//! The law of the snow is simple, so that ∫ T(θ) L cos θ dω over a lamp is a smooth integral; the midpoint rule gives it
//! here, from the lamp's own surface and not from the directions that the renderer draws.

#![allow(clippy::unwrap_used, clippy::cast_possible_truncation, reason = "tests may panic, and rays are single")]

mod snow;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, Vec3A};
use snow::{Estimate, SNOW, estimate, extinction_per_cm, scene, simple_law};
use snowblue_render::spectrum::light_spectrum::LightSpectrum;
use snowblue_stat::sidak_level;

/// Thickness of the slab, which stands on the plane z = 0, in m.
const THICKNESS_M: f64 = 0.2;

/// Indices of the wavelengths that are looked at: the ends and the middle of the grid.
const BANDS: [usize; 3] = [0, 15, 30];

/// Probability that a test here fails though nothing is wrong, were its seeds not fixed.
const LEVEL: f64 = 1e-3;

/// A light, of D65, as text and as a formula.
struct Case {
    name: &'static str,
    light: &'static str,
    /// Paths that are exact under this light.
    paths: &'static [&'static str],
    /// ∫ T(θ) dE at a point of the plane z = 0 from below, of one unit of the lamp's power, T being given by θ in degrees.
    transmitted: fn(DVec3, &dyn Fn(f64) -> f64) -> f64,
    /// Power in the unit that the light's text has.
    power: f64,
}

const CASES: [Case; 6] = [
    Case {
        name: "point",
        light: "[[light]]\ntype = \"point\"\nposition = [0.1, -0.2, -0.8]\nradiant_intensity_w_sr = 10\n",
        paths: &["normal", "view"],
        transmitted: |exit, share| {
            let way = DVec3::new(0.1, -0.2, -0.8) - exit;
            from_patch(way, share) / way.length_squared()
        },
        power: 10.0,
    },
    Case {
        name: "distant",
        light: "[[light]]\ntype = \"directional\"\ndirection = [0.6, 0, 0.8]\nirradiance_w_m2 = 3\n",
        paths: &["normal", "view", "brightest"],
        transmitted: |_, share| from_patch(DVec3::new(-0.6, 0.0, -0.8), share),
        power: 3.0,
    },
    Case {
        name: "ball",
        light: "[[light]]\ntype = \"sphere\"\nposition = [0.3, 0.2, -1]\nradius = 0.5\nradiance_w_m2_sr = 2\n",
        paths: &["normal", "view"],
        transmitted: |exit, share| from_ball(exit, DVec3::new(0.3, 0.2, -1.0), 0.5, share),
        power: 2.0,
    },
    Case {
        // So far away that on the line to the lamp the depth grows faster than the distance to the lamp falls.
        name: "far ball",
        light: "[[light]]\ntype = \"sphere\"\nposition = [4, 3, -30]\nradius = 3\nradiance_w_m2_sr = 20\n",
        paths: &["normal", "view", "brightest"],
        transmitted: |exit, share| from_ball(exit, DVec3::new(4.0, 3.0, -30.0), 3.0, share),
        power: 20.0,
    },
    Case {
        name: "panel",
        light: "[[light]]\ntype = \"rectangle\"\nposition = [0.4, -0.3, -0.7]\nlook_at = [0.4, -0.3, 0]\nup = [0, 1, 0]\n\
            size = [1.2, 0.5]\nradiance_w_m2_sr = 2\n",
        paths: &["normal", "view"],
        transmitted: |exit, share| from_panel(exit, DVec3::new(0.4, -0.3, -0.7), 1.2, 0.5, share),
        power: 2.0,
    },
    Case {
        name: "sky",
        light: "[environment]\nradiance_w_m2_sr = 1\n",
        paths: &["normal", "view", "brightest"],
        transmitted: |_, share| {
            let steps = 20_000;
            let term = |step: i32| {
                let angle = (f64::from(step) + 0.5) * FRAC_PI_2 / f64::from(steps);
                TAU * share(angle.to_degrees()) * angle.cos() * angle.sin()
            };
            (0..steps).map(term).sum::<f64>() * FRAC_PI_2 / f64::from(steps)
        },
        power: 1.0,
    },
];

/// T(θ) cos θ for light from a direction, of any length.
fn from_patch(way: DVec3, share: &dyn Fn(f64) -> f64) -> f64 {
    let cos = -way.z / way.length();
    share(cos.acos().to_degrees()) * cos
}

/// The integral over the cone of directions in which a ball is seen.
fn from_ball(exit: DVec3, centre: DVec3, radius_m: f64, share: &dyn Fn(f64) -> f64) -> f64 {
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
            sum += from_patch(axis * cos + side * (sin * across) + ahead * (sin * up), share);
        }
    }
    sum * TAU * (1.0 - least_cos) / f64::from(rings * turns)
}

/// The integral over a level rectangle that shines upwards, `width_m` along x.
fn from_panel(exit: DVec3, centre: DVec3, width_m: f64, depth_m: f64, share: &dyn Fn(f64) -> f64) -> f64 {
    let (across, along) = (240, 100);
    let mut sum = 0.0;
    for i in 0..across {
        for j in 0..along {
            let (u, v) = ((f64::from(i) + 0.5) / f64::from(across), (f64::from(j) + 0.5) / f64::from(along));
            let way = centre + DVec3::new((u - 0.5) * width_m, (v - 0.5) * depth_m, 0.0) - exit;
            sum += from_patch(way, share) * -way.z / (way.length() * way.length_squared());
        }
    }
    sum * width_m * depth_m / f64::from(across * along)
}

/// Points of the upper side, under the lamps and a good way off, each with an eye of its own above it.
fn points() -> impl Iterator<Item = (Vec3A, Vec3A)> {
    (0..12).map(|k| {
        let (sin, cos) = (2.399_963 * k as f32).sin_cos();
        let radius = 0.03 * 1.5f32.powi(k);
        let top = Vec3A::new(radius * cos, radius * sin, THICKNESS_M as f32);
        (top, top + Vec3A::new(0.3 * sin * k as f32, 0.2 * cos * k as f32, 1.0))
    })
}

#[test]
fn a_slab_meets_its_analytic_radiance_under_every_light() {
    let tests: usize = CASES.iter().map(|case| case.paths.len() * points().count() * BANDS.len()).sum();
    let level = sidak_level(LEVEL, tests);
    let unit = LightSpectrum::illuminant("D65".parse().unwrap()).unwrap().unit;
    for case in &CASES {
        for path in case.paths {
            let text = format!(
                "{SNOW}reflectance = 0\npath = \"{path}\"\n[[object]]\nshape = \"box\"\nsize = [1000, 1000, {THICKNESS_M}]\n\
                 position = [0, 0, {}]\nmaterial = \"snow\"\n{}",
                0.5 * THICKNESS_M,
                case.light
            );
            let mut scene = scene(&text, &simple_law(), &[]);
            for (top, eye) in points() {
                let along = (top - eye).as_dvec3().normalize();
                let slant = if *path == "view" { -along / along.z } else { DVec3::NEG_Z };
                let exit = top.as_dvec3() + slant * THICKNESS_M;
                let depth_cm = 100.0 * THICKNESS_M * slant.length();
                for (k, found) in BANDS.into_iter().zip(estimate(&mut scene, eye, top, 128, BANDS)) {
                    let share =
                        |angle_deg: f64| (-extinction_per_cm(k) * depth_cm * (1.0 + angle_deg.min(89.0) / 100.0)).exp();
                    let exact = case.power * f64::from(unit.0[k]) * (case.transmitted)(exit, &share) / PI;
                    let Estimate { mean, standard_error } = found;
                    let p = found.p_value(exact);
                    let what = format!("{} by {path} at {top}, sample {k}", case.name);
                    assert!(p > level, "{what}: {mean} ± {standard_error} for {exact}, p = {p:.1e}");
                    // Else the test could not fail.
                    assert!(standard_error < 5e-3 * exact, "{what}: {mean} ± {standard_error}");
                }
            }
        }
    }
}
