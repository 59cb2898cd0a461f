//! Imports curves from CSV: a header, then one row for each wavelength of each curve.
//!
//! Columns are the axes (`grain_size_um`, `facetness`, `density_kg_m3`, `angle_deg`, `thickness_cm`, `wavelength_nm`,
//! and further properties), `transmittance`, `reflectance` and, if they are known, `transmittance_se` and
//! `reflectance_se`. `snowblue spectrum` prints this format. Columns of absorptance are ignored.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use csv::{Reader, ReaderBuilder, StringRecord, Trim};

use super::columns::{FixedValues, axes, axis_of, check_fraction, metadata};
use crate::axes::DIFFUSE_ANGLE_DEG;
use crate::table::{CurveValues, StandardErrors};
use crate::{Axes, DatabaseError, Table};

const QUANTITIES: [&str; 4] = ["transmittance", "reflectance", "transmittance_se", "reflectance_se"];
/// Largest ratio of grid points to rows at which the first missing grid point is reported.
const MAX_GRID_RATIO: usize = 10;
const IGNORED: [&str; 2] = ["absorptance", "absorptance_se"];

/// The content of a column.
#[derive(Clone, Copy, PartialEq)]
enum Column {
    Axis(&'static str),
    Quantity(usize),
    Ignored,
}

/// A line: its coordinates on the axes, and the value of each quantity.
struct Row {
    line: u64,
    coordinates: Vec<f64>,
    values: [f64; 4],
}

/// Imports a table. `fixed` gives the values of what has no column.
///
/// # Errors
/// If the file cannot be read, a field is not a number, or the rows are not a complete grid. Messages name the line.
pub fn import_csv(path: &Path, fixed: &FixedValues) -> Result<Table, DatabaseError> {
    import(path, builder().from_path(path).map_err(|error| unreadable(path, &error))?, fixed)
}

/// Imports a table from the bytes of a file. `name` identifies them in messages.
///
/// # Errors
/// As [`import_csv`].
pub fn import_csv_bytes(name: &str, bytes: &[u8], fixed: &FixedValues) -> Result<Table, DatabaseError> {
    import(Path::new(name), builder().from_reader(bytes), fixed)
}

fn builder() -> ReaderBuilder {
    let mut builder = ReaderBuilder::new();
    builder.trim(Trim::All).comment(Some(b'#'));
    builder
}

fn unreadable(path: &Path, error: &csv::Error) -> DatabaseError {
    DatabaseError::file(path, format!("cannot be read: {error}"))
}

fn import<R: Read>(path: &Path, mut reader: Reader<R>, fixed: &FixedValues) -> Result<Table, DatabaseError> {
    let columns = columns(path, reader.headers().map_err(|error| unreadable(path, &error))?)?;
    let has =
        |wanted: usize| columns.iter().any(|column| matches!(column, Column::Quantity(found) if *found == wanted));
    let mut names: Vec<&'static str> =
        columns.iter().filter_map(|column| if let Column::Axis(name) = column { Some(*name) } else { None }).collect();
    let mut fixed_coordinates = Vec::new();
    let mut defaults = [f64::NAN; 4];
    for (name, value) in fixed {
        match (axis_of(name), QUANTITIES.iter().position(|quantity| quantity == name)) {
            (Some(axis), _) if !names.contains(&axis) => {
                names.push(axis);
                fixed_coordinates.push(*value);
            }
            (None, Some(quantity)) if !has(quantity) => defaults[quantity] = check_fraction(path, "", name, *value)?,
            (None, None) => {
                return Err(DatabaseError::file(path, format!("'{name}' is neither an axis nor a quantity")));
            }
            _ => return Err(DatabaseError::file(path, format!("has '{name}' itself, so it cannot be set"))),
        }
    }
    for quantity in 0..2 {
        if !has(quantity) && defaults[quantity].is_nan() {
            let name = QUANTITIES[quantity];
            return Err(DatabaseError::file(
                path,
                format!("has no '{name}'; if it is not needed, give any value: --set {name}=VALUE"),
            ));
        }
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let mut row = row(path, &columns, &record.map_err(|error| unreadable(path, &error))?, defaults)?;
        row.coordinates.extend(&fixed_coordinates);
        rows.push(row);
    }
    let mut values = BTreeMap::new();
    for (column, name) in names.iter().enumerate() {
        let mut axis: Vec<f64> = rows.iter().map(|row| row.coordinates[column]).collect();
        axis.sort_by(f64::total_cmp);
        axis.dedup();
        values.insert(*name, axis);
    }
    let axes = axes(path, values)?;
    let has_errors = has(2) && has(3);
    let [transmittance, reflectance, transmittance_se, reflectance_se] = curve_values(path, &axes, &names, rows)?;
    let errors = has_errors.then_some(StandardErrors { transmittance: transmittance_se, reflectance: reflectance_se });
    let values = CurveValues { transmittance, reflectance, errors };
    Ok(Table::new(axes, values, metadata(path, fixed)))
}

fn columns(path: &Path, header: &StringRecord) -> Result<Vec<Column>, DatabaseError> {
    let column = |name: &str| {
        if let Some(axis) = axis_of(name) {
            return Ok(Column::Axis(axis));
        }
        match QUANTITIES.iter().position(|quantity| *quantity == name) {
            Some(quantity) => Ok(Column::Quantity(quantity)),
            None if IGNORED.contains(&name) => Ok(Column::Ignored),
            None => Err(DatabaseError::file(path, format!("column '{}' is unknown", shown(name)))),
        }
    };
    let mut columns = Vec::new();
    for name in header {
        let column = column(name)?;
        if column != Column::Ignored && columns.contains(&column) {
            return Err(DatabaseError::file(path, format!("column '{}' occurs twice", shown(name))));
        }
        columns.push(column);
    }
    Ok(columns)
}

fn row(path: &Path, columns: &[Column], record: &StringRecord, defaults: [f64; 4]) -> Result<Row, DatabaseError> {
    let line = record.position().map_or(0, csv::Position::line);
    let mut row = Row { line, coordinates: Vec::new(), values: defaults };
    for (column, field) in columns.iter().zip(record) {
        let number = || {
            let number = field.parse().ok().filter(|number: &f64| number.is_finite());
            number.ok_or_else(|| DatabaseError::file(path, format!("line {line}: '{}' is not a number", shown(field))))
        };
        match column {
            Column::Axis("angle") if field == "diffuse" => row.coordinates.push(DIFFUSE_ANGLE_DEG),
            Column::Axis(_) => row.coordinates.push(number()?),
            Column::Quantity(quantity) => {
                let place = format!("line {line}: ");
                row.values[*quantity] = check_fraction(path, &place, QUANTITIES[*quantity], number()?)?;
            }
            Column::Ignored => {}
        }
    }
    Ok(row)
}

/// The start of a field, for messages.
fn shown(field: &str) -> String {
    field.chars().take(30).map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// An axis of the table with its column.
struct ColumnAxis {
    column: usize,
    values: Vec<f64>,
}

/// Orders rows on the grid of all the values that occur in them.
fn curve_values(
    path: &Path,
    axes: &Axes,
    names: &[&'static str],
    rows: Vec<Row>,
) -> Result<[Vec<f64>; 4], DatabaseError> {
    // `axes` requires a column for every axis.
    let column = |axis: &str| names.iter().position(|name| *name == axis).unwrap_or(0);
    let order: Vec<ColumnAxis> =
        axes.named().into_iter().map(|axis| ColumnAxis { column: column(axis.name), values: axis.values }).collect();
    let all = order.iter().try_fold(1_usize, |all, axis| all.checked_mul(axis.values.len()));
    let all = all.filter(|all| *all <= MAX_GRID_RATIO * rows.len()).ok_or_else(|| {
        let lengths: Vec<String> = order.iter().map(|axis| axis.values.len().to_string()).collect();
        let lengths = lengths.join(" × ");
        DatabaseError::file(path, format!("is not a grid: {} rows, but its axes have {lengths} values", rows.len()))
    })?;
    let mut lines = vec![0; all];
    let mut filled = [(); 4].map(|()| vec![0.0; all]);
    for row in rows {
        let index = order.iter().fold(0, |index, ColumnAxis { column, values }| {
            index * values.len() + values.partition_point(|value| *value < row.coordinates[*column])
        });
        if lines[index] > 0 {
            let what = format!("lines {} and {} are the same point of the grid", lines[index], row.line);
            return Err(DatabaseError::file(path, what));
        }
        lines[index] = row.line;
        for (filled, value) in filled.iter_mut().zip(row.values) {
            filled[index] = value;
        }
    }
    if let Some(empty) = lines.iter().position(|line| *line == 0) {
        let wavelengths = axes.wavelengths_nm.len();
        let curve = axes.describe(empty / wavelengths);
        let wavelength_nm = axes.wavelengths_nm[empty % wavelengths];
        let what = format!("is not a complete grid: there is no row for {curve}, {wavelength_nm} nm");
        return Err(DatabaseError::file(path, what));
    }
    Ok(filled)
}
