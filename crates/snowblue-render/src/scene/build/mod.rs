//! From a description to a scene: reads the files that it names, takes the curves of its snow from a table, and checks
//! that all of it fits together.

mod carved;
mod changes;
mod closed;
mod gltf_scene;
mod landscape;
mod light;
mod material;
mod object;
mod placing;
mod recorded_files;
mod sky;
mod snow;
mod sources;
mod texture;

use std::collections::BTreeMap;
use std::sync::Arc;

use snowblue_database::CompressedTable;
use snowblue_transport::SnowSample;
use snowblue_transport::monte_carlo::{Volume, WalkEnds};

use crate::error::RenderError;
use crate::files::SceneFiles;
use crate::film::exposure::FilmSettings;
use crate::film::sensor::Sensor;
use crate::film::white_balance::WhiteBalance;
use crate::scene::Scene;
use crate::scene::camera::{PinholeCamera, View};
use crate::scene::description::{DescriptionError, KeyPath, SceneDescription};
use crate::scene::integrator::IntegratorKind;
use crate::scene::layering::Layering;
use crate::scene::light::{Light, irradiance_by_sky};
use crate::scene::light_field::{EndDepth, FieldScene, LampInSnow, LightField, SnowLayer, Snowpack, Viewer};
use crate::scene::material::Material;
use crate::scene::objects::{Object, Objects, SurfaceInteraction};
use crate::spectrum::SAMPLES;
use crate::spectrum::light_spectrum::LightSpectrum;

use changes::Changes;
use gltf_scene::{GltfScene, read_gltf};
use material::{build_materials, build_volumes, snow_samples};
use object::ObjectBuilder;
use recorded_files::RecordedFiles;
use snow::build_optics;
use sources::Sources;

/// What there is in a scene without its described lights.
struct Solids {
    objects: Objects,
    materials: Vec<Material>,
    volumes: Vec<Vec<Volume>>,
    gltf_lights: Vec<Light>,
    gltf_view: Option<View>,
    /// Hashes of the files that were read, by name.
    files: BTreeMap<String, u64>,
}

/// The parts of an earlier scene that hold for another description.
#[derive(Default)]
struct Kept {
    solids: Option<Solids>,
    /// The described lights, and hashes of the files that were read for them.
    lights: Option<(Vec<Light>, BTreeMap<String, u64>)>,
    light_field: KeptField,
}

/// What is kept of a light field.
#[derive(Default)]
enum KeptField {
    #[default]
    Nothing,
    /// Grids, and the solutions of all lights that are the same.
    Grids(LightField, Changes),
    Everything(LightField),
}

impl SceneDescription {
    /// Builds the scene; snow takes its curves from `table`, and files come from `files`.
    ///
    /// # Errors
    ///
    /// When a value is out of range, a file is missing or malformed, or the table has no such snow. The error names the
    /// path of the value in the description, or the file.
    pub fn build(&self, table: &CompressedTable, files: &dyn SceneFiles) -> Result<Scene, RenderError> {
        self.build_with(Kept::default(), table, files)
    }

    /// Builds the scene like [`build`](Self::build), and keeps what it has in common with an earlier one, whose table
    /// and files were the same. Its pictures are identical to the last bit.
    ///
    /// Objects and their light fields are kept while they, the materials and the lights are the same. Where lights
    /// differ, the grids of light fields are kept, and the light of lamps that are the same.
    ///
    /// # Errors
    ///
    /// As those of [`build`](Self::build).
    pub fn build_after(
        &self,
        earlier: Scene,
        table: &CompressedTable,
        files: &dyn SceneFiles,
    ) -> Result<Scene, RenderError> {
        self.build_with(Kept::of(earlier, self), table, files)
    }

    fn build_with(&self, kept: Kept, table: &CompressedTable, files: &dyn SceneFiles) -> Result<Scene, RenderError> {
        self.check()?;
        let sensor = match self.film.false_color {
            None => Sensor::cie_1931(),
            Some(colour) => Sensor::false_color(colour, &table.axes.wavelengths_nm)?,
        };
        let mut solids = match kept.solids {
            Some(solids) => solids,
            None => self.solids(table, files)?,
        };
        let (mut lights, light_files) = match kept.lights {
            Some(lights) => lights,
            None => self.described_lights(&solids.materials, table, files)?,
        };
        let described_lights = lights.len();
        lights.append(&mut solids.gltf_lights);
        if lights.is_empty() {
            return Err(KeyPath::default().error("has no light: neither [[light]] nor [environment] nor [sky]").into());
        }
        let mut solved_light_fields = 0;
        let sensor = self.balanced(sensor, &lights)?;
        let light_field = match (self.integrator.kind.has_light_field(), kept.light_field) {
            (false, _) => None,
            (true, KeptField::Everything(field)) => Some(field),
            (true, kept) => {
                let sources = Sources::new(table, files, self.film.false_color.is_some());
                let (view, _) = self.view(solids.gltf_view)?;
                let field = self.light_field(&solids, (&lights, &view), kept, &sources)?;
                solved_light_fields = field.solved_count();
                Some(field)
            }
        };
        let Solids { objects, materials, volumes, gltf_view, files: solid_files, .. } = solids;
        let (view, path) = self.view(gltf_view)?;
        if let Some(index) = objects.around(view.position, |object| materials[object.material].is_snow()) {
            let name = &objects.list()[index].name;
            return Err(path.key("position").error(format!("lies inside the snow of \"{name}\"")).into());
        }
        let camera = PinholeCamera::new(&view, self.film.width as f32 / self.film.height as f32);
        let camera = camera
            .ok_or_else(|| path.key("look_at").error("must not lie at the camera's position or along its up axis"))?;
        Ok(Scene {
            camera,
            view,
            objects,
            materials,
            lights,
            described_lights,
            film: self.film,
            integrator: self.integrator,
            sensor,
            volumes,
            light_field,
            solved_light_fields,
            description: self.clone(),
            solid_files,
            light_files,
        })
    }

