//! Numbers that lie in the range of their quantity: a value that exists is valid.

use std::fmt;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::range::{ParameterRange, RangeError};

/// A quantity with a range. [`quantities!`](crate::quantities) declares quantities.
pub trait Quantity: fmt::Debug + Copy + PartialEq {
    /// Name, range and unit.
    const RANGE: ParameterRange;
}

/// Declares quantities.
///
/// ```
/// use snowblue_base::{Number, ParameterRange, quantities};
///
/// quantities! {
///     /// An angle about the vertical.
///     pub Azimuth = ParameterRange::new("azimuth", 0.0, 360.0, "°");
/// }
/// assert_eq!(Number::<Azimuth>::new(90.0)?.get(), 90.0);
/// let error = Number::<Azimuth>::new(400.0).unwrap_err();
/// assert_eq!(error.to_string(), "azimuth is 400°, but must lie in 0–360°");
/// # Ok::<(), snowblue_base::RangeError>(())
/// ```
#[macro_export]
macro_rules! quantities {
    ($($(#[$doc:meta])* $visibility:vis $name:ident = $range:expr;)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        $visibility struct $name;

        impl $crate::Quantity for $name {
            const RANGE: $crate::ParameterRange = $range;
        }
    )*};
}

/// A number in the range of a quantity.
#[derive(Clone, Copy, PartialEq)]
pub struct Number<Q: Quantity>(f64, PhantomData<Q>);

/// A whole number in the range of a quantity.
#[derive(Clone, Copy, PartialEq)]
pub struct Count<Q: Quantity>(u32, PhantomData<Q>);

/// A list of so many numbers in the range of a quantity.
#[derive(Clone, Copy, PartialEq)]
pub struct Numbers<Q: Quantity, const LENGTH: usize>([f64; LENGTH], PhantomData<Q>);

impl<Q: Quantity> Number<Q> {
    /// A number that may lie outside the range.
    ///
    /// # Errors
    /// If it lies outside the range.
    pub fn new(value: f64) -> Result<Self, RangeError> {
        Q::RANGE.check(value).map(|()| Self(value, PhantomData))
    }

    /// A number that is known to lie in the range.
    ///
    /// # Panics
    /// If it lies outside the range.
    #[must_use]
    pub const fn of(value: f64) -> Self {
        assert!(value >= Q::RANGE.least && value <= Q::RANGE.greatest, "the number lies in the range of its quantity");
        Self(value, PhantomData)
    }

    /// The number.
    #[must_use]
    pub const fn get(self) -> f64 {
        self.0
    }
}

impl<Q: Quantity> Count<Q> {
    /// The nearest whole number in the range.
    #[must_use]
    pub fn nearest(value: u32) -> Self {
        let nearest = f64::from(value).clamp(Q::RANGE.least, Q::RANGE.greatest);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the range of a count is of counts"
        )]
        Self(nearest as u32, PhantomData)
    }

    /// A whole number that may lie outside the range.
    ///
    /// # Errors
    /// If it lies outside the range.
    pub fn new(value: u32) -> Result<Self, RangeError> {
        Q::RANGE.check(value.into()).map(|()| Self(value, PhantomData))
    }

    /// A whole number that is known to lie in the range.
    ///
    /// # Panics
    /// If it lies outside the range.
    #[must_use]
    pub const fn of(value: u32) -> Self {
        let number = value as f64;
        assert!(
            number >= Q::RANGE.least && number <= Q::RANGE.greatest,
            "the number lies in the range of its quantity"
        );
        Self(value, PhantomData)
    }

    /// The number.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }
}

impl<Q: Quantity, const LENGTH: usize> Numbers<Q, LENGTH> {
    /// Numbers that may lie outside the range.
    ///
    /// # Errors
    /// If one of them lies outside the range.
    pub fn new(values: [f64; LENGTH]) -> Result<Self, RangeError> {
        values.iter().try_for_each(|value| Q::RANGE.check(*value)).map(|()| Self(values, PhantomData))
    }

    /// Numbers that are known to lie in the range.
    ///
    /// # Panics
    /// If one of them lies outside the range.
    #[must_use]
    pub fn of(values: [f64; LENGTH]) -> Self {
        Self(values.map(|value| Number::<Q>::of(value).get()), PhantomData)
    }

