//! Tables as files: NetCDF classic with 64-bit offsets, named dimensions with coordinates, and CF attributes.
//!
//! A full table holds `transmittance` and `reflectance` on all axes. A compressed table holds, for each of the two,
//! the `coefficients` on all axes but the wavelength, the `basis` and the `singular_values`, and the attribute
//! `space`. A shard holds values on `grain`, `sample` (of a grain), `angle`, `thickness` and `wavelength`, and the
//! attribute `shard`. A packed table, such as the embedded table, has bytes (`packed`) instead of the `coefficients`;
//! the module `format` describes them.
//!
//! [`read`] reads a file and [`AnyTable::from_bytes`] its bytes; [`Table::write`](crate::Table::write) and similar
//! methods write a file, atomically ([`write_atomically`](snowblue_base::atomic_file::write_atomically)).
//!
//! [`export_csv`] writes a row for each value. The columns are the axes with their units (`grain_size_um`, `facetness`,
//! `density_kg_m3`, further properties, `angle_deg`, `thickness_cm`, `wavelength_nm`), `transmittance` and
//! `reflectance`.

mod format;
pub mod netcdf;
mod reader;
mod writer;

use std::path::Path;

use snowblue_transport::parameters::UNITS_OF_KEYS;

use crate::axes::{Coordinate, NamedAxis, is_diffuse};
use crate::{DatabaseError, Quantity};

pub use reader::{AnyTable, read};
pub(crate) use writer::write_bytes;

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
    let columns = axes.named().iter().map(column_name).collect::<Vec<_>>();
    writer.write_record(columns.iter().map(String::as_str).chain(Quantity::ALL.map(Quantity::name))).map_err(failed)?;
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

/// The name of the column of an axis, which ends in its unit.
fn column_name(NamedAxis { name, unit, .. }: &NamedAxis) -> String {
    let ending = UNITS_OF_KEYS.iter().find_map(|(ending, of_ending)| (of_ending == unit).then_some(*ending));
    format!("{name}{}", ending.unwrap_or_default())
}
