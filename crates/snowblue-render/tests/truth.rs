//! `hybrid` and `diffusion` against the reference integrator on small scenes of many kinds.
//!
//! `truth/references.csv` holds X, Y and Z of 4 × 4 cells of each scene by `reference` with their standard errors, over
//! 16 renderings of 256 to 16,384 samples a cell. `UPDATE_TRUTH=1 cargo test -p snowblue-render --test truth` renders
//! them again, and `UPDATE_TRUTH=NAME` those of one scene. `-- --nocapture` prints the errors of both integrators.
//!
//! The measures are the greatest |ln| of the ratio of all light in X, Y and Z, and the root mean square of ln L/L₀ over
//! cells with a luminance L₀ above a fiftieth of the greatest, without the noise of both.

#![allow(clippy::unwrap_used, clippy::cast_possible_truncation, reason = "tests may panic, and meshes are single")]

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

use snowblue_render::files::FilesInMemory;
use snowblue_render::render::render_all;
use snowblue_render::scene::IntegratorKind;
use snowblue_render::{Integrator, SceneDescription, SceneFile};

const SIDE: usize = 4;
const CELLS: usize = SIDE * SIDE;
/// Renderings of the reference.
const REFERENCES: u32 = 16;
/// Those of the other integrators.
const HYBRID: Renderings = Renderings { count: 8, samples: 1024 };
const DIFFUSION: Renderings = Renderings { count: 8, samples: 64 };
/// Limits of `hybrid`, where a scene has no others.
const HYBRID_LIMITS: Limits = Limits { energy: 0.05, cells: 0.08 };
/// Snow of which ℓ* is 2.0 mm.
const SNOW: &str = "grain_size_um = 400\nfacetness = 0.3\ndensity_kg_m3 = 300\n";
const LENGTH_M: f64 = 0.002;
/// Three standard errors of all light, at most.
const GREATEST_NOISE: f64 = 0.16;
/// Cells darker than this part of the brightest do not count.
const DARK: f64 = 0.02;

/// Renderings with different seeds, and their samples per cell.
#[derive(Clone, Copy)]
struct Renderings {
    count: u32,
    samples: u32,
}

/// Greatest errors.
#[derive(Debug, Clone, Copy)]
struct Limits {
    energy: f64,
    cells: f64,
}

