//! Interreflection with closed-form solutions: furnaces, integrating spheres and infinite walls.

use std::f64::consts::PI;

use glam::{DVec3, Vec3, Vec3A};
use snowblue_base::Count;
use snowblue_color::LinearRgb;
use snowblue_render::Integrator;
use snowblue_render::film::Film;
use snowblue_render::film::image_file::write_exr;
use snowblue_render::render::render_all;
use snowblue_render::scene::Scene;
use snowblue_render::scene::camera::View;
use snowblue_render::scene::film::ImageSize;
use snowblue_stat::{Moments, sidak_level};

use crate::snow::{SNOW, analytic_table, directions, estimate, extinction_per_cm, pcasnow, prepared, radiance, scene};

/// A PLY file of spheres around the origin, each an octahedron whose sides are subdivided `steps` times.
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
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\n\
         property list uchar int vertex_indices\nend_header\n{vertices}{faces}",
        3 * triangles.len(),
        triangles.len()
    )
}

/// A hollow sphere with a point light in its centre. Its wall reflects the radiance ρ I / (π r²) of direct light.
fn lit_sphere(reflectance: f64, max_bounces: u32, samples_per_pixel: u32) -> Integrator {
    let text = format!(
        "[material.wall]\ntype = \"diffuse\"\nreflectance = {reflectance}\n\
         [[object]]\nmesh = \"sphere.ply\"\nmaterial = \"wall\"\n\
         [[light]]\ntype = \"point\"\nposition = [0, 0, 0]\nilluminant = \"E\"\nradiant_intensity_w_sr = {}\n",
        PI / reflectance
    );
    within(&text, ("sphere.ply", spheres(48, &[1.0])), max_bounces, samples_per_pixel)
}

/// A scene seen from within a sphere of radius 1 m.
fn within(text: &str, file: (&str, String), max_bounces: u32, samples_per_pixel: u32) -> Integrator {
    let mut scene = scene(text, &[file]);
    scene.set_image_size(ImageSize { width: 12, height: 8 });
    scene.set_max_bounces(Count::of(max_bounces));
    scene.set_samples_per_pixel(Count::of(samples_per_pixel));
    let view = View {
        position: Vec3A::new(0.3, -0.2, 0.1),
        look_at: Vec3A::new(0.5, 0.4, 0.3),
        up: Vec3A::Z,
        vertical_fov_deg: 100.0,
    };
    assert!(scene.set_view(&view));
    prepared(&scene, Some(&analytic_table()))
}

/// Mean luminance of an image and its standard error.
fn mean_luminance(film: &Film) -> (f64, f64) {
    let mut moments = Moments::default();
    film.pixels().iter().for_each(|xyz| moments.push(xyz.y));
    (moments.mean(), moments.standard_error())
}

#[test]
fn bounce_n_in_a_hollow_sphere_adds_the_reflectance_to_the_power_n() {
    for (max_bounces, sum) in [(0, 1.0), (1, 1.7), (3, 1.0 + 0.7 + 0.49 + 0.343)] {
        let film = render_all(&lit_sphere(0.7, max_bounces, 8), &|_| {}).film;
        for xyz in film.pixels() {
            // For equal-energy light Y is the radiance. Tolerance: the centre of a facet is nearer than its corners by
            // 2e-4, and its irradiance higher by twice that.
            assert!((xyz.y / sum - 1.0).abs() < 1e-3, "{max_bounces} bounces: {} for {sum}", xyz.y);
        }
    }
}

