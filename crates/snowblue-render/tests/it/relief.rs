//! Snow with relief: heights that belong to the object, closed meshes, and what they do not cut.
//! [`truth`](crate::truth) has its light.

use glam::{Mat3A, Vec3A};
use snowblue_geometry::ray::Ray;
use snowblue_geometry::topology::{Topology, volume};
use snowblue_geometry::triangle_mesh::TriangleMesh;
use snowblue_render::files::FilesInMemory;
use snowblue_render::scene::{Changes, Scene};
use snowblue_render::{SceneDescription, SceneFile};
use snowblue_stat::Moments;

/// The part of the way to the next surface that a vertex may move.
const OF_WAY: f32 = 1.0 / 3.0;
const LAMP: &str = "[[light]]\ntype = \"directional\"\ndirection = [1, 1, -1]\nirradiance_w_m2 = 100\n";
/// A block of 10 × 10 × 3 cm whose top is at z = 0.
const BLOCK: &str =
    "[[object]]\nshape = \"box\"\nsize = [0.1, 0.1, 0.03]\nposition = [0, 0, -0.015]\nmaterial = \"snow\"\n";

/// A scene of things with a relief, seen from a place over its middle.
fn description(relief: &str, eye: [f64; 3], things: &str) -> SceneDescription {
    let text = format!(
        "[camera]\nposition = {eye:?}\nlook_at = [0, 0, 0]\nvertical_fov_deg = 40\n[film]\nwidth = 320\nheight = 240\n\
         [material.snow]\ntype = \"snow\"\nrelief = {relief}\n[material.floor]\ntype = \"diffuse\"\nreflectance = 0.5\n\
         {LAMP}{things}"
    );
    SceneFile::parse(text, "scene.toml").unwrap_or_else(|error| panic!("{error}")).description
}

