//! Lambertian surfaces: radiance L = ρ E / π in all directions.

use crate::material::texture::Texture;
use crate::objects::{Objects, SurfaceInteraction};
use crate::spectrum::Spectrum;
use crate::spectrum::upsampling::Upsampling;

/// A surface with the same diffuse reflection on both sides.
#[derive(Debug)]
pub enum Diffuse {
    /// Uniform reflectance.
    Uniform(Spectrum),
    /// Reflectance from a texture.
    Textured(Box<ReflectanceTexture>),
}

/// A texture whose colours are reflectances.
#[derive(Debug)]
pub struct ReflectanceTexture {
    /// Linear sRGB.
    texture: Texture,
    upsampling: Upsampling,
}

impl Diffuse {
    /// Reflectance from a texture in linear sRGB.
    pub(crate) fn textured(texture: Texture, upsampling: Upsampling) -> Self {
        Self::Textured(Box::new(ReflectanceTexture { texture, upsampling }))
    }

    /// Reflectance at a hit.
    pub fn reflectance(&self, objects: &Objects, surface: &SurfaceInteraction) -> Spectrum {
        match self {
            Self::Uniform(reflectance) => *reflectance,
            Self::Textured(texture) => texture.upsampling.spectrum(texture.texture.at(objects, surface)),
        }
    }
}
