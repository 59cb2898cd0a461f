//! Charts as the text of SVG files.
//!
//! [`spectrum`] draws transmittance and reflectance against wavelength, and [`bsdf`] how a slab scatters light in the
//! plane of incidence.
//!
//! Charts are drawn with shapes of the `svg` crate: the SVG of plotting crates has whole pixels only, no title, and no
//! polar axes.

mod axis;
mod chart;

mod bsdf;
mod spectrum;

pub(crate) use axis::Axis;
pub(crate) use chart::{Area, Chart, GREY, HEADING, INK, LABEL, Lettering, Stroke, ordered_colours};

pub use bsdf::bsdf;
pub use spectrum::spectrum;
