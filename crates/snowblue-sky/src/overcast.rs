//! The overcast sky of the CIE.
//!
//! **Distribution** (Moon & Spencer 1942, Trans. Illum. Eng. Soc. 37, 707; CIE S 011 and ISO 15469, the traditional
//! overcast sky): L(θ) = L_z (1 + 2 cos θ) / 3, with the radiance L_z at the zenith. Level ground receives 7π/9 L_z.
//!
//! **Strength** (Krochmann & Seidl 1974, Light. Res. Technol. 6, 165): under a sun at the elevation h₀, level ground
//! receives 300 + 21000 sin h₀ lx.
//!
//! **Spectrum**: daylight D65 (CIE 015:2018) to 720 nm. Beyond 720 nm, light that a cloud of droplets and the air
//! transmit.
//!
//! **Simplified.** Clouds differ only in their optical thickness, and optical thickness has an effect only in the
//! infrared: the strength is a mean over all clouds. Light that goes back and forth between snow and clouds is not
//! added to the strength. With an albedo of 0.9 instead of 0.2 below clouds that reflect 0.6, it would nearly double
//! the illuminance: (1 − 0.2 · 0.6) / (1 − 0.9 · 0.6) = 1.9.

use std::f64::consts::PI;
use std::sync::LazyLock;

use snowblue_color::Illuminant;

use crate::clear_sky::check_elevation;
use crate::error::{SkyError, check};
use crate::luminous::ILLUMINANCE_LX;
use crate::tables::{NODES, PRECIPITABLE_WATER_CM, PRECIPITABLE_WATER_RANGE_CM, WAVELENGTHS_NM};

/// Irradiance of level ground under an overcast sky divided by the radiance at the zenith, in sr:
/// ∫ (1 + 2 cos θ)/3 cos θ dω = 7π/9.
pub const OVERCAST_IRRADIANCE_SR: f64 = 7.0 * PI / 9.0;

/// Optical thickness of the clouds in the visible. With 15 the infrared matches the cloudy sky that ships with SNICAR
/// (Flanner et al. 2021).
pub const CLOUD_OPTICAL_THICKNESS: f64 = 15.0;

/// Range of the optical thickness of clouds. Thin stratus has 5–20, rain clouds have 20–100.
pub const CLOUD_OPTICAL_THICKNESS_RANGE: (f64, f64) = (1.0, 200.0);

/// Albedo of snow in the visible.
const SNOW_ALBEDO: f64 = 0.8;

/// Illuminance by the tabulated power of D65 as irradiance in W m⁻² nm⁻¹, in lx.
static TABLE_ILLUMINANCE_LX: LazyLock<f64> =
    LazyLock::new(|| ILLUMINANCE_LX.iter().map(|at| at.weight * d65(at.wavelength_nm)).sum());

/// A sky covered by clouds that hide the sun.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OvercastSky {
    illuminance_lx: f64,
    optical_thickness: f64,
    ground_albedo: f64,
    precipitable_water_cm: f64,
}

impl OvercastSky {
    /// A sky that gives level ground an illuminance in lx, greater than 0.
    ///
    /// # Errors
    /// [`SkyError::OutOfRange`] if it lies outside 0–200000 lx.
    pub fn new(illuminance_lx: f64) -> Result<Self, SkyError> {
        check("illuminance", illuminance_lx, (0.0, 200_000.0), " lx")?;
        Ok(Self {
            illuminance_lx,
            optical_thickness: CLOUD_OPTICAL_THICKNESS,
            ground_albedo: SNOW_ALBEDO,
            precipitable_water_cm: PRECIPITABLE_WATER_CM,
        })
    }

    /// This sky with clouds of another optical thickness, 1–200. Thicker clouds absorb more of the infrared. The
    /// illuminance does not change.
    ///
    /// # Errors
    /// [`SkyError::OutOfRange`] outside that range.
    pub fn with_optical_thickness(self, optical_thickness: f64) -> Result<Self, SkyError> {
        check("optical thickness of clouds", optical_thickness, CLOUD_OPTICAL_THICKNESS_RANGE, "")?;
        Ok(Self { optical_thickness, ..self })
    }

    /// This sky over ground that reflects another fraction of the visible light, 0–1. Over bright ground the light
    /// has less infrared, since visible light goes back and forth between ground and clouds. The illuminance does not
    /// change.
    ///
    /// # Errors
    /// [`SkyError::OutOfRange`] outside that range.
    pub fn with_ground_albedo(self, ground_albedo: f64) -> Result<Self, SkyError> {
        check("ground albedo", ground_albedo, (0.0, 1.0), "")?;
        Ok(Self { ground_albedo, ..self })
    }

    /// This sky with another amount of water vapour, which absorbs only in the infrared.
    ///
    /// # Errors
    /// [`SkyError::OutOfRange`] outside 0–10 cm.
    pub fn with_precipitable_water(self, precipitable_water_cm: f64) -> Result<Self, SkyError> {
        check("precipitable water", precipitable_water_cm, PRECIPITABLE_WATER_RANGE_CM, " cm")?;
        Ok(Self { precipitable_water_cm, ..self })
    }

    /// Optical thickness of the clouds in the visible.
    #[must_use]
    pub fn optical_thickness(self) -> f64 {
        self.optical_thickness
    }

    /// Fraction of the visible light that the ground reflects.
    #[must_use]
    pub fn ground_albedo(self) -> f64 {
        self.ground_albedo
    }

    /// Water vapour in the air, in cm of water.
    #[must_use]
    pub fn precipitable_water_cm(self) -> f64 {
        self.precipitable_water_cm
    }

