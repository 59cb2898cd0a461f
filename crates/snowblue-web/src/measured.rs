//! Comparison of a measured curve with the computed curve.

use serde::{Deserialize, Serialize};
use snowblue_base::spectrum_csv::{self, SpectrumRows};
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
/// includes values below 0 due to noise: JSON of `{ name, text, quantity }` in, of `{ wavelengths_nm, values }` out.
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
    let spectra = spectrum_csv::read_within(&content, quantity.column(), quantity.measured().range())
        .map_err(|error| error.in_file(&name))?;
    let [SpectrumRows { wavelengths_nm, values, .. }] = &spectra[..] else {
        return Err(format!("{name}: holds {} spectra, but must hold one", spectra.len()));
    };
    let curve = Curve { wavelengths_nm: wavelengths_nm.clone(), values: values.clone() };
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
