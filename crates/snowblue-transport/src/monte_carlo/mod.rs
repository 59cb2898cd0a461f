//! The Monte Carlo engine: light walks from grain to grain, as in the paper.
//!
//! A ray is never absorbed outright: it carries the weight exp(−γℓ) of its path ℓ through ice. One trace thus serves all
//! wavelengths and thicknesses; the paper's way, each wavelength on its own, stays as the check. Every
//! answer has its standard error, and random streams belong to rays and teams of rays, so that any number of threads
//! gives the same bits.

mod goniometric;
mod options;
mod rays;
mod solve;
mod spectral;
mod stack;
mod volume;
mod walk;

pub use goniometric::{Distribution, GoniometricOptions, Patch, PatchGrid, distribute};
pub use options::{DEFAULT_RAYS, MonteCarloOptions};
pub use solve::{MeanPaths, mean_paths, solve};
pub use stack::solve_stack;
pub use volume::{GrainPlan, Lengths, Turn, Volume, VolumeNode};
