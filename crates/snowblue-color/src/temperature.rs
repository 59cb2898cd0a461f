//! The reference illuminant of a correlated colour temperature.
//!
//! The reference illuminant is a black body below 4000 K and CIE daylight above 5000 K. In between it is a
//! proportional mixture of both, so that it is continuous (CIE 224:2017, *Colour fidelity index for accurate
//! scientific use*, section 4.2.2).
//!
//! Daylight is S = S₀ + M₁ S₁ + M₂ S₂ with the chromaticity of its temperature (D. B. Judd, D. L. MacAdam & G.
//! Wyszecki 1964, *Spectral distribution of typical daylight as a function of correlated color temperature*, Journal
//! of the Optical Society of America 54(8), 1031–1040, doi:10.1364/JOSA.54.001031; CIE 015:2018, section 4.1.2). D50,
//! D65 and D75 are such sums, so S is the combination of these three spectra with the M₁ and M₂ of the temperature.

use std::ops::RangeInclusive;

use crate::error::ColorError;
use crate::illuminant::Illuminant;
use crate::matrix::{inverse, product};
use crate::xyz::Chromaticity;

/// Temperatures of light that sRGB can show and daylight is defined for, in K.
pub const RANGE_K: RangeInclusive<f64> = 2000.0..=25_000.0;

/// Greatest temperature of black-body light, in K.
const BLACK_BODY_K: f64 = 4000.0;
/// Least temperature of daylight, in K.
const DAYLIGHT_K: f64 = 5000.0;
/// Wavelength at which spectra are scaled to 1, in nm.
const UNIT_NM: f64 = 560.0;
/// Second radiation constant, in nm K.
const C2_NM_K: f64 = 1.438_776_877e7;
/// M₁ and M₂ of D50, D65 and D75, which have 5003, 6504 and 7504 K (CIE 015:2018).
const DAYLIGHTS: [[f64; 2]; 3] = [[-1.040, 0.367], [-0.296, -0.688], [0.144, -0.757]];

/// Checks a temperature in K.
///
/// # Errors
/// If it lies outside [`RANGE_K`].
pub fn check(kelvin: f64) -> Result<f64, ColorError> {
    if RANGE_K.contains(&kelvin) { Ok(kelvin) } else { Err(ColorError::Temperature { kelvin, range_k: RANGE_K }) }
}

/// Power of the reference illuminant of a temperature in K relative to its power at 560 nm.
///
/// ```
/// # use snowblue_color::temperature::relative_power;
/// // The light of a bulb is redder than that of the noon sky.
/// assert!(relative_power(2856.0, 650.0)? > 1.5 && relative_power(6500.0, 650.0)? < 0.9);
/// # Ok::<(), snowblue_color::ColorError>(())
/// ```
///
/// # Errors
/// If the temperature lies outside [`RANGE_K`], or the wavelength outside 300–780 nm.
pub fn relative_power(kelvin: f64, wavelength_nm: f64) -> Result<f64, ColorError> {
    check(kelvin)?;
    let share = ((kelvin - BLACK_BODY_K) / (DAYLIGHT_K - BLACK_BODY_K)).clamp(0.0, 1.0);
    let daylight = if share > 0.0 { daylight(kelvin, wavelength_nm)? } else { 0.0 };
    Ok(share * daylight + (1.0 - share) * planck(kelvin, wavelength_nm) / planck(kelvin, UNIT_NM))
}

/// Chromaticity of CIE daylight at 4000–25,000 K (CIE 015:2018, equations 4.7 to 4.9).
pub fn daylight_chromaticity(kelvin: f64) -> Chromaticity {
    let x = if kelvin <= 7000.0 {
        ((-4.6070e9 / kelvin + 2.9678e6) / kelvin + 0.099_11e3) / kelvin + 0.244_063
    } else {
        ((-2.0064e9 / kelvin + 1.9018e6) / kelvin + 0.247_48e3) / kelvin + 0.237_040
    };
    Chromaticity { x, y: (-3.0 * x + 2.870) * x - 0.275 }
}

/// Radiance of a black body at a wavelength, in any unit.
fn planck(kelvin: f64, wavelength_nm: f64) -> f64 {
    wavelength_nm.powi(-5) / (C2_NM_K / (wavelength_nm * kelvin)).exp_m1()
}

