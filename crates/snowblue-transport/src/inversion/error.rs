//! Errors of the input, with their places.

use snowblue_base::RangeError;

use crate::TransportError;

/// What is wrong with the input.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{error}")]
pub struct InversionError {
    /// The spectrum that is wrong, or none where all of them are.
    pub spectrum: Option<usize>,
    /// The wavelength at which it is wrong, if there is one.
    pub wavelength: Option<usize>,
    /// What is wrong with it.
    #[source]
    pub error: TransportError,
}

impl InversionError {
    pub(super) fn at_wavelength(place: usize, error: impl Into<TransportError>) -> Self {
        Self { spectrum: None, wavelength: Some(place), error: error.into() }
    }
}

impl From<TransportError> for InversionError {
    fn from(error: TransportError) -> Self {
        Self { spectrum: None, wavelength: None, error }
    }
}

impl From<RangeError> for InversionError {
    fn from(error: RangeError) -> Self {
        TransportError::from(error).into()
    }
}
