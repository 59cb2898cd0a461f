//! Files that keep a hash of everything that is read from them.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io;
use std::path::PathBuf;

use snowblue_base::files::FileSource;
use snowblue_base::hash::Fnv1a;

/// Files with a record of what was read.
pub(super) struct RecordedFiles<'files> {
    files: &'files dyn FileSource,
    hashes: RefCell<BTreeMap<String, u64>>,
}

impl<'files> RecordedFiles<'files> {
    /// Nothing is read yet.
    pub(super) fn new(files: &'files dyn FileSource) -> Self {
        Self { files, hashes: RefCell::default() }
    }

    /// Hashes of the contents that were read, by name.
    pub(super) fn hashes(&self) -> BTreeMap<String, u64> {
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
