//! The scenes on which integrators are compared with the reference.

use std::f64::consts::TAU;
use std::fmt::Write;

use glam::{DVec3, Vec3A};
use snowblue_render::{SceneDescription, SceneFile};

use crate::snow::block_of_ages;

/// Cells of a picture along each side.
const SIDE: usize = 4;
/// Limits of `hybrid`, where a scene has no others.
const HYBRID_LIMITS: Limits = Limits { energy: 0.05, cells: 0.08 };
/// Snow of which ℓ* is 2.0 mm.
const SNOW: &str = "grain_size_um = 400\nfacetness = 0.3\ndensity_kg_m3 = 300\n";
const LENGTH_M: f64 = 0.002;
/// As low as 35°.
const LOW_SUN: &str = "[[light]]\ntype = \"directional\"\ndirection = [1, 1, -1]\nirradiance_w_m2 = 100\n";
const SKY: &str = "[environment]\nradiance_w_m2_sr = 1\n";

/// Greatest errors.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    pub(super) energy: f64,
    pub(super) cells: f64,
}

/// What is seen of a scene.
pub(super) enum Camera {
    /// A picture of 4 × 4 cells of what lies within a radius, in m, of the origin, from a direction.
    Picture { radius_m: f64, from: [f64; 3] },
    /// Points, each from the position of a camera.
    Points(Vec<[Vec3A; 2]>),
}

/// A scene, what the integrators may err by, and what is seen of it.
pub(super) struct Scene {
    pub(super) name: &'static str,
    pub(super) hybrid: Limits,
    pub(super) diffusion: Limits,
    /// Keys of the snow.
    snow: String,
    /// Objects and lights.
    content: String,
    pub(super) camera: Camera,
    pub(super) files: Vec<(&'static str, String)>,
    /// Samples per cell of each rendering of the reference.
    pub(super) samples: u32,
}

impl Scene {
    /// A scene of the default snow, seen from the front. The limits of `diffusion` are those of energy and of cells.
    fn new(name: &'static str, diffusion: [f64; 2], radius_m: f64, content: String) -> Self {
        let [energy, cells] = diffusion;
        Self {
            name,
            hybrid: HYBRID_LIMITS,
            diffusion: Limits { energy, cells },
            snow: SNOW.to_owned(),
            content,
            camera: Camera::Picture { radius_m, from: [0.0, -1.0, 0.3] },
            files: Vec::new(),
            samples: 4096,
        }
    }

    fn with_snow(self, snow: &str) -> Self {
        Self { snow: snow.to_owned(), ..self }
    }

    fn with_file(mut self, name: &'static str, text: String) -> Self {
        self.files.push((name, text));
        self
    }

    fn with_hybrid(self, energy: f64, cells: f64) -> Self {
        Self { hybrid: Limits { energy, cells }, ..self }
    }

    fn with_samples(self, samples: u32) -> Self {
        Self { samples, ..self }
    }

    fn seen_from(self, from: [f64; 3]) -> Self {
        let Camera::Picture { radius_m, .. } = self.camera else { panic!("points have cameras of their own") };
        Self { camera: Camera::Picture { radius_m, from }, ..self }
    }

    /// Points instead of a picture.
    fn at(self, points: Vec<[Vec3A; 2]>) -> Self {
        Self { camera: Camera::Points(points), ..self }
    }

