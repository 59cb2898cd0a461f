//! A layer of cloud: its transmittance and reflectance, 610–2600 nm.
//!
//! Its droplets have an effective radius of 10 µm. `data/cloud_droplets.csv` has the fraction of light that a droplet
//! absorbs and the mean cosine of its scattering angle by the theory of Mie, for the water of Rowe, Fergoda & Neshyba
//! (2020, J. Geophys. Res. Atmos. 125, e2020JD032624) at 273 K. Diffuse light passes the layer as two streams with
//! Eddington's coefficients (Meador & Weaver 1980, J. Atmos. Sci. 37, 630, table 1).

use std::sync::LazyLock;

use crate::tables::{INFRARED_WAVELENGTHS, shipped};

const HEADER: &str = "wavelength_nm,coalbedo,asymmetry,absorption_per_m";

/// Wavelength in nm, fraction of its extinction that a droplet absorbs, mean cosine of the scattering angle, and the
/// absorption of water in 1/m.
static TABLE: LazyLock<Vec<[f64; 4]>> =
    LazyLock::new(|| shipped(include_str!("../data/cloud_droplets.csv"), HEADER, &[[]; INFRARED_WAVELENGTHS]));

/// Transmittance and reflectance of a layer under diffuse light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cloud {
    pub(crate) transmittance: f64,
    pub(crate) reflectance: f64,
}

impl Cloud {
    /// A layer of an optical thickness, at each wavelength of the table of the air.
    pub(crate) fn table(optical_thickness: f64) -> impl Iterator<Item = Self> {
        TABLE.iter().map(move |[_, coalbedo, asymmetry, _]| Self::new(*coalbedo, *asymmetry, optical_thickness))
    }

    fn new(coalbedo: f64, g: f64, optical_thickness: f64) -> Self {
        let albedo = 1.0 - coalbedo;
        let lost = 0.25 * (7.0 - albedo * (4.0 + 3.0 * g));
        let turned_back = 0.25 * (albedo * (4.0 - 3.0 * g) - 1.0);
        let decay = (lost * lost - turned_back * turned_back).sqrt();
        // Reflectance of an infinitely thick layer.
        let deep = turned_back / (lost + decay);
        let passing = (-decay * optical_thickness).exp();
        let echo = 1.0 - (deep * passing).powi(2);
        Self {
            transmittance: passing * (1.0 - deep * deep) / echo,
            reflectance: deep * (1.0 - passing * passing) / echo,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_the_wavelengths_of_the_air() {
        let air = include_str!("../data/bird_riordan_1986.csv").lines().skip(1);
        let of_air: Vec<f64> = air.map(|line| line.split(',').next().unwrap().parse().unwrap()).collect();
        assert_eq!(TABLE.iter().map(|row| row[0]).collect::<Vec<_>>(), of_air);
        assert!(TABLE.iter().all(|row| row[1..3].iter().all(|value| (0.0..1.0).contains(value))));
    }

    /// The absorption cross section of a large, weakly absorbing sphere is n² (1 − (1 − n⁻²)^3/2) α V, and half of
    /// its scattering is diffraction, so that 1 − ω is 0.84 α r for n = 1.32. Edge waves add some 15 % to droplets of
    /// 10 µm (Nussenzveig & Wiscombe 1980, Phys. Rev. Lett. 45, 1490).
    #[test]
    fn droplets_absorb_as_large_spheres() {
        for [wavelength_nm, coalbedo, _, absorption_per_m] in
            TABLE.iter().filter(|row| (700.0..1350.0).contains(&row[0]))
        {
            let over_rays = coalbedo / (0.84 * absorption_per_m * 10e-6);
            assert!((1.05..1.3).contains(&over_rays), "{wavelength_nm} nm: {over_rays}");
        }
    }

    /// Without absorption no light is lost and T = 1/(1 + 3/4 (1 − g) τ). With absorption the transmittance of a
    /// thick layer tends to e^{−Kτ}, and its reflectance tends to the reflectance of an infinitely thick layer.
    #[test]
    fn layers_tend_to_their_limits() {
        let layer = |coalbedo, optical_thickness| Cloud::new(coalbedo, 0.86, optical_thickness);
        let clear = layer(1e-12, 20.0);
        assert!((clear.transmittance - 1.0 / (1.0 + 0.75 * 0.14 * 20.0)).abs() < 1e-6, "{clear:?}");
        assert!((clear.transmittance + clear.reflectance - 1.0).abs() < 1e-6);
        let (thin, thick, thicker) = (layer(0.01, 1e-9), layer(0.01, 100.0), layer(0.01, 120.0));
        assert!((thin.transmittance - 1.0).abs() < 1e-8 && thin.reflectance < 1e-8);
        let decay = (thick.transmittance / thicker.transmittance).ln() / 20.0;
        // K² = 3 (1 − ω) (1 − ω g) (Meador & Weaver 1980).
        assert!((decay / (3.0_f64 * 0.01 * (1.0 - 0.99 * 0.86)).sqrt() - 1.0).abs() < 1e-5, "{decay}");
        assert!((thick.reflectance - thicker.reflectance).abs() < 1e-4);
    }
}
