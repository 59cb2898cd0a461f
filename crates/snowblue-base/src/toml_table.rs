//! Tables of TOML documents, read by serde. An error names the path of the value and its place in the text.
//!
//! serde's own tagged and flattened types buffer a table, and errors in a buffered table have no place in the text.
//! So a caller [takes](Table::take) out of a table the keys that name its kind, and [reads](Table::read) the rest.

use std::borrow::Cow;
use std::fmt::Display;
use std::ops::Range;

use serde::de::value::StrDeserializer;
use serde::de::{self, DeserializeOwned, DeserializeSeed, MapAccess, SeqAccess, Visitor};
use serde::{Deserializer, forward_to_deserialize_any};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::key_path::{KeyError, KeyPath, Step};

/// An error at a place of a document.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct ParseError {
    /// The bytes of the text at which the error lies.
    pub span: Range<usize>,
    /// The key, the error in its value, and the valid values.
    pub reason: String,
}

impl ParseError {
    /// The line of a text at which the error lies, counted from 1.
    #[must_use]
    pub fn line(&self, text: &str) -> usize {
        line_of(text, self.span.start)
    }
}

impl From<toml::de::Error> for ParseError {
    fn from(error: toml::de::Error) -> Self {
        Self { span: error.span().unwrap_or(0..0), reason: error.message().replace('\n', "; ") }
    }
}

/// The line of a byte of a text, counted from 1.
#[must_use]
pub fn line_of(text: &str, byte: usize) -> usize {
    1 + text.as_bytes()[..byte.min(text.len())].iter().filter(|&&byte| byte == b'\n').count()
}

/// The bytes of a value, or of the innermost existing table or list around the value.
#[must_use]
pub fn span_of(text: &str, path: &KeyPath) -> Range<usize> {
    let Ok(root) = DeTable::parse(text) else { return 0..0 };
    let mut span = root.span();
    let mut value = Spanned::new(root.span(), DeValue::Table(root.into_inner()));
    for step in path.steps() {
        let inner = match (step, value.into_inner()) {
            (Step::Key(key), DeValue::Table(mut table)) => table.remove(key.as_str()),
            (Step::Index(index), DeValue::Array(list)) => list.into_iter().nth(*index),
            _ => None,
        };
        let Some(inner) = inner else { break };
        span = inner.span();
        value = inner;
    }
    span
}

/// A value that is still to be read.
#[derive(Debug, Clone)]
pub struct Value<'text> {
    value: Spanned<DeValue<'text>>,
    path: KeyPath,
}

/// A table with keys that are still to be read.
#[derive(Debug, Clone)]
pub struct Table<'text> {
    entries: DeTable<'text>,
    span: Range<usize>,
    path: KeyPath,
    /// The keys that were asked for. All other keys are unknown.
    known: Vec<&'static str>,
}

impl<'text> Value<'text> {
    /// The value itself.
    #[must_use]
    pub fn get(&self) -> &DeValue<'text> {
        self.value.get_ref()
    }

    /// An error about the value: `reason` is the rest of a sentence that begins with its path.
    pub fn error(&self, reason: impl Display) -> ParseError {
        ParseError { span: self.value.span(), reason: self.path.error(reason).to_string() }
    }

    /// The value as a type.
    ///
    /// # Errors
    /// If the value is not of the type.
    pub fn read<T: DeserializeOwned>(self) -> Result<T, ParseError> {
        self.read_beside(&[])
    }

    /// The value as a type. `known` are keys that the value may have beside the keys of the type.
    fn read_beside<T: DeserializeOwned>(self, known: &[&str]) -> Result<T, ParseError> {
        let Self { value, path } = self;
        T::deserialize(TomlValue(&value)).map_err(|error| {
            let ValueError { mut message, span, steps } = error;
            if !known.is_empty() && message.starts_with("unknown field") && steps.len() <= 1 {
                message.push_str(&format!(", beside `{}`", known.join("`, `")));
            }
            let path = path.with(steps.into_iter().rev());
            let is_rest = ["is ", "has ", "needs ", "must "].iter().any(|verb| message.starts_with(verb));
            let reason = if is_rest { path.error(message).to_string() } else { format!("{path}: {message}") };
            ParseError { span: span.unwrap_or(value.span()), reason }
        })
    }

    /// The value as a table.
    ///
    /// # Errors
    /// If the value is not a table.
    pub fn table(self) -> Result<Table<'text>, ParseError> {
        let span = self.value.span();
        match self.value.into_inner() {
            DeValue::Table(entries) => Ok(Table { entries, span, path: self.path, known: Vec::new() }),
            _ => Err(ParseError { span, reason: self.path.error("must be a table").to_string() }),
        }
    }

    /// The value as a list of tables, as `[[light]]` makes it.
    ///
    /// # Errors
    /// If the value is not a list of tables.
    pub fn tables(self) -> Result<Vec<Table<'text>>, ParseError> {
        let Self { value, path } = self;
        let span = value.span();
        let DeValue::Array(list) = value.into_inner() else {
            let names: Vec<_> = path.steps().iter().filter_map(Step::key).collect();
            let reason = path.error(format!("must be written as [[{}]]", names.join("."))).to_string();
            return Err(ParseError { span, reason });
        };
        list.into_iter().enumerate().map(|(index, value)| Value { value, path: path.index(index) }.table()).collect()
    }
}

