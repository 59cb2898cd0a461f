//! Spectra from CSV files: two columns, or the output of `snowblue spectrum`.

use std::path::Path;

use snowblue_base::csv_text::{rows, separator_hint};
use snowblue_render::scene::spectrum::light_spectrum::LightSpectrum;

use super::settings_file::SettingsFile;
use crate::options::parse;
use crate::output::Failure;

const GREATEST_VALUE: f64 = LightSpectrum::GREATEST_VALUE;

/// A spectrum of the file.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Curve {
    /// Thickness in cm and angle in degrees as they are written; empty if the file has no such column.
    pub(crate) slab: [String; 2],
    pub(crate) wavelengths_nm: Vec<f64>,
    pub(crate) values: Vec<f64>,
    /// The line of the file on which it starts, from 1.
    pub(crate) line: usize,
}

/// Indices of the columns.
struct Columns {
    count: usize,
    slab: [Option<usize>; 2],
    wavelength: usize,
    value: usize,
}

/// A parsed row.
struct Row {
    slab: [String; 2],
    wavelength_nm: f64,
    value: f64,
}

/// Reads the curves of a file: rows of `wavelength_nm,value`, with or without a header, or rows under a header with the
/// columns `wavelength_nm` and `quantity`. A new curve starts where thickness or angle change, or where the wavelength
/// does not ascend.
pub(crate) fn read(path: &Path, quantity: &str) -> Result<Vec<Curve>, Failure> {
    let text = SettingsFile::read(path)?;
    let mut lines = rows(&text).peekable();
    let mut columns = Columns { count: 2, slab: [None, None], wavelength: 0, value: 1 };
    let starts_with_letter = |line: &str| line.trim_start().starts_with(|c: char| c.is_alphabetic());
    if let Some((number, line)) = lines.next_if(|(_, line)| starts_with_letter(line)) {
        columns = Columns::of_header(line, quantity).map_err(|why| failure(path, number, &why))?;
    }
    let mut curves: Vec<Curve> = Vec::new();
    for (number, line) in lines {
        let Row { slab, wavelength_nm, value } = columns.row(line).map_err(|why| failure(path, number, &why))?;
        let continues =
            |curve: &Curve| curve.slab == slab && curve.wavelengths_nm.last().is_some_and(|last| *last < wavelength_nm);
        // With two columns all rows are one curve, and descending wavelengths are an error.
        match curves.last_mut() {
            Some(last) if columns.count == 2 || continues(last) => {
                last.wavelengths_nm.push(wavelength_nm);
                last.values.push(value);
            }
            _ => {
                curves.push(Curve { slab, wavelengths_nm: vec![wavelength_nm], values: vec![value], line: number });
            }
        }
    }
    if curves.is_empty() {
        return Err(Failure::Input(format!("{}: holds no spectrum", path.display())));
    }
    Ok(curves)
}

/// An error on a line, counted from 1.
fn failure(path: &Path, line: usize, why: &str) -> Failure {
    Failure::Input(format!("{}:{line}: {why}", path.display()))
}

impl Columns {
    /// Columns by their names. Two columns are wavelength and value whatever their names are.
    fn of_header(line: &str, quantity: &str) -> Result<Self, String> {
        let names: Vec<&str> = line.split(',').map(str::trim).collect();
        let find = |wanted: &str| names.iter().position(|name| *name == wanted);
        let (wavelength, value) = match (find("wavelength_nm"), find(quantity)) {
            (Some(wavelength), Some(value)) => (wavelength, value),
            _ if names.len() == 2 => (0, 1),
            _ => {
                let hint = separator_hint(line, names.len());
                return Err(format!("expected the columns wavelength_nm and {quantity}, but found '{line}'{hint}"));
            }
        };
        Ok(Self { count: names.len(), slab: [find("thickness_cm"), find("angle_deg")], wavelength, value })
    }

    fn row(&self, line: &str) -> Result<Row, String> {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let hint = || separator_hint(line, self.count);
        let wrong = || {
            let values = format!("a wavelength in nm and a value of 0 to {GREATEST_VALUE:e}");
            format!("expected {values}, but found '{line}'{}", hint())
        };
        if fields.len() != self.count {
            return Err(if self.count == 2 {
                wrong()
            } else {
                format!("expected {} fields, but found {}{}", self.count, fields.len(), hint())
            });
        }
        let number = |column: usize| parse::number(fields[column]).ok().filter(|number| number.is_finite());
        match (number(self.wavelength), number(self.value)) {
            (Some(wavelength_nm), Some(value)) if (0.0..=GREATEST_VALUE).contains(&value) => {
                let slab = self.slab.map(|column| column.map_or_else(String::new, |column| fields[column].to_owned()));
                Ok(Row { slab, wavelength_nm, value })
            }
            _ => Err(wrong()),
        }
    }
}