    /// The numbers.
    #[must_use]
    pub const fn get(self) -> [f64; LENGTH] {
        self.0
    }
}

impl<Q: Quantity> fmt::Display for Number<Q> {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

impl<Q: Quantity> fmt::Display for Count<Q> {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

impl<Q: Quantity> fmt::Debug for Number<Q> {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

impl<Q: Quantity> fmt::Debug for Count<Q> {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

impl<Q: Quantity, const LENGTH: usize> fmt::Debug for Numbers<Q, LENGTH> {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

/// 0, for quantities whose range has it.
impl<Q: Quantity> Default for Number<Q> {
    fn default() -> Self {
        Self::of(0.0)
    }
}

/// Zeros, for quantities whose range has them.
impl<Q: Quantity, const LENGTH: usize> Default for Numbers<Q, LENGTH> {
    fn default() -> Self {
        Self::of([0.0; LENGTH])
    }
}

impl<Q: Quantity> Serialize for Number<Q> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(self.0)
    }
}

impl<Q: Quantity> Serialize for Count<Q> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u32(self.0)
    }
}

impl<Q: Quantity, const LENGTH: usize> Serialize for Numbers<Q, LENGTH> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.as_slice().serialize(serializer)
    }
}

impl<'de, Q: Quantity> Deserialize<'de> for Number<Q> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_f64(NumberVisitor(PhantomData::<Q>))
    }
}

impl<'de, Q: Quantity> Deserialize<'de> for Count<Q> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value: f64 = deserializer.deserialize_u64(NumberVisitor(PhantomData::<Q>))?.get();
        // The range of a count has no number beyond 32 bits.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it lies in the range")]
        let count = value as u32;
        if f64::from(count).to_bits() == value.to_bits() {
            return Ok(Self(count, PhantomData));
        }
        Err(D::Error::custom(format_args!("is {value}, but must be a whole number")))
    }
}

impl<'de, Q: Quantity, const LENGTH: usize> Deserialize<'de> for Numbers<Q, LENGTH> {
    /// serde's own arrays do not read items after the last expected item.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let values: Vec<f64> = Vec::<Number<Q>>::deserialize(deserializer)?.into_iter().map(Number::get).collect();
        let count = values.len();
        let wrong = |_| D::Error::custom(format_args!("has {count} numbers, but must have {LENGTH}"));
        Ok(Self(values.try_into().map_err(wrong)?, PhantomData))
    }
}

/// Reads a number. Messages leave out the name of the quantity, as its key stands before them.
struct NumberVisitor<Q>(PhantomData<Q>);

impl<Q: Quantity> Visitor<'_> for NumberVisitor<Q> {
    type Value = Number<Q>;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "a number in {}", Q::RANGE)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Number<Q>, E> {
        Number::new(value).map_err(|error| E::custom(error.after_key()))
    }

    #[expect(clippy::cast_precision_loss, reason = "no range reaches 2^53")]
    fn visit_i64<E: Error>(self, value: i64) -> Result<Number<Q>, E> {
        self.visit_f64(value as f64)
    }

    #[expect(clippy::cast_precision_loss, reason = "no range reaches 2^53")]
    fn visit_u64<E: Error>(self, value: u64) -> Result<Number<Q>, E> {
        self.visit_f64(value as f64)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Number<Q>, E> {
        Err(E::invalid_type(Unexpected::Str(text), &self))
    }
}

impl<Q: Quantity> JsonSchema for Number<Q> {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        Q::RANGE.quantity.into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        schema("number", &Q::RANGE)
    }
}

impl<Q: Quantity> JsonSchema for Count<Q> {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        Q::RANGE.quantity.into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        schema("integer", &Q::RANGE)
    }
}

impl<Q: Quantity, const LENGTH: usize> JsonSchema for Numbers<Q, LENGTH> {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        Q::RANGE.quantity.into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let items = schema("number", &Q::RANGE);
        json_schema!({ "type": "array", "items": items, "minItems": LENGTH, "maxItems": LENGTH })
    }
}

fn schema(kind: &str, &ParameterRange { least, greatest, unit, .. }: &ParameterRange) -> Schema {
    let mut schema = json_schema!({ "type": kind, "minimum": least, "maximum": greatest });
    if !unit.is_empty() {
        schema.insert("x-unit".to_owned(), unit.into());
    }
    schema
}
