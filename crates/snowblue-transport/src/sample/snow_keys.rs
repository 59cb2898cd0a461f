//! What is known of a snow, as words and numbers.

use std::collections::BTreeMap;
use std::str::FromStr;

use serde::{Deserialize, Deserializer};

use super::{SnowDescription, TruncatedNormal};
use crate::TransportError;
use crate::optics::Impurities;

/// What is known of a snow, as words and numbers by the keys of a [file of layers](crate::layer_file).
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default)]
pub struct SnowKeys {
    /// Kind of snow.
    pub snow: Option<String>,
    /// Grain size, in µm: a mean, or the ends of a range.
    #[serde(deserialize_with = "one_or_several")]
    pub grain_size_um: Option<Vec<f64>>,
    /// What the grain size measures.
    pub size_measure: Option<String>,
    /// Specific surface area, in m²/kg.
    pub ssa_m2_kg: Option<f64>,
    /// Facetness: a mean, or range, mean and standard deviation.
    #[serde(deserialize_with = "one_or_several")]
    pub facetness: Option<Vec<f64>>,
    /// Sphericity: one value, or range, mean and standard deviation.
    #[serde(deserialize_with = "one_or_several")]
    pub sphericity: Option<Vec<f64>>,
    /// Density of the dry snow, in kg/m³.
    pub density_kg_m3: Option<f64>,
    /// Fraction of the pore volume that is filled with water.
    pub water_saturation: Option<f64>,
    /// Mass fractions of impurities by name, in ng/g.
    pub impurities_ng_g: BTreeMap<String, f64>,
    /// Temperature, in °C.
    pub temperature_c: Option<f64>,
    /// Table of the absorption of ice.
    pub ice: Option<String>,
}

impl SnowKeys {
    /// The same with all words resolved.
    ///
    /// # Errors
    /// If a word is not known, or sphericity or facetness are out of range.
    pub fn description(&self) -> Result<SnowDescription, TransportError> {
        let mut impurities = Impurities::none();
        for (name, mass_fraction_ng_g) in &self.impurities_ng_g {
            impurities = impurities.with(name.parse()?, *mass_fraction_ng_g);
        }
        Ok(SnowDescription {
            snow_type: parsed(self.snow.as_deref())?,
            grain_size_um: self.grain_size_um.clone(),
            size_measure: parsed(self.size_measure.as_deref())?,
            surface_area_m2_kg: self.ssa_m2_kg,
            sphericity: self.sphericity.as_deref().map(TruncatedNormal::sphericity).transpose()?,
            facetness: self.facetness.as_deref().map(TruncatedNormal::facetness).transpose()?,
            density_kg_m3: self.density_kg_m3,
            water_saturation: self.water_saturation,
            impurities,
            temperature_c: self.temperature_c,
            ice: parsed(self.ice.as_deref())?,
        })
    }
}

fn parsed<T: FromStr<Err = TransportError>>(word: Option<&str>) -> Result<Option<T>, TransportError> {
    word.map(str::parse).transpose()
}

/// Reads a number or a list of numbers.
fn one_or_several<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Vec<f64>>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "must be a number or a list of numbers")]
    enum Numbers {
        One(f64),
        Several(Vec<f64>),
    }
    let numbers = Option::<Numbers>::deserialize(deserializer)?;
    Ok(numbers.map(|numbers| match numbers {
        Numbers::One(number) => vec![number],
        Numbers::Several(numbers) => numbers,
    }))
}
