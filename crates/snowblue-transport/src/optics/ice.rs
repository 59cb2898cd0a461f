//! Optical constants and density of ice Ih.
//!
//! The refractive index is n + ik. Two published tables of k differ by a factor of 7 at 450 nm and of 26 at 400 nm,
//! where ice is among the clearest of solids: Warren & Brandt 2008 (doi:10.1029/2007JD009744, inferred from light in
//! Antarctic snow) and Picard, Libois & Arnaud 2016 (doi:10.5194/tc-10-2655-2016, by this method with more profiles).
//! The hue of light behind 20 cm of snow depends on which table is right. Both tables are inferred, so the user
//! chooses.

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;
use std::sync::LazyLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::spectral_table::{SpectralTable, WavelengthRange};
use crate::error::{TransportError, find_by_name};

/// Wavelengths of the model, which tables of water and impurities cover. Beyond 2500 nm ice absorbs too strongly for
/// geometric optics.
const MODEL_RANGE: WavelengthRange = WavelengthRange::new(300.0, 2500.0);
/// First wavelength of the Picard 2016 table, in nm.
const PICARD_FIRST_NM: f64 = 320.0;
/// Wavelength from which Warren & Brandt 2008 continues the Picard 2016 table, in nm.
const PICARD_JOIN_NM: f64 = 610.0;

static WARREN_BRANDT_2008: LazyLock<SpectralTable> =
    LazyLock::new(|| SpectralTable::new(include_str!("../../data/warren_brandt_2008.csv")));

/// Picard 2016, with the join as its last row.
static PICARD_2016: LazyLock<SpectralTable> = LazyLock::new(|| {
    let join = format!("{PICARD_JOIN_NM},{}", absorption_per_m_warren_brandt_2008(PICARD_JOIN_NM));
    SpectralTable::new(&[include_str!("../../data/picard_2016_absorption.csv").trim_end(), &join].join("\n"))
});

/// A published table of the absorption of ice, and the optical constants of ice by it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub enum IceTable {
    /// Warren & Brandt 2008, which the paper cites.
    #[default]
    #[serde(rename = "warren2008")]
    WarrenBrandt2008,
    /// Picard, Libois & Arnaud 2016 from 320 to 600 nm, joined log-linearly to Warren & Brandt 2008 at 610 nm.
    #[serde(rename = "picard2016")]
    Picard2016,
}

impl IceTable {
    /// Every table.
    pub const ALL: [Self; 2] = [Self::WarrenBrandt2008, Self::Picard2016];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::WarrenBrandt2008 => "warren2008",
            Self::Picard2016 => "picard2016",
        }
    }

    /// The other table.
    pub(crate) fn other(self) -> Self {
        match self {
            Self::WarrenBrandt2008 => Self::Picard2016,
            Self::Picard2016 => Self::WarrenBrandt2008,
        }
    }

    /// The wavelengths of the model that the table covers.
    #[must_use]
    pub fn wavelength_range(self) -> WavelengthRange {
        match self {
            Self::WarrenBrandt2008 => MODEL_RANGE,
            Self::Picard2016 => WavelengthRange { first_nm: PICARD_FIRST_NM, ..MODEL_RANGE },
        }
    }

    /// Checks that the table and the model cover `wavelength_nm`.
    ///
    /// # Errors
    /// [`TransportError::Range`] if they do not.
    pub fn check_wavelength(self, wavelength_nm: f64) -> Result<(), TransportError> {
        Ok(self.wavelength_range().check("wavelength", wavelength_nm)?)
    }

    /// Real part n of the refractive index, linear between the rows of Warren & Brandt 2008.
    ///
    /// # Panics
    /// Outside the table, 199–4099 nm.
    #[must_use]
    pub fn index(self, wavelength_nm: f64) -> f64 {
        WARREN_BRANDT_2008.at(wavelength_nm).linear(1)
    }

    /// Absorption coefficient of ice, in 1/m: γ = 4π k / λ.
    ///
    /// Ice absorbs red some 200 times as strongly as blue (Warren & Brandt 2008):
    /// ```
    /// # use snowblue_transport::optics::IceTable;
    /// let ice = IceTable::WarrenBrandt2008;
    /// assert!(ice.absorption_per_m(700.0) > 150.0 * ice.absorption_per_m(450.0));
    /// ```
    ///
    /// # Panics
    /// Outside the table: below 199 nm or, for Picard 2016, 320 nm; beyond 4099 nm.
    #[must_use]
    pub fn absorption_per_m(self, wavelength_nm: f64) -> f64 {
        match self {
            // ln γ is linear in the wavelength between the 5 nm rows, and from the last row to the join.
            Self::Picard2016 if wavelength_nm < PICARD_JOIN_NM => PICARD_2016.at(wavelength_nm).logarithmic(1),
            _ => absorption_per_m_warren_brandt_2008(wavelength_nm),
        }
    }
}

