//! A date and a time of day with its offset from UTC.

use std::str::FromStr;

use crate::error::{SkyError, check};

/// Years for which the position of the sun has its stated accuracy.
const YEAR_RANGE: (f64, f64) = (1800.0, 2200.0);

/// A moment: a date of the Gregorian calendar, the time on a clock, and how far that clock is ahead of UTC.
///
/// Parses from ISO 8601. Seconds may be left out and may have a fraction.
/// ```
/// # use snowblue_sky::DateTime;
/// let noon: DateTime = "2026-02-01T12:00:00+01:00".parse()?;
/// assert_eq!(noon, DateTime { year: 2026, month: 2, day: 1, hours: 12.0, utc_offset_h: 1.0 });
/// // A clock in Greenwich shows 11 o'clock at that moment.
/// assert_eq!(noon.julian_day()?, "2026-02-01 11:00Z".parse::<DateTime>()?.julian_day()?);
/// # Ok::<(), snowblue_sky::SkyError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DateTime {
    /// Year, 1800–2200.
    pub year: i32,
    /// Month, 1–12.
    pub month: u32,
    /// Day of the month, from 1.
    pub day: u32,
    /// Hours since midnight on the clock, 0–24: noon is 12.
    pub hours: f64,
    /// Hours by which the clock is ahead of UTC, −14 to 14: 1 in Central Europe in winter.
    pub utc_offset_h: f64,
}

impl DateTime {
    /// The Julian day: days since noon of 1 January −4712, in universal time (Meeus 1998, equation 7.1).
    ///
    /// ```
    /// # use snowblue_sky::DateTime;
    /// let epoch: DateTime = "2000-01-01T12:00Z".parse()?;
    /// assert_eq!(epoch.julian_day()?, 2_451_545.0);
    /// # Ok::<(), snowblue_sky::SkyError>(())
    /// ```
    ///
    /// # Errors
    /// [`SkyError::OutOfRange`] or [`SkyError::NoSuchDay`] if a part of the date or time lies outside its range.
    pub fn julian_day(self) -> Result<f64, SkyError> {
        self.check()?;
        // January and February count as months 13 and 14 of the year before.
        let (year, month) = if self.month <= 2 { (self.year - 1, self.month + 12) } else { (self.year, self.month) };
        let century = (f64::from(year) / 100.0).floor();
        let gregorian = 2.0 - century + (century / 4.0).floor();
        let years = (365.25 * (f64::from(year) + 4716.0)).floor();
        let months = (30.6001 * (f64::from(month) + 1.0)).floor();
        let midnight = years + months + f64::from(self.day) + gregorian - 1524.5;
        Ok(midnight + (self.hours - self.utc_offset_h) / 24.0)
    }

    fn check(self) -> Result<(), SkyError> {
        let Self { year, month, day, hours, utc_offset_h } = self;
        check("year", f64::from(year), YEAR_RANGE, "")?;
        check("month", f64::from(month), (1.0, 12.0), "")?;
        let days = days_of_month(year, month);
        if day == 0 || day > days {
            return Err(SkyError::NoSuchDay { year, month, day, days });
        }
        check("time of day", hours, (0.0, 24.0), " h")?;
        check("offset from UTC", utc_offset_h, (-14.0, 14.0), " h")
    }
}

/// The middles of 96 quarters of an hour of a date, by the mean solar time of a longitude.
///
/// ```
/// # use snowblue_sky::times_of_day;
/// let day = times_of_day("2026-02-01", 11.39)?;
/// // The sun is highest near noon of solar time.
/// assert!(day.len() == 96 && day[48].hours > 12.0 && day[47].hours < 12.0);
/// # Ok::<(), snowblue_sky::SkyError>(())
/// ```
///
/// # Errors
/// [`SkyError::InvalidTime`] if the text is not a date such as 2026-02-01, and the errors of
/// [`DateTime::julian_day`].
pub fn times_of_day(date: &str, longitude_deg: f64) -> Result<Vec<DateTime>, SkyError> {
    check("longitude", longitude_deg, (-180.0, 180.0), "°")?;
    let midnight: DateTime = format!("{date}T00:00Z").parse().map_err(|error| match error {
        SkyError::InvalidTime { .. } => SkyError::InvalidTime { text: date.to_owned() },
        other => other,
    })?;
    let quarter = |quarter: u32| DateTime {
        hours: 0.25 * (f64::from(quarter) + 0.5),
        utc_offset_h: longitude_deg / 15.0,
        ..midnight
    };
    Ok((0..96).map(quarter).collect())
}

impl FromStr for DateTime {
    type Err = SkyError;

    fn from_str(text: &str) -> Result<Self, SkyError> {
        let time = parse(text).ok_or_else(|| SkyError::InvalidTime { text: text.to_owned() })?;
        time.check()?;
        Ok(time)
    }
}

