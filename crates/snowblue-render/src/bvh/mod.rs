//! Bounding volume hierarchy with eight children per node.

mod build;
pub(crate) mod bvh8;

#[cfg(test)]
mod tests;
