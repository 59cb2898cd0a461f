#![doc = include_str!("../README.md")]
//!
//! # The light field
//!
//! The fluence rate inside each body of snow obeys a diffusion equation ([`snowblue_field`]). Its boundary condition is
//! the light that enters at the surface, directed (F) and diffuse (H). The fluence rate determines the net flux J
//! through the surface at each wavelength. The radiance that leaves the snow is then
//!
//! L(μ) = Σ R₀(μ, μ₀, Δϕ) F + (H + K(μ) J)/π.
//!
//! The files, in the order in which a light field is made:
//!
//! 1. Bodies. `body_optics`: the kinds of snow of a body, and their optics. `sight`: the cell sizes that the pictures
//!    of a camera need. `bodies`: each body with its cells and its linear system of equations.
//! 2. Light that enters. `lit_scene`: the lights of a scene, grouped by their spectra. `direct_light`: the light of
//!    lamps and skies at the surface of a body. `gather`: paths from the surface of a body to snow, other surfaces and
//!    uniform skies.
//! 3. `exchange`: the iteration for the light that bodies and other surfaces send to each other.
//! 4. The solution. `body_solution`: the light at a place of a body. `bright_snow`: the light that snow sends to other
//!    surfaces. `field`: all steps, and the light in all bodies ([`LightField`]).
//! 5. [`bake`]: the light on meshes of the snow.

pub mod bake;
mod bodies;
mod body_optics;
mod body_solution;
mod bright_snow;
mod direct_light;
mod exchange;
mod field;
mod gather;
mod lit_scene;
mod sight;

pub use body_optics::{BodyOptics, EndDepth, KindOptics, SnowOfMaterials, WalkEndsByDepth};
pub use body_solution::{BodySolution, LightFromInside, LightWeights, NearLight, SnowAt};
pub use bright_snow::SnowSeen;
pub use field::{FieldStatistics, LightField};
