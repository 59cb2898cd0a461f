//! Light at depth in layers of snow.

use serde::{Deserialize, Serialize};
use snowblue_transport::ordinates::solve_stack_without_errors;
use snowblue_transport::stack::{DepthFluxes, Stack, StackRadiometry};
use wasm_bindgen::prelude::*;

use crate::sample::Sample;
use crate::text;

/// Fluxes over the incident flux at one wavelength, for each depth.
#[derive(Debug, Serialize)]
struct Profile {
    wavelength_nm: f64,
    down: Vec<f64>,
    up: Vec<f64>,
    fluence: Vec<f64>,
    /// E-folding depth of the snow below each depth, in cm.
    e_folding_depth_cm: Vec<f64>,
}

/// Solves for the light at depths, at each wavelength: JSON in and out. The numbers equal the output of `snowblue
/// spectrum --layers FILE --depths`.
///
/// # Errors
///
/// With the error message of the command, if a parameter is unknown or out of range.
#[wasm_bindgen]
pub fn light_at_depth(request: &str) -> Result<String, JsError> {
    answer(request).map_err(|reason| JsError::new(&reason))
}

/// As [`light_at_depth`], with the error as text.
///
/// # Errors
///
/// As [`light_at_depth`].
pub fn answer(request: &str) -> Result<String, String> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Request {
        sample: Sample,
        depths_cm: Vec<f64>,
        wavelengths_nm: Vec<f64>,
    }
    let Request { sample, depths_cm, wavelengths_nm } = serde_json::from_str(request).map_err(text)?;
    let stack = Stack { depths_cm, wavelengths_nm, ..sample.stack()? };
    let rows = solve_stack_without_errors(&stack, &sample.options()).map_err(text)?;
    serde_json::to_string(&rows.iter().map(profile).collect::<Vec<_>>()).map_err(text)
}

fn profile(row: &StackRadiometry) -> Profile {
    let values = |of: fn(&DepthFluxes) -> f64| row.profile.iter().map(of).collect();
    Profile {
        wavelength_nm: row.whole.wavelength_nm,
        down: values(|at| at.down.value),
        up: values(|at| at.up.value),
        fluence: values(|at| at.fluence.value),
        e_folding_depth_cm: values(|at| at.e_folding_depth_cm.value),
    }
}
