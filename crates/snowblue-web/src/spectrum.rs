//! The spectrum of a slab or of layers on a ground, and its colours.

use serde::{Deserialize, Serialize};
use snowblue_color::exposure::{AutoExposure, factor};
use snowblue_color::{Colorimeter, Illuminant, Lab, LinearRgb, Observer, THREE_SAMPLES_NM};
use snowblue_transport::optics::Wavelengths;
use snowblue_transport::slab::{Estimate, Radiometry};
use wasm_bindgen::prelude::*;

use crate::sample::{Curves, Sample};
use crate::text;

/// A request for the spectrum and the colours of a sample.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Request {
    sample: Sample,
    illuminant: String,
    observer: String,
    exposure: Exposure,
    #[serde(default)]
    standard_errors: bool,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Exposure {
    Stops(f64),
    Word(String),
}

/// The spectrum and its colours.
#[derive(Debug, Serialize)]
struct Answer {
    #[serde(flatten)]
    curves: Curves,
    #[serde(skip_serializing_if = "Option::is_none")]
    reflectance_se: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    transmittance_se: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    absorptance_se: Option<Vec<f64>>,
    transmitted: Color,
    reflected: Color,
    transmitted_3: Color,
    /// ΔE*ab of both transmitted colours.
    transmitted_3_delta_e: f64,
}

/// A colour in several spaces; `hex` has an exposure.
#[derive(Debug, Serialize)]
struct Color {
    xyz: [f64; 3],
    lab: [f64; 3],
    linear_rgb: [f64; 3],
    hex: String,
}

/// Solves for a spectrum by discrete ordinates: JSON in and out.
///
/// # Errors
///
/// With the error message of the command, if a parameter is unknown or out of range.
#[wasm_bindgen]
pub fn spectrum(request: &str) -> Result<String, JsError> {
    answer(request).map_err(|reason| JsError::new(&reason))
}

/// As [`spectrum`], with the error as text.
///
/// # Errors
///
/// As [`spectrum`].
pub fn answer(request: &str) -> Result<String, String> {
    let request: Request = serde_json::from_str(request).map_err(text)?;
    serde_json::to_string(&request.answer()?).map_err(text)
}

/// ΔE*ab of two colours: JSON of a list of two lists of L\*, a\* and b\*.
///
/// # Errors
///
/// If the JSON is something else.
#[wasm_bindgen]
pub fn delta_e(colors: &str) -> Result<f64, JsError> {
    let [one, other]: [[f64; 3]; 2] = serde_json::from_str(colors)?;
    Ok(difference(one, other))
}

fn difference(one: [f64; 3], other: [f64; 3]) -> f64 {
    let [one, other] = [one, other].map(|[l, a, b]| Lab { l, a, b });
    one.delta_e_1976(other)
}

impl Request {
    fn answer(&self) -> Result<Answer, String> {
        let illuminant: Illuminant = self.illuminant.parse().map_err(text)?;
        let observer: Observer = self.observer.parse().map_err(text)?;
        let Wavelengths(wavelengths_nm) = Wavelengths::visible();
        let all = wavelengths_nm.iter().copied().chain(THREE_SAMPLES_NM).collect();
        let rows = self.sample.rows(all, self.standard_errors)?;
        let (rows, three) = rows.split_at(wavelengths_nm.len());
        let of_31 = Colorimeter::new(observer, illuminant, &wavelengths_nm).map_err(text)?;
        let of_3 = Colorimeter::new(observer, illuminant, &THREE_SAMPLES_NM).map_err(text)?;
        let errors = |of: fn(&Radiometry) -> Estimate| -> Option<Vec<f64>> {
            self.standard_errors.then(|| rows.iter().map(|row| of(row).standard_error).collect())
        };
        let curves = Curves::of(rows);
        let color = |colorimeter: &Colorimeter, values: &[f64]| self.color(colorimeter, values);
        let transmitted = color(&of_31, &curves.transmittance)?;
        let transmitted_3 = color(&of_3, &Curves::of(three).transmittance)?;
        Ok(Answer {
            transmitted_3_delta_e: difference(transmitted.lab, transmitted_3.lab),
            transmitted,
            reflected: color(&of_31, &curves.reflectance)?,
            transmitted_3,
            curves,
            reflectance_se: errors(|row| row.fluxes.reflectance),
            transmittance_se: errors(|row| row.fluxes.transmittance),
            absorptance_se: errors(|row| row.fluxes.absorptance),
        })
    }

    fn color(&self, colorimeter: &Colorimeter, values: &[f64]) -> Result<Color, String> {
        let xyz = colorimeter.xyz(values);
        let lab = Lab::from_xyz(xyz, colorimeter.white());
        let rgb = LinearRgb::from_xyz(xyz);
        let factor = match &self.exposure {
            Exposure::Stops(stops) => factor(*stops),
            Exposure::Word(word) if word == "auto" => AutoExposure::OF_COLORS.factor([rgb]),
            Exposure::Word(word) => return Err(format!("'{word}' is neither a number of stops nor 'auto'")),
        };
        Ok(Color {
            xyz: [xyz.x, xyz.y, xyz.z],
            lab: [lab.l, lab.a, lab.b],
            linear_rgb: [rgb.r, rgb.g, rgb.b],
            hex: (rgb * factor).display_hex(),
        })
    }
}