    pub(super) fn description(&self) -> SceneDescription {
        let ([x, y, z], side) = match &self.camera {
            Camera::Picture { radius_m, from } => (from.map(|coordinate| 20.0 * radius_m * coordinate), SIDE),
            // Points have cameras of their own.
            Camera::Points(_) => ([0.0, -9.0, 0.0], 1),
        };
        let text = format!(
            "[camera]\nposition = [{x}, {y}, {z}]\nlook_at = [0, 0, 0]\nvertical_fov_deg = 5\n[film]\n\
             width = {side}\nheight = {side}\n[material.snow]\ntype = \"snow\"\n{}{}",
            self.snow, self.content
        );
        SceneFile::parse(text, self.name).unwrap().description
    }
}

fn point(position: [f64; 3]) -> String {
    format!("[[light]]\ntype = \"point\"\nposition = {position:?}\nradiant_intensity_w_sr = 5\n")
}

fn object(shape: &str) -> String {
    format!("[[object]]\n{shape}\nmaterial = \"snow\"\n")
}

fn mesh() -> String {
    object("mesh = \"mesh.obj\"\nup = \"z\"")
}

/// A ball of a radius in transport mean free paths, with the lamp behind.
fn ball(name: &'static str, lengths: f64, diffusion: [f64; 2]) -> Scene {
    let radius_m = lengths * LENGTH_M;
    let lamp = point([2.5, 20.0, 5.0].map(|coordinate| coordinate * radius_m));
    Scene::new(name, diffusion, radius_m, object(&format!("shape = \"sphere\"\nradius = {radius_m}")) + &lamp)
        .with_samples(if lengths > 25.0 { 10_000 } else { 16_384 })
}

/// The shadow of a plate on thick snow, with cells of forty transport mean free paths. In the shadow, which has a sixth
/// of the light around it, the light that cells of 8 mm spread into the shadow is missing: 2 % of the light around.
fn shadow() -> Scene {
    let block = object("shape = \"box\"\nsize = [0.8, 0.8, 0.3]\nposition = [0, 0, -0.15]");
    let plate = "[material.dark]\ntype = \"diffuse\"\nreflectance = 0\n\
                 [[object]]\nshape = \"box\"\nsize = [0.12, 0.12, 0.005]\nposition = [-0.1, -0.1, 0.1]\n\
                 material = \"dark\"\n[environment]\nradiance_w_m2_sr = 3\n[light_field]\nstep_mm = 80\n";
    Scene::new("shadow", [0.03, 0.13], 0.06, block + plate + LOW_SUN)
        .with_hybrid(0.03, 0.13)
        .seen_from([0.3, -1.0, 1.2])
        .with_samples(512)
}

/// A thin sheet above a plain of snow, between the camera and a sun of 12°: the plain reflects the sun forwards.
fn low_sun() -> Scene {
    let content = "[[object]]\nshape = \"box\"\nsize = [0.4, 0.003, 0.4]\nmaterial = \"snow\"\n\
                   [[object]]\nshape = \"plane\"\nposition = [0, 0, -2]\nmaterial = \"snow\"\n\
                   [[light]]\ntype = \"directional\"\ndirection = [0.413, -0.886, -0.208]\n\
                   irradiance_w_m2 = 100\n";
    Scene::new("low_sun", [0.05, 0.05], 0.02, content.to_owned())
        .with_snow("snow = \"fresh\"\ndensity_kg_m3 = 120\n")
        .with_hybrid(0.04, 0.05)
        .seen_from([0.0, -1.0, 0.0])
        .with_samples(4096)
}

/// A closed surface as an OBJ file, by a function of two angles.
fn closed(counts: [u32; 2], place: impl Fn(f64, f64) -> [f64; 3]) -> String {
    let (mut text, [around, across]) = (String::new(), counts);
    for i in 0..around {
        for j in 0..across {
            let [x, y, z] = place(TAU * f64::from(i) / f64::from(around), TAU * f64::from(j) / f64::from(across));
            writeln!(text, "v {x} {y} {z}").unwrap();
        }
    }
    for i in 0..around {
        for j in 0..across {
            let at = |i: u32, j: u32| (i % around) * across + j % across + 1;
            writeln!(text, "f {} {} {} {}", at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)).unwrap();
        }
    }
    text
}

fn torus() -> String {
    closed([160, 64], |u, v| {
        let small = 0.02 * (1.0 + 0.08 * (5.0 * u).sin() * (3.0 * v).cos());
        let large = 0.05 + small * v.cos();
        [large * u.cos(), large * u.sin(), small * v.sin()]
    })
}

/// A trefoil knot.
fn knot() -> String {
    let middle = |t: f64| {
        let large = 0.03 * (2.0 + (3.0 * t).cos());
        DVec3::new(large * (2.0 * t).cos(), large * (2.0 * t).sin(), 0.036 * (3.0 * t).sin())
    };
    closed([400, 48], |u, v| {
        let along = (middle(u + 1e-4) - middle(u - 1e-4)).normalize();
        let side = along.cross(DVec3::Z).normalize();
        (middle(u) + 0.018 * (v.cos() * side + v.sin() * along.cross(side))).to_array()
    })
}

