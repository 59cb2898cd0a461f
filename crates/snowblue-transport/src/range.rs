//! Ranges of wavelengths.

use snowblue_base::{ParameterRange, RangeError};

/// A range of wavelengths, ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WavelengthRange {
    /// First wavelength, in nm.
    pub first_nm: f64,
    /// Last wavelength, in nm.
    pub last_nm: f64,
}

impl WavelengthRange {
    /// The wavelengths from `first_nm` to `last_nm`.
    #[must_use]
    pub const fn new(first_nm: f64, last_nm: f64) -> Self {
        Self { first_nm, last_nm }
    }

    /// The wavelengths that lie in both ranges.
    #[must_use]
    pub fn intersection(self, other: Self) -> Self {
        Self { first_nm: self.first_nm.max(other.first_nm), last_nm: self.last_nm.min(other.last_nm) }
    }

    /// The least range that holds both.
    #[must_use]
    pub fn hull(self, other: Self) -> Self {
        Self { first_nm: self.first_nm.min(other.first_nm), last_nm: self.last_nm.max(other.last_nm) }
    }

    /// Whether `wavelength_nm` lies in the range.
    #[must_use]
    pub fn contains(self, wavelength_nm: f64) -> bool {
        (self.first_nm..=self.last_nm).contains(&wavelength_nm)
    }

    /// Checks that `wavelength_nm`, named `quantity` in the message, lies in the range.
    ///
    /// # Errors
    /// [`RangeError::OutOfRange`] otherwise.
    pub(crate) fn check(self, quantity: &'static str, wavelength_nm: f64) -> Result<(), RangeError> {
        ParameterRange { quantity, least: self.first_nm, greatest: self.last_nm, unit: "nm" }.check(wavelength_nm)
    }
}
