//! Grain sizes of a snow sample, and the specific surface area of dry snow as it ages, after Taillandier et al. (2007,
//! doi:10.1029/2006JF000514).
//!
//! With the area S₀ of new snow in cm²/g, the age t in hours and the temperature T in °C,
//!
//! ```text
//! S(t) = B − A ln(t + e^{(B − S₀)/A}),
//! isothermal:             A = 0.0760 S₀ − 1.76 (T − 2.96),   B = 0.629 S₀ − 15.0 (T − 11.2),
//! temperature gradient:   A = 0.0961 S₀ − 3.44 (T + 1.90),   B = 0.659 S₀ − 27.2 (T − 2.03),
//! ```
//!
//! which is S₀ at t = 0. The coefficients are taken from the snow model Crocus (Carmagnola et al. 2014,
//! doi:10.5194/tc-8-417-2014), which changes from the first law to the second law at a gradient of 10 K/m.
//!
//! **Simplified.** The fit describes new, dry snow, and has no lower bound: Crocus does not follow it below 8 m²/kg.

use snowblue_base::{ParameterRange, RangeError};

use crate::TransportError;
use crate::grain::SizeMeasure;
use crate::optics::ice;
use crate::parameters::{GRAIN_SIZE, SURFACE_AREA, TEMPERATURE};
use crate::quadrature::Quadrature;

/// Half-width of the range that a mean grain size represents, in µm (the paper's Table S1: 200–300 for 250).
pub const MEAN_SIZE_HALF_RANGE_UM: f64 = 50.0;
/// Mean grain size whose range lies within the range of grain sizes, in µm.
pub const MEAN_SIZE_RANGE: ParameterRange = ParameterRange {
    quantity: "mean grain size",
    least: GRAIN_SIZE.range.least + MEAN_SIZE_HALF_RANGE_UM,
    greatest: GRAIN_SIZE.range.greatest - MEAN_SIZE_HALF_RANGE_UM,
    unit: GRAIN_SIZE.range.unit,
};

/// Age of snow, in hours: up to a year.
const AGE_RANGE: ParameterRange = ParameterRange { quantity: "age", least: 0.0, greatest: 8784.0, unit: "h" };

/// Grain sizes, uniform in number over a range, in µm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrainSize {
    /// Smallest grain, in µm.
    pub min_um: f64,
    /// Largest grain, in µm.
    pub max_um: f64,
    /// The quantity that the size measures.
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
        SURFACE_AREA.range.check(area_m2_kg)?;
        Ok(Self::of_surface_area(area_m2_kg, temperature_c))
    }

    /// Grains of one optical diameter with a specific surface area in its range.
    pub(super) fn of_surface_area(area_m2_kg: f64, temperature_c: f64) -> Self {
        let diameter_um = 6e6 / (ice::density_kg_m3(temperature_c) * area_m2_kg);
        Self { min_um: diameter_um, max_um: diameter_um, measure: SizeMeasure::OpticalDiameter }
    }

    /// The sizes that numbers in µm state: a mean, as in [`around`](Self::around), or the ends of a range.
    ///
    /// # Errors
    /// For another count of numbers, and for values out of range.
    pub fn from_numbers(numbers_um: &[f64], measure: SizeMeasure) -> Result<Self, TransportError> {
        let sizes = match *numbers_um {
            [mean_um] => Self::around(mean_um)?,
            [min_um, max_um] => Self { min_um, max_um, measure },
            _ => {
                return Err(TransportError::Count {
                    quantity: "grain size",
                    count: numbers_um.len(),
                    expected: "a mean (400) or a range (350, 450), in µm",
                });
            }
        };
        sizes.check()?;
        Ok(Self { measure, ..sizes })
    }

    /// The middle of the range, in µm.
    #[must_use]
    pub fn middle_um(&self) -> f64 {
        0.5 * (self.min_um + self.max_um)
    }

    /// Sizes s in µm and their weights, which sum to 1 and go as s², for integrals over the projected area of grains.
    pub(crate) fn by_area_um(&self) -> impl Iterator<Item = (f64, f64)> + use<> {
        let rule = Quadrature::half_range(if self.min_um < self.max_um { 6 } else { 1 });
        let (least, width, mean_square) = (self.min_um, self.max_um - self.min_um, self.mean_square_um2());
        rule.cosines.iter().zip(&rule.weights).map(move |(node, weight)| {
            let size_um = least + node * width;
            (size_um, weight * size_um * size_um / mean_square)
        })
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
        GRAIN_SIZE.range.check_interval(self.min_um, self.max_um)
    }
}

/// The process that changes the grains of dry snow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Metamorphism {
    /// Snow of one temperature.
    Isothermal,
    /// Snow with a gradient of temperature.
    TemperatureGradient,
}