impl<'text> Table<'text> {
    /// The table of a document.
    ///
    /// # Errors
    /// If the text is not TOML.
    pub fn parse(text: &'text str) -> Result<Self, ParseError> {
        let root = DeTable::parse(text)?;
        let span = root.span();
        Ok(Self { entries: root.into_inner(), span, path: KeyPath::default(), known: Vec::new() })
    }

    /// The path to the table.
    #[must_use]
    pub fn path(&self) -> &KeyPath {
        &self.path
    }

    /// The bytes of the table.
    #[must_use]
    pub fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// Whether a key is still to be read.
    #[must_use]
    pub fn has(&self, key: &str) -> bool {
        self.entries.contains_key(key)
    }

    /// An error about the table: `reason` is the rest of a sentence that begins with its path.
    pub fn error(&self, reason: impl Display) -> ParseError {
        ParseError { span: self.span(), reason: self.path.error(reason).to_string() }
    }

    /// Takes a value out.
    pub fn take(&mut self, key: &'static str) -> Option<Value<'text>> {
        self.known.push(key);
        self.entries.remove(key).map(|value| Value { value, path: self.path.key(key) })
    }

    /// Takes a value out and reads it.
    ///
    /// # Errors
    /// If the value is not of the type.
    pub fn take_as<T: DeserializeOwned>(&mut self, key: &'static str) -> Result<Option<T>, ParseError> {
        self.take(key).map(Value::read).transpose()
    }

    /// Takes a table out.
    ///
    /// # Errors
    /// If the value is none.
    pub fn take_table(&mut self, key: &'static str) -> Result<Option<Table<'text>>, ParseError> {
        self.take(key).map(Value::table).transpose()
    }

    /// Takes the tables of a list out; none if the key is absent.
    ///
    /// # Errors
    /// If the value is no list of tables.
    pub fn take_tables(&mut self, key: &'static str) -> Result<Vec<Table<'text>>, ParseError> {
        self.take(key).map_or(Ok(Vec::new()), Value::tables)
    }

    /// Takes out all keys that are left, with their values as tables.
    ///
    /// # Errors
    /// If a value is not a table.
    pub fn into_tables(self) -> Result<Vec<(String, Table<'text>)>, ParseError> {
        let named = self.entries.into_iter().map(|(key, value)| {
            let key = key.into_inner().into_owned();
            let path = self.path.key(&key);
            Ok((key, Value { value, path }.table()?))
        });
        named.collect()
    }

    /// Takes some keys out as a table of its own.
    #[must_use]
    pub fn split(&mut self, keys: &[&'static str]) -> Self {
        self.known.extend(keys);
        let entries = keys.iter().filter_map(|key| self.entries.remove_entry(*key)).collect();
        Self { entries, span: self.span(), path: self.path.clone(), known: Vec::new() }
    }

    /// Takes out the name of the kind of the table, and finds it in a list.
    ///
    /// # Errors
    /// If the key is missing, or the name is not in the list.
    pub fn take_name<T: Copy>(&mut self, key: &'static str, named: &[(&str, T)]) -> Result<T, ParseError> {
        let missing = self.error_at(key, "is missing");
        let value = self.take(key).ok_or(missing)?;
        let name: String = value.clone().read()?;
        named.iter().find(|(known, _)| *known == name).map(|(_, found)| *found).ok_or_else(|| {
            let names: Vec<_> = named.iter().map(|(name, _)| *name).collect();
            value.error(format!("is \"{name}\", but must be one of {}", names.join(", ")))
        })
    }

    /// An error about the value of a key, or about the table if the key is absent: `reason` is the rest of a sentence
    /// that begins with the path of the key.
    pub fn error_at(&self, key: &str, reason: impl Display) -> ParseError {
        let span = self.entries.get(key).map_or(self.span(), Spanned::span);
        ParseError { span, reason: self.path.key(key).error(reason).to_string() }
    }

    /// Reads all keys that are left.
    ///
    /// # Errors
    /// If the keys are not the keys of the type.
    pub fn read<T: DeserializeOwned>(self) -> Result<T, ParseError> {
        let Self { entries, span, path, known } = self;
        Value { value: Spanned::new(span, DeValue::Table(entries)), path }.read_beside(&known)
    }

    /// Refuses keys that are left.
    ///
    /// # Errors
    /// If a key is left, with the first of these keys.
    pub fn finish(self) -> Result<(), ParseError> {
        let Some((key, _)) = self.entries.iter().next() else { return Ok(()) };
        let reason = format!("unknown key `{}`; known are {}", key.get_ref(), self.known.join(", "));
        Err(ParseError { span: key.span(), reason })
    }
}

/// A value as a deserializer. The deserializers of `toml` have different types for values, lists and tables, so that
/// each type that is read would be compiled for each of these deserializers.
#[derive(Debug, Clone, Copy)]
struct TomlValue<'a, 'text>(&'a Spanned<DeValue<'text>>);

/// Why a value cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
struct ValueError {
    message: String,
    /// The bytes of the innermost value or key at fault; none for the whole value.
    span: Option<Range<usize>>,
    /// The steps to that value or key, the last step first.
    steps: Vec<Step>,
}

impl ValueError {
    /// The error, seen from the table or list around a key or value at some bytes.
    fn inside(mut self, span: Range<usize>, step: Step) -> Self {
        self.span.get_or_insert(span);
        self.steps.push(step);
        self
    }
}

impl de::Error for ValueError {
    fn custom<T: Display>(message: T) -> Self {
        Self { message: message.to_string().replace('\n', "; "), span: None, steps: Vec::new() }
    }
}

impl<'de> Deserializer<'de> for TomlValue<'_, '_> {
    type Error = ValueError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ValueError> {
        match self.0.get_ref() {
            DeValue::String(text) => visitor.visit_str(text),
            DeValue::Integer(number) => match i64::from_str_radix(number.as_str(), number.radix()) {
                Ok(number) => visitor.visit_i64(number),
                Err(_) => Err(de::Error::custom("must be a number of at most 63 bits")),
            },
            DeValue::Float(number) => visitor.visit_f64(number.as_str().parse().map_err(de::Error::custom)?),
            DeValue::Boolean(value) => visitor.visit_bool(*value),
            DeValue::Datetime(moment) => visitor.visit_str(&moment.to_string()),
            DeValue::Array(list) => {
                let mut rest = Items(list.iter().enumerate());
                let value = visitor.visit_seq(&mut rest)?;
                rest.0.next().map_or(Ok(value), |(read, _)| {
                    Err(de::Error::custom(format!("has {} values, but must have {read}", list.len())))
                })
            }
            DeValue::Table(table) => visitor.visit_map(Entries { rest: table.iter(), value: None }),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ValueError> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, ValueError> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ValueError> {
        match self.0.get_ref() {
            DeValue::String(text) => visitor.visit_enum(StrDeserializer::new(text)),
            _ => Err(de::Error::custom("must be a text in quotes")),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map struct identifier ignored_any
    }
}

/// The items of a list that are still to be read.
struct Items<I>(I);

impl<'a, 'text: 'a, 'de, I: Iterator<Item = (usize, &'a Spanned<DeValue<'text>>)>> SeqAccess<'de> for &mut Items<I> {
    type Error = ValueError;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, ValueError> {
        let Some((index, item)) = self.0.next() else { return Ok(None) };
        let read = seed.deserialize(TomlValue(item));
        read.map(Some).map_err(|error| error.inside(item.span(), Step::Index(index)))
    }
}

/// The entries of a table that are still to be read.
struct Entries<'a, 'text, I> {
    rest: I,
    /// The last key and its value.
    value: Option<(&'a str, &'a Spanned<DeValue<'text>>)>,
}

impl<'a, 'text, 'de, I> MapAccess<'de> for Entries<'a, 'text, I>
where
    I: Iterator<Item = (&'a Spanned<Cow<'text, str>>, &'a Spanned<DeValue<'text>>)>,
{
    type Error = ValueError;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, ValueError> {
        let Some((key, value)) = self.rest.next() else { return Ok(None) };
        let name = &**key.get_ref();
        self.value = Some((name, value));
        let read = seed.deserialize(StrDeserializer::<ValueError>::new(name));
        read.map(Some).map_err(|error| error.inside(key.span(), Step::Key(name.to_owned())))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, ValueError> {
        let (key, value) = self.value.take().expect("a key is read before its value");
        let read = seed.deserialize(TomlValue(value));
        read.map_err(|error| error.inside(value.span(), Step::Key(key.to_owned())))
    }
}

/// The error of a value in a text that was read before.
impl KeyError {
    /// The place of the value in the text.
    #[must_use]
    pub fn in_text(&self, text: &str) -> ParseError {
        ParseError { span: span_of(text, &self.path), reason: self.to_string() }
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;
    use crate::quantity::{Count, Number, Numbers};
    use crate::range::ParameterRange;

    crate::quantities! {
        Length = ParameterRange::new("length", 0.001, 1000.0, "m");
        Courses = ParameterRange::new("courses", 2.0, 20.0, "");
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only read")]
    struct Wall {
        size: Numbers<Length, 3>,
        radius: Option<Number<Length>>,
        courses: Option<Count<Courses>>,
        parts: Option<Vec<Part>>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only read")]
    struct Part {
        radius: Number<Length>,
        middle: Option<[f64; 2]>,
        year: Option<i64>,
    }

    fn read(text: &str) -> Result<Wall, ParseError> {
        let mut root = Table::parse(text)?;
        let mut wall = root.take("wall").unwrap().table()?;
        wall.take_as::<String>("material")?;
        wall.read()
    }

    #[test]
    fn errors_name_path_value_range_unit_and_place() {
        for (keys, place, expected) in [
            ("size = [1, 2, 0]", "0]", "wall.size[2] is 0 m, but must lie in 0.001–1000 m"),
            ("size = [1, 2]", "[1, 2]", "wall.size has 2 numbers, but must have 3"),
            ("size = [1, 2, 3, 4]", "[1, 2, 3, 4]", "wall.size has 4 numbers, but must have 3"),
            ("size = [1, 2, 3]\nradius = nan", "nan", "wall.radius is NaN m, but must lie in 0.001–1000 m"),
            (
                "size = [1, 2, 3]\nradius = \"5 cm\"",
                "\"5 cm\"",
                "wall.radius: invalid type: string \"5 cm\", expected a number in 0.001–1000 m",
            ),
            ("size = [1, 2, 3]\ncourses = 21", "21", "wall.courses is 21, but must lie in 2–20"),
            ("size = [1, 2, 3]\ncourses = 2.5", "2.5", "wall.courses is 2.5, but must be a whole number"),
            (
                "size = [1, 2, 3]\nparts = [{ radius = 1 }, { radius = -1 }]",
                "-1 }",
                "wall.parts[1].radius is -1 m, but must lie in 0.001–1000 m",
            ),
            (
                "size = [1, 2, 3]\nparts = [{ radius = 1, middle = [1, 2, 3] }]",
                "[1, 2, 3] }]",
                "wall.parts[0].middle has 3 values, but must have 2",
            ),
            (
                "size = [1, 2, 3]\nparts = [{ radius = 1, year = 0x8000000000000000 }]",
                "0x8000000000000000",
                "wall.parts[0].year must be a number of at most 63 bits",
            ),
            ("size = [1, 2, 3]\nparts = [{ year = 1 }]", "{ year", "wall.parts[0]: missing field `radius`"),
            ("radius = 3", "[wall]", "wall: missing field `size`"),
            (
                "size = [1, 2, 3]\ncolour = 3",
                "colour",
                "wall.colour: unknown field `colour`, expected one of `size`, `radius`, `courses`, `parts`, \
                 beside `material`",
            ),
        ] {
            let text = format!("[wall]\nmaterial = \"snow\"\n{keys}\n");
            let error = read(&text).unwrap_err();
            assert_eq!(error.reason, expected, "{text}");
            assert!(
                text[error.span.clone()].starts_with(place.trim_end_matches([' ', '}', ']'])),
                "{place}: {error:?}"
            );
        }
    }

    #[test]
    fn values_have_each_notation_of_toml() {
        for (value, expected) in [("-inf", f64::NEG_INFINITY), ("+1_000", 1000.0), ("0xff", 255.0), ("-2.5e1", -25.0)] {
            let text = format!("value = {value}");
            let read: f64 = Table::parse(&text).unwrap().take_as("value").unwrap().unwrap();
            assert!(read.total_cmp(&expected).is_eq(), "{value}: {read}");
        }
        let mut moments = Table::parse("day = 2026-02-01\ntime = 14:30:00").unwrap();
        assert_eq!(moments.take_as::<String>("day").unwrap().unwrap(), "2026-02-01");
        assert_eq!(moments.take_as::<String>("time").unwrap().unwrap(), "14:30:00");
    }

    #[test]
    fn values_of_a_path_are_found() {
        let text = "[[wall]]\nsize = 1\n[[wall]]\nsize = 22\n";
        let path = KeyPath::root("wall").index(1);
        assert_eq!(&text[span_of(text, &path.key("size"))], "22");
        let error = path.key("radius").error("is missing").in_text(text);
        assert_eq!((error.line(text), &*error.reason), (3, "wall[1].radius is missing"));
        assert_eq!(span_of(text, &KeyPath::root("door")).start, 0);
    }
}
