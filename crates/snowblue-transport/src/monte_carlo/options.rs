//! Options of the Monte Carlo engine.

use crate::TransportError;
use crate::rng::Stream;
use crate::slab::Incidence;

/// Rays per wavelength that the paper uses.
pub const DEFAULT_RAYS: u64 = 100_000;

/// How the engine works.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MonteCarloOptions {
    /// Rays per direction and index node (per direction and wavelength among impurities and in snow more than half full of
    /// water); or, one wavelength at a time, per direction, thickness and wavelength.
    pub rays: u64,
    /// Seed of all randomness.
    pub seed: u64,
    /// Whether to trace each wavelength and thickness on its own, as the paper did.
    pub per_wavelength: bool,
}

impl Default for MonteCarloOptions {
    fn default() -> Self {
        Self { rays: DEFAULT_RAYS, seed: 1, per_wavelength: false }
    }
}

pub(super) fn check_rays(rays: u64) -> Result<(), TransportError> {
    TransportError::check("number of rays", rays as f64, (2.0, 1e12), "")
}

/// Cosine from the normal with which a ray enters; Lambertian light has μ² uniform.
pub(super) fn cos_incidence(incidence: Incidence, stream: &mut Stream) -> f64 {
    match incidence {
        Incidence::Beam { angle_deg } => angle_deg.to_radians().cos(),
        Incidence::Diffuse => stream.uniform().sqrt(),
    }
}
