//! Impurities between the grains: small absorbing and scattering particles, given by their mass fraction.
//!
//! A mass fraction c (mass of the substance over mass of dry snow) of particles with mass extinction E, in m²/kg,
//! adds ρ c E to the extinction coefficient of snow of density ρ. The particles scatter the fraction ω of this
//! extinction, their single-scattering albedo, with the Henyey–Greenstein (1941) phase function. They lie outside the
//! grains.
//!
//! `data/substances.toml` declares the substances. Their optical properties are taken from BioSNICAR (Cook et al. 2020,
//! doi:10.5194/tc-14-309-2020); [`Substance::source`] names the paper behind each substance. BioSNICAR gives the
//! extinction of algae in m² per cell. A cell counts as 1 ng here, so that ng/g are cells per g of snow.
//!
//! [`OwnParticles`] declare a further substance under a name of its own, which the process keeps.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;
use std::sync::{LazyLock, PoisonError, RwLock};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use snowblue_base::csv_text::{cells, rows};
use snowblue_base::spectrum_csv::{SpectrumError, read_one};
use snowblue_base::toml_table::Table;
use snowblue_base::{Number, ParameterRange};

use super::spectral_table::SpectralTable;
use crate::error::TransportError;
use crate::parameters::MassFraction;

/// Asymmetry above which particles take many streams.
const SHARP_ASYMMETRY: f64 = 0.9;

static BUILT_IN: LazyLock<Vec<Row>> = LazyLock::new(built_in);

/// The substances that were declared beside the built-in ones. They stay until the process ends.
static OWN: RwLock<Vec<&Row>> = RwLock::new(Vec::new());

/// Ranges of the columns of a table of particles.
const EXTINCTION: ParameterRange = ParameterRange::new("mass extinction", 0.0, 1e9, "m²/kg");
const ABSORPTION: ParameterRange = ParameterRange::new("mass absorption", 0.0, 1e9, "m²/kg");
const ALBEDO: ParameterRange = ParameterRange::new("single-scattering albedo", 0.0, 1.0, "");
const ASYMMETRY: ParameterRange = ParameterRange::new("asymmetry", -0.99, 0.99, "");

/// A substance that darkens snow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Substance(usize);

/// Description and optical properties of a substance, for every user interface.
struct Row {
    name: String,
    /// The name as a property of snow: words joined by underscores, with the unit.
    key: String,
    text: String,
    source: String,
    /// Median, in ng/g, of snow that contains it, and the standard deviation of the logarithm.
    usual_ng_g: (f64, f64),
    /// Wavelength, in nm; mass extinction, in m²/kg; single-scattering albedo; asymmetry.
    table: SpectralTable,
    /// Whether it scatters so far forward that it takes many streams.
    has_sharp_peak: bool,
    /// The name of a wavelength in messages.
    wavelength: String,
}

/// A substance of `data/substances.toml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Declaration {
    name: String,
    text: String,
    source: String,
    #[serde(default = "usual_ng_g")]
    usual_ng_g: (f64, f64),
    #[serde(default = "one_kilogram")]
    mass_kg: f64,
}

/// Of a substance without a value of its own.
fn usual_ng_g() -> (f64, f64) {
    (1000.0, 2.5)
}

fn one_kilogram() -> f64 {
    1.0
}

/// The declared substances.
fn built_in() -> Vec<Row> {
    let mut tables = BTreeMap::<&str, String>::new();
    for line in include_str!("../../data/impurities.csv").lines().skip(1) {
        let (name, numbers) = line.split_once(',').unwrap_or_else(|| unreachable!("'{line}' has no name"));
        let table = tables.entry(name).or_insert("header".to_owned());
        table.push('\n');
        table.push_str(numbers);
    }
    let row = |declaration: Declaration| {
        let Declaration { name, text, source, usual_ng_g, mass_kg } = declaration;
        let table = SpectralTable::new(&tables[&*name]).scaled(1, 1.0 / mass_kg);
        Row::new(name, [text, source], usual_ng_g, table)
    };
    let file = Table::parse(include_str!("../../data/substances.toml"));
    let declared = file.and_then(|mut file| file.take_tables("substance"));
    let rows = declared.and_then(|tables| tables.into_iter().map(|table| table.read().map(row)).collect());
    rows.unwrap_or_else(|error| unreachable!("data/substances.toml: {error}"))
}

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

