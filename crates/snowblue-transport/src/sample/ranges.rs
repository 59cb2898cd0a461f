//! The parameters of a snow sample and their ranges. Every face checks against these.

pub use crate::optics::impurity::MASS_FRACTION_RANGE;
use snowblue_base::Parameter;
use snowblue_base::ParameterRange;

/// The paper of PCASnow.
pub(crate) const PAPER: &str = "Varsa & Baranoski 2024, doi:10.1109/MCG.2023.3307517";

/// Grain size, in µm, by any measure.
pub const GRAIN_SIZE_RANGE: ParameterRange =
    ParameterRange { quantity: "grain size", least: 20.0, greatest: 5000.0, unit: "µm" };
/// Specific surface area, in m²/kg; the least is that of grains of the greatest size.
pub const SURFACE_AREA_RANGE: ParameterRange =
    ParameterRange { quantity: "specific surface area", least: 1.4, greatest: 300.0, unit: "m²/kg" };
/// Riley sphericity.
pub const SPHERICITY_RANGE: ParameterRange =
    ParameterRange { quantity: "sphericity", least: 0.5, greatest: 1.0, unit: "" };
/// Facetness.
pub const FACETNESS_RANGE: ParameterRange =
    ParameterRange { quantity: "facetness", least: 0.0, greatest: 1.0, unit: "" };
/// Density of the dry snow, in kg/m³.
pub const DENSITY_RANGE: ParameterRange =
    ParameterRange { quantity: "density", least: 10.0, greatest: 900.0, unit: "kg/m³" };
/// Fraction of the pore volume that water fills.
pub const WATER_SATURATION_RANGE: ParameterRange =
    ParameterRange { quantity: "water saturation", least: 0.0, greatest: 1.0, unit: "" };
/// Temperature, in °C.
pub const TEMPERATURE_RANGE: ParameterRange =
    ParameterRange { quantity: "temperature", least: -60.0, greatest: 0.0, unit: "°C" };

/// Standard deviation of the sphericity before truncation.
pub(super) const SPHERICITY_DEVIATION_RANGE: ParameterRange =
    ParameterRange { quantity: "standard deviation of sphericity", least: 0.0, greatest: 10.0, unit: "" };
/// Standard deviation of the facetness before truncation.
pub(super) const FACETNESS_DEVIATION_RANGE: ParameterRange =
    ParameterRange { quantity: "standard deviation of facetness", least: 0.0, greatest: 10.0, unit: "" };

/// Mean grain size.
pub const GRAIN_SIZE: Parameter = Parameter {
    key: "grain_size_um",
    title: "Grain size",
    range: GRAIN_SIZE_RANGE,
    default: 400.0,
    text: "Grain size",
    effect: "Coarse grains scatter less often and hold longer paths through ice, so the light gets deeper and bluer.",
    source: "Fierz et al. 2009, International Classification for Seasonal Snow on the Ground",
};
/// Specific surface area; the default is that of rounded grains.
pub const SURFACE_AREA: Parameter = Parameter {
    key: "ssa_m2_kg",
    title: "Specific surface area",
    range: SURFACE_AREA_RANGE,
    default: 25.0,
    text: "Specific surface area",
    effect: "It is the surface of the grains in a kilogram of snow; fine grains have more of it.",
    source: "Gallet et al. 2009, doi:10.5194/tc-3-167-2009",
};
/// Mean facetness.
pub const FACETNESS: Parameter = Parameter {
    key: "facetness",
    title: "Facetness",
    range: FACETNESS_RANGE,
    default: 0.3,
    text: "Facetness, the roughness of the grains",
    effect: "At 0 they are smooth; rough grains scatter more light backwards.",
    source: PAPER,
};
/// Mean sphericity.
pub const SPHERICITY: Parameter = Parameter {
    key: "sphericity",
    title: "Sphericity",
    range: SPHERICITY_RANGE,
    default: 0.8,
    text: "Riley sphericity of the grains",
    effect: "At 1 they are spheres; less makes them elongated.",
    source: PAPER,
};
/// Density of the dry snow.
pub const DENSITY: Parameter = Parameter {
    key: "density_kg_m3",
    title: "Density",
    range: DENSITY_RANGE,
    default: 300.0,
    text: "Density of the dry snow",
    effect: "Denser snow has more grains in the way of the light.",
    source: PAPER,
};
/// Fraction of the pore volume that water fills.
pub const WATER_SATURATION: Parameter = Parameter {
    key: "water_saturation",
    title: "Water saturation",
    range: WATER_SATURATION_RANGE,
    default: 0.0,
    text: "Fraction of the pore volume filled with water",
    effect: "In water a grain deflects light far less than in air.",
    source: "Röttgers et al. 2016, WOPP v3; Daimon & Masumura 2007, doi:10.1364/AO.46.003811",
};
/// Mass fraction of an impurity.
pub const MASS_FRACTION: Parameter = Parameter {
    key: "impurities_ng_g",
    title: "Impurity",
    range: MASS_FRACTION_RANGE,
    default: 0.0,
    text: "Mass fraction of an impurity in dry snow",
    effect: "Impurities absorb light that clean snow would transmit, blue most of all.",
    source: "Cook et al. 2020, doi:10.5194/tc-14-309-2020",
};
/// Temperature.
pub const TEMPERATURE: Parameter = Parameter {
    key: "temperature_c",
    title: "Temperature",
    range: TEMPERATURE_RANGE,
    default: -5.0,
    text: "Temperature",
    effect: "It changes the density of ice, and nothing else, by 1 % over the whole range.",
    source: "snowblue, chapter Snow and its grains",
};