#[test]
fn a_spherical_light_in_a_hollow_sphere_adds_the_same_powers() {
    // A sphere of radius a in the centre gives E = π L a², so the wall reflects ρ L a² = 1 of direct light.
    let radiance = 1.0 / (0.7 * 0.3f64.powi(2));
    let text = format!(
        "[material.wall]\ntype = \"diffuse\"\nreflectance = 0.7\n[[object]]\nmesh = \"sphere.ply\"\n\
         material = \"wall\"\n\
         [[light]]\ntype = \"sphere\"\nposition = [0, 0, 0]\nradius = 0.3\nilluminant = \"E\"\nvisible = false\n\
         radiance_w_m2_sr = {radiance}\n"
    );
    for (max_bounces, sum) in [(0, 1.0), (3, 1.0 + 0.7 + 0.49 + 0.343)] {
        let integrator = within(&text, ("sphere.ply", spheres(48, &[1.0])), max_bounces, 64);
        let film = render_all(&integrator, &|_| {}).film;
        let (mean, standard_error) = mean_luminance(&film);
        // The facets' error as above.
        let allowed = 4.0 * standard_error + 1e-3 * sum;
        assert!((mean - sum).abs() < allowed && allowed < 0.05 * sum, "{mean} ± {allowed} for {sum}");
    }
}

#[test]
fn a_hollow_sphere_reaches_equilibrium_with_russian_roulette() {
    let film = render_all(&lit_sphere(0.8, 10_000, 64), &|_| {}).film;
    let (mean, standard_error) = mean_luminance(&film);
    // L = 1 / (1 − ρ). The facets' error is as above, times 5.
    assert!((mean - 5.0).abs() < 4.0 * standard_error + 5e-3, "{mean} ± {standard_error}");
    assert!(standard_error > 1e-3 && standard_error < 0.1, "{standard_error}");
}

#[test]
fn light_transmitted_by_snow_illuminates_the_floor() {
    // A floor at the foot of an infinite wall of radiance L has the irradiance π L / 2.
    let text = format!(
        "{}{SNOW}[material.floor]\ntype = \"diffuse\"\nreflectance = 0.5\n\
         [[object]]\nshape = \"box\"\nsize = [400, 0.3, 400]\nposition = [0, 0.15, 0]\nmaterial = \"snow\"\n\
         [[object]]\nshape = \"box\"\nsize = [400, 200, 0.1]\nposition = [0, -100, -0.05]\nmaterial = \"floor\"\n\
         [[light]]\ntype = \"directional\"\ndirection = [0, -1, 0]\nirradiance_w_m2 = {PI}\nilluminant = \"E\"\n",
        pcasnow("reflectance = 0\npath = \"normal\"")
    );
    let mut scene = scene(&text, &[]);
    let samples = 1 << 14;
    scene.set_max_bounces(Count::of(1));
    scene.set_samples_per_pixel(Count::of(samples));
    let mut integrator = prepared(&scene, Some(&analytic_table()));
    let floor = radiance(&mut integrator, Vec3A::new(0.0, -1.0, 1.0), Vec3A::new(0.0, -0.1, 0.0));
    for k in [0, 15, 30] {
        let wall = (-30.0 * extinction_per_cm(k)).exp();
        // Half of the rays hit the wall. The relative standard error of independent rays is 1/√n.
        let expected = 0.25 * wall;
        let allowed = 4.0 * expected / f64::from(samples).sqrt();
        assert!((f64::from(floor.0[k]) - expected).abs() < allowed, "{} for {expected} ± {allowed}", floor.0[k]);
    }
}

#[test]
fn a_hollow_sphere_of_snow_is_a_furnace_with_the_reflectance_of_snow() {
    // A shell from 1 m to 1.2 m. The snow has reflectance 1/4, and no light comes from outside.
    let text = format!(
        "{SNOW}[[object]]\nmesh = \"shell.ply\"\nmaterial = \"snow\"\n\
         [[light]]\ntype = \"point\"\nposition = [0, 0, 0]\nilluminant = \"E\"\nradiant_intensity_w_sr = {}\n",
        4.0 * PI
    );
    let integrator = within(&text, ("shell.ply", spheres(48, &[1.0, 1.2])), 3, 8);
    let rendering = render_all(&integrator, &|_| {});
    assert_eq!(rendering.statistics.odd_depth_lines, 0);
    for xyz in rendering.film.pixels() {
        let sum = 1.0 + 0.25 + 0.0625 + 0.015_625;
        assert!((xyz.y / sum - 1.0).abs() < 1e-3, "{} for {sum}", xyz.y);
    }
}

