//! Builds a scene from a description: reads the files that the description names, and checks that its parts fit
//! together.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec3;
use snowblue_base::files::FileSource;
use snowblue_base::{KeyError, KeyPath};
use snowblue_transport::SnowSample;

use crate::air::Air;
use crate::camera::{CameraDescription, PerspectiveCamera, View};
use crate::changes::Changes;
use crate::error::SceneError;
use crate::film::sensor::Sensor;
use crate::film::white_balance::WhiteBalance;
use crate::gltf::read_gltf;
use crate::light::{Light, irradiance_by_sky};
use crate::material::deep_snow::DeepSnow;
use crate::material::{Material, MaterialDescription, NamedMaterial, build_materials};
use crate::objects::{Object, Objects};
use crate::progress::{Phase, Progress, Report};
use crate::scene::{Scene, SceneDescription};
use crate::shape::{ObjectBuilder, ObjectDescription, body_of_two, notes_on_bodies, with_relief};
use crate::sky::BuiltSky;
use crate::sources::{RecordedFiles, Sources};

/// The parts of a scene without its described lights.
struct Solids {
    objects: Arc<Objects>,
    materials: Arc<Vec<Material>>,
    material_names: Arc<Vec<String>>,
    gltf_lights: Vec<Arc<Light>>,
    gltf_view: Option<View>,
    /// Sentences that say what was changed in meshes.
    notes: Vec<String>,
    /// Hashes of the files that were read, by name.
    files: BTreeMap<String, u64>,
}

/// The described lights, with the air below the sky and hashes of the files that were read for them.
struct DescribedLights {
    lights: Vec<Arc<Light>>,
    air: Option<Arc<Air>>,
    files: BTreeMap<String, u64>,
}

impl SceneDescription {
    /// Builds the scene, with files from `files`.
    ///
    /// # Errors
    ///
    /// When a value is out of range, or a file is missing or malformed. The error names the path of the value in the
    /// description, or the file.
    pub fn build(&self, files: &dyn FileSource) -> Result<Scene, SceneError> {
        self.build_smooth(files)?.with_relief(&|_| {})
    }

    /// Builds the scene like [`build`](Self::build), without the relief of its snow, which [`Scene::with_relief`] adds.
    ///
    /// # Errors
    ///
    /// As [`build`](Self::build).
    pub fn build_smooth(&self, files: &dyn FileSource) -> Result<Scene, SceneError> {
        self.around_local_origin()?.build_with(None, None, files)
    }

    /// Builds the scene like [`build`](Self::build), and shares equal parts with an earlier scene whose files were
    /// the same. The pictures are identical to the last bit.
    ///
    /// # Errors
    ///
    /// As [`build`](Self::build).
    pub fn build_after(&self, earlier: &Scene, files: &dyn FileSource) -> Result<Scene, SceneError> {
        let description = self.around_local_origin()?;
        let changes = Changes::new(&earlier.description, &description);
        if changes.solids {
            return description.build_with(None, None, files)?.with_relief(&|_| {});
        }
        let (described, of_gltf) = earlier.lights.split_at(earlier.described_lights);
        let solids = Solids {
            objects: Arc::clone(&earlier.smooth_objects),
            materials: Arc::clone(&earlier.materials),
            material_names: Arc::clone(&earlier.material_names),
            gltf_lights: of_gltf.to_vec(),
            // With a camera in the description, the camera of a glTF does not matter.
            gltf_view: earlier.camera.map(|camera| *camera.view()).filter(|_| self.camera.is_none()),
            notes: earlier.solid_notes.clone(),
            files: earlier.solid_files.clone(),
        };
        let lights = (!changes.any_light()).then(|| DescribedLights {
            lights: described.to_vec(),
            air: earlier.air.clone(),
            files: earlier.light_files.clone(),
        });
        let smooth = description.build_with(Some(solids), lights, files)?;
        if changes.view {
            return smooth.with_relief(&|_| {});
        }
        Ok(Scene { objects: Arc::clone(&earlier.objects), notes: earlier.notes.clone(), ..smooth })
    }

