//! PCASnow's four ways through snow against light that walks from grain to grain: blocks and a ball before a lamp.
//!
//! The reference of a scene is the mean of a few pictures of different seeds, whose scatter tells its noise. A way is
//! judged by ln(L/L₀), L its luminance in a cell of 4×4 pixels and L₀ the reference's, over all cells where L₀ is above a
//! hundredth of its greatest; the mean square of the noise is taken off that of the ratio.

use std::path::Path;
use std::time::Instant;

use snowblue_color::{ColorDifference, Lab, Xyz};
use snowblue_render::film::exposure::Exposure;
use snowblue_render::scene::file::Overrides;
use snowblue_render::scene::material::Material;
use snowblue_render::scene::material::pca_snow::PathMode;
use snowblue_render::scene::{IntegratorKind, Scene};
use snowblue_render::{Film, render};

use super::truth_picture::drawn;
use super::{Drawing, Figure, Rendered, Table, daylight, numbers, scenes, wavelengths_nm};
use crate::failure::Failure;
use crate::report::Cell;

/// Pixels along a side of a picture.
pub(super) const SIDE: u32 = 16;
/// Pixels along a side of a cell, whose mean is what is compared: the noise of a single pixel is too great.
const CELL: u32 = 4;
/// Pictures of different seeds that make a reference.
const SEEDS: u32 = 4;
/// Samples of a pixel by PCASnow, which has no noise here but that of edges.
const QUICK_SAMPLES: u32 = 256;
/// Cells darker than this share of the brightest do not count.
const LEAST_SHARE: f64 = 0.01;

pub(super) const MODES: [(&str, PathMode); 4] = [
    ("view", PathMode::View),
    ("normal", PathMode::Normal),
    ("light", PathMode::Light),
    ("brightest", PathMode::Brightest),
];

/// Parts of a block that is seen straight on: columns of pixels, and the rows of them all.
const PLACES: [(&str, [[u32; 2]; 2]); 2] =
    [("middle", [[4, 8], [8, 12]]), ("left and right eighth", [[1, 3], [13, 15]])];
const PLACE_ROWS: [u32; 2] = [4, 12];

const BALL: &str = include_str!("../../../../scenes/truth_ball.toml");

/// A scene with its picture's name and what stands below it.
struct Case {
    name: &'static str,
    caption: String,
    scene: String,
    /// Samples of a pixel in each of the reference's pictures.
    samples: u32,
}

/// A picture with the time that it took, in s.
pub(super) struct Timed {
    pub(super) pixels: Vec<Xyz>,
    seconds: f64,
}

/// What a scene's pixels are, and how much the scatter of its pictures leaves open.
pub(super) struct Truth {
    pub(super) mean: Timed,
    pub(super) cells: Vec<Xyz>,
    /// Relative standard error of the luminance of each cell.
    pub(super) noise: Vec<f64>,
    /// Mean CIEDE2000 that noise alone makes.
    delta_e: f64,
    /// The cells that count.
    pub(super) lit: Vec<usize>,
    /// Mean luminance of each of [`PLACES`], with its relative standard error.
    places: Vec<[f64; 2]>,
    /// The light that shows white at the scene's exposure.
    white: Xyz,
}

/// How far one way through snow is from the truth in a scene.
struct Verdict {
    /// 5 %, median and 95 % of the ratio of luminance.
    ratios: [f64; 3],
    /// Mean square of ln of the ratio, without noise.
    square: f64,
    /// Of the picture's light over the reference's.
    energy: f64,
    /// Mean CIEDE2000 at the reference's exposure.
    delta_e: f64,
    /// CIEDE2000 of the light of all pixels together at L* = 50: hue and chroma.
    hue_delta_e: f64,
    seconds: f64,
}

