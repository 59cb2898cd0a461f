//! Runs the command as a shell does.

#![allow(dead_code, reason = "each test file uses a part")]

use std::path::PathBuf;
use std::process::{Command, Output};

/// Runs the command.
pub(crate) fn snowblue(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_snowblue")).args(arguments).output().unwrap()
}

/// Runs a command that must succeed, and returns its stdout.
pub(crate) fn stdout(arguments: &[&str]) -> String {
    let output = snowblue(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Runs a command that must succeed, and returns its stderr.
pub(crate) fn stderr(arguments: &[&str]) -> String {
    let output = snowblue(arguments);
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments:?}: {text}");
    text
}

/// Runs a command that must refuse its input: exit code 2, nothing on stdout, and one line on stderr that names all
/// `words`: quantity, value, range, unit, file or line.
pub(crate) fn assert_refused(arguments: &[&str], words: &[&str]) {
    let output = snowblue(arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{arguments:?}: {message}");
    assert_eq!(message.trim_end().lines().count(), 1, "{arguments:?}: {message}");
    assert_names(&message, words);
}

/// Asserts that a text contains all words.
pub(crate) fn assert_names(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "'{word}' is missing in: {text}");
    }
}

/// Width and channels of a PNG of 8 bits, row by row.
pub(crate) fn decoded(png: &[u8]) -> (usize, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut channels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut channels).unwrap();
    (reader.info().width as usize, channels)
}

/// A scene of the repository.
pub(crate) fn shipped_scene(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name)
}