impl Row {
    fn new(name: String, [text, source]: [String; 2], usual_ng_g: (f64, f64), table: SpectralTable) -> Self {
        let key = format!("{}_ng_g", name.replace('-', "_"));
        let has_sharp_peak = table.greatest(3) > SHARP_ASYMMETRY;
        let wavelength = format!("wavelength in snow with {name}");
        Self { name, key, text, source, usual_ng_g, table, has_sharp_peak, wavelength }
    }
}

impl Substance {
    /// Uncoated black carbon that absorbs 7.5 m²/g at 550 nm.
    pub const BLACK_CARBON: Self = Self(0);
    /// Saharan dust of 1.0–2.5 µm diameter, the central content of haematite.
    pub const SAHARAN_DUST: Self = Self(2);
    /// Dust of the San Juan Mountains, Colorado, of 1.0–2.5 µm diameter.
    pub const COLORADO_DUST: Self = Self(7);
    /// Uncoated brown carbon.
    pub const BROWN_CARBON: Self = Self(17);
    /// Cells of red snow algae of 1 ng: ng/g are cells per g of snow.
    pub const SNOW_ALGAE: Self = Self(20);

    /// Every built-in substance.
    pub fn all() -> impl Iterator<Item = Self> + Clone {
        (0..BUILT_IN.len()).map(Self)
    }

    /// Every substance that has been declared: the built-in ones, then those of [`OwnParticles`].
    pub fn known() -> impl Iterator<Item = Self> + Clone {
        let own = OWN.read().unwrap_or_else(PoisonError::into_inner).len();
        (0..BUILT_IN.len() + own).map(Self)
    }

    fn row(self) -> &'static Row {
        let own = |place: usize| OWN.read().unwrap_or_else(PoisonError::into_inner)[place];
        BUILT_IN.get(self.0).unwrap_or_else(|| own(self.0 - BUILT_IN.len()))
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        &self.row().name
    }

    /// Its mass fraction as a key: the words of the name joined by underscores, with the unit.
    #[must_use]
    pub fn key(self) -> &'static str {
        &self.row().key
    }

    /// Description of the substance, in a sentence.
    #[must_use]
    pub fn text(self) -> &'static str {
        &self.row().text
    }

    /// Source of its optical properties.
    #[must_use]
    pub fn source(self) -> &'static str {
        &self.row().source
    }

    /// Whether it scatters so far forward that it takes many streams.
    #[must_use]
    pub fn has_sharp_peak(self) -> bool {
        self.row().has_sharp_peak
    }

    /// Median of its mass fraction in snow that contains it, in ng/g, and the standard deviation of the logarithm.
    pub(crate) fn usual_ng_g(self) -> (f64, f64) {
        self.row().usual_ng_g
    }

    /// Checks that its table covers `wavelength_nm`.
    ///
    /// # Errors
    /// [`TransportError::Range`] if it does not.
    pub(crate) fn check_wavelength(self, wavelength_nm: f64) -> Result<(), TransportError> {
        Ok(self.row().table.wavelength_range().check(&self.row().wavelength, wavelength_nm)?)
    }

    /// The optical properties of a substance that is not built in, for identifiers.
    pub(crate) fn own_table(self) -> Option<String> {
        (self.0 >= BUILT_IN.len()).then(|| format!("{:?}", self.row().table))
    }

    /// Optical properties at a wavelength, linear between the rows.
    ///
    /// ```
    /// # use snowblue_transport::optics::Substance;
    /// // Black carbon mostly absorbs, desert dust mostly scatters.
    /// assert!(Substance::BLACK_CARBON.at(500.0).albedo < 0.4);
    /// assert!(Substance::SAHARAN_DUST.at(500.0).albedo > 0.8);
    /// ```
    ///
    /// # Panics
    /// Outside the table, 295–2505 nm.
    #[must_use]
    pub fn at(self, wavelength_nm: f64) -> Particles {
        let row = self.row().table.at(wavelength_nm);
        Particles { extinction_m2_kg: row.linear(1), albedo: row.linear(2), asymmetry: row.linear(3) }
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
        Self::known().find(|substance| substance.name() == hyphenated).ok_or_else(|| TransportError::Unknown {
            quantity: "impurity",
            name: name.to_owned(),
            known: Self::all().map(Self::name).collect::<Vec<_>>().join(", "),
        })
    }
}

