//! Depths through solids, inferred from the light transmitted by snow with an analytic transmittance.

use std::f64::consts::PI;

use glam::{DMat3, DVec3, Vec3A};
use snowblue_base::Count;
use snowblue_geometry::ray::Ray;
use snowblue_render::render::render_all;
use snowblue_render::scene::Scene;
use snowblue_render::scene::camera::View;
use snowblue_render::scene::film::ImageSize;

use crate::snow::{
    SNOW, analytic_table, directions, extinction_per_cm, integrator, pcasnow, point_light, prepared, radiance, scene,
    with_light_at,
};

const SIZE_M: [f64; 3] = [0.6, 0.3, 0.5];
const TURN_DEG: [f64; 3] = [20.0, -35.0, 70.0];
const POSITION_M: [f64; 3] = [0.2, 0.1, -0.3];

/// The sides of a box as quadrilaterals, oriented outwards.
const SIDES: &str = "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";

/// A PLY file of boxes, given by opposite corners, with the first `sides` sides of each.
fn boxes(corners: &[(DVec3, DVec3)], sides: usize) -> String {
    let mut vertices = String::new();
    let mut faces = String::new();
    for (number, (low, high)) in corners.iter().enumerate() {
        for bits in 0..8 {
            let pick = |axis: usize| if bits >> axis & 1 == 0 { low[axis] } else { high[axis] };
            vertices += &format!("{} {} {}\n", pick(0), pick(1), pick(2));
        }
        for side in SIDES.lines().take(sides) {
            let moved: Vec<String> = side
                .split(' ')
                .skip(1)
                .map(|index| (index.parse::<usize>().unwrap() + 8 * number).to_string())
                .collect();
            faces += &format!("4 {}\n", moved.join(" "));
        }
    }
    format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\n\
         property list uchar int vertex_indices\nend_header\n{vertices}{faces}",
        8 * corners.len(),
        sides * corners.len()
    )
}

/// One object of snow, with one light that the test moves, for PCASnow with some keys.
fn lone(object: &str, keys: &str, files: &[(&str, String)]) -> Scene {
    let text = format!(
        "{}{SNOW}[[object]]\n{object}\nmaterial = \"snow\"\n\
         [[light]]\ntype = \"point\"\nposition = [0, 0, 0]\nradiant_intensity_w_sr = 10\n",
        pcasnow(keys)
    );
    scene(&text, files)
}

/// Distances at which a ray enters and leaves the box, and the cosine at the exit; none if it misses.
fn through_box(origin: DVec3, direction: DVec3) -> Option<(f64, f64, f64)> {
    let [x, y, z] = TURN_DEG.map(f64::to_radians);
    let to_box = (DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x)).transpose();
    let (origin, direction) = (to_box * (origin - DVec3::from_array(POSITION_M)), to_box * direction);
    let half = DVec3::from_array(SIZE_M) * 0.5;
    let (a, b) = ((-half - origin) / direction, (half - origin) / direction);
    let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
    let cos = direction[a.max(b).min_position()].abs();
    (enter < leave).then_some((enter, leave, cos))
}

