//! Masks: a number from 0 to 1 at each point of a surface.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::toml_table::Table;
use snowblue_base::{KeyPath, Numbers, ParameterRange, ParseError, narrow, quantities};
use snowblue_geometry::images::DecodedImage;
use snowblue_geometry::shape::Shape;

use crate::error::SceneError;
use crate::material::texture::{Texture, TextureDescription};
use crate::objects::{Objects, SurfaceInteraction};
use crate::sources::Sources;
use crate::values::only_one;

quantities! {
    /// A value of an attribute of a mesh.
    pub AttributeValue = ParameterRange::new("value of an attribute", -1e9, 1e9, "");
}

/// A number between 0 and 1 for each point of a surface: the first channel of an image, undecoded, or values at the
/// vertices of a mesh.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MaskDescription {
    /// The image.
    #[serde(flatten, skip_deserializing)]
    #[schemars(!skip_deserializing)]
    pub texture: TextureDescription,
    /// The name of an attribute in the mesh file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attribute: Option<String>,
    /// The values of the attribute that count as 0 and as 1; 0 and 1 if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<Numbers<AttributeValue, 2>>,
}

impl MaskDescription {
    pub(super) fn read(mut table: Table) -> Result<Self, ParseError> {
        let texture = table.split(&TextureDescription::KEYS).read()?;
        Ok(Self { texture, ..table.read()? })
    }

    pub(super) fn build(&self, path: &KeyPath, sources: &Sources) -> Result<Mask, SceneError> {
        let range = self.range.map_or([0.0, 1.0], Numbers::get);
        if (range[1] - range[0]).abs() <= 0.0 {
            return Err(path.key("range").error(format!("is {} twice, but must have two ends", range[0])).into());
        }
        if self.range.is_some() && self.attribute.is_none() {
            return Err(path.key("range").error("needs an `attribute`").into());
        }
        let is_given =
            [("texture", self.texture.texture.as_ref().map(drop)), ("attribute", self.attribute.as_ref().map(drop))];
        only_one(path, is_given)?;
        let texture = self.texture.build(path, sources, DecodedImage::encoded_rgb)?.map(Mask::RasterImage);
        let attribute = self.attribute.clone().map(|name| Mask::Attribute { name, range: range.map(narrow) });
        texture.or(attribute).ok_or_else(|| path.error("needs a texture or an attribute").into())
    }
}

/// A number from 0 to 1 at each point of a surface.
#[derive(Debug, Clone)]
pub enum Mask {
    /// The first channel of a texture, without decoding.
    RasterImage(Texture),
    /// A vertex attribute of a mesh.
    Attribute {
        /// Name in the mesh file.
        name: String,
        /// The values that map to 0 and to 1.
        range: [f32; 2],
    },
}

impl Mask {
    /// Checks that a shape has what the mask needs; the error says what is missing.
    pub(crate) fn check(&self, shape: &Shape) -> Result<(), String> {
        let Self::Attribute { name, range: [low, high] } = self else {
            return Texture::check(shape);
        };
        let attributes = shape.mesh().map(|mesh| &mesh.triangles().attributes);
        let Some(values) = attributes.and_then(|attributes| attributes.get(name)) else {
            let known =
                attributes.map(|attributes| attributes.keys().map(String::as_str).collect::<Vec<_>>().join(", "));
            let known = known.filter(|known| !known.is_empty()).unwrap_or_else(|| "none".into());
            return Err(format!("the mask is the attribute \"{name}\", but those of the object are: {known}"));
        };
        let within = |value: &&f32| (low.min(*high)..=low.max(*high)).contains(*value);
        match values.iter().find(|value| !within(value)) {
            Some(value) => Err(format!("attribute \"{name}\" is {value} at a vertex, but must lie in {low} to {high}")),
            None => Ok(()),
        }
    }

    /// The number at a point of a surface.
    pub(crate) fn at(&self, objects: &Objects, surface: &SurfaceInteraction) -> f32 {
        let value = match self {
            Self::RasterImage(texture) => texture.at(objects, surface)[0],
            Self::Attribute { name, range: [low, high] } => {
                (objects.attribute(name, surface).unwrap_or(*low) - low) / (high - low)
            }
        };
        // Rounding in the interpolation may leave the range.
        value.clamp(0.0, 1.0)
    }
}
