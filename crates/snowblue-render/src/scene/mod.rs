//! A scene ready to be rendered: camera, objects, materials, lights, and settings of the film and the integrator.
//!
//! A scene is built from a [`SceneDescription`], which is made in code or read from a TOML [`mod@file`]. What is built
//! fits together: change the description and build it again to change the scene.

mod build;
pub mod camera;
pub mod description;
pub mod file;
pub(crate) mod integrator;
pub(crate) mod layering;
pub mod light;
pub(crate) mod light_field;
pub mod material;
pub mod objects;
pub mod queries;
pub mod undisturbed;

use std::collections::BTreeMap;

use snowblue_transport::monte_carlo::Volume;

use crate::film::exposure::FilmSettings;
use crate::film::sensor::Sensor;
use crate::images::raster::ImageSize;
use crate::scene::camera::{PinholeCamera, View};
use crate::scene::description::{CameraDescription, SceneDescription};
use crate::scene::light::Light;
use crate::scene::light_field::LightField;
use crate::scene::material::Material;
use crate::scene::objects::Objects;

pub use integrator::{IntegratorKind, IntegratorSettings, LightFieldSettings};

/// Everything that a picture depends on.
#[derive(Debug)]
pub struct Scene {
    pub(crate) camera: PinholeCamera,
    /// The view of the camera.
    view: View,
    pub(crate) objects: Objects,
    /// Objects refer to these by index.
    pub(crate) materials: Vec<Material>,
    /// The lights of the description, and then those of a glTF.
    pub(crate) lights: Vec<Light>,
    /// How many of them the description has.
    described_lights: usize,
    pub(crate) film: FilmSettings,
    pub(crate) integrator: IntegratorSettings,
    pub(crate) sensor: Sensor,
    /// The layers of snow of each material, for random walks; empty without them.
    pub(crate) volumes: Vec<Vec<Volume>>,
    /// The light in the snow, for the integrator that needs it.
    pub(crate) light_field: Option<LightField>,
    solved_light_fields: usize,
    /// What the scene was built from.
    pub(crate) description: SceneDescription,
    /// Hashes of the files that were read, by name: for the lights of the description, and for all else.
    light_files: BTreeMap<String, u64>,
    solid_files: BTreeMap<String, u64>,
}

impl Scene {
    /// The camera.
    pub fn camera(&self) -> &PinholeCamera {
        &self.camera
    }

    /// The objects.
    pub fn objects(&self) -> &Objects {
        &self.objects
    }

    /// The materials; objects refer to these by index.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The lights.
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// Size and brightness of the picture.
    pub fn film(&self) -> &FilmSettings {
        &self.film
    }

    /// The integrator and its settings.
    pub fn integrator(&self) -> &IntegratorSettings {
        &self.integrator
    }

    /// What the scene was built from, with the changes made since.
    pub fn description(&self) -> &SceneDescription {
        &self.description
    }

    /// Hashes of the files that were read, by name.
    pub(crate) fn file_hashes(&self) -> BTreeMap<&str, u64> {
        self.solid_files.iter().chain(&self.light_files).map(|(name, hash)| (&**name, *hash)).collect()
    }

    /// The number of light fields that were solved for when the scene was built, one for all lights of one spectrum.
    /// Those that were kept of [an earlier scene](SceneDescription::build_after) do not count.
    pub fn solved_light_fields(&self) -> usize {
        self.solved_light_fields
    }

    /// If the cells of a wide body of snow have sizes for the pixels of the image: the factor of these sizes that makes
    /// them fit into the memory of the light field. Light leaks through snow that is thinner than two cells.
    pub fn factor_of_cells(&self) -> Option<f64> {
        self.light_field.as_ref().and_then(LightField::view_factor)
    }

    /// Sets the number of samples per pixel, at least one.
    pub fn set_samples_per_pixel(&mut self, samples: u32) {
        self.integrator.samples_per_pixel = samples.max(1);
        self.description.integrator = self.integrator;
    }

    /// Sets the greatest number of surfaces after the first on a path.
    pub fn set_max_bounces(&mut self, bounces: u32) {
        self.integrator.max_bounces = bounces;
        self.description.integrator = self.integrator;
    }

    /// Sets the seed of the random numbers.
    pub fn set_seed(&mut self, seed: u32) {
        self.integrator.seed = seed;
        self.description.integrator = self.integrator;
    }

    /// Sets the size of the picture; the vertical field of view stays. A size has at least one pixel.
    pub fn set_image_size(&mut self, size: ImageSize) {
        (self.film.width, self.film.height) = (size.width.max(1), size.height.max(1));
        self.description.film = self.film;
        let view = self.view;
        self.set_view(&view);
    }

    /// Points the camera elsewhere; false, and no change, if the view looks along its own up direction or nowhere.
    ///
    /// It does not check that the camera stays out of snow. The light field of a wide body keeps the cells that the
    /// former view needed.
    pub fn set_view(&mut self, view: &View) -> bool {
        let aspect = self.film.width as f32 / self.film.height as f32;
        let Some(camera) = PinholeCamera::new(view, aspect) else {
            return false;
        };
        (self.camera, self.view) = (camera, *view);
        self.description.camera = Some(CameraDescription::from(view));
        true
    }
}
