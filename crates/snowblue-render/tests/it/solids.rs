//! Spheres, scaled and instanced meshes, and bodies of several objects have the depths and radiance of equivalent
//! shapes.

use glam::{DVec3, Vec3A};
use snowblue_base::Count;
use snowblue_geometry::ray::{Crossing, Ray};
use snowblue_render::render::render_all;
use snowblue_render::scene::Scene;
use snowblue_render::scene::film::ImageSize;
use snowblue_render::scene::inspection::inspect;

use crate::snow::{
    SNOW, analytic_table, directions, integrator, pcasnow, prepared, radiance, scene, scene_of_few_grains,
};

const LIGHT: &str = "[[light]]\ntype = \"point\"\nposition = [0.1, 2.0, 0.2]\nradiant_intensity_w_sr = 10\n";

/// A PLY file of the cube from −1 to 1.
const CUBE: &str = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
    element face 6\nproperty list uchar int vertex_indices\nend_header\n\
    -1 -1 -1\n1 -1 -1\n-1 1 -1\n1 1 -1\n-1 -1 1\n1 -1 1\n-1 1 1\n1 1 1\n\
    4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";

fn objects(text: &str) -> Scene {
    let keys = pcasnow("path = \"normal\"\nreflectance = 0");
    scene(&format!("{keys}{SNOW}{text}{LIGHT}"), &[("cube.ply", CUBE.into())])
}

/// The crossings of a line with the first object, by distance.
fn crossings(scene: &Scene, ray: &Ray) -> Vec<Crossing> {
    let mut crossings = Vec::new();
    assert!(!scene.objects().segments(0, ray, f32::INFINITY, &mut crossings));
    crossings.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
    crossings
}

#[test]
fn crossings_of_a_sphere_are_exact_in_every_direction() {
    let ball = objects(
        "[[object]]\nshape = \"sphere\"\nradius = 0.15\nscale = 2\nposition = [0.2, -0.1, 0.4]\nmaterial = \"snow\"\n",
    );
    let centre = DVec3::new(0.2, -0.1, 0.4);
    for (k, direction) in directions(2000).enumerate() {
        let towards = direction.as_dvec3().normalize();
        let miss_m = 0.31 * (k % 23) as f64 / 23.0;
        let eye = (centre + towards.any_orthonormal_vector() * miss_m - towards * 3.0).as_vec3a();
        let found = crossings(&ball, &Ray::new(eye, towards.as_vec3a()));
        // The expected crossings of the rounded ray.
        let along = towards.as_vec3a().as_dvec3();
        let to_centre = centre.as_vec3a().as_dvec3() - eye.as_dvec3();
        let middle = to_centre.dot(along) / along.length_squared();
        let within = 0.09 - (to_centre - middle * along).length_squared();
        // Near the silhouette the rounding of the centre, 3e-8 m, decides.
        if within < 1e-5 {
            continue;
        }
        let half_m = within.sqrt();
        for (crossing, expected) in found.iter().zip([middle - half_m, middle + half_m]) {
            // A distance near 3 m is rounded by 1.2e-7 m; the rounding of radius and centre, 3e-8 m, is scaled by r /
            // half.
            let allowed = 3e-7 + 2e-7 * 0.3 / half_m;
            assert!((f64::from(crossing.distance_m) - expected).abs() < allowed, "line {k}");
        }
        assert_eq!(found.len(), 2, "line {k}");
    }
}

