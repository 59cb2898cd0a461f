//! The keys of snow in a scene file: its composition, its sparkle and its relief.

use std::ops::Range;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::files::check_formats;
use snowblue_base::toml_table::Table;
use snowblue_base::{KeyError, KeyPath, ParseError};
use snowblue_transport::layer_file::LayerFile;
use snowblue_transport::sample::{SnowKeyError, SnowKeys};
use snowblue_transport::{Layer, SnowSample};

use crate::error::SceneError;
use crate::layering::{Layering, LayersTop};
use crate::material::mask::MaskDescription;
use crate::material::relief::ReliefDescription;
use crate::material::snow::{Snow, SnowMaterial};
use crate::material::sparkle::SparkleDescription;
use crate::sources::Sources;
use crate::spectrum::wavelengths_nm;
use crate::values::{AnyOf, beside};

/// Snow as a material: what it is made of, and how its surface is drawn.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SnowMaterialDescription {
    /// What it is made of.
    #[serde(flatten)]
    pub snow: SnowDescription,
    /// Its sparkle, if it is drawn: `true`, or a table.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<AnyOf<bool, SparkleDescription>>")]
    pub sparkle: Option<SparkleDescription>,
    /// The relief of its surface, if it has one: `fresh`, `wind-packed`, `melt-forms`, or a table.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<AnyOf<String, ReliefDescription>>")]
    pub relief: Option<ReliefDescription>,
}

/// What snow is made of, by the keys of its table: one snow, layers, or two snows and a mask.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
#[expect(clippy::large_enum_variant, reason = "there is one for each material")]
pub enum SnowDescription {
    /// One snow.
    Uniform(SnowKeys),
    /// Layers.
    Layers(LayeredSnowDescription),
    /// Two snows and a mask.
    Masked(MaskedSnowDescription),
}

/// Snow of layers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LayeredSnowDescription {
    /// A file of layers, top first. The last layer goes on below.
    pub layers: String,
    /// Where the first layer begins: "surface", or a height z in m.
    #[serde(default)]
    pub layers_top: LayersTop,
}

/// Snow that varies between two snows. Every property is in proportion to the mask.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MaskedSnowDescription {
    /// Where it is which.
    pub mask: MaskDescription,
    /// The snow where the mask is 0, and where it is 1.
    pub between: [SnowKeys; 2],
}

impl LayeredSnowDescription {
    /// The layers of a file, below the surface of the snow.
    pub fn new(file: impl Into<String>) -> Self {
        Self { layers: file.into(), layers_top: LayersTop::default() }
    }

    fn build(&self, path: &KeyPath, sources: &Sources) -> Result<Snow, SceneError> {
        let file = sources.open(&path.key("layers"), &self.layers)?;
        check_formats(&file.path)?;
        let text = file.text();
        let wrong = |error: ParseError| SceneError::Text {
            path: file.path.clone(),
            line: error.line(&text),
            reason: error.reason,
        };
        let LayerFile { layers, spans, .. } = LayerFile::parse(&text).map_err(wrong)?;
        let sample = |(layer, span): (&Layer, Range<usize>)| {
            let reason = "layer of clear ice has no model in scenes, whose layers must be of snow".to_owned();
            layer.sample().copied().ok_or_else(|| wrong(ParseError { span, reason }))
        };
        let samples = layers.iter().zip(spans).map(sample).collect::<Result<_, _>>()?;
        Ok(Snow::Layers { samples, layering: Layering::new(&layers, self.layers_top) })
    }
}

impl MaskedSnowDescription {
    fn read(mut table: Table) -> Result<Self, ParseError> {
        let (Some(mask), Some(between)) = (table.take("mask"), table.take("between")) else {
            return Err(table.error("needs both `mask` and `between`"));
        };
        let mask = MaskDescription::read(mask.table()?)?;
        let snows = between.clone().tables()?.into_iter().map(Table::read).collect::<Result<Vec<SnowKeys>, _>>()?;
        let count = snows.len();
        let wrong = |_| between.error(format!("has {count} snows, but must have two"));
        table.finish()?;
        Ok(Self { mask, between: snows.try_into().map_err(wrong)? })
    }

