//! The paper's Table 1, the axes of the table of curves, and the values that the embedded table adds.

use snowblue_database::Axes;

use crate::figure::{Figure, FigureError};
use crate::table::{Cell, DataTable};

const OURS: &str = "The embedded table has the paper's values. It adds thicknesses down to 5 µm and up to 1 m, and the \
    angles 75° and 85°, which makes interpolation accurate from 0 to 100 cm.";
const PAPER: &str = "Lists 225 samples and 24,750 curves of transmittance, at 31 wavelengths from 400 to 700 nm.";

type Values = fn(&Axes) -> &Vec<f64>;

const AXES: [(&str, Values); 6] = [
    ("grain_size_um", |axes| &axes.grain_sizes_um),
    ("facetness", |axes| &axes.facetness),
    ("density_kg_m3", |axes| &axes.densities_kg_m3),
    ("thickness_cm", |axes| &axes.thicknesses_cm),
    ("angle_deg", |axes| &axes.angles_deg),
    ("wavelength_nm", |axes| &axes.wavelengths_nm),
];

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let (paper, ours) = (Axes::paper(), &snowblue_data::embedded().axes);
    let (mut values, mut counts) = (Vec::new(), Vec::new());
    for (name, of) in AXES {
        let is_papers = |value: &&f64| of(&paper).iter().any(|known| (known - **value).abs() <= 1e-9 * value.abs());
        let list = |values: Vec<&f64>| match values[..] {
            [first, second, .., last] if values.len() > 13 => format!("{first} {second} … {last}"),
            _ => values.iter().map(|value| value.to_string()).collect::<Vec<_>>().join(" "),
        };
        let (papers, added): (Vec<&f64>, Vec<&f64>) = of(ours).iter().partition(is_papers);
        counts.push(vec![
            Cell::word(name),
            (of(&paper).len() as f64).into(),
            (of(ours).len() as f64).into(),
            Cell::Word(list(papers)),
            Cell::Word(list(added)),
        ]);
        let row = |value: &f64| {
            let is_papers = if is_papers(&value) { "yes" } else { "no" };
            vec![Cell::word(name), (*value).into(), Cell::word(is_papers)]
        };
        values.extend(of(ours).iter().map(row));
    }
    let curves = [&paper, ours].map(|axes| Cell::Number(axes.curves() as f64));
    counts.push([&[Cell::word("curves")], &curves[..], &[Cell::word(""), Cell::word("")]].concat());
    let columns = ["axis", "count", "embedded", "the paper's values", "added"];
    Ok(Figure {
        title: "The axes of the table",
        ours: OURS.to_owned(),
        paper: PAPER,
        pictures: Vec::new(),
        numbers: DataTable::new(&["axis", "value", "paper"], values),
        table: Some(("Table 1, and the values that the embedded table adds", DataTable::new(&columns, counts))),
        warning: None,
    })
}
