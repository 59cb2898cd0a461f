//! Lights as data.

use serde::{Deserialize, Serialize};
use snowblue_color::Illuminant;

use super::camera::upwards;
use super::value::numbers;
use crate::notation::text;

/// The spectrum of a light.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum LampDescription {
    /// That of a CIE illuminant.
    #[serde(rename = "illuminant", serialize_with = "text::serialize")]
    Illuminant(Illuminant),
    /// From a CSV file with the columns `wavelength_nm,value`.
    #[serde(rename = "spectrum")]
    File(String),
}

impl Default for LampDescription {
    /// Daylight, D65.
    fn default() -> Self {
        Self::Illuminant(Illuminant::D65)
    }
}

/// The keys of a light's spectrum.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LampKeys {
    #[serde(default, deserialize_with = "text::deserialize_some")]
    illuminant: Option<Illuminant>,
    spectrum: Option<String>,
}

impl LampKeys {
    /// Names of the keys.
    pub(crate) const NAMES: [&str; 2] = ["illuminant", "spectrum"];

    /// The spectrum that they describe; none if both are there.
    pub(crate) fn lamp(self) -> Option<LampDescription> {
        match (self.illuminant, self.spectrum) {
            (None, None) => Some(LampDescription::default()),
            (Some(illuminant), None) => Some(LampDescription::Illuminant(illuminant)),
            (None, Some(file)) => Some(LampDescription::File(file)),
            (Some(_), Some(_)) => None,
        }
    }
}

/// A light with a position or a direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LightDescription {
    /// The shape of its spectrum.
    #[serde(flatten)]
    pub lamp: LampDescription,
    /// Its geometry and strength.
    #[serde(flatten)]
    pub source: LightSource,
}

impl From<LightSource> for LightDescription {
    /// A light of daylight, D65.
    fn from(source: LightSource) -> Self {
        Self { lamp: LampDescription::default(), source }
    }
}

/// The geometry and the strength of a light.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum LightSource {
    /// Shines from a point in all directions.
    Point(PointLightDescription),
    /// Shines from a point into a cone.
    Spot(SpotLightDescription),
    /// Parallel light.
    Directional(DirectionalLightDescription),
    /// A sphere that emits uniformly.
    Sphere(SphereLightDescription),
    /// A rectangle that emits from one side.
    Rectangle(RectangleLightDescription),
}

/// A light that shines from a point in all directions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointLightDescription {
    /// Its position, in m.
    #[serde(deserialize_with = "numbers")]
    pub position: [f64; 3],
    /// Its radiant intensity over 400–700 nm, in W/sr.
    pub radiant_intensity_w_sr: f64,
}

/// A light that shines from a point into a cone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpotLightDescription {
    /// Its position, in m.
    #[serde(deserialize_with = "numbers")]
    pub position: [f64; 3],
    /// A point on the axis of the cone, in m.
    #[serde(deserialize_with = "numbers")]
    pub look_at: [f64; 3],
    /// Its radiant intensity in the middle of the cone over 400–700 nm, in W/sr.
    pub radiant_intensity_w_sr: f64,
    /// Angle from the axis within which it is brightest, in degrees.
    #[serde(default = "SpotLightDescription::default_inner_cone_deg")]
    pub inner_cone_deg: f64,
    /// Angle from the axis beyond which it is dark, in degrees.
    #[serde(default = "SpotLightDescription::default_outer_cone_deg")]
    pub outer_cone_deg: f64,
}

impl SpotLightDescription {
    fn default_inner_cone_deg() -> f64 {
        0.0
    }

    fn default_outer_cone_deg() -> f64 {
        45.0
    }
}

/// Parallel light.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DirectionalLightDescription {
    /// The direction in which it shines, of any length.
    #[serde(deserialize_with = "numbers")]
    pub direction: [f64; 3],
    /// Its irradiance on a plane that it meets at a right angle over 400–700 nm, in W/m².
    pub irradiance_w_m2: f64,
}

/// A sphere that emits uniformly.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereLightDescription {
    /// Its centre, in m.
    #[serde(deserialize_with = "numbers")]
    pub position: [f64; 3],
    /// Its radius, in m.
    pub radius: f64,
    /// Its radiance over 400–700 nm, in W/(m² sr).
    pub radiance_w_m2_sr: f64,
    /// Whether it is visible to the camera.
    #[serde(default = "visible")]
    pub visible: bool,
}

/// A rectangle that emits from one side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RectangleLightDescription {
    /// Its centre, in m.
    #[serde(deserialize_with = "numbers")]
    pub position: [f64; 3],
    /// A point that it faces, in m.
    #[serde(deserialize_with = "numbers")]
    pub look_at: [f64; 3],
    /// The direction of its height, made perpendicular to the direction that it faces; of any length.
    #[serde(default = "upwards", deserialize_with = "numbers")]
    pub up: [f64; 3],
    /// Width and height, in m.
    #[serde(deserialize_with = "numbers")]
    pub size: [f64; 2],
    /// Its radiance over 400–700 nm, in W/(m² sr).
    pub radiance_w_m2_sr: f64,
    /// Whether it is visible to the camera.
    #[serde(default = "visible")]
    pub visible: bool,
}

/// Light from all directions.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum EnvironmentDescription {
    /// The same from everywhere.
    Uniform(UniformSkyDescription),
    /// That of an image.
    Image(ImageSkyDescription),
}

/// Light that is the same from all directions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UniformSkyDescription {
    /// The shape of its spectrum.
    #[serde(flatten)]
    pub lamp: LampDescription,
    /// Its strength.
    #[serde(flatten)]
    pub glow: SkyGlow,
}

/// The strength of a uniform sky.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkyGlow {
    /// Its radiance over 400–700 nm, in W/(m² sr).
    pub radiance_w_m2_sr: f64,
    /// Whether it is visible to the camera.
    #[serde(default = "visible")]
    pub visible: bool,
}

/// Light of an image of all directions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageSkyDescription {
    /// An OpenEXR file, latitude by longitude.
    pub image: String,
    /// Multiplies the image.
    #[serde(default = "ImageSkyDescription::default_scale")]
    pub scale: f64,
    /// Turns the image about z, counter-clockwise seen from above, in degrees.
    #[serde(default)]
    pub rotation_deg: f64,
    /// Whether it is visible to the camera.
    #[serde(default = "visible")]
    pub visible: bool,
}

impl ImageSkyDescription {
    fn default_scale() -> f64 {
        1.0
    }
}

pub(super) fn visible() -> bool {
    true
}
