//! From a description to a scene: reads the files that it names, takes the curves of its snow from a table, and checks
//! that all of it fits together.

mod closed;
mod gltf_scene;
mod light;
mod material;
mod object;
mod placing;
mod recorded_files;
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
use crate::film::sensor::Sensor;
use crate::scene::Scene;
use crate::scene::camera::{PinholeCamera, View};
use crate::scene::description::{KeyPath, SceneDescription};
use crate::scene::integrator::IntegratorKind;
use crate::scene::layering::Layering;
use crate::scene::light::Light;
use crate::scene::light_field::{EndDepth, FieldScene, InnerLamp, LampInSnow, LightField, SnowLayer, Snowpack};
use crate::scene::material::Material;
use crate::scene::objects::{Object, Objects, SurfaceInteraction};
use crate::spectrum::SAMPLES;

use gltf_scene::{GltfScene, read_gltf};
use material::{NamedMaterial, build_materials, build_volumes, snow_samples};
use object::ObjectBuilder;
use recorded_files::RecordedFiles;
use snow::build_optics;
use sources::Sources;

impl SceneDescription {
    /// Builds the scene; snow takes its curves from `table`, and files come from `files`.
    ///
    /// # Errors
    ///
    /// When a value is out of range, a file is missing or malformed, or the table has no such snow. The error names the
    /// path of the value in the description, or the file.
    pub fn build(&self, table: &CompressedTable, files: &dyn SceneFiles) -> Result<Scene, RenderError> {
        self.check()?;
        let sensor = match self.film.false_color {
            None => Sensor::cie_1931(),
            Some(colour) => Sensor::false_color(colour, &table.axes.wavelengths_nm)?,
        };
        let files = RecordedFiles::new(files);
        let sources = Sources::new(table, &files, self.film.false_color.is_some());
        let mut materials = build_materials(&self.materials, &sources, self.integrator.kind)?;
        let snow = snow_samples(&self.materials, &materials, &sources, self.integrator.kind)?;
        let volumes = build_volumes(&snow, &materials, &sources, self.integrator.kind)?;
        let mut lights = Vec::with_capacity(self.lights.len() + 1);
        for (index, light) in self.lights.iter().enumerate() {
            lights.push(light::build_light(&KeyPath::root("light").index(index), light, &sources)?);
        }
        if let Some(environment) = &self.environment {
            lights.push(light::build_environment(&KeyPath::root("environment"), environment, &sources)?);
        }
        let mut objects = Vec::new();
        let mut builder = ObjectBuilder::new(&sources, &materials, self.integrator.kind);
        for (index, object) in self.objects.iter().enumerate() {
            objects.extend(builder.build(&KeyPath::root("object").index(index), object)?);
        }
        let gltf = match &self.gltf {
            None => GltfScene::default(),
            Some(name) => read_gltf(&KeyPath::root("gltf"), name, &mut materials, &sources, self.integrator.kind)?,
        };
        lights.extend(gltf.lights);
        if lights.is_empty() {
            return Err(KeyPath::default().error("has no light: neither [[light]] nor [environment]").into());
        }
        objects.extend(gltf.objects);
        let objects = Objects::new(objects);
        if let Some(body) = body_of_two(&objects).filter(|_| self.integrator.kind != IntegratorKind::PcaSnow) {
            let reason = format!("has a body \"{body}\" of several materials; this integrator takes one");
            return Err(KeyPath::root("object").error(reason).into());
        }
        let light_field = match self.integrator.kind {
            IntegratorKind::PcaSnow | IntegratorKind::Reference => None,
            IntegratorKind::Diffusion | IntegratorKind::Hybrid => {
                let snowpacks = snowpacks(&snow, &materials, &volumes, (&sources, self.light_field.grain_rays))?;
                Some(self.light_field(&objects, &lights, &materials, &snowpacks)?)
            }
        };
        let (view, path) = self.view(gltf.view)?;
        if let Some(index) = objects.around(view.position, |object| materials[object.material].material.is_snow()) {
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
            materials: materials.into_iter().map(|named| named.material).collect(),
            lights,
            film: self.film,
            integrator: self.integrator,
            sensor,
            volumes,
            light_field,
            description: self.clone(),
            file_hashes: files.hashes(),
        })
    }

    /// Solves for the light in all snow.
    fn light_field(
        &self,
        objects: &Objects,
        lights: &[Light],
        materials: &[NamedMaterial],
        snowpacks: &[Option<Arc<Snowpack>>],
    ) -> Result<LightField, RenderError> {
        let mut lamps_in_snow = Vec::new();
        for (index, light) in lights.iter().enumerate() {
            let position = light.central_sample().and_then(|sample| sample.origin.position());
            let is_snow = |object: &Object| materials[object.material].material.is_snow();
            let Some(object) = position.and_then(|position| objects.around(position, is_snow)) else { continue };
            let lamp = InnerLamp::new(light).ok_or_else(|| {
                let name = &objects.list()[object].name;
                let reason = format!("lies inside the snow of \"{name}\"; there, lights are points or spheres");
                KeyPath::root("light").index(index).error(reason)
            })?;
            lamps_in_snow.push(LampInSnow { light: index, object, lamp });
        }
        let reflectance = |surface: &SurfaceInteraction| match &materials[surface.material].material {
            Material::Diffuse(diffuse) => Some(diffuse.reflectance(objects, surface)),
            Material::PcaSnow(_) | Material::LayeredSnow(_) => None,
        };
        let scene = FieldScene {
            objects,
            lights,
            snow: &|object| snowpacks.get(objects.list()[object].material)?.clone(),
            lamps_in_snow: &lamps_in_snow,
            reflectance: &reflectance,
            max_bounces: self.integrator.max_bounces,
            settings: self.light_field,
        };
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
fn snowpacks(
    snow: &[Vec<SnowSample>],
    materials: &[NamedMaterial],
    volumes: &[Vec<Volume>],
    (sources, rays): (&Sources, u32),
) -> Result<Vec<Option<Arc<Snowpack>>>, RenderError> {
    let mut snowpacks = Vec::with_capacity(snow.len());
    for (number, (samples, NamedMaterial { name, material })) in snow.iter().zip(materials).enumerate() {
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

/// A body whose objects differ in material.
fn body_of_two(objects: &Objects) -> Option<&str> {
    let mut materials = BTreeMap::new();
    let named = objects.list().iter().filter_map(|object| Some((object.body.as_deref()?, object.material)));
    named
        .filter(|(body, material)| materials.entry(*body).or_insert(*material) != material)
        .map(|(body, _)| body)
        .next()
}
