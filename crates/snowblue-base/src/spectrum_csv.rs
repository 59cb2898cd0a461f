//! Spectra as comma-separated values that people write: two columns, or the output of `snowblue spectrum`.

use thiserror::Error;

use crate::ParameterRange;
use crate::csv_text::{cells, rows, separator_hint};

/// Greatest value of a spectrum, in any unit. Sums over a spectrum are far below the greatest number.
pub const MAX_VALUE: f64 = 1e30;

/// Greatest number of characters of a line that a message repeats.
const MAX_SHOWN: usize = 80;

/// A spectrum of a text.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SpectrumRows {
    /// Thickness in cm and angle in degrees as they are written; empty if the text has no such column.
    pub slab: [String; 2],
    /// Ascending wavelengths, in nm.
    pub wavelengths_nm: Vec<f64>,
    /// The value at each wavelength.
    pub values: Vec<f64>,
    /// The line of the text on which it starts, from 1.
    pub line: usize,
}

/// An error of a text without a spectrum. The interface prepends the name of the file to the message: `file:LINE: `
/// if the line is known, else `file: `.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{reason}")]
pub struct SpectrumError {
    /// The line, from 1.
    pub line: Option<usize>,
    /// Description of the error.
    pub reason: String,
}

/// Indices of the columns.
struct Columns {
    count: usize,
    slab: [Option<usize>; 2],
    wavelength: usize,
    value: usize,
    /// The range of values.
    range: ParameterRange,
}

/// A parsed row.
struct Row {
    slab: [String; 2],
    wavelength_nm: f64,
    value: f64,
}

/// Reads the spectra of a text: rows of `wavelength_nm,value`, with or without a header, or rows under a header with
/// the columns `wavelength_nm` and `quantity`. Two columns hold one spectrum. In more columns a new spectrum starts
/// where thickness or angle change, or where the wavelength does not ascend.
///
/// ```
/// use snowblue_base::spectrum_csv::read;
///
/// let spectra = read("wavelength_nm,albedo\n400,0.97\n1030,0.61\n", "reflectance")?;
/// assert_eq!(spectra[0].values, [0.97, 0.61]);
/// let error = read("400,0.97\n400;0.61\n", "reflectance").unwrap_err();
/// assert_eq!(error.line, Some(2));
/// # Ok::<(), snowblue_base::spectrum_csv::SpectrumError>(())
/// ```
///
/// # Errors
/// Names the first line that is not a row of numbers, whose value does not lie in 0 to [`MAX_VALUE`], or, with two
/// columns, whose wavelength does not ascend. If the text holds no spectrum, the error says so.
pub fn read(text: &str, quantity: &'static str) -> Result<Vec<SpectrumRows>, SpectrumError> {
    let range = ParameterRange { quantity, least: 0.0, greatest: MAX_VALUE, unit: "" };
    read_within(text, quantity, range)
}

/// As [`read`], with values in another range.
///
/// # Errors
/// As [`read`].
pub fn read_within(text: &str, quantity: &str, range: ParameterRange) -> Result<Vec<SpectrumRows>, SpectrumError> {
    let mut lines = rows(text).peekable();
    let mut columns = Columns { count: 2, slab: [None, None], wavelength: 0, value: 1, range };
    // R writes a column of row names, which has no name in the header.
    let is_header = |line: &str| {
        let first = cells(line).find(|cell| !cell.is_empty());
        first.is_some_and(|cell| cell.starts_with(|c: char| c.is_alphabetic()))
    };
    if let Some((number, line)) = lines.next_if(|(_, line)| is_header(line)) {
        columns = columns.under_header(line, quantity).map_err(at(number))?;
    }
    let mut spectra: Vec<SpectrumRows> = Vec::new();
    for (number, line) in lines {
        let Row { slab, wavelength_nm, value } = columns.row(line).map_err(at(number))?;
        let last_nm = spectra.last().and_then(|spectrum| spectrum.wavelengths_nm.last());
        let ascends = last_nm.is_none_or(|last_nm| *last_nm < wavelength_nm);
        if let (2, false, Some(last_nm)) = (columns.count, ascends, last_nm) {
            let reason = format!("wavelength is {wavelength_nm} nm, but must lie above {last_nm} nm, the one before");
            return Err(at(number)(reason));
        }
        match spectra.last_mut() {
            Some(last) if ascends && last.slab == slab => {
                last.wavelengths_nm.push(wavelength_nm);
                last.values.push(value);
            }
            _ => {
                let (wavelengths_nm, values) = (vec![wavelength_nm], vec![value]);
                spectra.push(SpectrumRows { slab, wavelengths_nm, values, line: number });
            }
        }
    }
    if spectra.is_empty() {
        return Err(SpectrumError { line: None, reason: "holds no spectrum".to_owned() });
    }
    Ok(spectra)
}

/// As [`read_within`], of a text with one spectrum.
///
/// # Errors
/// As [`read`], and on the line where a second spectrum starts.
pub fn read_one(text: &str, quantity: &str, range: ParameterRange) -> Result<SpectrumRows, SpectrumError> {
    let mut spectra = read_within(text, quantity, range)?;
    match spectra.get(1) {
        None => Ok(spectra.swap_remove(0)),
        Some(second) => Err(at(second.line)("the wavelength must lie above the one before".to_owned())),
    }
}

/// The start of a line in a message.
fn shown(line: &str) -> String {
    match line.char_indices().nth(MAX_SHOWN) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line.to_owned(),
    }
}