/// Specific surface area, in m²/kg, of dry snow of an age in hours. New snow has the area `new_m2_kg`.
///
/// In a cold week new snow loses half its surface; a gradient of temperature takes more:
/// ```
/// use snowblue_transport::sample::{Metamorphism, aged_surface_area_m2_kg};
///
/// let after_a_week = |metamorphism| aged_surface_area_m2_kg(60.0, -10.0, 168.0, metamorphism);
/// let isothermal = after_a_week(Metamorphism::Isothermal)?;
/// assert!((25.0..35.0).contains(&isothermal));
/// assert!(after_a_week(Metamorphism::TemperatureGradient)? < isothermal);
/// # Ok::<(), snowblue_transport::TransportError>(())
/// ```
///
/// # Errors
/// If a value lies outside its range, or the area after that time does.
pub fn aged_surface_area_m2_kg(
    new_m2_kg: f64,
    temperature_c: f64,
    age_h: f64,
    metamorphism: Metamorphism,
) -> Result<f64, TransportError> {
    SURFACE_AREA.range.check(new_m2_kg)?;
    TEMPERATURE.range.check(temperature_c)?;
    AGE_RANGE.check(age_h)?;
    /// cm²/g per m²/kg.
    const CM2_G: f64 = 10.0;
    let (new, t) = (CM2_G * new_m2_kg, temperature_c);
    let (a, b) = match metamorphism {
        Metamorphism::Isothermal => (0.0760 * new - 1.76 * (t - 2.96), 0.629 * new - 15.0 * (t - 11.2)),
        Metamorphism::TemperatureGradient => (0.0961 * new - 3.44 * (t + 1.90), 0.659 * new - 27.2 * (t - 2.03)),
    };
    if a <= 0.0 {
        let rule = "of new snow is too small for the law of ageing in a gradient of temperature";
        return Err(TransportError::Combination { quantity: SURFACE_AREA.range.quantity, rule });
    }
    // Written so that the age 0 gives the area of new snow to the last bit.
    let aged_m2_kg = new_m2_kg - a / CM2_G * (age_h * (-(b - new) / a).exp()).ln_1p();
    ParameterRange { quantity: "specific surface area after ageing", ..SURFACE_AREA.range }.check(aged_m2_kg)?;
    Ok(aged_m2_kg)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The formula as it is printed, with the constants 0.629 − 1 = −0.371 and 0.659 − 1 = −0.341 in the exponent.
    #[test]
    fn the_law_is_that_of_taillandier() {
        for (new, t, hours) in [(600.0_f64, -10.0_f64, 168.0_f64), (900.0, -3.0, 24.0), (250.0, -30.0, 2000.0)] {
            let isothermal = 0.629 * new
                - 15.0 * (t - 11.2)
                - (0.0760 * new - 1.76 * (t - 2.96))
                    * (hours + ((-0.371 * new - 15.0 * (t - 11.2)) / (0.0760 * new - 1.76 * (t - 2.96))).exp()).ln();
            let gradient = 0.659 * new
                - 27.2 * (t - 2.03)
                - (0.0961 * new - 3.44 * (t + 1.90))
                    * (hours + ((-0.341 * new - 27.2 * (t - 2.03)) / (0.0961 * new - 3.44 * (t + 1.90))).exp()).ln();
            let ours = |metamorphism| aged_surface_area_m2_kg(0.1 * new, t, hours, metamorphism).unwrap();
            assert!((10.0 * ours(Metamorphism::Isothermal) / isothermal - 1.0).abs() < 1e-12);
            assert!((10.0 * ours(Metamorphism::TemperatureGradient) / gradient - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn snow_loses_surface_with_age_and_faster_where_it_is_warm() {
        for metamorphism in [Metamorphism::Isothermal, Metamorphism::TemperatureGradient] {
            let area = |t, hours| aged_surface_area_m2_kg(60.0, t, hours, metamorphism).unwrap();
            assert!(area(-10.0, 0.0).to_bits() == 60.0_f64.to_bits() && area(-10.0, 24.0) > area(-10.0, 48.0));
        }
        let area = |t| aged_surface_area_m2_kg(60.0, t, 24.0, Metamorphism::Isothermal).unwrap();
        assert!(area(-1.0) < area(-40.0));
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let aged = |new, t, hours, by| aged_surface_area_m2_kg(new, t, hours, by).unwrap_err().to_string();
        let (isothermal, gradient) = (Metamorphism::Isothermal, Metamorphism::TemperatureGradient);
        assert_eq!(aged(60.0, 1.0, 1.0, isothermal), "temperature is 1 °C, but must lie in -60–0 °C");
        assert_eq!(aged(60.0, -1.0, -1.0, isothermal), "age is -1 h, but must lie in 0–8784 h");
        assert!(aged(60.0, -1.0, 8000.0, gradient).starts_with("specific surface area after ageing is -"));
        assert!(aged(5.0, -0.1, 10.0, gradient).contains("too small"));
    }
}
