//! Materials as data.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use snowblue_shapes::roughness::{Roughness, RoughnessStatistics};
use snowblue_transport::sample::SnowKeys;

use super::value::{ColorDescription, some_numbers};
use crate::notation::Notations;

/// A material.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
#[expect(clippy::large_enum_variant, reason = "there is one for each material")]
pub enum MaterialDescription {
    /// A Lambertian surface.
    Diffuse(DiffuseDescription),
    /// Snow.
    Snow(SnowMaterialDescription),
}

/// Snow as a material: what it is made of, and how its surface is drawn.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SnowMaterialDescription {
    /// What it is made of.
    #[serde(flatten)]
    pub snow: SnowDescription,
    /// Its sparkle, if it is drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sparkle: Option<SparkleDescription>,
    /// The relief of its surface, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relief: Option<ReliefDescription>,
}

impl SnowMaterialDescription {
    /// The keys beside those of the snow.
    pub(crate) const NAMES: [&'static str; 2] = ["sparkle", "relief"];
}

/// Snow without sparkle and without relief.
impl From<SnowDescription> for SnowMaterialDescription {
    fn from(snow: SnowDescription) -> Self {
        Self { snow, sparkle: None, relief: None }
    }
}

/// Sparkle: the facets of the grains at the surface that mirror a light into the camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SparkleDescription {
    /// Mean diameter of the facets, in µm; none for that which follows from grain size and facetness.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub facet_size_um: Option<f64>,
    /// Share of the surface of the grains that is flat facets, 0–1; the rest reflects smoothly.
    pub flat_fraction: f64,
}

impl Default for SparkleDescription {
    /// Facets by grain size and facetness, all over the grains.
    fn default() -> Self {
        Self { facet_size_um: None, flat_fraction: 1.0 }
    }
}

/// The relief of a surface: random heights of known statistics.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReliefDescription {
    /// Root mean square of the heights, in mm.
    pub height_mm: f64,
    /// The distance at which the autocorrelation of heights is 1/e, in mm.
    pub correlation_mm: f64,
    /// Hurst exponent, 0–1: how much finer structure is lower than coarser one.
    #[serde(default = "ReliefDescription::usual_hurst")]
    pub hurst: f64,
    /// Another number gives other heights of the same statistics.
    #[serde(default = "ReliefDescription::first_seed")]
    pub seed: u32,
}

/// Kinds of snow with a relief of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReliefKind {
    /// New snow that fell without wind.
    Fresh,
    /// Snow that the wind has packed and smoothed.
    WindPacked,
    /// Snow that the sun has melted into small hollows.
    MeltForms,
}

impl ReliefKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Fresh, Self::WindPacked, Self::MeltForms];

    /// Its name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fresh => "fresh",
            Self::WindPacked => "wind-packed",
            Self::MeltForms => "melt-forms",
        }
    }
}

impl From<ReliefKind> for ReliefDescription {
    fn from(kind: ReliefKind) -> Self {
        let (height_mm, correlation_mm, hurst) = match kind {
            ReliefKind::Fresh => (1.0, 25.0, 0.6),
            ReliefKind::WindPacked => (1.2, 50.0, 0.7),
            ReliefKind::MeltForms => (3.0, 60.0, 0.8),
        };
        Self { height_mm, correlation_mm, hurst, seed: Self::first_seed() }
    }
}

impl ReliefDescription {
    fn usual_hurst() -> f64 {
        0.5
    }

    fn first_seed() -> u32 {
        1
    }

    /// The random heights.
    pub(crate) fn roughness(&self) -> Roughness {
        let Self { height_mm, correlation_mm, hurst, seed } = *self;
        let statistics =
            RoughnessStatistics { height_m: 1e-3 * height_mm, correlation_m: 1e-3 * correlation_mm, hurst };
        Roughness::new(&statistics, seed)
    }
}

impl MaterialDescription {
    /// Whether it has relief.
    pub(crate) fn has_relief(&self) -> bool {
        matches!(self, Self::Snow(SnowMaterialDescription { relief: Some(_), .. }))
    }
}

/// The reflectance of a Lambertian surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "DiffuseKeys")]
pub enum DiffuseDescription {
    /// The same at all wavelengths.
    Uniform {
        /// The fraction of the light that is reflected, 0–1.
        reflectance: f64,
    },
    /// That of a colour under daylight.
    Color {
        /// The colour.
        reflectance_rgb: ColorDescription,
    },
    /// A spectrum.
    Spectrum {
        /// A CSV file with the columns `wavelength_nm,value`.
        reflectance_spectrum: String,
    },
    /// The colours of an image in encoded sRGB.
    Texture(TextureDescription),
}

/// An image on a surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TextureDescription {
    /// A PNG file.
    pub texture: String,
    /// Width of the image on boxes and planes, in m.
    pub texture_scale_m: f64,
}

impl TextureDescription {
    /// An image that is 1 m wide on boxes and planes.
    pub fn new(file: impl Into<String>) -> Self {
        Self { texture: file.into(), texture_scale_m: 1.0 }
    }

    fn of(texture: String, texture_scale_m: Option<f64>) -> Self {
        let default = Self::new(texture);
        Self { texture_scale_m: texture_scale_m.unwrap_or(default.texture_scale_m), ..default }
    }
}

