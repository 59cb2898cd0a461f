//! Files as input: bytes by names, from a folder, from memory or from anything else that yields bytes; why a file
//! cannot be used, and how much memory it may take.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

/// Memory in bytes that a file of any length may take: a height map of 4096 × 4096, or a sky of 4096 × 2048.
const MIN_ALLOWED: f64 = (384u64 << 20) as f64;

/// Bytes in memory that each byte of a file may take: a byte of a compressed image expands to at most 1032 bytes
/// (zlib), and memory holds several forms of the image.
const ALLOWED_PER_BYTE: f64 = 4096.0;

/// Greatest memory of any file in bytes, however long it is.
const MAX_ALLOWED: f64 = (16u64 << 30) as f64;

/// Greatest number of names of which a message gives each.
pub const MAX_NAMED: usize = 3;

/// Why a file cannot be used. Every message names the file, and the line if there is one.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// It cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// Its content is not valid.
    #[error("{}: {reason}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Description of the error, and its place if known.
        reason: String,
    },
    /// A line of it is not valid.
    #[error("{}:{line}: {reason}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// Description of the error.
        reason: String,
    },
    /// It cannot be written. Afterwards no file or the previous file has its name.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
}

/// Yields the bytes of files by their names.
pub trait FileSource {
    /// The content of a file.
    ///
    /// # Errors
    ///
    /// When there is no such file ([`io::ErrorKind::NotFound`]) or it cannot be read.
    fn read(&self, name: &str) -> io::Result<Vec<u8>>;

    /// The name of a file in error messages.
    fn display_name(&self, name: &str) -> PathBuf {
        name.into()
    }
}

/// Files in a folder of the file system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FilesIn(PathBuf);

impl FilesIn {
    /// Names are relative to this folder.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self(folder.into())
    }

    /// Names are relative to the folder of this file.
    pub fn beside(file: &Path) -> Self {
        Self::new(file.parent().unwrap_or(Path::new("")))
    }
}

impl FileSource for FilesIn {
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        let path = self.display_name(name);
        // A scene from elsewhere may name a device, which would be read without end.
        if path.exists() && !path.is_file() {
            return Err(io::Error::other("it is not a file, but a folder or device"));
        }
        std::fs::read(path)
    }

    fn display_name(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

/// Files in memory, by name.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FilesInMemory(BTreeMap<String, Vec<u8>>);

impl FilesInMemory {
    /// Adds a file, or replaces the file of that name.
    pub fn insert(&mut self, name: impl Into<String>, content: impl Into<Vec<u8>>) {
        self.0.insert(name.into(), content.into());
    }
}

impl<Name: Into<String>, Content: Into<Vec<u8>>, const COUNT: usize> From<[(Name, Content); COUNT]> for FilesInMemory {
    fn from(files: [(Name, Content); COUNT]) -> Self {
        Self(files.into_iter().map(|(name, content)| (name.into(), content.into())).collect())
    }
}

impl FileSource for FilesInMemory {
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        self.0.get(name).cloned().ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "no file has this name"))
    }
}

/// A function from names to contents.
impl<Read: Fn(&str) -> io::Result<Vec<u8>>> FileSource for Read {
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        self(name)
    }
}

/// The content of a file, and its name in error messages.
#[derive(Debug)]
pub struct NamedFile {
    /// The name in error messages.
    pub path: PathBuf,
    /// The content.
    pub bytes: Vec<u8>,
}

impl NamedFile {
    /// Reads a file.
    ///
    /// # Errors
    ///
    /// [`FileError::Read`] when it cannot be read.
    pub fn read(files: &dyn FileSource, name: &str) -> Result<Self, FileError> {
        let path = files.display_name(name);
        match files.read(name) {
            Ok(bytes) => Ok(Self { path, bytes }),
            Err(source) => Err(FileError::Read { path, source }),
        }
    }

