//! A Lambertian surface: radiance L = ρ E / π, the same in every direction.

use std::f32::consts::FRAC_1_PI;

use crate::light::PointLight;
use crate::objects::Surface;
use crate::probe::Probe;
use crate::spectrum::Spectrum;

/// A surface that reflects alike in all directions, on both sides.
#[derive(Debug, Clone, Copy)]
pub struct Diffuse {
    /// Share of the light that is reflected, at every wavelength.
    pub reflectance: f32,
}

impl Diffuse {
    /// Radiance due to the lights, in W m⁻² sr⁻¹ as a band density.
    pub(crate) fn lit(&self, probe: &mut Probe, surface: &Surface, lights: &[PointLight]) -> Spectrum {
        let mut radiance = Spectrum::ZERO;
        let reflectance = Spectrum::constant(self.reflectance);
        for light in lights {
            if let Some(arrival) = light.arrival(surface.point, surface.normal)
                && probe.sees(surface.point, surface.normal, light.position)
            {
                let factor = arrival.irradiance_per_intensity * FRAC_1_PI;
                radiance.add_product(factor, &reflectance, &light.intensity);
            }
        }
        radiance
    }
}
