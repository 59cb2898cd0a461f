//! Options of the Monte Carlo engine.

use snowblue_base::{ParameterRange, RangeError};

use crate::rng::Stream;
use crate::slab::Incidence;

/// Number of rays.
const RAY_RANGE: ParameterRange = ParameterRange { quantity: "number of rays", least: 2.0, greatest: 1e12, unit: "" };

/// Rays per wavelength in the paper.
pub const DEFAULT_RAYS: u64 = 100_000;

/// Options of the Monte Carlo engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MonteCarloOptions {
    /// Rays per incidence and index node (per incidence and wavelength in snow with impurities or with more than half
    /// of its pores filled by water); with `per_wavelength`, rays per incidence, thickness and wavelength.
    pub rays: u64,
    /// Seed of all randomness.
    pub seed: u64,
    /// Whether to trace each wavelength and thickness separately, as in the paper.
    pub per_wavelength: bool,
}

/// Progress of a computation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RayProgress {
    /// Rays traced so far.
    pub traced: u64,
    /// Rays to trace in all.
    pub total: u64,
}

impl Default for MonteCarloOptions {
    fn default() -> Self {
        Self { rays: DEFAULT_RAYS, seed: 1, per_wavelength: false }
    }
}

pub(super) fn check_rays(rays: u64) -> Result<(), RangeError> {
    RAY_RANGE.check(rays as f64)
}

/// Cosine from the normal of an incident ray; for Lambertian light μ² is uniform.
pub(super) fn cos_incidence(incidence: Incidence, stream: &mut Stream) -> f64 {
    match incidence {
        Incidence::Beam { angle_deg } => angle_deg.to_radians().cos(),
        Incidence::Diffuse => stream.uniform().sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_ray_has_no_error_and_too_many_are_refused() {
        assert!(check_rays(2).is_ok() && check_rays(1_000_000_000_000).is_ok());
        let message = check_rays(1).unwrap_err().to_string();
        assert_eq!(message, "number of rays is 1, but must lie in 2–1000000000000");
        assert!(check_rays(1_000_000_000_001).is_err());
    }
}
