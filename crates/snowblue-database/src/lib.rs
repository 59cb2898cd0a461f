//! Curves of snow on named axes: filled, compressed, judged, looked up, kept in files.
//!
//! ```text
//! Axes ─► fill ─► Table ─► pca ─► CompressedTable ─► lookup (PcaSnow) ─► a spectrum
//!                   └──────── fidelity ────┴──────────────┘
//! ```
//!
//! A [`Table`] holds transmittance and reflectance for every grain size, facetness, density, angle, thickness and
//! wavelength; [`fill::fill`] computes it by either engine. A [`CompressedTable`] keeps a few principal components of it
//! ([`pca`]), in the paper's linear space or in the space of logarithms. [`PcaSnow`] is one snow out of a compressed
//! table, ready to be asked for a spectrum at any thickness and angle: the paper's Algorithm 1. [`fidelity`] tells what
//! compression and interpolation cost, and [`mod@file`] reads and writes NetCDF.
//!
//! **Simplified.** Between the table's values everything is interpolated, in log space; in the paper's form grain size,
//! facetness and density are taken at the grid's values only, as in the paper.
//!
//! **Out of scope.** What snow does to light (`snowblue-transport`), and what becomes of a spectrum (`snowblue-render`).

pub mod error;

pub mod axes;
pub mod property;
pub mod table;
pub mod table_sample;

pub mod fill;
pub mod shard;

pub mod pca;

mod blend;
mod cubic;
pub mod lookup;
mod spline;

pub mod fidelity;

pub mod matching;

pub mod file;

pub mod exchange;

pub use axes::Axes;
pub use error::DatabaseError;
pub use lookup::PcaSnow;
pub use pca::{CompressedTable, Space};
pub use property::Property;
pub use table::{Quantity, Table};
pub use table_sample::TableSample;
