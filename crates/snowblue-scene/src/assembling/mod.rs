//! From a description to a scene: reads the files that it names, and checks that all of it fits together.

mod carved;
pub(crate) mod changes;
mod closed;
mod gltf_lights;
mod gltf_material;
mod gltf_scene;
mod ground;
mod joints;
mod landscape;
mod light;
mod material;
mod object;
mod placing;
mod recorded_files;
mod relief;
mod sky;
mod snow;
mod sources;
mod texture;

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::Scene;
use crate::air::Air;
use crate::camera::{PerspectiveCamera, View};
use crate::description::SceneDescription;
use crate::error::SceneError;
use crate::film::sensor::Sensor;
use crate::film::white_balance::WhiteBalance;
use crate::integrator::IntegratorKind;
use crate::light::{Light, irradiance_by_sky};
use crate::material::Material;
use crate::objects::{Object, Objects};
use crate::spectrum::light_spectrum::LightSpectrum;
use snowblue_base::{KeyError, KeyPath, short_number};
use snowblue_geometry::bounds::Bounds;
use snowblue_geometry::shape::Shape;

use changes::Changes;
use gltf_scene::{GltfScene, read_gltf};
use ground::add_grounds;
use joints::joints;
use material::{NamedMaterial, build_materials};
use object::ObjectBuilder;
use recorded_files::RecordedFiles;
use relief::with_relief;
use sky::build_sky;
use snowblue_base::files::FileSource;
use sources::Sources;

