//! Procedural solids as triangle meshes.

pub mod carved;
pub mod drift;
pub mod height_field;
pub mod igloo;
mod relief;
