#![doc = include_str!("../README.md")]
//!
//! **Simplified.** Only carved snow has overhangs. The relief of snow is noise, with no model of wind.
//!
//! **Out of scope.** The materials of the solids, and light (`snowblue-render`).

mod relief;

pub mod height_field;
pub mod height_files;

pub mod drift;

pub mod imprint;
mod quadtree;
mod sheet;
pub mod terrain;

pub mod refinement;
pub mod snow_on_mesh;

pub mod carved;
pub mod igloo;

pub mod displacement;
pub mod roughness;
