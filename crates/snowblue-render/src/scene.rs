//! A scene ready to be rendered: camera, objects, materials, lights, and how the picture is to be made.

use std::fmt;
use std::num::ParseFloatError;
use std::str::FromStr;

use crate::camera::PinholeCamera;
use crate::light::Light;
use crate::material::Material;
use crate::objects::Objects;
use crate::retina::Retina;

use snowblue_transport::monte_carlo::Volume;

/// Everything that a picture depends on.
#[derive(Debug)]
pub struct Scene {
    /// The eye.
    pub camera: PinholeCamera,
    /// What is there.
    pub objects: Objects,
    /// What it is made of; objects refer to these by index.
    pub materials: Vec<Material>,
    /// What shines.
    pub lights: Vec<Light>,
    /// The picture's size and brightness.
    pub film: FilmSettings,
    /// How many paths there are and how long.
    pub integrator: IntegratorSettings,
    /// What colours light has.
    pub(crate) retina: Retina,
    /// The snow of each material, where light walks from grain to grain; empty where it need not.
    pub(crate) volumes: Vec<Option<Volume>>,
}

/// Size and brightness of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmSettings {
    /// Pixels from left to right.
    pub width: u32,
    /// Pixels from top to bottom.
    pub height: u32,
    /// Brightness of the PNG.
    pub exposure: Exposure,
}

/// How radiance becomes brightness in a PNG; EXR files keep radiance as it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Exposure {
    /// The brightest percent of the pixels comes close to white.
    #[default]
    Auto,
    /// Radiance times 2^stops: at 0 stops, a luminance of 1 (that of 1 W m⁻² sr⁻¹ of equal-energy light over
    /// 400–700 nm) is white.
    Stops(f64),
}

/// Stops, or `auto`.
impl fmt::Display for Exposure {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Auto => formatter.write_str("auto"),
            Self::Stops(stops) => write!(formatter, "{stops}"),
        }
    }
}

/// Reads what [`Display`](fmt::Display) wrote, to the same bits.
impl FromStr for Exposure {
    type Err = ParseFloatError;

    fn from_str(text: &str) -> Result<Self, ParseFloatError> {
        if text == "auto" { Ok(Self::Auto) } else { text.parse().map(Self::Stops) }
    }
}

/// How light finds its way through snow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Integrator {
    /// PCASnow: by the curves of a slab, along one straight line.
    #[default]
    Path,
    /// From grain to grain, whatever the shape: slow, and true on average.
    Reference,
}

/// How many paths there are and how long.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct IntegratorSettings {
    /// Which way through snow.
    pub integrator: Integrator,
    /// Paths per pixel.
    pub samples_per_pixel: u32,
    /// Surfaces after the first one that a path may visit; 0 is light straight from the lights only.
    pub max_bounces: u32,
    /// Which random numbers.
    pub seed: u32,
}
