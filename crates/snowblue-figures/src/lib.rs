//! Charts of light through snow, sheets of labelled colours, and the figures and tables of the PCASnow paper,
//! recomputed.
//!
//! ```text
//! table ─► plot: charts of spectra, of BSDFs and of compression errors, as SVG
//!            └─► figure ─► paper, validation ─► catalog (all figures by name) ─► page (HTML)
//! ```
//!
//! [`recipes`] selects figures by name, [`Recipe::make`] computes one, [`Figure::files`] gives its files, and
//! [`page::index`] the page that shows them. Nothing is written: files are the caller's.
//!
#![doc = include_str!("../README.md")]

pub mod error;
pub mod table;

pub mod plot;

pub mod swatch;

pub mod figure;
mod scenes;
mod shading;

mod paper;
mod validation;

pub mod catalog;
pub mod page;

pub use catalog::{FigureOptions, RECIPES, Recipe, recipes};
pub use error::FigureError;
pub use figure::{Drawing, Figure, FigureFile, FigureTable, Rendering};
pub use table::{Cell, DataTable, Metadata, format_number};
