//! The discrete-ordinates engine: exact radiative transfer on a few directions.
//!
//! Chandrasekhar's (1960) method with double-Gauss quadrature and δ-M scaling, azimuth-averaged since only fluxes are
//! asked for. A homogeneous medium is solved once ([`HomogeneousMedium`]); every thickness then costs two small
//! Cholesky factorisations and every angle a sum over the modes. Layers of several media over a ground are piled up
//! ([`LayeredMedium`]) by the adding method.

mod eigen;
mod integrals;
mod jackknife;
mod phase;
mod quadrature;
mod slab;
mod solve;
mod solve_alike;
mod solve_stack;
mod stack;
mod streams;

pub use phase::Scattering;
pub use quadrature::Quadrature;
pub(crate) use quadrature::legendre_polynomials;
pub use slab::{Direction, Fluxes, HomogeneousMedium, Light};
pub use solve::{OrdinatesOptions, solve};
pub use solve_alike::{solve_alike, solve_each};
pub use solve_stack::solve_stack;
pub use stack::{FaceFluxes, LayeredMedium};
pub use streams::{DEFAULT_STREAMS, MOST_STREAMS, Peak, Streams, check_streams};
