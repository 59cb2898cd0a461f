//! Layers of snow and clear ice from a TOML file.
//!
//! ```toml
//! ice = "warren2008"          # or "picard2016"; for all layers
//! [[layer]]                   # top first
//! thickness_cm = 3            # the only required key; inf for the last layer of a half-space
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
//! Missing keys have the values of [`SnowSample::default`](crate::SnowSample). A layer of clear ice has a thickness
//! alone:
//!
//! ```toml
//! [[layer]]
//! kind = "ice"
//! thickness_cm = 0.5
//! ```
//!
//! Impurities that are not built in have a table of their own ([`OwnParticles`]):
//!
//! ```toml
//! [substance.my-dust]
//! wavelength_nm = [300, 1000, 2500]
//! extinction_m2_kg = [800, 700, 400]
//! single_scattering_albedo = [0.8, 0.95, 0.97]
//! asymmetry = [0.75, 0.7, 0.65]
//! ```

use std::collections::BTreeMap;
use std::ops::Range;

use schemars::JsonSchema;
use snowblue_base::toml_table::{ParseError, Table};

use crate::error::TransportError;
use crate::optics::{IceTable, OwnParticles};
use crate::sample::{SnowKeyError, SnowKeys};
use crate::stack::{Layer, check_kind};

/// Greatest number of layers in a file. Each kind of grain costs a scattering tally of some tenths of a second.
pub const MAX_LAYERS: usize = 1000;

/// Layers of snow and clear ice, and the table of ice that all of them use.
///
/// ```
/// # use snowblue_transport::layer_file::LayerFile;
/// let pack = LayerFile::parse("[[layer]]\nthickness_cm = 3\nsnow = \"fresh\"\n[[layer]]\nthickness_cm = 20\n")?;
/// assert_eq!(pack.layers.len(), 2);
/// let [fresh, below] = [0, 1].map(|layer| *pack.layers[layer].sample().unwrap());
/// // Fresh snow is light.
/// assert!(fresh.density_kg_m3 < 0.5 * below.density_kg_m3);
/// # Ok::<(), snowblue_base::toml_table::ParseError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LayerFile {
    /// The layers, top first: at least one.
    pub layers: Vec<Layer>,
    /// The range of bytes of each layer in the text.
    pub spans: Vec<Range<usize>>,
    /// Table of the absorption of ice.
    pub ice: IceTable,
}

/// The keys of a file.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "only its schema is used")]
pub struct LayerFileKeys {
    /// Table of the absorption of ice, for all layers.
    ice: Option<IceTable>,
    /// Impurities that are not built in, by name.
    substance: Option<BTreeMap<String, OwnParticles>>,
    /// The layers, top first.
    layer: Vec<LayerKeys>,
}

/// The keys of a layer.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "only its schema is used")]
enum LayerKeys {
    /// Clear ice.
    Ice {
        /// What the layer is made of, unless it is snow.
        kind: IceKind,
        /// Thickness, in cm: 0.01 to 100,000.
        thickness_cm: f64,
    },
    /// Snow.
    Snow {
        /// Thickness, in cm: 0 to 100,000, or inf for the last layer of a half-space.
        thickness_cm: f64,
        /// What it is made of.
        #[schemars(flatten)]
        snow: Box<SnowKeys>,
    },
}

/// The word for clear ice.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
#[expect(dead_code, reason = "only its schema is used")]
enum IceKind {
    /// Clear ice.
    Ice,
}

impl LayerFile {
    /// Reads the text of a file and checks every layer.
    ///
    /// # Errors
    /// If the text is not TOML, a key is unknown or missing, a value is out of range, or there is no layer or more than
    /// [`MAX_LAYERS`].
    pub fn parse(text: &str) -> Result<Self, ParseError> {
        let mut file = Table::parse(text)?;
        let ice = file.take_as("ice")?.unwrap_or_default();
        declare_substances(&mut file)?;
        let tables = file.take_tables("layer")?;
        let none = file.error("holds no [[layer]]");
        file.finish()?;
        let spans: Vec<Range<usize>> = tables.iter().map(Table::span).collect();
        if let Some(span) = spans.get(MAX_LAYERS).cloned() {
            let reason = format!("holds {} [[layer]], but must hold at most {MAX_LAYERS}", spans.len());
            return Err(ParseError { span, reason });
        }
        let last = spans.len().checked_sub(1).ok_or(none)?;
        let read = |(index, table)| read_layer(table, text, (ice, index == last));
        let layers = tables.into_iter().enumerate().map(read).collect::<Result<_, _>>()?;
        Ok(Self { layers, spans, ice })
    }
}

/// Declares the substances of the tables `[substance.NAME]`, and returns their particles by name.
///
/// # Errors
/// If a table is not that of [`OwnParticles`].
pub fn declare_substances(file: &mut Table) -> Result<BTreeMap<String, OwnParticles>, ParseError> {
    let tables = file.take_table("substance")?.map_or(Ok(Vec::new()), Table::into_tables)?;
    let read = |(name, table): (String, Table)| {
        let span = table.span();
        let particles: OwnParticles = table.read()?;
        let declared = particles.declare(&name);
        declared.map_err(|error| ParseError { span, reason: error.to_string() })?;
        Ok((name, particles))
    };
    tables.into_iter().map(read).collect()
}

