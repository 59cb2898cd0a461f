//! Tools that look at triangle meshes or mend them.

pub mod inspection;
pub mod mending;
pub mod topology;
