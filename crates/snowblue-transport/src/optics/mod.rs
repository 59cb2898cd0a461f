//! Optical constants of ice, water and impurities, and Fresnel's equations at a smooth interface between two
//! transparent media (Born & Wolf 1999, *Principles of Optics*, §1.5.2).
//!
//! The absorption of ice is far too weak in 300–2500 nm to change these equations (k < 10⁻² there), so indices are
//! real.

pub mod ice;
pub mod impurity;
mod index_nodes;
mod spectral_table;
pub mod water;
mod wavelengths;

use crate::dual::Real;
pub use ice::IceTable;
pub use impurity::{Impurities, OwnParticles, Substance};
pub(crate) use index_nodes::{IndexNodes, lagrange};
pub(crate) use spectral_table::SpectralTable;
pub use spectral_table::WavelengthRange;
pub use wavelengths::Wavelengths;

/// Reflection and refraction of unpolarised light at an interface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fresnel {
    /// Reflected fraction of the power, mean of both polarisations; 1 under total internal reflection.
    pub reflectance: f64,
    /// Cosine of the angle of refraction; 0 under total internal reflection.
    pub cos_refraction: f64,
}

/// Reflection and refraction of light that arrives with `cos_incidence` at a medium of relative index n_t/n_i.
///
/// ```
/// # use snowblue_transport::optics::fresnel;
/// // Ice in air reflects 2 % of light at normal incidence.
/// assert!((fresnel(1.0, 1.31).reflectance - (0.31_f64 / 2.31).powi(2)).abs() < 1e-15);
/// ```
#[must_use]
#[inline]
pub fn fresnel(cos_incidence: f64, relative_index: f64) -> Fresnel {
    let (cos_refraction, [s, p]) = polarised(cos_incidence, relative_index);
    Fresnel { reflectance: 0.5 * (s + p), cos_refraction }
}

/// The share of unpolarised light that a pane without absorption transmits, by the refractive index of the pane
/// relative to the medium around it. The light that goes to and fro between the two faces counts: ½ Σ (1 − R)²/(1 − R²)
/// over both polarisations, with the reflectance R of a face (Stokes 1860, *On the intensity of the light reflected
/// from or transmitted through a pile of plates*, Proceedings of the Royal Society 11, 545–556).
///
/// ```
/// # use snowblue_transport::optics::pane_transmittance;
/// // At normal incidence, this is 2n/(n² + 1): window glass transmits 92 % of light.
/// assert!((pane_transmittance(1.0, 1.52) - 3.04 / (1.52 * 1.52 + 1.0)).abs() < 1e-15);
/// ```
#[must_use]
pub fn pane_transmittance(cos_incidence: f64, relative_index: f64) -> f64 {
    let (_, [s, p]) = polarised(cos_incidence, relative_index);
    0.5 * ((1.0 - s) / (1.0 + s) + (1.0 - p) / (1.0 + p))
}

/// Reflection and refraction of polarised light: the cosine of the angle of refraction, and the reflectances of s-
/// and p-polarised light.
#[inline]
pub(crate) fn polarised<T: Real>(cos_incidence: T, relative_index: f64) -> (T, [T; 2]) {
    let one = T::from(1.0);
    let square = one - (one - cos_incidence * cos_incidence) / (relative_index * relative_index);
    if square.value() <= 0.0 {
        return (T::from(0.0), [one; 2]);
    }
    let cos_refraction = square.sqrt();
    let s = (cos_incidence - cos_refraction * relative_index) / (cos_incidence + cos_refraction * relative_index);
    let p = (cos_incidence * relative_index - cos_refraction) / (cos_incidence * relative_index + cos_refraction);
    (cos_refraction, [s * s, p * p])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflectance_is_equal_from_both_sides() {
        for cos in [0.9, 0.5, 0.1] {
            let down = fresnel(cos, 1.31);
            let up = fresnel(down.cos_refraction, 1.0 / 1.31);
            // The cosine is the root of a difference near cos², so rounding grows as 1/cos.
            assert!((up.cos_refraction - cos).abs() < 1e-15 / cos);
            assert!((up.reflectance - down.reflectance).abs() < 1e-14);
        }
    }

    #[test]
    fn only_s_polarised_light_is_reflected_at_the_brewster_angle() {
        let n: f64 = 1.31;
        let cos = 1.0 / n.hypot(1.0);
        let s = ((n * n - 1.0) / (n * n + 1.0)).powi(2);
        assert!((fresnel(cos, n).reflectance - 0.5 * s).abs() < 1e-15);
    }

    #[test]
    fn light_beyond_the_critical_angle_is_totally_reflected() {
        assert!((fresnel(0.6, 1.0 / 1.31).reflectance - 1.0).abs() < 1e-15);
        assert!(fresnel(0.7, 1.0 / 1.31).reflectance < 1.0);
    }
}
