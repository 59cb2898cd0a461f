//! Impurities between the grains: small absorbing and scattering particles, given by their mass fraction.
//!
//! A mass fraction c (mass of the substance over mass of dry snow) of particles with mass extinction E, in m²/kg,
//! adds ρ c E to the extinction coefficient of snow of density ρ. The particles scatter the fraction ω of this
//! extinction, their single-scattering albedo, with the Henyey–Greenstein (1941) phase function. They lie outside the
//! grains.
//!
//! Optical properties are taken from BioSNICAR (Cook et al. 2020, doi:10.5194/tc-14-309-2020); [`Substance::source`]
//! names the paper behind each substance. BioSNICAR gives the extinction of algae in 10⁻⁹ m² per cell, with a mass of
//! 1 ng per cell.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;
use std::sync::LazyLock;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use snowblue_base::{Number, RangeError};

use super::spectral_table::{SpectralTable, WavelengthRange};
use crate::error::{TransportError, find_by_name};
use crate::parameters::MassFraction;

/// Wavelengths that the tables of all substances cover.
pub const WAVELENGTH_RANGE: WavelengthRange = WavelengthRange::new(305.0, 1495.0);

static TABLES: LazyLock<Vec<SpectralTable>> =
    LazyLock::new(|| ROWS.iter().map(|Row { csv, .. }| SpectralTable::new(csv)).collect());

/// Grams per kilogram.
const PER_GRAM: f64 = 1e3;

/// A substance that darkens snow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Substance {
    /// Uncoated black carbon that absorbs 7.5 m²/g at 550 nm.
    BlackCarbon,
    /// Saharan dust of 1.0–2.5 µm diameter, the central content of haematite.
    SaharanDust,
    /// Dust of the San Juan Mountains, Colorado, of 1.0–2.5 µm diameter.
    ColoradoDust,
    /// Uncoated brown carbon.
    BrownCarbon,
    /// Cells of red snow algae of 1 ng: ng/g are cells per g of snow.
    SnowAlgae,
    /// An impurity of tests.
    #[cfg(any(test, feature = "test-rows"))]
    TestDust,
}

/// Name, description and optical properties of a substance, for every user interface.
#[derive(Debug, Clone, Copy)]
struct Row {
    substance: Substance,
    name: &'static str,
    /// The name as a property of snow: words joined by underscores, with the unit.
    key: &'static str,
    text: &'static str,
    source: &'static str,
    /// Wavelength, in nm; extinction; albedo; asymmetry.
    csv: &'static str,
    /// Factor of the extinction in `csv` that gives m²/kg.
    extinction_factor: f64,
    /// Whether it scatters so far forward that it takes many streams.
    has_sharp_peak: bool,
    /// Median, in ng/g, of snow that contains it, and the standard deviation of the logarithm.
    usual_ng_g: (f64, f64),
}

/// The row of Saharan dust. Most substances share values with it.
const SAHARAN_DUST: Row = Row {
    substance: Substance::SaharanDust,
    name: "saharan-dust",
    key: "saharan_dust_ng_g",
    text: "Desert dust of 1.0–2.5 µm with a central share of haematite.",
    source: "Balkanski et al. 2007, doi:10.5194/acp-7-81-2007",
    csv: include_str!("../../data/saharan_dust.csv"),
    extinction_factor: 1.0,
    has_sharp_peak: false,
    usual_ng_g: (1000.0, 2.5),
};

/// The substances, in the order of [`Substance`].
const ROWS: &[Row] = &[
    Row {
        substance: Substance::BlackCarbon,
        name: "black-carbon",
        key: "black_carbon_ng_g",
        text: "Uncoated soot; 10 ng/g absorb three times as much at 500 nm as the ice itself.",
        source: "Flanner et al. 2012, doi:10.5194/acp-12-4699-2012",
        csv: include_str!("../../data/black_carbon.csv"),
        usual_ng_g: (30.0, 2.0),
        ..SAHARAN_DUST
    },
    SAHARAN_DUST,
    Row {
        substance: Substance::ColoradoDust,
        name: "colorado-dust",
        key: "colorado_dust_ng_g",
        text: "Dust of 1.0–2.5 µm from the San Juan Mountains; it mostly scatters.",
        source: "Skiles et al. 2017, doi:10.1017/jog.2016.126",
        csv: include_str!("../../data/colorado_dust.csv"),
        ..SAHARAN_DUST
    },
    Row {
        substance: Substance::BrownCarbon,
        name: "brown-carbon",
        key: "brown_carbon_ng_g",
        text: "Carbon of smouldering fires, which absorbs mostly blue light.",
        source: "Kirchstetter et al. 2004, doi:10.1029/2004JD004999",
        csv: include_str!("../../data/brown_carbon.csv"),
        usual_ng_g: (100.0, 2.0),
        ..SAHARAN_DUST
    },
    Row {
        substance: Substance::SnowAlgae,
        name: "snow-algae",
        key: "snow_algae_ng_g",
        text: "Red algae of 1 ng each, so that ng/g are cells per gram.",
        source: "Chevrollier et al. 2023, doi:10.1017/jog.2022.64",
        csv: include_str!("../../data/snow_algae.csv"),
        extinction_factor: PER_GRAM,
        has_sharp_peak: true,
        ..SAHARAN_DUST
    },
    #[cfg(any(test, feature = "test-rows"))]
    Row { substance: Substance::TestDust, name: "test-dust", key: "test_dust_ng_g", ..SAHARAN_DUST },
];

