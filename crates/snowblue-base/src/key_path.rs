//! Paths to values in a document, and errors about them.

use std::fmt;

/// A step from a table or list into it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Step {
    /// To the value of a key.
    Key(String),
    /// To an item, counted from 0.
    Index(usize),
}

impl Step {
    /// The key, if the step is a key.
    pub fn key(&self) -> Option<&str> {
        match self {
            Self::Key(key) => Some(key),
            Self::Index(_) => None,
        }
    }
}

/// The path to a value in a document, such as `object[3].size` or `material."old snow"`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct KeyPath(Vec<Step>);

impl KeyPath {
    /// The path to a key of the document itself.
    pub fn root(key: &str) -> Self {
        Self::default().key(key)
    }

    /// The path to a key of the table at this path.
    #[must_use]
    pub fn key(&self, key: &str) -> Self {
        self.with([Step::Key(key.to_owned())])
    }

    /// The path to an item of the list at this path.
    #[must_use]
    pub fn index(&self, index: usize) -> Self {
        self.with([Step::Index(index)])
    }

    /// The path after more steps.
    #[must_use]
    pub fn with(&self, steps: impl IntoIterator<Item = Step>) -> Self {
        Self(self.0.iter().cloned().chain(steps).collect())
    }

    /// An error about the value at this path.
    pub fn error(&self, reason: impl fmt::Display) -> KeyError {
        KeyError { path: self.clone(), reason: reason.to_string() }
    }

    /// The steps from the outermost table.
    pub fn steps(&self) -> &[Step] {
        &self.0
    }
}

impl fmt::Display for KeyPath {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        if self.0.is_empty() {
            return formatter.write_str("the document");
        }
        for (number, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) => {
                    let is_bare = !key.is_empty()
                        && key.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"_-".contains(&byte));
                    formatter.write_str(if number == 0 { "" } else { "." })?;
                    if is_bare { formatter.write_str(key)? } else { write!(formatter, "{key:?}")? }
                }
                Step::Index(index) => write!(formatter, "[{index}]")?,
            }
        }
        Ok(())
    }
}

/// A value that breaks a rule: `object[3].size is 0 m, but must lie in 0.0001 to 100000 m`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path} {reason}")]
pub struct KeyError {
    /// The path to the value.
    pub path: KeyPath,
    /// Description of the error, as the rest of a sentence that begins with the path.
    pub reason: String,
}