    /// The content as text, by [`decode_text`].
    pub fn text(&self) -> Cow<'_, str> {
        decode_text(&self.bytes)
    }

    /// The part of the name after its last dot, in lower case.
    pub fn extension(&self) -> String {
        extension(&self.path)
    }
}

/// Text in UTF-8, or in UTF-16 if it begins with a byte order mark of UTF-16. The text has no byte order mark, and its
/// lines end in `\n` or `\r\n`, also where the lines of the file end in `\r`. Bytes that are not text become
/// replacement characters (U+FFFD).
pub fn decode_text(bytes: &[u8]) -> Cow<'_, str> {
    let utf16 = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = bytes.chunks(2).map(|pair| pair.try_into().map_or(0xfffd, unit));
        let characters = char::decode_utf16(units).map(|read| read.unwrap_or(char::REPLACEMENT_CHARACTER));
        Cow::Owned(characters.collect::<String>())
    };
    let text = match bytes {
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] | rest => String::from_utf8_lossy(rest),
    };
    if text.contains('\n') || !text.contains('\r') { text } else { text.replace('\r', "\n").into() }
}

/// The text of a file, by [`decode_text`].
///
/// # Errors
///
/// [`FileError::Line`] when a line is not text.
pub fn checked_text(path: &Path, bytes: &[u8]) -> Result<String, FileError> {
    let text = decode_text(bytes);
    match text.lines().position(|line| line.contains(char::REPLACEMENT_CHARACTER)) {
        None => Ok(text.into_owned()),
        Some(line) => {
            let reason = "the line is not text (UTF-8, or UTF-16 with a byte order mark)".to_owned();
            Err(FileError::Line { path: path.to_owned(), line: line + 1, reason })
        }
    }
}

/// A text in one line, as a message or a name.
pub fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The first three names of a list, and the number of the others among `count`.
pub fn first_names(names: &[String], count: usize) -> String {
    let first = &names[..names.len().min(MAX_NAMED)];
    let more = count.saturating_sub(first.len());
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{more}", first.join(", "))
}

/// Refuses the formats of the feature `formats` in a build without it. The compiler then drops the code that follows.
///
/// # Errors
///
/// [`FileError::Content`] in such a build.
#[inline]
pub fn check_formats(path: &Path) -> Result<(), FileError> {
    if cfg!(feature = "formats") {
        return Ok(());
    }
    let reason = "this build reads no PLY, STL, glTF, PNG, OpenEXR, TIFF or layers of snow".to_owned();
    Err(FileError::Content { path: path.to_owned(), reason })
}

/// Refuses content that would take more memory than a file of `file_bytes` may take. Call this function before memory
/// of the size given in a header is allocated. `what` is a noun in the plural.
///
/// # Errors
///
/// The quantity, its value and the limit.
pub fn check_memory(what: &str, asked_bytes: f64, file_bytes: usize) -> Result<(), String> {
    check_expansion(what, asked_bytes, file_bytes)?;
    check_total(what, asked_bytes)
}

/// Refuses content that would take more memory than the length of a file justifies.
///
/// # Errors
///
/// As [`check_memory`].
pub fn check_expansion(what: &str, asked_bytes: f64, file_bytes: usize) -> Result<(), String> {
    let allowed = (ALLOWED_PER_BYTE * file_bytes as f64).max(MIN_ALLOWED);
    at_most(what, asked_bytes, allowed).map_err(|reason| format!("{reason} in a file of {file_bytes} bytes"))
}

/// Refuses content that would take more memory than any file may take.
///
/// # Errors
///
/// As [`check_memory`].
pub fn check_total(what: &str, asked_bytes: f64) -> Result<(), String> {
    at_most(what, asked_bytes, MAX_ALLOWED)
}

fn at_most(what: &str, asked_bytes: f64, allowed: f64) -> Result<(), String> {
    if asked_bytes <= allowed {
        return Ok(());
    }
    let mib = |bytes: f64| (bytes / f64::from(1 << 20)).ceil();
    let (asked, allowed) = (mib(asked_bytes), mib(allowed));
    Err(format!("{what} take {asked} MiB of memory, but must take at most {allowed} MiB"))
}

