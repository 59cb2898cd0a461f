//! Materials: the light that leaves a surface towards the eye straight from the lights, and the share of light from
//! elsewhere that it returns.

pub mod diffuse;
pub mod pca_snow;
pub mod snow_curves;
pub mod texture;

use std::f32::consts::FRAC_1_PI;

use crate::geometry::shape::Shape;
use crate::sampling::Sampler;
use crate::scene::light::{Light, LightSample, SurfacePoint};
use crate::scene::material::texture::Texture;
use crate::scene::objects::Side;
use crate::scene::objects::SurfaceInteraction;
use crate::scene::queries::SceneQueries;
use crate::spectrum::Spectrum;

use diffuse::Diffuse;
use pca_snow::{PcaSnowMaterial, SnowHit};

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
pub(crate) struct Shading<'hit> {
    /// Radiance towards the eye due to the lights, in W m⁻² sr⁻¹ as a band density.
    pub(crate) radiance: Spectrum,
    /// What becomes of light that arrives.
    finish: Finish<'hit>,
}

/// How a surface reflects at one of its points.
#[derive(Debug, Clone, Copy)]
enum Finish<'hit> {
    /// The same share from every direction.
    Diffuse(Spectrum),
    /// As snow of a depth in cm.
    Snow(SnowHit<'hit>, f32),
}

impl Material {
    /// Whether a shape has what the material needs, or what is missing.
    pub(crate) fn check(&self, shape: &Shape) -> Result<(), String> {
        match self {
            Self::Diffuse(Diffuse::Even(_)) => Ok(()),
            Self::Diffuse(Diffuse::Painted(_)) => Texture::check(shape),
            Self::PcaSnow(snow) => snow.curves.check(shape),
        }
    }

    /// The light that comes from the lights on one path: reflected, or through the snow. What of it the next ray of the
    /// path can meet counts in part only ([`Light::met`] is the rest).
    pub(crate) fn lit<'hit>(
        &'hit self,
        probe: &mut SceneQueries,
        surface: &'hit SurfaceInteraction,
        lights: &[Light],
        sampler: &mut Sampler,
    ) -> Shading<'hit> {
        let mut shading = match self {
            Self::Diffuse(diffuse) => {
                let reflectance = diffuse.reflectance(probe.objects(), surface);
                Shading { radiance: Spectrum::ZERO, finish: Finish::Diffuse(reflectance) }
            }
            Self::PcaSnow(snow) => {
                let hit = snow.hit(probe.objects(), surface);
                let through = hit.lit_through(probe, lights, sampler);
                Shading { radiance: through.radiance, finish: Finish::Snow(hit, through.depth_cm) }
            }
        };
        let place = SurfacePoint { point: surface.point, normal: surface.normal };
        for light in lights {
            if let Some(beam) = light.single().or_else(|| light.reflected_beam(&place, sampler)) {
                shading.add_reflected(probe, surface, &beam);
            }
        }
        shading
    }
}

impl Shading<'_> {
    /// L = R E / π.
    fn add_reflected(&mut self, probe: &mut SceneQueries, surface: &SurfaceInteraction, beam: &LightSample) {
        let place = SurfacePoint { point: surface.point, normal: surface.normal };
        if let Some(arrival) = beam.arrival(&place)
            && beam.reaches(probe, &place, Side::Outer(surface.object))
        {
            let factor = arrival.irradiance_per_power * FRAC_1_PI;
            let reflectance = self.reflectance(arrival.cos_incidence);
            self.radiance.add_product(factor, &reflectance, &beam.power);
        }
    }

    /// The share of light from a direction with this cosine to the normal that is reflected, all directions together.
    pub(crate) fn reflectance(&self, cos_incidence: f32) -> Spectrum {
        match &self.finish {
            Finish::Diffuse(reflectance) => *reflectance,
            Finish::Snow(hit, depth_cm) => hit.reflectance(*depth_cm, cos_incidence),
        }
    }
}