    /// A sensor that sees the light of the film's white balance as white.
    fn balanced(&self, sensor: Sensor, lights: &[Light]) -> Result<Sensor, DescriptionError> {
        let FilmSettings { white, false_color, .. } = self.film;
        if false_color.is_some() || white == WhiteBalance::default() {
            return Ok(sensor);
        }
        let wrong = |reason: &str| KeyPath::root("film").key("white").error(format!("is \"{white}\", but {reason}"));
        let spectrum = match white {
            WhiteBalance::Illuminant(illuminant) => {
                LightSpectrum::illuminant(illuminant).map_err(|error| wrong(&error.to_string()))?.relative
            }
            WhiteBalance::Sky => irradiance_by_sky(lights),
        };
        if spectrum.maximum() <= 0.0 {
            return Err(wrong("there is no sky, sun or distant lamp above"));
        }
        sensor.balanced(&spectrum).ok_or_else(|| wrong("the light has a colour outside of sRGB"))
    }

    /// Builds all that is no described light.
    fn solids(&self, table: &CompressedTable, files: &dyn SceneFiles) -> Result<Solids, RenderError> {
        let files = RecordedFiles::new(files);
        let sources = Sources::new(table, &files, self.film.false_color.is_some());
        let mut materials = build_materials(&self.materials, &sources, self.integrator.kind)?;
        let mut objects = Vec::new();
        let mut builder = ObjectBuilder::new(&sources, &materials, self.integrator.kind);
        for (index, object) in self.objects.iter().enumerate() {
            objects.extend(builder.build(&KeyPath::root("object").index(index), object)?);
        }
        let gltf = match &self.gltf {
            None => GltfScene::default(),
            Some(name) => read_gltf(&KeyPath::root("gltf"), name, &mut materials, &sources, self.integrator.kind)?,
        };
        objects.extend(gltf.objects);
        let objects = Objects::new(objects);
        if let Some(body) = body_of_two(&objects).filter(|_| self.integrator.kind != IntegratorKind::PcaSnow) {
            let reason = format!("has a body \"{body}\" of several materials; this integrator takes one");
            return Err(KeyPath::root("object").error(reason).into());
        }
        let materials: Vec<Material> = materials.into_iter().map(|named| named.material).collect();
        let snow = snow_samples(&self.materials, &materials, &sources, self.integrator.kind)?;
        let volumes = build_volumes(&snow, self.materials.keys(), &sources, self.integrator.kind)?;
        Ok(Solids {
            objects,
            materials,
            volumes,
            gltf_lights: gltf.lights,
            gltf_view: gltf.view,
            files: files.hashes(),
        })
    }

    /// Builds the lights of the description, with hashes of the files that were read for them.
    fn described_lights(
        &self,
        materials: &[Material],
        table: &CompressedTable,
        files: &dyn SceneFiles,
    ) -> Result<(Vec<Light>, BTreeMap<String, u64>), RenderError> {
        let files = RecordedFiles::new(files);
        let sources = Sources::new(table, &files, self.film.false_color.is_some());
        let mut lights = Vec::with_capacity(self.lights.len() + 1);
        for (index, light) in self.lights.iter().enumerate() {
            lights.push(light::build_light(&KeyPath::root("light").index(index), light, &sources)?);
        }
        if let Some(environment) = &self.environment {
            lights.push(light::build_environment(&KeyPath::root("environment"), environment, &sources)?);
        }
        lights.extend(sky::build_sky(self, materials, &sources)?);
        Ok((lights, files.hashes()))
    }

    /// Builds the lights of a description for materials that were built.
    pub(crate) fn lights_over(
        &self,
        materials: &[Material],
        table: &CompressedTable,
        files: &dyn SceneFiles,
    ) -> Result<Vec<Light>, RenderError> {
        self.check()?;
        Ok(self.described_lights(materials, table, files)?.0)
    }