/// A scene, what the integrators may err by, and what its picture shows.
struct Scene {
    name: &'static str,
    hybrid: Limits,
    diffusion: Limits,
    snow: String,
    /// Objects and lights.
    content: String,
    /// Radius of what is seen, in m, and the direction of the camera from the middle.
    radius_m: f64,
    from: [f64; 3],
    files: Vec<(&'static str, String)>,
    /// Samples per cell of each rendering of the reference.
    samples: u32,
}

/// Mean X, Y and Z of each cell, and their standard errors.
#[derive(Clone)]
struct Cells {
    means: [[f64; 3]; CELLS],
    errors: [[f64; 3]; CELLS],
}

impl Scene {
    /// A scene of the default snow, seen from the front.
    fn new(name: &'static str, diffusion: [f64; 2], radius_m: f64, content: String) -> Self {
        let [energy, cells] = diffusion;
        let from = [0.0, -1.0, 0.3];
        let diffusion = Limits { energy, cells };
        Self {
            name,
            hybrid: HYBRID_LIMITS,
            diffusion,
            snow: SNOW.to_owned(),
            content,
            radius_m,
            from,
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

    /// Wider limits of `hybrid`, for a fault that is known.
    fn with_hybrid(self, energy: f64, cells: f64) -> Self {
        Self { hybrid: Limits { energy, cells }, ..self }
    }

    fn with_samples(self, samples: u32) -> Self {
        Self { samples, ..self }
    }

    fn seen_from(self, from: [f64; 3]) -> Self {
        Self { from, ..self }
    }

    fn description(&self) -> SceneDescription {
        let [x, y, z] = self.from.map(|coordinate| 20.0 * self.radius_m * coordinate);
        let text = format!(
            "[camera]\nposition = [{x}, {y}, {z}]\nlook_at = [0, 0, 0]\nvertical_fov_deg = 5\n[film]\n\
             width = {SIDE}\nheight = {SIDE}\n[material.snow]\ntype = \"snow\"\n{}{}",
            self.snow, self.content
        );
        SceneFile::parse(text, self.name).unwrap().description
    }

    fn rendered(&self, kind: IntegratorKind, Renderings { count, samples }: Renderings) -> Cells {
        let mut description = self.description();
        description.integrator.kind = kind;
        description.integrator.samples_per_pixel = samples;
        let mut files = FilesInMemory::default();
        self.files.iter().for_each(|(name, text)| files.insert(*name, text.clone()));
        let mut integrator = Integrator::prepare(&description.build(&files).unwrap()).unwrap();
        let (mut sums, mut squares) = ([[0.0; 3]; CELLS], [[0.0; 3]; CELLS]);
        for seed in 1..=count {
            integrator.set_seed(seed);
            let film = render_all(&integrator, &|_| {}).film;
            for (cell, xyz) in film.pixels().iter().enumerate() {
                for (channel, value) in [xyz.x, xyz.y, xyz.z].into_iter().enumerate() {
                    sums[cell][channel] += value;
                    squares[cell][channel] += value * value;
                }
            }
        }
        let count = f64::from(count);
        let mut cells = Cells { means: sums, errors: squares };
        for (mean, error) in cells.means.iter_mut().flatten().zip(cells.errors.iter_mut().flatten()) {
            *mean /= count;
            *error = ((*error / count - *mean * *mean).max(0.0) / (count - 1.0)).sqrt();
        }
        cells
    }
}

impl Cells {
    /// The errors against the truth.
    fn errors_against(&self, truth: &Self) -> Limits {
        assert!(self.means.iter().flatten().all(|mean| mean.is_finite()), "{:?}", self.means);
        let total = |cells: &Self, channel: usize| cells.means.iter().map(|mean| mean[channel]).sum::<f64>();
        let ratios = [0, 1, 2].map(|channel| (total(self, channel) / total(truth, channel)).ln().abs());
        let brightest = truth.means.iter().map(|mean| mean[1]).fold(0.0, f64::max);
        let (mut square, mut count) = (0.0, 0.0);
        for cell in (0..CELLS).filter(|cell| truth.means[*cell][1] > DARK * brightest) {
            assert!(self.means[cell][1] > 0.0, "cell {cell} is black");
            let noise = |cells: &Self| (cells.errors[cell][1] / cells.means[cell][1]).powi(2);
            square += (self.means[cell][1] / truth.means[cell][1]).ln().powi(2) - noise(self) - noise(truth);
            count += 1.0;
        }
        Limits { energy: ratios.into_iter().fold(0.0, f64::max), cells: f64::max(square / count, 0.0).sqrt() }
    }

    /// Greatest relative standard error of all light together, in X, Y or Z.
    fn noise(&self) -> f64 {
        let of_channel = |channel: usize| {
            let variance: f64 = self.errors.iter().map(|error| error[channel].powi(2)).sum();
            variance.sqrt() / self.means.iter().map(|mean| mean[channel]).sum::<f64>()
        };
        [0, 1, 2].map(of_channel).into_iter().fold(0.0, f64::max)
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
        .with_samples(if lengths > 50.0 { 4096 } else { 16_384 })
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
        glam::DVec3::new(large * (2.0 * t).cos(), large * (2.0 * t).sin(), 0.036 * (3.0 * t).sin())
    };
    closed([400, 48], |u, v| {
        let along = (middle(u + 1e-4) - middle(u - 1e-4)).normalize();
        let side = along.cross(glam::DVec3::Z).normalize();
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

/// A block as a PLY file whose attribute "age" rises from left to right.
fn block_of_two_snows() -> String {
    let mut text = "ply\nformat ascii 1.0\nelement vertex 16\nproperty float x\nproperty float y\nproperty float z\n\
                    property float age\nelement face 14\nproperty list uchar int vertex_indices\nend_header\n"
        .to_owned();
    for (x, age) in [(-0.06, 0.0), (-0.02, 0.0), (0.02, 1.0), (0.06, 1.0)] {
        for (y, z) in [(-0.02, -0.06), (0.02, -0.06), (0.02, 0.06), (-0.02, 0.06)] {
            writeln!(text, "{x} {y} {z} {age}").unwrap();
        }
    }
    for section in 0..3 {
        for side in 0..4 {
            let [a, b] = [side, (side + 1) % 4].map(|corner| 4 * section + corner);
            writeln!(text, "4 {a} {} {} {b}", a + 4, b + 4).unwrap();
        }
    }
    text + "4 0 1 2 3\n4 15 14 13 12\n"
}

fn boxed(size: [f64; 3]) -> String {
    object(&format!("shape = \"box\"\nsize = {size:?}"))
}

fn scenes() -> Vec<Scene> {
    let behind = point([0.05, 0.4, 0.1]);
    let front = point([0.4, -0.5, 0.4]);
    let sky = "[environment]\nradiance_w_m2_sr = 1\n";
    let igloo = "shape = \"igloo\"\ninner_radius = 0.5\nwall = 0.06\ncourses = 4\nblock_width = 0.25\n\
                 seam_depth = 0.015\nseam_width = 0.03\nposition = [0, 0.5, -0.2]";
    let sun = "[[light]]\ntype = \"directional\"\ndirection = [-1, 1, -1]\nirradiance_w_m2 = 100\n";
    let lamp = "[[light]]\ntype = \"sphere\"\nposition = [0, 0.01, 0]\nradius = 0.004\nradiance_w_m2_sr = 1000\n";
    let gap = |x: f64| object(&format!("shape = \"box\"\nsize = [0.05, 0.06, 0.1]\nposition = [{x}, 0, 0]"));
    let masked = "mask = { attribute = \"age\", range = [0, 1] }\nbetween = [{ grain_size_um = 200 }, \
                  { grain_size_um = 800 }]\n";
    vec![
        ball("ball_2.5", 2.5, [0.70, 0.66]),
        ball("ball_5", 5.0, [0.54, 0.46]),
        ball("ball_10", 10.0, [0.36, 0.28]),
        ball("ball_25", 25.0, [0.19, 0.12]),
        ball("ball_100", 100.0, [0.10, 0.05]),
        Scene::new("torus", [0.07, 0.07], 0.07, mesh() + &front).with_file("mesh.obj", torus()),
        Scene::new("knot_sun", [0.07, 0.07], 0.11, mesh() + sun).with_file("mesh.obj", knot()),
        Scene::new("corner", [0.03, 0.05], 0.075, mesh() + &front)
            .with_file("mesh.obj", corner())
            .seen_from([0.7, -0.7, 0.3]),
        Scene::new("groove", [0.03, 0.05], 0.05, mesh() + &front).with_file("mesh.obj", groove()),
        Scene::new("gap", [0.05, 0.13], 0.05, gap(-0.028) + &gap(0.028) + &behind)
            // The gap is narrower than two cells: details of the light in it are lost.
            .with_hybrid(0.06, 0.12),
        Scene::new("plate", [0.03, 0.05], 0.06, boxed([0.1, 2.5 * LENGTH_M, 0.1]) + &behind),
        Scene::new("igloo_wall", [0.12, 0.08], 0.15, object(igloo) + &point([0.0, 0.5, 0.0]))
            .with_samples(256)
            .with_hybrid(0.12, 0.08),
        Scene::new("lamp_inside", [0.04, 0.09], 0.04, object("shape = \"sphere\"\nradius = 0.04") + lamp),
        Scene::new("block_sky", [0.02, 0.02], 0.07, boxed([0.1, 0.1, 0.05]) + sky),
        Scene::new("coarse", [0.04, 0.07], 0.08, boxed([0.12, 0.06, 0.12]) + &behind)
            .with_snow("grain_size_um = 1000\nfacetness = 0.3\ndensity_kg_m3 = 300\n"),
        Scene::new("fresh", [0.04, 0.05], 0.08, boxed([0.12, 0.06, 0.12]) + &behind)
            .with_snow("snow = \"fresh\"\ndensity_kg_m3 = 80\n"),
        Scene::new("mask", [0.08, 0.15], 0.08, object("mesh = \"mesh.ply\"\nup = \"z\"") + &behind)
            .with_snow(masked)
            .with_samples(512)
            // Both integrators err here, for a reason that is not known.
            .with_hybrid(0.08, 0.16)
            .with_file("mesh.ply", block_of_two_snows()),
    ]
}

fn stored() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/truth/references.csv")
}

/// The stored references by the name of the scene.
fn references() -> BTreeMap<String, Cells> {
    let mut all = BTreeMap::new();
    for line in std::fs::read_to_string(stored()).unwrap().lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let numbers: Vec<f64> = fields[2..].iter().map(|field| field.parse().unwrap()).collect();
        let dark = || Cells { means: [[0.0; 3]; CELLS], errors: [[0.0; 3]; CELLS] };
        let (cell, cells) = (fields[1].parse::<usize>().unwrap(), all.entry(fields[0].to_owned()).or_insert_with(dark));
        cells.means[cell].copy_from_slice(&numbers[..3]);
        cells.errors[cell].copy_from_slice(&numbers[3..]);
    }
    all
}

#[expect(clippy::print_stdout, reason = "progress")]
fn update(name: &str) {
    scenes().iter().for_each(|scene| drop(scene.description()));
    let mut text = "scene,cell,x,y,z,x_error,y_error,z_error\n".to_owned();
    let stored = std::fs::read_to_string(stored()).unwrap();
    for scene in scenes() {
        if name != "1" && name != scene.name {
            let of_scene = |line: &&str| line.split(',').next() == Some(scene.name);
            stored.lines().filter(of_scene).for_each(|line| writeln!(text, "{line}").unwrap());
            continue;
        }
        let start = std::time::Instant::now();
        let cells = scene.rendered(IntegratorKind::Reference, Renderings { count: REFERENCES, samples: scene.samples });
        println!("{}: {:.1} s", scene.name, start.elapsed().as_secs_f64());
        for (cell, (mean, error)) in cells.means.iter().zip(&cells.errors).enumerate() {
            let numbers: Vec<String> = mean.iter().chain(error).map(|number| format!("{number:.4e}")).collect();
            writeln!(text, "{},{cell},{}", scene.name, numbers.join(",")).unwrap();
        }
    }
    std::fs::write(self::stored(), text).unwrap();
}

#[test]
#[expect(clippy::print_stdout, reason = "a table of errors")]
fn the_light_field_agrees_with_the_reference() {
    let updated = std::env::var("UPDATE_TRUTH").ok();
    if let Some(name) = &updated {
        update(name);
    }
    let is_update = updated.is_some();
    let (truth, mut failures) = (references(), Vec::new());
    for scene in
        scenes().into_iter().filter(|scene| updated.as_deref().is_none_or(|name| ["1", scene.name].contains(&name)))
    {
        let truth = &truth[scene.name];
        for (kind, renderings, limits) in
            [(IntegratorKind::Hybrid, HYBRID, scene.hybrid), (IntegratorKind::Diffusion, DIFFUSION, scene.diffusion)]
        {
            let cells = scene.rendered(kind, renderings);
            let found = cells.errors_against(truth);
            // Three standard errors of all light.
            let noise = 3.0 * cells.noise().hypot(truth.noise());
            assert!(noise < GREATEST_NOISE, "{} by {}: noise {noise}", scene.name, kind.name());
            let line = format!(
                "{} by {}: energy {:.3} of {:.3}, cells {:.3} of {:.3}, noise {noise:.3}",
                scene.name,
                kind.name(),
                found.energy,
                limits.energy,
                found.cells,
                limits.cells
            );
            println!("{line}");
            if found.energy > limits.energy + noise || found.cells > limits.cells {
                failures.push(line);
            }
        }
    }
    assert!(is_update || failures.is_empty(), "{}", failures.join("\n"));
}
