//! The four path modes of PCASnow against path-traced references: blocks and a ball in front of a lamp.
//!
//! The reference of a scene is the mean of a few renderings with different seeds; their scatter gives its noise. A mode
//! is judged by ln(L/L₀), where L is its luminance in a cell of 4×4 pixels and L₀ that of the reference, over all cells
//! where L₀ exceeds a hundredth of its maximum. The mean square of the noise is subtracted.

mod cases;
mod comparison;
mod image;
mod sheet;

use snowblue_render::RenderError;
use snowblue_render::scene::Scene;
use snowblue_render::scene::material::pca_snow::PathMode;

use crate::error::FigureError;
use crate::figure::{Drawing, Figure, FigureTable, Rendering};
use crate::shading::{daylight, wavelengths_nm};
use crate::table::{Cell, DataTable};
use cases::{Case, cases};
use comparison::{Comparison, Reference, SEEDS};
use image::{PARTS, TimedImage, render_timed};
use sheet::ModeImage;

/// Samples per pixel by PCASnow, whose only noise here is that of edges.
const PCASNOW_SAMPLES: u32 = 256;

const MODES: [(&str, PathMode); 4] = [
    ("view", PathMode::View),
    ("normal", PathMode::Normal),
    ("light", PathMode::Light),
    ("brightest", PathMode::Brightest),
];

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

/// The figure, with `sample_factor` times the samples in its references.
pub(crate) fn figure(sample_factor: u32) -> Result<Figure, FigureError> {
    let (mut renderings, mut rows, mut part_rows) = (Vec::new(), Vec::new(), Vec::new());
    let mut by_mode: Vec<Vec<Comparison>> = MODES.iter().map(|_| Vec::new()).collect();
    let white = daylight(&wavelengths_nm(400, 700, 10))?.white();
    for case in cases(sample_factor)? {
        let reference = Reference::render(&mut case.reference()?, white);
        let images = MODES.iter().map(|(mode, path_mode)| {
            let image = render_pcasnow(&mut case.pcasnow(*path_mode)?);
            Ok(ModeImage { mode, image })
        });
        let images: Vec<ModeImage> = images.collect::<Result<_, RenderError>>()?;
        let png = sheet::png(&reference, &images)?;
        renderings.push(Rendering { name: case.name, caption: case.caption.clone(), png });
        if case.is_front {
            part_rows.extend(rows_of_parts(&case, &reference, &images));
        }
        for (ModeImage { mode, image }, comparisons) in images.iter().zip(&mut by_mode) {
            let comparison = reference.compare(image);
            rows.push(row(&case, mode, &reference, &comparison));
            comparisons.push(comparison);
        }
    }
    Ok(Figure {
        title: "PCASnow against path tracing",
        ours: "For each scene, above: the reference, then view, normal, light and brightest, all at the reference's \
               exposure. Below: their luminance over that of the reference in cells of 4×4 pixels; the first shows two \
               standard errors of the reference on the same scale. Grains of 400 µm, facetness .3, 300 kg/m³, a point \
               light of D65."
            .to_owned(),
        paper: "Judges its pictures by eye, and its curves against its light transport model; it has no path-traced \
                picture of a block."
            .to_owned(),
        drawing: Drawing::Renderings(renderings),
        numbers: DataTable::new(&COLUMNS, rows),
        tables: vec![summary(&by_mode), parts_table(part_rows)],
        warning: None,
    })
}

/// Renders a scene by PCASnow.
fn render_pcasnow(scene: &mut Scene) -> TimedImage {
    scene.set_samples_per_pixel(PCASNOW_SAMPLES);
    scene.set_seed(SEEDS);
    render_timed(scene)
}

fn row(case: &Case, mode: &str, reference: &Reference, comparison: &Comparison) -> Vec<Cell> {
    let [low, median, high] = comparison.ratios;
    let cells = reference.lit_cells.len() as f64;
    let noise_squares: f64 = reference.lit_cells.iter().map(|cell| reference.noise[*cell].powi(2)).sum();
    let values = [
        cells,
        low,
        median,
        high,
        comparison.mean_square_log.max(0.0).sqrt(),
        comparison.energy,
        comparison.delta_e,
        reference.noise_delta_e,
        comparison.hue_delta_e,
        (noise_squares / cells).sqrt(),
        f64::from(case.samples * SEEDS),
        reference.mean.seconds,
        comparison.seconds,
    ];
    [case.name, mode].map(Cell::word).into_iter().chain(values.map(Cell::Number)).collect()
}

/// Each mode over all scenes, with equal weights.
fn summary(by_mode: &[Vec<Comparison>]) -> FigureTable {
    let row = |(comparisons, (mode, _)): (&Vec<Comparison>, (&str, PathMode))| {
        let mean =
            |value: &dyn Fn(&Comparison) -> f64| comparisons.iter().map(value).sum::<f64>() / comparisons.len() as f64;
        let worst = comparisons.iter().map(|one| one.energy.ln().abs()).fold(0.0, f64::max).exp();
        vec![
            mode.to_owned(),
            format!("{:.3}", mean(&|one| one.mean_square_log).max(0.0).sqrt()),
            format!("{:.2}", mean(&|one| one.delta_e)),
            format!("{:.2}", mean(&|one| one.hue_delta_e)),
            format!("{:.2}", mean(&|one| one.energy.ln()).exp()),
            format!("{worst:.2}"),
        ]
    };
    let columns = [
        "Path",
        "RMS of ln ratio",
        "Mean ΔE00",
        "ΔE00 of all light",
        "Energy ratio",
        "Worst energy ratio or its inverse",
    ];
    let rows = by_mode.iter().zip(MODES).map(row).collect();
    FigureTable::of_words("modes", "Path modes over all scenes", &columns, rows)
}

/// Luminance of each mode over that of the reference in the parts of a block.
fn rows_of_parts(case: &Case, reference: &Reference, images: &[ModeImage]) -> Vec<Vec<String>> {
    let rows = PARTS.iter().zip(&reference.parts).map(|(part, expected)| {
        let ratios = images
            .iter()
            .map(|ModeImage { image, .. }| format!("{:.2}", part.luminance(&image.pixels) / expected.luminance));
        let words = [case.name.to_owned(), part.name.to_owned(), format!("{:.2}", expected.relative_error)];
        words.into_iter().chain(ratios).collect()
    });
    rows.collect()
}

fn parts_table(rows: Vec<Vec<String>>) -> FigureTable {
    let columns = ["Block", "Part", "Noise of the reference", "view", "normal", "light", "brightest"];
    FigureTable::of_words("parts", "Luminance over that of the reference, straight on", &columns, rows)
}
