//! `snowblue render --check`: sizes and topology of the objects of a scene.

use snowblue_figures::{Cell, DataTable};
use snowblue_render::Scene;
use snowblue_render::scene::inspection::{Inspection, inspect};

use crate::output::{Failure, Outcome, OutputOptions, print_notes, printable};

const COLUMNS: [&str; 16] = [
    "object",
    "name",
    "snow",
    "watertight",
    "triangles",
    "size_x_m",
    "size_y_m",
    "size_z_m",
    "volume_m3",
    "open_edges",
    "shared_edges",
    "reversed_edges",
    "merged_vertices",
    "degenerate",
    "lines",
    "odd_lines",
];

/// Reports every object, and fails if snow is not watertight.
pub(super) fn check(scene: &Scene, output: &OutputOptions, quiet: bool) -> Outcome {
    print_notes(quiet, scene.notes());
    let found = inspect(scene);
    let rows = found.iter().enumerate().map(|(index, object)| row(index, object)).collect();
    let metadata = vec![("sizes", "m".to_owned()), ("shared edges", "of more than two triangles".to_owned())];
    output.write(&DataTable { columns: COLUMNS.to_vec(), rows, metadata }, quiet)?;
    let open: Vec<&str> =
        found.iter().filter(|object| object.is_snow && !object.is_watertight()).map(|object| &*object.name).collect();
    if open.is_empty() {
        return Ok(());
    }
    Err(Failure::Work(format!(
        "snow is not watertight, which makes depths wrong: {}; `snowblue repair` closes holes",
        open.join(", ")
    )))
}

fn row(index: usize, object: &Inspection) -> Vec<Cell> {
    let yes_or_no = |yes: bool| Cell::Word(if yes { "yes" } else { "no" }.to_owned());
    let known = |value: Option<f64>| value.map_or_else(|| Cell::Word("-".to_owned()), Cell::Number);
    // Sizes have single precision, about seven digits.
    let size = |axis: usize| known(object.size_m.map(|size| digits(f64::from(size[axis]), 6)));
    let count = |count: usize| Cell::Number(count as f64);
    let topology = &object.topology;
    vec![
        count(index + 1),
        // A comma would separate columns in CSV.
        Cell::Word(printable(&object.name).replace(',', ";")),
        yes_or_no(object.is_snow),
        yes_or_no(object.is_watertight()),
        count(topology.triangles),
        size(0),
        size(1),
        size(2),
        known(object.volume_m3.map(|volume| digits(volume, 6))),
        count(topology.open_edges),
        count(topology.shared_edges),
        count(topology.reversed_edges),
        count(topology.merged_vertices),
        count(topology.degenerate_triangles),
        Cell::Number(object.lines.into()),
        Cell::Number(object.odd_lines.into()),
    ]
}

/// A value rounded to this many significant digits.
fn digits(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}
