//! Exports a table as CSV: one row per value, with the columns that [`super::import_csv`] reads.

use std::path::Path;

use super::columns::axis_names;
use crate::axes::{Coordinate, is_diffuse};
use crate::file::{AnyTable, write_bytes};
use crate::{DatabaseError, Quantity};

/// Writes every value of a full table, or every rebuilt value of a compressed table.
///
/// # Errors
/// If the file cannot be written, or the table is a shard.
pub fn export_csv(table: &AnyTable, path: &Path) -> Result<(), DatabaseError> {
    let failed = |error: csv::Error| DatabaseError::file(path, format!("cannot be written: {error}"));
    let axes = match table {
        AnyTable::Full(table) => &table.axes,
        AnyTable::Compressed(table) => &table.axes,
        AnyTable::Shard(_) => {
            return Err(DatabaseError::file(path, "cannot be made from a shard; merge the shards first"));
        }
    };
    let mut writer = csv::Writer::from_writer(Vec::new());
    let names = axis_names();
    let named = axes.named();
    let columns =
        named.iter().map(|axis| names.iter().find(|n| n.netcdf == axis.name).map_or(axis.name, |n| n.csv.as_str()));
    writer.write_record(columns.chain(Quantity::ALL.map(Quantity::name))).map_err(failed)?;
    let wavelengths = axes.wavelengths_nm.len();
    let mut curve = [vec![0.0; wavelengths], vec![0.0; wavelengths]];
    for number in 0..axes.curves() {
        for (values, quantity) in curve.iter_mut().zip(Quantity::ALL) {
            match table {
                AnyTable::Full(table) => {
                    values.copy_from_slice(&table.values(quantity)[number * wavelengths..][..wavelengths])
                }
                AnyTable::Compressed(table) => table.components(quantity).rebuild(number, table.space, values),
                AnyTable::Shard(_) => {}
            }
        }
        let word = |Coordinate { name, value, .. }: Coordinate| {
            if name == "angle" && is_diffuse(value) { "diffuse".to_owned() } else { value.to_string() }
        };
        let coordinates: Vec<String> = axes.coordinates(number).into_iter().map(word).collect();
        for (w, wavelength_nm) in axes.wavelengths_nm.iter().enumerate() {
            let row =
                coordinates.iter().cloned().chain([*wavelength_nm, curve[0][w], curve[1][w]].map(|v| v.to_string()));
            writer.write_record(row).map_err(failed)?;
        }
    }
    let text = writer
        .into_inner()
        .map_err(|error| DatabaseError::file(path, format!("cannot be written: {}", error.error())))?;
    write_bytes(path, &text)
}
