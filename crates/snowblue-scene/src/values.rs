//! Quantities and notations that several parts of a scene share.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use glam::Vec3A;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Error, SeqAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use snowblue_base::{KeyError, KeyPath, Number, Numbers, ParameterRange, Quantity, narrow, quantities};
use snowblue_color::{LinearRgb, Srgb8};

/// Greatest coordinate of anything in a description, in m: more than the coordinates of national grids.
const MAX_COORDINATE_M: f64 = 1e8;
/// Greatest coordinate of anything in a scene from its local origin, in m.
pub(crate) const MAX_REACH_M: f64 = 1e5;

quantities! {
    /// A coordinate of anything in a scene.
    pub Coordinate = ParameterRange::new("coordinate", -MAX_COORDINATE_M, MAX_COORDINATE_M, "m");
    /// A component of a direction of any length.
    pub Direction = ParameterRange::new("component", -1e6, 1e6, "");
    /// An angle about an axis.
    pub Rotation = ParameterRange::new("angle", -360.0, 360.0, "°");
    /// A part of a whole.
    pub Fraction = ParameterRange::new("fraction", 0.0, 1.0, "");
    /// An edge or a radius of a shape.
    pub ShapeSize = ParameterRange::new("size", 1e-4, 1e5, "m");
    /// A height or a width of something small on a shape.
    pub SmallLength = ParameterRange::new("length", 0.0, 1.0, "m");
    /// A factor of the lengths of a shape.
    pub ScaleFactor = ParameterRange::new("scale", 1e-6, 1e6, "");
}

/// A stretch: one factor, or one for each axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Scale {
    /// All axes alike.
    Uniform(Number<ScaleFactor>),
    /// Along x, y and z, before the rotation.
    Axes(Numbers<ScaleFactor, 3>),
}

impl Default for Scale {
    fn default() -> Self {
        Self::Uniform(Number::of(1.0))
    }
}

/// The axis of a mesh file that points upwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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
    Linear(Numbers<Fraction, 3>),
    /// Encoded sRGB.
    Encoded(Srgb8),
}

impl ColorDescription {
    /// The colour in linear sRGB.
    pub(crate) fn linear(&self) -> [f32; 3] {
        match *self {
            Self::Linear(channels) => channels.get().map(narrow),
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
            word: None,
            list: Some(Self::Axes),
        })
    }
}

impl<'de> Deserialize<'de> for ColorDescription {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Notations {
            expected: "a list of three numbers or \"#rrggbb\"",
            number: None,
            word: Some(|word| word.parse().map(Self::Encoded).map_err(|error| format!("{error}"))),
            list: Some(Self::Linear),
        })
    }
}

impl JsonSchema for ColorDescription {
    fn schema_name() -> Cow<'static, str> {
        "Color".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let linear = Numbers::<Fraction, 3>::json_schema(generator);
        json_schema!({ "anyOf": [linear, { "type": "string", "pattern": "^#[0-9a-fA-F]{6}$" }] })
    }
}

/// The value of a word, or the rest of a sentence on what is wrong with it.
type Word<T> = fn(&str) -> Result<T, String>;

/// Notations of a value: a number, a word, or a list of fixed length. An untagged type of serde would lose the place of
/// an error.
pub(crate) struct Notations<Q: Quantity, const LENGTH: usize, T> {
    pub(crate) expected: &'static str,
    pub(crate) number: Option<fn(Number<Q>) -> T>,
    pub(crate) word: Option<Word<T>>,
    pub(crate) list: Option<fn(Numbers<Q, LENGTH>) -> T>,
}

impl<'de, Q: Quantity, const LENGTH: usize, T> Visitor<'de> for Notations<Q, LENGTH, T> {
    type Value = T;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(self.expected)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<T, E> {
        let number = self.number.ok_or_else(|| E::invalid_type(Unexpected::Float(value), &self))?;
        Number::new(value).map(number).map_err(|error| E::custom(error.after_key()))
    }

    #[expect(clippy::cast_precision_loss, reason = "no range reaches 2^53")]
    fn visit_i64<E: Error>(self, value: i64) -> Result<T, E> {
        self.visit_f64(value as f64)
    }

