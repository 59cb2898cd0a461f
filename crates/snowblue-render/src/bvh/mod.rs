//! Bounding volume hierarchies.

pub(crate) mod bvh8;
