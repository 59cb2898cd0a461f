//! Parsers of option values: numbers, ranges, lists and distributions.

use std::ops::{Range, RangeInclusive};
use std::path::Path;
use std::time::Duration;

use snowblue_base::files::checked_text;
use snowblue_base::spectrum_csv::SpectrumError;
use snowblue_base::{Count, Number, ParameterRange, Quantity};
use snowblue_color::exposure::MAX_STOPS;
use snowblue_color::{Illuminant, Observer, Srgb8};
use snowblue_render::Aovs;
use snowblue_render::Exposure;
use snowblue_render::film::window::Window;
use snowblue_sky::DateTime;
use snowblue_transport::GroundAlbedo;
use snowblue_transport::optics::IceTable;
use snowblue_transport::ordinates::Streams;
use snowblue_transport::sample::{SizeMeasure, SnowType};
use snowblue_transport::slab::Incidence;

/// `5:30`, or `10` for 10 to 10.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Span {
    pub(crate) min: f64,
    pub(crate) max: f64,
}

pub(crate) fn number(word: &str) -> Result<f64, String> {
    word.trim().parse().map_err(|_| format!("'{word}' is not a number"))
}

/// Albedo of the ground: a number, or the name of a CSV file with its spectrum.
#[derive(Debug, Clone)]
pub(crate) struct GivenGround {
    pub(crate) albedo: GroundAlbedo,
    /// The number or the name of the file.
    pub(crate) word: String,
}

pub(crate) fn ground_albedo(word: &str) -> Result<GivenGround, String> {
    let albedo = match word.trim().parse::<f64>() {
        Ok(albedo) => albedo.into(),
        Err(_) if has_end(word, "csv") => csv_file(word, GroundAlbedo::read)?,
        Err(_) => return Err(format!("'{word}' is neither a number nor the name of a CSV file")),
    };
    Ok(GivenGround { albedo, word: word.trim().to_owned() })
}

/// Whether the name of a file has an ending, in any case.
pub(crate) fn has_end(file: &str, end: &str) -> bool {
    Path::new(file).extension().is_some_and(|own| own.eq_ignore_ascii_case(end))
}

/// What `read` reads in a CSV file. An error names the file and the line.
pub(crate) fn csv_file<T>(file: &str, read: impl Fn(&str) -> Result<T, SpectrumError>) -> Result<T, String> {
    let bytes = std::fs::read(file).map_err(|error| format!("{file}: cannot be read: {error}"))?;
    let text = checked_text(Path::new(file), &bytes).map_err(|error| error.to_string())?;
    read(&text).map_err(|error| error.in_file(file))
}

/// The parser of a parameter. Its errors name the parameter with its range and unit.
pub(crate) fn parameter(range: ParameterRange) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |word| {
        let number = number(word)?;
        range.check(number).map_err(|error| error.to_string())?;
        Ok(number)
    }
}

/// The parser of a whole number in a range, in plain or exponent form (1e5).
pub(crate) fn whole_number<T: TryFrom<u64>>(range: RangeInclusive<u64>) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |word| {
        let number = whole(word).filter(|number| range.contains(number)).map(T::try_from);
        match number {
            Some(Ok(number)) => Ok(number),
            _ => Err(format!("must be a whole number of {}–{}", range.start(), range.end())),
        }
    }
}

/// A number of a quantity.
pub(crate) fn quantity<Q: Quantity>(word: &str) -> Result<Number<Q>, String> {
    let number = number(word).map_err(|_| format!("must be a number of {}", Q::RANGE))?;
    Number::new(number).map_err(|error| error.to_string())
}

/// A whole number of a quantity.
pub(crate) fn count<Q: Quantity>(word: &str) -> Result<Count<Q>, String> {
    let wrong = || format!("must be a whole number of {}", Q::RANGE);
    let count = whole(word).and_then(|count| u32::try_from(count).ok()).ok_or_else(wrong)?;
    Count::new(count).map_err(|_| wrong())
}

