//! Layers of snow from a TOML file.
//!
//! ```toml
//! ice = "warren2008"          # or "picard2016"; for all layers
//! [[layer]]                   # top first
//! thickness_cm = 3            # the only required key
//! grain_size_um = 200         # a mean, or [MIN, MAX]
//! size_measure = "greatest-extension"   # or "volume-diameter", "optical-diameter"
//! # ssa_m2_kg = 40            # instead of a grain size
//! facetness = 0.3             # a mean, or [MIN, MAX, MEAN, SD]
//! sphericity = 0.8            # one value, or [MIN, MAX, MEAN, SD]
//! density_kg_m3 = 120
//! # snow = "fresh"            # a kind of snow, for grain size and density where they are not given
//! water_saturation = 0
//! impurities_ng_g = { black-carbon = 10, saharan-dust = 500 }
//! temperature_c = -5
//! ```
//!
//! Missing keys have the values of [`SnowSample::default`](crate::SnowSample).

use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;

use crate::TransportError;
use crate::optics::IceTable;
use crate::sample::{SnowDescription, TruncatedNormal};
use crate::stack::Layer;

/// Greatest number of layers in a file. Each kind of grain costs a scattering tally of some tenths of a second.
pub const MOST_LAYERS: usize = 1000;

/// Layers of snow, and the table of ice that all of them use.
///
/// ```
/// # use snowblue_transport::layer_file::LayerFile;
/// let pack = LayerFile::parse("[[layer]]\nthickness_cm = 3\nsnow = \"fresh\"\n[[layer]]\nthickness_cm = 20\n")?;
/// assert_eq!(pack.layers.len(), 2);
/// // Fresh snow is light.
/// assert!(pack.layers[0].sample.density_kg_m3 < 0.5 * pack.layers[1].sample.density_kg_m3);
/// # Ok::<(), snowblue_transport::layer_file::LayerFileError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LayerFile {
    /// The layers, top first: at least one.
    pub layers: Vec<Layer>,
    /// Table of the absorption of ice.
    pub ice: IceTable,
}

/// What is wrong with a file of layers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct LayerFileError {
    /// The bytes of the text that it is about; none if it is about the whole file.
    pub span: Option<Range<usize>>,
    /// The quantity, its value and its range.
    pub reason: String,
}

impl LayerFile {
    /// Reads the text of a file and checks every layer.
    ///
    /// # Errors
    /// If the text is not TOML, a key is unknown or missing, a value is out of range, or there is no layer or more than
    /// [`MOST_LAYERS`].
    pub fn parse(text: &str) -> Result<Self, LayerFileError> {
        let tables: Tables = toml::from_str(text).map_err(|error| LayerFileError {
            span: Some(error.span().unwrap_or(0..0)),
            reason: error.message().replace('\n', "; "),
        })?;
        if tables.layer.is_empty() {
            return Err(LayerFileError { span: None, reason: "holds no [[layer]]".to_owned() });
        }
        if let Some(layer) = tables.layer.get(MOST_LAYERS) {
            let reason = format!("holds {} [[layer]], but must hold at most {MOST_LAYERS}", tables.layer.len());
            return Err(LayerFileError::at(layer.span(), reason));
        }
        let ice = tables.ice.as_ref().map(|ice| parsed(ice, |name| name.parse())).transpose()?.unwrap_or_default();
        let layers: Result<_, _> = tables.layer.iter().map(|table| read_layer(table.get_ref(), ice)).collect();
        Ok(Self { layers: layers?, ice })
    }
}

impl LayerFileError {
    fn at(span: Range<usize>, reason: impl Display) -> Self {
        Self { span: Some(span), reason: reason.to_string() }
    }
}

/// The tables of a file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    ice: Option<Spanned<String>>,
    #[serde(default)]
    layer: Vec<Spanned<LayerTable>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerTable {
    thickness_cm: Spanned<f64>,
    grain_size_um: Option<Spanned<Numbers>>,
    size_measure: Option<Spanned<String>>,
    ssa_m2_kg: Option<Spanned<f64>>,
    facetness: Option<Spanned<Numbers>>,
    sphericity: Option<Spanned<Numbers>>,
    density_kg_m3: Option<Spanned<f64>>,
    snow: Option<Spanned<String>>,
    water_saturation: Option<Spanned<f64>>,
    #[serde(default)]
    impurities_ng_g: BTreeMap<Spanned<String>, Spanned<f64>>,
    temperature_c: Option<Spanned<f64>>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "must be a number or a list of numbers")]
enum Numbers {
    One(f64),
    Several(Vec<f64>),
}

impl Numbers {
    fn as_slice(&self) -> &[f64] {
        match self {
            Self::One(number) => std::slice::from_ref(number),
            Self::Several(numbers) => numbers,
        }
    }
}