fn scene(relief: &str, eye: [f64; 3], things: &str) -> Scene {
    description(relief, eye, things).build(&FilesInMemory::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn mesh(scene: &Scene, object: usize) -> &TriangleMesh {
    scene.objects().list()[object].shape.mesh().unwrap().triangles()
}

/// Heights of the surface at places on a grid, found by rays from above.
fn heights(scene: &Scene, places: impl Iterator<Item = [f32; 2]>) -> Vec<f32> {
    let down = |[x, y]: [f32; 2]| Ray::new(Vec3A::new(x, y, 1.0), Vec3A::NEG_Z);
    places.map(|place| scene.objects().first_hit(&down(place)).unwrap().point.z).collect()
}

fn grid(side: u16, step_m: f32) -> impl Iterator<Item = [f32; 2]> {
    let at = move |k: u16| (f32::from(k) - 0.5 * f32::from(side - 1)) * step_m;
    (0..side * side).map(move |k| [at(k % side), at(k / side)])
}

/// The sizes of 80 mm hold 25 × 25 correlation lengths: the variance of the heights is known to √(2π/625) = 10 %, and
/// their root mean square to 5 %. The test takes 3 of these.
#[test]
fn rendered_surfaces_have_the_stated_heights() {
    let scene = scene("{ height_mm = 0.3, correlation_mm = 3.2 }", [0.0, -0.05, 0.15], BLOCK);
    let heights = heights(&scene, grid(81, 1e-3));
    let square: f32 = heights.iter().map(|height| height * height).sum::<f32>() / heights.len() as f32;
    assert!((square.sqrt() / 3e-4 - 1.0).abs() < 0.15, "{}", square.sqrt());
}

#[test]
fn heights_stay_when_the_camera_moves_and_move_with_the_object() {
    // All wavelengths are wider than two edges in both pictures.
    let relief = "{ height_mm = 0.5, correlation_mm = 12, hurst = 0.9 }";
    let one = scene(relief, [0.0, -0.03, 0.1], BLOCK);
    let other = scene(relief, [0.03, 0.05, 0.07], BLOCK);
    assert_ne!(mesh(&one, 0).positions.len(), mesh(&other, 0).positions.len());
    let [heights_m, others_m] = [&one, &other].map(|scene| heights(scene, grid(30, 5e-4)));
    let difference = |one: &[f32], other: &[f32]| {
        let sum: f32 = one.iter().zip(other).map(|(one, other)| (one - other).powi(2)).sum();
        (sum / one.len() as f32).sqrt()
    };
    // Flat triangles with edges of 0.45 mm cut off some of the waves of 2 mm, which are 0.04 mm high.
    assert!(difference(&heights_m, &others_m) < 2.5e-5, "{}", difference(&heights_m, &others_m));
    assert!(difference(&heights_m, &[0.0; 900]) > 2e-4);
    // The same block, turned by 30° and 4 cm away.
    let turned = BLOCK.replace("position = [0, 0, -0.015]", "position = [0.04, 0, -0.015]\nrotation_deg = [0, 0, 30]");
    let turned = scene(relief, [0.04, -0.03, 0.1], &turned);
    let place = |[x, y]: [f32; 2]| {
        let place = Mat3A::from_rotation_z(30f32.to_radians()) * Vec3A::new(x, y, 0.0);
        [place.x + 0.04, place.y]
    };
    let moved_m = heights(&turned, grid(30, 5e-4).map(place));
    assert!(difference(&heights_m, &moved_m) < 2.5e-5, "{}", difference(&heights_m, &moved_m));
    let another = scene("{ height_mm = 0.5, correlation_mm = 12, hurst = 0.9, seed = 2 }", [0.0, -0.03, 0.1], BLOCK);
    assert!(difference(&heights_m, &heights(&another, grid(30, 5e-4))) > 2e-4);
}

#[test]
fn rough_solids_are_closed() {
    let ball = "[[object]]\nshape = \"sphere\"\nradius = 0.04\nmaterial = \"snow\"\n";
    let stretched = format!("{ball}scale = [1, 2, 0.5]\nrotation_deg = [10, 20, 30]\n");
    let drift = "[[object]]\nshape = \"drift\"\nsize = [0.3, 0.3, 0.05]\nmounds = [[0, 0, 0.03, 0.08]]\n\
                 material = \"snow\"\n";
    let ball_m3 = 4.0 / 3.0 * std::f64::consts::PI * 0.04f64.powi(3);
    for (things, volume_m3) in [(BLOCK, 3e-4), (ball, ball_m3), (&*stretched, ball_m3), (drift, 0.0)] {
        let scene = scene("{ height_mm = 0.8, correlation_mm = 6 }", [0.0, -0.2, 0.2], things);
        let mesh = mesh(&scene, 0);
        let topology = Topology::of(mesh);
        assert!(topology.is_closed() && topology.reversed_edges == 0, "{things}: {topology:?}");
        assert!(mesh.indices.len() > 30_000, "{things}: {} triangles", mesh.indices.len());
        // The mean height of a face is 0 within 0.8 mm over the root of its number of correlation lengths.
        if volume_m3 > 0.0 {
            assert!((volume(mesh) / volume_m3 - 1.0).abs() < 0.02, "{things}: {}", volume(mesh));
        }
    }
}

/// A plate of 2 mm, with heights of 3 mm: opposite sides move toward each other by less than two thirds.
#[test]
fn thin_snow_does_not_cut_itself() {
    let plate = "[[object]]\nshape = \"box\"\nsize = [0.1, 0.1, 0.002]\nmaterial = \"snow\"\n";
    let scene = scene("{ height_mm = 3, correlation_mm = 40, hurst = 0.9 }", [0.0, -0.05, 0.15], plate);
    let mut crossings = Vec::new();
    let (mut least_m, mut greatest_m) = (f32::INFINITY, 0f32);
    for [x, y] in grid(40, 2e-3) {
        let down = Ray::new(Vec3A::new(x, y, 1.0), Vec3A::NEG_Z);
        assert!(!scene.objects().segments(0, &down, f32::INFINITY, &mut crossings));
        assert_eq!(crossings.len(), 2, "{x} {y}");
        let thickness_m = (crossings[0].distance_m - crossings[1].distance_m).abs();
        (least_m, greatest_m) = (least_m.min(thickness_m), greatest_m.max(thickness_m));
    }
    assert!(least_m > 0.3 * 0.002 && greatest_m > 0.004, "{least_m} {greatest_m}");
    // Where a side moves inwards at all, it moves on as far as it may: no place between stays where it was.
    let moved_m: Vec<f32> = heights(&scene, grid(40, 2e-3)).iter().map(|height| height - 0.001).collect();
    let deepest_m = moved_m.iter().copied().fold(0.0, f32::min);
    assert!(deepest_m < -0.9 * OF_WAY * 0.002, "{deepest_m}");
    let unmoved = moved_m.iter().filter(|moved| moved.abs() < 5e-5).count();
    // Of a standard normal distribution 1.3 % lie within 1/60. The spread of 1,600 places is that of some 12.
    assert!(unmoved < 1600 / 12, "{unmoved}");
}

/// The face of a ball of 0.5 m towards the camera, with triangles finer than those of the smooth ball. It holds some 37
/// × 37 correlation lengths, so that the mean height is known to 7 % of the RMS height and the latter to 4 %. Waves of
/// some pixels are left out.
#[test]
fn balls_are_rough_outwards_and_inwards() {
    let ball = "[[object]]\nshape = \"sphere\"\nradius = 0.5\nmaterial = \"snow\"\n";
    let scene = scene("{ height_mm = 0.5, correlation_mm = 8, hurst = 0.9 }", [0.0, -1.2, 0.0], ball);
    let mut moments = Moments::default();
    for [x, z] in grid(40, 7.5e-3) {
        let direction = -Vec3A::new(x, -0.5, z).normalize();
        let hit = scene.objects().first_hit(&Ray::new(-direction, direction)).unwrap();
        moments.push(f64::from(hit.point.length() - 0.5) / 5e-4);
    }
    let (mean, deviation) = (moments.mean(), moments.standard_error() * 40.0);
    assert!(mean.abs() < 0.21 && (0.8..1.12).contains(&deviation), "{mean} {deviation}");
}

/// Snow on a floor does not reach through it, and two blocks that touch stay one piece.
#[test]
fn surfaces_that_touch_stay_together() {
    let half = |x: f64| {
        format!(
            "[[object]]\nshape = \"box\"\nsize = [0.05, 0.1, 0.03]\nposition = [{x}, 0, 0.015]\nmaterial = \"snow\"\n\
             body = \"block\"\n"
        )
    };
    let floor = "[[object]]\nshape = \"plane\"\nmaterial = \"floor\"\n";
    let things = format!("{}{}{floor}", half(-0.025), half(0.025));
    let scene = scene("{ height_mm = 0.6, correlation_mm = 5 }", [0.05, -0.2, 0.1], &things);
    for object in [0, 1] {
        let frame_m = 0.015;
        let lowest_m = mesh(&scene, object).positions.iter().map(|at| at.z + frame_m).fold(f32::INFINITY, f32::min);
        assert!(lowest_m > -1e-6, "{lowest_m}");
    }
    let mut crossings = Vec::new();
    for [y, z] in grid(20, 1e-3) {
        let along = Ray::new(Vec3A::new(-1.0, y, z + 0.015), Vec3A::X);
        assert!(!scene.objects().segments(0, &along, f32::INFINITY, &mut crossings));
        assert_eq!(crossings.len(), 2, "no gap at the joint: {y} {z}");
    }
}

#[test]
fn a_scene_that_is_built_after_another_has_triangles_for_its_own_camera() {
    let first = description("\"fresh\"", [0.0, -0.2, 0.1], BLOCK);
    let second = description("\"fresh\"", [0.1, -0.2, 0.1], BLOCK);
    let changes = Changes::new(&first, &second);
    assert!(!changes.solids && changes.grids, "the body differs");
    let files = FilesInMemory::default();
    let after = second.build_after(&first.build(&files).unwrap(), &files).unwrap();
    assert!(mesh(&after, 0) == mesh(&second.build(&files).unwrap(), 0));
    let mut smooth = [first, second];
    for scene in &mut smooth {
        let text = scene.materials.remove("floor").unwrap();
        scene.materials.clear();
        scene.materials.insert("snow".to_owned(), text);
    }
    assert!(!Changes::new(&smooth[0], &smooth[1]).grids, "without relief the camera does not matter");
}

#[test]
fn masked_snow_with_relief_needs_a_mesh() {
    let relief = "\"fresh\"\nmask = { attribute = \"age\", range = [0, 1] }\n\
                  between = [{ grain_size_um = 200 }, { grain_size_um = 800 }]";
    let error = description(relief, [0.0, -0.2, 0.1], BLOCK).build(&FilesInMemory::default()).unwrap_err().to_string();
    assert!(error.contains("a mask together with a relief needs a mesh"), "{error}");
}
