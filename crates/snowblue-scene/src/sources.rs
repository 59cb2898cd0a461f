//! The files and spectra from which the parts of a scene are built.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io;
use std::path::PathBuf;

use snowblue_base::KeyPath;
use snowblue_base::files::{FileError, FileSource, NamedFile};
use snowblue_base::hash::Fnv1a;

use crate::error::SceneError;
use crate::spectrum::upsampling::Upsampling;

/// The files and the spectra of colours.
pub(crate) struct Sources<'scene> {
    pub(crate) files: &'scene dyn FileSource,
    pub(crate) upsampling: Upsampling,
}

impl<'scene> Sources<'scene> {
    pub(crate) fn new(files: &'scene dyn FileSource) -> Self {
        Self { files, upsampling: Upsampling::reflectance() }
    }

    /// The file that a key names.
    pub(crate) fn open(&self, path: &KeyPath, name: &str) -> Result<NamedFile, SceneError> {
        NamedFile::read(self.files, name).map_err(|error| self.named(path, name, error))
    }

    /// An error about the file that a key names. If the file does not exist, the error is about the key.
    pub(crate) fn named(&self, path: &KeyPath, name: &str, error: impl Into<SceneError>) -> SceneError {
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

/// Files with a record of the contents that were read.
pub(crate) struct RecordedFiles<'files> {
    files: &'files dyn FileSource,
    hashes: RefCell<BTreeMap<String, u64>>,
}

impl<'files> RecordedFiles<'files> {
    /// Files of which no file is read yet.
    pub(crate) fn new(files: &'files dyn FileSource) -> Self {
        Self { files, hashes: RefCell::default() }
    }

    /// Hashes of the contents that were read, by name.
    pub(crate) fn hashes(&self) -> BTreeMap<String, u64> {
        self.hashes.borrow().clone()
    }
}

impl FileSource for RecordedFiles<'_> {
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        let bytes = self.files.read(name)?;
        self.hashes.borrow_mut().insert(name.to_owned(), Fnv1a::of(&bytes));
        Ok(bytes)
    }

    fn display_name(&self, name: &str) -> PathBuf {
        self.files.display_name(name)
    }
}
