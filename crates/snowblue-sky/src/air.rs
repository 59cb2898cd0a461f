//! Extinction by the air near the ground.
//!
//! Molecules: the scattering cross section of Nicolet (1984, doi:10.1016/0032-0633(84)90089-8), with λ in µm,
//!
//! σ = 4.02·10⁻³² m² / λ^(4 + x), x = 0.389 λ + 0.09426/λ − 0.3228 below 0.55 µm and 0.04 above,
//!
//! times N = 2.547·10²⁵ molecules per m³ at 15 °C and 1013 hPa: β_m(λ).
//!
//! Haze: the turbidity T is the ratio of the optical thickness of all air to the optical thickness of its molecules,
//! τ_m = β_m H_m. The haze therefore has the optical thickness (T − 1) τ_m at 550 nm. Near the ground its extinction
//! coefficient is
//!
//! β_h(λ) = (T − 1) β_m(550 nm) H_m/H_h (550 nm/λ)^1.3,
//!
//! with the scale heights H_m = 8.4 km and H_h = 1.25 km (Preetham et al. 1999) and the exponent of Ångström (1929).

/// Molecules in 1 m³ of air at 15 °C and 1013 hPa.
const MOLECULES_PER_M3: f64 = 2.547e25;
/// Scale heights of molecules and haze, in m.
const MOLECULES_HEIGHT_M: f64 = 8400.0;
const HAZE_HEIGHT_M: f64 = 1250.0;
/// The wavelength at which turbidity is defined, in nm, and the exponent of Ångström.
const TURBIDITY_NM: f64 = 550.0;
const HAZE_EXPONENT: f64 = 1.3;

/// Extinction coefficient of the air near the ground, in 1/m.
///
/// - `turbidity`: as in [`ClearSky`](crate::ClearSky).
/// - `wavelength_nm`: greater than 0.
///
/// On a clear day the visual range is some 25 km, by Koschmieder's contrast of 2 % (1924):
/// ```
/// # use snowblue_sky::air_extinction_per_m;
/// let range_m = -f64::ln(0.02) / air_extinction_per_m(3.0, 550.0);
/// assert!((20e3..30e3).contains(&range_m));
/// ```
#[must_use]
pub fn air_extinction_per_m(turbidity: f64, wavelength_nm: f64) -> f64 {
    let haze = (turbidity - 1.0) * molecules_per_m(TURBIDITY_NM) * MOLECULES_HEIGHT_M / HAZE_HEIGHT_M;
    molecules_per_m(wavelength_nm) + haze * (TURBIDITY_NM / wavelength_nm).powf(HAZE_EXPONENT)
}

fn molecules_per_m(wavelength_nm: f64) -> f64 {
    let wavelength_um = 1e-3 * wavelength_nm;
    let x = if wavelength_um < 0.55 { 0.389 * wavelength_um + 0.09426 / wavelength_um - 0.3228 } else { 0.04 };
    4.02e-32 * MOLECULES_PER_M3 / wavelength_um.powf(4.0 + x)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// By the law of Rayleigh (1871): 24π³ (n² − 1)² / (λ⁴ N (n² + 2)²) (6 + 3p) / (6 − 7p), with the refractive
    /// index n of air by Peck & Reeder (1972), and a depolarisation p of 0.03. Nicolet's fit is within 0.5 % of Bates
    /// (1984), whose p depends on the wavelength. This dependence changes the last factor by less than 1 %.
    #[test]
    fn clear_air_scatters_as_its_molecules_do() {
        for wavelength_nm in [400.0, 450.0, 550.0, 700.0] {
            let inverse_um2 = (1e3_f64 / wavelength_nm).powi(2);
            let index = 1.0 + 1e-8 * (5_791_817.0 / (238.0185 - inverse_um2) + 167_909.0 / (57.362 - inverse_um2));
            let polarisability = ((index * index - 1.0) / (index * index + 2.0)).powi(2);
            let depolarisation = (6.0 + 3.0 * 0.03) / (6.0 - 7.0 * 0.03);
            let wavelength_m: f64 = 1e-9 * wavelength_nm;
            let law = 24.0 * PI.powi(3) * polarisability * depolarisation / (wavelength_m.powi(4) * MOLECULES_PER_M3);
            let pure = air_extinction_per_m(1.0, wavelength_nm);
            assert!((pure / law - 1.0).abs() < 0.015, "{wavelength_nm} nm: {pure} {law}");
        }
    }

    /// The definition of turbidity at 550 nm.
    #[test]
    fn turbidity_is_the_ratio_of_the_thicknesses() {
        let molecules = air_extinction_per_m(1.0, 550.0);
        let haze = air_extinction_per_m(4.0, 550.0) - molecules;
        let ratio = (molecules * MOLECULES_HEIGHT_M + haze * HAZE_HEIGHT_M) / (molecules * MOLECULES_HEIGHT_M);
        assert!((ratio - 4.0).abs() < 1e-12, "{ratio}");
    }
}