/// A prism of a length along z over a polygon of x and y that runs counter-clockwise, cut into `strips`.
fn prism(polygon: &[[f64; 2]], strips: &[&[usize]], length_m: f64) -> String {
    let (mut text, count) = (String::new(), polygon.len());
    for z in [-0.5 * length_m, 0.5 * length_m] {
        polygon.iter().for_each(|[x, y]| writeln!(text, "v {x} {y} {z}").unwrap());
    }
    for side in 0..count {
        let next = (side + 1) % count;
        writeln!(text, "f {} {} {} {}", side + 1, next + 1, next + 1 + count, side + 1 + count).unwrap();
    }
    for strip in strips {
        let upper: Vec<String> = strip.iter().map(|vertex| (vertex + 1 + count).to_string()).collect();
        let lower: Vec<String> = strip.iter().rev().map(|vertex| (vertex + 1).to_string()).collect();
        writeln!(text, "f {}\nf {}", upper.join(" "), lower.join(" ")).unwrap();
    }
    text
}

/// An L of two walls, 4 cm thick.
fn corner() -> String {
    let polygon = [[-0.06, -0.06], [-0.02, -0.06], [-0.02, 0.02], [0.06, 0.02], [0.06, 0.06], [-0.06, 0.06]];
    // Both walls meet at vertex 2; the long one has a vertex more at its end.
    let polygon =
        [polygon[0], polygon[1], polygon[2], polygon[3], polygon[4], [-0.02, 0.06], polygon[5], [-0.06, 0.02]];
    prism(&polygon, &[&[0, 1, 2, 7], &[7, 2, 5, 6], &[2, 3, 4, 5]], 0.1)
}

/// A block with a groove in its front, 8 mm wide and 16 mm deep.
fn groove() -> String {
    let polygon = [
        [-0.05, -0.03],
        [-0.004, -0.03],
        [-0.004, -0.014],
        [0.004, -0.014],
        [0.004, -0.03],
        [0.05, -0.03],
        [0.05, 0.03],
        [0.004, 0.03],
        [-0.004, 0.03],
        [-0.05, 0.03],
    ];
    prism(&polygon, &[&[0, 1, 2, 8, 9], &[2, 3, 7, 8], &[3, 4, 5, 6, 7]], 0.1)
}

fn boxed(size: [f64; 3]) -> String {
    object(&format!("shape = \"box\"\nsize = {size:?}"))
}

/// Points seen from an offset of the camera.
fn seen_from_offset(offset: Vec3A, points: &[[f32; 3]]) -> Vec<[Vec3A; 2]> {
    points.iter().map(|point| [Vec3A::from(*point) + offset, Vec3A::from(*point)]).collect()
}

/// A plate of two snows with a plane boundary over a wide lamp, seen far from the boundary and within ℓ* of it.
fn boundary() -> Scene {
    let wide = "[light_field]\nstep_mm = 2\n[[light]]\ntype = \"rectangle\"\nposition = [0, 0, -1]\n\
                look_at = [0, 0, 0]\nup = [0, 1, 0]\nsize = [20, 20]\nradiance_w_m2_sr = 1\n";
    let ages = [(-0.08, 0.0), (-0.0005, 0.0), (0.0005, 1.0), (0.08, 1.0)];
    let points = [-0.05, -0.003, 0.003, 0.05].map(|x| [x, 0.003, 0.005]);
    Scene::new("boundary", [0.03, 0.03], 0.0, object("mesh = \"mesh.ply\"\nup = \"z\"") + wide)
        .with_hybrid(0.03, 0.03)
        .with_snow("mask = { attribute = \"age\" }\nbetween = [{ grain_size_um = 200 }, { grain_size_um = 400 }]\n")
        .with_file("mesh.ply", block_of_ages([0.03, 0.005], &ages))
        .at(seen_from_offset(Vec3A::new(0.2, -0.5, 1.0), &points))
        .with_samples(2048)
}

/// Coarse snow that is wet and dirty, seen from above and from below.
fn wet_and_dirty() -> Scene {
    let from = |up: f32| {
        let point = Vec3A::new(0.01, 0.003, 0.03 * up);
        [point + Vec3A::new(0.2, -0.5, up), point]
    };
    Scene::new("wet_and_dirty", [0.03, 0.03], 0.0, boxed([0.2, 0.15, 0.06]) + SKY)
        .with_hybrid(0.03, 0.03)
        .with_snow(
            "grain_size_um = 1000\ndensity_kg_m3 = 400\nwater_saturation = 0.1\n\
             impurities_ng_g = { black-carbon = 50, saharan-dust = 2000 }\n",
        )
        .at(vec![from(1.0), from(-1.0)])
        .with_samples(256)
}