/// `times` says how many times as many samples the references take.
pub(super) fn figure(times: u32) -> Result<Figure, Failure> {
    let (mut pictures, mut rows, mut places) = (Vec::new(), Vec::new(), Vec::new());
    let mut all: Vec<Vec<Verdict>> = MODES.iter().map(|_| Vec::new()).collect();
    let white = daylight(&wavelengths_nm(400, 700, 10))?.white();
    for case in cases(times) {
        let mut scene = load(&case)?;
        let truth = truth(&mut scene, case.samples, white);
        let films: Vec<Timed> = MODES.iter().map(|(_, mode)| quick(&mut scene, *mode)).collect();
        let png = drawn(&truth, &films)?;
        pictures.push(Rendered { name: case.name, caption: case.caption.clone(), png });
        if case.name.starts_with("front") {
            places.extend(place_rows(&case, &truth, &films));
        }
        for ((film, (mode, _)), verdicts) in films.iter().zip(MODES).zip(&mut all) {
            let verdict = judged(&truth, film);
            rows.push(row(&case, mode, &truth, &verdict));
            verdicts.push(verdict);
        }
    }
    Ok(Figure {
        title: "PCASnow against light that walks",
        ours: "Of each scene, above: the reference, then view, normal, light and brightest, all at the reference's exposure. Below: \
               their luminance over the reference's in cells of 4×4 pixels; first, on the same scale, two standard errors of the reference's noise. Grains of 400 µm, facetness .3, 300 kg/m³, a point of D65."
            .to_owned(),
        paper: "Judges its pictures by eye, and its curves by those of its model; no picture of light that walks in a block.".to_owned(),
        drawing: Drawing::Pictures(pictures),
        numbers: numbers(&COLUMNS, rows),
        tables: vec![summary(&all), places_table(places)],
    })
}

/// Blocks of three thicknesses before a lamp far and near, straight on and obliquely, and a ball.
fn cases(times: u32) -> Vec<Case> {
    let mut cases = Vec::new();
    let views = [
        (
            scenes::BACK,
            "straight on",
            [["front_far_5", "front_far_10", "front_far_15"], ["front_near_5", "front_near_10", "front_near_15"]],
        ),
        (
            scenes::OBLIQUE,
            "obliquely",
            [
                ["oblique_far_5", "oblique_far_10", "oblique_far_15"],
                ["oblique_near_5", "oblique_near_10", "oblique_near_15"],
            ],
        ),
    ];
    // Thicker snow passes less light, and needs as many more samples.
    let thicknesses = [("5 cm", "0.05", 256), ("10 cm", "0.1", 512), ("15 cm", "0.15", 512)]
        .map(|(thickness, size_m, samples)| (thickness, size_m, samples * times));
    for (scene, view, names) in views {
        for (names, (lamp_m, lamp)) in names.into_iter().zip([("1.2", "120 cm"), ("0.45", "45 cm")]) {
            for (name, (thickness, size_m, samples)) in names.into_iter().zip(thicknesses) {
                let scene = scene
                    .replace(scenes::BLOCK_SIZE, &format!("size = [0.6, {size_m}, 0.6]"))
                    .replace("position = [0.0, 1.2, 0.2]", &format!("position = [0.0, {lamp_m}, 0.2]"))
                    .replace("vertical_fov_deg = 20", "vertical_fov_deg = 17");
                let caption = format!("A block of {thickness}, the lamp {lamp} behind its middle, seen {view}");
                cases.push(Case { name, caption, scene, samples });
            }
        }
    }
    for (name, place, lamp) in [("ball_far", "[0.5, 0.85, 0.2]", "1 m"), ("ball_near", "[0.1, 0.17, 0.04]", "20 cm")] {
        let caption = format!("A ball 10 cm across, the lamp {lamp} from its middle");
        cases.push(Case { name, caption, scene: BALL.replace("[0.5, 0.85, 0.2]", place), samples: 512 * times });
    }
    cases
}

fn load(case: &Case) -> Result<Scene, Failure> {
    let overrides = Overrides {
        integrator: Some(IntegratorKind::Reference),
        width: Some(SIDE),
        height: Some(SIDE),
        samples_per_pixel: Some(case.samples),
        ..Overrides::default()
    };
    let place = format!("{}.toml", case.name);
    Scene::from_text(&case.scene, Path::new(&place), snowblue_data::embedded(), &overrides).map_err(Failure::work)
}

fn timed(scene: &Scene) -> Timed {
    let start = Instant::now();
    let pixels = render::render(scene, &|_| {}).film.pixels().to_vec();
    Timed { pixels, seconds: start.elapsed().as_secs_f64() }
}

fn quick(scene: &mut Scene, mode: PathMode) -> Timed {
    scene.integrator.kind = IntegratorKind::PcaSnow;
    scene.integrator.samples_per_pixel = QUICK_SAMPLES;
    for material in &mut scene.materials {
        if let Material::PcaSnow(snow) = material {
            snow.path = mode;
        }
    }
    timed(scene)
}

