//! Output files: checks before long work, and atomic writes.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser};
use snowblue_base::atomic_file::{STANDARD_OUTPUT, check_writable, is_stream, write_atomically};

use super::failure::{Failure, Outcome};

/// Parses the path of an output. The path - is the standard output.
pub(crate) fn output_path() -> impl TypedValueParser<Value = PathBuf> {
    let without_dash = |path: PathBuf| if path == Path::new("-") { PathBuf::from(STANDARD_OUTPUT) } else { path };
    PathBufValueParser::new().map(without_dash)
}

/// The ending of an output's name, in lower case. A stream without an ending has the ending `stream_ending`.
pub(crate) fn ending(path: &Path, stream_ending: &str) -> String {
    let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_lowercase);
    ending.unwrap_or_else(|| if is_stream(path) { stream_ending.to_owned() } else { String::new() })
}

/// Checks that a file can be written at a path.
pub(crate) fn check_path(path: &Path) -> Outcome {
    let name = path.display();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if path.is_dir() {
        return Err(Failure::Input(format!("{name}: is a folder, but must be a file")));
    }
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        let what = if folder.exists() { "its folder is a file" } else { "its folder does not exist" };
        return Err(Failure::Input(format!("{name}: {what}")));
    }
    check_writable(path).map_err(|error| Failure::Input(format!("{name}: cannot be written: {error}")))
}

/// Creates a folder for outputs if it does not exist.
pub(crate) fn create_folder(path: &Path) -> Outcome {
    if path.is_dir() {
        return Ok(());
    }
    check_path(path)?;
    std::fs::create_dir(path).map_err(|error| Failure::Input(format!("{}: cannot be created: {error}", path.display())))
}

/// Whether two paths name one file.
pub(crate) fn is_same_file(one: &Path, other: &Path) -> bool {
    one.canonicalize().is_ok_and(|one| other.canonicalize().is_ok_and(|other| one == other))
}

/// Refuses to overwrite an input.
pub(crate) fn check_not_input(input: &Path, output: &Path) -> Outcome {
    if is_same_file(input, output) {
        return Err(Failure::Input(format!("{}: would be overwritten by the output", input.display())));
    }
    Ok(())
}

/// Checks that a file has this extension and can be written; `what` names its content.
pub(crate) fn check_extension(path: &Path, extension: &str, what: &str) -> Outcome {
    if ending(path, extension) != extension {
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
