#![doc = include_str!("../README.md")]
//!
//! # Data flow
//!
//! ```text
//! Axes ─► fill ─► Table ─► pca ─► CompressedTable ─► lookup (PcaSnow) ─► a spectrum
//!                   └──────── fidelity ────┘
//! ```
//!
//! A [`Table`] holds transmittance and reflectance for every grain size, facetness, density, angle, thickness and
//! wavelength; [`fill::fill`] computes it by either engine, [`shard`] in parts. A [`CompressedTable`] keeps a few
//! principal components of it ([`pca`]), in the paper's linear space or in the space of logarithms. [`PcaSnow`] is one
//! snow sample of a compressed table, ready for look-ups of spectra at any thickness and angle: the paper's Algorithm
//! 1. [`compact`] fits the colours of one sample for shaders, [`preset`] the subsurface parameters of other renderers.
//! [`fidelity`] evaluates the errors of compression, [`matching`] finds snow of a target colour, [`mod@file`] reads and
//! writes NetCDF, and [`export_csv`] writes CSV.
//!
//! **Simplifications.** Between the table's values everything is interpolated in log space. In the paper's scheme,
//! grain size, facetness and density take only the values of the grid, as in the paper.
//!
//! **Out of scope.** Light transport in snow (`snowblue-transport`), and the use of spectra in pictures
//! (`snowblue-render`).

pub mod error;

pub mod axes;
pub mod axes_file;
pub mod property;
pub mod table;

pub mod fill;
pub mod shard;

pub mod pca;
mod svd;

mod blend;
mod cubic;
pub mod lookup;

pub mod compact;
pub mod preset;

pub mod fidelity;

pub mod matching;

pub mod file;

pub use axes::Axes;
pub use error::DatabaseError;
pub use file::export_csv;
pub use lookup::PcaSnow;
pub use matching::Interval;
pub use pca::{CompressedTable, Space};
pub use property::{PropertyAxis, PropertyValue, TableSample, axis_properties, unit_in_files};
pub use snowblue_transport::Property;
pub use table::{Quantity, Table};
