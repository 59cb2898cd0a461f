//! From a scene with snow to an image: a spectral path tracer with PCASnow.
//!
//! ```text
//! scene_file ─► Scene ─► render ─► Film ─► image_file (PNG, OpenEXR)
//!                 │         ├─ path: one path of light, 31 wavelengths at once
//!                 │         └─ sums: the exact sums of a part of a picture; picture_file keeps them
//!                 ├─ objects: shapes and meshes ─ what a ray hits, and how deep a line runs through a solid
//!                 ├─ materials: diffuse, pca_snow, each even or by a texture
//!                 └─ lights, camera
//! ```
//!
//! [`Scene::load`](scene::Scene::load) reads a scene and takes the curves of its snow from a table,
//! [`render::render`] makes the picture, and [`image_file`] stores it. What a hit on snow means is told in
//! [`material::pca_snow`]. Past the door nothing fails: a scene that was read can be rendered.
//!
//! [`swatch`] draws sheets of colours with labels, and [`texture`] the grey of snow over them.
//!
//! A picture has the same bits on any number of threads. Geometry is single precision, in metres; where a sign decides
//! what is inside (the edges of triangles) arithmetic is exact, so that depths hold from every direction and through
//! every edge.
//!
//! **Simplified.** Snow takes in light at one point and gives it out at another on a straight line, with the curves of a
//! slab; light leaves it alike in all directions. Faces are flat: normals of a mesh's vertices are not used.
//!
//! **Out of scope.** Building tables (`snowblue-database`); names of files, options and progress bars (the faces).

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
