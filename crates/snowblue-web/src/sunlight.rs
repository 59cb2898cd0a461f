//! The spectrum of snow over all wavelengths of the model, and its means over bands of sunlight.

use serde::Serialize;
use snowblue_transport::slab::Fluxes;
use snowblue_transport::sunlight::{
    Band, BandWeights, SPECTRUM, irradiance_w_m2, photon_flux_umol_m2_s, wavelengths_nm,
};
use wasm_bindgen::prelude::*;

use crate::sample::{Curves, Sample};
use crate::text;

/// The solar spectrum of a sample, without standard errors.
#[derive(Debug, Serialize)]
struct Answer {
    #[serde(flatten)]
    curves: Curves,
    /// All of [`Band::ALL`].
    bands: Vec<Mean>,
}

/// Means over a band.
#[derive(Debug, Serialize)]
struct Mean {
    name: &'static str,
    first_nm: f64,
    last_nm: f64,
    /// Irradiance of the sun in W/m²; for PAR its photon flux in µmol m⁻² s⁻¹.
    full_sun: f64,
    unit: &'static str,
    reflectance: f64,
    transmittance: f64,
    absorptance: f64,
}

/// The name of the spectrum of sunlight.
#[wasm_bindgen]
#[must_use]
pub fn sunlight_name() -> String {
    SPECTRUM.to_owned()
}

/// Solves for the spectrum every 10 nm, as far as the table of ice reaches, and its means over the bands of `snowblue
/// spectrum --broadband`: JSON in and out.
///
/// # Errors
///
/// With the error message of the command, if a parameter is unknown or out of range.
#[wasm_bindgen]
pub fn sunlight(sample: &str) -> Result<String, JsError> {
    answer(sample).map_err(|reason| JsError::new(&reason))
}

/// As [`sunlight`], with the error as text.
///
/// # Errors
///
/// As [`sunlight`].
pub fn answer(sample: &str) -> Result<String, String> {
    let sample: Sample = serde_json::from_str(sample).map_err(text)?;
    let wavelengths_nm = wavelengths_nm(sample.wavelength_range()?);
    let rows = sample.rows(wavelengths_nm.clone(), false)?;
    let fluxes: Vec<Fluxes> = rows.iter().map(|row| row.fluxes).collect();
    let mean = |band: Band| {
        let weights = BandWeights::new(band, &wavelengths_nm).map_err(text)?;
        let (mean, range) = (weights.broadband(&fluxes), band.wavelength_range());
        let (full_sun, unit) = match band {
            Band::Par => (photon_flux_umol_m2_s(range), "µmol m⁻² s⁻¹"),
            Band::Solar | Band::Visible | Band::NearInfrared => (irradiance_w_m2(range), "W/m²"),
        };
        Ok(Mean {
            name: band.name(),
            first_nm: range.first_nm,
            last_nm: range.last_nm,
            full_sun,
            unit,
            reflectance: mean.reflectance.value,
            transmittance: mean.transmittance.value,
            absorptance: mean.absorptance.value,
        })
    };
    let bands = Band::ALL.into_iter().map(mean).collect::<Result<_, String>>()?;
    serde_json::to_string(&Answer { curves: Curves::of(&rows), bands }).map_err(text)
}