#[test]
fn a_scaled_and_rotated_mesh_equals_the_box_of_that_size() {
    let place = "position = [0.3, -0.2, 0.4]\nrotation_deg = [20, -35, 70]\nmaterial = \"snow\"\n";
    // A second instance shares the triangles of the first.
    let mesh =
        |more: &str| objects(&format!("[[object]]\nmesh = \"cube.ply\"\nscale = [0.3, 0.15, 0.25]\n{place}{more}"));
    let instance = "[[object]]\nmesh = \"cube.ply\"\nposition = [0, -60, 0]\nmaterial = \"snow\"\n";
    let exact = objects(&format!("[[object]]\nshape = \"box\"\nsize = [0.6, 0.3, 0.5]\n{place}"));
    for stretched in [mesh(""), mesh(instance)] {
        let mut hits = 0;
        for (k, direction) in directions(2000).enumerate() {
            let side = direction.any_orthonormal_vector() * (0.4 * (k % 17) as f32 / 17.0);
            let ray = Ray::new(Vec3A::new(0.3, -0.2, 0.4) + side - direction * 2.0, direction);
            let (one, other) = (crossings(&stretched, &ray), crossings(&exact, &ray));
            assert_eq!(one.len(), other.len(), "line {k}");
            for (one, other) in one.iter().zip(&other) {
                // Rounding of coordinates of a few metres, and of the transform.
                let cos = other.normal.dot(direction).abs();
                assert!((one.distance_m - other.distance_m).abs() * cos < 4e-6, "line {k}");
                assert!(one.normal.normalize().dot(other.normal).abs() > 0.999_99, "line {k}");
                hits += 1;
            }
            if let (Some(one), Some(other)) = (stretched.objects().first_hit(&ray), exact.objects().first_hit(&ray)) {
                assert!((one.point - other.point).dot(other.normal).abs() < 1e-6, "line {k}");
                assert!(one.normal.dot(other.normal) > 0.999_99, "line {k}");
            }
        }
        assert!(hits > 2000, "{hits}");
    }
}

/// Vertices and sides of the cube from −1 to 1, moved along x and turned inside out.
fn shells(cubes: &[(f64, bool)]) -> String {
    let (mut vertices, mut sides) = (String::new(), String::new());
    for (number, (x, is_turned)) in cubes.iter().enumerate() {
        for corner in 0..8 {
            let [along, across, up] = [corner & 1, corner >> 1 & 1, corner >> 2].map(|bit| f64::from(2 * bit - 1));
            let size = if *is_turned { 0.5 } else { 1.0 };
            vertices += &format!("{} {} {}\n", x + size * along, size * across, size * up);
        }
        for mut side in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
            if *is_turned {
                side.reverse();
            }
            sides += &format!("4 {}\n", side.map(|corner: usize| (8 * number + corner).to_string()).join(" "));
        }
    }
    let header = CUBE.split("-1 -1").next().unwrap_or_default();
    let header = header.replace("vertex 8", &format!("vertex {}", 8 * cubes.len()));
    header.replace("face 6", &format!("face {}", 6 * cubes.len())) + &vertices + &sides
}

/// Shells of one mesh that overlap are one solid, and a shell that is turned inwards is a cavity.
#[test]
fn shells_of_a_mesh_are_inside_where_their_winding_number_is_not_0() {
    let object = "[[object]]\nmesh = \"shells.ply\"\nscale = 0.1\nmaterial = \"snow\"\n";
    let lengths = |cubes: &[(f64, bool)]| {
        let scene = scene(&format!("{SNOW}{object}{LIGHT}"), &[("shells.ply", shells(cubes))]);
        let found = crossings(&scene, &Ray::new(Vec3A::new(-1.0, 0.011, 0.02), Vec3A::X));
        let found: Vec<f32> = found.iter().map(|crossing| (crossing.distance_m * 1e4).round() / 1e4).collect();
        (found, inspect(&scene)[0].volume_m3.unwrap())
    };
    let cases = [
        (vec![(0.0, false), (1.0, false)], vec![0.9, 1.2], 0.012),
        (vec![(0.0, false), (1.0, false), (0.5, false)], vec![0.9, 1.2], 0.012),
        (vec![(0.0, false), (5.0, false)], vec![0.9, 1.1, 1.4, 1.6], 0.016),
        (vec![(0.0, false), (0.0, true)], vec![0.9, 0.95, 1.05, 1.1], 0.007),
    ];
    for (cubes, segments, volume_m3) in cases {
        let (found, found_m3) = lengths(&cubes);
        assert_eq!(found, segments);
        // The volume of shells that overlap follows from random lines.
        assert!((found_m3 / volume_m3 - 1.0).abs() < 0.01, "{found_m3} for {volume_m3}");
    }
}

