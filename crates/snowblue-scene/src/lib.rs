#![doc = include_str!("../README.md")]
//!
//! # Data flow
//!
//! ```text
//! SceneFile (TOML) ─► SceneDescription ─► Scene ─┬─ objects: shapes and meshes, their intersections and chords
//!                             files ────────┘    ├─ materials: diffuse and snow
//!                                                └─ lights, camera, film settings
//! ```
//!
//! A [`SceneDescription`] is plain data; [`SceneFile`] reads it from TOML, and [`SceneDescription::build`] makes a
//! [`Scene`] of it. What is built fits together: change the description and build it again to change the scene.
//!
//! **Simplifications.** Faces are flat for depths, shadows and the offsets of rays; vertex normals are for shading
//! only.
//!
//! **Out of scope.** Light in snow, and pictures (`snowblue-light-field`, `snowblue-render`).

pub mod air;
pub mod directions;
pub mod error;
pub(crate) mod notation;
pub mod sampling;
pub mod spectrum;

pub mod film;

pub mod camera;
pub mod integrator;
pub mod light;
pub mod material;
pub mod objects;
pub mod progress;
pub mod queries;
pub mod seen;

pub mod description;

mod scene;

mod assembling;
pub mod file;
pub mod inspection;
pub(crate) mod layering;
pub mod provenance;
pub mod undisturbed;

pub use assembling::changes::Changes;
pub use description::SceneDescription;
pub use error::SceneError;
pub use file::SceneFile;
pub use integrator::{IntegratorKind, IntegratorSettings, LightFieldSettings, PathMode, PcaSnowSettings, Views};
pub use scene::Scene;
