//! Weights of wavelengths for illuminance and for the photon flux of photosynthesis.

use std::sync::LazyLock;

use snowblue_base::units::{LUMENS_PER_WATT, PHOTONS_UMOL_J_NM};
use snowblue_color::Observer;

/// The weight of a wavelength in an integral over the spectrum by the trapezoidal rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Weight {
    pub(crate) wavelength_nm: f64,
    /// Per W m⁻² nm⁻¹.
    pub(crate) weight: f64,
}

/// Illuminance in lx: 683 lm/W ∫ E V dλ over 360–720 nm. About a ten-thousandth lies beyond 720 nm.
pub(crate) static ILLUMINANCE_LX: LazyLock<Vec<Weight>> = LazyLock::new(|| {
    let visibility = |wavelength_nm| Observer::Cie1931.color_matching(wavelength_nm).map_or(0.0, |matching| matching.y);
    weights(360, 720, |wavelength_nm| LUMENS_PER_WATT * visibility(wavelength_nm))
});

/// Photosynthetically active radiation in µmol m⁻² s⁻¹: the photons of 400–700 nm (McCree 1972,
/// doi:10.1016/0002-1571(72)90045-3).
pub(crate) static PAR_UMOL_M2_S: LazyLock<Vec<Weight>> =
    LazyLock::new(|| weights(400, 700, |wavelength_nm| PHOTONS_UMOL_J_NM * wavelength_nm));

fn weights(first_nm: u32, last_nm: u32, factor: impl Fn(f64) -> f64) -> Vec<Weight> {
    let step_nm = 5;
    let weight = |nm: u32| {
        let ends = if nm == first_nm || nm == last_nm { 0.5 } else { 1.0 };
        Weight { wavelength_nm: f64::from(nm), weight: ends * f64::from(step_nm) * factor(f64::from(nm)) }
    };
    (0..=(last_nm - first_nm) / step_nm).map(|index| weight(first_nm + step_nm * index)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(weights: &[Weight]) -> f64 {
        weights.iter().map(|weight| weight.weight).sum()
    }

    /// ∫ V dλ = 106.857 nm (the sum of ȳ every 1 nm). A fraction of 1.4e-4 lies beyond 720 nm.
    #[test]
    fn illuminance_of_equal_power() {
        assert!(
            (sum(&ILLUMINANCE_LX) / (LUMENS_PER_WATT * 106.857) - (1.0 - 1.4e-4)).abs() < 2e-5,
            "{}",
            sum(&ILLUMINANCE_LX)
        );
    }

    /// 1 W m⁻² nm⁻¹ at every wavelength: ∫ λ dλ = 165000 nm², times 1/(h c N_A) = 8.3593 nmol/(J nm).
    #[test]
    fn photons_of_equal_power() {
        assert!((sum(&PAR_UMOL_M2_S) / (165_000.0 * 8.3593e-3) - 1.0).abs() < 1e-5, "{}", sum(&PAR_UMOL_M2_S));
    }
}
