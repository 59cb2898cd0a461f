//! Spectra from files of `wavelength_nm,value` rows, which straight lines join: light of lamps, reflectances of paints.

use std::path::PathBuf;

use crate::error::RenderError;
use crate::files::SceneFile;
use crate::spectrum::SAMPLES;

/// The rows of a file.
#[derive(Debug)]
pub(crate) struct SpectrumFile {
    path: PathBuf,
    /// Wavelengths in nm, ascending, with their values.
    rows: Vec<(f64, f64)>,
    last_line: usize,
}

impl SpectrumFile {
    /// Parses a file with or without a header whose values lie in 0 to `greatest`. Every error names the line.
    pub(crate) fn parse(file: &SceneFile, greatest: f64) -> Result<Self, RenderError> {
        let text = file.text();
        let mut file = Self { path: file.path.clone(), rows: Vec::new(), last_line: 1 };
        for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
            let is_header = index == 0 && line.starts_with(|first: char| first.is_ascii_alphabetic());
            if is_header || line.trim().is_empty() {
                continue;
            }
            file.last_line = index + 1;
            let (nm, value) = parse_row(line).map_err(|reason| file.refused(reason))?;
            if value > greatest {
                return Err(file.refused(format!("value is {value}, but must lie in 0–{greatest}")));
            }
            if let Some((before_nm, _)) = file.rows.last().filter(|(before_nm, _)| *before_nm >= nm) {
                let reason = format!("wavelength is {nm} nm, but must lie above {before_nm} nm, the one before");
                return Err(file.refused(reason));
            }
            file.rows.push((nm, value));
        }
        Ok(file)
    }

    /// The values at ascending wavelengths, which the file must cover.
    pub(crate) fn sampled(&self, wavelengths_nm: &[f64; SAMPLES]) -> Result<[f64; SAMPLES], RenderError> {
        let (first_nm, last_nm) = (wavelengths_nm[0], wavelengths_nm[SAMPLES - 1]);
        // Sums of steps may end an unnoticeable part of a nanometre beyond.
        const SAME_NM: f64 = 1e-9;
        let range = self.rows.first().zip(self.rows.last()).map(|(first, last)| (first.0, last.0));
        let covers = |&(low_nm, high_nm): &(f64, f64)| low_nm <= first_nm + SAME_NM && high_nm >= last_nm - SAME_NM;
        let Some((low_nm, high_nm)) = range.filter(covers) else {
            let found = range.map_or("none".into(), |(low_nm, high_nm)| format!("{low_nm}–{high_nm} nm"));
            let reason = format!("wavelengths are {found}, but must cover {first_nm:.0}–{last_nm:.0} nm");
            return Err(self.refused(reason));
        };
        Ok(wavelengths_nm.map(|nm| between(&self.rows, nm.clamp(low_nm, high_nm))))
    }

    /// A complaint about the line that was read last.
    pub(crate) fn refused(&self, reason: String) -> RenderError {
        RenderError::Spectrum { path: self.path.clone(), line: self.last_line, reason }
    }
}

fn parse_row(line: &str) -> Result<(f64, f64), String> {
    let fields: Vec<Option<f64>> = line.split(',').map(|field| field.trim().parse().ok()).collect();
    match fields[..] {
        [Some(nm), Some(value)] if f64::is_finite(nm) && f64::is_finite(value) && value >= 0.0 => Ok((nm, value)),
        _ => Err(format!("expected a wavelength in nm and a value of 0 or more, but found `{line}`")),
    }
}

/// The value at a wavelength within the rows, on the straight line between its neighbours.
fn between(rows: &[(f64, f64)], nm: f64) -> f64 {
    let above = rows.partition_point(|row| row.0 <= nm).clamp(1, rows.len() - 1);
    let ((low_nm, low), (high_nm, high)) = (rows[above - 1], rows[above]);
    low + (high - low) * (nm - low_nm) / (high_nm - low_nm)
}
