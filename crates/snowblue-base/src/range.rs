//! Ranges of parameters, and the message about a value outside its range.

use std::fmt;
use std::ops::RangeInclusive;

/// The values that a parameter may take, ends included.
///
/// ```
/// use snowblue_base::ParameterRange;
///
/// let azimuth = ParameterRange { quantity: "azimuth", least: 0.0, greatest: 360.0, unit: "°" };
/// assert!(azimuth.check(360.0).is_ok());
/// assert_eq!(azimuth.check(400.0).unwrap_err().to_string(), "azimuth is 400°, but must lie in 0–360°");
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
    /// The values of a quantity from `least` to `greatest`, ends included.
    #[must_use]
    pub const fn new(quantity: &'static str, least: f64, greatest: f64, unit: &'static str) -> Self {
        Self { quantity, least, greatest, unit }
    }

    /// Whether `value` lies in the range; not-a-number does not.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        self.inclusive().contains(&value)
    }

    /// Checks that `value` lies in the range; not-a-number does not.
    ///
    /// # Errors
    /// [`RangeError::OutOfRange`] otherwise.
    pub fn check(&self, value: f64) -> Result<(), RangeError> {
        let Self { quantity, least, greatest, unit } = *self;
        if self.contains(value) {
            Ok(())
        } else {
            Err(RangeError::OutOfRange { quantity, value, least, greatest, unit })
        }
    }

    /// Checks that both ends of an interval lie in the range and ascend.
    ///
    /// # Errors
    /// [`RangeError::OutOfRange`] or [`RangeError::Reversed`] otherwise.
    pub fn check_interval(&self, first: f64, last: f64) -> Result<(), RangeError> {
        self.check(first)?;
        self.check(last)?;
        if first <= last {
            Ok(())
        } else {
            Err(RangeError::Reversed { quantity: self.quantity, first, last, unit: self.unit })
        }
    }

    /// The range as a [`RangeInclusive`].
    #[must_use]
    pub fn inclusive(&self) -> RangeInclusive<f64> {
        self.least..=self.greatest
    }
}

/// Formats both ends and the unit.
impl fmt::Display for ParameterRange {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let Self { least, greatest, unit, .. } = *self;
        write!(formatter, "{}–{}{}", short_number(least), short_number(greatest), unit_suffix(unit))
    }
}

/// Why a value or an interval is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RangeError {
    /// A value lies outside the range of its quantity, or is not a number.
    #[error(
        "{quantity} is {}{unit}, but must lie in {}–{}{unit}",
        short_number(*.value), short_number(*.least), short_number(*.greatest), unit = unit_suffix(.unit)
    )]
    OutOfRange {
        /// Name of the quantity.
        quantity: &'static str,
        /// Value given.
        value: f64,
        /// Least value allowed.
        least: f64,
        /// Greatest value allowed.
        greatest: f64,
        /// Unit of the values; empty for a ratio.
        unit: &'static str,
    },
    /// The ends of an interval are in the wrong order.
    #[error(
        "{quantity} has the range {first}:{last}{unit}, whose ends are in the wrong order",
        unit = unit_suffix(.unit)
    )]
    Reversed {
        /// Name of the quantity.
        quantity: &'static str,
        /// First end given.
        first: f64,
        /// Last end given.
        last: f64,
        /// Unit of the ends; empty for a ratio.
        unit: &'static str,
    },
}

impl RangeError {
    /// The message without the name of the quantity, as the rest of a sentence that begins with a key.
    #[must_use]
    pub fn after_key(&self) -> String {
        let (Self::OutOfRange { quantity, .. } | Self::Reversed { quantity, .. }) = self;
        let message = self.to_string();
        message.strip_prefix(quantity).unwrap_or(&message).trim_start().to_owned()
    }
}

/// A number in digits, or with an exponent where it would have more than fifteen digits or five leading zeros.
#[must_use]
pub fn short_number(value: f64) -> String {
    let has_digits = value.abs() < 1e15 && (value.abs() >= 1e-5 || value.abs() <= 0.0);
    if has_digits { value.to_string() } else { format!("{value:e}") }
}

/// A unit as it follows a number: `10 µm`, `45°`, `0.5`.
#[must_use]
pub fn unit_suffix(unit: &str) -> String {
    if unit.is_empty() || unit == "°" { unit.to_owned() } else { format!(" {unit}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_numbers_have_an_exponent() {
        let shown = [1200.0, -0.25, 123_456_789_012_345.0, 1e99, -1e15, 1e-5, -2e-6, 0.0, f64::NAN].map(short_number);
        assert_eq!(shown, ["1200", "-0.25", "123456789012345", "1e99", "-1e15", "0.00001", "-2e-6", "0", "NaN"]);
    }
}
