//! A scene ready to be rendered: camera, objects, materials, lights, and how the picture is to be made.

pub mod camera;
pub mod file;
pub mod light;
pub mod material;
pub mod objects;
pub mod queries;

use crate::film::exposure::FilmSettings;
use crate::film::sensor::Sensor;
use crate::scene::camera::PinholeCamera;
use crate::scene::light::Light;
use crate::scene::material::Material;
use crate::scene::objects::Objects;

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
    pub(crate) sensor: Sensor,
    /// The snow of each material, where light walks from grain to grain; empty where it need not.
    pub(crate) volumes: Vec<Option<Volume>>,
}

/// How light finds its way through snow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum IntegratorKind {
    /// PCASnow: by the curves of a slab, along one straight line.
    #[default]
    PcaSnow,
    /// From grain to grain, whatever the shape: slow, and true on average.
    Reference,
}

impl IntegratorKind {
    /// All kinds.
    pub const ALL: [Self; 2] = [Self::PcaSnow, Self::Reference];

    /// Its name in scene files and options.
    pub fn name(self) -> &'static str {
        match self {
            Self::PcaSnow => "pcasnow",
            Self::Reference => "reference",
        }
    }
}

/// How many paths there are and how long.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct IntegratorSettings {
    /// Which way through snow.
    pub kind: IntegratorKind,
    /// Paths per pixel.
    pub samples_per_pixel: u32,
    /// Surfaces after the first one that a path may visit; 0 is light straight from the lights only.
    pub max_bounces: u32,
    /// Which random numbers.
    pub seed: u32,
}