/// Power of daylight relative to its power at 560 nm.
fn daylight(kelvin: f64, wavelength_nm: f64) -> Result<f64, ColorError> {
    let Chromaticity { x, y } = daylight_chromaticity(kelvin);
    let scale = 0.0241 + 0.2562 * x - 0.7341 * y;
    let m1 = (-1.3515 - 1.7703 * x + 5.9114 * y) / scale;
    let m2 = (0.0300 - 31.4424 * x + 30.0717 * y) / scale;
    let [[a1, a2], [b1, b2], [c1, c2]] = DAYLIGHTS;
    let weights = product(inverse([[1.0, 1.0, 1.0], [a1, b1, c1], [a2, b2, c2]]), [1.0, m1, m2]);
    let mut power = 0.0;
    for (name, weight) in ["D50", "D65", "D75"].into_iter().zip(weights) {
        power += weight * name.parse::<Illuminant>()?.relative_power(wavelength_nm)?;
    }
    Ok(0.01 * power)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Colorimeter, Observer};

    /// Chromaticity of the light of a temperature, from its spectrum.
    fn chromaticity(kelvin: f64) -> Chromaticity {
        let nm: Vec<f64> = (380..=780).map(f64::from).collect();
        let power: Vec<f64> = nm.iter().map(|nm| relative_power(kelvin, *nm).unwrap()).collect();
        Colorimeter::new(Observer::Cie1931, Illuminant::E, &nm).unwrap().xyz(&power).chromaticity()
    }

    fn assert_near(kelvin: f64, expected: Chromaticity, tolerance: f64) {
        let found = chromaticity(kelvin);
        let [dx, dy] = [found.x - expected.x, found.y - expected.y].map(f64::abs);
        assert!(dx < tolerance && dy < tolerance, "{kelvin} K: {found:?} {expected:?}");
    }

    /// The tables are rounded to 6 digits and M₁ and M₂ of D50, D65 and D75 to three decimals.
    #[test]
    fn daylight_has_the_chromaticity_of_its_temperature() {
        for kelvin in [5000.0, 5500.0, 6500.0, 7500.0, 10_000.0, 25_000.0] {
            assert_near(kelvin, daylight_chromaticity(kelvin), 3e-4);
        }
        // D65 has the temperature 6504 K (CIE 015:2018).
        for nm in [400.0, 450.0, 600.0, 700.0] {
            let (found, table) = (relative_power(6504.0, nm).unwrap(), Illuminant::D65.relative_power(nm).unwrap());
            assert!((100.0 * found / table - 1.0).abs() < 1e-3, "{nm}: {found} {table}");
        }
        // An illuminant other than D50, D65 and D75: D55, of 5503 K.
        for nm in [400.0, 450.0, 600.0, 700.0] {
            let table = "D55".parse::<Illuminant>().unwrap().relative_power(nm).unwrap();
            let found = 100.0 * relative_power(5503.0, nm).unwrap();
            assert!((found / table - 1.0).abs() < 2e-3, "{nm}: {found} {table}");
        }
    }

    /// Chromaticities of black bodies (Wyszecki & Stiles 1982, *Color Science*, 2nd edition, table 1(3.11)).
    #[test]
    fn warm_light_is_that_of_a_black_body() {
        for (kelvin, x, y) in [(2000.0, 0.5267, 0.4133), (3000.0, 0.4369, 0.4041), (4000.0, 0.3805, 0.3768)] {
            // The published values have c₂ = 1.4388e7 nm K and four digits.
            assert_near(kelvin, Chromaticity { x, y }, 1e-4);
        }
    }

    #[test]
    fn colours_change_continuously_with_temperature() {
        for kelvin in [4000.0, 5000.0, 7000.0] {
            assert_near(kelvin - 0.5, chromaticity(kelvin + 0.5), 1e-4);
        }
    }

    #[test]
    fn temperatures_outside_the_range_are_refused() {
        for kelvin in [1999.0, 25_001.0, f64::NAN, -1.0] {
            assert!(relative_power(kelvin, 500.0).is_err());
        }
        let message = check(500.0).unwrap_err().to_string();
        assert_eq!(message, "colour temperature is 500 K, but must lie in 2000–25000 K");
    }
}
