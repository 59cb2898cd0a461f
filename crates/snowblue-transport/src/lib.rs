#![doc = include_str!("../README.md")]
//!
//! # Structure
//!
//! ```text
//! optics ─► grain (one ray, one grain) ─► sample ─► slab, stack, batch (input and output of the engines)
//!                                                        │
//!           monte_carlo: random walks between grains ◄───┼───► medium: moments of scattering ─► ordinates
//!                                                        ▼
//!                              R, T, A ─► sunlight, inversion
//! ```
//!
//! A [`SnowSample`] describes the snow, a [`Slab`] or a [`Stack`] describes thicknesses, light and wavelengths, and
//! both engines return [`Radiometry`](slab::Radiometry): [`ordinates::solve`] and [`monte_carlo::solve`] for slabs,
//! [`ordinates::solve_stack`] and [`monte_carlo::solve_stack`] for stacks. A [`batch`] has many slabs,
//! each with its own snow, thickness, light and ground. A [`layer_file`] describes layers as text.
//!
//! For the diffusion of light in bodies of snow, [`PhaseFunction`] tabulates the scattering angles of a sample, and
//! [`ordinates::HalfSpace`] describes its surface: escape, extrapolation and reflection.
//!
//! # Model
//!
//! The model follows SPLITSnow (Varsa, Baranoski & Kimmel 2021, doi:10.1016/j.rse.2020.112272), with choices that obey
//! the conservation laws where its description leaves them open. Grains are prolate spheroids in random orientation
//! with a rough surface, light is geometric rays, and free paths between grains are exponential. The result is
//! radiative transfer with the phase function of the grains. The interface uses µm, cm, kg/m³, degrees and nm; the
//! computation uses SI units and radians.
//!
//! **Simplified.** No diffraction and no polarisation. Grains are points within the slab, and layers are homogeneous.
//! The refractive index does not change at the faces of snow. Clear ice has no bubbles and smooth faces. A grain lies
//! entirely in water or entirely in air.
//!
//! **Out of scope.** Radiance inside the snow (only fluxes and fluence rates are computed), and colour
//! (`snowblue-color`).

mod dual;
mod error;

pub mod parameters;

pub mod quadrature;
pub mod rng;

pub mod optics;

pub mod grain;

pub mod sample;

mod ground;
pub mod slab;
pub mod stack;

pub mod batch;
mod variable;

pub mod layer_file;

pub mod medium;

pub mod monte_carlo;
pub mod ordinates;

pub mod inversion;
pub mod spread;
pub mod sunlight;

pub mod illumination;

pub use error::TransportError;
pub use ground::{GroundAlbedo, GroundSpectrum};
pub use medium::{
    Demand, GrainTallies, HenyeyGreenstein, Medium, PhaseFunction, PhasePlan, Population, Scattering, TallyPlan,
};
pub use optics::{IceTable, Impurities, Substance};
pub use sample::{GrainSize, Property, SnowSample, TruncatedNormal};
pub use slab::{Incidence, Slab};
pub use snowblue_base::{Number, Parameter, ParameterRange, RangeError, short_number};
pub use stack::{Layer, Stack};
pub use variable::{LayerVariable, Variable};
