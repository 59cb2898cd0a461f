//! The specific surface area of dry snow as it ages, after Taillandier et al. (2007, doi:10.1029/2006JF000514).
//!
//! With the area S₀ of new snow in cm²/g, the age t in hours and the temperature T in °C,
//!
//! ```text
//! S(t) = B − A ln(t + e^{(B − S₀)/A}),
//! isothermal:             A = 0.0760 S₀ − 1.76 (T − 2.96),   B = 0.629 S₀ − 15.0 (T − 11.2),
//! temperature gradient:   A = 0.0961 S₀ − 3.44 (T + 1.90),   B = 0.659 S₀ − 27.2 (T − 2.03),
//! ```
//!
//! which is S₀ at t = 0. The coefficients are those of the snow model Crocus (Carmagnola et al. 2014,
//! doi:10.5194/tc-8-417-2014), which changes from the first law to the second at a gradient of 10 K/m.
//!
//! **Simplified.** The fit describes new, dry snow, and has no lower bound: Crocus does not follow it below 8 m²/kg.

use super::ranges::{SURFACE_AREA_RANGE, TEMPERATURE_RANGE};
use crate::TransportError;
use snowblue_base::ParameterRange;

/// Age of snow, in hours: up to a year.
pub const AGE_RANGE: ParameterRange = ParameterRange { quantity: "age", least: 0.0, greatest: 8784.0, unit: "h" };

/// What changes the grains of dry snow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Metamorphism {
    /// Snow of one temperature.
    Isothermal,
    /// Snow with a gradient of temperature.
    TemperatureGradient,
}

/// Specific surface area of dry snow of an age in hours, in m²/kg, that of new snow being `new_m2_kg`.
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
    SURFACE_AREA_RANGE.check(new_m2_kg)?;
    TEMPERATURE_RANGE.check(temperature_c)?;
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
        return Err(TransportError::Combination { quantity: SURFACE_AREA_RANGE.quantity, rule });
    }
    // Written so that the age 0 gives the area of new snow to the last bit.
    let aged_m2_kg = new_m2_kg - a / CM2_G * (age_h * (-(b - new) / a).exp()).ln_1p();
    ParameterRange { quantity: "specific surface area after ageing", ..SURFACE_AREA_RANGE }.check(aged_m2_kg)?;
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
