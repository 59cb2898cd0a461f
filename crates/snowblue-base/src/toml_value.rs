//! Values of TOML documents, read by serde. An error names the path of the value, what it is, and what it must be.
//!
//! serde's own messages name neither the path nor, for values with several notations, the value. And the deserializers
//! of `toml` are different types for tables, lists and values: each makes code of its own for each type that is read.

use std::fmt::{self, Display};
use std::ops::Range;

use serde::de::value::StrDeserializer;
use serde::de::{self, DeserializeSeed, Expected, MapAccess, SeqAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, forward_to_deserialize_any};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::key_path::{KeyPath, Step};

/// Longest text that a message names as a number, in bytes.
const LONGEST_NUMBER: usize = 40;

/// Something wrong at a place in a document.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct Mistake {
    /// The bytes of the text that it is about.
    pub span: Range<usize>,
    /// The key, what is wrong with its value, and what is right.
    pub reason: String,
}

impl Mistake {
    /// The error of the parser in a text. Of what looks like a number it names the key, and how TOML writes it.
    #[must_use]
    pub fn of_parser(text: &str, error: &toml::de::Error) -> Self {
        let span = error.span().unwrap_or(0..0);
        // A text of the right form has values of a wrong type, of which the parser says what is right.
        let is_malformed = DeTable::parse(text).is_err();
        let number = if is_malformed { wrong_number(text, span.start) } else { None };
        let reason = number.unwrap_or_else(|| error.message().replace('\n', "; "));
        Self { span, reason }
    }
}

/// Parses a text.
///
/// # Errors
///
/// When it is not TOML.
pub fn parse(text: &str) -> Result<Spanned<DeTable<'_>>, Mistake> {
    DeTable::parse(text).map_err(|error| Mistake::of_parser(text, &error))
}

/// What is wrong with a value at a byte of a text, if it is written like a number: with digits, and with nothing on
/// either side of the point, a decimal comma, leading zeros or a unit.
fn wrong_number(text: &str, place: usize) -> Option<String> {
    let start = text.get(..place)?.rfind('\n').map_or(0, |before| before + 1);
    let line = text[start..].lines().next()?.split('#').next()?;
    let (before, after) = line.split_at_checked(place - start).unwrap_or((line, ""));
    // A comma separates the items of a list; without one it is that of a decimal.
    let ends: &[char] = if before.contains(['[', '{']) { &['=', '[', ']', '{', '}', ','] } else { &['='] };
    let from = before.rfind(ends).map_or(0, |before| before + 1);
    let to = after.find(ends).map_or(line.len(), |end| before.len() + end);
    let (value, key) = (line[from..to].trim().trim_end_matches(','), line[..from].rsplit_once('=').map(|(key, _)| key));
    let number = value.trim_start_matches(['+', '-']);
    let first = number.trim_start_matches('.').chars().next()?;
    let is_other = value.chars().any(|c| c.is_control() || matches!(c, '"' | '\'' | ':'));
    // Another assignment follows, without a line break or a comma.
    let is_followed = line[to..].starts_with('=');
    // The value is right, and something else is not.
    let is_right = || DeTable::parse(&format!("a = {value}")).is_ok();
    if !first.is_ascii_digit() || is_other || is_followed || value.len() > LONGEST_NUMBER || is_right() {
        return None;
    }
    let key = key.map(|key| key.rsplit(['[', '{', ',']).next().unwrap_or(key).trim());
    let quantity = key.filter(|key| !key.is_empty()).unwrap_or("a number");
    let plain = number.replacen(',', ".", 1);
    let unit = number.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.' || c == ',').trim_start();
    // Digits of another base, or an exponent without digits, are no units.
    let is_letter = |c: char| c.is_ascii_alphabetic() || !c.is_ascii();
    let is_unit = !unit.is_empty() && unit.chars().all(is_letter) && !unit.starts_with(['e', 'E', 'x', 'X']);
    // A comma before three digits may separate thousands.
    let is_grouped = number.split_once(',').is_some_and(|(_, after)| after.len() == 3);
    let hint = match plain.parse::<f64>() {
        Ok(_) if is_grouped => String::new(),
        Ok(plain) => {
            let sign = if value.starts_with('-') { "-" } else { "" };
            format!(", such as {sign}{plain}{}", if plain.fract() > 0.0 { "" } else { ".0" })
        }
        Err(_) if is_unit => " without a unit".to_owned(),
        Err(_) if plain.chars().all(|c| c.is_ascii_digit() || c == '.') => String::new(),
        Err(_) => return None,
    };
    Some(format!("{quantity} is {value}, but must be a number{hint}"))
}