/// The part of a file name after its last dot, in lower case.
pub fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// The name of a file that is given relative to the folder of another file.
pub fn name_beside(file: &str, name: &str) -> String {
    Path::new(file).with_file_name(name).to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_relative_to_a_folder_and_to_other_files() {
        let files = FilesIn::beside("scenes/dragon.toml".as_ref());
        assert_eq!(files.display_name("../models/dragon.ply"), Path::new("scenes/../models/dragon.ply"));
        assert_eq!(FilesIn::beside("dragon.toml".as_ref()).display_name("a.ply"), Path::new("a.ply"));
        assert_eq!(name_beside("models/a.gltf", "a.bin"), "models/a.bin");
    }

    #[test]
    fn a_folder_or_device_is_no_file() {
        for name in ["", "/dev/zero"] {
            let message = NamedFile::read(&FilesIn::new("/"), name).unwrap_err().to_string();
            assert!(message.contains("it is not a file, but a folder or device"), "{message}");
        }
    }

    #[test]
    fn text_is_the_same_in_every_encoding() {
        let text = "Gelände\n1 2\r\n雪 \u{1f328}";
        let utf16 = |bytes: fn(u16) -> [u8; 2]| format!("\u{feff}{text}").encode_utf16().flat_map(bytes).collect();
        let files: [Vec<u8>; 4] =
            [text.into(), format!("\u{feff}{text}").into(), utf16(u16::to_le_bytes), utf16(u16::to_be_bytes)];
        for bytes in files {
            assert_eq!(decode_text(&bytes), text);
            assert_eq!(checked_text("a.toml".as_ref(), &bytes).unwrap(), text);
        }
        assert_eq!(decode_text(b"1\r2\r").lines().collect::<Vec<_>>(), ["1", "2"]);
        assert_eq!(decode_text(b""), "");
    }

    #[test]
    fn a_line_that_is_not_text_is_named() {
        // In Latin-1, ä is the byte E4. In UTF-16, an odd byte is half a character.
        for bytes in [&b"a\nGel\xe4nde"[..], b"\xff\xfea\0\n\0b"] {
            let message = checked_text("a.toml".as_ref(), bytes).unwrap_err().to_string();
            assert!(message.starts_with("a.toml:2: the line is not text"), "{message}");
        }
    }

    #[test]
    fn a_list_of_names_ends_with_the_number_of_the_others() {
        let names = ["a", "b", "c", "d"].map(str::to_owned);
        assert_eq!([first_names(&names[..3], 3), first_names(&names, 5)], ["a, b, c", "a, b, c and 2 more"]);
    }

    #[test]
    fn memory_grows_with_the_file_between_two_bounds() {
        let allows =
            |mib: u32, file_bytes: usize| check_memory("pixels", f64::from(mib) * 1048576.0, file_bytes).is_ok();
        assert!(allows(384, 0) && !allows(385, 0));
        assert!(allows(4096, 1 << 20) && !allows(4097, 1 << 20));
        assert!(allows(16_384, usize::MAX) && !allows(16_385, usize::MAX));
        let message = check_memory("2 × 3 pixels", 1e12, 619).unwrap_err();
        let expected = "2 × 3 pixels take 953675 MiB of memory, but must take at most 384 MiB in a file of 619 bytes";
        assert_eq!(message, expected);
    }

    #[test]
    fn files_in_memory_are_found_by_name() {
        let files = FilesInMemory::from([("a", [1, 2])]);
        assert_eq!(NamedFile::read(&files, "a").unwrap().bytes, [1, 2]);
        let missing = NamedFile::read(&files, "b").unwrap_err().to_string();
        assert!(missing.contains("cannot read b"), "{missing}");
    }
}
