//! Charts of light through snow, tables of results, and the figures and tables of the PCASnow paper, recomputed.
//!
//! ```text
//! table ─► plot: charts of spectra and of BSDFs, as SVG
//!            └─► figure ─► paper ─► catalog (all figures by name, and their HTML page)
//! ```
//!
//! [`recipes`] selects figures by name, [`Recipe::make`] computes one, [`Figure::files`] gives its files, and [`page`]
//! the page that shows them. Nothing is written: files are the caller's.
//!
#![doc = include_str!("../README.md")]

mod table;

pub mod plot;

mod figure;
mod paper;

mod catalog;

pub use catalog::{RECIPES, Recipe, page, recipes};
pub use figure::{Figure, FigureError, FigureFile, Picture};
pub use table::{Cell, DataTable, Metadata, format_number};
