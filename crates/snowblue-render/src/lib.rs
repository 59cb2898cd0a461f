#![doc = include_str!("../README.md")]
//!
//! # Data flow
//!
//! ```text
//! SceneFile (TOML) ─► SceneDescription ─► Scene ─► Integrator ─► render ─► Film ─► image_file (PNG, OpenEXR)
//!                             files ────────┤          │           └─ FilmAccumulator: exact sums, which files keep
//!                                           │          └─ what its method needs of the scene, prepared once
//!                                           ├─ objects: shapes and meshes, their intersections and chords
//!                                           ├─ materials: diffuse and snow
//!                                           └─ lights, camera
//! ```
//!
//! A [`SceneDescription`] is plain data; [`SceneFile`] reads it from TOML, and [`SceneDescription::build`] makes a
//! [`Scene`] of it, which knows what snow is made of and nothing of how it is rendered. [`Integrator::prepare`]
//! computes what a method needs: curves of slabs, random walks, the light field. [`render()`] does both and makes the
//! picture. [`scene::integrator`] names the methods. An integrator that was prepared always renders.
//!
//! A picture has the same bits on any number of threads.
//!
//! **Simplifications.** In PCASnow light enters the snow at one point and leaves it at another on a straight line, with
//! the curves of a slab, and leaves equally in all directions. Faces are flat for depths, shadows and the offsets of
//! rays; vertex normals are for shading only.
//!
//! **Out of scope.** Building tables (`snowblue-database`); options and progress bars (the command).

pub mod error;
pub(crate) mod notation;
pub mod sampling;
pub mod spectrum;

pub mod raster;

pub mod film;

pub mod scene;

pub(crate) mod light_field;

pub mod integrators;

pub mod render;

pub mod inspection;

pub mod bake;

pub use error::RenderError;
pub use film::Film;
pub use film::accumulator::FilmAccumulator;
pub use film::aov::Aovs;
pub use film::exposure::Exposure;
pub use film::sample_block::SampleBlock;
pub use film::sensor::FalseColor;
pub use integrators::{Integrator, Preparation};
pub use render::{Progress, Rendering, render};
pub use scene::Scene;
pub use scene::description::SceneDescription;
pub use scene::file::SceneFile;
pub use snowblue_base::files;