/// White objects that do not touch each other.
const WHITE_OBJECTS: &str = "[material.white]\ntype = \"diffuse\"\nreflectance = 1\n\
    [[object]]\nshape = \"plane\"\nposition = [0, 0, -1]\nmaterial = \"white\"\n\
    [[object]]\nshape = \"sphere\"\nradius = 0.6\nscale = [1, 0.5, 1.5]\nmaterial = \"white\"\n\
    [[object]]\nmesh = \"ball.ply\"\nposition = [1.2, 0.3, 0]\nscale = 0.5\nmaterial = \"white\"\n\
    [[object]]\nshape = \"box\"\nsize = [0.8, 0.6, 0.7]\nrotation_deg = [20, 30, 40]\nposition = [-1.2, 0, -0.2]\n\
    material = \"white\"\n";

/// A small image of these objects with unlimited bounces.
fn white_furnace(sky: &str) -> Scene {
    let mut scene = scene(&format!("{WHITE_OBJECTS}{sky}"), &[("ball.ply", spheres(12, &[1.0]))]);
    scene.set_image_size(ImageSize { width: 24, height: 16 });
    scene.set_samples_per_pixel(Count::of(16));
    scene.set_max_bounces(Count::of(10_000));
    let view = View {
        position: Vec3A::new(0.5, -4.0, 0.8),
        look_at: Vec3A::new(0.0, 0.0, -0.2),
        up: Vec3A::Z,
        vertical_fov_deg: 50.0,
    };
    assert!(scene.set_view(&view));
    scene
}

#[test]
fn objects_in_a_white_furnace_are_invisible() {
    let furnace = white_furnace("[environment]\nradiance_w_m2_sr = 1\nilluminant = \"E\"\n");
    let rendering = render_all(&prepared(&furnace, None), &|_| {});
    // Every path reaches the sky without absorption, so Y is 1 within rounding.
    for xyz in rendering.film.pixels() {
        assert!((xyz.y - 1.0).abs() < 1e-6, "{}", xyz.y);
    }
    let statistics = rendering.statistics;
    assert!(
        2 * statistics.indirect_rays > statistics.camera_rays,
        "at least half of the pixels show white objects: {statistics:?}"
    );
}

#[test]
fn objects_in_a_white_furnace_with_an_image_sky_are_invisible() {
    // Here light is sampled in two ways: by the sky's luminance and by the reflection.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("white.exr");
    write_exr(
        &Film::new(ImageSize { width: 8, height: 4 }, vec![LinearRgb { r: 1.0, g: 1.0, b: 1.0 }.xyz(); 32]),
        &[],
        &path,
    )
    .unwrap();
    let mut furnace = white_furnace(&format!("[environment]\nimage = \"{}\"\n", path.display()));
    furnace.set_samples_per_pixel(Count::of(64));
    let (mean, standard_error) = mean_luminance(&render_all(&prepared(&furnace, None), &|_| {}).film);
    assert!((mean - 1.0).abs() < 4.0 * standard_error + 1e-5, "{mean} ± {standard_error}");
    assert!(standard_error < 5e-3, "{standard_error}");
}

/// A light in a hollow sphere of radius 1 m around the origin.
struct HollowSphereLight {
    text: &'static str,
    /// Φ, in W.
    power_w: f64,
    /// Irradiance of the wall, in W/m².
    irradiance: fn(DVec3) -> f64,
}

