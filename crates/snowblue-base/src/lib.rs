#![doc = include_str!("../README.md")]
//!
//! **Simplified.** A file is read as a whole. The hash is no protection against forgery.
//!
//! **Out of scope.** The formats of files, and any physics.

pub mod range;

pub mod parameter;
pub mod quantity;

pub mod atomic_file;
pub mod csv_text;
pub mod files;
pub mod hash;
pub mod spectrum_csv;

pub mod schema;

pub mod key_path;
pub mod toml_table;

pub mod units;

pub use key_path::{KeyError, KeyPath};
pub use parameter::Parameter;
pub use quantity::{Count, Number, Numbers, Quantity};
pub use range::{ParameterRange, RangeError, short_number, unit_suffix};
pub use toml_table::ParseError;
pub use units::narrow;
