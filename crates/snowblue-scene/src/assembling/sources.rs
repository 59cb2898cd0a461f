//! What the parts of a scene are built from.

use std::io;

use snowblue_base::files::{FileError, FileSource, NamedFile};

use crate::error::SceneError;
use crate::material::diffuse::Diffuse;
use crate::material::texture::Texture;
use crate::spectrum::upsampling::Upsampling;
use snowblue_base::KeyPath;

/// The files and the spectra of colours.
pub(super) struct Sources<'scene> {
    pub(super) files: &'scene dyn FileSource,
    upsampling: Upsampling,
}

impl<'scene> Sources<'scene> {
    pub(super) fn new(files: &'scene dyn FileSource) -> Self {
        Self { files, upsampling: Upsampling::reflectance() }
    }

    /// A reflectance of one colour in linear sRGB.
    pub(super) fn uniform(&self, colour: [f32; 3]) -> Diffuse {
        Diffuse::Uniform(self.upsampling.spectrum(colour))
    }

    /// Reflectances of the colours of a texture in linear sRGB.
    pub(super) fn textured(&self, texture: Texture) -> Diffuse {
        Diffuse::textured(texture, self.upsampling)
    }

    /// The file that a key names.
    pub(super) fn open(&self, path: &KeyPath, name: &str) -> Result<NamedFile, SceneError> {
        NamedFile::read(self.files, name).map_err(|error| self.named(path, name, error))
    }

    /// An error about the file that a key names: where the file does not exist, that of the key.
    pub(super) fn named(&self, path: &KeyPath, name: &str, error: impl Into<SceneError>) -> SceneError {
        match error.into() {
            SceneError::File(FileError::Read { path: file, source })
                if source.kind() == io::ErrorKind::NotFound && file == self.files.display_name(name) =>
            {
                path.error(format!("is \"{name}\", but {} does not exist", file.display())).into()
            }
            other => other,
        }
    }
}
