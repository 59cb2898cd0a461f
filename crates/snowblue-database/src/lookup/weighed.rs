//! Sums of a snow's spectra with given weights, without the spectra: the colour of light that comes through, looked up at
//! once.
//!
//! The light of one lamp through one snow is a colour at each thickness and angle. Its logarithms bend a little more along
//! the thickness than those of single wavelengths do, as the mean of exponentials with different slopes; on cells a sixteenth as
//! wide they differ from the sums of the spectrum by less than 2·10⁻⁴, and are there for a tenth of the work.

use super::basis::four_powers_of_two;
use super::resampled::{Resampled, THIN_CM};
use super::{Curves, HORIZON_DEG, PcaSnow};

/// Sums that are looked up together.
pub const SUMS: usize = 4;

/// Bits of mantissa that tell a cell along the thickness.
const FINE: u32 = 7;

/// Thinnest snow of which reflectance is taken, in cm: below, it is in proportion to the thickness.
const THINNEST_CM: f32 = 1e-6;

/// Weighted sums of the transmittance and the reflectance of one snow.
#[derive(Debug, Clone)]
pub struct WeighedSnow {
    bare: [f32; SUMS],
    transmittance: Resampled,
    reflectance: Resampled,
    most_cm: f32,
}

impl PcaSnow {
    /// The sums of transmittance and reflectance with some weights, four of them at each wavelength, for all thicknesses and
    /// angles. None out of a table of the paper's form, whose spectra may go below 0.
    ///
    /// # Panics
    /// If there are not as many weights as wavelengths, or weights below 0.
    #[must_use]
    pub fn weighed(&self, weights: &[[f32; SUMS]]) -> Option<WeighedSnow> {
        let mut spectrum = vec![1.0; weights.len()];
        self.check_length(&spectrum);
        assert!(weights.iter().flatten().all(|weight| *weight >= 0.0), "logarithms need weights of 0 or more");
        let Curves::Log { transmittance, .. } = &self.curves else { return None };
        let angles_deg = transmittance.angles_deg();
        let most_cm = self.last_thickness_cm / self.thicker;
        let sums = |spectrum: &[f32]| {
            let mut sums = [0.0; SUMS];
            for (value, weights) in spectrum.iter().zip(weights) {
                sums.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += value * weight);
            }
            sums
        };
        let bare = sums(&spectrum);
        let passing = Resampled::of_four((angles_deg, most_cm), FINE, |thickness_cm, angle_deg| {
            self.transmittance(thickness_cm, angle_deg, &mut spectrum);
            sums(&spectrum).map(logarithm)
        });
        let returned = Resampled::of_four((angles_deg, most_cm), FINE, |thickness_cm, angle_deg| {
            let thickness_cm = thickness_cm.max(THINNEST_CM);
            self.reflectance(thickness_cm, angle_deg, &mut spectrum);
            sums(&spectrum).map(|sum| logarithm(sum * (thickness_cm + THIN_CM) / thickness_cm))
        });
        Some(WeighedSnow { bare, transmittance: passing, reflectance: returned, most_cm })
    }
}

impl WeighedSnow {
    /// The thickness in cm up to which transmittance is known; there are no colours of thicker snow here.
    #[must_use]
    pub const fn most_cm(&self) -> f32 {
        self.most_cm
    }

    /// Sums of transmittance through `thickness_cm`, up to [`most_cm`](Self::most_cm), for light at `angle_deg` from the
    /// normal.
    #[must_use]
    #[inline]
    pub fn transmittance(&self, thickness_cm: f32, angle_deg: f32) -> [f32; SUMS] {
        if angle_deg >= HORIZON_DEG {
            return [0.0; SUMS];
        }
        if thickness_cm <= 0.0 {
            return self.bare;
        }
        four_powers_of_two(self.transmittance.four(thickness_cm, angle_deg).to_array())
    }

    /// Sums of reflectance of `thickness_cm` for light at `angle_deg` from the normal.
    #[must_use]
    #[inline]
    pub fn reflectance(&self, thickness_cm: f32, angle_deg: f32) -> [f32; SUMS] {
        if thickness_cm <= 0.0 || angle_deg >= HORIZON_DEG {
            return [0.0; SUMS];
        }
        let thickness_cm = thickness_cm.min(self.most_cm);
        let factor = thickness_cm / (thickness_cm + THIN_CM);
        let mut sums = four_powers_of_two(self.reflectance.four(thickness_cm, angle_deg).to_array());
        sums.iter_mut().for_each(|sum| *sum *= factor);
        sums
    }
}

/// In base 2, and of nothing one that is taken for nothing.
fn logarithm(sum: f32) -> f32 {
    const NOTHING: f32 = -200.0;
    if sum > 0.0 { sum.log2() } else { NOTHING }
}
