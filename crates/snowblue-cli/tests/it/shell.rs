//! Runs the command as a shell does.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The scene of the README: a block of snow, lit from behind.
pub(crate) const BLOCK: &str = include_str!("../../../../scenes/block_30cm.toml");

/// Runs a command line: words separated by blanks.
pub(crate) fn snowblue(line: &str) -> Output {
    command(line).output().unwrap()
}

/// Runs a command line that must succeed, and returns its stdout.
pub(crate) fn stdout(line: &str) -> String {
    text(line, snowblue(line)).0
}

/// Runs a command line that must succeed, and returns its stderr.
pub(crate) fn stderr(line: &str) -> String {
    text(line, snowblue(line)).1
}

/// A command line that is not run yet.
pub(crate) fn command(line: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_snowblue"));
    command.args(line.split_whitespace());
    command
}

/// The stdout and the stderr of a command line that must have succeeded.
fn text(line: &str, output: Output) -> (String, String) {
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{line}: {errors}");
    (String::from_utf8(output.stdout).unwrap(), errors)
}

/// An empty folder in which commands run.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    pub(crate) fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).unwrap()
    }

    /// All files by name, without those in folders.
    pub(crate) fn files(&self) -> BTreeMap<OsString, Vec<u8>> {
        let entries = std::fs::read_dir(self.0.path()).unwrap().map(Result::unwrap);
        entries.map(|entry| (entry.file_name(), std::fs::read(entry.path()).unwrap_or_default())).collect()
    }

    /// Runs a command line.
    pub(crate) fn run(&self, line: &str) -> Output {
        command(line).current_dir(self.0.path()).output().unwrap()
    }

    /// Runs a command line that must succeed, and returns its stdout.
    pub(crate) fn stdout(&self, line: &str) -> String {
        text(line, self.run(line)).0
    }

    /// Runs a command line that must succeed, and returns its stderr.
    pub(crate) fn stderr(&self, line: &str) -> String {
        text(line, self.run(line)).1
    }

    /// Runs a command line that must be refused: exit code 2, nothing on stdout, no change of a file, and one line on
    /// stderr that names all `words`: quantity, value, range, unit, file or line.
    pub(crate) fn assert_refused(&self, line: &str, words: &[&str]) {
        let before = self.files();
        let output = self.run(line);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{line}: {message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{line}: {message}");
        assert_names(&message, words);
        assert!(self.files() == before, "{line}: files have changed");
    }
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
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name)
}
