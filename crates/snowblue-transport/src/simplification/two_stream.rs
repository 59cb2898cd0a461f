//! The δ-Eddington approximation, the two-stream model of many land-surface and climate models (Joseph, Wiscombe &
//! Weinman 1976, doi:10.1175/1520-0469(1976)033<2452:TDEAFR>2.0.CO;2).
//!
//! With f = g², τ' = (1 − ωf)τ, 1 − ω' = (1 − ω)/(1 − ωf) and g' = g/(1 + g), the transmittance is equation 15 of
//! Meador & Weaver (1980, doi:10.1175/1520-0469(1980)037<0630:TSATRT>2.0.CO;2), where γ₁ ∓ γ₂ are 2(1 − ω') and 3(1 −
//! ω'g')/2, and γ₃ = (2 − 3g'μ₀)/4.

use crate::medium::Medium;

/// Total transmittance of a slab over a black ground for a beam with cosine `mu`, where kμ ≠ 1.
pub(crate) fn delta_eddington(medium: &Medium, thickness_cm: f64, mu: f64) -> f64 {
    let (lost, g) = (medium.scattering.one_minus_albedo, medium.scattering.asymmetry());
    let forward = g * g;
    let depth_ratio = (1.0 - forward) + forward * lost;
    let tau = depth_ratio * medium.extinction_per_m * thickness_cm * 0.01;
    let (lost, g) = (lost / depth_ratio, g / (1.0 + g));
    let (difference, sum) = (2.0 * lost, 1.5 * (1.0 - g + g * lost));
    let (gamma_1, gamma_2) = (0.5 * (sum + difference), 0.5 * (sum - difference));
    let gamma_3 = 0.25 * (2.0 - 3.0 * g * mu);
    let gamma_4 = 1.0 - gamma_3;
    let alpha_1 = gamma_1 * gamma_4 + gamma_2 * gamma_3;
    let k = (difference * sum).sqrt();
    // Both sides of the equation are divided by e^{kτ}.
    let (direct, fading) = ((-tau / mu).exp(), (-2.0 * k * tau).exp());
    let bracket = ((1.0 + k * mu) * (alpha_1 + k * gamma_4) - (1.0 - k * mu) * (alpha_1 - k * gamma_4) * fading)
        * direct
        - 2.0 * k * (gamma_4 + alpha_1 * mu) * (-k * tau).exp();
    let below = (1.0 - k * k * mu * mu) * ((k + gamma_1) + (k - gamma_1) * fading);
    direct - (1.0 - lost) * bracket / below
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::HenyeyGreenstein;

    fn medium(one_minus_albedo: f64, g: f64) -> Medium {
        Medium {
            extinction_per_m: 100.0,
            scattering: HenyeyGreenstein { one_minus_albedo, asymmetry: g }.scattering(2),
        }
    }

    /// Without absorption, Eddington's approximation has a closed form:
    /// T = ((2 + 3μ) + (2 − 3μ) e^{−τ/μ})/(4 + 3(1 − g)τ), here for g = 0.
    #[test]
    fn slabs_without_absorption_have_eddingtons_closed_form() {
        for (thickness_cm, mu) in [(1.0, 1.0), (5.0, 0.6), (30.0, 0.2)] {
            let tau: f64 = thickness_cm;
            let expected = ((2.0 + 3.0 * mu) + (2.0 - 3.0 * mu) * (-tau / mu).exp()) / (4.0 + 3.0 * tau);
            let found = delta_eddington(&medium(1e-10, 0.0), thickness_cm, mu);
            assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
        }
    }

    #[test]
    fn deep_slabs_transmit_a_positive_fraction() {
        let found = delta_eddington(&medium(0.1, 0.7), 1000.0, 0.8);
        assert!(found > 0.0 && found < 1e-50, "{found}");
    }
}
