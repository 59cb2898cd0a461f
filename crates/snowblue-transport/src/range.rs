//! Ranges of parameters and of wavelengths.

use std::ops::RangeInclusive;

use crate::TransportError;

/// The values that a parameter may take, ends included.
///
/// ```
/// use snowblue_transport::sample::DENSITY_RANGE;
///
/// let message = DENSITY_RANGE.check(1200.0).unwrap_err().to_string();
/// assert_eq!(message, "density is 1200 kg/m³, but must lie in 10–900 kg/m³");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterRange {
    /// Name of the parameter.
    pub quantity: &'static str,
    /// Least value.
    pub least: f64,
    /// Greatest value.
    pub greatest: f64,
    /// Unit of both values; empty for a ratio.
    pub unit: &'static str,
}

impl ParameterRange {
    /// Whether `value` lies in the range; not-a-number does not.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        self.inclusive().contains(&value)
    }

    /// Checks that `value` lies in the range; not-a-number does not.
    ///
    /// # Errors
    /// [`TransportError::OutOfRange`] otherwise.
    pub fn check(&self, value: f64) -> Result<(), TransportError> {
        let Self { quantity, least, greatest, unit } = *self;
        if self.contains(value) {
            Ok(())
        } else {
            Err(TransportError::OutOfRange { quantity, value, least, greatest, unit })
        }
    }

    /// Checks that both ends of an interval lie in the range and ascend.
    ///
    /// # Errors
    /// [`TransportError::OutOfRange`] or [`TransportError::Reversed`] otherwise.
    pub fn check_interval(&self, first: f64, last: f64) -> Result<(), TransportError> {
        self.check(first)?;
        self.check(last)?;
        if first <= last {
            Ok(())
        } else {
            Err(TransportError::Reversed { quantity: self.quantity, first, last, unit: self.unit })
        }
    }

    /// The range as a [`RangeInclusive`].
    #[must_use]
    pub fn inclusive(&self) -> RangeInclusive<f64> {
        self.least..=self.greatest
    }
}

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
    /// [`TransportError::OutOfRange`] otherwise.
    pub(crate) fn check(self, quantity: &'static str, wavelength_nm: f64) -> Result<(), TransportError> {
        ParameterRange { quantity, least: self.first_nm, greatest: self.last_nm, unit: "nm" }.check(wavelength_nm)
    }
}
