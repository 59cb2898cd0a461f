//! Bounding volume hierarchy with eight children per node.

mod build;
pub mod bvh8;

#[cfg(test)]
mod tests;
