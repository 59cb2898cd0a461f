//! Renders scenes with snow: a spectral path tracer with PCASnow, and a volumetric reference.
//!
//! ```text
//! scene file ─► Scene ─► render ─► Film ─► PNG, OpenEXR
//! table ───────┘  │        ├─ integrators: paths of light, with PCASnow or through the volume
//!                 │        └─ film: exact sums over samples, AOVs, files that can be resumed and merged
//!                 ├─ camera, lights
//!                 ├─ objects: shapes and meshes in bodies; hits and depths along lines
//!                 └─ materials: diffuse and snow, constant or textured
//! ```
//!
//! A [`Scene`] takes the curves of its snow from a table of `snowblue-database`. [`render`](render::render) renders it,
//! and [`film::image_file`] writes the image. All checks are made when a scene is loaded; a loaded scene always
//! renders. [`swatch`] draws sheets of labelled colours.
//!
//! An image has the same bits on any number of threads. Geometry is in metres and single precision. Tests at the edges
//! of triangles are exact, so that depths are correct in every direction and through every edge.
//!
//! **Simplified.** With PCASnow, light enters snow at one point and leaves it at another on a straight line, with the
//! curves of a slab, equally in all directions. Faces are flat: vertex normals of meshes are ignored.
//!
//! **Out of scope.** Building tables (`snowblue-database`); the command line (`snowblue-cli`).

pub mod error;
pub mod files;
pub(crate) mod hash;
pub mod sampling;
pub mod spectrum;

pub mod geometry;

pub(crate) mod bvh;

pub mod images;

pub mod mesh_files;

pub mod shapes;

pub mod mesh_tools;

pub mod film;

pub mod scene;

mod integrators;

pub mod render;

pub mod swatch;

pub use error::RenderError;
pub use film::Film;
pub use film::accumulator::FilmAccumulator;
pub use film::aov::Aovs;
pub use film::exposure::Exposure;
pub use film::sample_block::SampleBlock;
pub use film::sensor::FalseColor;
pub use render::{Progress, Rendering, render};
pub use scene::Scene;
pub use scene::description::SceneDescription;
pub use scene::file::SceneFile;
