//! Materials: the light that leaves a surface towards the eye straight from the lights, and the share of light from
//! elsewhere that it returns.

pub mod diffuse;
pub mod pca_snow;

use crate::light::PointLight;
use crate::objects::Surface;
use crate::probe::Probe;
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
    /// The light that comes from the lights on one path: reflected, or through the snow.
    pub(crate) fn lit(&self, probe: &mut Probe, surface: &Surface, lights: &[PointLight]) -> Shading {
        match self {
            Self::Diffuse(diffuse) => Shading { radiance: diffuse.lit(probe, surface, lights), depth_cm: 0.0 },
            Self::PcaSnow(snow) => snow.lit(probe, surface, lights),
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
