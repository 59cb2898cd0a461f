//! PCASnow's four ways through snow against light that walks from grain to grain: blocks and a ball before a lamp.
//!
//! The reference of a scene is the mean of a few pictures of different seeds, whose scatter tells its noise. A way is
//! judged by ln(L/L₀), L its luminance in a cell of 4×4 pixels and L₀ the reference's, over all cells where L₀ is above a
//! hundredth of its greatest; the mean square of the noise is taken off that of the ratio.

use std::path::Path;
use std::time::Instant;

use snowblue_color::{Difference, Lab, LinearRgb, Srgb8, Xyz};
use snowblue_render::material::Material;
use snowblue_render::material::pca_snow::PathMode;
use snowblue_render::picture::Picture;
use snowblue_render::scene::{Exposure, Integrator, Scene};
use snowblue_render::scene_file::Overrides;
use snowblue_render::{Film, image_file, render};

use super::{Drawing, Figure, Rendered, Table, daylight, numbers, scenes, wavelengths_nm};
use crate::failure::Failure;
use crate::report::Cell;

/// Pixels along a side of a picture, and how many of the page's each of them takes.
const SIDE: u32 = 16;
/// Pixels along a side of a cell, whose mean is what is compared: the noise of a single pixel is too great.
const CELL: u32 = 4;
const ZOOM: u32 = 7;
/// Pixels of the page between pictures.
const GAP: u32 = 8;
/// Pictures of different seeds that make a reference.
const SEEDS: u32 = 4;
/// Samples of a pixel by PCASnow, which has no noise here but that of edges.
const QUICK_SAMPLES: u32 = 256;
/// Cells darker than this share of the brightest do not count.
const LEAST_SHARE: f64 = 0.01;
/// Stops at which the colours of ratios are full.
const FULL_STOPS: f64 = 2.0;

const MODES: [(&str, PathMode); 4] = [
    ("view", PathMode::View),
    ("normal", PathMode::Normal),
    ("light", PathMode::Light),
    ("easiest", PathMode::Easiest),
];

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
struct Timed {
    pixels: Vec<Xyz>,
    seconds: f64,
}

/// What a scene's pixels are, and how much the scatter of its pictures leaves open.
struct Truth {
    mean: Timed,
    cells: Vec<Xyz>,
    /// Relative standard error of the luminance of each cell.
    noise: Vec<f64>,
    /// Mean CIEDE2000 that noise alone makes.
    delta_e: f64,
    /// The cells that count.
    lit: Vec<usize>,
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

pub(super) fn figure() -> Result<Figure, Failure> {
    let (mut pictures, mut rows) = (Vec::new(), Vec::new());
    let mut all: Vec<Vec<Verdict>> = MODES.iter().map(|_| Vec::new()).collect();
    let white = daylight(&wavelengths_nm(400, 700, 10))?.white();
    for case in cases() {
        let mut scene = load(&case)?;
        let truth = truth(&mut scene, case.samples, white);
        let films: Vec<Timed> = MODES.iter().map(|(_, mode)| quick(&mut scene, *mode)).collect();
        pictures.push(drawn(&case, &truth, &films)?);
        for ((film, (mode, _)), verdicts) in films.iter().zip(MODES).zip(&mut all) {
            let verdict = judged(&truth, film);
            rows.push(row(&case, mode, &truth, &verdict));
            verdicts.push(verdict);
        }
    }
    Ok(Figure {
        title: "PCASnow against light that walks",
        ours: "Of each scene, above: the reference, then view, normal, light and easiest, all at the reference's exposure. Below: \
               their luminance over the reference's in cells of 4×4 pixels, from a quarter or less (blue) over equal (white) to four times or more (red); \
               first what two standard errors of the reference's noise look like. Grains of 400 µm, facetness .3, 300 kg/m³, a point of D65."
            .to_owned(),
        paper: "Judges its pictures by eye, and its curves by those of its model; no picture of light that walks in a block.".to_owned(),
        drawing: Drawing::Pictures(pictures),
        numbers: numbers(&COLUMNS, rows),
        tables: vec![summary(&all)],
    })
}

/// Blocks of three thicknesses before a lamp far and near, straight on and obliquely, and a ball.
fn cases() -> Vec<Case> {
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
    let thicknesses = [("5 cm", "0.05", 128), ("10 cm", "0.1", 256), ("15 cm", "0.15", 256)];
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
        cases.push(Case { name, caption, scene: BALL.replace("[0.5, 0.85, 0.2]", place), samples: 256 });
    }
    cases
}

