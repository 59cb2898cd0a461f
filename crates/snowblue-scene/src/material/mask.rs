//! Masks: a number from 0 to 1 at each point of a surface.

use snowblue_geometry::shape::Shape;

use crate::material::texture::Texture;
use crate::objects::{Objects, SurfaceInteraction};

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
        // Interpolation rounds.
        value.clamp(0.0, 1.0)
    }
}
