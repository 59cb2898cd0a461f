//! `hybrid` and `diffusion` against the reference integrator on small scenes of many kinds.
//!
//! [`scenes`] is the table of scenes. Each has a test, and a file `tests/truth/NAME.csv` with X, Y and Z of its cells
//! by `reference`: means and standard errors over 16 renderings. `UPDATE_TRUTH=1 cargo test -p snowblue-render --test
//! it truth::NAME` renders it again, and without the name all of them. Where the first line has seconds, two cores took
//! them beside other work. `-- --nocapture` prints the errors of both integrators.
//!
//! The measures are the greatest |ln| of the ratio of all light in X, Y and Z, and the root mean square of ln L/L₀ over
//! cells with a luminance L₀ above a fiftieth of the greatest, without the noise of both.

mod scenes;

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::Vec3A;
use scenes::{Camera, Limits, Scene, scenes};
use snowblue_base::Count;
use snowblue_render::Integrator;
use snowblue_render::files::FilesInMemory;
use snowblue_render::render::render_all;
use snowblue_render::scene::IntegratorKind;
use snowblue_render::scene::camera::View;
use snowblue_stat::{chi_squared_p_value, t_p_value};

/// Renderings of the reference.
const REFERENCES: u32 = 16;
/// Paths of the reference go on until they are absorbed or leave.
const REFERENCE_BOUNCES: u32 = 10_000;
/// Renderings of the other integrators. Three standard errors of all their light are within the limit of its error.
const HYBRID: Renderings = Renderings { count: 8, samples: 1280 };
const DIFFUSION: Renderings = Renderings { count: 8, samples: 128 };
/// Three standard errors of all light by the reference, at most.
const MAX_REFERENCE_NOISE: f64 = 0.02;
/// Cells darker than this part of the brightest do not count.
const DARK: f64 = 0.02;

/// Renderings with different seeds, and their samples per cell.
#[derive(Clone, Copy)]
struct Renderings {
    count: u32,
    samples: u32,
}

/// Mean X, Y and Z of each cell, and their standard errors.
struct Cells {
    means: Vec<[f64; 3]>,
    errors: Vec<[f64; 3]>,
}

impl Scene {
    /// The cells by an integrator.
    fn rendered(&self, kind: IntegratorKind, Renderings { count, samples }: Renderings) -> Cells {
        let mut description = self.description();
        description.integrator.kind = kind;
        description.integrator.samples_per_pixel = Count::of(samples);
        if kind == IntegratorKind::Reference {
            description.integrator.max_bounces = Count::of(REFERENCE_BOUNCES);
        }
        let mut files = FilesInMemory::default();
        self.files.iter().for_each(|(name, text)| files.insert(*name, text.clone()));
        let mut integrator = Integrator::prepare(&description.build(&files).unwrap()).unwrap();
        let renderings: Vec<Vec<[f64; 3]>> = (1..=count)
            .map(|seed| {
                integrator.set_seed(seed);
                self.picture(&mut integrator)
            })
            .collect();
        Cells::of(&renderings)
    }

    /// X, Y and Z of all cells by one rendering.
    fn picture(&self, integrator: &mut Integrator) -> Vec<[f64; 3]> {
        let pixels = |integrator: &Integrator| -> Vec<[f64; 3]> {
            render_all(integrator, &|_| {}).film.pixels().iter().map(|xyz| [xyz.x, xyz.y, xyz.z]).collect()
        };
        let Camera::Points(points) = &self.camera else { return pixels(integrator) };
        let at_point = |&[position, look_at]: &[Vec3A; 2]| {
            let up = (look_at - position).any_orthogonal_vector();
            assert!(integrator.set_view(&View { position, look_at, up, vertical_fov_deg: 1e-5 }));
            pixels(integrator)[0]
        };
        points.iter().map(at_point).collect()
    }

    fn stored(&self) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/truth/{}.csv", self.name))
    }

    /// The stored cells by the reference.
    fn truth(&self) -> Cells {
        let path = self.stored();
        let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let (mut means, mut errors) = (Vec::new(), Vec::new());
        for line in text.lines().skip(2) {
            let numbers: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
            means.push([numbers[0], numbers[1], numbers[2]]);
            errors.push([numbers[3], numbers[4], numbers[5]]);
        }
        Cells { means, errors }
    }

    /// Renders and stores the cells by the reference.
    fn update(&self) {
        let start = Instant::now();
        let cells = self.rendered(IntegratorKind::Reference, Renderings { count: REFERENCES, samples: self.samples });
        let mut text = format!(
            "# {REFERENCES} renderings of {} samples per cell, {:.0} s\nx,y,z,x_error,y_error,z_error\n",
            self.samples,
            start.elapsed().as_secs_f64()
        );
        for (mean, error) in cells.means.iter().zip(&cells.errors) {
            let numbers: Vec<String> = mean.iter().chain(error).map(|number| format!("{number:.4e}")).collect();
            writeln!(text, "{}", numbers.join(",")).unwrap();
        }
        std::fs::write(self.stored(), text).unwrap();
    }
}

impl Cells {
    /// Means and standard errors over renderings.
    fn of(renderings: &[Vec<[f64; 3]>]) -> Self {
        let count = renderings.len() as f64;
        let mut cells =
            Self { means: vec![[0.0; 3]; renderings[0].len()], errors: vec![[0.0; 3]; renderings[0].len()] };
        for (cell, channel) in (0..cells.means.len()).flat_map(|cell| [(cell, 0), (cell, 1), (cell, 2)]) {
            let values = renderings.iter().map(|picture| picture[cell][channel]);
            let mean = values.clone().sum::<f64>() / count;
            let square = values.map(|value| (value - mean).powi(2)).sum::<f64>();
            cells.means[cell][channel] = mean;
            cells.errors[cell][channel] = (square / (count * (count - 1.0))).sqrt();
        }
        cells
    }

