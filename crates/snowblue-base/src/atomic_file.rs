//! Files that appear complete or not at all.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Ending of the names of hidden files that are being written.
const PARTIAL: &str = ".part";

/// The path of the standard output.
pub const STANDARD_OUTPUT: &str = "/dev/stdout";

/// Where the content of a path goes.
enum Target {
    /// To a file, which need not exist. Symbolic links in the path are resolved.
    File(PathBuf),
    /// To the standard output, or to a pipe or a device. Nothing is replaced.
    Stream,
}

/// Writes a file atomically: `write` fills a hidden file beside `path`, which then replaces `path`.
///
/// An existing file at `path` stays until then, and remains if anything fails. The new file gets the permissions of
/// the existing file. Symbolic links are followed. The standard output, a pipe and a device get the content when it
/// is complete.
///
/// ```
/// use std::io::Write as _;
/// use snowblue_base::atomic_file::write_atomically;
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
    let mut partial = Partial::create(path)?;
    let written = partial.fill(path, write);
    if written.is_err() {
        partial.remove();
    }
    written
}

/// Checks that [`write_atomically`] can write a file at a path, as far as this can be checked in advance.
///
/// # Errors
/// As [`write_atomically`].
pub fn check_writable(path: &Path) -> io::Result<()> {
    if path.is_dir() {
        return Err(io::Error::from(io::ErrorKind::IsADirectory));
    }
    Partial::create(path).map(|partial| partial.remove())
}

/// Whether a path is the standard output, a pipe or a device, which get the content in one piece.
pub fn is_stream(path: &Path) -> bool {
    matches!(target(path), Ok(Target::Stream))
}

/// The hidden file that [`write_atomically`] fills, unique to this process. `None` if the path has no file name. A
/// process that exits without unwinding removes this file.
pub fn partial_path(path: &Path) -> Option<PathBuf> {
    let beside = match target(path).ok()? {
        Target::File(path) => path,
        Target::Stream => std::env::temp_dir().join(path.file_name()?),
    };
    let mut name = OsString::from(".");
    name.push(beside.file_name()?);
    name.push(format!(".{}{PARTIAL}", this_process()));
    Some(beside.with_file_name(name))
}

/// Where the content of a path goes.
fn target(path: &Path) -> io::Result<Target> {
    if path == Path::new(STANDARD_OUTPUT) {
        return Ok(Target::Stream);
    }
    match fs::metadata(path) {
        Ok(metadata) if metadata.is_file() => fs::canonicalize(path).map(Target::File),
        Ok(metadata) if !metadata.is_dir() => Ok(Target::Stream),
        Err(error) if error.kind() == io::ErrorKind::NotFound && path.is_symlink() => {
            // A link to a file that does not exist yet. A cycle of links has another error.
            let link = fs::read_link(path)?;
            target(&path.parent().unwrap_or(Path::new("")).join(link))
        }
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(Target::File(path.to_owned())),
    }
}

/// A hidden file that is being written, and locked until it is complete.
struct Partial {
    path: PathBuf,
    file: File,
}

impl Partial {
    /// Creates the file, and removes hidden files of processes that were killed.
    fn create(path: &Path) -> io::Result<Self> {
        let partial = partial_path(path).ok_or_else(|| io::Error::other("the path names no file"))?;
        loop {
            // A writer may read the file again.
            let file = File::options().read(true).write(true).create(true).truncate(false).open(&partial)?;
            // Where a file system has no locks, files of killed processes stay.
            drop(file.lock());
            // Another process may have renamed or removed the file before it was locked.
            if is_at(&file, &partial) {
                file.set_len(0)?;
                remove_abandoned(&partial);
                return Ok(Self { path: partial, file });
            }
        }
    }

    fn fill(&mut self, path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
        write(&mut self.file)?;
        match target(path)? {
            Target::File(path) => {
                if let Ok(metadata) = fs::metadata(&path) {
                    fs::set_permissions(&self.path, metadata.permissions())?;
                }
                // A network file system may report a full disk only now.
                self.file.sync_all()?;
                fs::rename(&self.path, path)
            }
            Target::Stream => {
                let mut content = File::open(&self.path)?;
                if path == Path::new(STANDARD_OUTPUT) {
                    let mut output = io::stdout().lock();
                    ignore_closed(io::copy(&mut content, &mut output).and_then(|_| output.flush()))?;
                } else {
                    let mut output = File::options().write(true).open(path)?;
                    ignore_closed(io::copy(&mut content, &mut output).map(drop))?;
                }
                fs::remove_file(&self.path)
            }
        }
    }

    fn remove(&self) {
        // The first error is reported, and not an error of the clean-up.
        drop(fs::remove_file(&self.path));
    }
}

