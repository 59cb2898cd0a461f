//! Paths to values in a description, and errors about them.

use std::fmt;

/// One step from a table or list into it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Step {
    /// To the value of a key.
    Key(String),
    /// To an item, counted from 0.
    Index(usize),
}

impl Step {
    /// The key, if the step is one.
    pub(crate) fn key(&self) -> Option<&str> {
        match self {
            Self::Key(key) => Some(key),
            Self::Index(_) => None,
        }
    }
}

/// The path to a value in a description, such as `object[3].size`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct KeyPath(Vec<Step>);

impl KeyPath {
    /// A key of the description itself.
    pub(crate) fn root(key: &str) -> Self {
        Self::default().key(key)
    }

    /// The path to a key of the table at this path.
    pub(crate) fn key(&self, key: &str) -> Self {
        self.with(Step::Key(key.to_owned()))
    }

    /// The path to an item of the list at this path.
    pub(crate) fn index(&self, index: usize) -> Self {
        self.with(Step::Index(index))
    }

    fn with(&self, step: Step) -> Self {
        Self(self.0.iter().cloned().chain([step]).collect())
    }

    /// The steps from the outermost table.
    pub fn steps(&self) -> &[Step] {
        &self.0
    }

    /// An error that says of the value what is wrong with it.
    pub(crate) fn error(&self, reason: impl fmt::Display) -> DescriptionError {
        DescriptionError { path: self.clone(), reason: reason.to_string() }
    }
}

impl fmt::Display for KeyPath {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        if self.0.is_empty() {
            return formatter.write_str("the scene");
        }
        for (number, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) if number == 0 => formatter.write_str(key)?,
                Step::Key(key) => write!(formatter, ".{key}")?,
                Step::Index(index) => write!(formatter, "[{index}]")?,
            }
        }
        Ok(())
    }
}

/// A value of a description that breaks a rule: `object[3].size is 0 m, but must lie in 0.0001 to 100000 m`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path} {reason}")]
pub struct DescriptionError {
    /// The path to the value.
    pub path: KeyPath,
    /// What is wrong, as the rest of a sentence that begins with the path.
    pub reason: String,
}
