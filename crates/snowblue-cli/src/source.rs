//! Files of settings as users write them, and the place in them of what is wrong.

use std::fmt::Display;
use std::ops::Range;
use std::path::Path;

use serde::de::DeserializeOwned;

use crate::failure::Failure;

/// A file's name and text.
#[derive(Clone, Copy)]
pub(crate) struct Source<'f> {
    pub(crate) path: &'f Path,
    pub(crate) text: &'f str,
}

impl Source<'_> {
    /// The text of a file.
    pub(crate) fn read(path: &Path) -> Result<String, Failure> {
        std::fs::read_to_string(path)
            .map_err(|error| Failure::Input(format!("{}: cannot be read: {error}", path.display())))
    }

    /// What the text says in TOML.
    pub(crate) fn parse<T: DeserializeOwned>(self) -> Result<T, Failure> {
        toml::from_str(self.text)
            .map_err(|error| self.failure(&error.span().unwrap_or(0..0), error.message().replace('\n', "; ")))
    }

    /// That something is wrong at a place in the text.
    pub(crate) fn failure(self, place: &Range<usize>, reason: impl Display) -> Failure {
        let before = &self.text.as_bytes()[..place.start.min(self.text.len())];
        let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
        Failure::Input(format!("{}:{line}: {reason}", self.path.display()))
    }
}