    /// Solves for the light in all snow.
    fn light_field(
        &self,
        solids: &Solids,
        (lights, view): (&[Light], &View),
        kept: KeptField,
        sources: &Sources,
    ) -> Result<LightField, RenderError> {
        let Solids { objects, materials, volumes, .. } = solids;
        let snowpacks = if matches!(kept, KeptField::Grids(..)) {
            Vec::new()
        } else {
            let snow = snow_samples(&self.materials, materials, sources, self.integrator.kind)?;
            let rays = self.light_field.grain_rays;
            snowpacks(&snow, (self.materials.keys(), materials), volumes, (sources, rays))?
        };
        let mut lamps_in_snow = Vec::new();
        for (index, light) in lights.iter().enumerate() {
            let position = light.central_sample().and_then(|sample| sample.origin.position());
            let is_snow = |object: &Object| materials[object.material].is_snow();
            let Some(object) = position.and_then(|position| objects.around(position, is_snow)) else { continue };
            let lamp = light.inner_lamp().ok_or_else(|| {
                let name = &objects.list()[object].name;
                let reason = format!("lies inside the snow of \"{name}\"; there, lights are points or spheres");
                KeyPath::root("light").index(index).error(reason)
            })?;
            lamps_in_snow.push(LampInSnow { light: index, object, lamp });
        }
        let reflectance = |surface: &SurfaceInteraction| match &materials[surface.material] {
            Material::Diffuse(diffuse) => Some(diffuse.reflectance(objects, surface)),
            Material::PcaSnow(_) | Material::LayeredSnow(_) => None,
        };
        let scene = FieldScene {
            objects,
            lights,
            // The materials of a glTF follow those of the description, and are no snow.
            snow: &|object| snowpacks.get(objects.list()[object].material)?.clone(),
            lamps_in_snow: &lamps_in_snow,
            reflectance: &reflectance,
            max_bounces: self.integrator.max_bounces,
            viewer: Some(Viewer {
                position: view.position,
                pixel_rad: f64::from(view.vertical_fov_deg.to_radians()) / f64::from(self.film.height),
            }),
            settings: self.light_field,
        };
        if let KeptField::Grids(field, changes) = kept {
            return Ok(field.relit_where_changed(&scene, &|light| changes.has_light(light)));
        }
        LightField::new(&scene).map_err(|(object, reason)| {
            KeyPath::root("object").error(format!("\"{}\" {reason}", objects.list()[object].name)).into()
        })
    }

    /// The view of the camera, or that of the glTF, and its path in the description.
    fn view(&self, of_gltf: Option<View>) -> Result<(View, KeyPath), RenderError> {
        if let Some(camera) = &self.camera {
            return Ok((camera.view(), KeyPath::root("camera")));
        }
        let reason = "is missing, and there is no glTF with a perspective camera";
        let view = of_gltf.ok_or_else(|| KeyPath::root("camera").error(reason))?;
        Ok((view, KeyPath::root("gltf").key("camera")))
    }
}

/// The snow of each material for the light field, in the same order, by its samples. `rays` are those through grains.
fn snowpacks<'a>(
    snow: &[Vec<SnowSample>],
    (names, materials): (impl Iterator<Item = &'a String>, &[Material]),
    volumes: &[Vec<Volume>],
    (sources, rays): (&Sources, u32),
) -> Result<Vec<Option<Arc<Snowpack>>>, RenderError> {
    let mut snowpacks = Vec::with_capacity(snow.len());
    for (number, ((samples, name), material)) in snow.iter().zip(names).zip(materials).enumerate() {
        let path = KeyPath::root("material").key(name);
        let mut layers = Vec::with_capacity(samples.len());
        for (layer, sample) in samples.iter().enumerate() {
            let optics = build_optics(&path, sample, sources, rays)?;
            let length_m = optics.transport_lengths_m[SAMPLES / 2];
            let node = volumes.get(number).and_then(|volumes| volumes[layer].nodes().first());
            let walk_ends = |node| EndDepth::ALL.map(|depth| WalkEnds::new(node, length_m, depth.lengths().into()));
            layers.push(SnowLayer::new(optics, node.map(walk_ends)));
        }
        let layering = match material {
            Material::LayeredSnow(snow) => snow.layering.clone(),
            Material::PcaSnow(_) | Material::Diffuse(_) => Layering::uniform(),
        };
        snowpacks.push((!layers.is_empty()).then(|| Arc::new(Snowpack::new(layers, layering))));
    }
    Ok(snowpacks)
}

impl Kept {
    /// What holds for a description of an earlier scene.
    fn of(earlier: Scene, description: &SceneDescription) -> Self {
        let changes = Changes::new(&earlier.description, description);
        if changes.solids {
            return Self::default();
        }
        let Scene { objects, materials, volumes, mut lights, described_lights, view, light_field, .. } = earlier;
        let gltf_lights = lights.split_off(described_lights);
        // With a camera in the description, that of a glTF does not matter.
        let gltf_view = Some(view).filter(|_| description.camera.is_none());
        let solids = Solids { objects, materials, volumes, gltf_lights, gltf_view, files: earlier.solid_files };
        let light_field = match light_field {
            Some(field) if field.view_factor().is_some() && changes.view => KeptField::Nothing,
            Some(field) if !changes.field() => KeptField::Everything(field),
            Some(field) if !changes.grids => KeptField::Grids(field, changes.clone()),
            _ => KeptField::Nothing,
        };
        let lights = (!changes.any_light()).then_some((lights, earlier.light_files));
        Self { solids: Some(solids), lights, light_field }
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