    /// The sky of mean strength under a sun at an elevation of 0–90°, in degrees ([`overcast_illuminance_lx`]).
    ///
    /// # Errors
    /// [`SkyError::SunBelowHorizon`], or [`SkyError::OutOfRange`] above 90°.
    pub fn under_sun(sun_elevation_deg: f64) -> Result<Self, SkyError> {
        Self::new(overcast_illuminance_lx(sun_elevation_deg)?)
    }

    /// Illuminance of level ground, in lx.
    #[must_use]
    pub fn illuminance_lx(self) -> f64 {
        self.illuminance_lx
    }

    /// Radiance of the sky, in W m⁻² sr⁻¹ nm⁻¹; zero below the horizon.
    ///
    /// The zenith is three times as bright as the horizon:
    /// ```
    /// # use snowblue_sky::OvercastSky;
    /// let sky = OvercastSky::under_sun(30.0)?;
    /// assert!((sky.radiance(550.0, 1.0) / sky.radiance(550.0, 0.0) - 3.0).abs() < 1e-12);
    /// # Ok::<(), snowblue_sky::SkyError>(())
    /// ```
    ///
    /// # Panics
    /// If the wavelength lies outside 320–720 nm.
    #[must_use]
    pub fn radiance(self, wavelength_nm: f64, cos_zenith: f64) -> f64 {
        self.irradiance(wavelength_nm) / OVERCAST_IRRADIANCE_SR * overcast_relative_radiance(cos_zenith)
    }

    /// Irradiance of level ground, in W m⁻² nm⁻¹.
    ///
    /// # Panics
    /// If the wavelength lies outside 320–720 nm.
    #[must_use]
    pub fn irradiance(self, wavelength_nm: f64) -> f64 {
        self.illuminance_lx / *TABLE_ILLUMINANCE_LX * d65(wavelength_nm)
    }
}

/// Radiance of the overcast sky relative to the zenith: (1 + 2 cos θ) / 3 above the horizon, zero below.
#[must_use]
pub fn overcast_relative_radiance(cos_zenith: f64) -> f64 {
    if cos_zenith < 0.0 { 0.0 } else { (1.0 + 2.0 * cos_zenith) / 3.0 }
}

/// Mean illuminance of level ground under an overcast sky, in lx, for an elevation of the sun of 0–90°, in degrees
/// (Krochmann & Seidl 1974): 300 + 21000 sin h₀.
///
/// # Errors
/// [`SkyError::SunBelowHorizon`], or [`SkyError::OutOfRange`] above 90°.
pub fn overcast_illuminance_lx(sun_elevation_deg: f64) -> Result<f64, SkyError> {
    check_elevation(sun_elevation_deg)?;
    Ok(300.0 + 21_000.0 * sun_elevation_deg.to_radians().sin())
}

/// Relative power of D65.
///
/// # Panics
/// If the wavelength lies outside the range of radiances, 320–720 nm.
fn d65(wavelength_nm: f64) -> f64 {
    let (first_nm, last_nm) = (WAVELENGTHS_NM[0], WAVELENGTHS_NM[NODES - 1]);
    let known = (first_nm..=last_nm).contains(&wavelength_nm);
    let power = Illuminant::D65.relative_power(wavelength_nm).ok().filter(|_| known);
    power.unwrap_or_else(|| panic!("wavelength is {wavelength_nm} nm, but must lie in {first_nm}–{last_nm} nm"))
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "zero below the horizon")]
mod tests {
    use super::*;
    use crate::rings::midpoints;

    /// ∫ L cos θ dω = 2π ∫ L c dc = 7π/9 L_z.
    #[test]
    fn irradiance_is_the_integral_of_the_radiance() {
        let sky = OvercastSky::new(10_000.0).unwrap();
        let sum: f64 = midpoints(0.0, 1.0, 1000).map(|cosine| sky.radiance(480.0, cosine) * cosine).sum();
        // The midpoint rule on a parabola: 1/(12 · 1000²) of its curvature.
        assert!((2.0 * PI * sum / 1000.0 / sky.irradiance(480.0) - 1.0).abs() < 1e-6);
        assert_eq!(sky.radiance(480.0, -0.1), 0.0);
    }

    #[test]
    fn illuminance_is_that_of_krochmann_and_seidl() {
        assert_eq!(overcast_illuminance_lx(0.0), Ok(300.0));
        assert!((overcast_illuminance_lx(30.0).unwrap() - 10_800.0).abs() < 1e-9);
        let sky = OvercastSky::under_sun(30.0).unwrap();
        let illuminance_lx: f64 = ILLUMINANCE_LX.iter().map(|at| at.weight * sky.irradiance(at.wavelength_nm)).sum();
        assert!((illuminance_lx / 10_800.0 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn bad_input_is_refused_in_one_line() {
        let message = |elevation_deg| OvercastSky::under_sun(elevation_deg).unwrap_err().to_string();
        assert_eq!(message(-1.0), "sun elevation is -1°, but must lie in 0–90°: there is no model of twilight");
        assert_eq!(message(91.0), "sun elevation is 91°, but must lie in 0–90°");
        let message = |illuminance_lx| OvercastSky::new(illuminance_lx).unwrap_err().to_string();
        assert_eq!(message(-1.0), "illuminance is -1 lx, but must lie in 0–200000 lx");
    }

    #[test]
    #[should_panic(expected = "wavelength is 750 nm, but must lie in 320–720 nm")]
    fn wavelengths_of_no_clear_sky_panic() {
        let _ = OvercastSky::new(1.0).unwrap().irradiance(750.0);
    }
}
