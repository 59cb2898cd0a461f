//! Aerial perspective: the air between the camera and what it sees.
//!
//! L = L₀ e^{−βd} + L_h (1 − e^{−βd}) (Koschmieder 1924), with the radiance L₀ of a surface at the distance d, the
//! extinction coefficient β of the air near the ground ([`air_extinction_per_m`]), and the radiance L_h of the sky at
//! the horizon below or above the surface.
//!
//! Simplification: the air is everywhere as dense as at the ground, and everywhere lit.

use std::sync::Arc;

use glam::Vec3A;
use snowblue_base::narrow;
use snowblue_geometry::ray::Ray;
use snowblue_sky::air_extinction_per_m;

use crate::light::dome::ClearRadiance;
use crate::spectrum::{Spectrum, wavelengths_nm};

/// The air below a clear sky.
#[derive(Debug)]
pub struct Air {
    extinction_per_m: Spectrum,
    sky: Arc<ClearRadiance>,
}

/// The effect of the air on light on its way to the camera.
#[derive(Debug, Clone, Copy)]
pub struct AirBetween {
    /// The fraction of light that passes.
    pub transmittance: Spectrum,
    /// The radiance that the air adds, as a band density.
    pub added: Spectrum,
}

impl Air {
    pub(crate) fn new(sky: Arc<ClearRadiance>) -> Self {
        let turbidity = sky.sky.turbidity();
        let extinction_per_m = Spectrum(wavelengths_nm().map(|nm| narrow(air_extinction_per_m(turbidity, nm))));
        Self { extinction_per_m, sky }
    }

    /// The air along a camera ray to a surface at a distance in m.
    pub fn between(&self, ray: &Ray, distance_m: f32) -> AirBetween {
        let transmittance = Spectrum(self.extinction_per_m.0.map(|per_m| (-per_m * distance_m).exp()));
        let level = Vec3A::new(ray.direction.x, ray.direction.y, 0.0).normalize_or(Vec3A::Y);
        let scattered = Spectrum(transmittance.0.map(|passes| 1.0 - passes));
        AirBetween { transmittance, added: self.sky.at(level) * scattered }
    }
}