/// Checks the depth of a transformed box along lines in all directions.
fn check_thickness(object: &str, path: &str, files: &[(&str, String)]) {
    let placed = format!("{object}\nposition = {POSITION_M:?}\nrotation_deg = {TURN_DEG:?}");
    let (table, keys) = (analytic_table(), format!("path = \"{path}\"\nreflectance = 0"));
    let scene = lone(&placed, &keys, files);
    let centre = DVec3::from_array(POSITION_M);
    let mut checked = 0;
    for from_lamp in directions(50) {
        let lamp = (centre - from_lamp.as_dvec3() * 3.0).as_vec3a();
        let mut integrator = prepared(&with_light_at(&scene, lamp, files), Some(&table));
        let (across, up) = from_lamp.as_dvec3().any_orthonormal_pair();
        for k in 0..40 {
            let (sin, cos) = (2.4 * f64::from(k)).sin_cos();
            let aside = (across * cos + up * sin) * 0.3 * (f64::from(k) / 40.0).sqrt();
            // The light is on the same line behind the box. In all path modes but `normal` the path is this line.
            let direction = (lamp.as_dvec3() - (centre + aside)).normalize();
            let eye = centre + aside - direction * 3.0;
            let Some((enter, leave, cos)) = through_box(eye, direction) else {
                continue;
            };
            if leave - enter < 1e-3 {
                // Too close to an edge for the single precision of camera rays.
                continue;
            }
            let seen = radiance(&mut integrator, eye.as_vec3a(), (eye + direction * enter).as_vec3a());
            let beyond_m = lamp.as_dvec3().distance(eye + direction * leave);
            let irradiance = f64::from(point_light(integrator.scene()).intensity.0[15]) * cos / (beyond_m * beyond_m);
            let angle_deg = cos.acos().to_degrees().min(89.0);
            let depth_cm =
                -(f64::from(seen.0[15]) * PI / irradiance).ln() / (extinction_per_cm(15) * (1.0 + angle_deg / 100.0));
            // Coordinates near 3 m are rounded by 2e-7 m, which oblique exits divide by the cosine. The arc cosine near
            // 1 has an error of 0.02°.
            let allowed_cm = 1e-4 * depth_cm + 1e-3 / cos;
            let expected_cm = 100.0 * (leave - enter);
            assert!((depth_cm - expected_cm).abs() < allowed_cm, "{lamp} {k}: {depth_cm} cm for {expected_cm} cm");
            checked += 1;
        }
    }
    assert!(checked > 1500, "{checked}");
}

#[test]
fn boxes_have_the_exact_depth_in_every_direction() {
    for path in ["view", "light"] {
        check_thickness(&format!("shape = \"box\"\nsize = {SIZE_M:?}"), path, &[]);
    }
}

#[test]
fn boxes_of_triangles_have_the_exact_depth_in_every_direction() {
    let half = DVec3::from_array(SIZE_M) * 0.5;
    let file = boxes(&[(-half, half)], 6);
    check_thickness("mesh = \"box.ply\"", "view", &[("box.ply", file.clone())]);
    // The same box from half the size, scaled by 2.
    let small = boxes(&[(-half * 0.5, half * 0.5)], 6);
    check_thickness("mesh = \"box.ply\"\nscale = 2", "light", &[("box.ply", small)]);
}

#[test]
fn depth_is_the_sum_up_to_the_last_exit() {
    // One object of two walls, 10 cm and 20 cm thick, 30 cm apart, under light along the view.
    let walls = [
        (DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 0.1, 1.0)),
        (DVec3::new(-1.0, 0.4, -1.0), DVec3::new(1.0, 0.6, 1.0)),
    ];
    let files = [("walls.ply", boxes(&walls, 6))];
    let scene = lone("mesh = \"walls.ply\"", "path = \"view\"\nreflectance = 0", &files);
    let scene = with_light_at(&scene, Vec3A::new(0.2, 9.0, 0.3), &files);
    let mut integrator = prepared(&scene, Some(&analytic_table()));
    let seen = radiance(&mut integrator, Vec3A::new(0.2, -3.0, 0.3), Vec3A::new(0.2, 0.0, 0.3));
    let irradiance = f64::from(point_light(integrator.scene()).intensity.0[15]) / 8.4f64.powi(2);
    let fraction = PI * f64::from(seen.0[15]) / irradiance;
    assert!((fraction.ln() + extinction_per_cm(15) * 30.0).abs() < 1e-4, "{fraction}");
}