/// Date, time and offset, which may be out of range; `None` if the text has another form.
fn parse(text: &str) -> Option<DateTime> {
    let (date, time) = text.split_once(['T', 't', ' '])?;
    let mut date = date.split('-');
    let (year, month, day) = (date.next()?, date.next()?, date.next()?);
    if date.next().is_some() || year.len() != 4 {
        return None;
    }
    let (clock, utc_offset_h) = match time.strip_suffix(['Z', 'z']) {
        Some(clock) => (clock, 0.0),
        None => {
            let (clock, offset) = time.split_at(time.rfind(['+', '-'])?);
            let sign = if offset.starts_with('-') { -1.0 } else { 1.0 };
            (clock, sign * clock_hours(&offset[1..])?)
        }
    };
    let (month, day) = (two_digits(month)?, two_digits(day)?);
    Some(DateTime { year: year.parse().ok()?, month, day, hours: clock_hours(clock)?, utc_offset_h })
}

/// Hours of `hh:mm` or `hh:mm:ss`, where the seconds may have a fraction.
fn clock_hours(clock: &str) -> Option<f64> {
    let mut fields = clock.split(':');
    let (hours, minutes) = (two_digits(fields.next()?)?, two_digits(fields.next()?)?);
    let seconds = match fields.next() {
        Some(seconds) if seconds.starts_with(|digit: char| digit.is_ascii_digit()) => seconds.parse().ok()?,
        Some(_) => return None,
        None => 0.0,
    };
    let whole = fields.next().is_none() && minutes < 60 && (0.0..60.0).contains(&seconds);
    whole.then(|| f64::from(hours) + (f64::from(minutes) + seconds / 60.0) / 60.0)
}

fn two_digits(text: &str) -> Option<u32> {
    let digits = text.len() == 2 && text.bytes().all(|byte| byte.is_ascii_digit());
    text.parse().ok().filter(|_| digits)
}

fn days_of_month(year: i32, month: u32) -> u32 {
    match month {
        2 if year % 4 == 0 && (year % 100 != 0 || year % 400 == 0) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "sums without rounding")]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        text.parse::<DateTime>().unwrap_err().to_string()
    }

    /// Meeus 1998, chapter 7, the table on page 62.
    #[test]
    fn julian_days_in_print() {
        let printed = [
            ("2000-01-01T12:00Z", 2_451_545.0),
            ("1999-01-01T00:00Z", 2_451_179.5),
            ("1987-01-27T00:00Z", 2_446_822.5),
            ("1987-06-19T12:00Z", 2_446_966.0),
            ("1988-01-27T00:00Z", 2_447_187.5),
            ("1988-06-19T12:00Z", 2_447_332.0),
            ("1900-01-01T00:00Z", 2_415_020.5),
        ];
        for (text, julian_day) in printed {
            assert_eq!(text.parse::<DateTime>().unwrap().julian_day(), Ok(julian_day), "{text}");
        }
    }

    #[test]
    fn offsets_and_fractions_are_read() {
        let time = |text: &str| text.parse::<DateTime>().unwrap();
        assert_eq!(time("2003-10-17T12:30:30-07:00").hours, 12.0 + 30.5 / 60.0);
        assert_eq!(time("2003-10-17T12:30:30-07:00").utc_offset_h, -7.0);
        assert_eq!(time("2003-10-17 12:30:00.9+05:45").utc_offset_h, 5.75);
        assert!((time("2003-10-17 12:30:00.9+05:45").hours - (12.5 + 0.9 / 3600.0)).abs() < 1e-12);
        assert_eq!(time("2024-02-29t24:00z").hours, 24.0);
    }

    #[test]
    fn bad_times_are_refused_in_one_line() {
        for text in [
            "noon",
            "2026-02-01",
            "2026-02-01T12:00",
            "2026-02-01T12+01:00",
            "2026-2-1T12:00Z",
            "26-02-01T12:00Z",
            "2026-02-01T12:60Z",
            "2026-02-01T12:00:60Z",
            "2026-02-01T12:00:-1Z",
            "2026-02-01T12:00:00:00Z",
            "2026-02-01T12:00+1",
            "2026-02-01-01T12:00Z",
        ] {
            assert!(error(text).starts_with(&format!("time is `{text}`, but must be a date, a time and ")), "{text}");
        }
        assert_eq!(error("2026-13-01T12:00Z"), "month is 13, but must lie in 1–12");
        assert_eq!(error("2026-02-29T12:00Z"), "day is 29, but month 2 of the year 2026 has 28 days");
        assert_eq!(error("1900-02-29T12:00Z"), "day is 29, but month 2 of the year 1900 has 28 days");
        assert_eq!(error("2026-04-00T12:00Z"), "day is 0, but month 4 of the year 2026 has 30 days");
        assert_eq!(error("1700-04-01T12:00Z"), "year is 1700, but must lie in 1800–2200");
        assert_eq!(error("2026-02-01T25:00Z"), "time of day is 25 h, but must lie in 0–24 h");
        assert_eq!(error("2026-02-01T12:00+15:00"), "offset from UTC is 15 h, but must lie in -14–14 h");
    }
}
