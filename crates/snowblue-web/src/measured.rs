//! Comparison of a measured curve with the computed curve, and files of instruments as curves.

use serde::{Deserialize, Serialize};
use snowblue_base::csv_text::{cells, rows};
use snowblue_base::spectrum_csv::{self, SpectrumError, SpectrumRows};
use snowblue_transport::inversion::Quantity;
use snowblue_transport::slab::Radiometry;
use wasm_bindgen::prelude::*;

use crate::sample::Sample;
use crate::text;

/// The quantity of a measured curve: R or T.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Measures {
    Reflectance,
    Transmittance,
}

/// A measured curve.
#[derive(Debug, Serialize)]
struct Curve {
    wavelengths_nm: Vec<f64>,
    values: Vec<f64>,
    /// Sentences on what the curve is made of.
    notes: Vec<String>,
}

/// A file of an instrument as `snowblue color --spectrum` reads a spectrum: each line of the file is one line here.
struct Rewritten {
    lines: Vec<String>,
    /// The first of the lines that stand in reverse order, if wavelengths descend in the file.
    reversed_from: Option<usize>,
    notes: Vec<String>,
}

/// Difference of a measured curve from the computed curve.
#[derive(Debug, Serialize)]
struct Difference {
    /// Number of wavelengths, and the first and the last of them.
    count: usize,
    first_nm: f64,
    last_nm: f64,
    /// Root of the mean square of measured − computed, and its mean.
    root_mean_square: f64,
    mean: f64,
}

/// Reads a measured curve like `snowblue color --spectrum`, but within the range of a measured quantity, which
/// includes values below 0 due to noise: JSON of `{ name, text, quantity }` in, of `{ wavelengths_nm, values, notes }`
/// out. Columns may also be separated by tabs or semicolons, then with decimal commas; wavelengths may descend, and be
/// in µm or values in percent if the header says so; rows without a number as their value are left out.
///
/// # Errors
///
/// Names the file, and the line that cannot be read or whose value is out of range.
#[wasm_bindgen]
pub fn measured_curve(file: &str) -> Result<String, JsError> {
    curve(file).map_err(|reason| JsError::new(&reason))
}

/// As [`measured_curve`], with the error as text.
///
/// # Errors
///
/// As [`measured_curve`].
pub fn curve(file: &str) -> Result<String, String> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct File {
        name: String,
        text: String,
        quantity: Measures,
    }
    let File { name, text: content, quantity } = serde_json::from_str(file).map_err(text)?;
    let Rewritten { lines, reversed_from, notes } = Rewritten::of(&content, quantity.column());
    let in_file = |line: usize| reversed_from.map_or(line, |start| start + lines.len() + 1 - line);
    let spectra = spectrum_csv::read_within(&lines.join("\n"), quantity.column(), quantity.measured().range())
        .map_err(|error| SpectrumError { line: error.line.map(in_file), ..error }.in_file(&name))?;
    let [SpectrumRows { wavelengths_nm, values, .. }] = &spectra[..] else {
        return Err(format!("{name}: holds {} spectra, but must hold one", spectra.len()));
    };
    let curve = Curve { wavelengths_nm: wavelengths_nm.clone(), values: values.clone(), notes };
    serde_json::to_string(&curve).map_err(text)
}

/// Solves for the spectrum at the wavelengths of a measured curve within `first_nm` to `last_nm` that the tables of the
/// snow cover, and compares both: JSON in and out.
///
/// # Errors
///
/// With the error message of the command, if a parameter is unknown or out of range, or if no wavelength lies in the
/// range.
#[wasm_bindgen]
pub fn difference_from(request: &str) -> Result<String, JsError> {
    difference(request).map_err(|reason| JsError::new(&reason))
}

/// As [`difference_from`], with the error as text.
///
/// # Errors
///
/// As [`difference_from`].
pub fn difference(request: &str) -> Result<String, String> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Request {
        sample: Sample,
        quantity: Measures,
        wavelengths_nm: Vec<f64>,
        values: Vec<f64>,
        first_nm: f64,
        last_nm: f64,
    }
    let Request { sample, quantity, wavelengths_nm, values, first_nm, last_nm } =
        serde_json::from_str(request).map_err(text)?;
    let available = sample.wavelength_range()?;
    let (least_nm, greatest_nm) = (available.first_nm.max(first_nm), available.last_nm.min(last_nm));
    let (inside_nm, measured): (Vec<f64>, Vec<f64>) =
        wavelengths_nm.iter().zip(&values).filter(|(nm, _)| (least_nm..=greatest_nm).contains(*nm)).unzip();
    if inside_nm.is_empty() {
        return Err(format!("no wavelength of the measured curve lies in {least_nm}–{greatest_nm} nm"));
    }
    let rows = sample.rows(inside_nm.clone(), false)?;
    let differences: Vec<f64> = rows.iter().zip(&measured).map(|(row, value)| value - quantity.of(row)).collect();
    let count = differences.len();
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / count as f64;
    let difference = Difference {
        count,
        first_nm: inside_nm[0],
        last_nm: inside_nm[count - 1],
        root_mean_square: mean(&mut differences.iter().map(|one| one * one)).sqrt(),
        mean: mean(&mut differences.iter().copied()),
    };
    serde_json::to_string(&difference).map_err(text)
}

