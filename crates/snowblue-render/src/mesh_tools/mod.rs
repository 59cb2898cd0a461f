//! Mesh checks and repair.

pub mod inspection;
pub mod repair;
pub mod topology;