    #[expect(clippy::cast_precision_loss, reason = "no range reaches 2^53")]
    fn visit_u64<E: Error>(self, value: u64) -> Result<T, E> {
        self.visit_f64(value as f64)
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<T, E> {
        match self.word {
            Some(read) => read(word).map_err(E::custom),
            None => Err(E::invalid_type(Unexpected::Str(word), &self)),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, items: A) -> Result<T, A::Error> {
        let list = self.list.ok_or_else(|| A::Error::invalid_type(Unexpected::Seq, &self))?;
        Numbers::deserialize(SeqAccessDeserializer::new(items)).map(list)
    }
}

/// The schema of a value with two notations.
pub(crate) struct AnyOf<A, B>(PhantomData<(A, B)>);

impl<A: JsonSchema, B: JsonSchema> JsonSchema for AnyOf<A, B> {
    fn schema_name() -> Cow<'static, str> {
        format!("{}_or_{}", A::schema_name(), B::schema_name()).into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({ "anyOf": [generator.subschema_for::<A>(), generator.subschema_for::<B>()] })
    }
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

    pub(crate) fn serialize_some<T: Display, S: Serializer>(
        value: &Option<T>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        match value {
            Some(value) => serializer.collect_str(value),
            None => serializer.serialize_none(),
        }
    }

    pub(crate) fn deserialize_some<'de, T: FromStr<Err: Display>, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<T>, D::Error> {
        deserialize(deserializer).map(Some)
    }
}

/// Whether things are visible to the camera by default.
pub(crate) fn visible() -> bool {
    true
}

/// The default seed of random numbers.
pub(crate) fn first_seed() -> u32 {
    1
}

/// The z axis.
pub(crate) fn upwards() -> Numbers<Direction, 3> {
    Numbers::of([0.0, 0.0, 1.0])
}

/// A point or direction in single precision.
pub(crate) fn point<Q: Quantity>(coordinates: Numbers<Q, 3>) -> Vec3A {
    coordinates.get().map(narrow).into()
}

/// The unit vector of a direction. A direction of zero length is refused with the given `reason`.
pub(crate) fn unit_vector(path: &KeyPath, direction: Vec3A, reason: &str) -> Result<Vec3A, KeyError> {
    direction.try_normalize().ok_or_else(|| path.error(reason))
}

/// The reason why a key is refused beside another given key that excludes it.
pub(crate) fn beside(other: &str) -> String {
    format!("stands beside `{other}`: give one of them")
}

/// The only given value among several values that exclude each other.
///
/// # Errors
///
/// If none or more than one is given.
pub(crate) fn only_one<T, const COUNT: usize>(
    path: &KeyPath,
    given: [(&str, Option<T>); COUNT],
) -> Result<T, KeyError> {
    let names = given.each_ref().map(|(name, _)| *name);
    let mut given = given.into_iter().filter_map(|(name, value)| Some((name, value?)));
    match (given.next(), given.next()) {
        (Some((_, value)), None) => Ok(value),
        (Some((first, _)), Some((second, _))) => Err(path.key(second).error(beside(first))),
        (None, _) => Err(path.error(format!("needs one of {}", names.join(", ")))),
    }
}

/// Declares an enumeration of things of one kind. Each line has the word that names the thing, its variant, and the
/// type of its keys. A file of its own declares this type, which implements a common trait. Where serde alone does not
/// read the keys, the function of the type that reads a table follows.
macro_rules! things {
    (@keys $table:ident, $keys:path) => {
        $table.read::<$keys>()
    };
    (@keys $table:ident, $keys:path, $read:ident) => {
        <$keys>::$read($table)
    };
    (
        $(#[$doc:meta])*
        $name:ident by $tag:literal: dyn $interface:path {
            $($(#[$variant_doc:meta])* $word:literal => $variant:ident($keys:path $(, $read:ident)?),)*
        }
    ) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
        #[serde(tag = $tag)]
        pub enum $name {
            $($(#[$variant_doc])* #[serde(rename = $word)] $variant($keys),)*
        }

        impl $name {
            /// Reads the thing that a table names.
            pub(crate) fn read(mut table: snowblue_base::toml_table::Table) -> Result<Self, snowblue_base::ParseError> {
                type Read = fn(snowblue_base::toml_table::Table) -> Result<$name, snowblue_base::ParseError>;
                let known: &[(&str, Read)] =
                    &[$(($word, |table| things!(@keys table, $keys $(, $read)?).map($name::$variant)),)*];
                table.take_name($tag, known)?(table)
            }

            /// The word that names the thing.
            #[allow(dead_code, reason = "not everything is named in reports")]
            pub(crate) fn word(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => $word,)*
                }
            }

            /// The keys of the thing.
            pub(crate) fn keys(&self) -> &dyn $interface {
                match self {
                    $(Self::$variant(keys) => keys,)*
                }
            }
        }
    };
}

pub(crate) use things;
