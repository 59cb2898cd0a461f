//! Snow by the keys of a file of layers.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::str::FromStr;

use serde::Deserialize;
use snowblue_transport::optics::Impurities;
use snowblue_transport::sample::{SnowDescription, SnowSample, TruncatedNormal};

/// A number or several.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
pub(crate) enum Numbers {
    One(f64),
    Several(Vec<f64>),
}

/// A layer of snow.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Layer {
    pub(crate) thickness_cm: f64,
    snow: Option<String>,
    grain_size_um: Option<Numbers>,
    size_measure: Option<String>,
    ssa_m2_kg: Option<f64>,
    facetness: Option<Numbers>,
    sphericity: Option<Numbers>,
    density_kg_m3: Option<f64>,
    water_saturation: Option<f64>,
    #[serde(default)]
    impurities_ng_g: BTreeMap<String, f64>,
    temperature_c: Option<f64>,
    ice: Option<String>,
}

impl Numbers {
    fn as_slice(&self) -> &[f64] {
        match self {
            Self::One(number) => std::slice::from_ref(number),
            Self::Several(numbers) => numbers,
        }
    }
}

impl Layer {
    /// The snow. Only its grain size is checked.
    pub(crate) fn sample(&self) -> Result<SnowSample, String> {
        let distribution = |numbers: &Option<Numbers>, of: fn(&[f64]) -> Result<TruncatedNormal, _>| {
            numbers.as_ref().map(|numbers| of(numbers.as_slice())).transpose().map_err(text)
        };
        let mut impurities = Impurities::none();
        for (name, mass_fraction_ng_g) in &self.impurities_ng_g {
            impurities = impurities.with(name.parse().map_err(text)?, *mass_fraction_ng_g);
        }
        let description = SnowDescription {
            snow_type: parsed(self.snow.as_deref())?,
            grain_size_um: self.grain_size_um.as_ref().map(|numbers| numbers.as_slice().to_vec()),
            size_measure: parsed(self.size_measure.as_deref())?,
            surface_area_m2_kg: self.ssa_m2_kg,
            sphericity: distribution(&self.sphericity, TruncatedNormal::sphericity)?,
            facetness: distribution(&self.facetness, TruncatedNormal::facetness)?,
            density_kg_m3: self.density_kg_m3,
            water_saturation: self.water_saturation,
            impurities,
            temperature_c: self.temperature_c,
            ice: parsed(self.ice.as_deref())?,
        };
        description.sample().map_err(text)
    }
}

fn parsed<T: FromStr<Err: Display>>(word: Option<&str>) -> Result<Option<T>, String> {
    word.map(str::parse).transpose().map_err(text)
}

/// The words of an error.
pub(crate) fn text(error: impl Display) -> String {
    error.to_string()
}
