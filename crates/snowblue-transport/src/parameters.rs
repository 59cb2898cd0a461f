//! All parameters of snow and of the light on it, with their ranges. Every user interface checks against these
//! ranges.

use snowblue_base::{Parameter, ParameterRange, quantities};

/// Endings of keys and columns that name a unit, and the name of this unit by UDUNITS.
pub const UNITS_OF_KEYS: [(&str, &str); 8] = [
    ("_kg_m3", "kg m-3"),
    ("_m2_kg", "m2 kg-1"),
    ("_ng_g", "ng g-1"),
    ("_cm", "cm"),
    ("_nm", "nm"),
    ("_um", "um"),
    ("_deg", "degree"),
    ("_c", "degC"),
];

/// The paper of PCASnow.
const PAPER: &str = "Varsa & Baranoski 2024, doi:10.1109/MCG.2023.3307517";

/// Mean grain size, in µm, by any measure.
pub const GRAIN_SIZE: Parameter = Parameter {
    key: "grain_size_um",
    title: "Grain size",
    range: ParameterRange::new("grain size", 20.0, 5000.0, "µm"),
    default: 400.0,
    text: "Grain size",
    effect: "Coarse grains scatter less often and hold longer paths through ice, so the light gets deeper and bluer.",
    source: "Fierz et al. 2009, International Classification for Seasonal Snow on the Ground",
};

/// Specific surface area, in m²/kg. The least value belongs to grains of the greatest size, the default to rounded
/// grains.
pub const SURFACE_AREA: Parameter = Parameter {
    key: "ssa_m2_kg",
    title: "Specific surface area",
    range: ParameterRange::new("specific surface area", 1.4, 300.0, "m²/kg"),
    default: 25.0,
    text: "Specific surface area",
    effect: "It is the surface of the grains in a kilogram of snow; fine grains have more of it.",
    source: "Gallet et al. 2009, doi:10.5194/tc-3-167-2009",
};

/// Mean facetness.
pub const FACETNESS: Parameter = Parameter {
    key: "facetness",
    title: "Facetness",
    range: ParameterRange::new("facetness", 0.0, 1.0, ""),
    default: 0.3,
    text: "Facetness, the roughness of the grains",
    effect: "At 0 they are smooth; rough grains scatter more light backwards.",
    source: PAPER,
};

/// Mean Riley sphericity.
pub const SPHERICITY: Parameter = Parameter {
    key: "sphericity",
    title: "Sphericity",
    range: ParameterRange::new("sphericity", 0.5, 1.0, ""),
    default: 0.8,
    text: "Riley sphericity of the grains",
    effect: "At 1 they are spheres; less makes them elongated.",
    source: PAPER,
};

/// Density of the dry snow, in kg/m³.
pub const DENSITY: Parameter = Parameter {
    key: "density_kg_m3",
    title: "Density",
    range: ParameterRange::new("density", 10.0, 900.0, "kg/m³"),
    default: 300.0,
    text: "Density of the dry snow",
    effect: "Denser snow has more grains in the way of the light.",
    source: PAPER,
};

/// Fraction of the pore volume that water fills.
pub const WATER_SATURATION: Parameter = Parameter {
    key: "water_saturation",
    title: "Water saturation",
    range: ParameterRange::new("water saturation", 0.0, 1.0, ""),
    default: 0.0,
    text: "Fraction of the pore volume filled with water",
    effect: "In water a grain deflects light far less than in air.",
    source: "Röttgers et al. 2016, WOPP v3; Daimon & Masumura 2007, doi:10.1364/AO.46.003811; from 1225 nm Rowe et \
             al. 2020, doi:10.1029/2020JD032624",
};

/// Mass fraction of an impurity, in ng/g: up to a hundredth of the snow.
pub const MASS_FRACTION: Parameter = Parameter {
    key: "impurities_ng_g",
    title: "Impurity",
    range: ParameterRange::new("mass fraction of an impurity", 0.0, 1e7, "ng/g"),
    default: 0.0,
    text: "Mass fraction of an impurity in dry snow",
    effect: "Impurities absorb light that clean snow would transmit, blue most of all.",
    source: "Cook et al. 2020, doi:10.5194/tc-14-309-2020",
};

/// Temperature, in °C.
pub const TEMPERATURE: Parameter = Parameter {
    key: "temperature_c",
    title: "Temperature",
    range: ParameterRange::new("temperature", -60.0, 0.0, "°C"),
    default: -5.0,
    text: "Temperature",
    effect: "It changes the density of ice, and nothing else, by 1 % over the whole range.",
    source: "snowblue, chapter Snow and its grains",
};

/// Thickness of a slab or layer, in cm.
pub const THICKNESS: Parameter = Parameter {
    key: "thickness_cm",
    title: "Thickness",
    range: ParameterRange::new("thickness", 0.0, 1e5, "cm"),
    default: 15.0,
    text: "Thickness",
    effect: "Thicker snow transmits less light, and what remains is bluer.",
    source: PAPER,
};

/// Angle of a beam from the normal, in degrees.
pub const ANGLE: Parameter = Parameter {
    key: "angle_deg",
    title: "Angle of incidence",
    range: ParameterRange::new("angle", 0.0, 89.99, "°"),
    default: 0.0,
    text: "Angle of incidence from the normal",
    effect: "Oblique light is reflected more.",
    source: PAPER,
};

/// Albedo of the ground.
pub const GROUND_ALBEDO: Parameter = Parameter {
    key: "ground_albedo",
    title: "Ground albedo",
    range: ParameterRange::new("ground albedo", 0.0, 1.0, ""),
    default: 0.0,
    text: "Albedo of the ground under the snow",
    effect: "It is the fraction of light that a matt ground sends back; 0 is no ground.",
    source: "Stamnes et al. 1988, doi:10.1364/AO.27.002502",
};

/// The name in a key or column and its unit by UDUNITS, 1 for numbers without a unit.
#[must_use]
pub fn name_and_unit(key: &str) -> (&str, &'static str) {
    let found = UNITS_OF_KEYS.iter().find_map(|(ending, unit)| Some((key.strip_suffix(ending)?, *unit)));
    found.unwrap_or((key, "1"))
}

quantities! {
    /// Specific surface area, in m²/kg.
    pub SurfaceArea = SURFACE_AREA.range;
    /// Density of the dry snow, in kg/m³.
    pub Density = DENSITY.range;
    /// Fraction of the pore volume that water fills.
    pub WaterSaturation = WATER_SATURATION.range;
    /// Mass fraction of an impurity, in ng/g.
    pub MassFraction = MASS_FRACTION.range;
    /// Temperature, in °C.
    pub Temperature = TEMPERATURE.range;
}
