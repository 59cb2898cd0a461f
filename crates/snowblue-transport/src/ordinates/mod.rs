//! The discrete-ordinates engine: radiative transfer on a few directions.
//!
//! Chandrasekhar's (1960) method with double-Gauss quadrature and δ-M scaling, averaged over azimuth because only
//! fluxes are computed. A homogeneous medium is solved once ([`HomogeneousMedium`]); each thickness then costs two
//! small Cholesky factorisations and each angle a sum over the modes. Layers of several media on a ground are combined
//! by the adding method ([`LayeredMedium`]), with slabs of clear ice between them. The half-space without absorption
//! has all azimuths ([`HalfSpace`]).

mod delta_m;
mod differentiated;
mod eigen;
mod escape;
mod fluxes;
mod half_space;
mod homogeneous;
mod ice_slab;
mod integrals;
mod jackknife;
mod layered;
mod options;
mod sensitivity;
mod solve;
mod solve_alike;
mod solve_batch;
mod solve_stack;
mod stack_media;
mod streams;
mod unscattered;

pub use half_space::HalfSpace;
pub use homogeneous::{Direction, Fluxes, HomogeneousMedium, Light};
pub use layered::{FaceFluxes, LayeredMedium, MediumLayer};
pub use options::OrdinatesOptions;
pub use solve::{solve, solve_without_errors};
pub use solve_alike::{FluxSpectra, solve_alike, solve_each};
pub use solve_batch::{DifferentiatedFluxes, differentiate_batch, solve_batch};
pub use solve_stack::{DifferentiatedStack, differentiate_stack, solve_stack, solve_stack_without_errors};
pub use streams::{MOST_STREAMS, Peak, StreamGroup, Streams, check_streams};
