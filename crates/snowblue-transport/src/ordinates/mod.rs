//! The discrete-ordinates engine: radiative transfer on a few directions.
//!
//! Chandrasekhar's (1960) method with double-Gauss quadrature and δ-M scaling, averaged over azimuth because only
//! fluxes are computed. A homogeneous medium is solved once ([`HomogeneousMedium`]); each thickness then costs two
//! small Cholesky factorisations and each angle a sum over the modes. Layers of several media on a ground are combined
//! by the adding method ([`LayeredMedium`]), with slabs of clear ice between them. Radiances have all azimuthal modes,
//! of layers ([`bidirectional()`]) and of the half-space without absorption ([`HalfSpace`]).

mod adding;
mod bidirectional;
mod differentiated;
mod eigen;
mod escape;
mod half_space;
mod homogeneous;
mod ice_slab;
mod integrals;
mod layered;
mod options;
mod sensitivity;
mod solve;
mod solve_each;
mod solve_stack;
mod stack_media;

pub use bidirectional::{BidirectionalLight, Views, bidirectional, distribute};
pub use half_space::HalfSpace;
pub use homogeneous::{Direction, HomogeneousMedium, MediumFluxes, ModalLight};
pub use layered::{FaceFluxes, LayeredMedium, MediumLayer};
pub use options::{MAX_STREAMS, OrdinatesOptions, Peak, StreamGroup, Streams};
pub use solve::{DifferentiatedFluxes, differentiate_batch, solve, solve_batch, solve_without_errors};
pub use solve_each::{FluxSpectra, solve_each};
pub use solve_stack::{
    DifferentiatedStack, differentiate_stack, differentiate_stacks, solve_stack, solve_stack_without_errors,
};
