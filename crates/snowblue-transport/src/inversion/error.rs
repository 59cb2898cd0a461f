//! Errors of the input, with their places.

use snowblue_base::RangeError;

use crate::TransportError;

/// What is wrong with the input.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{error}{}", depth_cm.map(|depth_cm| format!(", at a depth of {depth_cm} cm")).unwrap_or_default())]
pub struct InversionError {
    /// The observation that is wrong, or none where all of them are.
    pub observation: Option<usize>,
    /// The wavelength, or the band, at which it is wrong, if there is one.
    pub wavelength: Option<usize>,
    /// The depth at which it is wrong, in cm, if there is one.
    pub depth_cm: Option<f64>,
    /// What is wrong with it.
    #[source]
    pub error: Box<TransportError>,
}

impl InversionError {
    pub(super) fn at_wavelength(place: usize, error: impl Into<TransportError>) -> Self {
        Self { wavelength: Some(place), ..Self::from(error.into()) }
    }
}

impl From<TransportError> for InversionError {
    fn from(error: TransportError) -> Self {
        Self { observation: None, wavelength: None, depth_cm: None, error: Box::new(error) }
    }
}

impl From<RangeError> for InversionError {
    fn from(error: RangeError) -> Self {
        TransportError::from(error).into()
    }
}
