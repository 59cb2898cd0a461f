//! Carved snow: solids heaped up and hollowed out, with rounded joints and an uneven surface, as one closed mesh.

mod lattice;
mod mesh;
mod patches;
mod snow;
mod solid;

pub use mesh::CarvedError;
pub use snow::Carved;
pub use solid::Solid;
