//! Rays and the shapes they meet: first hits, occlusion, and all crossings of a line with a solid.
//!
//! Geometry is single precision, in metres. Where a sign decides what is inside (the edges of triangles) arithmetic is
//! exact, so that a line crosses a closed surface an even number of times.

pub mod bounds;
pub mod ray;
pub mod texture_coordinates;
pub(crate) mod triangle;
pub mod triangle_mesh;

pub mod cuboid;
pub mod ellipsoid;
pub mod plane;

pub mod mesh;

pub mod instance;
pub mod placement;

pub mod shape;

pub(crate) mod body;
pub mod chord;