impl Rewritten {
    fn of(content: &str, quantity: &str) -> Self {
        let table: Vec<(usize, Vec<String>)> = rows(content).map(|(line, row)| (line - 1, cells_of(row))).collect();
        let is_row = |row: &[String]| row[0].parse::<f64>().is_ok();
        let first = table.iter().position(|(_, row)| is_row(row)).unwrap_or(table.len());
        let (above, rows) = table.split_at(first);
        let mut lines = vec![String::new(); content.lines().count()];
        let mut notes = Vec::new();
        let (mut value, mut scales) = (1, [1.0; 2]);
        if let [others @ .., (line, names)] = above {
            if !others.is_empty() {
                notes.push(format!("lines above the names of its columns, which are not read: {}", others.len()));
            }
            let columns: Vec<Column> = names.iter().map(|name| Column::named(name, quantity)).collect();
            value = columns.iter().position(|column| column.name == quantity).unwrap_or(1);
            scales = [columns.first(), columns.get(value)].map(|column| column.map_or(1.0, |column| column.scale));
            lines[*line] = columns.into_iter().map(|column| column.name).collect::<Vec<_>>().join(",");
            let units =
                [(scales[0] > 1.0, "its wavelengths are in µm"), (scales[1] < 1.0, "its values are in percent")];
            notes.extend(units.into_iter().filter(|(is_so, _)| *is_so).map(|(_, note)| note.to_owned()));
        }
        let mut missing = 0;
        for (line, row) in rows {
            if row.get(value).is_some_and(|cell| cell.is_empty() || cell.eq_ignore_ascii_case("nan")) {
                missing += 1;
                continue;
            }
            let scale = |place| {
                if place == 0 {
                    scales[0]
                } else if place == value {
                    scales[1]
                } else {
                    1.0
                }
            };
            let written = row.iter().enumerate().map(|(place, cell)| scaled(cell, scale(place)));
            lines[*line] = written.collect::<Vec<_>>().join(",");
        }
        if missing > 0 {
            notes.push(format!("rows without a value, which are left out: {missing}"));
        }
        let wavelengths: Vec<f64> = rows.iter().filter_map(|(_, row)| row[0].parse().ok()).collect();
        let descends = wavelengths.len() > 1 && wavelengths.is_sorted_by(|one, other| one > other);
        let reversed_from = rows.first().filter(|_| descends).map(|(line, _)| *line);
        if let Some(start) = reversed_from {
            lines[start..].reverse();
        }
        Self { lines, reversed_from, notes }
    }
}

/// A column by the name that [`spectrum_csv`] has for it, and the factor to its unit there.
struct Column {
    name: String,
    scale: f64,
}

impl Column {
    fn named(name: &str, quantity: &str) -> Self {
        let written = name.to_lowercase().replace('\u{3bc}', "µ");
        let (word, unit) = written.split_at(written.find(['(', '[', '%', '_', ' ', '/']).unwrap_or(written.len()));
        let unit = unit.trim_matches(|c: char| !c.is_alphanumeric() && c != '%' && c != 'µ');
        let (name, scale) = match (word, unit) {
            ("wavelength" | "lambda" | "wl", "" | "nm") | ("nm", "") => ("wavelength_nm", 1.0),
            ("wavelength" | "lambda" | "wl", "µm" | "um" | "micron" | "microns") | ("µm" | "um", "") => {
                ("wavelength_nm", 1000.0)
            }
            (word, "") if word == quantity => (quantity, 1.0),
            (word, "%" | "percent") if word == quantity => (quantity, 0.01),
            (_, "%" | "percent") => (name, 0.01),
            _ => (name, 1.0),
        };
        Self { name: name.to_owned(), scale }
    }
}

/// The cells of a row that commas separate, or else tabs or semicolons, with decimal points.
fn cells_of(row: &str) -> Vec<String> {
    let Some(separator) = [';', '\t'].into_iter().find(|separator| row.contains(*separator)) else {
        return cells(row).map(str::to_owned).collect();
    };
    let row = row.trim_end().trim_end_matches(separator);
    row.split(separator).map(|cell| cell.trim().trim_matches('"').trim().replace(',', ".")).collect()
}

/// A number times a factor, to nine decimals; as it is if the factor is 1.
fn scaled(cell: &str, scale: f64) -> String {
    match cell.parse::<f64>() {
        Ok(value) if (scale - 1.0).abs() > 0.0 => ((value * scale * 1e9).round() / 1e9).to_string(),
        _ => cell.to_owned(),
    }
}

impl Measures {
    /// The column of the quantity in a file with several columns.
    fn column(self) -> &'static str {
        match self {
            Self::Reflectance => "reflectance",
            Self::Transmittance => "transmittance",
        }
    }

    fn measured(self) -> Quantity {
        match self {
            Self::Reflectance => Quantity::Albedo,
            Self::Transmittance => Quantity::Transmittance,
        }
    }

    fn of(self, row: &Radiometry) -> f64 {
        match self {
            Self::Reflectance => row.fluxes.reflectance.value,
            Self::Transmittance => row.fluxes.transmittance.value,
        }
    }
}
