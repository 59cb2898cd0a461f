#![doc = include_str!("../README.md")]
//!
//! **Simplified.** Faces are flat for hits, crossings and the offsets of rays; vertex normals are for shading only.
//!
//! **Out of scope.** Scenes with their materials, lights and cameras (`snowblue-render`), and meshes made by rules
//! (`snowblue-shapes`).

pub mod bounds;
pub mod ray;
pub mod texture_coordinates;
mod triangle;

pub mod coincident;

pub mod edges;

pub mod vertex_normals;

pub mod triangle_mesh;

pub mod cuboid;
pub mod ellipsoid;
pub mod plane;

pub mod bvh;
pub mod mesh_bvh;

pub mod instance;
pub mod transform;

pub mod shape;

pub mod body;

pub mod topology;

pub mod repair;

pub mod images;
pub mod mesh_files;
