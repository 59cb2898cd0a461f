//! Light in snow: what a layer of ice grains reflects, transmits and absorbs, wavelength by wavelength.
//!
//! ```text
//! fresnel ─► grain, microsurface ─► scatter (one grain) ─► population ─┬─► monte_carlo: walk from grain to grain ─┐
//! ice, water, impurity ─► sample (what snow is) ─► constituents ───────┴─► tally, medium ─► ordinates: solve ─────┴─► R, T, A ± σ
//! ```
//!
//! A [`sample::SnowSample`] says what the snow is made of, a [`slab::Slab`] asks what a thickness of it does to light, and
//! two independent engines answer with the same types: [`monte_carlo::solve`] and [`ordinates::solve`].
//! [`inversion`] goes back from an albedo to the snow, [`simplification`] says what a simpler model would answer, and
//! [`measured`] snow is there to compare with.
//! A [`stack::Stack`] is layers of different snow on a ground, with fluxes at any depth: [`ordinates::solve_stack`].
//! [`sunlight`] makes broadband values of the curves.
//!
//! ```
//! use snowblue_transport::ordinates::{self, OrdinatesOptions};
//! use snowblue_transport::sample::SnowSample;
//! use snowblue_transport::slab::{Incidence, Slab};
//!
//! let slab = Slab {
//!     sample: SnowSample::default(),
//!     thicknesses_cm: vec![15.0],
//!     incidences: vec![Incidence::Beam { angle_deg: 0.0 }],
//!     wavelengths_nm: vec![450.0, 700.0],
//! };
//! let answer = ordinates::solve(&slab, &OrdinatesOptions { tally_rays: 1 << 12, ..OrdinatesOptions::default() })?;
//! // 15 cm of snow pass two hundredths of the blue light and a third of that of the red.
//! assert!(answer[0].transmittance.value > 3.0 * answer[1].transmittance.value);
//! # Ok::<(), snowblue_transport::TransportError>(())
//! ```
//!
//! **The model** fills the outline of SPLITSnow (Varsa, Baranoski & Kimmel 2021, doi:10.1016/j.rse.2020.112272) by the
//! choices that obey the conservation laws: grains are prolate spheroids in random orientation with a rough surface,
//! light is a ray, and free paths between grains are exponential, so that the answer is exactly that of radiative
//! transfer with the grains' own phase function. Outside it speaks µm, cm, kg/m³, degrees and nm; inside SI and radians.
//!
//! **Simplified.** No diffraction, no polarisation; a grain is a point in the slab; no step of the refractive index at
//! the slab's faces; homogeneous layers. Grains lie in water as a whole or not at all.
//!
//! **Out of scope.** Where radiance goes (only fluxes are computed), and colour.

mod error;
pub mod range;

pub mod quadrature;
pub mod rng;

pub mod optics;

pub mod grain;

pub mod sample;

pub mod slab;
pub mod stack;

pub mod medium;

pub mod monte_carlo;
pub mod ordinates;

pub mod inversion;
pub mod measured;
pub mod simplification;
pub mod sunlight;

pub use error::TransportError;
pub use medium::{Demand, GrainOptics, GrainTallies, Medium, Microstructure, Population, Scattering, TallyPlan};
pub use optics::{Ice, IceTable, Impurities, Substance};
pub use sample::{GrainSize, SizeMeasure, SnowSample, SnowType, TruncatedNormal};
pub use slab::{Estimate, Incidence, Radiometry, Slab};
pub use stack::{DepthFluxes, Layer, Stack, StackRadiometry};