#[test]
fn overlapping_shells_are_as_bright_as_a_body_of_two_objects() {
    for method in ["pcasnow", "diffusion", "hybrid", "reference"] {
        let radiance_of = |text: &str, file: (&str, String)| {
            let mut scene = scene_of_few_grains(method, &format!("{SNOW}{text}{LIGHT}"), &[file]);
            scene.set_samples_per_pixel(Count::of(64));
            radiance(&mut prepared(&scene, None), Vec3A::new(0.0, -2.0, 0.3), Vec3A::new(0.05, -0.1, 0.02)).0[15]
        };
        let mesh = "[[object]]\nmesh = \"shells.ply\"\nscale = 0.1\nmaterial = \"snow\"\n";
        let joined = radiance_of(mesh, ("shells.ply", shells(&[(0.0, false), (1.0, false)])));
        let half = |x: f64| {
            format!(
                "[[object]]\nmesh = \"cube.ply\"\nscale = 0.1\nposition = [{x}, 0, 0]\nmaterial = \"snow\"\n\
                 body = \"one\"\n"
            )
        };
        let body = radiance_of(&(half(0.0) + &half(0.1)), ("cube.ply", CUBE.into()));
        assert!(joined > 0.0 && (joined / body - 1.0).abs() < 1e-3, "{method}: {joined} for {body}");
    }
}

#[test]
fn scaled_spheres_have_distances_in_metres() {
    let egg = objects("[[object]]\nshape = \"sphere\"\nradius = 1\nscale = [0.1, 0.2, 0.4]\nmaterial = \"snow\"\n");
    for (axis, length_m) in [(Vec3A::X, 0.2), (Vec3A::Y, 0.4), (Vec3A::Z, 0.8)] {
        let found = crossings(&egg, &Ray::new(-3.0 * axis, axis));
        assert!((found[1].distance_m - found[0].distance_m - length_m).abs() < 1e-6);
    }
}

/// Boxes between these bounds along y, 0.8 m wide and high, in one body or without a body.
fn blocks(boundaries: &[(f64, f64)], body: bool) -> String {
    let body = if body { "body = \"wall\"\n" } else { "" };
    let block = |&(low, high): &(f64, f64)| {
        format!(
            "[[object]]\nshape = \"box\"\nsize = [0.8, {}, 0.8]\nposition = [0, {}, 0]\nmaterial = \"snow\"\n{body}",
            high - low,
            0.5 * (low + high)
        )
    };
    boundaries.iter().map(block).collect()
}

fn light_through(text: &str, target: Vec3A) -> f32 {
    radiance(&mut prepared(&objects(text), Some(&analytic_table())), Vec3A::new(0.3, -2.0, 0.5), target).0[15]
}

#[test]
fn touching_or_overlapping_blocks_of_a_body_are_one_block() {
    let target = Vec3A::new(0.1, 0.0, -0.05);
    let whole = light_through(&blocks(&[(0.0, 0.3)], false), target);
    assert!(whole > 0.0);
    for parts in [[(0.0, 0.1), (0.1, 0.3)], [(0.0, 0.2), (0.1, 0.3)], [(0.0, 0.3), (0.1, 0.2)]] {
        let united = light_through(&blocks(&parts, true), target);
        // Bounds near 0.3 m are rounded by 3e-8 m; the depth of 30 cm has ln T ≈ −1.
        assert!((united / whole - 1.0).abs() < 1e-5, "{parts:?}: {united} for {whole}");
    }
    // Without a body the rear block occludes the light of the front block.
    assert_eq!(light_through(&blocks(&[(0.0, 0.1), (0.1, 0.3)], false), target).to_bits(), 0);
}

#[test]
fn a_gap_in_a_body_is_air() {
    let target = Vec3A::new(0.1, 0.0, -0.05);
    let depth = |parts: &[(f64, f64)]| {
        let scene = objects(&blocks(parts, true));
        let found = crossings(&scene, &Ray::new(target - Vec3A::Y, Vec3A::Y));
        found.chunks(2).map(|pair| pair[1].distance_m - pair[0].distance_m).sum::<f32>()
    };
    assert!((depth(&[(0.0, 0.1), (0.4, 0.6)]) - 0.3).abs() < 1e-6);
    assert!((depth(&[(0.0, 0.1), (0.05, 0.6)]) - 0.6).abs() < 1e-6);
    // The light enters at the last exit.
    let apart = light_through(&blocks(&[(0.0, 0.1), (0.4, 0.6)], true), target);
    let mut thin = prepared(&objects(&blocks(&[(0.3, 0.6)], false)), Some(&analytic_table()));
    let same_exit = radiance(&mut thin, Vec3A::new(0.3, -2.0, 0.5), Vec3A::new(0.1, 0.3, -0.05)).0[15];
    assert!((apart / same_exit - 1.0).abs() < 1e-5, "{apart} for {same_exit}");
}

