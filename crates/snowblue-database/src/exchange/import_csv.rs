//! Curves from CSV: a header, then one row for each value of each curve.
//!
//! Columns are the axes (`grain_size_um`, `facetness`, `density_kg_m3`, `angle_deg`, `thickness_cm`, `wavelength_nm`, and
//! further properties), `transmittance`, `reflectance` and, if they are known, `transmittance_se` and `reflectance_se`.
//! What `snowblue spectrum` prints is of this kind. Columns of absorptance are passed over.

use std::collections::BTreeMap;
use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};

use super::{Fixed, axes, axis_of, check_share, metadata, wrong};
use crate::axes::DIFFUSE_ANGLE_DEG;
use crate::{DatabaseError, Table};

const QUANTITIES: [&str; 4] = ["transmittance", "reflectance", "transmittance_se", "reflectance_se"];
/// Times as many places as rows are searched for the one that is missing.
const MOST_MISSING: usize = 10;
const PASSED_OVER: [&str; 2] = ["absorptance", "absorptance_se"];

/// What a column is.
#[derive(Clone, Copy, PartialEq)]
enum Column {
    Axis(&'static str),
    Quantity(usize),
    Passed,
}

/// A line's values: by axis, and of each quantity.
struct Row {
    line: u64,
    place: Vec<f64>,
    values: [f64; 4],
}

/// Reads a table; `fixed` says what has no column.
///
/// # Errors
/// If the file cannot be read, a field is no number, or the rows are not a whole grid; with the line.
pub fn import_csv(path: &Path, fixed: &Fixed) -> Result<Table, DatabaseError> {
    let broken = |error: csv::Error| wrong(path, format!("cannot be read: {error}"));
    let mut reader = ReaderBuilder::new().trim(Trim::All).comment(Some(b'#')).from_path(path).map_err(broken)?;
    let columns = columns(path, reader.headers().map_err(broken)?)?;
    let has =
        |wanted: usize| columns.iter().any(|column| matches!(column, Column::Quantity(found) if *found == wanted));
    let mut names: Vec<&'static str> =
        columns.iter().filter_map(|column| if let Column::Axis(name) = column { Some(*name) } else { None }).collect();
    let mut said = Vec::new();
    let mut usual = [f64::NAN; 4];
    for (name, value) in fixed {
        match (axis_of(name), QUANTITIES.iter().position(|quantity| quantity == name)) {
            (Some(axis), _) if !names.contains(&axis) => {
                names.push(axis);
                said.push(*value);
            }
            (None, Some(quantity)) if !has(quantity) => usual[quantity] = check_share(path, "", name, *value)?,
            (None, None) => return Err(wrong(path, format!("'{name}' is neither an axis nor a quantity"))),
            _ => return Err(wrong(path, format!("has '{name}' itself, so it cannot be set"))),
        }
    }
    for quantity in 0..2 {
        if !has(quantity) && usual[quantity].is_nan() {
            let name = QUANTITIES[quantity];
            return Err(wrong(path, format!("has no '{name}'; if it does not matter, give it: --set {name}=VALUE")));
        }
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let mut row = row(path, &columns, &record.map_err(broken)?, usual)?;
        row.place.extend(&said);
        rows.push(row);
    }
    table(path, &names, rows, (has(2) && has(3), metadata(path, fixed)))
}

fn columns(path: &Path, header: &StringRecord) -> Result<Vec<Column>, DatabaseError> {
    let column = |name: &str| {
        if let Some(axis) = axis_of(name) {
            return Ok(Column::Axis(axis));
        }
        match QUANTITIES.iter().position(|quantity| *quantity == name) {
            Some(quantity) => Ok(Column::Quantity(quantity)),
            None if PASSED_OVER.contains(&name) => Ok(Column::Passed),
            None => Err(wrong(path, format!("column '{}' is not known", shown(name)))),
        }
    };
    let mut columns = Vec::new();
    for name in header {
        let column = column(name)?;
        if column != Column::Passed && columns.contains(&column) {
            return Err(wrong(path, format!("column '{}' comes twice", shown(name))));
        }
        columns.push(column);
    }
    Ok(columns)
}

fn row(path: &Path, columns: &[Column], record: &StringRecord, usual: [f64; 4]) -> Result<Row, DatabaseError> {
    let line = record.position().map_or(0, csv::Position::line);
    let mut row = Row { line, place: Vec::new(), values: usual };
    for (column, field) in columns.iter().zip(record) {
        let number = || {
            let number = field.parse().ok().filter(|number: &f64| number.is_finite());
            number.ok_or_else(|| wrong(path, format!("line {line}: '{}' is not a number", shown(field))))
        };
        match column {
            Column::Axis("angle") if field == "diffuse" => row.place.push(DIFFUSE_ANGLE_DEG),
            Column::Axis(_) => row.place.push(number()?),
            Column::Quantity(quantity) => {
                let place = format!("line {line}: ");
                row.values[*quantity] = check_share(path, &place, QUANTITIES[*quantity], number()?)?;
            }
            Column::Passed => {}
        }
    }
    Ok(row)
}

/// The start of a field, for messages.
fn shown(field: &str) -> String {
    field.chars().take(30).map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// Puts rows to their places on the grid of all the values that come in them.
fn table(
    path: &Path,
    names: &[&'static str],
    rows: Vec<Row>,
    (with_errors, metadata): (bool, Vec<(String, String)>),
) -> Result<Table, DatabaseError> {
    let mut values = BTreeMap::new();
    for (column, name) in names.iter().enumerate() {
        let mut axis: Vec<f64> = rows.iter().map(|row| row.place[column]).collect();
        axis.sort_by(f64::total_cmp);
        axis.dedup();
        values.insert(*name, axis);
    }
    let axes = axes(path, values)?;
    let named = axes.named();
    // Every axis of the table is one of the columns, or `axes` had refused.
    let column = |axis: &str| names.iter().position(|name| *name == axis).unwrap_or(0);
    let order: Vec<(usize, &Vec<f64>)> = named.iter().map(|(name, _, values)| (column(name), values)).collect();
    let all = order.iter().try_fold(1_usize, |all, (_, values)| all.checked_mul(values.len()));
    let all = all.filter(|all| *all <= MOST_MISSING * rows.len()).ok_or_else(|| {
        let lengths: Vec<String> = order.iter().map(|(_, values)| values.len().to_string()).collect();
        wrong(path, format!("is not a grid: {} rows, but values on its axes {}", rows.len(), lengths.join(" × ")))
    })?;
    let mut lines = vec![0; all];
    let mut filled = [(); 4].map(|()| vec![0.0; all]);
    for row in rows {
        let place = order.iter().fold(0, |place, (column, values)| {
            place * values.len() + values.partition_point(|value| *value < row.place[*column])
        });
        if lines[place] > 0 {
            return Err(wrong(path, format!("lines {} and {} are of one place", lines[place], row.line)));
        }
        lines[place] = row.line;
        for (filled, value) in filled.iter_mut().zip(row.values) {
            filled[place] = value;
        }
    }
    if let Some(empty) = lines.iter().position(|line| *line == 0) {
        let wavelengths = axes.wavelengths_nm.len();
        let place = axes.describe(empty / wavelengths);
        let wavelength_nm = axes.wavelengths_nm[empty % wavelengths];
        return Err(wrong(path, format!("is not a whole grid: there is no row for {place}, {wavelength_nm} nm")));
    }
    let [transmittance, reflectance, transmittance_se, reflectance_se] = filled;
    let errors = with_errors.then_some([transmittance_se, reflectance_se]);
    Ok(Table { axes, transmittance, reflectance, errors, metadata })
}