/// Fine dense snow on coarse loose snow, seen from above, from below, and on the side above and below the boundary.
fn two_layers() -> Scene {
    let pack = "[[layer]]\nthickness_cm = 1\ngrain_size_um = 200\ndensity_kg_m3 = 350\n\
                [[layer]]\nthickness_cm = 2\ngrain_size_um = 800\ndensity_kg_m3 = 250\n";
    let points = [
        [[0.3, 0.2, 2.0], [0.003, 0.002, 0.015]],
        [[0.3, 0.2, -2.0], [0.003, 0.002, -0.015]],
        [[0.1, -2.0, 0.2], [0.0, -0.05, 0.01]],
        [[0.1, -2.0, -0.2], [0.0, -0.05, -0.005]],
    ];
    Scene::new("two_layers", [0.005, 0.005], 0.0, boxed([0.1, 0.1, 0.03]) + SKY)
        .with_hybrid(0.005, 0.005)
        .with_snow("layers = \"pack.toml\"\n")
        .with_file("pack.toml", pack.to_owned())
        .at(points.map(|point| point.map(Vec3A::from)).to_vec())
        .with_samples(256)
}

/// The wall of a narrow hole, at three depths. It is two degrees off the vertical, and seen past the opposite rim.
/// Light goes back and forth in the hole, and hardly any is lost from one reflection to the next.
fn hole() -> Scene {
    let drift = object("shape = \"drift\"\nsize = [0.4, 0.4, 0.2]\nrelief = 0");
    let hole = "[[object.imprint]]\ntype = \"hole\"\nposition = [0, 0]\nradius = 0.012\ndepth = 0.12\n";
    let point = |depth_m: f32| {
        let point = Vec3A::new(0.012 - 0.035 * depth_m, 0.0, -depth_m);
        [point + (Vec3A::new(-0.009, 0.0, 0.0) - point).normalize() * 3.0, point]
    };
    Scene::new("hole", [0.02, 0.02], 0.0, drift + hole + SKY)
        .with_hybrid(0.02, 0.02)
        .at([0.01, 0.04, 0.11].map(point).to_vec())
        .with_samples(64)
}

/// A cave with a narrow opening, seen from within. Light comes through the opening and through the snow.
fn cave() -> Scene {
    let carved = object("shape = \"carved\"\ncell = 0.004");
    let solids = "[[object.add]]\ntype = \"box\"\ncentre = [0, 0, 0]\nsize = [0.4, 0.4, 0.3]\n\
                  [[object.remove]]\ntype = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = [0.07, 0.07, 0.07]\n\
                  [[object.remove]]\ntype = \"capsule\"\nfrom = [0, 0, 0]\nto = [0, 0, 0.2]\nradius = 0.012\n";
    let points = [[0.0, 0.0, -0.07], [0.07, 0.0, 0.0], [0.06, 0.0, 0.036]];
    Scene::new("cave", [0.04, 0.04], 0.0, carved + solids + SKY)
        .at(points.map(|point| [Vec3A::new(-0.03, 0.01, 0.0), Vec3A::from(point)]).to_vec())
        .with_samples(64)
}

