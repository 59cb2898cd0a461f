#![doc = include_str!("../README.md")]
//!
//! **Simplified.** Snow has no overhangs but those of carved snow. Its relief is noise, with no model of wind.
//!
//! **Out of scope.** What the solids are made of, and light (`snowblue-render`).

mod relief;

pub mod height_field;
pub mod height_files;

pub mod drift;

pub mod imprint;
mod quadtree;
mod sheet;
pub mod terrain;

pub mod refinement;
mod segments;
pub mod snow_on_mesh;

pub mod carved;
pub mod igloo;

pub mod displacement;
pub mod roughness;
