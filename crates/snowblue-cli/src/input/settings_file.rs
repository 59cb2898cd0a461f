//! Settings in TOML, with errors that name the file and the line.

use std::fmt::Display;
use std::ops::Range;
use std::path::Path;

use snowblue_base::files::checked_text;

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
        let bytes = std::fs::read(path)
            .map_err(|error| Failure::Input(format!("{}: cannot be read: {error}", path.display())))?;
        checked_text(path, &bytes).map_err(Failure::input)
    }

    /// An error at a byte range of the text.
    pub(crate) fn failure(self, span: &Range<usize>, reason: impl Display) -> Failure {
        let before = &self.text.as_bytes()[..span.start.min(self.text.len())];
        let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
        Failure::Input(format!("{}:{line}: {reason}", self.path.display()))
    }
}