fn truth(scene: &mut Scene, samples: u32, white: Xyz) -> Truth {
    scene.integrator.samples_per_pixel = samples;
    let pictures: Vec<Timed> = (1..=SEEDS)
        .map(|seed| {
            scene.integrator.seed = seed;
            timed(scene)
        })
        .collect();
    let mean_of = |chosen: &[Timed]| -> Vec<Xyz> {
        let sum = |pixel: usize| chosen.iter().fold(Xyz::default(), |sum, picture| sum + picture.pixels[pixel]);
        (0..pictures[0].pixels.len()).map(|pixel| sum(pixel) * (chosen.len() as f64).recip()).collect()
    };
    let mean = mean_of(&pictures);
    let means = cells(&mean);
    let single: Vec<Vec<Xyz>> = pictures.iter().map(|picture| cells(&picture.pixels)).collect();
    let count = f64::from(SEEDS);
    let error = |mean: f64, single: &dyn Fn(usize) -> f64| {
        let squares: f64 = (0..pictures.len()).map(|picture| (single(picture) - mean).powi(2)).sum();
        (squares / (count * (count - 1.0))).sqrt() / mean
    };
    let noise =
        means.iter().enumerate().map(|(cell, mean)| error(mean.y, &|picture| single[picture][cell].y)).collect();
    let place = |place: usize| {
        let light = place_light(&mean, place);
        [light, error(light, &|picture| place_light(&pictures[picture].pixels, place))]
    };
    let places = (0..PLACES.len()).map(place).collect();
    let brightest = means.iter().map(|xyz| xyz.y).fold(0.0, f64::max);
    let lit = (0..means.len()).filter(|cell| means[*cell].y > LEAST_SHARE * brightest).collect::<Vec<_>>();
    // Two halves of the pictures differ twice as much as their mean from the truth.
    let halves = pictures.split_at(pictures.len() / 2);
    let exposure = film(&mean).display_factor(Exposure::Auto);
    let delta_e =
        0.5 * mean_delta_e([halves.0, halves.1].map(|half| cells(&mean_of(half))), &lit, white * exposure.recip());
    let seconds = pictures.iter().map(|picture| picture.seconds).sum();
    let mean = Timed { pixels: mean, seconds };
    Truth { mean, cells: means, noise, delta_e, lit, places, white: white * exposure.recip() }
}

pub(super) fn film(pixels: &[Xyz]) -> Film {
    Film::new(SIDE, SIDE, pixels.to_vec())
}

/// The mean luminance of a part of a picture.
fn place_light(pixels: &[Xyz], place: usize) -> f64 {
    let ((_, columns), rows) = (PLACES[place], PLACE_ROWS);
    let inside = |x: u32, y: u32| {
        (rows[0]..rows[1]).contains(&y) && columns.iter().any(|columns| (columns[0]..columns[1]).contains(&x))
    };
    let chosen = (0..SIDE * SIDE).filter(|pixel| inside(pixel % SIDE, pixel / SIDE));
    let light: Vec<f64> = chosen.map(|pixel| pixels[pixel as usize].y).collect();
    light.iter().sum::<f64>() / light.len() as f64
}

/// The mean light of each cell of a picture.
pub(super) fn cells(pixels: &[Xyz]) -> Vec<Xyz> {
    let mut cells = vec![Xyz::default(); ((SIDE / CELL) * (SIDE / CELL)) as usize];
    for (pixel, xyz) in pixels.iter().enumerate() {
        cells[cell_of(pixel)] = cells[cell_of(pixel)] + *xyz * f64::from(CELL * CELL).recip();
    }
    cells
}

/// The cell in which a pixel lies.
pub(super) fn cell_of(pixel: usize) -> usize {
    let (side, cell) = (SIDE as usize, CELL as usize);
    pixel / side / cell * (side / cell) + pixel % side / cell
}

fn mean_delta_e([ones, others]: [Vec<Xyz>; 2], lit: &[usize], white: Xyz) -> f64 {
    let lab = |xyz: Xyz| Lab::from_xyz(xyz, white);
    let sum: f64 = lit.iter().map(|cell| lab(ones[*cell]).delta_e_2000(lab(others[*cell]))).sum();
    sum / lit.len() as f64
}

