//! Materials: what objects are made of.

pub mod deep_snow;
pub mod diffuse;
pub mod mask;
pub mod snow;
pub mod surface_optics;
pub mod texture;

use snowblue_geometry::shape::Shape;

use crate::description::{ReliefDescription, SparkleDescription};
use crate::objects::{Objects, SurfaceInteraction};
use crate::spectrum::Spectrum;
use deep_snow::DeepSnow;
use diffuse::Diffuse;
use snow::{Snow, SnowMaterial};
use texture::Texture;

/// The material of an object.
#[derive(Debug)]
pub enum Material {
    /// A Lambertian surface.
    Diffuse(Diffuse),
    /// Deep snow as a surface, of a plane.
    Ground(Box<DeepSnow>),
    /// Snow.
    Snow(Box<SnowMaterial>),
}

impl Material {
    /// The snow, if it is one.
    pub fn snow(&self) -> Option<&Snow> {
        match self {
            Self::Diffuse(_) | Self::Ground(_) => None,
            Self::Snow(material) => Some(&material.snow),
        }
    }

    /// The sparkle, if it is snow with it.
    pub fn sparkle(&self) -> Option<&SparkleDescription> {
        match self {
            Self::Diffuse(_) | Self::Ground(_) => None,
            Self::Snow(material) => material.sparkle.as_ref(),
        }
    }

    /// The relief, if it is snow with it.
    pub(crate) fn relief(&self) -> Option<&ReliefDescription> {
        match self {
            Self::Diffuse(_) | Self::Ground(_) => None,
            Self::Snow(material) => material.relief.as_ref(),
        }
    }

    /// The share of even light that it reflects at a hit; none of snow with an inside.
    pub fn albedo(&self, objects: &Objects, surface: &SurfaceInteraction) -> Option<Spectrum> {
        match self {
            Self::Diffuse(diffuse) => Some(diffuse.reflectance(objects, surface)),
            Self::Ground(ground) => Some(*ground.albedo()),
            Self::Snow(_) => None,
        }
    }

    /// Whether what one sees of it is snow.
    pub fn looks_like_snow(&self) -> bool {
        matches!(self, Self::Snow(_) | Self::Ground(_))
    }

    /// Whether it is snow with an inside.
    pub fn is_snow(&self) -> bool {
        self.snow().is_some()
    }

    /// Checks that a shape has what the material needs; the error says what is missing.
    pub(crate) fn check(&self, shape: &Shape) -> Result<(), String> {
        match self {
            Self::Diffuse(Diffuse::Uniform(_)) | Self::Ground(_) => Ok(()),
            Self::Diffuse(Diffuse::Textured(_)) => Texture::check(shape),
            Self::Snow(material) => {
                let is_masked = matches!(material.snow, Snow::Masked { .. });
                if is_masked && material.relief.is_some() && shape.mesh().is_none() {
                    return Err("a mask together with a relief needs a mesh".to_owned());
                }
                material.snow.check(shape)
            }
        }
    }
}
