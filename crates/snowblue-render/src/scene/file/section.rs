//! One table of a scene file, read key by key: unknown keys are errors, every value is checked for kind and
//! range, and every complaint knows its line.

use std::ops::{Range, RangeInclusive};
use std::path::Path;

use glam::Vec3A;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::RenderError;
use crate::geometry::ray::narrow;

/// A scene file's name and text, to say where in it something is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SceneText<'text> {
    /// The file.
    pub(crate) path: &'text Path,
    /// Its content.
    pub(crate) text: &'text str,
}

impl SceneText<'_> {
    /// A complaint about a place in the file.
    pub(crate) fn error(&self, place: &Range<usize>, reason: impl Into<String>) -> RenderError {
        let before = &self.text.as_bytes()[..place.start.min(self.text.len())];
        RenderError::Scene {
            path: self.path.into(),
            line: 1 + before.iter().filter(|&&byte| byte == b'\n').count(),
            reason: reason.into(),
        }
    }
}

/// A table of the scene while it is read.
#[derive(Debug)]
pub(crate) struct Section<'text> {
    source: SceneText<'text>,
    table: &'text DeTable<'text>,
    name: String,
    place: Range<usize>,
}

type Read<T> = Result<T, RenderError>;

impl<'text> Section<'text> {
    /// A table with its name in the file and its place.
    pub(crate) fn new(source: SceneText<'text>, name: String, value: &'text Spanned<DeValue<'text>>) -> Read<Self> {
        let place = value.span();
        let Some(table) = value.get_ref().as_table() else {
            return Err(source.error(&place, format!("`{name}` is {}, but must be a table", kind(value.get_ref()))));
        };
        Ok(Self { source, table, name, place })
    }

    /// Refuses keys other than these.
    pub(crate) fn only(&self, keys: &[&str]) -> Read<()> {
        match self.table.keys().find(|key| !keys.contains(&key.get_ref().as_ref())) {
            None => Ok(()),
            Some(key) => {
                let known = keys.join(", ");
                let reason = format!("unknown key `{}` in {}; known are {known}", key.get_ref(), self.name);
                Err(self.source.error(&key.span(), reason))
            }
        }
    }

    /// A complaint about the table as a whole.
    pub(crate) fn error(&self, reason: impl Into<String>) -> RenderError {
        self.source.error(&self.place, reason)
    }

    /// A complaint about the value of one key.
    pub(crate) fn error_at(&self, key: &str, reason: impl Into<String>) -> RenderError {
        self.source.error(&self.place_of(key), reason)
    }

    /// Where a key's value stands, or the table where there is none.
    pub(crate) fn place_of(&self, key: &str) -> Range<usize> {
        self.table.get(key).map_or(self.place.clone(), Spanned::span)
    }

    /// A number within a range; the key must be there unless there is a default.
    pub(crate) fn number(&self, key: &str, default: Option<f64>, range: RangeInclusive<f64>, unit: &str) -> Read<f64> {
        let Some(value) = self.value(key) else {
            return default.ok_or_else(|| self.missing(key));
        };
        let number = as_number(value).ok_or_else(|| self.wrong_kind(key, value, "a number"))?;
        self.check(key, number, &range, unit)?;
        Ok(number)
    }

    /// A whole number within a range.
    pub(crate) fn count(&self, key: &str, default: u32, range: RangeInclusive<u32>) -> Read<u32> {
        let Some(value) = self.value(key) else {
            return Ok(default);
        };
        let integer = as_integer(value).ok_or_else(|| self.wrong_kind(key, value, "a whole number"))?;
        match u32::try_from(integer) {
            Ok(count) if range.contains(&count) => Ok(count),
            _ => {
                let (low, high) = range.into_inner();
                Err(self.error_at(key, format!("{} is {integer}, but must lie in {low}–{high}", self.full_name(key))))
            }
        }
    }

    /// Three numbers within a range; the key must be there unless there is a default.
    pub(crate) fn vector(
        &self,
        key: &str,
        default: Option<Vec3A>,
        range: RangeInclusive<f64>,
        unit: &str,
    ) -> Read<Vec3A> {
        let Some(value) = self.value(key) else {
            return default.ok_or_else(|| self.missing(key));
        };
        let numbers: Option<Vec<f64>> =
            value.as_array().map(|list| list.iter().filter_map(|item| as_number(item.get_ref())).collect());
        let length = value.as_array().map_or(0, |list| list.len());
        match numbers.as_deref() {
            Some(&[x, y, z]) if length == 3 => {
                for number in [x, y, z] {
                    self.check(key, number, &range, unit)?;
                }
                Ok(Vec3A::new(narrow(x), narrow(y), narrow(z)))
            }
            _ => Err(self.wrong_kind(key, value, "a list of three numbers")),
        }
    }

    /// Rows of numbers, all of one length: how many there are in each, and all of them.
    pub(crate) fn rows(&self, key: &str) -> Read<Option<(usize, Vec<f32>)>> {
        let Some(value) = self.value(key) else {
            return Ok(None);
        };
        let wrong = || self.wrong_kind(key, value, "a list of lists of numbers, all of one length");
        let mut columns = 0;
        let mut numbers = Vec::new();
        for row in value.as_array().ok_or_else(wrong)? {
            let row = row.get_ref().as_array().ok_or_else(wrong)?;
            if columns != 0 && columns != row.len() {
                return Err(wrong());
            }
            columns = row.len();
            for item in row {
                numbers.push(narrow(as_number(item.get_ref()).ok_or_else(wrong)?));
            }
        }
        Ok(Some((columns, numbers)))
    }

