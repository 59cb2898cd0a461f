//! Light in snow.

pub mod error;
pub mod fresnel;
pub mod grain;
pub mod ice;
pub mod microsurface;
pub mod monte_carlo;
pub mod ordinates;
mod population;
mod rays;
pub mod rng;
pub mod sample;
pub mod scatter;
pub mod slab;
mod tally;

pub use error::TransportError;
pub use population::Population;
pub use tally::{Tally, TallyPlan};
