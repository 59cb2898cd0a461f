//! Materials: the light that leaves a surface towards the eye straight from the lights, and the share of light from
//! elsewhere that it returns.

pub mod diffuse;
pub mod pca_snow;

use std::f32::consts::FRAC_1_PI;

use crate::light::{Beam, Light, Place};
use crate::objects::Surface;
use crate::probe::{Probe, Side};
use crate::sampling::Sampler;
use crate::spectrum::Spectrum;

use diffuse::Diffuse;
use pca_snow::PcaSnowMaterial;

/// What a surface is made of.
#[derive(Debug)]
pub enum Material {
    /// Reflects alike in all directions.
    Diffuse(Diffuse),
    /// Snow: reflects alike in all directions and lets light through.
    PcaSnow(Box<PcaSnowMaterial>),
}

/// A surface point under the scene's lights.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shading {
    /// Radiance towards the eye due to the lights, in W m⁻² sr⁻¹ as a band density.
    pub(crate) radiance: Spectrum,
    /// Depth of snow behind the point, in cm, on which its reflectance rests; 0 for other materials.
    pub(crate) depth_cm: f32,
}

impl Material {
    /// The light that comes from the lights on one path: reflected, or through the snow. What of it the next ray of the
    /// path can meet counts in part only ([`Light::met`] is the rest).
    pub(crate) fn lit(&self, probe: &mut Probe, surface: &Surface, lights: &[Light], sampler: &mut Sampler) -> Shading {
        let mut shading = match self {
            Self::Diffuse(_) => Shading { radiance: Spectrum::ZERO, depth_cm: 0.0 },
            Self::PcaSnow(snow) => snow.lit_through(probe, surface, lights, sampler),
        };
        let place = Place { point: surface.point, normal: surface.normal };
        for light in lights {
            if let Some(beam) = light.single().or_else(|| light.reflected_beam(&place, sampler)) {
                self.add_reflected(&mut shading, probe, surface, &beam);
            }
        }
        shading
    }

    /// L = R E / π.
    fn add_reflected(&self, shading: &mut Shading, probe: &mut Probe, surface: &Surface, beam: &Beam) {
        let place = Place { point: surface.point, normal: surface.normal };
        if let Some(arrival) = beam.arrival(&place)
            && beam.reaches(probe, &place, Side::Outer(surface.object))
        {
            let factor = arrival.irradiance_per_power * FRAC_1_PI;
            let reflectance = self.reflectance(shading, arrival.cos_incidence);
            shading.radiance.add_product(factor, &reflectance, &beam.power);
        }
    }

    /// The share of light from a direction with this cosine to the normal that is reflected, all directions together.
    pub(crate) fn reflectance(&self, shading: &Shading, cos_incidence: f32) -> Spectrum {
        match self {
            Self::Diffuse(diffuse) => Spectrum::constant(diffuse.reflectance),
            Self::PcaSnow(snow) => snow.reflectance(shading.depth_cm, cos_incidence),
        }
    }
}