/// Optical properties of a substance at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Particles {
    /// Mass extinction coefficient, in m²/kg.
    pub extinction_m2_kg: f64,
    /// Single-scattering albedo.
    pub albedo: f64,
    /// Asymmetry parameter of the scattered light.
    pub asymmetry: f64,
}

/// Mass fraction of each substance, in ng per g of dry snow.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Impurities([f64; Substance::ALL.len()]);

impl Substance {
    /// Every substance.
    pub const ALL: [Self; ROWS.len()] = {
        let mut all = [Self::BlackCarbon; ROWS.len()];
        let mut place = 0;
        while place < all.len() {
            all[place] = ROWS[place].substance;
            place += 1;
        }
        all
    };

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        ROWS[self as usize].name
    }

    /// Its mass fraction as a key: the words of the name joined by underscores, with the unit.
    #[must_use]
    pub fn key(self) -> &'static str {
        ROWS[self as usize].key
    }

    /// Description of the substance, in a sentence.
    #[must_use]
    pub fn text(self) -> &'static str {
        ROWS[self as usize].text
    }

    /// Source of its optical properties.
    #[must_use]
    pub fn source(self) -> &'static str {
        ROWS[self as usize].source
    }

    /// Whether it scatters so far forward that it takes many streams.
    pub(crate) fn has_sharp_peak(self) -> bool {
        ROWS[self as usize].has_sharp_peak
    }

    /// Median of its mass fraction in snow that contains it, in ng/g, and the standard deviation of the logarithm.
    pub(crate) fn usual_ng_g(self) -> (f64, f64) {
        ROWS[self as usize].usual_ng_g
    }

    /// Optical properties at a wavelength, linear between the rows.
    ///
    /// ```
    /// # use snowblue_transport::optics::Substance;
    /// // Black carbon mostly absorbs, desert dust mostly scatters.
    /// assert!(Substance::BlackCarbon.at(500.0).albedo < 0.4);
    /// assert!(Substance::SaharanDust.at(500.0).albedo > 0.8);
    /// ```
    ///
    /// # Panics
    /// Outside 305–1495 nm.
    #[must_use]
    pub fn at(self, wavelength_nm: f64) -> Particles {
        let row = TABLES[self as usize].at(wavelength_nm);
        Particles {
            extinction_m2_kg: ROWS[self as usize].extinction_factor * row.linear(1),
            albedo: row.linear(2),
            asymmetry: row.linear(3),
        }
    }
}

/// Formats the name.
impl fmt::Display for Substance {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

impl FromStr for Substance {
    type Err = TransportError;

    /// Words of a name may be joined by hyphens or underscores, as in the names of columns.
    fn from_str(name: &str) -> Result<Self, TransportError> {
        let hyphenated = name.replace('_', "-");
        let named = Self::ALL.into_iter().find(|substance| substance.name() == hyphenated);
        named.map_or_else(|| find_by_name("impurity", name, &Self::ALL, Self::name), Ok)
    }
}

impl Impurities {
    /// Clean snow.
    #[must_use]
    pub fn none() -> Self {
        Self::default()
    }

    /// Sets the mass fraction of one substance, in ng/g.
    #[must_use]
    pub fn with(mut self, substance: Substance, mass_fraction_ng_g: f64) -> Self {
        self.0[substance as usize] = mass_fraction_ng_g;
        self
    }

    /// Whether the snow is clean.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.present().next().is_none()
    }

    /// The mass fraction of a substance, in ng/g.
    #[must_use]
    pub fn ng_g(&self, substance: Substance) -> f64 {
        self.0[substance as usize]
    }

