//! Standard output and standard error.

use std::fmt::Display;
use std::io::{self, Write as _};

/// Prints results to stdout. A closed pipe is not an error.
///
/// # Errors
/// If stdout cannot be written for another reason.
pub(crate) fn print(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(unprinted(&error)),
        _ => Ok(()),
    }
}

/// The error for text that stdout does not accept.
pub(crate) fn unprinted(error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("the standard output cannot be written: {error}"))
}

/// Prints notes to stderr, a line each, unless `quiet`. Notes help to read a result correctly, or say what was
/// changed.
pub(crate) fn print_notes(quiet: bool, notes: impl IntoIterator<Item = impl Display>) {
    if !quiet {
        notes.into_iter().for_each(|note| print_message(&format!("{note}\n")));
    }
}

/// Prints messages to stderr, and ignores errors: results do not depend on them.
pub(crate) fn print_message(text: &str) {
    drop(io::stderr().write_all(text.as_bytes()));
}
