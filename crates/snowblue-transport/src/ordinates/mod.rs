//! The discrete-ordinates engine: exact radiative transfer on a few directions.
//!
//! Chandrasekhar's (1960) method with double-Gauss quadrature and δ-M scaling, azimuth-averaged since only fluxes are
//! asked for. A homogeneous medium is solved once ([`HomogeneousMedium`]); every thickness then costs two small
//! Cholesky factorisations and every angle a sum over the modes.

mod eigen;
mod phase;
mod quadrature;
mod slab;
mod solve;

pub use phase::Scattering;
pub use quadrature::Quadrature;
pub(crate) use quadrature::legendre_polynomials;
pub use slab::{Direction, Fluxes, HomogeneousMedium, Light};
pub use solve::{DEFAULT_STREAMS, MOST_STREAMS, OrdinatesOptions, check_streams, index_range, most_absorption, solve};
