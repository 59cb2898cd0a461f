//! The Monte Carlo engine: random walks of light from grain to grain, as in the paper.
//!
//! A ray is never absorbed as a whole: it carries the weight exp(−γℓ) of its path ℓ through ice. One set of rays thus
//! serves all wavelengths and thicknesses; tracing each wavelength separately, as in the paper, remains as a check.
//! Every result has a standard error. Random streams belong to rays and batches of rays, so results are equal to the
//! last bit on any number of threads.

mod goniometric;
mod half_space;
mod rays;
mod solve;
mod spectral;
mod stack;
mod volume;
mod walk;

pub use goniometric::{Distribution, GoniometricOptions, Patch, PatchGrid, PlanePoint, distribute};
pub use half_space::{BeamPlan, MeanEnd, NarrowBeam, WalkEnds};
pub use rays::{DEFAULT_RAYS, MonteCarloOptions, RayProgress};
pub use solve::{MeanPaths, mean_paths, solve, solve_batch};
pub use stack::solve_stack;
pub use volume::{GrainPlan, PathLengths, ScatteringEvent, Volume, VolumeNode};
