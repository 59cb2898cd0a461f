#![doc = include_str!("../README.md")]
//!
//! # The light field
//!
//! The light that enters at the surface, from lamps (`surface_light`) and from other surfaces (`gather`), determines
//! the fluence rate inside ([`snowblue_field`]). The fluence rate determines the net flux J through the surface at
//! each wavelength. The radiance that leaves the snow is then
//!
//! L(μ) = Σ R₀(μ, μ₀, Δϕ) F + K(μ) J/π.

pub mod bake;
mod body_optics;
mod body_solution;
mod body_system;
mod bright_snow;
mod exchange;
mod field;
mod field_scene;
mod gather;
mod illumination;
mod of_scene;
mod sight;
mod surface_light;

pub use body_optics::{BodyOptics, EndDepth, KindOptics, WalkEndsByDepth};
pub use body_solution::{BodySolution, LightWeights, NearLight, SnowAt};
pub use bright_snow::SnowSeen;
pub use field::{FieldStatistics, LightField};
pub use field_scene::FieldScene;
pub use illumination::LampInSnow;
pub use of_scene::{SnowOfMaterials, optics_of_materials};