/// An error on a line, counted from 1.
fn at(line: usize) -> impl Fn(String) -> SpectrumError {
    move |reason| SpectrumError { line: Some(line), reason }
}

impl SpectrumError {
    /// The message, after the name of the file.
    #[must_use]
    pub fn in_file(&self, name: &str) -> String {
        let Self { line, reason } = self;
        line.map_or_else(|| format!("{name}: {reason}"), |line| format!("{name}:{line}: {reason}"))
    }
}

impl Columns {
    /// Columns by their names. Two columns are wavelength and value whatever their names are.
    fn under_header(self, line: &str, quantity: &str) -> Result<Self, String> {
        let names: Vec<&str> = cells(line).collect();
        let find = |wanted: &str| names.iter().position(|name| *name == wanted);
        let (wavelength, value) = match (find("wavelength_nm"), find(quantity)) {
            (Some(wavelength), Some(value)) => (wavelength, value),
            _ if names.len() == 2 => (0, 1),
            _ => {
                let hint = separator_hint(line, names.len());
                let line = shown(line);
                return Err(format!("expected the columns wavelength_nm and {quantity}, but found '{line}'{hint}"));
            }
        };
        let slab = [find("thickness_cm"), find("angle_deg")];
        Ok(Self { count: names.len(), slab, wavelength, value, ..self })
    }

    fn row(&self, line: &str) -> Result<Row, String> {
        let fields: Vec<&str> = cells(line).collect();
        let hint = || separator_hint(line, self.count);
        let wrong = || format!("expected a wavelength in nm and a value, but found '{}'{}", shown(line), hint());
        if fields.len() != self.count {
            return Err(if self.count == 2 {
                wrong()
            } else {
                format!("expected {} fields, but found {}{}", self.count, fields.len(), hint())
            });
        }
        let number = |column: usize| fields[column].parse::<f64>().ok();
        let wavelength_nm = number(self.wavelength).filter(|wavelength_nm| wavelength_nm.is_finite());
        let (Some(wavelength_nm), Some(value)) = (wavelength_nm, number(self.value)) else {
            return Err(wrong());
        };
        self.range.check(value).map_err(|error| error.to_string())?;
        let slab = self.slab.map(|column| column.map_or_else(String::new, |column| fields[column].to_owned()));
        Ok(Row { slab, wavelength_nm, value })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spectra_start_where_the_slab_changes() {
        let text =
            "thickness_cm,angle_deg,wavelength_nm,reflectance\n1,0,400,0.5\n1,0,500,0.4\n2,0,600,0.7\n2,0,500,1\n";
        let spectra = read(text, "reflectance").unwrap();
        let values: Vec<_> = spectra.iter().map(|one| (one.line, one.slab[0].as_str(), one.values.clone())).collect();
        assert_eq!(values, [(2, "1", vec![0.5, 0.4]), (4, "2", vec![0.7]), (5, "2", vec![1.0])]);
    }

    #[test]
    fn cells_may_be_quoted() {
        let spectra = read("\"\",\"wavelength_nm\",\"albedo\"\n\"1\",400,0.9\n", "albedo").unwrap();
        assert_eq!((spectra[0].wavelengths_nm[0], spectra[0].values[0]), (400.0, 0.9));
        assert_eq!(read("\"nm\",\"r\"\n400,0.9\n", "albedo").unwrap(), read("nm,r\n400,0.9", "albedo").unwrap());
    }

    #[test]
    fn another_range_allows_values_below_0() {
        let range = ParameterRange { quantity: "albedo", least: -0.5, greatest: 1.5, unit: "" };
        let read = |text| read_within(text, "reflectance", range);
        assert_eq!(read("2500,-0.01").unwrap()[0].values, [-0.01]);
        let message = read("2500,-0.6").unwrap_err().in_file("field.csv");
        assert_eq!(message, "field.csv:1: albedo is -0.6, but must lie in -0.5–1.5");
    }

    #[test]
    fn errors_name_the_line() {
        let message = |text: &str| read(text, "reflectance").unwrap_err().in_file("field.csv");
        for (text, expected) in [
            ("", "field.csv: holds no spectrum"),
            ("nm,albedo\n", "field.csv: holds no spectrum"),
            (
                "# made by hand\n500,0.9\n400,0.9",
                "field.csv:3: wavelength is 400 nm, but must lie above 500 nm, the one before",
            ),
            ("500,0.9\n510", "field.csv:2: expected a wavelength in nm and a value, but found '510'"),
            ("500,-0.1", "field.csv:1: reflectance is -0.1, but must lie in 0–1e30"),
            ("500,1e400", "field.csv:1: reflectance is inf, but must lie in 0–1e30"),
            ("500,nan", "field.csv:1: reflectance is NaN, but must lie in 0–1e30"),
            ("1e400,0.5", "field.csv:1: expected a wavelength in nm and a value, but found '1e400,0.5'"),
            (
                "nm,sun,snow\n500,1,1",
                "field.csv:1: expected the columns wavelength_nm and reflectance, but found 'nm,sun,snow'",
            ),
            ("wavelength_nm,reflectance,error\n500,1", "field.csv:2: expected 3 fields, but found 2"),
            (
                &"é".repeat(1000),
                &format!(
                    "field.csv:1: expected the columns wavelength_nm and reflectance, but found '{}…'",
                    "é".repeat(80)
                ),
            ),
        ] {
            assert_eq!(message(text), expected);
        }
    }
}
