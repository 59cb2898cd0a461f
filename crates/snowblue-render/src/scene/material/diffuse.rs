//! A Lambertian surface: radiance L = ρ E / π, the same in every direction.

use crate::scene::material::texture::Texture;
use crate::scene::objects::{Objects, SurfaceInteraction};
use crate::spectrum::Spectrum;
use crate::spectrum::upsampling::Upsampling;

/// A surface that reflects alike in all directions, on both sides.
#[derive(Debug)]
pub enum Diffuse {
    /// The same share of the light everywhere.
    Even(Spectrum),
    /// As a picture says.
    Painted(Box<Paint>),
}

/// A picture whose colours are reflectances.
#[derive(Debug)]
pub struct Paint {
    /// Linear sRGB.
    texture: Texture,
    upsampling: Upsampling,
}

impl Diffuse {
    /// Paint of the colours of a texture in linear sRGB.
    pub(crate) fn painted(texture: Texture, upsampling: Upsampling) -> Self {
        Self::Painted(Box::new(Paint { texture, upsampling }))
    }

    /// The share of the light that is reflected at a hit.
    pub(crate) fn reflectance(&self, objects: &Objects, surface: &SurfaceInteraction) -> Spectrum {
        match self {
            Self::Even(reflectance) => *reflectance,
            Self::Painted(paint) => paint.upsampling.spectrum(paint.texture.at(objects, surface)),
        }
    }
}