/// The keys of a diffuse material.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DiffuseKeys {
    reflectance: Option<f64>,
    reflectance_rgb: Option<ColorDescription>,
    reflectance_spectrum: Option<String>,
    texture: Option<String>,
    texture_scale_m: Option<f64>,
}

impl TryFrom<DiffuseKeys> for DiffuseDescription {
    type Error = String;

    fn try_from(keys: DiffuseKeys) -> Result<Self, String> {
        if keys.texture_scale_m.is_some() && keys.texture.is_none() {
            return Err("has `texture_scale_m`, which needs a `texture`".into());
        }
        let given = [
            keys.reflectance.map(|reflectance| Self::Uniform { reflectance }),
            keys.reflectance_rgb.map(|reflectance_rgb| Self::Color { reflectance_rgb }),
            keys.reflectance_spectrum.map(|reflectance_spectrum| Self::Spectrum { reflectance_spectrum }),
            keys.texture.map(|texture| Self::Texture(TextureDescription::of(texture, keys.texture_scale_m))),
        ];
        let names = ["reflectance", "reflectance_rgb", "reflectance_spectrum", "texture"];
        let mut given = given.into_iter().zip(names).filter_map(|(value, name)| Some((value?, name)));
        match (given.next(), given.next()) {
            (Some((value, _)), None) => Ok(value),
            (Some((_, first)), Some((_, second))) => Err(format!("has either `{first}` or `{second}`, not both")),
            (None, _) => Err(format!("needs one of {}", names.join(", "))),
        }
    }
}

/// Snow, by the keys of its table: what it is made of, or layers, or two snows and a mask.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
#[expect(clippy::large_enum_variant, reason = "there is one for each material")]
pub enum SnowDescription {
    /// The same everywhere.
    Uniform(SnowKeys),
    /// Layers.
    Layers(LayeredSnowDescription),
    /// Two snows and a mask.
    Masked(MaskedSnowDescription),
}

/// Snow of layers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayeredSnowDescription {
    /// A file of layers, top first ([`layer_file`](snowblue_transport::layer_file)). The last layer goes on below.
    pub layers: String,
    /// Where the first layer begins.
    #[serde(default)]
    pub layers_top: LayersTop,
}

impl LayeredSnowDescription {
    /// The layers of a file, below the surface of the snow.
    pub fn new(file: impl Into<String>) -> Self {
        Self { layers: file.into(), layers_top: LayersTop::default() }
    }
}

/// Snow that varies between two snows. Every property is in proportion to the mask.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaskedSnowDescription {
    /// Where it is which.
    pub mask: MaskDescription,
    /// The snow where the mask is 0, and where it is 1.
    #[serde(deserialize_with = "two_snows")]
    pub between: [SnowKeys; 2],
}

/// Reads a list of two tables of snow.
fn two_snows<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[SnowKeys; 2], D::Error> {
    let snows = Vec::<SnowKeys>::deserialize(deserializer)?;
    let count = snows.len();
    let snow = if count == 1 { "snow" } else { "snows" };
    snows.try_into().map_err(|_| D::Error::custom(format!("has {count} {snow}, but must have two")))
}

/// Where the first layer of snow begins, from which all depths count vertically.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum LayersTop {
    /// At the topmost surface of the body above each point: layers follow the terrain.
    #[default]
    Surface,
    /// At a height z, in m: layers are horizontal, and snow above is of the first.
    Height(f64),
}

impl Serialize for LayersTop {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Surface => serializer.serialize_str("surface"),
            Self::Height(height_m) => serializer.serialize_f64(*height_m),
        }
    }
}

impl<'de> Deserialize<'de> for LayersTop {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Notations::<Self, 0> {
            expected: "\"surface\" or a height in m",
            number: Some(Self::Height),
            text: Some(|text| match text {
                "surface" => Ok(Self::Surface),
                other => Err(format!("is \"{other}\", but must be \"surface\" or a height in m")),
            }),
            list: None,
        })
    }
}

/// A number between 0 and 1 for each point of a surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "MaskKeys")]
pub enum MaskDescription {
    /// The first channel of an image, undecoded.
    Texture(TextureDescription),
    /// A value at the vertices of a mesh.
    Attribute {
        /// The attribute's name in the mesh file.
        attribute: String,
        /// The values that count as 0 and as 1.
        range: [f64; 2],
    },
}

impl MaskDescription {
    /// An attribute of values from 0 to 1.
    pub fn attribute(name: impl Into<String>) -> Self {
        Self::Attribute { attribute: name.into(), range: [0.0, 1.0] }
    }
}

/// The keys of a mask.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MaskKeys {
    texture: Option<String>,
    texture_scale_m: Option<f64>,
    attribute: Option<String>,
    #[serde(default, deserialize_with = "some_numbers")]
    range: Option<[f64; 2]>,
}

impl TryFrom<MaskKeys> for MaskDescription {
    type Error = &'static str;

    fn try_from(keys: MaskKeys) -> Result<Self, &'static str> {
        match (keys.texture, keys.texture_scale_m, keys.attribute, keys.range) {
            (Some(texture), width_m, None, None) => Ok(Self::Texture(TextureDescription::of(texture, width_m))),
            (None, None, Some(attribute), Some(range)) => Ok(Self::Attribute { attribute, range }),
            (None, None, Some(attribute), None) => Ok(Self::attribute(attribute)),
            _ => Err("needs either `texture` and `texture_scale_m`, or `attribute` and `range`"),
        }
    }
}
