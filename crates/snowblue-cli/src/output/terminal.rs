//! Standard output and standard error.

use std::io::{self, Write as _};

/// Prints results to stdout. A closed pipe is not an error.
///
/// # Errors
/// If stdout cannot be written for another reason.
pub(crate) fn print(text: &str) -> io::Result<()> {
    match io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error),
        _ => Ok(()),
    }
}

/// Prints messages to stderr, and ignores errors: results do not depend on them.
pub(crate) fn print_message(text: &str) {
    drop(io::stderr().write_all(text.as_bytes()));
}