    /// Each substance with a mass fraction above 0, in ng/g.
    pub fn present(&self) -> impl Iterator<Item = (Substance, f64)> {
        Substance::ALL.into_iter().zip(self.0).filter(|(_, mass_fraction)| *mass_fraction > 0.0)
    }

    /// Checks that the tables cover `wavelength_nm`, unless the snow is clean.
    ///
    /// # Errors
    /// [`RangeError::OutOfRange`] outside 305–1495 nm.
    pub(crate) fn check_wavelength(&self, wavelength_nm: f64) -> Result<(), RangeError> {
        if self.is_none() {
            return Ok(());
        }
        WAVELENGTH_RANGE.check("wavelength in snow with impurities", wavelength_nm)
    }
}

/// Formats as `black-carbon=10, saharan-dust=500`, in ng/g, or `none`.
impl fmt::Display for Impurities {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words: Vec<String> = self.present().map(|(substance, ng_g)| format!("{substance}={ng_g}")).collect();
        out.write_str(if words.is_empty() { "none" } else { "" })?;
        out.write_str(&words.join(", "))
    }
}

/// Writes mass fractions in ng/g by name.
impl Serialize for Impurities {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer
            .collect_map(self.present().map(|(substance, mass_fraction_ng_g)| (substance.name(), mass_fraction_ng_g)))
    }
}

/// Reads mass fractions in ng/g by name.
impl<'de> Deserialize<'de> for Impurities {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let given = BTreeMap::<String, Number<MassFraction>>::deserialize(deserializer)?;
        given.iter().try_fold(Self::none(), |impurities, (name, mass_fraction)| {
            let substance: Substance = name.parse().map_err(D::Error::custom)?;
            if name != substance.name() && given.contains_key(substance.name()) {
                let twice = "is given twice, with a hyphen and with an underscore";
                return Err(D::Error::custom(format_args!("{substance} {twice}")));
            }
            Ok(impurities.with(substance, mass_fraction.get()))
        })
    }
}

impl JsonSchema for Impurities {
    fn schema_name() -> Cow<'static, str> {
        "Impurities".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let (names, values) = (Substance::ALL.map(Substance::name), Number::<MassFraction>::json_schema(generator));
        json_schema!({ "type": "object", "propertyNames": { "enum": names }, "additionalProperties": values })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// BioSNICAR's tables, their rows at 305 and 505 nm.
    #[test]
    fn the_tables_are_complete_and_ordered() {
        for table in &*TABLES {
            assert_eq!((table.ordered_rows(), table.wavelength_range()), (Some(120), WAVELENGTH_RANGE));
        }
        let soot = Particles { extinction_m2_kg: 12492.1, albedo: 0.367_635, asymmetry: 0.440_771 };
        assert_eq!(Substance::BlackCarbon.at(505.0), soot);
        assert!(Substance::ALL.into_iter().enumerate().all(|(place, substance)| substance as usize == place));
        // A cell of 9 µm radius and 1 ng has a cross section of 254 µm², 254 m²/kg; its extinction efficiency is about
        // 1.
        assert!((200.0..600.0).contains(&Substance::SnowAlgae.at(500.0).extinction_m2_kg));
        let absorbed = |particles: Particles| particles.extinction_m2_kg * (1.0 - particles.albedo);
        assert!((absorbed(Substance::BlackCarbon.at(550.0)) - 7500.0).abs() < 50.0);
        assert!((Substance::BrownCarbon.at(305.0).extinction_m2_kg - 12762.5).abs() < 1e-9);
    }

    #[test]
    fn names_parse_as_they_print() {
        for substance in Substance::ALL {
            assert_eq!(substance.to_string().parse(), Ok(substance));
            assert_eq!(substance.to_string().replace('-', "_").parse(), Ok(substance));
        }
        let message = "soot".parse::<Substance>().unwrap_err().to_string();
        assert!(message.starts_with("impurity 'soot' is not known; there are black-carbon, saharan-dust"), "{message}");
    }

    #[test]
    fn mass_fractions_are_kept_by_substance() {
        let dirty = Impurities::none().with(Substance::BlackCarbon, 10.0).with(Substance::SaharanDust, 500.0);
        assert_eq!(dirty.to_string(), "black-carbon=10, saharan-dust=500");
        assert!(!dirty.is_none() && Impurities::none().is_none());
        assert!(dirty.check_wavelength(300.0).is_err() && Impurities::none().check_wavelength(300.0).is_ok());
    }
}
