//! Export of tables to other programs: [`export_csv`] writes a row for each value, [`export_raw`] plain `f32` numbers
//! with a JSON file that describes them. A table of another program is a NetCDF file in the layout of [`crate::file`].

mod export_csv;
mod export_raw;

pub use export_csv::export_csv;
pub use export_raw::export_raw;