fn read_layer(mut table: Table, text: &str, (ice, is_last): (IceTable, bool)) -> Result<Layer, ParseError> {
    let (path, span) = (table.path().clone(), table.span());
    let missing = || ParseError { span, reason: path.key("thickness_cm").error("is missing").to_string() };
    let thickness = table.take("thickness_cm").ok_or_else(missing)?;
    if let Some(ice) = table.take("ice") {
        return Err(ice.error("is the same for all layers: it stands above them"));
    }
    let thickness_cm = thickness.clone().read()?;
    let checked = |layer: Layer| match layer.check(is_last) {
        Ok(()) => Ok(layer),
        Err(error) => Err(thickness.error(error.after_key())),
    };
    if let Some(kind) = table.take("kind") {
        check_kind(&kind.clone().read::<String>()?, None).map_err(|error| kind.error(error.after_key()))?;
        table.finish().map_err(|ParseError { span, .. }| {
            let error = TransportError::IceProperty { key: text[span.clone()].to_owned() };
            ParseError { span, reason: error.to_string() }
        })?;
        return checked(Layer::ice(ice, thickness_cm));
    }
    let snow = SnowKeys { ice: Some(ice), ..table.read()? };
    let sample = snow.sample().map_err(|SnowKeyError { key, impurity, error }| {
        let key = path.key(key);
        let path = impurity.map_or(key.clone(), |name| key.key(&name));
        path.error(error.after_key()).in_text(text)
    })?;
    checked(Layer::snow(sample, thickness_cm))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Property, SnowSample, TruncatedNormal};

    #[test]
    fn values_are_numbers_or_lists() {
        let text = "[[layer]]\nthickness_cm = 3\ngrain_size_um = 200\nfacetness = 0.5\nsphericity = 0.9\n\
                    [[layer]]\nthickness_cm = 2\ngrain_size_um = [100, 300]\nfacetness = [0, 1, 0.5, 0.2]\n";
        let layers = LayerFile::parse(text).unwrap().layers;
        let [first, second] = [0, 1].map(|layer| *layers[layer].sample().unwrap());
        let ends = |sample: &SnowSample| (sample.grain_size.min_um, sample.grain_size.max_um);
        assert_eq!((ends(&first), ends(&second)), ((150.0, 250.0), (100.0, 300.0)));
        assert_eq!(first.facetness, TruncatedNormal::facetness_around(0.5));
        assert_eq!(first.sphericity, TruncatedNormal::exactly(0.9));
        let wide = TruncatedNormal { min: 0.0, max: 1.0, mean: 0.5, standard_deviation: 0.2 };
        assert_eq!(second.facetness, wide);
    }

    #[test]
    fn every_property_is_a_key() {
        for property in Property::all() {
            let range = property.parameter().range;
            let value = 0.5 * (range.least + range.greatest.min(1000.0));
            let key = match property {
                Property::Impurity(substance) => format!("impurities_ng_g = {{ {substance} = {value} }}"),
                _ => format!("{} = {value}", property.key()),
            };
            let layer = LayerFile::parse(&format!("[[layer]]\nthickness_cm = 3\n{key}\n")).unwrap().layers[0];
            assert!((property.get(layer.sample().unwrap()) / value - 1.0).abs() < 1e-12, "{key}");
        }
    }

    #[test]
    fn wrong_values_are_named() {
        for (layer, expected) in [
            ("thickness_cm = 3\ngrain_size_um = 12000", "12000 µm"),
            ("thickness_cm = 3\ngrain_size_um = [1, 2, 3]", "3"),
            ("thickness_cm = 3\nfacetness = \"rough\"", "number or a list of numbers"),
            ("thickness_cm = -3", "layer[0].thickness_cm is -3 cm"),
            ("thickness_cm = 3\ndensity_kg_m3 = 917", "kind = \"ice\""),
            (
                "thickness_cm = 3\nkind = \"water\"",
                "kind of layer 'water' is not known; it must be ice, or be left out for snow",
            ),
            (
                "thickness_cm = 3\nkind = \"ice\"\nssa_m2_kg = 3",
                "ssa_m2_kg is a property of snow: a layer of clear ice has only",
            ),
            ("thickness_cm = 0\nkind = \"ice\"", "layer[0].thickness_cm is 0 cm, but must lie in 0.01–100000 cm"),
            ("thickness_cm = inf\nkind = \"ice\"", "layer[0].thickness_cm is inf cm, but must lie in 0.01–100000 cm"),
        ] {
            let error = LayerFile::parse(&format!("[[layer]]\n{layer}\n")).unwrap_err();
            assert!(error.reason.contains(expected), "{}", error.reason);
        }
    }
}
