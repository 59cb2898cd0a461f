//! A scene: camera, objects, materials, lights, and settings of the film and the integrator, as data and built.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use schemars::JsonSchema;
use serde::Serialize;
use snowblue_base::{Count, KeyError, KeyPath, Numbers};

use snowblue_transport::optics::OwnParticles;

use crate::air::Air;
use crate::camera::{CameraDescription, PerspectiveCamera, View};
use crate::film::sensor::Sensor;
use crate::film::white_balance::PictureWhite;
use crate::film::{FilmSettings, ImageSize, PictureSettings};
use crate::integrator::{Bounces, IntegratorKind, IntegratorSettings, LightFieldSettings, SamplesPerPixel};
use crate::light::{EnvironmentDescription, Light, LightDescription, irradiance_by_sky};
use crate::material::{Material, MaterialDescription};
use crate::objects::Objects;
use crate::shape::ObjectDescription;
use crate::sky::SkyDescription;

/// Settings of a coarse scene: the least factor between the sides of the two pictures, the greatest number of pixels,
/// the number of rays through grains, and the greatest number of rounds of light between bodies.
const COARSE_FACTOR: f64 = 4.0;
const COARSE_PIXELS: f64 = 65_536.0;
const COARSE_GRAIN_RAYS: u32 = 1 << 13;
const COARSE_ROUNDS: u32 = 2;

/// A scene as plain data.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
#[schemars(default, deny_unknown_fields)]
pub struct SceneDescription {
    /// A glTF whose meshes, lights and materials belong to the scene, and its camera where there is no other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gltf: Option<String>,
    /// The camera; the camera of the glTF if absent. `snowblue bake` needs none, unless snow has relief.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraDescription>,
    /// Size and brightness of the picture.
    pub film: FilmSettings,
    /// The integrator and its settings.
    pub integrator: IntegratorSettings,
    /// The grid of the light field in snow.
    pub light_field: LightFieldSettings,
    /// Impurities that are not built in, by name.
    #[serde(rename = "substance", skip_serializing_if = "BTreeMap::is_empty")]
    pub substances: BTreeMap<String, OwnParticles>,
    /// Materials by name.
    #[serde(rename = "material", skip_serializing_if = "BTreeMap::is_empty")]
    pub materials: BTreeMap<String, MaterialDescription>,
    /// Lights with a position or a direction.
    #[serde(rename = "light", skip_serializing_if = "Vec::is_empty")]
    pub lights: Vec<LightDescription>,
    /// Light from all directions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub environment: Option<EnvironmentDescription>,
    /// Sun and sky.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sky: Option<SkyDescription>,
    /// What is there.
    #[serde(rename = "object", skip_serializing_if = "Vec::is_empty")]
    pub objects: Vec<ObjectDescription>,
    /// The origin of these coordinates in the coordinates of the scene file, in m.
    #[serde(skip)]
    #[schemars(skip)]
    pub local_origin: DVec3,
}

impl SceneDescription {
    /// Whether the camera may see a lamp or the sun.
    pub fn has_visible_emitters(&self) -> bool {
        let shows_sun = self.sky.as_ref().is_some_and(SkyDescription::has_visible_sun);
        shows_sun || self.lights.iter().any(|light| light.source.keys().is_visible_emitter())
    }

    /// Whether a material is snow.
    pub fn has_snow(&self) -> bool {
        self.materials.values().any(|material| matches!(material, MaterialDescription::Snow(_)))
    }

    /// Whether noise is filtered: the noise of random walks, of samples of a `sky`, and of light from other surfaces.
    pub fn is_filtered(&self) -> bool {
        self.integrator.filter && self.integrator.kind.has_light_field()
    }

    /// The scene as the text of a scene file.
    ///
    /// # Panics
    ///
    /// Never: every value has a notation in TOML.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("every value has a notation in TOML")
    }
}

/// Everything that a picture depends on. Clones share large data.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The camera; none in a scene that is only baked.
    pub(crate) camera: Option<PerspectiveCamera>,
    pub(crate) objects: Arc<Objects>,
    /// The objects without relief.
    pub(crate) smooth_objects: Arc<Objects>,
    /// Objects refer to materials by index. The materials of the description come first, in the order of their names.
    pub(crate) materials: Arc<Vec<Material>>,
    pub(crate) material_names: Arc<Vec<String>>,
    /// The lights of the description, followed by the lights of a glTF.
    pub(crate) lights: Vec<Arc<Light>>,
    /// Number of lights of the description.
    pub(crate) described_lights: usize,
    /// The air between the camera and the surfaces that it sees, if aerial perspective is on.
    pub(crate) air: Option<Arc<Air>>,
    pub(crate) sensor: Sensor,
    /// The file of the table for PCASnow, if the description names a table.
    pub(crate) table_file: Option<PathBuf>,
    /// The description around the local origin, with the changes made since.
    pub(crate) description: SceneDescription,
    /// Sentences that say what was changed in meshes. `solid_notes` has no sentence about changes for the relief.
    pub(crate) notes: Vec<String>,
    pub(crate) solid_notes: Vec<String>,
    /// Hashes of the files that were read, by name: the files for the lights of the description, and all other files.
    pub(crate) light_files: BTreeMap<String, u64>,
    pub(crate) solid_files: BTreeMap<String, u64>,
}

impl Scene {
    /// The camera of the description or of its glTF.
    ///
    /// # Errors
    ///
    /// If the description has no camera, which a bake does not need.
    pub fn camera(&self) -> Result<&PerspectiveCamera, KeyError> {
        let reason = "is missing, and there is no glTF with a perspective camera";
        self.camera.as_ref().ok_or_else(|| KeyPath::root("camera").error(reason))
    }