/// Optical properties of a substance that is not built in: extinction, single-scattering albedo and asymmetry, or a
/// mass absorption coefficient alone, at ascending wavelengths. They are linear between the wavelengths.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OwnParticles {
    /// Wavelengths, in nm.
    pub wavelength_nm: Vec<f64>,
    /// Mass extinction coefficient, in m²/kg.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub extinction_m2_kg: Vec<f64>,
    /// Single-scattering albedo.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub single_scattering_albedo: Vec<f64>,
    /// Asymmetry of the scattered light.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub asymmetry: Vec<f64>,
    /// Mass absorption coefficient, in m²/kg, of particles that do not scatter.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub absorption_m2_kg: Vec<f64>,
}

impl OwnParticles {
    /// Reads a CSV file with the columns `wavelength_nm`, `extinction_m2_kg`, `single_scattering_albedo` and
    /// `asymmetry`; or `wavelength_nm` and `absorption_m2_kg`, the names of which may be missing.
    ///
    /// # Errors
    /// Names the first line that is wrong.
    pub fn read(text: &str) -> Result<Self, SpectrumError> {
        let column = |name: &str, range: ParameterRange| {
            read_one(text, name, range).map(|spectrum| (spectrum.wavelengths_nm, spectrum.values))
        };
        let header = rows(text).next().map(|(line, cells_of)| (line, cells(cells_of).collect::<Vec<_>>()));
        let header = header.filter(|(_, names)| names.iter().any(|name| name.starts_with(char::is_alphabetic)));
        let has = |columns: &[&str]| header.iter().any(|(_, names)| columns.iter().all(|one| names.contains(one)));
        let scatters = has(&["wavelength_nm", "extinction_m2_kg", "single_scattering_albedo", "asymmetry"]);
        if let Some((line, _)) = header.as_ref().filter(|_| !scatters && !has(&["wavelength_nm", "absorption_m2_kg"])) {
            let reason = "the columns must be wavelength_nm and absorption_m2_kg, or wavelength_nm, extinction_m2_kg, \
                          single_scattering_albedo and asymmetry";
            return Err(SpectrumError { line: Some(*line), reason: reason.to_owned() });
        }
        if !scatters {
            let (wavelength_nm, absorption_m2_kg) = column("absorption_m2_kg", ABSORPTION)?;
            return Ok(Self { wavelength_nm, absorption_m2_kg, ..Self::default() });
        }
        let (wavelength_nm, extinction_m2_kg) = column("extinction_m2_kg", EXTINCTION)?;
        let (_, single_scattering_albedo) = column("single_scattering_albedo", ALBEDO)?;
        let (_, asymmetry) = column("asymmetry", ASYMMETRY)?;
        Ok(Self { wavelength_nm, extinction_m2_kg, single_scattering_albedo, asymmetry, ..Self::default() })
    }

