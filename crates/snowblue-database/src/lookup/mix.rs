//! A mix of two snow samples of one table, for objects whose snow varies over their surface.
//!
//! The logarithms of transmittance and reflectance are interpolated, ln T = (1 − s) ln T₁ + s ln T₂. They are linear in
//! the coefficients, so the coefficients are mixed and the spectrum is evaluated once.

use super::basis::{PADDED_COMPONENTS, Scale};
use super::pca_snow::{Curves, HORIZON_DEG, PcaSnow};
use super::resampled_grid::OFFSET_CM;

/// A mix of two snow samples of the same table.
#[derive(Debug, Clone, Copy)]
pub struct SnowMix<'snow> {
    first: &'snow PcaSnow,
    second: &'snow PcaSnow,
    fraction: f32,
}

impl<'snow> SnowMix<'snow> {
    /// One sample alone.
    #[must_use]
    pub const fn single(snow: &'snow PcaSnow) -> Self {
        Self { first: snow, second: snow, fraction: 0.0 }
    }

    /// A fraction of the second sample, 0–1, and the rest of the first. Samples of a table in linear space are not
    /// mixed, since the paper's scheme does not interpolate between samples: the one with the larger fraction is taken.
    #[must_use]
    pub const fn new(first: &'snow PcaSnow, second: &'snow PcaSnow, fraction: f32) -> Self {
        match (&first.curves, &second.curves) {
            (Curves::Log { .. }, Curves::Log { .. }) => Self { first, second, fraction },
            _ if fraction < 0.5 => Self::single(first),
            _ => Self::single(second),
        }
    }

    /// Angle of incidence to look up, in degrees: [`PcaSnow::look_up_angle_deg`].
    #[must_use]
    #[inline]
    pub fn look_up_angle_deg(&self, cos_incidence: f32) -> f32 {
        self.first.look_up_angle_deg(cos_incidence)
    }

    /// Writes the spectral transmittance of `thickness_cm` for light at `angle_deg` from the normal into `spectrum`.
    ///
    /// # Panics
    /// If the length of `spectrum` is not the number of wavelengths.
    pub fn transmittance(&self, thickness_cm: f32, angle_deg: f32, spectrum: &mut [f32]) {
        // The result is then independent of the mix.
        if self.fraction <= 0.0 || thickness_cm <= 0.0 || angle_deg >= HORIZON_DEG {
            return self.first.transmittance(thickness_cm, angle_deg, spectrum);
        }
        self.first.check_length(spectrum);
        let (mut mixed, mut second) = ([0.0; PADDED_COMPONENTS], [0.0; PADDED_COMPONENTS]);
        self.first.transmittance_coefficients(thickness_cm, angle_deg, &mut mixed);
        self.second.transmittance_coefficients(thickness_cm, angle_deg, &mut second);
        mixed.iter_mut().zip(second).for_each(|(mixed, second)| *mixed += self.fraction * (second - *mixed));
        self.first.transmittance_basis.transmittance(&mixed, spectrum);
    }

    /// Writes the spectral reflectance of `thickness_cm` for light at `angle_deg` from the normal into `spectrum`.
    ///
    /// # Panics
    /// If the length of `spectrum` is not the number of wavelengths.
    pub fn reflectance(&self, thickness_cm: f32, angle_deg: f32, spectrum: &mut [f32]) {
        let (Curves::Log { reflectance: first, .. }, Curves::Log { reflectance: second, .. }) =
            (&self.first.curves, &self.second.curves)
        else {
            return self.first.reflectance(thickness_cm, angle_deg, spectrum);
        };
        if self.fraction <= 0.0 || thickness_cm <= 0.0 || angle_deg >= HORIZON_DEG {
            return self.first.reflectance(thickness_cm, angle_deg, spectrum);
        }
        self.first.check_length(spectrum);
        let (mut mixed, mut other) = ([0.0; PADDED_COMPONENTS], [0.0; PADDED_COMPONENTS]);
        let [first_cm, second_cm] = [self.first, self.second].map(|snow| snow.equivalent_thickness_cm(thickness_cm));
        first.coefficients(first_cm, angle_deg, &mut mixed);
        second.coefficients(second_cm, angle_deg, &mut other);
        mixed.iter_mut().zip(other).for_each(|(mixed, other)| *mixed += self.fraction * (other - *mixed));
        let [first_factor, second_factor] = [first_cm, second_cm].map(|h| h / (h + OFFSET_CM));
        let factor = first_factor * (second_factor / first_factor).powf(self.fraction);
        let scale = Scale { factor, log2: mixed[self.first.count] };
        self.first.reflectance_basis.powers_of_two(&mixed, scale, spectrum);
    }
}