/// A reader that closes a pipe early is not an error.
fn ignore_closed(written: io::Result<()>) -> io::Result<()> {
    match written {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error),
        _ => Ok(()),
    }
}

/// Removes further hidden files of an output that no process has locked, since their processes were killed.
fn remove_abandoned(own: &Path) {
    let name_of = |path: &Path| path.file_name().and_then(OsStr::to_str).map(str::to_owned);
    let process_of = |name: &str, prefix: &str| name.strip_prefix(prefix)?.strip_suffix(PARTIAL)?.parse::<u32>().ok();
    let prefix = name_of(own).and_then(|own| Some(own.strip_suffix(PARTIAL)?.rsplit_once('.')?.0.to_owned() + "."));
    let (Some(folder), Some(prefix)) = (own.parent(), prefix) else { return };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let Ok(entries) = fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        let process = name_of(&path).and_then(|name| process_of(&name, &prefix));
        if process.is_some_and(|process| process != this_process())
            && let Ok(file) = File::options().write(true).open(&path)
            && file.try_lock().is_ok()
            && is_at(&file, &path)
        {
            drop(fs::remove_file(&path));
        }
    }
}

/// Whether a path names an open file.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let number = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    file.metadata().is_ok_and(|open| fs::metadata(path).is_ok_and(|named| number(open) == number(named)))
}

/// Whether a path names an open file. Here an open file is neither renamed nor removed.
#[cfg(not(unix))]
fn is_at(_file: &File, path: &Path) -> bool {
    path.exists()
}

/// The number of this process.
fn this_process() -> u32 {
    // WebAssembly has no processes, and their number would panic.
    if cfg!(target_family = "wasm") { 0 } else { std::process::id() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.nc");
        write_atomically(&path, |file| file.write_all(b"first")).unwrap();
        let fails = |file: &mut File| file.write_all(b"half").and_then(|()| Err(io::Error::other("full disk")));
        assert_eq!(write_atomically(&path, fails).unwrap_err().to_string(), "full disk");
        assert_eq!(fs::read(&path).unwrap(), b"first");
        check_writable(&path).unwrap();
        assert_eq!(names(folder.path()), ["table.nc"]);
        for path in [&*folder.path().join("missing/table.nc"), folder.path(), Path::new("/")] {
            assert!(check_writable(path).is_err() && write_atomically(path, |_| Ok(())).is_err(), "{}", path.display());
        }
        assert_eq!(names(folder.path()), ["table.nc"]);
    }

    #[test]
    fn files_of_killed_processes_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        // Process numbers are below 2^22.
        for name in [".a.nc.5000000.part", ".a.nc.5000001.part", ".b.nc.5000000.part", ".a.nc.backup.part"] {
            fs::write(at(name), "half").unwrap();
        }
        let alive = File::open(at(".a.nc.5000001.part")).unwrap();
        alive.lock().unwrap();
        write_atomically(&at("a.nc"), |file| file.write_all(b"whole")).unwrap();
        assert_eq!(names(folder.path()), [".a.nc.5000001.part", ".a.nc.backup.part", ".b.nc.5000000.part", "a.nc"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_permissions_kept() {
        use std::os::unix::fs::{PermissionsExt as _, symlink};

        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("disk")).unwrap();
        symlink("disk/file", at("link")).unwrap();
        symlink("link", at("linked")).unwrap();
        symlink("circle", at("circle")).unwrap();
        write_atomically(&at("linked"), |file| file.write_all(b"new")).unwrap();
        fs::set_permissions(at("disk/file"), fs::Permissions::from_mode(0o640)).unwrap();
        write_atomically(&at("linked"), |file| file.write_all(b"again")).unwrap();
        assert_eq!(fs::read(at("disk/file")).unwrap(), b"again");
        assert_eq!(fs::metadata(at("disk/file")).unwrap().permissions().mode() & 0o777, 0o640);
        assert!(at("linked").is_symlink() && at("link").is_symlink());
        assert_eq!(names(&at("disk")), ["file"]);
        assert!(write_atomically(&at("circle"), |_| Ok(())).is_err());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn devices_get_the_content() {
        let null = Path::new("/dev/null");
        assert!(is_stream(null) && is_stream(Path::new(STANDARD_OUTPUT)) && !is_stream(Path::new("/tmp/new")));
        write_atomically(null, |file| file.write_all(b"snow")).unwrap();
        let full = write_atomically(Path::new("/dev/full"), |file| file.write_all(b"snow")).unwrap_err();
        assert_eq!(full.kind(), io::ErrorKind::StorageFull);
        assert!(!fs::metadata(null).unwrap().is_file());
    }
}