/// What there is in a scene without its described lights.
struct Solids {
    objects: Arc<Objects>,
    /// The objects with relief as the camera sees it, and all notes, if they are known.
    rough: Option<(Arc<Objects>, Vec<String>)>,
    materials: Arc<Vec<Material>>,
    gltf_lights: Vec<Arc<Light>>,
    gltf_view: Option<View>,
    /// What was changed in meshes, in sentences.
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
        self.check()?;
        self.build_checked(files)
    }

    /// Builds the scene of a description that was checked.
    pub(crate) fn build_checked(&self, files: &dyn FileSource) -> Result<Scene, SceneError> {
        self.build_with(None, None, files)
    }

    /// Builds the scene like [`build`](Self::build), and shares what is the same with an earlier one, whose files were
    /// the same. Its pictures are identical to the last bit.
    ///
    /// # Errors
    ///
    /// As those of [`build`](Self::build).
    pub fn build_after(&self, earlier: &Scene, files: &dyn FileSource) -> Result<Scene, SceneError> {
        let changes = Changes::new(&earlier.description, self);
        self.check()?;
        if changes.solids {
            return self.build_checked(files);
        }
        let (described, of_gltf) = earlier.lights.split_at(earlier.described_lights);
        let solids = Solids {
            objects: Arc::clone(&earlier.smooth_objects),
            rough: (!changes.view).then(|| (Arc::clone(&earlier.objects), earlier.notes.clone())),
            materials: Arc::clone(&earlier.materials),
            gltf_lights: of_gltf.to_vec(),
            // With a camera in the description, that of a glTF does not matter.
            gltf_view: Some(earlier.view).filter(|_| self.camera.is_none()),
            notes: earlier.solid_notes.clone(),
            files: earlier.solid_files.clone(),
        };
        let lights = (!changes.any_light()).then(|| DescribedLights {
            lights: described.to_vec(),
            air: earlier.air.clone(),
            files: earlier.light_files.clone(),
        });
        self.build_with(Some(solids), lights, files)
    }

    fn build_with(
        &self,
        solids: Option<Solids>,
        lights: Option<DescribedLights>,
        files: &dyn FileSource,
    ) -> Result<Scene, SceneError> {
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
        let Solids { objects: smooth_objects, rough, materials, gltf_view, notes: solid_notes, .. } = solids;
        let (view, path) = self.view(gltf_view)?;
        let lens = self.camera.as_ref().map(|camera| camera.lens()).unwrap_or_default();
        let camera = PerspectiveCamera::new(&view, lens, self.film.width as f32 / self.film.height as f32);
        let camera = camera
            .ok_or_else(|| path.key("look_at").error("must not lie at the camera's position or along its up axis"))?;
        let check = |objects: &Objects| {
            let is_snow = |object: &Object| materials[object.material].is_snow();
            // A plane is no solid, but snow fills what is behind one of snow.
            let is_behind = |object: &Object, point| match (&object.shape, &materials[object.material]) {
                (Shape::Plane(plane), Material::Ground(_)) => plane.is_behind(point),
                _ => false,
            };
            let behind = |point| objects.list().iter().position(|object| is_behind(object, point));
            let in_snow = |point| behind(point).or_else(|| objects.around(point, is_snow));
            let name = |index: usize| &objects.list()[index].name;
            if let Some(index) = in_snow(view.position) {
                let reason = format!("lies inside the snow of \"{}\"", name(index));
                return Err(path.key("position").error(reason));
            }
            if let Some(index) = camera.lens_points().find_map(in_snow) {
                let reason = format!("reaches into the snow of \"{}\"", name(index));
                return Err(path.key("aperture").error(reason));
            }
            Ok(())
        };
        check(&smooth_objects)?;
        let (objects, notes) = if let Some(same) = rough {
            same
        } else if let Some((rough, note)) = with_relief(&smooth_objects, &materials, (&camera, &view, &self.film)) {
            check(&rough)?;
            (Arc::new(rough), solid_notes.iter().cloned().chain(note).collect())
        } else {
            (Arc::clone(&smooth_objects), solid_notes.clone())
        };
        Ok(Scene {
            camera,
            view,
            objects,
            smooth_objects,
            solid_notes,
            materials,
            lights,
            described_lights,
            air,
            film: self.film,
            integrator: self.integrator.clone(),
            sensor,
            table_file: self.integrator.pcasnow.table.as_ref().map(|name| files.display_name(name)),
            description: self.clone(),
            notes,
            solid_files: solids.files,
            light_files,
        })
    }

    /// The CIE 1931 observer who sees the light of the film's white balance as white.
    fn sensor(&self, lights: &[Arc<Light>]) -> Result<Sensor, KeyError> {
        let white = self.film.white;
        if white == WhiteBalance::default() {
            return Ok(Sensor::cie_1931());
        }
        let wrong = |reason: &str| KeyPath::root("film").key("white").error(format!("is \"{white}\", but {reason}"));
        let spectrum = match white {
            WhiteBalance::Illuminant(illuminant) => {
                LightSpectrum::illuminant(illuminant).map_err(|error| wrong(&error.to_string()))?.relative
            }
            WhiteBalance::Temperature(kelvin) => {
                LightSpectrum::of_temperature(kelvin).map_err(|error| wrong(&error.to_string()))?.relative
            }
            WhiteBalance::Sky => irradiance_by_sky(lights),
        };
        if spectrum.maximum() <= 0.0 {
            return Err(wrong("there is no sky, sun or distant lamp above"));
        }
        Sensor::cie_1931().balanced(&spectrum).ok_or_else(|| wrong("the light has a colour outside of sRGB"))
    }

    /// Builds all that is no described light.
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
        let gltf = match &self.gltf {
            None => GltfScene::default(),
            Some(name) => read_gltf(&KeyPath::root("gltf"), name, &mut materials, &sources, self.integrator.kind)?,
        };
        notes.extend(gltf.notes);
        objects.extend(gltf.objects);
        let objects = Objects::new(objects);
        notes.extend(notes_on_bodies(&objects, &materials, self.integrator.kind));
        if let Some(body) = body_of_two(&objects).filter(|_| self.integrator.kind != IntegratorKind::PcaSnow) {
            let reason = format!("has a body \"{body}\" of several materials; this integrator takes one");
            return Err(KeyPath::root("object").error(reason).into());
        }
        Ok(Solids {
            objects: Arc::new(objects),
            rough: None,
            materials: Arc::new(materials.into_iter().map(|named| named.material).collect()),
            gltf_lights: gltf.lights.into_iter().map(Arc::new).collect(),
            gltf_view: gltf.view,
            notes,
            files: files.hashes(),
        })
    }

    /// Builds the lights of the description for materials that were built, with hashes of the files that were read for
    /// them.
    fn described_lights(&self, materials: &[Material], files: &dyn FileSource) -> Result<DescribedLights, SceneError> {
        let files = RecordedFiles::new(files);
        let sources = Sources::new(&files);
        let mut lights = Vec::with_capacity(self.lights.len() + 1);
        for (index, light) in self.lights.iter().enumerate() {
            lights.push(light::build_light(&KeyPath::root("light").index(index), light, &sources)?);
        }
        if let Some(environment) = &self.environment {
            lights.push(light::build_environment(&KeyPath::root("environment"), environment, &sources)?);
        }
        let sky = build_sky(self, materials, &sources)?;
        lights.extend(sky.lights);
        Ok(DescribedLights {
            lights: lights.into_iter().map(Arc::new).collect(),
            air: sky.air.map(Arc::new),
            files: files.hashes(),
        })
    }

    /// Builds the lights of a description for materials that were built.
    pub fn lights_over(&self, materials: &[Material], files: &dyn FileSource) -> Result<Vec<Arc<Light>>, SceneError> {
        self.check()?;
        Ok(self.described_lights(materials, files)?.lights)
    }

    /// The view of the camera, or that of the glTF, and its path in the description.
    fn view(&self, of_gltf: Option<View>) -> Result<(View, KeyPath), SceneError> {
        if let Some(camera) = &self.camera {
            return Ok((camera.view(), KeyPath::root("camera")));
        }
        let reason = "is missing, and there is no glTF with a perspective camera";
        let view = of_gltf.ok_or_else(|| KeyPath::root("camera").error(reason))?;
        Ok((view, KeyPath::root("gltf").key("camera")))
    }
}

