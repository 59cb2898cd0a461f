//! Files that a scene names: meshes, textures, spectra, skies. They come from a folder, from memory or from anything
//! else that yields bytes.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use crate::error::RenderError;

/// Yields the bytes of files by the names that a scene gives them.
pub trait SceneFiles {
    /// The content of a file.
    ///
    /// # Errors
    ///
    /// When there is no such file ([`io::ErrorKind::NotFound`]) or it cannot be read.
    fn read(&self, name: &str) -> io::Result<Vec<u8>>;

    /// The name of a file in error messages.
    fn display_name(&self, name: &str) -> PathBuf {
        name.into()
    }
}

/// Files in a folder of the file system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FilesIn(PathBuf);

impl FilesIn {
    /// Names are relative to this folder.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self(folder.into())
    }

    /// Names are relative to the folder of this file.
    pub fn beside(file: &Path) -> Self {
        Self::new(file.parent().unwrap_or(Path::new("")))
    }
}

impl SceneFiles for FilesIn {
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        std::fs::read(self.display_name(name))
    }

    fn display_name(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

/// Files in memory, by name.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FilesInMemory(BTreeMap<String, Vec<u8>>);

impl FilesInMemory {
    /// Adds a file, or replaces the one of that name.
    pub fn insert(&mut self, name: impl Into<String>, content: impl Into<Vec<u8>>) {
        self.0.insert(name.into(), content.into());
    }
}

impl<Name: Into<String>, Content: Into<Vec<u8>>, const COUNT: usize> From<[(Name, Content); COUNT]> for FilesInMemory {
    fn from(files: [(Name, Content); COUNT]) -> Self {
        Self(files.into_iter().map(|(name, content)| (name.into(), content.into())).collect())
    }
}

impl SceneFiles for FilesInMemory {
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        self.0.get(name).cloned().ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "no file has this name"))
    }
}

/// A function from names to contents.
impl<Read: Fn(&str) -> io::Result<Vec<u8>>> SceneFiles for Read {
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        self(name)
    }
}

/// The content of a file, and its name in error messages.
#[derive(Debug)]
pub(crate) struct NamedFile {
    pub(crate) path: PathBuf,
    pub(crate) bytes: Vec<u8>,
}

impl NamedFile {
    /// Reads a file.
    pub(crate) fn read(files: &dyn SceneFiles, name: &str) -> Result<Self, RenderError> {
        let path = files.display_name(name);
        match files.read(name) {
            Ok(bytes) => Ok(Self { path, bytes }),
            Err(source) => Err(RenderError::ReadFile { path, source }),
        }
    }

    /// The content as text. Bytes that are not UTF-8 become replacement characters.
    pub(crate) fn text(&self) -> Cow<'_, str> {
        String::from_utf8_lossy(&self.bytes)
    }

    /// The part of the name after its last dot, in lower case.
    pub(crate) fn extension(&self) -> String {
        extension(&self.path)
    }
}

/// Refuses the formats of the feature `formats` in a build without it, whose compiler then drops all that follows.
#[inline]
pub(crate) fn check_formats(path: &Path) -> Result<(), RenderError> {
    if cfg!(feature = "formats") {
        return Ok(());
    }
    let reason = "this build reads no PLY, glTF, PNG, OpenEXR or TIFF".to_owned();
    Err(RenderError::Mesh { path: path.to_owned(), reason })
}

/// The part of a file name after its last dot, in lower case.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// The name of a file given relative to the folder of another.
pub(crate) fn name_beside(file: &str, name: &str) -> String {
    Path::new(file).with_file_name(name).to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_relative_to_a_folder_and_to_other_files() {
        let files = FilesIn::beside("scenes/dragon.toml".as_ref());
        assert_eq!(files.display_name("../models/dragon.ply"), Path::new("scenes/../models/dragon.ply"));
        assert_eq!(FilesIn::beside("dragon.toml".as_ref()).display_name("a.ply"), Path::new("a.ply"));
        assert_eq!(name_beside("models/a.gltf", "a.bin"), "models/a.bin");
    }

    #[test]
    fn files_in_memory_are_found_by_name() {
        let files = FilesInMemory::from([("a", [1, 2])]);
        assert_eq!(NamedFile::read(&files, "a").unwrap().bytes, [1, 2]);
        let missing = NamedFile::read(&files, "b").unwrap_err().to_string();
        assert!(missing.contains("cannot read b"), "{missing}");
    }
}
