//! Optical constants of pure liquid water, for water in the pores of snow.
//!
//! - Refractive index: Daimon & Masumura 2007 (doi:10.1364/AO.46.003811), Sellmeier's formula at 20 °C, tabulated.
//! - Absorption: the Water Optical Properties Processor, version 3 (Röttgers, Doerffer, McKee & Schönfeld 2016) at
//!   20 °C, in the blue from Mason, Cone & Fry 2016 and Pope & Fry 1997. Older compilations are 20–50 times higher
//!   there.
//! - From 1225 nm: both by Rowe, Fergoda & Neshyba 2020 (doi:10.1029/2020JD032624), at 0 °C. The absorptions agree
//!   there: the step is 0.3 %. The index has a step of −0.0012. At shorter wavelengths the table of 0 °C has up to 38 %
//!   less absorption, between the bands of water.

use std::f64::consts::PI;
use std::sync::LazyLock;

use super::spectral_table::SpectralTable;

/// First wavelength of the table of Rowe et al. 2020, in nm.
const ROWE_FIRST_NM: f64 = 1225.0;

static ABSORPTION: LazyLock<SpectralTable> =
    LazyLock::new(|| SpectralTable::new(include_str!("../../data/water_absorption_wopp_v3.csv")));

static INDEX: LazyLock<SpectralTable> =
    LazyLock::new(|| SpectralTable::new(include_str!("../../data/water_index_daimon_2007.csv")));

static ROWE_2020: LazyLock<SpectralTable> =
    LazyLock::new(|| SpectralTable::new(include_str!("../../data/water_index_rowe_2020.csv")));

/// Refractive index of water, linear between the rows.
///
/// # Panics
/// Outside 300–2505 nm.
#[must_use]
pub fn index(wavelength_nm: f64) -> f64 {
    let table = if wavelength_nm < ROWE_FIRST_NM { &INDEX } else { &ROWE_2020 };
    table.at(wavelength_nm).linear(1)
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
/// Outside 300–2505 nm.
#[must_use]
pub fn absorption_per_m(wavelength_nm: f64) -> f64 {
    if wavelength_nm < ROWE_FIRST_NM {
        return ABSORPTION.at(wavelength_nm).double_logarithmic(1, wavelength_nm);
    }
    let k = ROWE_2020.at(wavelength_nm).double_logarithmic(2, wavelength_nm);
    4.0 * PI * k / (wavelength_nm * 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::WavelengthRange;

    #[test]
    fn tables_are_complete_and_ordered() {
        let rows = [&ABSORPTION, &INDEX, &ROWE_2020].map(|table| table.ordered_rows());
        assert_eq!(rows, [Some(551), Some(221), Some(129)]);
        let ranges = [&ABSORPTION, &INDEX, &ROWE_2020].map(|table| table.wavelength_range());
        let shorter = WavelengthRange::new(300.0, 1400.0);
        assert_eq!(ranges, [shorter, shorter, WavelengthRange::new(ROWE_FIRST_NM, 2505.0)]);
    }

    /// Absorption as printed: 400 nm from Mason et al. 2016, 700 nm from Röttgers et al. 2014; the index of water at
    /// the sodium line is 1.3330 against air, 1.3334 against vacuum (20 °C). Water absorbs most strongly at 1940 nm.
    #[test]
    fn water_in_print() {
        for (nm, absorption_per_m) in [(400.0, 0.00222), (500.0, 0.0207), (600.0, 0.2353), (700.0, 0.613)] {
            assert!((super::absorption_per_m(nm) / absorption_per_m - 1.0).abs() < 3e-3, "{nm}");
        }
        assert!((index(589.3) - 1.3334).abs() < 1e-4);
        let strongest = (150..=240).map(|ten| 10.0 * f64::from(ten));
        let strongest = strongest.max_by(|a, b| super::absorption_per_m(*a).total_cmp(&super::absorption_per_m(*b)));
        assert!(strongest.is_some_and(|nm| (nm - 1940.0).abs() <= 10.0), "{strongest:?}");
    }

    #[test]
    fn the_steps_at_the_join_are_small() {
        let below = ROWE_FIRST_NM - 1e-6;
        assert!((super::absorption_per_m(ROWE_FIRST_NM) / super::absorption_per_m(below) - 1.003).abs() < 5e-4);
        assert!((index(ROWE_FIRST_NM) - index(below) + 0.0012).abs() < 5e-5);
    }
}
