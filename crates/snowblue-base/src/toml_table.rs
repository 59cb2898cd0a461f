//! Tables of TOML documents, read by serde. An error names the path of the value and its place in the text.
//!
//! serde's own tagged and flattened types buffer a table, and errors in it have no place. So a caller
//! [takes](Table::take) the keys out of a table that say what it describes, and [reads](Table::read) the rest.

use std::fmt::Display;
use std::ops::Range;

use serde::de::DeserializeOwned;
use serde_path_to_error::{Segment, Track};
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use crate::key_path::{KeyError, KeyPath, Step};

/// Something wrong at a place of a document.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct ParseError {
    /// The bytes of the text that it is about.
    pub span: Range<usize>,
    /// The key, what is wrong with its value, and what is right.
    pub reason: String,
}

impl ParseError {
    /// The line of a text that it is about, counted from 1.
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

/// The bytes of a value, or of the innermost table or list around it that is there.
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
    /// The keys that were asked for: others are unknown.
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
    /// If it is none of the type.
    pub fn read<T: DeserializeOwned>(self) -> Result<T, ParseError> {
        self.read_beside(&[])
    }

    /// The value as a type. `known` are keys that it may have beside those of the type.
    fn read_beside<T: DeserializeOwned>(self, known: &[&str]) -> Result<T, ParseError> {
        let Self { value, path } = self;
        let (whole, mut track) = (value.span(), Track::new());
        let deserializer = serde_path_to_error::Deserializer::new(ValueDeserializer::from(value), &mut track);
        T::deserialize(deserializer).map_err(|error: toml::de::Error| {
            let inner = track.path();
            let mut message = error.message().replace('\n', "; ");
            if !known.is_empty() && message.starts_with("unknown field") && inner.iter().count() <= 1 {
                message.push_str(&format!(", beside `{}`", known.join("`, `")));
            }
            let path = path.with(inner.iter().filter_map(step));
            let is_rest = ["is ", "has ", "needs ", "must "].iter().any(|verb| message.starts_with(verb));
            let reason = if is_rest { path.error(message).to_string() } else { format!("{path}: {message}") };
            ParseError { span: error.span().unwrap_or(whole), reason }
        })
    }

    /// The value as a table.
    ///
    /// # Errors
    /// If it is none.
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
    /// If it is none.
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
    /// If it is none of the type.
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
    /// If one is no table.
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

    /// Takes the name out that says what the table describes, and finds it in a list.
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

    /// An error about the value of a key, or about the table where it is absent: `reason` is the rest of a sentence
    /// that begins with the path of the key.
    pub fn error_at(&self, key: &str, reason: impl Display) -> ParseError {
        let span = self.entries.get(key).map_or(self.span(), Spanned::span);
        ParseError { span, reason: self.path.key(key).error(reason).to_string() }
    }

    /// Reads all keys that are left.
    ///
    /// # Errors
    /// If they are not those of the type.
    pub fn read<T: DeserializeOwned>(self) -> Result<T, ParseError> {
        let Self { entries, span, path, known } = self;
        Value { value: Spanned::new(span, DeValue::Table(entries)), path }.read_beside(&known)
    }

    /// Refuses keys that are left.
    ///
    /// # Errors
    /// With the first of them.
    pub fn finish(self) -> Result<(), ParseError> {
        let Some((key, _)) = self.entries.iter().next() else { return Ok(()) };
        let reason = format!("unknown key `{}`; known are {}", key.get_ref(), self.known.join(", "));
        Err(ParseError { span: key.span(), reason })
    }
}

/// A step of a path of serde, but for the parts of types with a place.
fn step(segment: &Segment) -> Option<Step> {
    match segment {
        Segment::Seq { index } => Some(Step::Index(*index)),
        Segment::Map { key } if !key.starts_with("$__serde_spanned") => Some(Step::Key(key.clone())),
        Segment::Map { .. } | Segment::Enum { .. } | Segment::Unknown => None,
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
    fn values_of_a_path_are_found() {
        let text = "[[wall]]\nsize = 1\n[[wall]]\nsize = 22\n";
        let path = KeyPath::root("wall").index(1);
        assert_eq!(&text[span_of(text, &path.key("size"))], "22");
        let error = path.key("radius").error("is missing").in_text(text);
        assert_eq!((error.line(text), &*error.reason), (3, "wall[1].radius is missing"));
        assert_eq!(span_of(text, &KeyPath::root("door")).start, 0);
    }
}
