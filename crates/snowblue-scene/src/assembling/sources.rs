//! What the parts of a scene are built from.

use std::io;

use snowblue_base::files::{FileError, FileSource, NamedFile};

use crate::error::SceneError;
use crate::film::sensor::FalseColor;
use crate::material::diffuse::Diffuse;
use crate::material::texture::Texture;
use crate::spectrum::upsampling::Upsampling;
use crate::spectrum::{SAMPLES, wavelengths_nm};
use snowblue_base::KeyPath;

/// The files, the wavelengths and the colours.
pub(super) struct Sources<'scene> {
    pub(super) files: &'scene dyn FileSource,
    /// The wavelengths of the picture.
    pub(super) wavelengths_nm: [f64; SAMPLES],
    /// In false colour lights are white, whatever their spectrum.
    pub(super) is_false_color: bool,
    upsampling: Upsampling,
}

impl<'scene> Sources<'scene> {
    /// For the wavelengths of the observer, or those of a false colour.
    pub(super) fn new(files: &'scene dyn FileSource, false_color: Option<FalseColor>) -> Self {
        let is_false_color = false_color.is_some();
        Self {
            files,
            wavelengths_nm: false_color.map_or_else(wavelengths_nm, |colour| colour.wavelengths_nm()),
            is_false_color,
            upsampling: if is_false_color { Upsampling::grey() } else { Upsampling::reflectance() },
        }
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