#[test]
fn a_body_does_not_occlude_area_lights_at_its_own_exits_but_other_snow_does() {
    let panel = "[[light]]\ntype = \"rectangle\"\nposition = [0.1, 2, 0.2]\nlook_at = [0, 0, 0]\nsize = [0.5, 0.5]\n\
        radiance_w_m2_sr = 10\n";
    let ball = "[[light]]\ntype = \"sphere\"\nposition = [0.1, 2, 0.2]\nradius = 0.3\nradiance_w_m2_sr = 10\n";
    let sky = "[environment]\nradiance_w_m2_sr = 1\n";
    let front = |body: &str| {
        format!(
            "[[object]]\nshape = \"box\"\nsize = [0.8, 0.1, 0.8]\nposition = [0, 0.05, 0]\nmaterial = \"snow\"\n{body}"
        )
    };
    // Behind the front, and wide enough to cover most of the sky.
    let behind = |body: &str| {
        format!(
            "[[object]]\nshape = \"box\"\nsize = [60, 0.1, 60]\nposition = [0, 0.3, 0]\nmaterial = \"snow\"\n{body}"
        )
    };
    // As deep as front and wall together, with the exits of the wall.
    let whole = "[[object]]\nshape = \"box\"\nsize = [60, 0.2, 60]\nposition = [0, 0.25, 0]\nmaterial = \"snow\"\n";
    for (light, path) in
        [panel, ball, sky].into_iter().flat_map(|light| ["normal", "brightest"].map(|path| (light, path)))
    {
        let through = |objects: &str, target: Vec3A| {
            let keys = pcasnow(&format!("path = \"{path}\"\nreflectance = 0"));
            let mut integrator = integrator(&format!("{keys}{SNOW}{objects}{light}"), Some(&analytic_table()), &[]);
            integrator.set_samples_per_pixel(256);
            f64::from(radiance(&mut integrator, Vec3A::new(0.3, -2.0, 0.5), target).0[15])
        };
        let target = Vec3A::new(0.1, 0.0, -0.05);
        let of_front = through(&front(""), target);
        let of_whole = through(whole, target + Vec3A::new(0.0, 0.15, 0.0));
        let of_one_body = through(&format!("{}{}", front("body = \"wall\"\n"), behind("body = \"wall\"\n")), target);
        let of_two = through(&format!("{}{}", front("body = \"wall\"\n"), behind("body = \"other\"\n")), target);
        assert!(of_one_body > 0.0, "{light} {path}");
        if path == "normal" {
            assert!((of_one_body / of_whole - 1.0).abs() < 1e-5, "{light}: {of_one_body} for {of_whole}");
        }
        // Through the gap of 20 cm the sky is visible within half a degree of the wall: 1/100 of the hemisphere.
        let leak = if light == sky { 0.01 * of_front } else { 0.0 };
        assert!(of_two <= leak, "{light} {path}: {of_two} of {of_front}");
    }
}

#[test]
fn an_image_of_two_halves_equals_the_image_of_the_whole() {
    let picture = |text: &str| {
        let mut scene = objects(text);
        scene.set_image_size(ImageSize { width: 24, height: 24 });
        scene.set_samples_per_pixel(Count::of(4));
        scene.set_max_bounces(Count::of(2));
        let rendering = render_all(&prepared(&scene, Some(&analytic_table())), &|_| {});
        assert_eq!(rendering.statistics.odd_depth_lines, 0);
        rendering.film
    };
    let whole = picture(&blocks(&[(-0.2, 0.2)], false));
    let halves = picture(&blocks(&[(-0.2, 0.05), (0.0, 0.2)], true));
    for (one, other) in whole.pixels().iter().zip(halves.pixels()) {
        // A sample may hit either side of an edge; the rest agrees within rounding.
        assert!((one.y - other.y).abs() <= 1e-4 * one.y.max(1e-3), "{} {}", one.y, other.y);
    }
    assert!(whole.pixels().iter().any(|xyz| xyz.y > 0.0));
}
