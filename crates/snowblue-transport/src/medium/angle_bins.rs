//! Bins of scattering angles, of equal width in u = sin Θ/2 = √((1 − cos Θ)/2): narrow in the forward direction, where
//! phase functions of grains are steep.
//!
//! With cos Θ = 1 − 2u², the solid angle is dΩ = 2π d(cos Θ) = 8π u du.

use std::f64::consts::PI;

/// A number of bins of equal width in u.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct AngleBins(pub(crate) usize);

/// u = sin Θ/2 of a scattering angle.
#[inline]
pub(crate) fn half_angle_sine(cos_scattering: f64) -> f64 {
    (0.5 * (1.0 - cos_scattering)).max(0.0).sqrt()
}

impl AngleBins {
    /// The bin of an angle.
    #[inline]
    pub(crate) fn bin(self, cos_scattering: f64) -> usize {
        let position = half_angle_sine(cos_scattering) * self.0 as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 ≤ position, clamped to the last bin"
        )]
        let bin = (position as usize).min(self.0 - 1);
        bin
    }

    /// Solid angle of a bin, 4π (u₂² − u₁²), in sr.
    pub(crate) fn solid_angle_sr(self, bin: usize) -> f64 {
        let (first, last) = (bin as f64 / self.0 as f64, (bin + 1) as f64 / self.0 as f64);
        4.0 * PI * (last * last - first * first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_cover_the_sphere_and_contain_their_angles() {
        let bins = AngleBins(128);
        let sphere_sr: f64 = (0..128).map(|bin| bins.solid_angle_sr(bin)).sum();
        assert!((sphere_sr - 4.0 * PI).abs() < 1e-13);
        assert!((bins.bin(1.0), bins.bin(-1.0)) == (0, 127));
        // u² = 1/4 at 60°.
        assert!(bins.bin(0.5 + 1e-9) == 63 && bins.bin(0.5 - 1e-9) == 64);
    }
}
