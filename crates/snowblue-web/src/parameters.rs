//! Content of the controls of the page: names, limits, texts and defaults.

use serde_json::{Map, Value, json};
use snowblue_color::exposure::MAX_STOPS;
use snowblue_color::tone::display_glsl;
use snowblue_color::{Illuminant, LinearRgb, Observer};
use snowblue_sky::{ELEVATION_RANGE_DEG, TURBIDITY_RANGE};
use snowblue_transport::optics::{IceTable, Substance, ice};
use snowblue_transport::sample::{Property, SnowSample, SnowType, TruncatedNormal, parameters as of_snow};
use snowblue_transport::{Parameter, ParameterRange};
use wasm_bindgen::prelude::*;

/// Fraction of the light of one wavelength that is shown, so that most wavelengths lie within sRGB.
const SHOWN_PART: f64 = 0.5;
const SKY_SOURCE: &str = "Hosek & Wilkie 2012, doi:10.1145/2185520.2185591";
/// Parameters that only the page has controls for.
const OF_PAGE: [Parameter; 3] = [
    Parameter {
        key: "exposure",
        title: "Exposure in stops",
        range: ParameterRange { quantity: "exposure", least: -MAX_STOPS, greatest: MAX_STOPS, unit: "stops" },
        default: 0.0,
        text: "Factor of the light before it is shown, as a power of two",
        effect: "Each stop doubles the light.",
        source: "snowblue, chapter Rendering",
    },
    Parameter {
        key: "elevation_deg",
        title: "Sun elevation",
        range: ParameterRange {
            quantity: "sun elevation",
            least: ELEVATION_RANGE_DEG.0,
            greatest: ELEVATION_RANGE_DEG.1,
            unit: "°",
        },
        default: 18.0,
        text: "Height of the sun above the horizon",
        effect: "A low sun is redder and weaker. Behind clouds it sets their strength.",
        source: SKY_SOURCE,
    },
    Parameter {
        key: "turbidity",
        title: "Turbidity",
        range: ParameterRange {
            quantity: "turbidity",
            least: TURBIDITY_RANGE.0,
            greatest: TURBIDITY_RANGE.1,
            unit: "",
        },
        default: 2.5,
        text: "Haze: 2 in very clear alpine air, 3 on a clear day, 6 on a moist one",
        effect: "Haze makes the sky whiter.",
        source: SKY_SOURCE,
    },
];

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
    let entry = |substance: Substance| {
        json!({
            "name": substance.name(),
            "text": substance.text(),
            "source": substance.source(),
            "has_sharp_peak": substance.has_sharp_peak(),
        })
    };
    json!(Substance::all().map(entry).collect::<Vec<_>>()).to_string()
}

/// The properties of snow that are numbers, without impurities, a JSON array of objects.
#[wasm_bindgen]
#[must_use]
pub fn properties() -> String {
    let plain = Property::all().filter(|property| !matches!(property, Property::Impurity(_)));
    json!(plain.map(|one| json!({ "key": one.key(), "name": one.name() })).collect::<Vec<_>>()).to_string()
}

/// Names, limits, defaults and texts of all parameters by their keys, a JSON object.
#[wasm_bindgen]
#[must_use]
pub fn parameters() -> String {
    let entry = |parameter: Parameter| {
        let Parameter { key, title, range, default, text, effect, source } = parameter;
        let ParameterRange { quantity, least, greatest, unit } = range;
        let value = json!({
            "title": title, "quantity": quantity, "least": least, "greatest": greatest, "default": default,
            "unit": unit, "text": text, "effect": effect, "source": source,
        });
        (key.to_owned(), value)
    };
    Value::from(of_snow().chain(OF_PAGE).map(entry).collect::<Map<_, _>>()).to_string()
}

/// Half-width and standard deviation of the distributions of the default snow by their keys, a JSON object.
#[wasm_bindgen]
#[must_use]
pub fn spreads() -> String {
    let SnowSample { grain_size, facetness, sphericity, .. } = SnowSample::default();
    let spread =
        |one: TruncatedNormal| json!({ "half_width": 0.5 * (one.max - one.min), "deviation": one.standard_deviation });
    let half_width = 0.5 * (grain_size.max_um - grain_size.min_um);
    json!({
        "grain_size_um": { "half_width": half_width, "deviation": 0 },
        "facetness": spread(facetness),
        "sphericity": spread(sphericity),
    })
    .to_string()
}

/// Colours of the wavelengths 400, 410, …, 700 nm for the axis of a chart, a JSON array of `#rrggbb`.
#[wasm_bindgen]
#[must_use]
pub fn wavelength_colors() -> String {
    let wavelengths_nm = (400..=700).step_by(10).map(f64::from);
    let values = wavelengths_nm.filter_map(|wavelength_nm| Observer::Cie1931.color_matching(wavelength_nm).ok());
    json!(values.map(|xyz| (LinearRgb::from_xyz(xyz) * SHOWN_PART).display_hex()).collect::<Vec<_>>()).to_string()
}

/// Clear ice, a JSON object: `density_kg_m3` at 0 °C, and `absorption_per_m` at 400, 410, …, 700 nm.
#[wasm_bindgen]
#[must_use]
pub fn ice() -> String {
    let ice = IceTable::WarrenBrandt2008;
    let absorption_per_m = (400..=700).step_by(10).map(|wavelength_nm| ice.absorption_per_m(f64::from(wavelength_nm)));
    json!({
        "density_kg_m3": ice::density_kg_m3(0.0),
        "absorption_per_m": absorption_per_m.collect::<Vec<_>>(),
    })
    .to_string()
}

/// Luminances of red, green and blue light of linear sRGB, a JSON array.
#[wasm_bindgen]
#[must_use]
pub fn luminances() -> String {
    let [r, g, b] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    json!([r, g, b].map(|[r, g, b]| LinearRgb { r, g, b }.luminance())).to_string()
}

/// The tone curve and the display of linear light as a shader.
#[wasm_bindgen]
#[must_use]
pub fn display_shader() -> String {
    display_glsl()
}
