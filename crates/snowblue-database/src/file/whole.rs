//! Files that are there whole or not at all.

use std::io;
use std::path::{Path, PathBuf};

/// Lets `write` fill a file beside `path`, hidden and of a name that no other process uses, and moves it to its place.
///
/// What was there before stays until then, and stays for good if anything fails.
///
/// # Errors
/// If the path names no file, or the file cannot be written or moved.
pub fn write_whole(path: &Path, write: impl FnOnce(&Path) -> io::Result<()>) -> io::Result<()> {
    let beside = unfinished_path(path).ok_or_else(|| io::Error::other("the path names no file"))?;
    let moved = write(&beside).and_then(|()| std::fs::rename(&beside, path));
    if moved.is_err() {
        // What is left of a failed write is of no use; a second failure would only hide the first.
        drop(std::fs::remove_file(&beside));
    }
    moved
}

/// Where this process writes a file before it moves to its place; none if the path names no file. A process that ends at once
/// removes it.
pub fn unfinished_path(path: &Path) -> Option<PathBuf> {
    let mut hidden = std::ffi::OsString::from(".");
    hidden.push(path.file_name()?);
    hidden.push(format!(".{}.part", std::process::id()));
    Some(path.with_file_name(hidden))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.nc");
        write_whole(&path, |beside| std::fs::write(beside, "first")).unwrap();
        let half = |beside: &Path| std::fs::write(beside, "half").and_then(|()| Err(io::Error::other("full disk")));
        assert_eq!(write_whole(&path, half).unwrap_err().to_string(), "full disk");
        assert_eq!(std::fs::read(&path).unwrap(), b"first");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        assert!(write_whole(&folder.path().join("missing/table.nc"), |beside| std::fs::write(beside, "")).is_err());
        assert!(write_whole(Path::new("/"), |_| Ok(())).is_err());
    }
}
