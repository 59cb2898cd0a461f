//! Grain sizes of a snow sample.

use snowblue_base::{ParameterRange, RangeError};

use super::ranges::{GRAIN_SIZE_RANGE, SURFACE_AREA_RANGE};
use crate::TransportError;
use crate::grain::SizeMeasure;
use crate::optics::ice;

/// Half-width of the range that a mean grain size represents, in µm (the paper's Table S1: 200–300 for 250).
pub const MEAN_SIZE_HALF_RANGE_UM: f64 = 50.0;
/// Mean grain size whose range lies in that of grain sizes, in µm.
pub const MEAN_SIZE_RANGE: ParameterRange = ParameterRange {
    quantity: "mean grain size",
    least: GRAIN_SIZE_RANGE.least + MEAN_SIZE_HALF_RANGE_UM,
    greatest: GRAIN_SIZE_RANGE.greatest - MEAN_SIZE_HALF_RANGE_UM,
    unit: GRAIN_SIZE_RANGE.unit,
};

/// Grain sizes, uniform in number over a range, in µm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrainSize {
    /// Smallest grain, in µm.
    pub min_um: f64,
    /// Largest grain, in µm.
    pub max_um: f64,
    /// What the size measures.
    pub measure: SizeMeasure,
}

impl GrainSize {
    /// The range that a mean greatest extension represents: mean ± 50 µm.
    ///
    /// # Errors
    /// [`TransportError::MeanSize`] if the range would start below 20 µm or end above 5000 µm.
    pub fn around(mean_um: f64) -> Result<Self, TransportError> {
        if !MEAN_SIZE_RANGE.contains(mean_um) {
            return Err(TransportError::MeanSize {
                mean_um,
                half_range_um: MEAN_SIZE_HALF_RANGE_UM,
                least_um: MEAN_SIZE_RANGE.least,
                greatest_um: MEAN_SIZE_RANGE.greatest,
            });
        }
        let (min_um, max_um) = (mean_um - MEAN_SIZE_HALF_RANGE_UM, mean_um + MEAN_SIZE_HALF_RANGE_UM);
        Ok(Self { min_um, max_um, measure: SizeMeasure::default() })
    }

    /// Grains of one optical diameter with a given specific surface area SSA = S/(V ρ_ice), in m²/kg.
    ///
    /// # Errors
    /// [`TransportError::Range`] for an area outside 1.4–300 m²/kg.
    pub fn from_specific_surface_area(area_m2_kg: f64, temperature_c: f64) -> Result<Self, TransportError> {
        SURFACE_AREA_RANGE.check(area_m2_kg)?;
        let diameter_um = 6e6 / (ice::density_kg_m3(temperature_c) * area_m2_kg);
        Ok(Self { min_um: diameter_um, max_um: diameter_um, measure: SizeMeasure::OpticalDiameter })
    }

    /// The sizes that numbers in µm state: a mean, as in [`around`](Self::around), or the ends of a range.
    ///
    /// # Errors
    /// For another count of numbers, and as [`around`](Self::around).
    pub fn from_numbers(numbers_um: &[f64], measure: SizeMeasure) -> Result<Self, TransportError> {
        match *numbers_um {
            [mean_um] => Ok(Self { measure, ..Self::around(mean_um)? }),
            [min_um, max_um] => Ok(Self { min_um, max_um, measure }),
            _ => Err(TransportError::Count {
                quantity: "grain size",
                count: numbers_um.len(),
                expected: "a mean (400) or a range (350, 450), in µm",
            }),
        }
    }

    /// The middle of the range, in µm.
    #[must_use]
    pub fn middle_um(&self) -> f64 {
        0.5 * (self.min_um + self.max_um)
    }

    /// ⟨s²⟩ in µm².
    pub(crate) fn mean_square_um2(&self) -> f64 {
        let (a, b) = (self.min_um, self.max_um);
        (a * a + a * b + b * b) / 3.0
    }

    /// ⟨s³⟩ in µm³.
    pub(crate) fn mean_cube_um3(&self) -> f64 {
        let (a, b) = (self.min_um, self.max_um);
        (a + b) * (a * a + b * b) / 4.0
    }

    pub(super) fn check(&self) -> Result<(), RangeError> {
        GRAIN_SIZE_RANGE.check_interval(self.min_um, self.max_um)
    }
}
