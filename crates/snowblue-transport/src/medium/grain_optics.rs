//! Snow by three measured numbers instead of a shape of its grains.

use super::scattering::{Medium, Scattering};
use crate::optics::ice;
use crate::quadrature::MOST_NODES;

/// Moments that serve any number of ordinates.
const MOST_MOMENTS: usize = 2 * MOST_NODES;

/// What snow of a density and a surface area further has to tell of itself: three numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrainOptics {
    /// Extinction coefficient over that of convex grains, ρ SSA/4.
    pub extinction_ratio: f64,
    /// B: mean ice path per hit over the mean chord 4V/S of convex grains.
    pub path_enhancement: f64,
    /// Asymmetry parameter of refraction and reflection, without diffraction.
    pub asymmetry: f64,
}

/// Extinction coefficient of convex grains in random orientation, κ = ρ SSA/4, in 1/m.
#[must_use]
pub fn convex_extinction_per_m(density_kg_m3: f64, surface_area_m2_kg: f64) -> f64 {
    0.25 * density_kg_m3 * surface_area_m2_kg
}

impl GrainOptics {
    /// The medium that snow with these properties is for light that ice absorbs with γ = `absorption_per_m`: a metre of snow
    /// absorbs γ B φ, and what it scatters goes by Henyey & Greenstein's law.
    #[must_use]
    pub fn medium(&self, density_kg_m3: f64, surface_area_m2_kg: f64, absorption_per_m: f64) -> Medium {
        let extinction_per_m = self.extinction_ratio * convex_extinction_per_m(density_kg_m3, surface_area_m2_kg);
        let ice_fraction = density_kg_m3 / ice::density_kg_m3(0.0);
        let one_minus_albedo = absorption_per_m * self.path_enhancement * ice_fraction / extinction_per_m;
        Medium {
            extinction_per_m,
            scattering: Scattering::henyey_greenstein(one_minus_albedo, self.asymmetry, MOST_MOMENTS),
        }
    }
}
