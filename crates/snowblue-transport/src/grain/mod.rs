//! A single grain of ice: its shape, its rough surface, and the scattering of a ray of light by it.

pub mod microsurface;
mod scatter;
mod spheroid;

pub use scatter::{Grain, ROUGHNESS_PER_FACETNESS, Scattered};
pub use spheroid::{SizeMeasure, Spheroid};
