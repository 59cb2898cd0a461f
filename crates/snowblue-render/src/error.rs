//! Errors of this crate.

use std::path::PathBuf;

use snowblue_base::KeyError;
use snowblue_base::files::FileError;
use snowblue_scene::{SceneError, SceneFile};

/// Why a scene cannot be loaded or rendered, or an image not written. An integrator that was prepared always renders.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// A scene cannot be built, or a method cannot render it.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// An image cannot be encoded.
    #[error("{0}")]
    EncodeImage(String),
    /// An image cannot be encoded or written. There is no file under its name then.
    #[error("cannot write {}: {reason}", path.display())]
    WriteImage {
        /// The image file.
        path: PathBuf,
        /// The error of the encoder or the operating system.
        reason: String,
    },
}

impl RenderError {
    /// Adds the scene file and the line to an error about a value.
    #[must_use]
    pub fn located(self, file: &SceneFile) -> Self {
        match self {
            Self::Scene(error) => Self::Scene(file.locate(error)),
            other => other,
        }
    }
}

impl From<KeyError> for RenderError {
    fn from(error: KeyError) -> Self {
        Self::Scene(error.into())
    }
}

impl From<FileError> for RenderError {
    fn from(error: FileError) -> Self {
        Self::Scene(error.into())
    }
}