/// Formats the name.
impl fmt::Display for IceTable {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

impl FromStr for IceTable {
    type Err = TransportError;

    fn from_str(name: &str) -> Result<Self, TransportError> {
        find_by_name("ice table", name, &Self::ALL, Self::name)
    }
}

/// Density of ice in kg/m³: 917 − 0.1403 T, with T in °C, here from −60 to 0 °C (Pounder 1965, *The Physics of Ice*, as
/// quoted by Cox & Weeks 1983, "Equations for determining the gas and brine volumes in sea-ice samples", Journal of
/// Glaciology 29, 306).
#[must_use]
pub fn density_kg_m3(temperature_c: f64) -> f64 {
    917.0 - 0.1403 * temperature_c
}

/// Heat capacity of ice in J kg⁻¹ K⁻¹: 152.5 + 7.122 T, with T in K (Cuffey & Paterson 2010, *The Physics of Glaciers*,
/// 4th edition, eq. 9.1).
#[must_use]
pub fn heat_capacity_j_kg_k(temperature_c: f64) -> f64 {
    152.5 + 7.122 * (temperature_c + 273.15)
}

/// Absorption coefficient of ice by Warren & Brandt 2008, in 1/m; k is interpolated log–log between the rows.
fn absorption_per_m_warren_brandt_2008(wavelength_nm: f64) -> f64 {
    let k = WARREN_BRANDT_2008.at(wavelength_nm).double_logarithmic(2, wavelength_nm);
    4.0 * PI * k / (wavelength_nm * 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_complete_and_ordered() {
        // With the join, Picard 2016 has one row more than in print.
        assert_eq!((WARREN_BRANDT_2008.ordered_rows(), PICARD_2016.ordered_rows()), (Some(223), Some(58)));
    }

    /// Warren & Brandt 2008, their printed table.
    #[test]
    fn warren_brandt_2008_in_print() {
        let ice = IceTable::WarrenBrandt2008;
        for (nm, n, k) in [(400.0, 1.3194, 2.365e-11), (500.0, 1.3130, 5.889e-10), (700.0, 1.3069, 2.900e-8)] {
            assert!((ice.index(nm) - n).abs() < 1e-12);
            assert!((ice.absorption_per_m(nm) * nm * 1e-9 / (4.0 * PI) / k - 1.0).abs() < 1e-12);
        }
    }

    /// Picard et al. 2016, final table, in 1/m.
    #[test]
    fn picard_2016_in_print() {
        let ice = IceTable::Picard2016;
        assert!((ice.absorption_per_m(400.0) - 0.01971).abs() < 5e-6);
        assert!((ice.absorption_per_m(500.0) - 0.03131).abs() < 5e-6);
        assert!((ice.absorption_per_m(600.0) - 0.13597).abs() < 5e-6);
        assert!(ice.check_wavelength(319.0).is_err());
    }

    #[test]
    fn picard_2016_is_continuous_at_the_join() {
        let (picard, warren) = (IceTable::Picard2016, IceTable::WarrenBrandt2008);
        let join = warren.absorption_per_m(610.0);
        assert!((picard.absorption_per_m(610.0) / join - 1.0).abs() < 1e-12);
        assert!((picard.absorption_per_m(609.999_999) / join - 1.0).abs() < 1e-6);
        assert!((picard.absorption_per_m(605.0).powi(2) / (join * picard.absorption_per_m(600.0)) - 1.0).abs() < 1e-12);
    }
}
