//! Bounding volume hierarchies.

pub(crate) mod bvh8;
pub(crate) mod pencil;