    /// The errors against the truth.
    fn errors_against(&self, truth: &Self) -> Limits {
        assert!(self.means.iter().flatten().all(|mean| mean.is_finite()), "{:?}", self.means);
        let ratios = [0, 1, 2].map(|channel| (self.total(channel) / truth.total(channel)).ln().abs());
        let brightest = truth.means.iter().map(|mean| mean[1]).fold(0.0, f64::max);
        let (mut square, mut count) = (0.0, 0.0);
        for cell in (0..truth.means.len()).filter(|cell| truth.means[*cell][1] > DARK * brightest) {
            assert!(self.means[cell][1] > 0.0, "cell {cell} is black");
            let noise = |cells: &Self| (cells.errors[cell][1] / cells.means[cell][1]).powi(2);
            square += (self.means[cell][1] / truth.means[cell][1]).ln().powi(2) - noise(self) - noise(truth);
            count += 1.0;
        }
        Limits { energy: ratios.into_iter().fold(0.0, f64::max), cells: f64::max(square / count, 0.0).sqrt() }
    }

    /// The light of all cells in X, Y or Z.
    fn total(&self, channel: usize) -> f64 {
        self.means.iter().map(|mean| mean[channel]).sum()
    }

    /// Three relative standard errors of all light, the greatest of X, Y and Z.
    fn noise(&self) -> f64 {
        let of_channel = |channel: usize| {
            let variance: f64 = self.errors.iter().map(|error| error[channel].powi(2)).sum();
            3.0 * variance.sqrt() / self.total(channel)
        };
        [0, 1, 2].map(of_channel).into_iter().fold(0.0, f64::max)
    }
}

/// Compares both integrators with the stored reference of a scene, or stores the reference.
#[expect(clippy::print_stdout, reason = "a table of errors")]
fn check(name: &str) {
    let scenes = scenes();
    let scene = scenes.iter().find(|scene| scene.name == name).unwrap();
    if std::env::var_os("UPDATE_TRUTH").is_some() {
        scene.update();
    }
    let truth = scene.truth();
    let mut failures = Vec::new();
    let mut report = |line: String, fails: bool| {
        println!("{line}");
        if fails {
            failures.push(line);
        }
    };
    let noise = truth.noise();
    report(format!("{name} by reference: noise {noise:.4}"), noise > MAX_REFERENCE_NOISE);
    for (kind, renderings, limits) in
        [(IntegratorKind::Hybrid, HYBRID, scene.hybrid), (IntegratorKind::Diffusion, DIFFUSION, scene.diffusion)]
    {
        let cells = scene.rendered(kind, renderings);
        let (found, noise) = (cells.errors_against(&truth), cells.noise());
        let line = format!(
            "{name} by {}: energy {:.4} of {}, cells {:.4} of {}, noise {noise:.4}",
            kind.name(),
            found.energy,
            limits.energy,
            found.cells,
            limits.cells
        );
        report(line, found.energy > limits.energy || found.cells > limits.cells || noise > limits.energy);
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// A test for each scene of the table.
macro_rules! one_test_a_scene {
    ($($name:ident)*) => {
        $(
            #[test]
            fn $name() {
                check(stringify!($name));
            }
        )*

        #[test]
        fn every_scene_has_a_test() {
            let names: Vec<&str> = scenes().iter().map(|scene| scene.name).collect();
            assert_eq!(names, [$(stringify!($name)),*]);
        }
    };
}

one_test_a_scene! {
    ball_2_5 ball_5 ball_10 ball_25 ball_50 torus knot_sun corner groove gap plate igloo_wall lamp_inside block_sky
    coarse fresh mask boundary wet_and_dirty two_layers rough lamp_through_snow shadow low_sun hole cave
}

/// The stored references are still what the reference integrator renders: cell by cell within its noise, as a χ² test
/// of the luminances and a t-test of all light show. 3 % more light fails both.
#[test]
fn the_reference_of_a_small_ball_is_still_rendered() {
    let scenes = scenes();
    let ball = scenes.iter().find(|scene| scene.name == "ball_2_5").unwrap();
    let (known, found) =
        (ball.truth(), ball.rendered(IntegratorKind::Reference, Renderings { count: REFERENCES, samples: 2048 }));
    let degrees = f64::from(REFERENCES - 1);
    let p_values = |factor: f64| {
        let mut chi_squared = 0.0;
        for cell in 0..found.means.len() {
            let difference = factor * found.means[cell][1] - known.means[cell][1];
            let variance = found.errors[cell][1].powi(2) + known.errors[cell][1].powi(2);
            // The variance of t is ν / (ν − 2).
            chi_squared += difference * difference / variance * (degrees - 2.0) / degrees;
        }
        let t = 3.0 * (factor * found.total(1) / known.total(1) - 1.0) / found.noise().hypot(known.noise());
        [chi_squared_p_value(chi_squared, found.means.len() as f64), t_p_value(t, degrees)]
    };
    assert!(p_values(1.0).into_iter().all(|p| p > 1e-3), "{:?}", p_values(1.0));
    assert!(p_values(1.03).into_iter().all(|p| p < 1e-3), "{:?}", p_values(1.03));
}