/// Reads the value at a path. `known` are keys that it may have beside those of the type.
///
/// # Errors
///
/// When the value is not one of the type.
pub fn read<'de, T: Deserialize<'de>>(value: &Spanned<DeValue>, path: &KeyPath, known: &[&str]) -> Result<T, Mistake> {
    T::deserialize(TomlValue(value)).map_err(|error| error.in_value(value).mistake(path, known))
}

/// A value of a document as a deserializer.
#[derive(Debug, Clone, Copy)]
struct TomlValue<'a, 'text>(&'a Spanned<DeValue<'text>>);

/// Why a value cannot be read, with the way to the value at fault.
#[derive(Debug)]
struct ValueError {
    /// Its bytes in the text, once they are known.
    span: Option<Range<usize>>,
    /// The steps to it, the last one first.
    steps: Vec<Step>,
    problem: Problem,
}

#[derive(Debug)]
enum Problem {
    /// A key that its table may not have, and those that it may.
    UnknownKey(String, &'static [&'static str]),
    MissingKey(&'static str),
    /// What the value must be.
    Unlike(String),
    /// The words of a type, about the value.
    Said(String),
}

impl ValueError {
    fn new(problem: Problem) -> Self {
        Self { span: None, steps: Vec::new(), problem }
    }

    /// The error, if it arose in a value and not in one inside it: it gets the value's place and name.
    fn in_value(mut self, value: &Spanned<DeValue>) -> Self {
        if self.span.is_none() {
            // Words about a table may name one of its keys.
            let named = match (&self.problem, value.get_ref().as_table()) {
                (Problem::Said(words), Some(table)) => {
                    words.split('`').skip(1).step_by(2).filter_map(|key| table.get(key)).last()
                }
                _ => None,
            };
            self.span = Some(named.unwrap_or(value).span());
            if let Problem::Unlike(expected) = &self.problem {
                self.problem = Problem::Said(format!("is {}, but must be {expected}", name(value.get_ref())));
            }
        }
        self
    }

    /// The error, seen from the table or list around the value.
    fn after(mut self, step: Step) -> Self {
        self.steps.push(step);
        self
    }

    fn mistake(self, path: &KeyPath, outer: &[&str]) -> Mistake {
        let outer = if self.steps.is_empty() { outer } else { &[] };
        let path = path.with(self.steps.into_iter().rev());
        let reason = match self.problem {
            Problem::UnknownKey(key, known) => {
                let known: Vec<&str> = outer.iter().chain(known).copied().collect();
                format!("unknown key `{key}` in {path}; known are {}", known.join(", "))
            }
            Problem::MissingKey(key) => format!("{path}.{key} is missing"),
            Problem::Unlike(expected) => format!("{path} must be {expected}"),
            Problem::Said(words) if ["is ", "has ", "needs "].iter().any(|verb| words.starts_with(verb)) => {
                format!("{path} {words}")
            }
            Problem::Said(words) => format!("{path}: {words}"),
        };
        Mistake { span: self.span.unwrap_or(0..0), reason }
    }
}

impl Display for ValueError {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match &self.problem {
            Problem::UnknownKey(key, _) => write!(formatter, "unknown key `{key}`"),
            Problem::MissingKey(key) => write!(formatter, "`{key}` is missing"),
            Problem::Unlike(expected) => write!(formatter, "must be {expected}"),
            Problem::Said(words) => formatter.write_str(words),
        }
    }
}

impl std::error::Error for ValueError {}

impl de::Error for ValueError {
    fn custom<T: Display>(words: T) -> Self {
        let words = words.to_string();
        Self::new(match words.strip_prefix("must be ") {
            Some(expected) => Problem::Unlike(expected.to_owned()),
            None => Problem::Said(words),
        })
    }

    fn invalid_type(_: Unexpected, expected: &dyn Expected) -> Self {
        Self::new(Problem::Unlike(in_words(&expected.to_string())))
    }

    fn invalid_value(found: Unexpected, expected: &dyn Expected) -> Self {
        Self::invalid_type(found, expected)
    }

    fn invalid_length(length: usize, expected: &dyn Expected) -> Self {
        let values = if length == 1 { "value" } else { "values" };
        Self::new(Problem::Said(format!("has {length} {values}, but must be {}", in_words(&expected.to_string()))))
    }

    fn unknown_variant(_: &str, expected: &'static [&'static str]) -> Self {
        let one_of = if expected.len() > 2 { "one of " } else { "" };
        let separator = if expected.len() > 2 { ", " } else { " or " };
        Self::new(Problem::Unlike(format!("{one_of}{}", expected.join(separator))))
    }

    fn unknown_field(key: &str, expected: &'static [&'static str]) -> Self {
        Self::new(Problem::UnknownKey(key.to_owned(), expected))
    }

    fn missing_field(key: &'static str) -> Self {
        Self::new(Problem::MissingKey(key))
    }
}

