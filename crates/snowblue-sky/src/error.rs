//! Errors of this crate.

/// Why a sky or the position of the sun cannot be computed from the input.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SkyError {
    /// A value lies outside its range, or is not a number.
    #[error("{quantity} is {value}{unit}, but must lie in {least}–{greatest}{unit}")]
    OutOfRange {
        /// Name of the quantity.
        quantity: &'static str,
        /// The given value.
        value: f64,
        /// Least value.
        least: f64,
        /// Greatest value.
        greatest: f64,
        /// Unit of the three values, with the space before it; empty for a ratio.
        unit: &'static str,
    },
    /// The sun is below the horizon.
    #[error("sun elevation is {elevation_deg}°, but must lie in 0–90°: there is no model of twilight")]
    SunBelowHorizon {
        /// Elevation of the sun in degrees, rounded down to four decimals.
        elevation_deg: f64,
    },
    /// A month has fewer days.
    #[error("day is {day}, but month {month} of the year {year} has {days} days")]
    NoSuchDay {
        /// The year.
        year: i32,
        /// The month, 1–12.
        month: u32,
        /// The given day.
        day: u32,
        /// Number of days of the month.
        days: u32,
    },
    /// A file of coefficients of the clear sky differs from the file that ships with this crate.
    #[error("{file}: {reason}")]
    Coefficients {
        /// Name of the file.
        file: &'static str,
        /// Description of the error.
        reason: String,
    },
    /// A text is not a date and a time with an offset from UTC.
    #[error(
        "time is `{text}`, but must be a date, a time and its offset from UTC, such as 2026-02-01T12:00:00+01:00 or \
         2026-02-01T11:00Z"
    )]
    InvalidTime {
        /// The given text.
        text: String,
    },
}

/// Checks that a value lies in a range, ends included; not-a-number does not.
pub(crate) fn check(
    quantity: &'static str,
    value: f64,
    (least, greatest): (f64, f64),
    unit: &'static str,
) -> Result<(), SkyError> {
    if (least..=greatest).contains(&value) {
        Ok(())
    } else {
        Err(SkyError::OutOfRange { quantity, value, least, greatest, unit })
    }
}
