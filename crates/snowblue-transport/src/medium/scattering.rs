//! A homogeneous medium: its extinction coefficient and its law of single scattering.
//!
//! The phase function is p(cos Θ) = Σ (2l + 1) χ_l P_l(cos Θ), so χ_0 = 1 and χ_1 = g.

use crate::dual::Real;

/// Single scattering of a medium: co-albedo and phase function.
#[derive(Debug, Clone, PartialEq)]
pub struct Scattering<T = f64> {
    /// 1 − ω, the probability that an extinction event absorbs. In snow it is as small as 3·10⁻⁸, so it is stored
    /// instead of the albedo ω, which would lose it to rounding.
    pub one_minus_albedo: T,
    /// Legendre moments χ_0 = 1, χ_1 = g, … of the phase function of the scattered light.
    pub moments: Vec<T>,
}

/// A homogeneous medium at one wavelength.
#[derive(Debug, Clone, PartialEq)]
pub struct Medium<T = f64> {
    /// Extinction coefficient κ, in 1/m.
    pub extinction_per_m: T,
    /// Single scattering per unit of optical depth.
    pub scattering: Scattering<T>,
}

/// Single scattering with the Henyey–Greenstein (1941) phase function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HenyeyGreenstein {
    /// Co-albedo 1 − ω.
    pub one_minus_albedo: f64,
    /// Asymmetry parameter g.
    pub asymmetry: f64,
}

impl HenyeyGreenstein {
    /// The moments χ_l = g^l for l = 0 … `degree`, which serve up to `degree` streams.
    #[must_use]
    pub fn scattering(self, degree: usize) -> Scattering {
        let Self { one_minus_albedo, asymmetry } = self;
        let moments = std::iter::successors(Some(1.0), |chi| Some(chi * asymmetry)).take(degree + 1).collect();
        Scattering { one_minus_albedo, moments }
    }
}

impl Scattering {
    /// Asymmetry parameter g = χ_1, the mean cosine of the scattering angle.
    #[must_use]
    pub fn asymmetry(&self) -> f64 {
        self.moments[1]
    }
}

/// A mixture of media and an absorber.
///
/// Each part j adds κ_j to the extinction; phase functions are averaged with the weights κ_j ω_j, and 1 − ω is summed
/// from the absorption of each part, never as a difference.
pub(super) fn mix<T: Real>(parts: &[Medium<T>], absorption_per_m: T) -> Medium<T> {
    let (mut extinction_per_m, mut absorbed_per_m, mut scattered_per_m) =
        (absorption_per_m, absorption_per_m, T::from(0.0));
    let mut moments = vec![T::from(0.0); parts[0].scattering.moments.len()];
    for Medium { extinction_per_m: part_per_m, scattering } in parts {
        let kept_per_m = *part_per_m * (T::from(1.0) - scattering.one_minus_albedo);
        extinction_per_m += *part_per_m;
        absorbed_per_m += *part_per_m * scattering.one_minus_albedo;
        scattered_per_m += kept_per_m;
        for (sum, moment) in moments.iter_mut().zip(&scattering.moments) {
            *sum += kept_per_m * *moment;
        }
    }
    moments.iter_mut().for_each(|moment| *moment = *moment / scattered_per_m);
    // Removes the rounding of χ_0 = 1.
    moments[0] = T::from(1.0);
    let scattering = Scattering { one_minus_albedo: absorbed_per_m / extinction_per_m, moments };
    Medium { extinction_per_m, scattering }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mixture_conserves_absorption_and_weights_moments_by_scattering() {
        let parts = [
            (3.0, Scattering { one_minus_albedo: 0.1, moments: vec![1.0, 0.8, 0.6] }),
            (1.0, Scattering { one_minus_albedo: 0.4, moments: vec![1.0, 0.2, 0.1] }),
        ]
        .map(|(extinction_per_m, scattering)| Medium { extinction_per_m, scattering });
        let Medium { extinction_per_m, scattering } = mix(&parts, 0.5);
        assert!((extinction_per_m - 4.5).abs() < 1e-15);
        assert!((scattering.one_minus_albedo - (0.3 + 0.4 + 0.5) / 4.5).abs() < 1e-15);
        assert!((scattering.moments[1] - (2.7 * 0.8 + 0.6 * 0.2) / 3.3).abs() < 1e-15);
    }
}
