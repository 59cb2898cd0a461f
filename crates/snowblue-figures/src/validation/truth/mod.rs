//! PCASnow and the light field against path-traced references: blocks and balls in front of a lamp, and further scenes.
//!
//! The reference of a scene is the mean of a few renderings with different seeds; their scatter gives its noise. A
//! method is judged by ln(L/L₀), where L is its luminance in a cell of 4×4 pixels and L₀ that of the reference, over
//! all cells where L₀ exceeds a hundredth of its maximum. The mean square of the noise is subtracted.

mod cases;
mod comparison;
mod image;
mod method;
mod sheet;

use snowblue_render::RenderError;

use crate::error::FigureError;
use crate::figure::{Drawing, Figure, FigureTable, Rendering};
use crate::shading::{daylight, wavelengths_nm};
use crate::table::{Cell, DataTable};
use cases::{Case, Group, cases};
use comparison::{Comparison, Reference, SEEDS};
use image::{PARTS, render_timed};
use method::Method;
use sheet::MethodImage;

const COLUMNS: [&str; 15] = [
    "scene",
    "method",
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
    "method_s",
];

/// The figure, with `sample_factor` times the samples in its references.
pub(crate) fn figure(sample_factor: u32) -> Result<Figure, FigureError> {
    let (mut renderings, mut rows, mut part_rows) = (Vec::new(), Vec::new(), Vec::new());
    let mut judged = Vec::new();
    let white = daylight(&wavelengths_nm(400, 700, 10))?.white();
    for case in cases(sample_factor)? {
        let reference = Reference::render(&mut case.integrator(Method::Reference)?, white);
        let images = Method::COMPARED.map(|method| {
            let mut integrator = case.integrator(method)?;
            integrator.set_samples_per_pixel(method.samples());
            integrator.set_seed(SEEDS);
            Ok(MethodImage { method, image: render_timed(&integrator) })
        });
        let images: Vec<MethodImage> = images.into_iter().collect::<Result<_, RenderError>>()?;
        let png = sheet::png(&reference, &images)?;
        renderings.push(Rendering { name: case.name.to_owned(), caption: case.caption.clone(), png });
        if case.is_front {
            part_rows.extend(rows_of_parts(&case, &reference, &images));
        }
        for MethodImage { method, image } in &images {
            let comparison = reference.compare(image);
            rows.push(row(&case, *method, &reference, &comparison));
            judged.push(Judgement { group: case.group, method: *method, comparison });
        }
    }
    Ok(Figure {
        title: "PCASnow and the light field against path tracing",
        ours: "For each scene, above: the reference, the path modes of PCASnow, diffusion and hybrid, all at the \
               reference's exposure. Below: their luminance over that of the reference in cells of 4×4 pixels; the \
               first shows two standard errors of the reference on the same scale. Grains of 400 µm, facetness .3, \
               300 kg/m³, a point light of D65."
            .to_owned(),
        paper: "Judges its pictures by eye, and its curves against its light transport model; it has no path-traced \
                picture of a block."
            .to_owned(),
        drawing: Drawing::Renderings(renderings),
        numbers: DataTable::new(&COLUMNS, rows),
        tables: vec![summary(&judged), parts_table(part_rows)],
        warning: None,
    })
}

/// How a method renders a scene.
struct Judgement {
    group: Group,
    method: Method,
    comparison: Comparison,
}

fn row(case: &Case, method: Method, reference: &Reference, comparison: &Comparison) -> Vec<Cell> {
    let [low, median, high] = comparison.ratios;
    let cells = reference.lit_cells.len() as f64;
    let noise_squares: f64 = reference.lit_cells.iter().map(|cell| reference.noise[*cell].powi(2)).sum();
    let values = [
        cells,
        low,
        median,
        high,
        signed_root(comparison.mean_square_log),
        comparison.energy,
        comparison.delta_e,
        reference.noise_delta_e,
        comparison.hue_delta_e,
        (noise_squares / cells).sqrt(),
        f64::from(case.samples * SEEDS),
        reference.mean.seconds,
        comparison.seconds,
    ];
    [case.name, method.name()].map(Cell::word).into_iter().chain(values.map(Cell::Number)).collect()
}

/// The root of a mean square, negative where noise made that negative.
fn signed_root(square: f64) -> f64 {
    square.abs().sqrt().copysign(square)
}

/// Each method over the scenes of each group, with equal weights.
fn summary(judged: &[Judgement]) -> FigureTable {
    let row = |method: Method| {
        let chosen = |groups: &[Group]| -> Vec<&Comparison> {
            let judgements =
                judged.iter().filter(|judgement| judgement.method == method && groups.contains(&judgement.group));
            judgements.map(|judgement| &judgement.comparison).collect()
        };
        let mean = |chosen: &[&Comparison], value: &dyn Fn(&Comparison) -> f64| {
            chosen.iter().map(|comparison| value(comparison)).sum::<f64>() / chosen.len() as f64
        };
        let rms = |groups: &[Group]| {
            format!("{:.3}", signed_root(mean(&chosen(groups), &|comparison| comparison.mean_square_log)))
        };
        let all = chosen(&[Group::Blocks, Group::Balls, Group::Further]);
        let worst = all.iter().map(|comparison| comparison.energy.ln().abs()).fold(0.0, f64::max).exp();
        vec![
            method.name().to_owned(),
            rms(&[Group::Blocks]),
            rms(&[Group::Balls]),
            rms(&[Group::Further]),
            format!("{:.2}", mean(&all, &|comparison| comparison.delta_e)),
            format!("{:.2}", mean(&all, &|comparison| comparison.hue_delta_e)),
            format!("{:.2}", mean(&all, &|comparison| comparison.energy.ln()).exp()),
            format!("{worst:.2}"),
        ]
    };
    let columns = [
        "Method",
        "RMS of ln ratio, blocks",
        "Balls",
        "Further scenes",
        "Mean ΔE00",
        "ΔE00 of all light",
        "Energy ratio",
        "Worst energy ratio or its inverse",
    ];
    FigureTable::of_words("methods", "Methods over all scenes", &columns, Method::COMPARED.map(row).into())
}

/// Luminance by each method over that of the reference in the parts of a block.
fn rows_of_parts(case: &Case, reference: &Reference, images: &[MethodImage]) -> Vec<Vec<String>> {
    let rows = PARTS.iter().zip(&reference.parts).map(|(part, expected)| {
        let ratios = images
            .iter()
            .map(|MethodImage { image, .. }| format!("{:.2}", part.luminance(&image.pixels) / expected.luminance));
        let words = [case.name.to_owned(), part.name.to_owned(), format!("{:.2}", expected.relative_error)];
        words.into_iter().chain(ratios).collect()
    });
    rows.collect()
}

fn parts_table(rows: Vec<Vec<String>>) -> FigureTable {
    let methods = Method::COMPARED.map(Method::name);
    let columns: Vec<&str> = ["Block", "Part", "Noise of the reference"].into_iter().chain(methods).collect();
    FigureTable::of_words("parts", "Luminance over that of the reference, straight on", &columns, rows)
}