/// A value as a message names it.
fn name(value: &DeValue) -> String {
    match value {
        DeValue::String(text) => format!("\"{text}\""),
        DeValue::Integer(number) => number.to_string(),
        DeValue::Float(number) => number.to_string(),
        DeValue::Boolean(value) => value.to_string(),
        DeValue::Datetime(_) => "a date".to_owned(),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    }
}

/// What serde expects, as a message says it.
fn in_words(expected: &str) -> String {
    match expected {
        "f64" => "a number".to_owned(),
        "u32" => format!("a whole number from 0 to {}", u32::MAX),
        "u64" | "usize" => "a whole number from 0".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a string" => "a text in quotes".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a map" => "a table".to_owned(),
        other if other.starts_with("struct ") => "a table".to_owned(),
        other => other.to_owned(),
    }
}

impl<'de> Deserializer<'de> for TomlValue<'_, '_> {
    type Error = ValueError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ValueError> {
        match self.0.get_ref() {
            DeValue::String(text) => visitor.visit_str(text),
            DeValue::Integer(number) => match i64::from_str_radix(number.as_str(), number.radix()) {
                Ok(number) => visitor.visit_i64(number),
                Err(_) => Err(ValueError::new(Problem::Unlike("a number of at most 63 bits".to_owned()))),
            },
            DeValue::Float(number) => match number.as_str().parse() {
                Ok(number) => visitor.visit_f64(number),
                Err(_) => Err(ValueError::new(Problem::Unlike("a number".to_owned()))),
            },
            DeValue::Boolean(value) => visitor.visit_bool(*value),
            // A text's visitor may take it for one, another says what it expects.
            DeValue::Datetime(date) => visitor.visit_str(&date.to_string()),
            DeValue::Array(items) => {
                let mut rest = Items(items.iter().enumerate());
                let value = visitor.visit_seq(&mut rest)?;
                match rest.0.next() {
                    None => Ok(value),
                    Some((read, _)) => {
                        let words = format!("has {} values, but must have {read}", items.len());
                        Err(ValueError::new(Problem::Said(words)))
                    }
                }
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
            _ => Err(ValueError::new(Problem::Unlike("a text in quotes".to_owned()))),
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
        read.map(Some).map_err(|error| error.in_value(item).after(Step::Index(index)))
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
    I: Iterator<Item = (&'a Spanned<std::borrow::Cow<'text, str>>, &'a Spanned<DeValue<'text>>)>,
{
    type Error = ValueError;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, ValueError> {
        let Some((key, value)) = self.rest.next() else { return Ok(None) };
        self.value = Some((key.get_ref(), value));
        let read = seed.deserialize(StrDeserializer::new(key.get_ref()));
        read.map(Some).map_err(|error: ValueError| ValueError { span: error.span.or(Some(key.span())), ..error })
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, ValueError> {
        let (key, value) = self.value.take().expect("a key is read before its value");
        let read = seed.deserialize(TomlValue(value));
        read.map_err(|error| error.in_value(value).after(Step::Key(key.to_owned())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Lamp {
        #[serde(default)]
        _position: [f64; 3],
        _visible: Option<bool>,
        #[serde(default)]
        _parts: Vec<Part>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Part {
        _count: u32,
        _kind: Option<Kind>,
        _size: Option<Size>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Kind {
        Round,
        Flat,
    }

    #[derive(Debug, Deserialize)]
    #[serde(untagged, expecting = "must be a number or a list of numbers")]
    enum Size {
        #[expect(dead_code, reason = "only read")]
        Of(f64),
        #[expect(dead_code, reason = "only read")]
        Each(Vec<f64>),
    }

    #[test]
    fn errors_name_the_path_and_the_value() {
        for (text, place, expected) in [
            ("lamp = 3", "3", "lamp is 3, but must be a table"),
            ("lamp = { colour = 1 }", "colour", "unknown key `colour` in lamp; known are type, _position, _visible,"),
            (
                "lamp = { _position = [1, 2] }",
                "[1, 2]",
                "lamp._position has 2 values, but must be an array of length 3",
            ),
            ("lamp = { _position = [1, 2, 3, 4] }", "[1", "lamp._position has 4 values, but must have 3"),
            ("lamp = { _position = [1, 2, \"3\"] }", "\"3\"", "lamp._position[2] is \"3\", but must be a number"),
            ("lamp = { _visible = 1 }", "1", "lamp._visible is 1, but must be true or false"),
            ("[[lamp._parts]]\n_kind = \"flat\"", "[[lamp._parts]]", "lamp._parts[0]._count is missing"),
            (
                "[[lamp._parts]]\n_count = 1\n[[lamp._parts]]\n_count = -1",
                "-1",
                "lamp._parts[1]._count is -1, but must",
            ),
            ("[[lamp._parts]]\n_count = 99999999999999999999", "99", "but must be a number of at most 63 bits"),
            ("[[lamp._parts]]\n_count = 1\n_kind = \"odd\"", "\"odd\"", "_kind is \"odd\", but must be round or flat"),
            ("[[lamp._parts]]\n_count = 1\n_kind = []", "[]", "_kind is a list, but must be a text in quotes"),
            ("[[lamp._parts]]\n_count = 1\nkind = 2", "kind", "in lamp._parts[0]; known are _count, _kind, _size"),
            (
                "[[lamp._parts]]\n_count = 1\n_size = \"big\"",
                "\"big\"",
                "_size is \"big\", but must be a number or a list",
            ),
            ("lamp = { _visible = 1979-05-27 }", "1979-05-27", "lamp._visible is a date, but must be true or false"),
        ] {
            let document = DeTable::parse(text).unwrap();
            let Mistake { span, reason } =
                read::<Lamp>(&document.get_ref()["lamp"], &KeyPath::root("lamp"), &["type"]).unwrap_err();
            assert!(reason.contains(expected), "{text}: {reason}");
            assert!(text[span.clone()].starts_with(place), "{text}: {span:?}");
        }
    }

    #[test]
    fn numbers_that_are_written_otherwise_are_named() {
        for (text, expected) in [
            ("a = 1\nfacetness = .7 # rough", "facetness is .7, but must be a number, such as 0.7"),
            ("facetness = -.7", "facetness is -.7, but must be a number, such as -0.7"),
            ("facetness = 7.\nb = 2", "facetness is 7., but must be a number, such as 7.0"),
            ("facetness = 7.", "facetness is 7., but must be a number, such as 7.0"),
            ("facetness = 0,7\n", "facetness is 0,7, but must be a number, such as 0.7"),
            ("layer.depth = 007", "layer.depth is 007, but must be a number, such as 7.0"),
            ("depth = 0.7.1", "depth is 0.7.1, but must be a number"),
            ("depth = 30cm", "depth is 30cm, but must be a number without a unit"),
            ("depth = 30 cm", "depth is 30 cm, but must be a number without a unit"),
            ("size = 1,000", "size is 1,000, but must be a number"),
            ("size = [1, .7, 2]", "size is .7, but must be a number, such as 0.7"),
            ("size = [\n  1,\n  .7,\n]", "a number is .7, but must be a number, such as 0.7"),
            ("of = { size = 1, soot = .5 }", "soot is .5, but must be a number, such as 0.5"),
        ] {
            let Mistake { span, reason } = parse(text).unwrap_err();
            assert_eq!(reason, expected, "{text}");
            let (value, _) = reason.split_once(" is ").unwrap().1.split_once(", but").unwrap();
            let line = text[..span.start].matches('\n').count();
            assert_eq!(Some(line), text.lines().position(|line| line.contains(value)), "{text}: {span:?}");
        }
        for text in [
            "a = [1",
            "a 1",
            "= 1",
            "[a",
            "a = \"1",
            "a = x7",
            "a = 1 = 2",
            "é = é",
            "a = 1979-99-99",
            ".",
            "size = [1, 2, 3",
            "a = [\n 1\n 2\n]",
            "a = 1e",
            "a = 0xZZ",
            "of = { soot = 5 dust = 3 }",
            "a = 1 b = 2",
            "a = 5\rb = 6",
            "a = [\n 1,.7,2,\n]",
            "1 = 1\n1 = 2",
        ] {
            let Mistake { reason, .. } = parse(text).unwrap_err();
            assert!(!reason.is_empty() && !reason.contains('\n'), "{text}: {reason}");
            assert!(!reason.contains("must be a number"), "{text}: {reason}");
        }
    }

    #[test]
    fn numbers_may_be_written_as_toml_allows() {
        for (text, value) in [("+1_000", 1000.0), ("0xff", 255.0), ("-2.5e1", -25.0), ("-inf", f64::NEG_INFINITY)] {
            let document = format!("value = {text}");
            let document = DeTable::parse(&document).unwrap();
            let read: f64 = read(&document.get_ref()["value"], &KeyPath::root("value"), &[]).unwrap();
            assert!(read.total_cmp(&value).is_eq(), "{text}: {read}");
        }
    }
}
