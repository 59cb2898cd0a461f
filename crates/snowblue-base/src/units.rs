//! Factors between units, and rounding.

/// Lumens per watt at the greatest sensitivity of the eye, for the tabulated V(λ) (CIE 015:2018): 683 lm/W are
/// defined at 540 THz (BIPM 2019, "The International System of Units", section 2.3.1).
pub const LUMENS_PER_WATT: f64 = 683.002;

/// Photons per energy and wavelength, 1/(h c N_A), in µmol J⁻¹ nm⁻¹ (exact constants of the SI).
pub const PHOTONS_UMOL_J_NM: f64 = 1e-3 / (6.626_070_15e-34 * 299_792_458.0 * 6.022_140_76e23);

/// Rounds to single precision.
#[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
#[inline]
#[must_use]
pub fn narrow(value: f64) -> f32 {
    value as f32
}
