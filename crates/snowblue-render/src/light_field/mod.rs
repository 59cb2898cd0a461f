//! The light field inside each body of snow of a scene, for the integrators `diffusion` and `hybrid`.
//!
//! The light that enters at the surface, of lamps ([`surface_light`]) and by other surfaces ([`gather`]), determines
//! the fluence rate inside ([`snowblue_field`]), and that the net flux J through the surface at each wavelength. Snow
//! then sends out
//!
//! L(μ) = Σ R₀(μ, μ₀, Δϕ) F + K(μ) J/π.

mod body_field;
mod bright_snow;
mod end_depth;
mod field;
mod field_scene;
mod gather;
mod illumination;
mod lit_bodies;
mod near_light;
mod of_scene;
mod snowpack;
mod solid;
mod surface_light;

#[cfg(test)]
mod depth_tests;
#[cfg(test)]
mod tests;

pub(crate) use body_field::{BodyField, SnowAt};
pub(crate) use end_depth::{EndDepth, WalkEndsByDepth};
pub(crate) use field::LightField;
pub(crate) use field_scene::FieldScene;
pub(crate) use illumination::LampInSnow;
pub(crate) use near_light::{LightWeights, NearLight};
pub(crate) use of_scene::{SnowOfMaterials, snowpacks};
pub(crate) use snowpack::{KindOptics, Snowpack};
pub(crate) use surface_light::{LitPoint, visit_lights};