    /// A number within a range, or two; one number counts as both. The key must be there.
    pub(crate) fn one_or_two(&self, key: &str, range: RangeInclusive<f64>, unit: &str) -> Read<[f64; 2]> {
        let value = self.value(key).ok_or_else(|| self.missing(key))?;
        let Some(list) = value.as_array() else {
            return self.number(key, None, range, unit).map(|number| [number; 2]);
        };
        let numbers: Option<Vec<f64>> = list.iter().map(|item| as_number(item.get_ref())).collect();
        let Some(&[first, second]) = numbers.as_deref() else {
            return Err(self.wrong_kind(key, value, "a number or a list of two"));
        };
        self.check(key, first, &range, unit)?;
        self.check(key, second, &range, unit)?;
        Ok([first, second])
    }

    /// Two numbers within a range, which must be there.
    pub(crate) fn pair(&self, key: &str, range: RangeInclusive<f64>, unit: &str) -> Read<[f32; 2]> {
        if let Some(value) = self.value(key).filter(|value| value.as_array().is_none()) {
            return Err(self.wrong_kind(key, value, "a list of two numbers"));
        }
        self.one_or_two(key, range, unit).map(|pair| pair.map(narrow))
    }

    /// True or false.
    pub(crate) fn flag(&self, key: &str, default: bool) -> Read<bool> {
        match self.value(key) {
            None => Ok(default),
            Some(value) => value.as_bool().ok_or_else(|| self.wrong_kind(key, value, "true or false")),
        }
    }

    /// A table within this one, if the key is there.
    pub(crate) fn table(&self, key: &str) -> Read<Option<Self>> {
        let inner = self.table.get(key);
        inner.map(|value| Self::new(self.source, self.full_name(key), value)).transpose()
    }

    /// A text, if the key is there.
    pub(crate) fn text(&self, key: &str) -> Read<Option<&'text str>> {
        let Some(value) = self.value(key) else {
            return Ok(None);
        };
        match value.as_str() {
            Some(text) => Ok(Some(text)),
            None => Err(self.wrong_kind(key, value, "a text in quotes")),
        }
    }

    /// A text that must be there.
    pub(crate) fn required_text(&self, key: &str) -> Read<&'text str> {
        self.text(key)?.ok_or_else(|| self.missing(key))
    }

    /// One of a few named values, or the default.
    pub(crate) fn choice<T: Copy>(&self, key: &str, default: T, choices: &[(&str, T)]) -> Read<T> {
        let Some(text) = self.text(key)? else {
            return Ok(default);
        };
        match choices.iter().find(|(name, _)| *name == text) {
            Some(&(_, value)) => Ok(value),
            None => {
                let names: Vec<_> = choices.iter().map(|(name, _)| *name).collect();
                let name = self.full_name(key);
                Err(self.error_at(key, format!("{name} is \"{text}\", but must be one of {}", names.join(", "))))
            }
        }
    }

    /// Whether a key is there, and a text: for values that are a word or a number.
    pub(crate) fn is_text(&self, key: &str) -> bool {
        self.table.get(key).is_some_and(|value| value.get_ref().as_str().is_some())
    }

    /// Whether a key is there, and a list: for values that are one number or several.
    pub(crate) fn is_list(&self, key: &str) -> bool {
        self.value(key).is_some_and(|value| value.as_array().is_some())
    }

    /// Whether a key is there.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// A key's name with its table's.
    pub(crate) fn full_name(&self, key: &str) -> String {
        format!("{}.{key}", self.name)
    }

    fn value(&self, key: &str) -> Option<&'text DeValue<'text>> {
        self.table.get(key).map(Spanned::get_ref)
    }

    fn missing(&self, key: &str) -> RenderError {
        self.error(format!("{} is missing", self.full_name(key)))
    }

    fn wrong_kind(&self, key: &str, value: &DeValue, wanted: &str) -> RenderError {
        self.error_at(key, format!("{} is {}, but must be {wanted}", self.full_name(key), kind(value)))
    }

    fn check(&self, key: &str, number: f64, range: &RangeInclusive<f64>, unit: &str) -> Read<()> {
        if range.contains(&number) {
            return Ok(());
        }
        let space = if unit.is_empty() { "" } else { " " };
        let (low, high) = (range.start(), range.end());
        let name = self.full_name(key);
        Err(self
            .error_at(key, format!("{name} is {number}{space}{unit}, but must lie in {low} to {high}{space}{unit}")))
    }
}

fn as_number(value: &DeValue) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        #[expect(clippy::cast_precision_loss, reason = "beyond 2^53 no quantity here is valid")]
        DeValue::Integer(_) => as_integer(value).map(|integer| integer as f64),
        _ => None,
    }
}

fn as_integer(value: &DeValue) -> Option<i64> {
    let integer = value.as_integer()?;
    i64::from_str_radix(integer.as_str(), integer.radix()).ok()
}

fn kind(value: &DeValue) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) => "a whole number",
        DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}