fn whole(word: &str) -> Option<u64> {
    let plain = word.trim().parse().ok();
    plain.or_else(|| {
        let number = number(word).ok()?;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole and below 2⁵³")]
        let whole = number as u64;
        ((0.0..9e15).contains(&number) && number.fract() == 0.0).then_some(whole)
    })
}

/// The parser of a number of rays.
pub(crate) fn rays() -> impl Fn(&str) -> Result<u64, String> + Clone {
    whole_number(2..=1_000_000_000_000)
}

/// The parser of a seed of 64 bits.
pub(crate) fn seed() -> impl Fn(&str) -> Result<u64, String> + Clone {
    whole_number(0..=u64::MAX)
}

/// Numbers between colons.
pub(crate) fn numbers(words: &str) -> Result<Vec<f64>, String> {
    words.split(':').map(number).collect()
}

pub(crate) fn size_measure(word: &str) -> Result<SizeMeasure, String> {
    word.parse::<SizeMeasure>().map_err(|error| error.to_string())
}

pub(crate) fn ice(word: &str) -> Result<IceTable, String> {
    word.parse::<IceTable>().map_err(|error| error.to_string())
}

pub(crate) fn snow_type(word: &str) -> Result<SnowType, String> {
    word.parse::<SnowType>().map_err(|error| error.to_string())
}

/// `auto`, or a number of streams.
pub(crate) fn streams(word: &str) -> Result<Streams, String> {
    match word {
        "auto" => Ok(Streams::Auto),
        number => number.parse().map(Streams::Exactly).map_err(|_| format!("'{word}' is neither a number nor 'auto'")),
    }
}

pub(crate) fn incidence(word: &str) -> Result<Incidence, String> {
    word.parse::<Incidence>().map_err(|error| error.to_string())
}

pub(crate) fn span(words: &str) -> Result<Span, String> {
    match numbers(words)?[..] {
        [value] => Ok(Span { min: value, max: value }),
        [min, max] if min < max => Ok(Span { min, max }),
        [min, max] => Err(format!("the range must ascend, but {max} follows {min}")),
        _ => Err("give one value (10) or a range (5:30)".to_owned()),
    }
}

pub(crate) fn hex(word: &str) -> Result<Srgb8, String> {
    word.parse::<Srgb8>().map_err(|error| error.to_string())
}

pub(crate) fn illuminant(word: &str) -> Result<Illuminant, String> {
    word.parse::<Illuminant>().map_err(|error| error.to_string())
}

pub(crate) fn observer(word: &str) -> Result<Observer, String> {
    word.parse::<Observer>().map_err(|error| error.to_string())
}

/// `auto`, or a number of stops.
pub(crate) fn exposure(word: &str) -> Result<Exposure, String> {
    if word == "auto" {
        return Ok(Exposure::Auto);
    }
    let stops = number(word).map_err(|_| format!("'{word}' is neither a number of stops nor 'auto'"))?;
    if !(-MAX_STOPS..=MAX_STOPS).contains(&stops) {
        return Err(format!("exposure is {stops} stops, but must lie in -{MAX_STOPS} to {MAX_STOPS} stops"));
    }
    Ok(Exposure::Stops(stops))
}

/// A half-open range of whole numbers, `A:B`.
pub(crate) fn whole_range(words: &str) -> Result<Range<u32>, String> {
    range(words).ok_or_else(|| format!("'{words}' is not a range A:B of whole numbers with 0 ≤ A < B ≤ {}", u32::MAX))
}

fn range(words: &str) -> Option<Range<u32>> {
    let (start, end) = words.split_once(':')?;
    let range = start.trim().parse().ok()?..end.trim().parse().ok()?;
    (range.start < range.end).then_some(range)
}

/// A rectangle of pixels, `X0:X1,Y0:Y1`.
pub(crate) fn window(words: &str) -> Result<Window, String> {
    let example = "a rectangle is X0:X1,Y0:Y1 in pixels from the upper left, such as 500:516,300:316";
    let (columns, rows) = words.split_once(',').ok_or_else(|| format!("the rows are missing: {example}"))?;
    let side = |name: &str, letter: char, words: &str| {
        let rule = format!("whole numbers with 0 ≤ {letter}0 < {letter}1 ≤ {}", u32::MAX);
        range(words)
            .ok_or_else(|| format!("the {name} are '{words}', but must be {letter}0:{letter}1, {rule}; {example}"))
    };
    Ok(Window { columns: side("columns", 'X', columns)?, rows: side("rows", 'Y', rows)? })
}

