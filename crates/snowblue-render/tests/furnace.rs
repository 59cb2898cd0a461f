//! Closed rooms and endless walls, where the light between surfaces is known.

#![allow(clippy::unwrap_used, clippy::cast_possible_truncation, reason = "tests may panic, and rays are single")]

mod snow;

use std::f64::consts::PI;

use glam::{Vec3, Vec3A};
use snow::{SNOW, extinction_per_cm, lamp, scene, seen, simple_law};
use snowblue_render::camera::{PinholeCamera, View};
use snowblue_render::film::Film;
use snowblue_render::render::render;
use snowblue_render::scene::Scene;
use snowblue_stat::Moments;

/// Spheres about the origin, each an octahedron whose sides are cut `steps` times and blown up, as a PLY file.
fn spheres(steps: usize, radii_m: &[f32]) -> String {
    let mut triangles: Vec<[Vec3; 3]> = Vec::new();
    for (octant, radius_m) in (0..8).flat_map(|octant| radii_m.iter().map(move |radius_m| (octant, radius_m))) {
        let sign = Vec3::from_array([1, 2, 4].map(|bit| if octant & bit == 0 { 1.0 } else { -1.0 }));
        let point =
            |i: usize, j: usize| (Vec3::new(i as f32, j as f32, (steps - i - j) as f32) * sign).normalize() * *radius_m;
        for i in 0..steps {
            for j in 0..steps - i {
                triangles.push([point(i, j), point(i + 1, j), point(i, j + 1)]);
                if i + j + 1 < steps {
                    triangles.push([point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]);
                }
            }
        }
    }
    let vertices: String =
        triangles.iter().flatten().map(|corner| format!("{} {} {}\n", corner.x, corner.y, corner.z)).collect();
    let faces: String = (0..triangles.len()).map(|k| format!("3 {} {} {}\n", 3 * k, 3 * k + 1, 3 * k + 2)).collect();
    format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n{vertices}{faces}",
        3 * triangles.len(),
        triangles.len()
    )
}

/// A closed sphere with a lamp in its middle; directly lit, its wall has the radiance ρ I / (π r²).
fn lit_sphere(reflectance: f64, max_bounces: u32, samples_per_pixel: u32) -> Scene {
    let text = format!(
        "[material.wall]\ntype = \"diffuse\"\nreflectance = {reflectance}\n\
         [[object]]\nmesh = \"sphere.ply\"\nmaterial = \"wall\"\n\
         [[light]]\ntype = \"point\"\nposition = [0, 0, 0]\nilluminant = \"E\"\nradiant_intensity_w_sr = {}\n",
        PI / reflectance
    );
    let mut scene = scene(&text, &simple_law(), &[("sphere.ply", spheres(48, &[1.0]))]);
    (scene.film.width, scene.film.height) = (12, 8);
    (scene.integrator.max_bounces, scene.integrator.samples_per_pixel) = (max_bounces, samples_per_pixel);
    let view = View {
        position: Vec3A::new(0.3, -0.2, 0.1),
        look_at: Vec3A::new(0.5, 0.4, 0.3),
        up: Vec3A::Z,
        vertical_fov_deg: 100.0,
    };
    scene.camera = PinholeCamera::new(&view, 1.5).unwrap();
    scene
}

/// Mean luminance of a picture and its standard error.
fn mean_luminance(film: &Film) -> (f64, f64) {
    let mut moments = Moments::default();
    film.pixels().iter().for_each(|xyz| moments.push(xyz.y));
    (moments.mean(), moments.standard_error())
}

#[test]
fn every_bounce_in_a_closed_sphere_adds_its_power_of_the_reflectance() {
    for (max_bounces, sum) in [(0, 1.0), (1, 1.7), (3, 1.0 + 0.7 + 0.49 + 0.343)] {
        let film = render(&lit_sphere(0.7, max_bounces, 8), &|_| {}).film;
        for xyz in film.pixels() {
            // Equal-energy light: Y is the radiance. A facet's middle is nearer than its corners by 2e-4, and its
            // irradiance higher by twice that.
            assert!((xyz.y / sum - 1.0).abs() < 1e-3, "{max_bounces} bounces: {} for {sum}", xyz.y);
        }
    }
}

