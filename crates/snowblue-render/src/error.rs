//! Errors of this crate. Every message names the file, and the line if there is one.

use std::path::PathBuf;

use snowblue_base::files::FileError;
use snowblue_database::DatabaseError;

use snowblue_base::KeyError;

/// Why a scene cannot be loaded, or an image not written. Rendering a loaded scene never fails.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// A file of a scene cannot be read or used.
    #[error(transparent)]
    File(#[from] FileError),
    /// A scene is not valid TOML, has an unknown or missing key, or a value is out of range.
    #[error("{}:{line}: {reason}", path.display())]
    Scene {
        /// The scene file.
        path: PathBuf,
        /// Its line, counted from 1.
        line: usize,
        /// The quantity, its value and its range.
        reason: String,
    },
    /// A file with the spectrum of a light or a reflectance is not valid.
    #[error("{}:{line}: {reason}", path.display())]
    Spectrum {
        /// The file.
        path: PathBuf,
        /// Its line, counted from 1.
        line: usize,
        /// The quantity, its value and its range.
        reason: String,
    },
    /// A file of layers of snow is not valid.
    #[error("{}:{line}: {reason}", path.display())]
    Layers {
        /// The file.
        path: PathBuf,
        /// Its line, counted from 1.
        line: usize,
        /// The quantity, its value and its range.
        reason: String,
    },
    /// A value of a description breaks a rule.
    #[error(transparent)]
    Description(#[from] KeyError),
    /// A table of curves for PCASnow cannot be used.
    #[error(transparent)]
    Table(#[from] DatabaseError),
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
    /// A mesh cannot be written. There is no file under its name then.
    #[error("cannot write {}: {source}", path.display())]
    WriteMesh {
        /// The mesh file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
}