/// Refuses a colour that is given without the name of its option.
pub(crate) fn option_of_color(word: &str) -> Result<String, String> {
    let color = format!("#{}", word.trim_start_matches('#'));
    let color = if hex(&color).is_ok() { &color } else { "#rrggbb" };
    Err(format!("a colour is given as --target '{color}'"))
}

/// Names of AOVs, separated by commas.
pub(crate) fn aovs(words: &str) -> Result<Aovs, String> {
    words.parse::<Aovs>().map_err(|error| error.to_string())
}

/// A date, a time of day and its offset from UTC.
pub(crate) fn time(words: &str) -> Result<DateTime, String> {
    words.parse::<DateTime>().map_err(|error| error.to_string())
}

/// A time in minutes.
pub(crate) fn minutes(words: &str) -> Result<Duration, String> {
    let minutes = number(words)?;
    if (0.01..=1e5).contains(&minutes) {
        Ok(Duration::from_secs_f64(60.0 * minutes))
    } else {
        Err(format!("the time is {minutes} minutes, but must lie in 0.01–100000 minutes"))
    }
}

#[cfg(test)]
mod tests {
    use snowblue_render::scene::integrator::{Bounces, NoiseTarget};

    use super::*;

    #[test]
    fn angles_are_parsed() {
        assert_eq!(incidence("diffuse").unwrap(), Incidence::Diffuse);
        assert!(incidence("steep").is_err());
    }

    #[test]
    fn numbers_lie_in_their_range() {
        let threads = whole_number::<u16>(1..=1024);
        assert_eq!([threads("1"), threads("1e3"), threads(" 1024 ")], [Ok(1), Ok(1000), Ok(1024)]);
        for wrong in ["0", "-1", "1025", "1.5", "1e400", "nan", "", "many", "99999999999999999999"] {
            assert_eq!(threads(wrong).unwrap_err(), "must be a whole number of 1–1024", "{wrong}");
        }
        assert_eq!(seed()("18446744073709551615"), Ok(u64::MAX));
        assert!(seed()("18446744073709551616").is_err() && rays()("1").is_err() && rays()("1e12").is_ok());
        let noise = quantity::<NoiseTarget>;
        assert_eq!(noise("1e-4").unwrap().get().to_bits(), 1e-4_f64.to_bits());
        for wrong in ["0", "nan", "2"] {
            let message = noise(wrong).unwrap_err();
            assert!(message.ends_with("but must lie in 0.0001–1"), "{message}");
        }
        assert_eq!(noise("1%").unwrap_err(), "must be a number of 0.0001–1");
        assert_eq!(count::<Bounces>("1e4").unwrap().get(), 10_000);
        assert_eq!(count::<Bounces>("-1").unwrap_err(), "must be a whole number of 0–10000");
    }

    #[test]
    fn rectangles_have_columns_and_rows() {
        assert_eq!(window("1:2, 0:30"), Ok(Window { columns: 1..2, rows: 0..30 }));
        for (wrong, expected) in [
            ("5", "the rows are missing: a rectangle is X0:X1,Y0:Y1"),
            ("1:2", "the rows are missing"),
            ("5:3,0:1", "the columns are '5:3', but must be X0:X1, whole numbers with 0 ≤ X0 < X1"),
            ("-1:3,0:1", "the columns are '-1:3'"),
            ("0:1,0:0", "the rows are '0:0', but must be Y0:Y1, whole numbers with 0 ≤ Y0 < Y1"),
            ("0:1,2,3:4", "the rows are '2,3:4'"),
        ] {
            let message = window(wrong).unwrap_err();
            assert!(message.starts_with(expected) && message.ends_with("such as 500:516,300:316"), "{message}");
        }
    }
}
