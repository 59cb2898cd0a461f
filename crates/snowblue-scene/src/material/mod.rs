//! Materials: what objects are made of.

pub mod deep_snow;
pub mod diffuse;
pub mod glass;
pub mod mask;
pub(crate) mod relief;
pub mod snow;
pub mod snow_keys;
pub mod sparkle;
pub mod surface_optics;
pub mod texture;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use snowblue_base::toml_table::Table;
use snowblue_base::{KeyPath, Number, ParseError, narrow};
use snowblue_geometry::shape::Shape;

use crate::error::SceneError;
use crate::objects::{Objects, SurfaceInteraction};
use crate::sources::Sources;
use crate::spectrum::Spectrum;
use deep_snow::DeepSnow;
use diffuse::Diffuse;
use glass::Glass;
use snow::{Snow, SnowMaterial};
use texture::Texture;

pub use crate::layering::LayersTop;
pub use diffuse::DiffuseDescription;
pub use glass::GlassDescription;
pub use mask::MaskDescription;
pub use relief::ReliefDescription;
pub use snow_keys::{LayeredSnowDescription, MaskedSnowDescription, SnowDescription, SnowMaterialDescription};
pub use sparkle::SparkleDescription;
pub use texture::TextureDescription;

/// A material.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
#[expect(clippy::large_enum_variant, reason = "there is one for each material")]
pub enum MaterialDescription {
    /// A Lambertian surface.
    Diffuse(DiffuseDescription),
    /// A thin pane.
    Glass(GlassDescription),
    /// Snow.
    Snow(SnowMaterialDescription),
}

impl MaterialDescription {
    /// Reads a material.
    pub(crate) fn read(mut table: Table) -> Result<Self, ParseError> {
        type Read = fn(Table) -> Result<MaterialDescription, ParseError>;
        let kinds: [(&str, Read); 3] = [
            ("diffuse", |table| DiffuseDescription::read(table).map(Self::Diffuse)),
            ("glass", |table| table.read().map(Self::Glass)),
            ("snow", |table| SnowMaterialDescription::read(table).map(Self::Snow)),
        ];
        let read = table.take_name("type", &kinds)?;
        read(table)
    }

    /// Whether the material has relief.
    pub(crate) fn has_relief(&self) -> bool {
        matches!(self, Self::Snow(SnowMaterialDescription { relief: Some(_), .. }))
    }
}

/// A material with its name.
pub(crate) struct NamedMaterial {
    pub(crate) name: String,
    pub(crate) material: Material,
}

/// Builds all materials, in alphabetical order.
pub(crate) fn build_materials(
    descriptions: &BTreeMap<String, MaterialDescription>,
    sources: &Sources,
) -> Result<Vec<NamedMaterial>, SceneError> {
    let built = descriptions.iter().map(|(name, description)| {
        let path = KeyPath::root("material").key(name);
        let material = match description {
            MaterialDescription::Diffuse(diffuse) => {
                let opacity = narrow(diffuse.opacity.map_or(1.0, Number::get));
                Material::Diffuse(diffuse.build(&path, sources)?, opacity)
            }
            MaterialDescription::Glass(glass) => Material::Glass(glass.build()),
            MaterialDescription::Snow(snow) => Material::Snow(Box::new(snow.build(&path, sources)?)),
        };
        Ok(NamedMaterial { name: name.clone(), material })
    });
    built.collect()
}

/// The material of an object.
#[derive(Debug)]
pub enum Material {
    /// A Lambertian surface, with its opacity.
    Diffuse(Diffuse, f32),
    /// A thin pane.
    Glass(Glass),
    /// Deep snow as the surface of a plane.
    Ground(Box<DeepSnow>),
    /// Snow.
    Snow(Box<SnowMaterial>),
}

impl Material {
    /// The snow, if the material is snow with an inside.
    pub fn snow(&self) -> Option<&Snow> {
        match self {
            Self::Diffuse(..) | Self::Glass(_) | Self::Ground(_) => None,
            Self::Snow(material) => Some(&material.snow),
        }
    }

    /// The sparkle, if the material is snow with sparkle.
    pub fn sparkle(&self) -> Option<&SparkleDescription> {
        match self {
            Self::Diffuse(..) | Self::Glass(_) | Self::Ground(_) => None,
            Self::Snow(material) => material.sparkle.as_ref(),
        }
    }

    /// The relief, if the material is snow with relief.
    pub(crate) fn relief(&self) -> Option<&ReliefDescription> {
        match self {
            Self::Diffuse(..) | Self::Glass(_) | Self::Ground(_) => None,
            Self::Snow(material) => material.relief.as_ref(),
        }
    }

    /// Whether light passes a surface of the material straight on.
    #[inline]
    pub(crate) fn is_transparent(&self) -> bool {
        match self {
            Self::Diffuse(diffuse, opacity) => *opacity < 1.0 || diffuse.has_alpha(),
            Self::Glass(_) => true,
            Self::Ground(_) | Self::Snow(_) => false,
        }
    }

    /// Whether the material mirrors the light that does not pass it.
    pub(crate) fn is_mirror(&self) -> bool {
        matches!(self, Self::Glass(_))
    }

    /// The share of light that passes the surface straight on at a hit.
    pub(crate) fn transmittance(&self, objects: &Objects, surface: &SurfaceInteraction) -> f32 {
        match self {
            Self::Diffuse(diffuse, opacity) => 1.0 - opacity * diffuse.alpha(objects, surface),
            Self::Glass(glass) => glass.transmittance(-surface.normal.dot(surface.direction)),
            Self::Ground(_) | Self::Snow(_) => 0.0,
        }
    }

    /// The fraction of even light that the material reflects diffusely at a hit, where it is opaque; none for snow with
    /// an inside.
    pub fn albedo(&self, objects: &Objects, surface: &SurfaceInteraction) -> Option<Spectrum> {
        match self {
            Self::Diffuse(diffuse, _) => Some(diffuse.reflectance(objects, surface)),
            Self::Glass(_) => Some(Spectrum::ZERO),
            Self::Ground(ground) => Some(*ground.albedo()),
            Self::Snow(_) => None,
        }
    }

    /// Whether the visible surface of the material is snow.
    pub fn looks_like_snow(&self) -> bool {
        matches!(self, Self::Snow(_) | Self::Ground(_))
    }

    /// Whether the material is snow with an inside.
    pub fn is_snow(&self) -> bool {
        self.snow().is_some()
    }

    /// Checks that a shape has what the material needs; the error says what is missing.
    pub(crate) fn check(&self, shape: &Shape) -> Result<(), String> {
        match self {
            Self::Diffuse(Diffuse::Uniform(_), _) | Self::Glass(_) | Self::Ground(_) => Ok(()),
            Self::Diffuse(Diffuse::Textured(_), _) => Texture::check(shape),
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
