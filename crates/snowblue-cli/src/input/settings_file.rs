//! Settings in TOML, with errors that name the file and the line.

use std::fmt::Display;
use std::io::ErrorKind;
use std::ops::Range;
use std::path::Path;

use crate::output::Failure;

/// A file's path and text.
#[derive(Clone, Copy)]
pub(crate) struct SettingsFile<'f> {
    pub(crate) path: &'f Path,
    pub(crate) text: &'f str,
}

impl SettingsFile<'_> {
    /// Reads the text of a file.
    pub(crate) fn read(path: &Path) -> Result<String, Failure> {
        std::fs::read_to_string(path).map_err(|error| {
            let name = path.display();
            Failure::Input(match error.kind() {
                ErrorKind::InvalidData => format!("{name}: is not text (UTF-8)"),
                _ => format!("{name}: cannot be read: {error}"),
            })
        })
    }

    /// An error at a byte range of the text.
    pub(crate) fn failure(self, span: &Range<usize>, reason: impl Display) -> Failure {
        let before = &self.text.as_bytes()[..span.start.min(self.text.len())];
        let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
        Failure::Input(format!("{}:{line}: {reason}", self.path.display()))
    }
}
