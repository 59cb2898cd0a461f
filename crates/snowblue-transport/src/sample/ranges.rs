//! Ranges of the parameters of a snow sample. Every face checks against these.

pub use crate::optics::impurity::MASS_FRACTION_RANGE;
use crate::range::ParameterRange;

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