    /// Declares the substance of these particles under a name. The process keeps it.
    ///
    /// ```
    /// use snowblue_transport::optics::{OwnParticles, Substance};
    ///
    /// let particles = OwnParticles::read("wavelength_nm,absorption_m2_kg\n300,9000\n2500,1000\n")?;
    /// let soot = particles.declare("my-soot").unwrap();
    /// assert_eq!("my_soot".parse(), Ok(soot));
    /// assert!(soot.at(300.0).extinction_m2_kg == 9000.0 && soot.at(300.0).albedo == 0.0);
    /// # Ok::<(), snowblue_base::spectrum_csv::SpectrumError>(())
    /// ```
    ///
    /// # Errors
    /// [`TransportError::Substance`] if the name has other characters than letters, digits, hyphens and underscores, or
    /// is the name of another substance; if there are fewer than two wavelengths, or they do not ascend; if columns
    /// are missing or differ in length, or a value is out of range; if there are 64 substances.
    pub fn declare(&self, name: &str) -> Result<Substance, TransportError> {
        let name = name.replace('_', "-");
        let wrong = |reason: String| TransportError::Substance { name: name.clone(), reason };
        if name.is_empty() || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-') {
            return Err(wrong("its name must have only letters, digits, hyphens and underscores".to_owned()));
        }
        let table = self.table().map_err(wrong)?;
        let taken = |by: &str| Err(wrong(format!("the name is taken by {by}: take another name")));
        if Substance::all().any(|substance| substance.name() == name) {
            return taken("a built-in substance");
        }
        let mut own = OWN.write().unwrap_or_else(PoisonError::into_inner);
        if let Some(place) = own.iter().position(|row| row.name == name) {
            return match own[place].table == table {
                true => Ok(Substance(BUILT_IN.len() + place)),
                false => taken("another table in this process"),
            };
        }
        if BUILT_IN.len() + own.len() == MAX_SUBSTANCES {
            return Err(wrong(format!("there are {MAX_SUBSTANCES} substances, and no more are possible")));
        }
        let texts = ["Particles of a table of one's own.", "own table"].map(str::to_owned);
        own.push(Box::leak(Box::new(Row::new(name.clone(), texts, usual_ng_g(), table))));
        Ok(Substance(BUILT_IN.len() + own.len() - 1))
    }

    fn table(&self) -> Result<SpectralTable, String> {
        let count = self.wavelength_nm.len();
        if count < 2 || !self.wavelength_nm.is_sorted_by(|a, b| a < b) || !self.wavelength_nm[count - 1].is_finite() {
            return Err("its wavelengths must be at least two numbers that ascend".to_owned());
        }
        let scattering = [
            ("extinction_m2_kg", &self.extinction_m2_kg, EXTINCTION),
            ("single_scattering_albedo", &self.single_scattering_albedo, ALBEDO),
            ("asymmetry", &self.asymmetry, ASYMMETRY),
        ];
        let absorbs = !self.absorption_m2_kg.is_empty();
        if absorbs && scattering.iter().any(|(_, values, _)| !values.is_empty()) {
            return Err("absorption_m2_kg stands alone, without extinction, albedo and asymmetry".to_owned());
        }
        let column = |(name, values, range): (&str, &Vec<f64>, ParameterRange)| {
            if values.len() != count {
                return Err(format!("{name} has {} values, but there are {count} wavelengths", values.len()));
            }
            values.iter().try_for_each(|value| range.check(*value)).map_err(|error| error.to_string())?;
            Ok(values.clone())
        };
        let mut columns = vec![self.wavelength_nm.clone()];
        if absorbs {
            columns.push(column(("absorption_m2_kg", &self.absorption_m2_kg, ABSORPTION))?);
            columns.extend([vec![0.0; count], vec![0.0; count]]);
        } else {
            columns.extend(scattering.map(column).into_iter().collect::<Result<Vec<_>, _>>()?);
        }
        Ok(SpectralTable::of_columns(&columns))
    }
}

/// Greatest number of substances, built-in ones included.
const MAX_SUBSTANCES: usize = 64;

/// Mass fraction of each substance, in ng per g of dry snow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impurities {
    /// The substances whose mass fraction is not 0, ascending; then 0 of the first substance.
    entries: [(Substance, f64); MAX_SUBSTANCES],
    count: usize,
}

impl Default for Impurities {
    fn default() -> Self {
        Self { entries: [(Substance(0), 0.0); MAX_SUBSTANCES], count: 0 }
    }
}

impl Impurities {
    /// Clean snow.
    #[must_use]
    pub fn none() -> Self {
        Self::default()
    }

    /// Sets the mass fraction of one substance, in ng/g.
    ///
    #[must_use]
    pub fn with(self, substance: Substance, mass_fraction_ng_g: f64) -> Self {
        let mut all: Vec<(Substance, f64)> = self.given().filter(|(other, _)| *other != substance).collect();
        if mass_fraction_ng_g.to_bits() != 0 {
            all.push((substance, mass_fraction_ng_g));
        }
        all.sort_by_key(|(substance, _)| *substance);
        let mut with = Self { count: all.len(), ..Self::default() };
        with.entries[..all.len()].copy_from_slice(&all);
        with
    }

