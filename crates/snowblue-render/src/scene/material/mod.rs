//! Materials: what objects are made of.

pub mod diffuse;
pub mod layered_snow;
pub mod pca_snow;
pub mod snow_curves;
pub mod texture;

use crate::geometry::shape::Shape;

use diffuse::Diffuse;
use layered_snow::LayeredSnow;
use pca_snow::PcaSnowMaterial;
use texture::Texture;

/// The material of an object.
#[derive(Debug)]
pub enum Material {
    /// A Lambertian surface.
    Diffuse(Diffuse),
    /// Snow that transmits light along straight lines.
    PcaSnow(Box<PcaSnowMaterial>),
    /// Snow of layers, with the light field inside.
    LayeredSnow(LayeredSnow),
}

impl Material {
    /// Whether it is snow.
    pub(crate) fn is_snow(&self) -> bool {
        matches!(self, Self::PcaSnow(_) | Self::LayeredSnow(_))
    }

    /// Checks that a shape has what the material needs; the error says what is missing.
    pub(crate) fn check(&self, shape: &Shape) -> Result<(), String> {
        match self {
            Self::Diffuse(Diffuse::Uniform(_)) | Self::LayeredSnow(_) => Ok(()),
            Self::Diffuse(Diffuse::Textured(_)) => Texture::check(shape),
            Self::PcaSnow(snow) => snow.curves.check(shape),
        }
    }
}
