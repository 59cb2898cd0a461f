//! Charts as the text of SVG files.
//!
//! [`spectrum`] draws transmittance and reflectance against wavelength, [`bsdf`] how a slab scatters light in the plane
//! of incidence, and [`fidelity`] the errors of a compressed table.
//!
//! Charts are drawn with shapes of the `svg` crate: the plotting crates round to whole pixels, or have no polar plot of
//! two halves.

mod axis;
mod canvas;
mod colours;

mod chart;

mod bsdf;
mod fidelity;
mod spectrum;

pub(crate) use axis::Axis;
pub(crate) use canvas::{Canvas, GREY, INK, LABEL, Lettering, PALE, Point, Stroke};
pub(crate) use chart::{Area, Chart, Entry, Fill, Panel, Symbol};
pub(crate) use colours::ordered_colour;

pub use bsdf::bsdf;
pub use fidelity::{CompressionError, fidelity};
pub use spectrum::spectrum;
