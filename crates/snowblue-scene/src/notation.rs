//! Values that files write in more than one way.

use std::fmt;

use serde::de::{Error, SeqAccess, Unexpected, Visitor};

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
pub(crate) struct Notations<T, const COUNT: usize> {
    pub(crate) expected: &'static str,
    pub(crate) number: Option<fn(f64) -> T>,
    pub(crate) text: Option<FromText<T>>,
    pub(crate) list: Option<fn([f64; COUNT]) -> T>,
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
