//! Procedural solids as triangle meshes.

pub mod carved;
pub mod drift;
pub mod height_field;
pub mod igloo;
pub(crate) mod imprint;
mod quadtree;
mod relief;
pub(crate) mod sheet;
pub(crate) mod snow_on_mesh;
pub(crate) mod terrain;
