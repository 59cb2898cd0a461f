//! Values of several descriptions, and lists of fixed length.

use glam::Vec3A;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use snowblue_color::{LinearRgb, Srgb8};
use snowblue_geometry::ray::narrow;

use crate::notation::Notations;

/// A stretch: one factor, or one for each axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Scale {
    /// The same along all axes.
    Uniform(f64),
    /// Along x, y and z, before the rotation.
    Axes([f64; 3]),
}

/// Radii of the two ends of something: one for both, or one for each.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Radii {
    /// The same at both ends, in m.
    Same(f64),
    /// At the first and at the second end, in m.
    Ends([f64; 2]),
}

impl Radii {
    /// The radii at the first and at the second end, in m.
    pub fn ends(&self) -> [f64; 2] {
        match *self {
            Self::Same(radius) => [radius; 2],
            Self::Ends(radii) => radii,
        }
    }
}

/// The axis of a mesh file that points upwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum UpAxis {
    /// y, as in glTF.
    Y,
    /// z, as in a scene.
    Z,
}

/// A colour: three numbers are linear sRGB, `#rrggbb` is encoded sRGB.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColorDescription {
    /// Linear sRGB, 0–1.
    Linear([f64; 3]),
    /// Encoded sRGB.
    Encoded(Srgb8),
}

impl ColorDescription {
    /// The colour in linear sRGB.
    pub(crate) fn linear(&self) -> [f32; 3] {
        match *self {
            Self::Linear(channels) => channels.map(narrow),
            Self::Encoded(code) => {
                let LinearRgb { r, g, b } = code.decode();
                [r, g, b].map(narrow)
            }
        }
    }
}

impl Serialize for ColorDescription {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Linear(channels) => channels.serialize(serializer),
            Self::Encoded(code) => serializer.collect_str(code),
        }
    }
}

impl<'de> Deserialize<'de> for Scale {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Notations {
            expected: "a number or a list of three numbers",
            number: Some(Self::Uniform),
            text: None,
            list: Some(Self::Axes),
        })
    }
}

impl<'de> Deserialize<'de> for Radii {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Notations {
            expected: "a number or a list of two",
            number: Some(Self::Same),
            text: None,
            list: Some(Self::Ends),
        })
    }
}

impl<'de> Deserialize<'de> for ColorDescription {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Notations {
            expected: "a list of three numbers or \"#rrggbb\"",
            number: None,
            text: Some(|text| text.parse().map(Self::Encoded).map_err(|error| format!("{error}"))),
            list: Some(Self::Linear),
        })
    }
}

/// A list of exactly so many numbers.
pub(crate) fn numbers<'de, const COUNT: usize, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<[f64; COUNT], D::Error> {
    let expected = match COUNT {
        2 => "a list of two numbers",
        3 => "a list of three numbers",
        _ => "a list of four numbers",
    };
    deserializer.deserialize_any(Notations { expected, number: None, text: None, list: Some(|numbers| numbers) })
}

/// A list of exactly so many numbers, where the key is there.
pub(crate) fn some_numbers<'de, const COUNT: usize, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<[f64; COUNT]>, D::Error> {
    numbers(deserializer).map(Some)
}

/// What lights are without the key `visible`.
pub(crate) fn visible() -> bool {
    true
}

/// A point or direction in single precision.
pub(crate) fn point(coordinates: [f64; 3]) -> Vec3A {
    coordinates.map(narrow).into()
}