const LIGHTS: [HollowSphereLight; 3] = [
    HollowSphereLight {
        text: "type = \"point\"\nposition = [0.3, -0.2, 0.1]\nradiant_intensity_w_sr = 2\n",
        power_w: 8.0 * PI,
        irradiance: |wall| {
            let to_light = DVec3::new(0.3, -0.2, 0.1) - wall;
            2.0 * -wall.dot(to_light) / to_light.length().powi(3)
        },
    },
    HollowSphereLight {
        text: "type = \"sphere\"\nposition = [-0.2, 0.3, 0.2]\nradius = 0.15\nradiance_w_m2_sr = 5\nvisible = false\n",
        power_w: 5.0 * PI * 4.0 * PI * 0.0225,
        // E = π L (R/d)² cos θ of a sphere above the horizon.
        irradiance: |wall| {
            let to_light = DVec3::new(-0.2, 0.3, 0.2) - wall;
            5.0 * PI * 0.0225 * -wall.dot(to_light) / to_light.length().powi(3)
        },
    },
    HollowSphereLight {
        text: "type = \"rectangle\"\nposition = [0.1, 0.2, -0.3]\nlook_at = [0.1, 0.2, 5]\nup = [0, 1, 0]\n\
            size = [0.4, 0.25]\nradiance_w_m2_sr = 5\nvisible = false\n",
        power_w: 5.0 * PI * 0.1,
        irradiance: |wall| {
            let steps = 100;
            let mut sum = 0.0;
            for (i, j) in (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
                let [u, v] = [i, j].map(|step| (f64::from(step) + 0.5) / f64::from(steps) - 0.5);
                let to_light = DVec3::new(0.1 + 0.4 * u, 0.2 + 0.25 * v, -0.3) - wall;
                sum += -wall.dot(to_light) * (-to_light.z).max(0.0) / to_light.length_squared().powi(2);
            }
            sum * 5.0 * 0.1 / f64::from(steps * steps)
        },
    },
];

#[test]
fn an_integrating_sphere_distributes_the_light_of_any_light_source_evenly() {
    // The wall's radiance is ρ E / π + (ρ + ρ² + …) · ρ Φ / (4 π² R²). The second term is the same everywhere, for any
    // position and shape of the light.
    let reflectance = 0.7f64;
    let level = sidak_level(1e-3, LIGHTS.len() * 16);
    for lamp in &LIGHTS {
        let text = format!(
            "[material.wall]\ntype = \"diffuse\"\nreflectance = {reflectance}\n[[object]]\nshape = \"sphere\"\n\
             radius = 1\n\
             material = \"wall\"\n[[light]]\nilluminant = \"E\"\n{}",
            lamp.text
        );
        let mut scene = scene(&text, &[]);
        scene.set_max_bounces(Count::of(3));
        let mut integrator = prepared(&scene, None);
        let spread =
            (reflectance + reflectance.powi(2) + reflectance.powi(3)) * reflectance * lamp.power_w / (4.0 * PI * PI);
        for wall in directions(16) {
            let [found, ..] = estimate(&mut integrator, Vec3A::new(0.05, -0.1, 0.6), wall, 256, [15, 15, 15]);
            let exact = reflectance * (lamp.irradiance)(wall.as_dvec3()) / PI + spread;
            let p = found.p_value(exact);
            assert!(p > level, "{} at {wall}: {found:?} for {exact}, p = {p:.1e}", lamp.text);
            assert!(found.standard_error < 0.01 * exact, "{} at {wall}: {found:?}", lamp.text);
        }
    }
}

#[test]
fn a_hollow_sphere_reaches_a_radiance_of_one_for_any_reflectance() {
    // With a light in the centre such that ρ E / π = 1 − ρ, L = 1 − ρ + ρ L everywhere, so L = 1.
    for reflectance in [0.2, 0.5, 0.9] {
        let text = format!(
            "[material.wall]\ntype = \"diffuse\"\nreflectance = {reflectance}\n[[object]]\nshape = \"sphere\"\n\
             radius = 1\n\
             material = \"wall\"\n[[light]]\ntype = \"point\"\nposition = [0, 0, 0]\nilluminant = \"E\"\n\
             radiant_intensity_w_sr = {}\n",
            PI * (1.0 - reflectance) / reflectance
        );
        let mut scene = scene(&text, &[]);
        scene.set_max_bounces(Count::of(10_000));
        let mut integrator = prepared(&scene, None);
        let level = sidak_level(1e-3, 8);
        for wall in directions(8) {
            let [found, ..] = estimate(&mut integrator, Vec3A::new(0.05, -0.1, 0.6), wall, 256, [15, 15, 15]);
            assert!(found.p_value(1.0) > level, "{reflectance} at {wall}: {found:?}");
            // Only the number of bounces is random.
            assert!(found.standard_error < 0.06, "{reflectance} at {wall}: {found:?}");
        }
    }
}
