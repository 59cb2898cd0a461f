//! Spectra at the 31 wavelengths of an image: 400–700 nm in steps of 10 nm.
//!
//! Radiometric quantities are *band densities*: a sample is the spectral quantity (per nm) times the width of the whole
//! grid, 31 × 10 nm = 310 nm. The mean of the 31 samples is then the total over the grid: a radiance whose samples are
//! all 1 is a radiance of 1 W m⁻² sr⁻¹. Reflectances and transmittances need no such factor.

pub mod emission;
pub(crate) mod file;
pub mod light_spectrum;
pub(crate) mod upsampling;

use std::ops::{AddAssign, Mul, MulAssign};

/// Number of wavelengths.
pub const SAMPLES: usize = 31;

/// First wavelength, in nm.
pub const FIRST_WAVELENGTH_NM: f64 = 400.0;

/// Distance between wavelengths, in nm.
pub const WAVELENGTH_STEP_NM: f64 = 10.0;

/// The wavelengths of a [`Spectrum`], in nm.
pub fn wavelengths_nm() -> [f64; SAMPLES] {
    let mut nm = FIRST_WAVELENGTH_NM - WAVELENGTH_STEP_NM;
    [(); SAMPLES].map(|()| {
        nm += WAVELENGTH_STEP_NM;
        nm
    })
}

/// A quantity at each of the [`wavelengths_nm`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spectrum(pub [f32; SAMPLES]);

impl Spectrum {
    /// 0 at every wavelength.
    pub const ZERO: Self = Self([0.0; SAMPLES]);

    /// 1 at every wavelength.
    pub const ONE: Self = Self([1.0; SAMPLES]);

    /// The same value at every wavelength.
    pub fn constant(value: f32) -> Self {
        Self([value; SAMPLES])
    }

    /// Mean over the wavelengths. For a band density this is the total over the grid.
    pub fn mean(&self) -> f64 {
        self.0.iter().map(|&sample| f64::from(sample)).sum::<f64>() / SAMPLES as f64
    }

    /// The greatest sample.
    pub fn maximum(&self) -> f32 {
        self.0.iter().copied().fold(f32::NEG_INFINITY, f32::max)
    }

    /// The least sample.
    pub fn minimum(&self) -> f32 {
        self.0.iter().copied().fold(f32::INFINITY, f32::min)
    }

    /// Adds `factor · a · b`, wavelength by wavelength.
    #[inline]
    pub fn add_product(&mut self, factor: f32, a: &Self, b: &Self) {
        for (sum, (x, y)) in self.0.iter_mut().zip(a.0.iter().zip(&b.0)) {
            *sum += factor * x * y;
        }
    }

    /// Sum of products, wavelength by wavelength.
    #[inline]
    pub fn dot(&self, weights: &Self) -> f32 {
        self.0.iter().zip(&weights.0).map(|(x, y)| x * y).sum()
    }
}

impl Mul for Spectrum {
    type Output = Self;

    #[inline]
    fn mul(mut self, other: Self) -> Self {
        self *= other;
        self
    }
}

impl Mul<f32> for Spectrum {
    type Output = Self;

    #[inline]
    fn mul(self, factor: f32) -> Self {
        Self(self.0.map(|sample| sample * factor))
    }
}

impl MulAssign for Spectrum {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        for (sample, factor) in self.0.iter_mut().zip(&other.0) {
            *sample *= factor;
        }
    }
}

impl AddAssign for Spectrum {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        for (sample, term) in self.0.iter_mut().zip(&other.0) {
            *sample += term;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_is_400_to_700_nm_in_steps_of_10_nm() {
        let grid = wavelengths_nm();
        assert_eq!(grid.len(), 31);
        assert!(
            (grid[0] - 400.0).abs() < 1e-12 && (grid[15] - 550.0).abs() < 1e-12 && (grid[30] - 700.0).abs() < 1e-12
        );
    }

    #[test]
    fn operations_act_wavelength_by_wavelength() {
        let ramp = Spectrum(std::array::from_fn(|k| k as f32));
        let mut sum = Spectrum::ONE;
        sum.add_product(2.0, &ramp, &ramp);
        assert!((sum.0[3] - 19.0).abs() < 1e-6);
        assert!((ramp.mean() - 15.0).abs() < 1e-12);
        assert!((ramp.dot(&Spectrum::ONE) - 465.0).abs() < 1e-3);
        assert!((ramp.maximum() - 30.0).abs() < 1e-6);
    }
}
