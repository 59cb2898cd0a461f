//! All parameters of snow and of the light on it.

use snowblue_base::Parameter;

use crate::sample::{
    DENSITY, FACETNESS, GRAIN_SIZE, MASS_FRACTION, SPHERICITY, SURFACE_AREA, TEMPERATURE, WATER_SATURATION,
};
use crate::slab::{ANGLE, THICKNESS};
use crate::stack::GROUND_ALBEDO;

/// All parameters that are numbers.
pub const PARAMETERS: [Parameter; 11] = [
    GRAIN_SIZE,
    SURFACE_AREA,
    FACETNESS,
    SPHERICITY,
    DENSITY,
    WATER_SATURATION,
    MASS_FRACTION,
    TEMPERATURE,
    THICKNESS,
    ANGLE,
    GROUND_ALBEDO,
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{SnowSample, SnowType};

    #[test]
    fn the_default_sample_has_the_defaults_of_its_parameters() {
        let SnowSample { grain_size, sphericity, facetness, density_kg_m3, water_saturation, temperature_c, .. } =
            SnowSample::default();
        let values = [
            (GRAIN_SIZE, grain_size.middle_um()),
            (SURFACE_AREA, SnowType::Rounded.surface_area_m2_kg()),
            (SPHERICITY, sphericity.mean),
            (FACETNESS, facetness.mean),
            (DENSITY, density_kg_m3),
            (WATER_SATURATION, water_saturation),
            (TEMPERATURE, temperature_c),
        ];
        for (parameter, value) in values {
            assert!((parameter.default - value).abs() < 1e-12, "{}: {value}", parameter.key);
        }
    }

    #[test]
    fn every_default_lies_in_its_range() {
        for parameter in PARAMETERS {
            parameter.range.check(parameter.default).unwrap();
        }
    }
}
