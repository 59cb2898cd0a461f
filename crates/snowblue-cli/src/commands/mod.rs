//! The commands: each parses its options, calls the library and writes the result.

pub(crate) mod bake;
pub(crate) mod bsdf;
pub(crate) mod color;
pub(crate) mod completions;
pub(crate) mod database;
pub(crate) mod export;
pub(crate) mod figures;
mod interrupt;
pub(crate) mod man;
pub(crate) mod match_color;
pub(crate) mod merge;
pub(crate) mod render;
pub(crate) mod repair;
pub(crate) mod schema;
pub(crate) mod sky;
pub(crate) mod slab;
pub(crate) mod spectrum;
pub(crate) mod swatch;
