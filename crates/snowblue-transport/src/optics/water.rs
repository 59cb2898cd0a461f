//! Optical constants of pure liquid water at 20 °C, for water in the pores of snow.
//!
//! - Refractive index: Daimon & Masumura 2007 (doi:10.1364/AO.46.003811), Sellmeier's formula, tabulated.
//! - Absorption: the Water Optical Properties Processor, version 3 (Röttgers, Doerffer, McKee & Schönfeld 2016), in
//!   the blue from Mason, Cone & Fry 2016 and Pope & Fry 1997. Older compilations are 20–50 times higher there.

use std::sync::LazyLock;

use super::spectral_table::{SpectralTable, WavelengthRange};
use crate::TransportError;

/// Wavelengths that both tables cover.
pub const WAVELENGTH_RANGE: WavelengthRange = WavelengthRange::new(300.0, 1400.0);

static ABSORPTION: LazyLock<SpectralTable> =
    LazyLock::new(|| SpectralTable::new(include_str!("../../data/water_absorption_wopp_v3.csv")));

static INDEX: LazyLock<SpectralTable> =
    LazyLock::new(|| SpectralTable::new(include_str!("../../data/water_index_daimon_2007.csv")));

/// Checks that both tables cover `wavelength_nm`: 300–1400 nm.
///
/// # Errors
/// [`TransportError::Range`] if they do not.
pub fn check_wavelength(wavelength_nm: f64) -> Result<(), TransportError> {
    Ok(WAVELENGTH_RANGE.check("wavelength in wet snow", wavelength_nm)?)
}

/// Refractive index of water, linear between the rows.
///
/// # Panics
/// Outside 300–1400 nm.
#[must_use]
pub fn index(wavelength_nm: f64) -> f64 {
    INDEX.at(wavelength_nm).linear(1)
}

/// Absorption coefficient of water, in 1/m, log–log between the rows.
///
/// Water absorbs a fifth more than ice in the red, and three times as much in the blue:
/// ```
/// # use snowblue_transport::optics::{IceTable, water};
/// let over_ice = |nm| water::absorption_per_m(nm) / IceTable::WarrenBrandt2008.absorption_per_m(nm);
/// assert!((over_ice(700.0) - 1.2).abs() < 0.1 && over_ice(450.0) > 3.0);
/// ```
///
/// # Panics
/// Outside 300–1400 nm.
#[must_use]
pub fn absorption_per_m(wavelength_nm: f64) -> f64 {
    ABSORPTION.at(wavelength_nm).double_logarithmic(1, wavelength_nm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_complete_and_ordered() {
        assert_eq!((ABSORPTION.ordered_rows(), INDEX.ordered_rows()), (Some(551), Some(221)));
        assert_eq!([ABSORPTION.wavelength_range(), INDEX.wavelength_range()], [WAVELENGTH_RANGE; 2]);
    }

    /// Absorption as printed: 400 nm from Mason et al. 2016, 700 nm from Röttgers et al. 2014; the index of water at
    /// the sodium line is 1.3330 against air, 1.3334 against vacuum (20 °C).
    #[test]
    fn water_in_print() {
        for (nm, absorption_per_m) in [(400.0, 0.00222), (500.0, 0.0207), (600.0, 0.2353), (700.0, 0.613)] {
            assert!((super::absorption_per_m(nm) / absorption_per_m - 1.0).abs() < 3e-3, "{nm}");
        }
        assert!((index(589.3) - 1.3334).abs() < 1e-4);
        assert!(check_wavelength(1401.0).is_err());
    }
}
