//! One grain of ice: its shape, its rough surface, and what it does to a ray of light.

pub mod microsurface;
mod scatter;
mod spheroid;

pub use scatter::{Grain, ROUGHNESS_PER_FACETNESS, Scattered};
pub use spheroid::{SizeMeasure, Spheroid};