#[test]
fn a_lamp_with_extent_in_a_closed_sphere_adds_the_same_powers() {
    // E = π L a² from a ball of radius a in the middle: directly lit, the wall has the radiance ρ L a² = 1.
    let radiance = 1.0 / (0.7 * 0.3f64.powi(2));
    let text = format!(
        "[material.wall]\ntype = \"diffuse\"\nreflectance = 0.7\n[[object]]\nmesh = \"sphere.ply\"\nmaterial = \"wall\"\n\
         [[light]]\ntype = \"sphere\"\nposition = [0, 0, 0]\nradius = 0.3\nilluminant = \"E\"\nvisible = false\n\
         radiance_w_m2_sr = {radiance}\n"
    );
    for (max_bounces, sum) in [(0, 1.0), (3, 1.0 + 0.7 + 0.49 + 0.343)] {
        let mut scene = lit_sphere(0.7, max_bounces, 64);
        scene.lights = snow::scene(&text, &simple_law(), &[("sphere.ply", spheres(48, &[1.0]))]).lights;
        let film = render(&scene, &|_| {}).film;
        let (mean, standard_error) = mean_luminance(&film);
        // The facets' share as above.
        let allowed = 4.0 * standard_error + 1e-3 * sum;
        assert!((mean - sum).abs() < allowed && allowed < 0.05 * sum, "{mean} ± {allowed} for {sum}");
    }
}

#[test]
fn a_closed_sphere_reaches_its_balance_though_long_paths_end_by_chance() {
    let film = render(&lit_sphere(0.8, 10_000, 64), &|_| {}).film;
    let (mean, standard_error) = mean_luminance(&film);
    // L = 1 / (1 − ρ); the facets' share as above, five times over.
    assert!((mean - 5.0).abs() < 4.0 * standard_error + 5e-3, "{mean} ± {standard_error}");
    assert!(standard_error > 1e-3 && standard_error < 0.1, "{standard_error}");
}

#[test]
fn snow_that_lets_light_through_lights_the_floor() {
    // Before an endless wall of radiance L a floor at its foot gets π L / 2.
    let text = format!(
        "{SNOW}reflectance = 0\nemission = \"relative\"\npath = \"normal\"\n\
         [material.floor]\ntype = \"diffuse\"\nreflectance = 0.5\n\
         [[object]]\nshape = \"box\"\nsize = [400, 0.3, 400]\nposition = [0, 0.15, 0]\nmaterial = \"snow\"\n\
         [[object]]\nshape = \"box\"\nsize = [400, 200, 0.1]\nposition = [0, -100, -0.05]\nmaterial = \"floor\"\n\
         [[light]]\ntype = \"point\"\nposition = [0, 90000, 0]\nradiant_intensity_w_sr = 1\n"
    );
    let mut scene = scene(&text, &simple_law(), &[]);
    let samples = 1 << 14;
    (scene.integrator.max_bounces, scene.integrator.samples_per_pixel) = (1, samples);
    let floor = seen(&mut scene, Vec3A::new(0.0, -1.0, 1.0), Vec3A::new(0.0, -0.1, 0.0));
    for k in [0, 15, 30] {
        let wall = f64::from(lamp(&mut scene).relative.0[k]) * (-30.0 * extinction_per_cm(k)).exp();
        // Half of the rays meet the wall: the standard error of independent ones, relative, is 1/√n.
        let expected = 0.25 * wall;
        let allowed = 4.0 * expected / f64::from(samples).sqrt();
        assert!((f64::from(floor.0[k]) - expected).abs() < allowed, "{} for {expected} ± {allowed}", floor.0[k]);
    }
}

#[test]
fn a_hollow_ball_of_snow_is_a_furnace_with_the_reflectance_of_snow() {
    // A shell from 1 m to 1.2 m: the simple snow reflects a quarter, and no light comes from outside.
    let mut scene = lit_sphere(0.25, 3, 8);
    let text = format!(
        "{SNOW}[[object]]\nmesh = \"shell.ply\"\nmaterial = \"snow\"\n\
         [[light]]\ntype = \"point\"\nposition = [0, 0, 0]\nilluminant = \"E\"\nradiant_intensity_w_sr = {}\n",
        4.0 * PI
    );
    let snow = snow::scene(&text, &simple_law(), &[("shell.ply", spheres(48, &[1.0, 1.2]))]);
    (scene.objects, scene.materials, scene.lights) = (snow.objects, snow.materials, snow.lights);
    let rendering = render(&scene, &|_| {});
    assert_eq!(rendering.statistics.odd_depth_lines, 0);
    for xyz in rendering.film.pixels() {
        let sum = 1.0 + 0.25 + 0.0625 + 0.015_625;
        assert!((xyz.y / sum - 1.0).abs() < 1e-3, "{} for {sum}", xyz.y);
    }
}