fn judged(truth: &Truth, found: &Timed) -> Verdict {
    let (reference, light) = (&truth.cells, cells(&found.pixels));
    let ratio = |cell: usize| light[cell].y / reference[cell].y;
    let mut ratios: Vec<f64> = truth.lit.iter().map(|cell| ratio(*cell)).collect();
    ratios.sort_by(f64::total_cmp);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a number of cells")]
    let quantile = |share: f64| ratios[((ratios.len() - 1) as f64 * share).round() as usize];
    // Black where the truth is not counts as a thousandth.
    let square = |cell: &usize| ratio(*cell).max(1e-3).ln().powi(2) - truth.noise[*cell].powi(2);
    let sum = |pixels: &[Xyz]| pixels.iter().fold(Xyz::default(), |sum, xyz| sum + *xyz);
    let (all, expected) = (sum(&light), sum(reference));
    Verdict {
        ratios: [quantile(0.05), quantile(0.5), quantile(0.95)],
        square: truth.lit.iter().map(square).sum::<f64>() / truth.lit.len() as f64,
        energy: all.y / expected.y,
        delta_e: mean_delta_e([light, reference.clone()], &truth.lit, truth.white),
        hue_delta_e: ColorDifference::between(all, expected, truth.white).at_middle_grey_2000,
        seconds: found.seconds,
    }
}

const COLUMNS: [&str; 15] = [
    "scene",
    "path",
    "cells",
    "ratio_5_percent",
    "ratio_median",
    "ratio_95_percent",
    "rms_ln_ratio",
    "energy_ratio",
    "mean_delta_e_2000",
    "noise_delta_e_2000",
    "delta_e_2000_of_all_light_at_middle_grey",
    "noise_of_a_cell",
    "reference_samples",
    "reference_s",
    "path_s",
];

fn row(case: &Case, mode: &str, truth: &Truth, verdict: &Verdict) -> Vec<Cell> {
    let [low, median, high] = verdict.ratios;
    let noise = (truth.lit.iter().map(|cell| truth.noise[*cell].powi(2)).sum::<f64>() / truth.lit.len() as f64).sqrt();
    let values = [
        truth.lit.len() as f64,
        low,
        median,
        high,
        verdict.square.max(0.0).sqrt(),
        verdict.energy,
        verdict.delta_e,
        truth.delta_e,
        verdict.hue_delta_e,
        noise,
        f64::from(case.samples * SEEDS),
        truth.mean.seconds,
        verdict.seconds,
    ];
    let words = [case.name, mode].map(|word| Cell::Word(word.to_owned()));
    words.into_iter().chain(values.map(Cell::Number)).collect()
}

/// Every way over all scenes, each scene counting alike.
fn summary(all: &[Vec<Verdict>]) -> Table {
    let row = |(verdicts, (mode, _)): (&Vec<Verdict>, (&str, PathMode))| {
        let mean = |value: &dyn Fn(&Verdict) -> f64| verdicts.iter().map(value).sum::<f64>() / verdicts.len() as f64;
        let worst = verdicts.iter().map(|verdict| verdict.energy.ln().abs()).fold(0.0, f64::max).exp();
        vec![
            mode.to_owned(),
            format!("{:.3}", mean(&|verdict| verdict.square).max(0.0).sqrt()),
            format!("{:.2}", mean(&|verdict| verdict.delta_e)),
            format!("{:.2}", mean(&|verdict| verdict.hue_delta_e)),
            format!("{:.2}", mean(&|verdict| verdict.energy.ln()).exp()),
            format!("{worst:.2}"),
        ]
    };
    let columns =
        ["Path", "RMS of ln ratio", "Mean ΔE00", "ΔE00 of all light", "Energy ratio", "Worst energy, either way"];
    Table::new("ways", "Ways through snow over all scenes", &columns, all.iter().zip(MODES).map(row).collect())
}

/// Each way's luminance over the reference's in parts of a block.
fn place_rows(case: &Case, truth: &Truth, films: &[Timed]) -> Vec<Vec<String>> {
    let row = |(place, [light, error]): (usize, &[f64; 2])| {
        let ratios = films.iter().map(|film| format!("{:.2}", place_light(&film.pixels, place) / light));
        let words = [case.name.to_owned(), PLACES[place].0.to_owned(), format!("{error:.2}")];
        words.into_iter().chain(ratios).collect()
    };
    truth.places.iter().enumerate().map(row).collect()
}

fn places_table(rows: Vec<Vec<String>>) -> Table {
    let columns = ["Block", "Part", "Noise of the reference", "view", "normal", "light", "brightest"];
    Table::new("places", "Luminance over the reference's, straight on", &columns, rows)
}