/// The table of scenes.
pub(super) fn scenes() -> Vec<Scene> {
    let behind = point([0.05, 0.4, 0.1]);
    let front = point([0.4, -0.5, 0.4]);
    let igloo = "shape = \"igloo\"\ninner_radius = 0.5\nwall = 0.03\ncourses = 8\nblock_width = 0.125\n\
                 seam_depth = 0.0075\nseam_width = 0.015\nposition = [0, 0.5, -0.1]";
    let sun = "[[light]]\ntype = \"directional\"\ndirection = [-1, 1, -1]\nirradiance_w_m2 = 100\n";
    let lamp = "[[light]]\ntype = \"sphere\"\nposition = [0, 0.01, 0]\nradius = 0.016\nradiance_w_m2_sr = 1000\n";
    let gap = |x: f64| object(&format!("shape = \"box\"\nsize = [0.05, 0.06, 0.1]\nposition = [{x}, 0, 0]"));
    let floor = "[material.floor]\ntype = \"diffuse\"\nreflectance = 0.6\n[[object]]\nshape = \"plane\"\n\
                 position = [0, 0, -0.05]\nmaterial = \"floor\"\n";
    // A tenth of its light passes straight through half a transport mean free path of snow.
    let below = "[[light]]\ntype = \"sphere\"\nposition = [0, 0, -0.05]\nradius = 0.01\nradiance_w_m2_sr = 1\n";
    let through = [-0.004, 0.0, 0.004].map(|x| [-0.004, 0.0, 0.004].map(|y| [x, y, 0.0005])).concat();
    let masked = "mask = { attribute = \"age\", range = [0, 1] }\nbetween = [{ grain_size_um = 200 }, \
                  { grain_size_um = 800 }]\n";
    vec![
        ball("ball_2_5", 2.5, [0.70, 0.66]),
        ball("ball_5", 5.0, [0.54, 0.46]),
        ball("ball_10", 10.0, [0.36, 0.28]),
        ball("ball_25", 25.0, [0.19, 0.12]),
        ball("ball_50", 50.0, [0.10, 0.11]),
        Scene::new("torus", [0.07, 0.07], 0.07, mesh() + &front).with_file("mesh.obj", torus()),
        Scene::new("knot_sun", [0.07, 0.07], 0.11, mesh() + sun).with_file("mesh.obj", knot()),
        Scene::new("corner", [0.03, 0.05], 0.075, mesh() + floor + &front)
            .with_file("mesh.obj", corner())
            .seen_from([0.7, -0.7, 0.3])
            .with_samples(1024),
        Scene::new("groove", [0.03, 0.05], 0.05, mesh() + &front).with_file("mesh.obj", groove()),
        Scene::new("gap", [0.05, 0.08], 0.05, gap(-0.028) + &gap(0.028) + &behind),
        Scene::new("plate", [0.03, 0.05], 0.06, boxed([0.1, 2.5 * LENGTH_M, 0.1]) + &behind),
        Scene::new("igloo_wall", [0.08, 0.08], 0.075, object(igloo) + &point([0.0, 0.5, 0.0]))
            .with_samples(1800)
            .with_hybrid(0.08, 0.08),
        Scene::new("lamp_inside", [0.04, 0.09], 0.04, object("shape = \"sphere\"\nradius = 0.04") + lamp)
            .with_samples(8192),
        Scene::new("block_sky", [0.005, 0.005], 0.07, boxed([0.1, 0.1, 0.05]) + SKY).with_hybrid(0.005, 0.005),
        Scene::new("coarse", [0.04, 0.07], 0.08, boxed([0.12, 0.06, 0.12]) + &behind)
            .with_snow("grain_size_um = 1000\nfacetness = 0.3\ndensity_kg_m3 = 300\n"),
        Scene::new("fresh", [0.04, 0.05], 0.08, boxed([0.12, 0.06, 0.12]) + &behind)
            .with_snow("snow = \"fresh\"\ndensity_kg_m3 = 80\n"),
        Scene::new("mask", [0.07, 0.1], 0.08, object("mesh = \"mesh.ply\"\nup = \"z\"") + &behind)
            .with_snow(masked)
            .with_samples(2200)
            // Both integrators err here, for a reason that is not known.
            .with_hybrid(0.06, 0.1)
            .with_file(
                "mesh.ply",
                block_of_ages([0.02, 0.06], &[(-0.06, 0.0), (-0.02, 0.0), (0.02, 1.0), (0.06, 1.0)]),
            ),
        boundary(),
        wet_and_dirty(),
        two_layers(),
        Scene::new("rough", [0.09, 0.23], 0.05, boxed([0.06, 0.04, 0.05]) + LOW_SUN)
            // Cells of the field are wider than the shadows of the relief.
            .with_hybrid(0.05, 0.15)
            .with_snow("relief = { height_mm = 0.8, correlation_mm = 8 }\n")
            .seen_from([0.0, -1.0, 0.5])
            .with_samples(2048),
        Scene::new("lamp_through_snow", [1.1, 1.1], 0.0, boxed([0.1, 0.1, 0.001]) + below)
            .with_hybrid(0.03, 0.03)
            .at(seen_from_offset(Vec3A::Z, &through))
            .with_samples(1024),
        shadow(),
        low_sun(),
        hole(),
        cave(),
    ]
}
