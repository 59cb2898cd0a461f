//! Snow between two others of one table, without a look-up of its own: for objects whose snow changes from place to place.
//!
//! The logarithms of transmittance and reflectance are mixed, ln T = (1 − s) ln T₁ + s ln T₂. They are sums of components,
//! so that mixing these is enough, and a mixture costs one spectrum.

use super::basis::LANES;
use super::resampled::THIN_CM;
use super::{Curves, HORIZON_DEG, PcaSnow};

/// A mixture of two snows out of the same table.
#[derive(Debug, Clone, Copy)]
pub struct Between<'snow> {
    first: &'snow PcaSnow,
    second: &'snow PcaSnow,
    share: f32,
}

impl<'snow> Between<'snow> {
    /// One snow alone.
    #[must_use]
    pub const fn only(snow: &'snow PcaSnow) -> Self {
        Self { first: snow, second: snow, share: 0.0 }
    }

    /// `share` of the second snow, from 0 to 1, and of the first the rest. Snows of the paper's form, which knows none
    /// between those of its table, are not mixed: the one with the greater share counts.
    #[must_use]
    pub const fn new(first: &'snow PcaSnow, second: &'snow PcaSnow, share: f32) -> Self {
        match (&first.curves, &second.curves) {
            (Curves::Log { .. }, Curves::Log { .. }) => Self { first, second, share },
            _ if share < 0.5 => Self::only(first),
            _ => Self::only(second),
        }
    }

    /// Transmittance at each wavelength through `thickness_cm` for light at `angle_deg` from the normal, into `spectrum`.
    ///
    /// # Panics
    /// If `spectrum` has not as many values as there are wavelengths.
    pub fn transmittance(&self, thickness_cm: f32, angle_deg: f32, spectrum: &mut [f32]) {
        // No snow is no snow of any kind, and nothing comes from below the horizon.
        if self.share <= 0.0 || thickness_cm <= 0.0 || angle_deg >= HORIZON_DEG {
            return self.first.transmittance(thickness_cm, angle_deg, spectrum);
        }
        self.first.check_length(spectrum);
        let (mut mixed, mut second) = ([0.0; LANES], [0.0; LANES]);
        self.first.transmittance_coefficients(thickness_cm, angle_deg, &mut mixed);
        self.second.transmittance_coefficients(thickness_cm, angle_deg, &mut second);
        mixed.iter_mut().zip(second).for_each(|(one, other)| *one += self.share * (other - *one));
        self.first.transmittance_basis.shares(&mixed, spectrum);
    }

    /// Reflectance at each wavelength of `thickness_cm` for light at `angle_deg` from the normal, into `spectrum`.
    ///
    /// # Panics
    /// If `spectrum` has not as many values as there are wavelengths.
    pub fn reflectance(&self, thickness_cm: f32, angle_deg: f32, spectrum: &mut [f32]) {
        let (Curves::Log { reflectance: first, .. }, Curves::Log { reflectance: second, .. }) =
            (&self.first.curves, &self.second.curves)
        else {
            return self.first.reflectance(thickness_cm, angle_deg, spectrum);
        };
        if self.share <= 0.0 || thickness_cm <= 0.0 || angle_deg >= HORIZON_DEG {
            return self.first.reflectance(thickness_cm, angle_deg, spectrum);
        }
        self.first.check_length(spectrum);
        let (mut mixed, mut other) = ([0.0; LANES], [0.0; LANES]);
        let [first_cm, second_cm] = [self.first, self.second].map(|snow| snow.seeming_thickness_cm(thickness_cm));
        first.coefficients(first_cm, angle_deg, &mut mixed);
        second.coefficients(second_cm, angle_deg, &mut other);
        mixed.iter_mut().zip(other).for_each(|(one, other)| *one += self.share * (other - *one));
        let [first_factor, second_factor] = [first_cm, second_cm].map(|h| h / (h + THIN_CM));
        let factor = first_factor * (second_factor / first_factor).powf(self.share);
        self.first.reflectance_basis.powers_of_two(&mixed, (mixed[self.first.count], factor), spectrum);
    }
}