    /// The sensor, which turns spectra into colours.
    pub fn sensor(&self) -> &Sensor {
        &self.sensor
    }

    /// The settings of a PNG, and the colour of the sky, from which another white follows.
    pub fn picture_settings(&self) -> PictureSettings {
        let sky = Sensor::cie_1931().white_xyz(&irradiance_by_sky(&self.lights));
        let white = PictureWhite { white: self.description.film.white, sky };
        PictureSettings { development: self.description.film.development(), white }
    }

    /// The file of the table for PCASnow, if the description names a table.
    pub fn table_file(&self) -> Option<&Path> {
        self.table_file.as_deref()
    }

    /// The objects. Objects with relief have triangles for the camera and the size of the picture with which the
    /// scene was built.
    pub fn objects(&self) -> &Objects {
        &self.objects
    }

    /// The materials; objects refer to these by index.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The names of the materials, in their order. The plane of a snow and the snow share a name.
    pub fn material_names(&self) -> &[String] {
        &self.material_names
    }

    /// The lights.
    pub fn lights(&self) -> &[Arc<Light>] {
        &self.lights
    }

    /// The air between the camera and the surfaces that it sees, if aerial perspective is on.
    pub fn air(&self) -> Option<&Air> {
        self.air.as_deref()
    }

    /// Size and brightness of the picture.
    pub fn film(&self) -> &FilmSettings {
        &self.description.film
    }

    /// The integrator and its settings.
    pub fn integrator(&self) -> &IntegratorSettings {
        &self.description.integrator
    }

    /// The description from which the scene was built, around its [local origin](Self::local_origin), with the changes
    /// made since.
    pub fn description(&self) -> &SceneDescription {
        &self.description
    }

    /// The origin of the scene in the coordinates of the description from which it was built, in m. It is 0 unless the
    /// camera looks at a point farther than 500 m from their origin.
    pub fn local_origin(&self) -> DVec3 {
        self.description.local_origin
    }

    /// Sentences that say what was changed in meshes.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Hashes of the files that were read, by name.
    pub fn file_hashes(&self) -> BTreeMap<&str, u64> {
        self.solid_files.iter().chain(&self.light_files).map(|(name, hash)| (&**name, *hash)).collect()
    }

    /// The path in the description of a material, given by its index. For a material of a glTF, this is the path of
    /// all materials.
    pub fn material_path(&self, material: usize) -> KeyPath {
        let path = KeyPath::root("material");
        self.description.materials.keys().nth(material).map_or(path.clone(), |name| path.key(name))
    }

    /// The scene for a first picture, which takes about a second: few pixels with one sample each, rendered by
    /// `diffusion` with coarse cells. The cells take at most `memory_mib` MiB. None for PCASnow, which has no cells.
    pub fn coarse(&self, memory_mib: u32) -> Option<Self> {
        if self.description.integrator.kind.has_curves() {
            return None;
        }
        let mut coarse = self.clone();
        let [width, height] =
            [self.description.film.width, self.description.film.height].map(|side| f64::from(side.get()));
        let factor = (width * height / COARSE_PIXELS).sqrt().max(COARSE_FACTOR);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small positive numbers")]
        let [width, height] = [width, height].map(|side| (side / factor).ceil() as u32);
        coarse.set_image_size(ImageSize { width, height });
        coarse.description.integrator.kind = IntegratorKind::Diffusion;
        coarse.description.integrator.noise_target = None;
        coarse.set_samples_per_pixel(Count::of(1));
        coarse.description.light_field = LightFieldSettings {
            memory_mib: self.description.light_field.memory_mib,
            coarse_memory_mib: Some(memory_mib),
            grain_rays: COARSE_GRAIN_RAYS,
            most_rounds: COARSE_ROUNDS,
            ..LightFieldSettings::default()
        };
        Some(coarse)
    }

    /// Sets the number of samples per pixel.
    pub fn set_samples_per_pixel(&mut self, samples: Count<SamplesPerPixel>) {
        self.description.integrator.samples_per_pixel = samples;
    }

    /// Sets the greatest number of surfaces after the first on a path.
    pub fn set_max_bounces(&mut self, bounces: Count<Bounces>) {
        self.description.integrator.max_bounces = bounces;
    }

    /// Sets the seed of the random numbers.
    pub fn set_seed(&mut self, seed: u32) {
        self.description.integrator.seed = seed;
    }

    /// Sets the size of the picture, within the least and the greatest size. The vertical field of view stays.
    pub fn set_image_size(&mut self, size: ImageSize) {
        (self.description.film.width, self.description.film.height) =
            (Count::nearest(size.width), Count::nearest(size.height));
        let lens = self.description.camera.as_ref().map(CameraDescription::lens).unwrap_or_default();
        let aspect = self.description.film.aspect();
        self.camera = self.camera.and_then(|camera| PerspectiveCamera::new(camera.view(), lens, aspect));
    }

    /// Points the camera elsewhere, in coordinates from the [local origin](Self::local_origin), and keeps its lens.
    /// Returns false without a change if the view looks along its own up direction or nowhere, or is out of range.
    ///
    /// The method does not check that the camera stays out of snow.
    pub fn set_view(&mut self, view: &View) -> bool {
        let aspect = self.description.film.aspect();
        let described = self.description.camera.clone();
        let lens = described.as_ref().map(CameraDescription::lens).unwrap_or_default();
        let Some(camera) = PerspectiveCamera::new(view, lens, aspect) else {
            return false;
        };
        let described =
            described.unwrap_or_else(|| CameraDescription::new(Numbers::default(), Numbers::default())).with_view(view);
        let Ok(described) = described else { return false };
        self.camera = Some(camera);
        self.description.camera = Some(described);
        true
    }
}
