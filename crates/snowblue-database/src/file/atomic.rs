//! Files that appear complete or not at all.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// Writes a file atomically: `write` fills a hidden file beside `path`, which then replaces `path`.
///
/// A file that exists at `path` stays until then, and remains if anything fails.
///
/// ```
/// use std::io::Write as _;
/// use snowblue_database::file::write_atomically;
///
/// let path = std::env::temp_dir().join(format!("snowblue-{}.txt", std::process::id()));
/// write_atomically(&path, |file| file.write_all(b"snow"))?;
/// assert_eq!(std::fs::read(&path)?, b"snow");
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
/// If the path has no file name, or the file cannot be written or renamed.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let partial = partial_path(path).ok_or_else(|| io::Error::other("the path names no file"))?;
    let written =
        File::create(&partial).and_then(|mut file| write(&mut file)).and_then(|()| std::fs::rename(&partial, path));
    if written.is_err() {
        // The first error is reported, not one of the clean-up.
        drop(std::fs::remove_file(&partial));
    }
    written
}

/// The hidden file that [`write_atomically`] fills, unique to this process. `None` if the path has no file name. A
/// process that exits without unwinding removes this file.
pub fn partial_path(path: &Path) -> Option<PathBuf> {
    let mut hidden = std::ffi::OsString::from(".");
    hidden.push(path.file_name()?);
    // WebAssembly has no processes, and their number would panic.
    let process = if cfg!(target_family = "wasm") { 0 } else { std::process::id() };
    hidden.push(format!(".{process}.part"));
    Some(path.with_file_name(hidden))
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    #[test]
    fn failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.nc");
        write_atomically(&path, |file| file.write_all(b"first")).unwrap();
        let fails = |file: &mut File| file.write_all(b"half").and_then(|()| Err(io::Error::other("full disk")));
        assert_eq!(write_atomically(&path, fails).unwrap_err().to_string(), "full disk");
        assert_eq!(std::fs::read(&path).unwrap(), b"first");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        assert!(write_atomically(&folder.path().join("missing/table.nc"), |_| Ok(())).is_err());
        assert!(write_atomically(Path::new("/"), |_| Ok(())).is_err());
    }
}