    /// Builds the scene of a description around its local origin, without relief.
    fn build_with(
        &self,
        solids: Option<Solids>,
        lights: Option<DescribedLights>,
        files: &dyn FileSource,
    ) -> Result<Scene, SceneError> {
        self.light_field.check(&KeyPath::root("light_field"))?;
        if let Some(camera) = &self.camera {
            camera.check(&KeyPath::root("camera"))?;
        }
        let solids = solids.map_or_else(|| self.solids(files), Ok)?;
        let described = lights.map_or_else(|| self.described_lights(&solids.materials, files), Ok)?;
        let DescribedLights { mut lights, air, files: light_files } = described;
        let described_lights = lights.len();
        lights.extend(solids.gltf_lights);
        if lights.is_empty() {
            return Err(KeyPath::root("light")
                .error("is missing, and there is neither [environment] nor [sky]")
                .into());
        }
        let sensor = self.sensor(&lights)?;
        let Solids { objects, materials, gltf_view, notes, .. } = solids;
        let scene = Scene {
            camera: self.camera(gltf_view)?,
            smooth_objects: Arc::clone(&objects),
            objects,
            solid_notes: notes.clone(),
            materials,
            material_names: solids.material_names,
            lights,
            described_lights,
            air,
            sensor,
            table_file: self.integrator.pcasnow.table.as_ref().map(|name| files.display_name(name)),
            description: self.clone(),
            notes,
            solid_files: solids.files,
            light_files,
        };
        scene.check_camera()?;
        Ok(scene)
    }

    /// The CIE 1931 observer who sees the light of the film's white balance as white.
    fn sensor(&self, lights: &[Arc<Light>]) -> Result<Sensor, KeyError> {
        let white = self.film.white;
        if white == WhiteBalance::default() {
            return Ok(Sensor::cie_1931());
        }
        let wrong = |reason: &str| KeyPath::root("film").key("white").error(format!("is \"{white}\", but {reason}"));
        let spectrum = white.spectrum().map_err(|error| wrong(&error.to_string()))?;
        let spectrum = spectrum.unwrap_or_else(|| irradiance_by_sky(lights));
        if spectrum.maximum() <= 0.0 {
            return Err(wrong("there is no sky, sun or distant lamp above"));
        }
        Sensor::cie_1931().balanced(&spectrum).ok_or_else(|| wrong("the light has a colour outside of sRGB"))
    }

    /// Builds everything except the described lights.
    fn solids(&self, files: &dyn FileSource) -> Result<Solids, SceneError> {
        let files = RecordedFiles::new(files);
        let sources = Sources::new(&files);
        let mut materials = build_materials(&self.materials, &sources)?;
        let grounds = add_grounds(&mut materials, &self.objects)?;
        let mut objects = Vec::new();
        let mut builder = ObjectBuilder::new(&sources, &materials, grounds, self.integrator.kind);
        for (index, object) in self.objects.iter().enumerate() {
            objects.extend(builder.build(&KeyPath::root("object").index(index), object)?);
        }
        let mut notes = builder.notes;
        let gltf = read_gltf(self, &mut materials, &sources)?;
        notes.extend(gltf.notes);
        objects.extend(gltf.objects);
        let objects = Objects::new(objects);
        if self.local_origin != DVec3::ZERO {
            notes.push(format!("the scene is computed around {} m", self.local_origin));
        }
        notes.extend(notes_on_bodies(&objects, &materials, self.integrator.kind));
        if let Some(body) = body_of_two(&objects).filter(|_| !self.integrator.kind.has_curves()) {
            let reason = format!("has a body \"{body}\" of several materials; this integrator takes one");
            return Err(KeyPath::root("object").error(reason).into());
        }
        Ok(Solids {
            objects: Arc::new(objects),
            material_names: Arc::new(materials.iter().map(|named| named.name.clone()).collect()),
            materials: Arc::new(materials.into_iter().map(|named| named.material).collect()),
            gltf_lights: gltf.lights.into_iter().map(Arc::new).collect(),
            gltf_view: gltf.view,
            notes,
            files: files.hashes(),
        })
    }

    /// Builds the lights of the description for built materials, with hashes of the files that were read for the
    /// lights.
    fn described_lights(&self, materials: &[Material], files: &dyn FileSource) -> Result<DescribedLights, SceneError> {
        let files = RecordedFiles::new(files);
        let sources = Sources::new(&files);
        let mut lights = Vec::with_capacity(self.lights.len() + 1);
        for (index, light) in self.lights.iter().enumerate() {
            lights.push(light.build(&KeyPath::root("light").index(index), &sources)?);
        }
        if let Some(environment) = &self.environment {
            lights.push(environment.build(&KeyPath::root("environment"), &sources)?);
        }
        let sky = match &self.sky {
            Some(sky) => sky.build(self.first_snow(materials), &sources)?,
            None => BuiltSky::default(),
        };
        lights.extend(sky.lights);
        Ok(DescribedLights {
            lights: lights.into_iter().map(Arc::new).collect(),
            air: sky.air.map(Arc::new),
            files: files.hashes(),
        })
    }

