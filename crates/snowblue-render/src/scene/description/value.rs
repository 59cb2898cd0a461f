//! Values with more than one notation, and lists of fixed length.

use std::fmt;

use glam::Vec3A;
use serde::de::{Error, SeqAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use snowblue_color::{LinearRgb, Srgb8};

use super::material::LayersTop;
use crate::film::exposure::Exposure;
use crate::geometry::ray::narrow;
use crate::scene::integrator::IntegratorKind;
use crate::scene::material::pca_snow::PathMode;

/// A property of snow: one value, or two that a mask blends. Written as a number or a list of two.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum SnowProperty {
    /// The same everywhere.
    Uniform(f64),
    /// The values where the mask is 0 and where it is 1.
    Blend([f64; 2]),
}

impl SnowProperty {
    /// The value where the mask has a value.
    pub fn at(&self, mask: f64) -> f64 {
        let [first, second] = self.ends();
        first + mask * (second - first)
    }

    /// The values where the mask is 0 and where it is 1.
    pub fn ends(&self) -> [f64; 2] {
        match *self {
            Self::Uniform(value) => [value; 2],
            Self::Blend(ends) => ends,
        }
    }
}

impl From<f64> for SnowProperty {
    fn from(value: f64) -> Self {
        Self::Uniform(value)
    }
}

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

impl Serialize for Exposure {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => serializer.serialize_str("auto"),
            Self::Stops(stops) => serializer.serialize_f64(*stops),
        }
    }
}

impl Serialize for LayersTop {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Surface => serializer.serialize_str("surface"),
            Self::Height(height_m) => serializer.serialize_f64(*height_m),
        }
    }
}

impl Serialize for PathMode {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl Serialize for IntegratorKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for PathMode {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        one_of(deserializer, &Self::ALL, Self::name)
    }
}

impl<'de> Deserialize<'de> for IntegratorKind {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        one_of(deserializer, &Self::ALL, Self::name)
    }
}

/// One of a few values by its name.
fn one_of<'de, D: Deserializer<'de>, T: Copy>(
    deserializer: D,
    values: &[T],
    name: fn(T) -> &'static str,
) -> Result<T, D::Error> {
    let text = String::deserialize(deserializer)?;
    values.iter().copied().find(|value| name(*value) == text).ok_or_else(|| {
        let names: Vec<_> = values.iter().map(|value| name(*value)).collect();
        D::Error::custom(format!("is \"{text}\", but must be one of {}", names.join(", ")))
    })
}

/// A value that displays as text and is parsed from it.
pub(crate) mod text {
    use std::fmt::Display;
    use std::str::FromStr;

    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    pub(crate) fn serialize<T: Display, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(value)
    }

    pub(crate) fn deserialize<'de, T: FromStr<Err: Display>, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<T, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }

    pub(crate) fn deserialize_some<'de, T: FromStr<Err: Display>, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<T>, D::Error> {
        deserialize(deserializer).map(Some)
    }
}

/// Converts a text to a value, or says what it must be.
type FromText<T> = fn(&str) -> Result<T, String>;

/// Conversions of a number, a text and a list. Kinds without a conversion are refused.
struct Notations<T, const COUNT: usize> {
    expected: &'static str,
    number: Option<fn(f64) -> T>,
    text: Option<FromText<T>>,
    list: Option<fn([f64; COUNT]) -> T>,
}

impl<'de, T, const COUNT: usize> Visitor<'de> for Notations<T, COUNT> {
    type Value = T;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(self.expected)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<T, E> {
        let number = self.number.ok_or_else(|| E::invalid_type(Unexpected::Float(value), &self))?;
        Ok(number(value))
    }

    #[expect(clippy::cast_precision_loss, reason = "beyond 2^53 no quantity here is valid")]
    fn visit_i64<E: Error>(self, value: i64) -> Result<T, E> {
        let number = self.number.ok_or_else(|| E::invalid_type(Unexpected::Signed(value), &self))?;
        Ok(number(value as f64))
    }

    #[expect(clippy::cast_precision_loss, reason = "beyond 2^53 no quantity here is valid")]
    fn visit_u64<E: Error>(self, value: u64) -> Result<T, E> {
        let number = self.number.ok_or_else(|| E::invalid_type(Unexpected::Unsigned(value), &self))?;
        Ok(number(value as f64))
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<T, E> {
        match self.text {
            Some(text) => text(value).map_err(E::custom),
            None => Err(E::invalid_type(Unexpected::Str(value), &self)),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<T, A::Error> {
        let list = self.list.ok_or_else(|| A::Error::invalid_type(Unexpected::Seq, &self))?;
        let mut numbers = [0.0; COUNT];
        for (index, number) in numbers.iter_mut().enumerate() {
            *number = items.next_element()?.ok_or_else(|| A::Error::invalid_length(index, &self))?;
        }
        if items.next_element::<serde::de::IgnoredAny>()?.is_some() {
            return Err(A::Error::invalid_length(COUNT + 1, &self));
        }
        Ok(list(numbers))
    }
}

impl<'de> Deserialize<'de> for SnowProperty {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Notations {
            expected: "a number or a list of two",
            number: Some(Self::Uniform),
            text: None,
            list: Some(Self::Blend),
        })
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

impl<'de> Deserialize<'de> for Exposure {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Notations::<Self, 0> {
            expected: "\"auto\" or a number of stops",
            number: Some(Self::Stops),
            text: Some(|text| match text {
                "auto" => Ok(Self::Auto),
                other => Err(format!("is \"{other}\", but must be \"auto\" or a number of stops")),
            }),
            list: None,
        })
    }
}

impl<'de> Deserialize<'de> for LayersTop {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Notations::<Self, 0> {
            expected: "\"surface\" or a height in m",
            number: Some(Self::Height),
            text: Some(|text| match text {
                "surface" => Ok(Self::Surface),
                other => Err(format!("is \"{other}\", but must be \"surface\" or a height in m")),
            }),
            list: None,
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