/// Builds a layer key by key, and checks it after each key to report the place of an error.
fn read_layer(table: &LayerTable, ice: IceTable) -> Result<Layer, LayerFileError> {
    let mut snow = SnowDescription { ice: Some(ice), ..SnowDescription::default() };
    let check = |snow: &SnowDescription, span: Range<usize>| {
        let layer = snow.sample().map(|sample| Layer { sample, thickness_cm: *table.thickness_cm.get_ref() });
        layer.and_then(|layer| layer.check().map(|()| layer)).map_err(|error| LayerFileError::at(span, error))
    };
    let mut layer = check(&snow, table.thickness_cm.span())?;
    if let Some(kind) = &table.snow {
        snow.snow_type = Some(parsed(kind, |name| name.parse())?);
        layer = check(&snow, kind.span())?;
    }
    if let Some(water_saturation) = &table.water_saturation {
        snow.water_saturation = Some(*water_saturation.get_ref());
        layer = check(&snow, water_saturation.span())?;
    }
    for (name, mass_fraction_ng_g) in &table.impurities_ng_g {
        let substance = parsed(name, |name| name.parse())?;
        snow.impurities = snow.impurities.with(substance, *mass_fraction_ng_g.get_ref());
        layer = check(&snow, mass_fraction_ng_g.span())?;
    }
    if let Some(density_kg_m3) = &table.density_kg_m3 {
        snow.density_kg_m3 = Some(*density_kg_m3.get_ref());
        layer = check(&snow, density_kg_m3.span())?;
    }
    if let Some(temperature_c) = &table.temperature_c {
        snow.temperature_c = Some(*temperature_c.get_ref());
        layer = check(&snow, temperature_c.span())?;
    }
    if let Some(facetness) = &table.facetness {
        snow.facetness = Some(parsed(facetness, |numbers| TruncatedNormal::facetness(numbers.as_slice()))?);
        layer = check(&snow, facetness.span())?;
    }
    if let Some(sphericity) = &table.sphericity {
        snow.sphericity = Some(parsed(sphericity, |numbers| TruncatedNormal::sphericity(numbers.as_slice()))?);
        layer = check(&snow, sphericity.span())?;
    }
    if let Some(grain_size_um) = &table.grain_size_um {
        snow.grain_size_um = Some(grain_size_um.get_ref().as_slice().to_vec());
        layer = check(&snow, grain_size_um.span())?;
    }
    if let Some(measure) = &table.size_measure {
        snow.size_measure = Some(parsed(measure, |name| name.parse())?);
        layer = check(&snow, measure.span())?;
    }
    if let Some(area_m2_kg) = &table.ssa_m2_kg {
        snow.surface_area_m2_kg = Some(*area_m2_kg.get_ref());
        layer = check(&snow, area_m2_kg.span())?;
    }
    Ok(layer)
}

/// The value of a key, or an error at its place.
fn parsed<K, V>(key: &Spanned<K>, parse: impl Fn(&K) -> Result<V, TransportError>) -> Result<V, LayerFileError> {
    parse(key.get_ref()).map_err(|error| LayerFileError::at(key.span(), error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::SnowSample;

    #[test]
    fn values_are_numbers_or_lists() {
        let text = "[[layer]]\nthickness_cm = 3\ngrain_size_um = 200\nfacetness = 0.5\nsphericity = 0.9\n\
                    [[layer]]\nthickness_cm = 2\ngrain_size_um = [100, 300]\nfacetness = [0, 1, 0.5, 0.2]\n";
        let [one, other] = LayerFile::parse(text).unwrap().layers[..] else { panic!("two layers") };
        let ends = |sample: &SnowSample| (sample.grain_size.min_um, sample.grain_size.max_um);
        assert_eq!((ends(&one.sample), ends(&other.sample)), ((150.0, 250.0), (100.0, 300.0)));
        assert_eq!(one.sample.facetness, TruncatedNormal::facetness_around(0.5));
        assert_eq!(one.sample.sphericity, TruncatedNormal::exactly(0.9));
        let wide = TruncatedNormal { min: 0.0, max: 1.0, mean: 0.5, standard_deviation: 0.2 };
        assert_eq!(other.sample.facetness, wide);
    }

    #[test]
    fn wrong_values_are_named() {
        for (layer, expected) in [
            ("thickness_cm = 3\ngrain_size_um = 12000", "12000 µm"),
            ("thickness_cm = 3\ngrain_size_um = [1, 2, 3]", "3"),
            ("thickness_cm = 3\nfacetness = \"rough\"", "number or a list of numbers"),
            ("thickness_cm = -3", "thickness is -3 cm"),
        ] {
            let error = LayerFile::parse(&format!("[[layer]]\n{layer}\n")).unwrap_err();
            assert!(error.reason.contains(expected), "{}", error.reason);
        }
    }
}
