//! Import of curves from other models and instruments, and export of tables to other programs.
//!
//! - [`import_csv`]: one row per value, columns by name, rows in any order;
//! - [`import_netcdf`]: variables on named dimensions in any order;
//! - [`export_csv`]: the same rows; [`export_raw`]: plain `f32` numbers with a JSON file that describes them.
//!
//! Imported values must form a complete grid: every combination of the axes' values occurs once. An axis that the file
//! does not have is given as a fixed value. Values are not changed, but must lie in 0–1 with a tolerance for noise.

mod columns;
mod export_csv;
mod export_raw;
mod import_csv;
mod import_netcdf;

use std::path::Path;

use crate::{DatabaseError, Table};

pub use columns::FixedValues;
pub use export_csv::export_csv;
pub use export_raw::export_raw;
pub use import_csv::{import_csv, import_csv_bytes};
pub use import_netcdf::{import_netcdf, import_netcdf_bytes};

/// Reads a table from a NetCDF file, if the name ends in `.nc`, or else from CSV.
///
/// # Errors
/// As those of [`import_netcdf`] and [`import_csv`].
pub fn import(path: &Path, fixed: &FixedValues) -> Result<Table, DatabaseError> {
    let is_netcdf = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("nc"));
    if is_netcdf { import_netcdf(path, fixed) } else { import_csv(path, fixed) }
}