    /// The first snow that an object is made of.
    fn first_snow<'materials>(&self, materials: &'materials [Material]) -> Option<&'materials SnowSample> {
        self.objects.iter().find_map(|object| {
            let mut named = self.materials.keys().zip(materials);
            let (_, material) = named.find(|(name, _)| **name == object.common.material)?;
            material.snow()?.samples().first()
        })
    }

    /// Builds the lights of the description for a built scene.
    pub fn lights_over(&self, scene: &Scene, files: &dyn FileSource) -> Result<Vec<Arc<Light>>, SceneError> {
        Ok(self.around(scene.local_origin())?.described_lights(&scene.materials, files)?.lights)
    }

    /// The camera of the description, or else of the glTF.
    fn camera(&self, view_of_gltf: Option<View>) -> Result<Option<PerspectiveCamera>, KeyError> {
        let lens = self.camera.as_ref().map(CameraDescription::lens).unwrap_or_default();
        let Some(view) = self.camera.as_ref().map(CameraDescription::view).or(view_of_gltf) else { return Ok(None) };
        let camera = PerspectiveCamera::new(&view, lens, self.film.aspect());
        let reason = "must not lie at the camera's position or along its up axis";
        camera.map(Some).ok_or_else(|| self.camera_path().key("look_at").error(reason))
    }

    /// The path of the camera in the description.
    fn camera_path(&self) -> KeyPath {
        if self.camera.is_some() { KeyPath::root("camera") } else { KeyPath::root("gltf").key("camera") }
    }
}

impl Scene {
    /// The scene with the relief of its snow as the camera sees it, added to a scene
    /// [without relief](SceneDescription::build_smooth). It reports [`Phase::Relief`].
    ///
    /// # Errors
    ///
    /// When snow has relief, and there is no camera or it lies inside the snow with its relief.
    pub fn with_relief(mut self, report: Report) -> Result<Self, SceneError> {
        if self.description.materials.values().any(MaterialDescription::has_relief) {
            report(Progress { phase: Phase::Relief, done: 0, total: 0 });
        }
        let camera = (self.camera.as_ref(), &self.description.film);
        if let Some((objects, note)) = with_relief(&self.smooth_objects, &self.materials, camera)? {
            self.objects = Arc::new(objects);
            self.notes.extend(note);
            self.check_camera()?;
        }
        Ok(self)
    }

    /// Checks that the camera lies outside of snow.
    fn check_camera(&self) -> Result<(), KeyError> {
        let Some(camera) = &self.camera else { return Ok(()) };
        let is_snow = |object: &Object| self.materials[object.material].looks_like_snow();
        let in_snow = |point| self.objects.around(point, is_snow);
        let name = |index: usize| &self.objects.list()[index].name;
        let path = self.description.camera_path();
        if let Some(index) = in_snow(camera.view().position) {
            return Err(path.key("position").error(format!("lies inside the snow of \"{}\"", name(index))));
        }
        if let Some(index) = camera.lens_points().find_map(in_snow) {
            return Err(path.key("aperture").error(format!("reaches into the snow of \"{}\"", name(index))));
        }
        Ok(())
    }
}

/// Adds materials for planes of snow, and returns the indices of these materials by the indices of the snow. For
/// layers the plane has the uppermost layer, for a mask the snow where the mask is 0.
fn add_grounds(
    materials: &mut Vec<NamedMaterial>,
    objects: &[ObjectDescription],
) -> Result<BTreeMap<usize, usize>, KeyError> {
    let mut grounds = BTreeMap::new();
    for (number, object) in objects.iter().enumerate() {
        let index = materials.iter().position(|material| material.name == object.common.material);
        let Some(index) = index.filter(|_| object.is_plane()) else { continue };
        let Some(snow) = materials[index].material.snow().filter(|_| !grounds.contains_key(&index)) else { continue };
        let ground = DeepSnow::new(&snow.samples()[0]).map_err(|error| {
            let reason = format!("cannot be the snow of a plane: {error}");
            KeyPath::root("object").index(number).key("material").error(reason)
        })?;
        grounds.insert(index, materials.len());
        let name = materials[index].name.clone();
        materials.push(NamedMaterial { name, material: Material::Ground(Box::new(ground)) });
    }
    Ok(grounds)
}