    /// Whether the snow is clean.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.present().next().is_none()
    }

    /// The mass fraction of a substance, in ng/g.
    #[must_use]
    pub fn ng_g(&self, substance: Substance) -> f64 {
        self.given().find(|(other, _)| *other == substance).map_or(0.0, |(_, mass_fraction)| mass_fraction)
    }

    /// Each substance whose mass fraction is not 0, in ng/g. The mass fractions may be out of range.
    pub(crate) fn given(&self) -> impl Iterator<Item = (Substance, f64)> + use<> {
        self.entries.into_iter().take(self.count)
    }

    /// Each substance with a mass fraction above 0, in ng/g.
    pub fn present(&self) -> impl Iterator<Item = (Substance, f64)> + use<> {
        self.given().filter(|(_, mass_fraction)| *mass_fraction > 0.0)
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
        let names: Vec<&str> = Substance::all().map(Substance::name).collect();
        let values = Number::<MassFraction>::json_schema(generator);
        let names = json_schema!({ "anyOf": [{ "enum": names }, {}] });
        json_schema!({ "type": "object", "propertyNames": names, "additionalProperties": values })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::WavelengthRange;

    /// BioSNICAR's tables: their rows from 295 to 2505 nm, and values at 305, 505 and 2505 nm.
    #[test]
    fn the_tables_are_complete_and_ordered() {
        assert_eq!(Substance::all().count(), 22);
        for row in &*BUILT_IN {
            assert_eq!(row.table.ordered_rows(), Some(222), "{}", row.name);
            assert_eq!(row.table.wavelength_range(), WavelengthRange::new(295.0, 2505.0));
        }
        let soot = Particles { extinction_m2_kg: 12492.1, albedo: 0.367_635, asymmetry: 0.440_771 };
        assert_eq!(Substance::BLACK_CARBON.at(505.0), soot);
        let absorbed = |particles: Particles| particles.extinction_m2_kg * (1.0 - particles.albedo);
        assert!((absorbed(Substance::BLACK_CARBON.at(550.0)) - 7500.0).abs() < 50.0);
        assert!((Substance::BROWN_CARBON.at(305.0).extinction_m2_kg - 12762.5).abs() < 1e-9);
        // A cell of 9 µm radius has a cross section of 254 µm², and large particles extinguish twice their cross
        // section.
        assert!((Substance::SNOW_ALGAE.at(505.0).extinction_m2_kg - 447.929).abs() < 1e-9);
        for (substance, name) in [
            (Substance::BLACK_CARBON, "black-carbon"),
            (Substance::SAHARAN_DUST, "saharan-dust"),
            (Substance::COLORADO_DUST, "colorado-dust"),
            (Substance::BROWN_CARBON, "brown-carbon"),
            (Substance::SNOW_ALGAE, "snow-algae"),
        ] {
            assert_eq!(substance.name(), name);
        }
    }

    #[test]
    fn names_parse_as_they_print() {
        for substance in Substance::all() {
            assert_eq!(substance.to_string().parse(), Ok(substance));
            assert_eq!(substance.to_string().replace('-', "_").parse(), Ok(substance));
        }
        let message = "soot".parse::<Substance>().unwrap_err().to_string();
        assert!(message.starts_with("impurity 'soot' is not known; there are black-carbon, black"), "{message}");
    }

    #[test]
    fn mass_fractions_are_kept_by_substance() {
        let dirty = Impurities::none().with(Substance::SAHARAN_DUST, 500.0).with(Substance::BLACK_CARBON, 10.0);
        assert_eq!(dirty.to_string(), "black-carbon=10, saharan-dust=500");
        assert!(!dirty.is_none() && Impurities::none().is_none());
        assert_eq!(dirty.with(Substance::BLACK_CARBON, 0.0).with(Substance::SAHARAN_DUST, 0.0), Impurities::none());
    }
}
