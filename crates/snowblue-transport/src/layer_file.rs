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

use std::fmt::Display;
use std::ops::Range;

use snowblue_base::KeyPath;
use snowblue_base::toml_value::{Mistake, parse, read};
use toml::Spanned;
use toml::de::DeValue;

use crate::optics::IceTable;
use crate::sample::{SnowKeyError, SnowKeys};
use crate::stack::{ICE_KIND, Layer, check_kind};

/// Greatest number of layers in a file. Each kind of grain costs a scattering tally of some tenths of a second.
pub const MOST_LAYERS: usize = 1000;

/// Layers of snow and clear ice, and the table of ice that all of them use.
///
/// ```
/// # use snowblue_transport::layer_file::LayerFile;
/// let pack = LayerFile::parse("[[layer]]\nthickness_cm = 3\nsnow = \"fresh\"\n[[layer]]\nthickness_cm = 20\n")?;
/// assert_eq!(pack.layers.len(), 2);
/// let [fresh, below] = [0, 1].map(|layer| *pack.layers[layer].sample().unwrap());
/// // Fresh snow is light.
/// assert!(fresh.density_kg_m3 < 0.5 * below.density_kg_m3);
/// # Ok::<(), snowblue_transport::layer_file::LayerFileError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LayerFile {
    /// The layers, top first: at least one.
    pub layers: Vec<Layer>,
    /// The bytes of the text of each layer.
    pub spans: Vec<Range<usize>>,
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
        let mut file = parse(text)?.into_inner();
        let ice = match file.remove("ice") {
            Some(ice) => read::<String>(&ice, &KeyPath::root("ice"), &[])?
                .parse()
                .map_err(|error| LayerFileError::at(ice.span(), error))?,
            None => IceTable::default(),
        };
        let layers = file.remove("layer");
        if let Some((key, _)) = file.iter().next() {
            let reason = format!("unknown key `{}`; known are ice, layer", key.get_ref());
            return Err(LayerFileError::at(key.span(), reason));
        }
        let none = || LayerFileError { span: None, reason: "holds no [[layer]]".to_owned() };
        let layers = layers.ok_or_else(none)?;
        let tables = layers.get_ref().as_array().ok_or_else(|| LayerFileError::at(layers.span(), NO_LIST))?;
        if let Some(layer) = tables.get(MOST_LAYERS) {
            let reason = format!("holds {} [[layer]], but must hold at most {MOST_LAYERS}", tables.len());
            return Err(LayerFileError::at(layer.span(), reason));
        }
        if tables.is_empty() {
            return Err(none());
        }
        let read = |(index, table)| read_layer(table, index, (ice, index + 1 == tables.len()));
        let layers: Result<_, _> = tables.iter().enumerate().map(read).collect();
        Ok(Self { layers: layers?, spans: tables.iter().map(Spanned::span).collect(), ice })
    }
}

/// What is wrong with layers that are no list.
const NO_LIST: &str = "layers must be written as [[layer]]";

impl LayerFileError {
    fn at(span: Range<usize>, reason: impl Display) -> Self {
        Self { span: Some(span), reason: reason.to_string() }
    }
}

impl From<Mistake> for LayerFileError {
    fn from(Mistake { span, reason }: Mistake) -> Self {
        Self { span: Some(span), reason }
    }
}

fn read_layer(
    value: &Spanned<DeValue>,
    index: usize,
    (ice, is_last): (IceTable, bool),
) -> Result<Layer, LayerFileError> {
    let path = KeyPath::root("layer").index(index);
    let mut keys = value.get_ref().as_table().cloned().ok_or_else(|| LayerFileError::at(value.span(), NO_LIST))?;
    let thickness = keys.remove("thickness_cm");
    let thickness =
        thickness.ok_or_else(|| LayerFileError::at(value.span(), format!("{path}.thickness_cm is missing")))?;
    if let Some((key, _)) = keys.get_key_value("ice") {
        return Err(LayerFileError::at(key.span(), "`ice` is the same for all layers: it stands above them"));
    }
    let thickness_cm = read(&thickness, &path.key("thickness_cm"), &[])?;
    let checked = |layer: Layer| match layer.check(is_last) {
        Ok(()) => Ok(layer),
        Err(error) => Err(LayerFileError::at(thickness.span(), error)),
    };
    if let Some(kind) = keys.remove("kind") {
        let name: String = read(&kind, &path.key("kind"), &[])?;
        if let Err(error) = check_kind(&name, keys.keys().next().map(|key| &**key.get_ref())) {
            let key = keys.keys().next().filter(|_| name == ICE_KIND);
            return Err(LayerFileError::at(key.map_or(kind.span(), Spanned::span), error));
        }
        return checked(Layer::ice(ice, thickness_cm));
    }
    let snow: SnowKeys = read(&Spanned::new(value.span(), DeValue::Table(keys.clone())), &path, &["thickness_cm"])?;
    let snow = SnowKeys { ice: Some(ice.name().to_owned()), ..snow };
    let sample = snow.sample().map_err(|SnowKeyError { key, impurity, error }| {
        let given = keys.get(key);
        let given_impurity = impurity.and_then(|name| given?.get_ref().as_table()?.get(name.as_str()));
        LayerFileError::at(given_impurity.or(given).map_or(value.span(), Spanned::span), error)
    })?;
    checked(Layer::snow(sample, thickness_cm))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{SnowSample, TruncatedNormal};

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
    fn wrong_values_are_named() {
        for (layer, expected) in [
            ("thickness_cm = 3\ngrain_size_um = 12000", "12000 µm"),
            ("thickness_cm = 3\ngrain_size_um = [1, 2, 3]", "3"),
            ("thickness_cm = 3\nfacetness = \"rough\"", "number or a list of numbers"),
            ("thickness_cm = -3", "thickness is -3 cm"),
            ("thickness_cm = 3\ndensity_kg_m3 = 917", "kind = \"ice\""),
            (
                "thickness_cm = 3\nkind = \"water\"",
                "kind of layer 'water' is not known; it must be ice, or be left out for snow",
            ),
            (
                "thickness_cm = 3\nkind = \"ice\"\nssa_m2_kg = 3",
                "ssa_m2_kg is a property of snow: a layer of clear ice has only",
            ),
            ("thickness_cm = 0\nkind = \"ice\"", "thickness of ice is 0 cm, but must lie in 0.01–100000 cm"),
            ("thickness_cm = inf\nkind = \"ice\"", "thickness of ice is inf cm"),
        ] {
            let error = LayerFile::parse(&format!("[[layer]]\n{layer}\n")).unwrap_err();
            assert!(error.reason.contains(expected), "{}", error.reason);
        }
    }
}
