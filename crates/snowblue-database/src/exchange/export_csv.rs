//! A table as CSV: one row a value, the columns that [`super::import_csv`] reads.

use std::path::Path;

use super::{axis_names, wrong};
use crate::axes::is_diffuse;
use crate::file::{AnyTable, replace};
use crate::{DatabaseError, Quantity};

/// Writes every value of a full table, or every rebuilt one of a compressed table.
///
/// # Errors
/// If the file cannot be written, or the table is a shard.
pub fn export_csv(table: &AnyTable, path: &Path) -> Result<(), DatabaseError> {
    let failed = |error: csv::Error| wrong(path, format!("cannot be written: {error}"));
    let axes = match table {
        AnyTable::Full(table) => &table.axes,
        AnyTable::Compressed(table) => &table.axes,
        AnyTable::Shard(_) => return Err(wrong(path, "cannot be made of a shard; merge it first".to_owned())),
    };
    let mut writer = csv::Writer::from_writer(Vec::new());
    let names = axis_names();
    let named = axes.named();
    let columns =
        named.iter().map(|(axis, ..)| names.iter().find(|(short, _)| short == axis).map_or(*axis, |(_, l)| l));
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
        let word = |(name, _, value): (&str, &str, f64)| {
            if name == "angle" && is_diffuse(value) { "diffuse".to_owned() } else { value.to_string() }
        };
        let place: Vec<String> = axes.place(number).into_iter().map(word).collect();
        for (w, wavelength_nm) in axes.wavelengths_nm.iter().enumerate() {
            let row = place.iter().cloned().chain([*wavelength_nm, curve[0][w], curve[1][w]].map(|v| v.to_string()));
            writer.write_record(row).map_err(failed)?;
        }
    }
    let text = writer.into_inner().map_err(|error| wrong(path, format!("cannot be written: {}", error.error())))?;
    replace(path, &text)
}
