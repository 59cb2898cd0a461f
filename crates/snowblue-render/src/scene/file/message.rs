//! Errors of a scene file: where in the text they are, and what they say.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::scene::description::{KeyPath, Step};

/// Something wrong at a place in the text.
#[derive(Debug)]
pub(super) struct Mistake {
    pub(super) span: Range<usize>,
    pub(super) reason: String,
}

impl From<toml::de::Error> for Mistake {
    fn from(error: toml::de::Error) -> Self {
        Self { span: error.span().unwrap_or(0..0), reason: error.message().to_owned() }
    }
}

/// The line of a place, counted from 1.
pub(crate) fn line_of(text: &str, place: usize) -> usize {
    1 + text.as_bytes()[..place.min(text.len())].iter().filter(|&&byte| byte == b'\n').count()
}

/// The span of a value, or of the innermost table or list around it that is there.
pub(super) fn span_of(root: &Spanned<DeTable>, path: &KeyPath) -> Range<usize> {
    let mut steps = path.steps().iter();
    let Some(Step::Key(first)) = steps.next() else {
        return root.span();
    };
    let Some(mut value) = root.get_ref().get(first.as_str()) else {
        return root.span();
    };
    for step in steps {
        let inner = match step {
            Step::Key(key) => value.get_ref().as_table().and_then(|table| table.get(key.as_str())),
            Step::Index(index) => value.get_ref().as_array().and_then(|list| list.get(*index)),
        };
        let Some(inner) = inner else { break };
        value = inner;
    }
    value.span()
}

/// An error of serde about a value at a path, as a sentence about the key with its value.
///
/// `known` are keys that the value may have beside those that serde names.
pub(super) fn explain(error: &toml::de::Error, value: &Spanned<DeValue>, path: &KeyPath, known: &[&str]) -> Mistake {
    let span = error.span().unwrap_or(value.span());
    let message = error.message();
    let place = path_to(value, &span, path.clone());
    // An error about a table as a whole may name a key of it.
    let named = message.split('`').skip(1).step_by(2).filter_map(|key| value.get_ref().as_table()?.get(key)).last();
    let span = match named {
        Some(named) if span == value.span() => named.span(),
        _ => span,
    };
    let reason = if let Some(rest) = message.strip_prefix("unknown field `") {
        let (key, rest) = rest.split_once('`').unwrap_or((rest, ""));
        let keys: Vec<&str> = known.iter().copied().chain(rest.split('`').skip(1).step_by(2)).collect();
        format!("unknown key `{key}` in {place}; known are {}", keys.join(", "))
    } else if let Some(key) = message.strip_prefix("missing field `") {
        format!("{place}.{} is missing", key.trim_end_matches('`'))
    } else if let Some((found, expected)) = message.split_once(", expected ")
        && let Some((problem, found)) = found.split_once(": ").or_else(|| found.split_once(' '))
    {
        let found = match problem {
            "unknown" => found.trim_start_matches("variant ").replace('`', "\""),
            _ => found.replace('`', ""),
        };
        let expected = expected.strip_prefix("one of ").map_or(expected.to_owned(), |all| format!("one of {all}"));
        format!("{place} is {found}, but must be {}", plain(&expected))
    } else if message.starts_with("is ") || message.starts_with("has ") || message.starts_with("needs ") {
        format!("{place} {message}")
    } else {
        format!("{place}: {message}")
    };
    Mistake { span, reason }
}

/// What serde expects, in words.
fn plain(expected: &str) -> String {
    match expected {
        "f64" => "a number".to_owned(),
        "u32" => "a whole number from 0 to 4294967295".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a string" => "a text in quotes".to_owned(),
        "a sequence" => "a list".to_owned(),
        other if other.starts_with("struct ") => "a table".to_owned(),
        other => other.replace('`', ""),
    }
}

/// The path of the innermost value that holds a span.
fn path_to(value: &Spanned<DeValue>, span: &Range<usize>, path: KeyPath) -> KeyPath {
    match value.get_ref() {
        DeValue::Table(table) => match table.iter().find(|(_, inner)| holds(inner, span)) {
            Some((key, inner)) => path_to(inner, span, path.key(key.get_ref())),
            None => path,
        },
        DeValue::Array(list) => match list.iter().enumerate().find(|(_, inner)| holds(inner, span)) {
            Some((index, inner)) => path_to(inner, span, path.index(index)),
            None => path,
        },
        _ => path,
    }
}

/// Whether a value, a key of it or a value inside it holds a span. A table with a header of its own lies outside of the
/// table around it, and its keys outside of its span.
fn holds(value: &Spanned<DeValue>, span: &Range<usize>) -> bool {
    let contains = |outer: Range<usize>| outer.start <= span.start && span.end <= outer.end;
    contains(value.span())
        || match value.get_ref() {
            DeValue::Table(table) => table.iter().any(|(key, inner)| contains(key.span()) || holds(inner, span)),
            DeValue::Array(list) => list.iter().any(|inner| holds(inner, span)),
            _ => false,
        }
}
