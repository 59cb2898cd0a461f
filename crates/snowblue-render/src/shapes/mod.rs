//! Procedural solids as triangle meshes.

pub mod drift;
pub mod height_field;
pub mod igloo;
mod relief;
