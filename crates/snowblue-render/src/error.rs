//! What can go wrong in this room: every message names the file and, in a scene, the line.

use std::path::PathBuf;

/// The ways in which loading a scene or writing an image can fail; rendering itself cannot.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// A scene or mesh file cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    ReadFile {
        /// The file asked for.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The scene breaks a rule: of TOML, of the scene's keys, or of a value's range.
    #[error("{}:{line}: {reason}", path.display())]
    Scene {
        /// The scene file.
        path: PathBuf,
        /// Line in it, counted from 1.
        line: usize,
        /// The quantity, its value and what it must be.
        reason: String,
    },
    /// A file with a spectrum, of a lamp or a paint, breaks a rule.
    #[error("{}:{line}: {reason}", path.display())]
    Spectrum {
        /// The file.
        path: PathBuf,
        /// Line in it, counted from 1.
        line: usize,
        /// The quantity, its value and what it must be.
        reason: String,
    },
    /// An image, of the sky or on a surface, cannot be used.
    #[error("{}: {reason}", path.display())]
    ReadImage {
        /// The image file.
        path: PathBuf,
        /// What is wrong in it.
        reason: String,
    },
    /// A mesh file is not what it claims to be.
    #[error("{}: {reason}", path.display())]
    Mesh {
        /// The mesh file.
        path: PathBuf,
        /// What is wrong in it, with the place where that is known.
        reason: String,
    },
    /// A line of a mesh file breaks a rule of its format.
    #[error("{}:{line}: {reason}", path.display())]
    MeshLine {
        /// The mesh file.
        path: PathBuf,
        /// Line in it, counted from 1.
        line: usize,
        /// What is wrong there.
        reason: String,
    },
    /// A setting given from outside the scene file (an override) lies out of range.
    #[error("{0}")]
    Override(String),
    /// A picture cannot be encoded.
    #[error("{0}")]
    EncodeImage(String),
    /// An image cannot be encoded or stored; nothing is left behind under its name.
    #[error("cannot write {}: {reason}", path.display())]
    WriteImage {
        /// The image file.
        path: PathBuf,
        /// What the encoder or the operating system said.
        reason: String,
    },
}
