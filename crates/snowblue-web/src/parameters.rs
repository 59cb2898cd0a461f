//! What the controls of the page offer: names, ranges and defaults.

use serde_json::json;
use snowblue_color::Illuminant;
use snowblue_transport::ParameterRange;
use snowblue_transport::optics::Substance;
use snowblue_transport::sample::{
    DENSITY_RANGE, FACETNESS_RANGE, GRAIN_SIZE_RANGE, MASS_FRACTION_RANGE, SPHERICITY_RANGE, SURFACE_AREA_RANGE,
    SnowSample, SnowType, TEMPERATURE_RANGE, WATER_SATURATION_RANGE,
};
use snowblue_transport::slab::{ANGLE_RANGE, THICKNESS_RANGE};
use snowblue_transport::stack::GROUND_ALBEDO_RANGE;
use wasm_bindgen::prelude::*;

/// The version of snowblue.
#[wasm_bindgen]
#[must_use]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

/// Names of all illuminants, a JSON array.
#[wasm_bindgen]
#[must_use]
pub fn illuminants() -> String {
    json!(Illuminant::all().map(Illuminant::name).collect::<Vec<_>>()).to_string()
}

/// The kinds of snow, a JSON array of objects.
#[wasm_bindgen]
#[must_use]
pub fn kinds() -> String {
    let kind = |kind: SnowType| {
        json!({
            "name": kind.name(),
            "ssa_m2_kg": kind.surface_area_m2_kg(),
            "density_kg_m3": kind.density_kg_m3(),
            "source": kind.source(),
        })
    };
    json!(SnowType::ALL.map(kind)).to_string()
}

/// The impurities, a JSON array of objects.
#[wasm_bindgen]
#[must_use]
pub fn impurities() -> String {
    let substance = |substance: &Substance| json!({ "name": substance.name(), "source": substance.source() });
    json!(Substance::ALL.iter().map(substance).collect::<Vec<_>>()).to_string()
}

/// Ranges and defaults of all parameters, a JSON object.
#[wasm_bindgen]
#[must_use]
pub fn ranges() -> String {
    let default = SnowSample::default();
    let range = |range: ParameterRange, default: f64| {
        let ParameterRange { least, greatest, unit, .. } = range;
        json!({ "least": least, "greatest": greatest, "default": default, "unit": unit })
    };
    json!({
        "grain_size_um": range(GRAIN_SIZE_RANGE, default.grain_size.middle_um()),
        "ssa_m2_kg": range(SURFACE_AREA_RANGE, SnowType::Rounded.surface_area_m2_kg()),
        "facetness": range(FACETNESS_RANGE, default.facetness.mean),
        "sphericity": range(SPHERICITY_RANGE, default.sphericity.mean),
        "density_kg_m3": range(DENSITY_RANGE, default.density_kg_m3),
        "water_saturation": range(WATER_SATURATION_RANGE, default.water_saturation),
        "temperature_c": range(TEMPERATURE_RANGE, default.temperature_c),
        "impurities_ng_g": range(MASS_FRACTION_RANGE, 0.0),
        "thickness_cm": range(THICKNESS_RANGE, 15.0),
        "angle_deg": range(ANGLE_RANGE, 0.0),
        "ground_albedo": range(GROUND_ALBEDO_RANGE, 0.0),
    })
    .to_string()
}
