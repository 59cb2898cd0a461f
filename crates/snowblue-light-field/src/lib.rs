#![doc = include_str!("../README.md")]
//!
//! # The light field
//!
//! The light that enters at the surface, of lamps (`surface_light`) and by other surfaces (`gather`), determines
//! the fluence rate inside ([`snowblue_field`]), and that the net flux J through the surface at each wavelength. Snow
//! then sends out
//!
//! L(μ) = Σ R₀(μ, μ₀, Δϕ) F + K(μ) J/π.

pub mod bake;
mod body_field;
mod bright_snow;
mod exchange;
mod field;
mod field_scene;
mod gather;
mod illumination;
mod of_scene;
mod prepared_body;
mod sight;
mod snowpack;
mod surface_light;

pub use body_field::{BodyField, LightWeights, NearLight, SnowAt};
pub use bright_snow::SnowSeen;
pub use field::{FieldStatistics, LightField};
pub use field_scene::FieldScene;
pub use illumination::LampInSnow;
pub use of_scene::{SnowOfMaterials, snowpacks};
pub use snowpack::{EndDepth, KindOptics, Snowpack, WalkEndsByDepth};
