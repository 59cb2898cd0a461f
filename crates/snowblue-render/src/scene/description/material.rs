//! Materials as data.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use snowblue_database::{Property, TableSample};

use super::value::{ColorDescription, SnowProperty, some_numbers};
use crate::geometry::chord::Exit;
use crate::notation::Notations;
use crate::scene::material::pca_snow::{Emission, PathMode};

/// A material.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum MaterialDescription {
    /// A Lambertian surface.
    Diffuse(DiffuseDescription),
    /// Snow.
    PcaSnow(PcaSnowDescription),
    /// Snow of layers. In a scene file it is `pca_snow` with the key `layers`.
    #[serde(rename = "pca_snow")]
    LayeredSnow(LayeredSnowDescription),
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

/// Snow: what it is made of, and how PCASnow treats it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PcaSnowDescription {
    /// Greatest extension of the grains, in µm.
    pub grain_size_um: SnowProperty,
    /// Facetness of the grains, 0–1.
    pub facetness: SnowProperty,
    /// Density of the snow, in kg/m³.
    pub density_kg_m3: SnowProperty,
    /// Fraction of the pores that water fills; dry if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub water_saturation: Option<SnowProperty>,
    /// Temperature, in °C; −5 °C if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<SnowProperty>,
    /// Mass fractions of impurities by name, in ng/g.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub impurities_ng_g: BTreeMap<String, SnowProperty>,
    /// Blends properties of two values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mask: Option<MaskDescription>,
    /// The straight path that stands for all paths of light through the snow.
    #[serde(default)]
    pub path: PathMode,
    /// Where the path ends.
    #[serde(default)]
    pub exit: Exit,
    /// The light that enters at the end of the path.
    #[serde(default)]
    pub emission: Emission,
    /// A constant reflectance, 0–1, instead of the table's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reflectance: Option<f64>,
}

impl PcaSnowDescription {
    /// Dry, clean, uniform snow with the default settings of PCASnow.
    pub fn new(grain_size_um: f64, facetness: f64, density_kg_m3: f64) -> Self {
        Self {
            grain_size_um: grain_size_um.into(),
            facetness: facetness.into(),
            density_kg_m3: density_kg_m3.into(),
            water_saturation: None,
            temperature_c: None,
            impurities_ng_g: BTreeMap::new(),
            mask: None,
            path: PathMode::default(),
            exit: Exit::default(),
            emission: Emission::default(),
            reflectance: None,
        }
    }

    /// The snow where the mask has a value from 0 to 1.
    pub fn sample_at(&self, mask: f64) -> TableSample {
        let sample =
            TableSample::new(self.grain_size_um.at(mask), self.facetness.at(mask), self.density_kg_m3.at(mask));
        let further = [(Property::WaterSaturation, self.water_saturation), (Property::Temperature, self.temperature_c)];
        let given = further.into_iter().filter_map(|(property, value)| Some((property, value?)));
        given.chain(self.impurities()).fold(sample, |sample, (property, value)| sample.with(property, value.at(mask)))
    }
}

/// Snow of layers, for the integrators `diffusion` and `hybrid`.
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
