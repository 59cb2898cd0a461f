//! Rays and shapes: first hits, occlusion, and all crossings of a line with a solid.
//!
//! Geometry is in single precision and metres. The signs of triangle edge functions are exact, so that every line
//! crosses a closed surface an even number of times.

pub mod bounds;
pub mod ray;
pub mod texture_coordinates;
pub(crate) mod triangle;

pub(crate) mod coincident;
pub(crate) mod grouped;
pub mod vertex_normals;

pub mod triangle_mesh;

pub mod cuboid;
pub mod ellipsoid;
pub mod plane;

pub mod mesh_bvh;

pub mod instance;
pub mod transform;

pub mod shape;

pub(crate) mod body;
pub mod chord;
