//! Tables as files: NetCDF classic with 64-bit offsets, named dimensions with coordinates, and CF attributes.
//!
//! A full table holds `transmittance` and `reflectance` on all axes. A compressed table holds, for each of the two, the
//! `coefficients` on all axes but the wavelength, the `basis` and the `singular_values`, and the attribute `space`. A
//! shard holds values on `grain`, `sample` (of a grain), `angle`, `thickness` and `wavelength`, and the attribute
//! `shard`. A packed table, such as the embedded one, has bytes (`packed`) instead of the `coefficients`; the module of
//! that name has their format.
//!
//! [`read`] reads a file and [`AnyTable::from_bytes`] its bytes; [`Table::write`](crate::Table::write) and its like
//! write one, atomically ([`write_atomically`](snowblue_base::atomic_file::write_atomically)).

mod header;
mod names;
mod packed;
mod reader;
mod writer;

pub use reader::{AnyTable, read};

pub(crate) use writer::write_bytes;
