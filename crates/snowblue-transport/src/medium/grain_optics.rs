//! Grains described by three measured numbers instead of a shape, as from micro-tomography.

use super::scattering::{HenyeyGreenstein, Medium};
use crate::optics::ice;
use crate::quadrature::MOST_NODES;

/// Degree of the moments, which serves any number of ordinates.
const MOST_MOMENTS: usize = 2 * MOST_NODES;

/// Optical properties of grains besides density and specific surface area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrainOptics {
    /// Extinction coefficient over that of convex grains, ρ SSA/4.
    pub extinction_ratio: f64,
    /// B: mean ice path per scattering event over the mean chord 4V/S of convex grains.
    pub path_enhancement: f64,
    /// Asymmetry parameter of refraction and reflection, without diffraction.
    pub asymmetry: f64,
}

/// Density and specific surface area of snow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Microstructure {
    /// Density, in kg/m³.
    pub density_kg_m3: f64,
    /// Specific surface area, in m²/kg.
    pub surface_area_m2_kg: f64,
}

impl Microstructure {
    /// Extinction coefficient of convex grains in random orientation, κ = ρ SSA/4, in 1/m.
    #[must_use]
    pub fn convex_extinction_per_m(&self) -> f64 {
        0.25 * self.density_kg_m3 * self.surface_area_m2_kg
    }
}

impl GrainOptics {
    /// The medium of snow with these grains at a wavelength where ice has the absorption coefficient γ =
    /// `absorption_per_m`: the absorption coefficient of snow is γ B φ, and the phase function is Henyey–Greenstein.
    #[must_use]
    pub fn medium(&self, snow: &Microstructure, absorption_per_m: f64) -> Medium {
        let extinction_per_m = self.extinction_ratio * snow.convex_extinction_per_m();
        let ice_fraction = snow.density_kg_m3 / ice::density_kg_m3(0.0);
        let one_minus_albedo = absorption_per_m * self.path_enhancement * ice_fraction / extinction_per_m;
        Medium {
            extinction_per_m,
            scattering: HenyeyGreenstein { one_minus_albedo, asymmetry: self.asymmetry }.scattering(MOST_MOMENTS),
        }
    }
}
