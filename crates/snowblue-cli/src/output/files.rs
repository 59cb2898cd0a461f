//! Output files: checks before long work, and atomic writes.

use std::io::{self, Write as _};
use std::path::Path;

use snowblue_database::file::write_atomically;

use super::failure::{Failure, Outcome};

/// Checks that a file can be written at a path.
pub(crate) fn check_path(path: &Path) -> Outcome {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if path.is_dir() || folder.is_some_and(|folder| !folder.is_dir()) {
        let name = path.display();
        return Err(Failure::Input(format!("{name}: it is a folder, or its folder does not exist")));
    }
    Ok(())
}

/// Checks that a file has this extension and can be written; `what` names its content.
pub(crate) fn check_extension(path: &Path, extension: &str, what: &str) -> Outcome {
    if path.extension().is_none_or(|found| !found.eq_ignore_ascii_case(extension)) {
        return Err(Failure::Input(format!("{}: {what} must end in .{extension}", path.display())));
    }
    check_path(path)
}

/// Checks that a NetCDF table can be written at a path.
pub(crate) fn check_table_path(path: &Path) -> Outcome {
    check_extension(path, "nc", "the table")
}

/// Writes a file completely or not at all.
pub(crate) fn write_file(path: &Path, contents: &[u8]) -> Outcome {
    let failed = |error: io::Error| Failure::Work(format!("{}: cannot be written: {error}", path.display()));
    write_atomically(path, |file| file.write_all(contents)).map_err(failed)
}