    fn build(&self, path: &KeyPath, sources: &Sources) -> Result<Snow, SceneError> {
        let mask = self.mask.build(&path.key("mask"), sources)?;
        let path = path.key("between");
        let [first, last] = &self.between;
        let between = [sample(&path.index(0), first)?, sample(&path.index(1), last)?];
        if between[0].grain_size.measure != between[1].grain_size.measure {
            let reason = "has two measures of grain size, but must have one: a kind of snow and ssa_m2_kg state \
                          optical diameters";
            return Err(path.error(reason).into());
        }
        if between[0].ice != between[1].ice {
            return Err(path.error("has two tables of ice, but must have one").into());
        }
        Ok(Snow::Masked { mask, between })
    }
}

impl SnowDescription {
    /// Reads snow. The keys of layers and of masks decide which kind of description it is.
    fn read(table: Table) -> Result<Self, ParseError> {
        const OF_SNOW: [&str; 4] = ["snow", "grain_size_um", "ssa_m2_kg", "density_kg_m3"];
        let alone = |key: &str, others: &[&str]| match others.iter().find(|other| table.has(other)) {
            Some(other) => Err(table.error_at(other, beside(key))),
            None => Ok(()),
        };
        if table.has("layers") {
            alone("layers", &[&OF_SNOW[..], &["mask", "between"]].concat())?;
            return table.read().map(Self::Layers);
        }
        if let Some(key) = ["mask", "between"].into_iter().find(|key| table.has(key)) {
            alone(key, &OF_SNOW)?;
            return MaskedSnowDescription::read(table).map(Self::Masked);
        }
        table.read().map(Self::Uniform)
    }

    /// Builds snow, whose tables of constants must cover the wavelengths of the picture.
    fn build(&self, path: &KeyPath, sources: &Sources) -> Result<Snow, SceneError> {
        let built = match self {
            Self::Uniform(keys) => Snow::Uniform(sample(path, keys)?),
            Self::Layers(layered) => layered.build(path, sources)?,
            Self::Masked(masked) => masked.build(path, sources)?,
        };
        for sample in built.samples() {
            for wavelength_nm in wavelengths_nm() {
                let covered = sample.check_wavelength(wavelength_nm);
                covered.map_err(|error| path.error(format!("has no constants: {error}")))?;
            }
        }
        Ok(built)
    }
}

impl SnowMaterialDescription {
    pub(super) fn read(mut table: Table) -> Result<Self, ParseError> {
        let sparkle = table.take("sparkle").map_or(Ok(None), SparkleDescription::read)?;
        let relief = table.take("relief").map(ReliefDescription::read).transpose()?;
        Ok(Self { snow: SnowDescription::read(table)?, sparkle, relief })
    }

    pub(super) fn build(&self, path: &KeyPath, sources: &Sources) -> Result<SnowMaterial, SceneError> {
        let snow = self.snow.build(path, sources)?;
        if let Some(sparkle) = &self.sparkle {
            let sizes_um = snow.samples().iter().map(|sample| sample.grain_size.middle_um());
            sparkle.check(&path.key("sparkle"), sizes_um.fold(f64::INFINITY, f64::min))?;
        }
        if let Some(relief) = &self.relief {
            relief.check(&path.key("relief"))?;
        }
        Ok(SnowMaterial { snow, sparkle: self.sparkle, relief: self.relief })
    }
}

/// Snow without sparkle and without relief.
impl From<SnowDescription> for SnowMaterialDescription {
    fn from(snow: SnowDescription) -> Self {
        Self { snow, sparkle: None, relief: None }
    }
}

/// The snow sample that some keys describe.
fn sample(path: &KeyPath, keys: &SnowKeys) -> Result<SnowSample, KeyError> {
    keys.sample().map_err(|SnowKeyError { key, impurity, error }| {
        let path = path.key(key);
        impurity.map_or(path.clone(), |name| path.key(&name)).error(error.after_key())
    })
}
