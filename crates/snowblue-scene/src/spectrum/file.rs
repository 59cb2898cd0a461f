//! Files of spectra: rows of `wavelength_nm,value`, linear in between. For lights and reflectances.

use std::path::PathBuf;

use snowblue_base::csv_text::{rows, separator_hint};
use snowblue_base::files::NamedFile;

use crate::error::SceneError;
use crate::spectrum::{SAMPLES, wavelengths_nm};

#[derive(Debug, Clone, Copy)]
struct Row {
    nm: f64,
    value: f64,
}

/// The rows of a file.
#[derive(Debug)]
pub(crate) struct SpectrumFile {
    path: PathBuf,
    /// By ascending wavelength.
    rows: Vec<Row>,
    last_line: usize,
}

impl SpectrumFile {
    /// Parses a file with or without a header whose values lie in 0 to `greatest`. Every error names the line.
    pub(crate) fn parse(file: &NamedFile, greatest: f64) -> Result<Self, SceneError> {
        let text = file.text();
        let mut file = Self { path: file.path.clone(), rows: Vec::new(), last_line: 1 };
        for (index, (line_number, line)) in rows(&text).enumerate() {
            if index == 0 && line.starts_with(|first: char| first.is_ascii_alphabetic()) {
                continue;
            }
            file.last_line = line_number;
            let row = parse_row(line).map_err(|reason| file.error(reason))?;
            let Row { nm, value } = row;
            if value > greatest {
                return Err(file.error(format!("value is {value:?}, but must lie in 0–{greatest:?}")));
            }
            if let Some(Row { nm: previous_nm, .. }) = file.rows.last().filter(|previous| previous.nm >= nm) {
                let reason = format!("wavelength is {nm} nm, but must lie above {previous_nm} nm, the one before");
                return Err(file.error(reason));
            }
            file.rows.push(row);
        }
        Ok(file)
    }

    /// The values at the wavelengths of a [`Spectrum`](crate::spectrum::Spectrum), which the file must cover.
    pub(crate) fn resample(&self) -> Result<[f64; SAMPLES], SceneError> {
        let wavelengths_nm = wavelengths_nm();
        let (first_nm, last_nm) = (wavelengths_nm[0], wavelengths_nm[SAMPLES - 1]);
        let range = self.rows.first().zip(self.rows.last()).map(|(first, last)| (first.nm, last.nm));
        if !range.is_some_and(|(low_nm, high_nm)| low_nm <= first_nm && high_nm >= last_nm) {
            let found = range.map_or("none".into(), |(low_nm, high_nm)| format!("{low_nm}–{high_nm} nm"));
            let reason = format!("wavelengths are {found}, but must cover {first_nm:.0}–{last_nm:.0} nm");
            return Err(self.error(reason));
        }
        Ok(wavelengths_nm.map(|nm| interpolate(&self.rows, nm)))
    }

    /// An error in the line that was read last.
    pub(crate) fn error(&self, reason: String) -> SceneError {
        SceneError::Text { path: self.path.clone(), line: self.last_line, reason }
    }
}

fn parse_row(line: &str) -> Result<Row, String> {
    let fields: Vec<Option<f64>> = line.split(',').map(|field| field.trim().parse().ok()).collect();
    match fields[..] {
        [Some(nm), Some(value)] if f64::is_finite(nm) && f64::is_finite(value) && value >= 0.0 => Ok(Row { nm, value }),
        _ => Err(format!(
            "expected a wavelength in nm and a value of 0 or more, but found `{line}`{}",
            separator_hint(line, 2)
        )),
    }
}

/// The value at a wavelength within the rows, by linear interpolation.
fn interpolate(rows: &[Row], nm: f64) -> f64 {
    let above = rows.partition_point(|row| row.nm <= nm).clamp(1, rows.len() - 1);
    let (low, high) = (rows[above - 1], rows[above]);
    low.value + (high.value - low.value) * (nm - low.nm) / (high.nm - low.nm)
}