fn load(case: &Case) -> Result<Scene, Failure> {
    let overrides = Overrides {
        integrator: Some(Integrator::Reference),
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
    scene.integrator.integrator = Integrator::Path;
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
    let noise = means.iter().enumerate().map(|(cell, mean)| {
        let squares: f64 = single.iter().map(|picture| (picture[cell].y - mean.y).powi(2)).sum();
        (squares / (count * (count - 1.0))).sqrt() / mean.y
    });
    let noise = noise.collect();
    let brightest = means.iter().map(|xyz| xyz.y).fold(0.0, f64::max);
    let lit = (0..means.len()).filter(|cell| means[*cell].y > LEAST_SHARE * brightest).collect::<Vec<_>>();
    // Two halves of the pictures differ twice as much as their mean from the truth.
    let halves = pictures.split_at(pictures.len() / 2);
    let exposure = film(&mean).display_factor(Exposure::Auto);
    let delta_e =
        0.5 * mean_delta_e([halves.0, halves.1].map(|half| cells(&mean_of(half))), &lit, white * exposure.recip());
    let seconds = pictures.iter().map(|picture| picture.seconds).sum();
    Truth { mean: Timed { pixels: mean, seconds }, cells: means, noise, delta_e, lit, white: white * exposure.recip() }
}

fn film(pixels: &[Xyz]) -> Film {
    Film::new(SIDE, SIDE, pixels.to_vec())
}

/// The mean light of each cell of a picture.
fn cells(pixels: &[Xyz]) -> Vec<Xyz> {
    let mut cells = vec![Xyz::default(); ((SIDE / CELL) * (SIDE / CELL)) as usize];
    for (pixel, xyz) in pixels.iter().enumerate() {
        cells[cell_of(pixel)] = cells[cell_of(pixel)] + *xyz * f64::from(CELL * CELL).recip();
    }
    cells
}

/// The cell in which a pixel lies.
fn cell_of(pixel: usize) -> usize {
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
        hue_delta_e: Difference::between(all, expected, truth.white).at_middle_grey_2000,
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

/// The pictures of a scene above, and below how far each is from the reference.
fn drawn(case: &Case, truth: &Truth, films: &[Timed]) -> Result<Rendered, Failure> {
    let exposure = Exposure::Stops(film(&truth.mean.pixels).display_factor(Exposure::Auto).log2());
    let mut columns = Vec::new();
    let noise: Vec<f64> = truth.noise.iter().map(|noise| 1.0 + 2.0 * noise).collect();
    columns.push([image_file::picture(&film(&truth.mean.pixels), exposure), compared(truth, &noise)]);
    for found in films {
        let light = cells(&found.pixels);
        let ratios: Vec<f64> = light.iter().zip(&truth.cells).map(|(light, truth)| light.y / truth.y).collect();
        columns.push([image_file::picture(&film(&found.pixels), exposure), compared(truth, &ratios)]);
    }
    let (cell, paper) = (SIDE * ZOOM + GAP, Srgb8 { r: 255, g: 255, b: 255 });
    let (width, height) = (5 * cell - GAP, 2 * cell - GAP);
    let mut pixels = vec![paper; (width * height) as usize];
    for y in 0..height {
        for x in 0..width {
            let (column, row, inner) = (x / cell, y / cell, (x % cell / ZOOM, y % cell / ZOOM));
            if inner.0 < SIDE && inner.1 < SIDE {
                let picture = &columns[column as usize][row as usize];
                pixels[(y * width + x) as usize] = picture.pixels()[(inner.1 * SIDE + inner.0) as usize];
            }
        }
    }
    let notes = [("Software", concat!("snowblue ", env!("CARGO_PKG_VERSION")))];
    let png = image_file::png_bytes(&Picture::new(width, height, pixels), &notes).map_err(Failure::work)?;
    Ok(Rendered { name: case.name, caption: case.caption.clone(), png })
}

/// Ratios as colours: blue below one, red above; grey where the reference is dark.
fn compared(truth: &Truth, ratios: &[f64]) -> Picture {
    const DARK: Srgb8 = Srgb8 { r: 120, g: 120, b: 120 };
    let (less, equal, more) = ([0.02, 0.11, 0.42], [0.92, 0.92, 0.92], [0.45, 0.01, 0.03]);
    let colour = |ratio: f64| {
        let share = (ratio.max(1e-6).log2() / FULL_STOPS).clamp(-1.0, 1.0);
        let end: [f64; 3] = if share < 0.0 { less } else { more };
        let [r, g, b] = [0, 1, 2].map(|i| equal[i] + share.abs().sqrt() * (end[i] - equal[i]));
        Srgb8::encode(LinearRgb { r, g, b })
    };
    let mut shown = vec![DARK; ratios.len()];
    truth.lit.iter().for_each(|cell| shown[*cell] = colour(ratios[*cell]));
    let pixels = (0..(SIDE * SIDE) as usize).map(|pixel| shown[cell_of(pixel)]).collect();
    Picture::new(SIDE, SIDE, pixels)
}