/// Most bodies that notes name one by one.
const MOST_NAMED: usize = 3;
/// Coordinate from which on random walks lose more than 1 % of the light: rays start off the surface by a multiple of
/// the rounding of coordinates. A ball lost 0.5 % below, 2.5 % above, and 6 % above 512 m.
const FAR_M: f32 = 256.0;

/// Notes on bodies of snow that have a side below the size of their finest grains, that are so far from the origin that
/// random walks lose light, or that meet.
fn notes_on_bodies(objects: &Objects, materials: &[NamedMaterial], integrator: IntegratorKind) -> Vec<String> {
    let has_walks = matches!(integrator, IntegratorKind::Hybrid | IntegratorKind::Reference);
    let name = |object: usize| {
        let Object { name, body, .. } = &objects.list()[object];
        body.as_ref().unwrap_or(name)
    };
    let (mut small, mut far) = (Vec::new(), Vec::new());
    for (index, object) in objects.list().iter().enumerate() {
        let members = objects.body_of(index);
        let snow = materials[object.material].material.snow().filter(|_| members.first() == Some(&index));
        let bounds: Option<Vec<Bounds>> = members.iter().map(|member| objects.list()[*member].shape.bounds()).collect();
        let (Some(snow), Some(bounds)) = (snow, bounds) else { continue };
        let bounds = Bounds::of(bounds.iter().flat_map(|bounds| [bounds.low.into(), bounds.high.into()]));
        let name = name(index);
        let away_m = bounds.low.max(-bounds.high).max_element();
        if has_walks && away_m > FAR_M {
            far.push(format!(
                "\"{name}\" is {} m from the origin, where coordinates are so coarse that random walks lose some per \
                 cent of the light: move the scene to the origin",
                short_number(f64::from(away_m.round()))
            ));
        }
        let size_mm = 1e3 * (bounds.high - bounds.low).as_dvec3();
        let rounding_mm = 2e3 * f64::from(bounds.low.abs().max(bounds.high.abs()).max_element() * f32::EPSILON);
        let grains_mm = snow.samples().iter().map(|sample| 1e-3 * sample.grain_size.middle_um());
        let grain_mm = grains_mm.fold(f64::INFINITY, f64::min);
        let [x, y, z] = size_mm.to_array().map(|side_mm| short_number((side_mm * 1e4).round() / 1e4));
        if size_mm.min_element() + rounding_mm < grain_mm {
            small.push(format!(
                "\"{name}\" is {x} × {y} × {z} mm, smaller than a grain of its snow, which is {} mm: light is computed \
                 as in many grains",
                short_number(grain_mm)
            ));
        }
    }
    let is_snow = |object: usize| materials[objects.list()[object].material].material.is_snow();
    let of_pair = |[one, other]: [usize; 2]| {
        let is_same = objects.list()[one].material == objects.list()[other].material;
        let remedy = if is_same { "give both the same `body`" } else { "make them `layers` of one snow" };
        format!(
            "\"{}\" and \"{}\" are bodies of snow that meet, but light does not spread from one into the other: \
             {remedy}",
            name(one),
            name(other)
        )
    };
    // Walks of the reference pass from one body into the other. Pages show no notes.
    let has_joints = integrator != IntegratorKind::Reference && !cfg!(target_family = "wasm");
    let pairs = if has_joints { joints(objects, is_snow) } else { Vec::new() };
    let mut meeting: Vec<String> = pairs.into_iter().map(of_pair).collect();
    name_first(&mut small, "bodies are smaller than a grain of their snow");
    name_first(&mut far, "bodies are far from the origin");
    name_first(&mut meeting, "pairs of bodies meet");
    [small, far, meeting].concat()
}

/// Keeps the first of the notes on bodies, and says how many more there are.
fn name_first(notes: &mut Vec<String>, others: &str) {
    if notes.len() > MOST_NAMED {
        let more = notes.len() - MOST_NAMED;
        notes.truncate(MOST_NAMED);
        notes.push(format!("{more} more {others}"));
    }
}

/// A body whose objects differ in material.
fn body_of_two(objects: &Objects) -> Option<&str> {
    let mut materials = BTreeMap::new();
    let named = objects.list().iter().filter_map(|object| Some((object.body.as_deref()?, object.material)));
    named
        .filter(|(body, material)| materials.entry(*body).or_insert(*material) != material)
        .map(|(body, _)| body)
        .next()
}
