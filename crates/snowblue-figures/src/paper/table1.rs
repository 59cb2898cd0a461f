//! The paper's Table 1, the axes of the table of curves, and the values that the embedded table adds.

use snowblue_database::Axes;

use crate::error::FigureError;
use crate::figure::{Drawing, Figure, FigureTable};
use crate::plot::{Axis, Canvas, GREY, LABEL, Lettering, PALE, Stroke};
use crate::table::{Cell, DataTable};

const ADDED: &str = "#d1495b";
const PAPERS: &str = "#1f5fa8";
/// Ends of the axes, position of the first and distance between them, in pixels.
const LEFT: f64 = 210.0;
const RIGHT: f64 = 1040.0;
const FIRST: f64 = 96.0;
const APART: f64 = 62.0;
/// An axis with more values has labels at round values only.
const MOST_LABELS: usize = 30;

/// An axis with its name and unit, its scale, the paper's values and ours.
struct Row {
    name: &'static str,
    unit: &'static str,
    scale: Axis,
    paper: Vec<f64>,
    ours: Vec<f64>,
}

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let (paper, ours) = (Axes::paper(), snowblue_data::embedded().axes.clone());
    let rows = rows(&paper, &ours);
    let cells = |row: &Row| {
        let value_cells = |value: &f64| {
            let of = |values: &[f64]| Cell::Word(if contains(values, *value) { "yes" } else { "no" }.to_owned());
            vec![Cell::Word(row.name.to_lowercase().replace(' ', "_")), (*value).into(), of(&row.paper), of(&row.ours)]
        };
        row.ours.iter().map(value_cells).collect::<Vec<_>>()
    };
    Ok(Figure {
        title: "The axes of the table",
        ours: format!(
            "The same values: {} samples, {} curves of {} wavelengths, each with reflectance and transmittance. The \
             table that comes with snowblue adds thicknesses down to 5 µm and up to 1 m, and the angles 75° and 85°, \
             which makes interpolation accurate from 0 to 100 cm: {} curves. Infrared wavelengths, water, temperature \
             and impurities are optional axes.",
            paper.samples(),
            thousands(paper.curves()),
            paper.wavelengths_nm.len(),
            thousands(ours.curves()),
        ),
        paper:
            "Lists nine grain sizes, five values of facetness, five densities, eleven thicknesses and ten angles: 225 \
                samples and 24,750 curves of transmittance, at 31 wavelengths from 400 to 700 nm."
                .to_owned(),
        drawing: Drawing::Svg(draw(&rows)),
        numbers: DataTable::new(&["axis", "value", "paper", "embedded"], rows.iter().flat_map(cells).collect()),
        tables: vec![values_table(&rows, [&paper, &ours])],
        warning: None,
    })
}

fn rows(paper: &Axes, ours: &Axes) -> Vec<Row> {
    let row = |name, unit, scale, of: fn(&Axes) -> &Vec<f64>| Row {
        name,
        unit,
        scale,
        paper: of(paper).clone(),
        ours: of(ours).clone(),
    };
    vec![
        row("Mean grain size", "µm", Axis::linear(100.0, 500.0, 8.0), |axes| &axes.grain_sizes_um),
        row("Facetness", "", Axis::linear(0.1, 0.9, 4.0), |axes| &axes.facetness),
        row("Density", "kg/m³", Axis::linear(200.0, 400.0, 4.0), |axes| &axes.densities_kg_m3),
        row("Thickness", "cm", Axis::logarithmic(5e-4, 100.0), |axes| &axes.thicknesses_cm),
        row("Angle of incidence", "°", Axis::linear(0.0, 89.0, 9.0), |axes| &axes.angles_deg),
        row("Wavelength", "nm", Axis::linear(400.0, 700.0, 6.0), |axes| &axes.wavelengths_nm),
    ]
}

fn contains(values: &[f64], value: f64) -> bool {
    values.iter().any(|known| (known - value).abs() <= 1e-9 * value.abs())
}

fn values_table(rows: &[Row], [paper, ours]: [&Axes; 2]) -> FigureTable {
    let list = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    let line = |row: &Row| {
        let added: Vec<f64> = row.ours.iter().copied().filter(|value| !contains(&row.paper, *value)).collect();
        let name = if row.unit.is_empty() { row.name.to_owned() } else { format!("{} ({})", row.name, row.unit) };
        let shown = if row.paper.len() > 12 { "400 410 … 700".to_owned() } else { list(&row.paper) };
        vec![name, row.paper.len().to_string(), row.ours.len().to_string(), shown, list(&added)]
    };
    let mut lines: Vec<Vec<String>> = rows.iter().map(line).collect();
    let curves = [paper, ours].map(|axes| axes.curves().to_string());
    lines.push([vec!["Curves".to_owned()], curves.to_vec(), vec![String::new(), String::new()]].concat());
    let columns = ["axis", "count", "embedded", "the paper's values", "added"];
    FigureTable::of_words("values", "Table 1, and the values that the embedded table adds", &columns, lines)
}

fn draw(rows: &[Row]) -> String {
    let height = FIRST + APART * rows.len() as f64 + 24.0;
    let mut canvas = Canvas::new(1080.0, height, "The axes of the table of curves");
    let dots = [("the paper's Table 1", PAPERS, 740.0), ("added in ours", ADDED, 920.0)];
    for (name, colour, x) in dots {
        canvas.dot((x, 29.0), 5.0, colour);
        canvas.text((x + 12.0, 33.5), name, LABEL);
    }
    for (number, row) in rows.iter().enumerate() {
        draw_row(&mut canvas, row, FIRST + APART * number as f64);
    }
    let made = [("snowblue", env!("CARGO_PKG_VERSION").to_owned()), ("ours", "the embedded table".to_owned())];
    canvas.finish(height - 16.0, &made)
}

fn draw_row(canvas: &mut Canvas, row: &Row, y: f64) {
    let x = |value: f64| LEFT + (RIGHT - LEFT) * row.scale.fraction(value);
    canvas.text((24.0, y), row.name, Lettering { bold: true, ..LABEL });
    let count = if row.ours.len() == row.paper.len() {
        format!("{} values", row.paper.len())
    } else {
        format!("{} + {} values", row.paper.len(), row.ours.len() - row.paper.len())
    };
    let remark = if row.unit.is_empty() { count } else { format!("{count}, {}", row.unit) };
    canvas.text((24.0, y + 17.0), &remark, Lettering { size: 12.0, fill: GREY, ..LABEL });
    canvas.line((LEFT, y), (RIGHT, y), Stroke::solid(PALE, 3.0));
    // Many values have labels at round marks only.
    let many = row.ours.len() > MOST_LABELS;
    for value in &row.ours {
        let papers = contains(&row.paper, *value);
        let (colour, height) = if papers { (PAPERS, 23.0) } else { (ADDED, -13.0) };
        canvas.dot((x(*value), y), if many { 3.4 } else { 5.0 }, colour);
        if !many || contains(&row.scale.marks, *value) {
            let name = Lettering { size: 11.0, fill: colour, anchor: "middle", bold: false };
            canvas.text((x(*value), y + height), &value.to_string(), name);
        }
    }
}

/// 24,750 for 24750.
fn thousands(count: usize) -> String {
    let digits = count.to_string();
    let split = digits.len().saturating_sub(3);
    if split == 0 { digits } else { format!("{},{}", &digits[..split], &digits[split..]) }
}
