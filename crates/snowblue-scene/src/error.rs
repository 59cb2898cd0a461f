//! Errors of this crate. Every message names the file, and the line if there is one, or the path of a value.

use std::path::PathBuf;

use snowblue_base::KeyError;
use snowblue_base::files::FileError;

/// Why a scene cannot be built.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// A file of a scene cannot be read or used.
    #[error(transparent)]
    File(#[from] FileError),
    /// A text is not valid, has an unknown or missing key, or has a value out of range. The text is a scene file,
    /// layers of snow, or a spectrum.
    #[error("{}:{line}: {reason}", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// The line of the text, counted from 1.
        line: usize,
        /// The quantity, its value and its range.
        reason: String,
    },
    /// A value of a description breaks a rule.
    #[error(transparent)]
    Description(#[from] KeyError),
}