#[test]
fn lines_through_open_meshes_are_counted() {
    let corners = [(DVec3::splat(-0.5), DVec3::splat(0.5))];
    for (sides, open) in [(6, false), (5, true)] {
        let files = [("box.ply", boxes(&corners, sides))];
        let scene = lone("mesh = \"box.ply\"\nrotation_deg = [10, 20, 30]", "", &files);
        let mut scene = with_light_at(&scene, Vec3A::new(-1.0, 3.0, 1.0), &files);
        scene.set_image_size(ImageSize { width: 40, height: 40 });
        scene.set_samples_per_pixel(Count::of(4));
        let view =
            View { position: Vec3A::new(1.0, -3.0, 1.0), look_at: Vec3A::ZERO, up: Vec3A::Z, vertical_fov_deg: 30.0 };
        assert!(scene.set_view(&view));
        let statistics = render_all(&prepared(&scene, Some(&analytic_table())), &|_| {}).statistics;
        assert!(statistics.depth_lines > 1000, "{statistics:?}");
        assert_eq!(statistics.odd_depth_lines > 100, open, "{statistics:?}");
        assert_eq!(statistics.odd_depth_lines == 0, !open, "{statistics:?}");
    }
}

#[test]
fn scenes_of_many_objects_use_the_bvh_over_objects() {
    // Enough objects for a BVH over objects.
    let text: String = (0..40)
        .map(|k| {
            format!(
                "[[object]]\nshape = \"box\"\nsize = [0.5, 0.5, 0.5]\nposition = [{k}, 0, 0]\nmaterial = \"snow\"\n"
            )
        })
        .collect();
    let light = "[environment]\nradiance_w_m2_sr = 1\n";
    let scene = scene(&format!("{SNOW}{text}{light}"), &[]);
    for k in 0..40 {
        let ray = Ray::new(Vec3A::new(k as f32 + 0.1, -5.0, 0.1), Vec3A::Y);
        assert_eq!(scene.objects().first_hit(&ray).unwrap().object, k);
        assert!(scene.objects().any_hit(&ray, 5.0) && !scene.objects().any_hit(&ray, 4.7));
    }
}

/// Includes directions along the axes, with zeros of either sign, and faces that receive light through the other wall.
#[test]
fn two_walls_in_a_mesh_look_like_two_boxes() {
    let walls = [
        (DVec3::new(-1.0, -0.3, -1.0), DVec3::new(1.0, -0.2, 1.0)),
        (DVec3::new(-1.0, 0.2, -1.0), DVec3::new(1.0, 0.4, 1.0)),
    ];
    let light = "[[light]]\ntype = \"point\"\nposition = [0.1, 2.0, 0.2]\nradiant_intensity_w_sr = 10\n";
    for path in ["normal", "light", "brightest"] {
        let keys = pcasnow(&format!("path = \"{path}\"\nreflectance = 0"));
        let mesh = format!("{keys}{SNOW}[[object]]\nmesh = \"walls.ply\"\nmaterial = \"snow\"\n{light}");
        let mut one = integrator(&mesh, Some(&analytic_table()), &[("walls.ply", boxes(&walls, 6))]);
        let of_box = |(low, high): &(DVec3, DVec3)| {
            let (size, middle) = (*high - *low, 0.5 * (*low + *high));
            format!(
                "[[object]]\nshape = \"box\"\nsize = [{}, {}, {}]\nposition = [{}, {}, {}]\nmaterial = \"snow\"\n",
                size.x, size.y, size.z, middle.x, middle.y, middle.z
            )
        };
        let apart = format!("{keys}{SNOW}{}{}{light}", of_box(&walls[0]), of_box(&walls[1]));
        let mut two = integrator(&apart, Some(&analytic_table()), &[]);
        // From between the walls: the face of the lit wall transmits light, that of the shadowed wall does not.
        for (target, is_lit) in [(Vec3A::new(0.3, 0.2, 0.1), true), (Vec3A::new(0.3, -0.2, 0.1), false)] {
            let eye = Vec3A::new(0.0, 0.05, 0.0);
            let (a, b) = (radiance(&mut one, eye, target), radiance(&mut two, eye, target));
            assert_eq!(b.mean() > 1e-9, is_lit, "{path} {target}: {}", b.mean());
            assert!((a.mean() - b.mean()).abs() <= 1e-4 * b.mean(), "{path} {target}: {} {}", a.mean(), b.mean());
        }
    }
}
