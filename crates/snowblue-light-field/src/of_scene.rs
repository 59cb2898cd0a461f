//! The light field of a scene: its snow with optics, its lamps inside snow, and its camera.

use std::sync::Arc;

use snowblue_field::SnowOptics;

use super::body_optics::{BodyOptics, KindOptics, WalkEndsByDepth};
use super::field::LightField;
use super::field_scene::{FieldScene, WorkCounter};
use super::illumination::{LampInSnow, parts_in_snow};
use super::sight::CameraCells;
use snowblue_base::KeyPath;
use snowblue_scene::material::snow::SnowKinds;
use snowblue_scene::progress::Report;
use snowblue_scene::spectrum::{SAMPLES, wavelengths_nm};
use snowblue_scene::{Changes, Scene, SceneError};

/// The snow of each material, by the index of the material; none for other materials.
pub type SnowOfMaterials<T> = Vec<Option<Arc<T>>>;

/// The ends of random walks, if there are any, for a material, a kind of its snow, and a transport mean free path in
/// m.
pub(crate) type WalkEndsOf<'a> = dyn Fn(usize, usize, f64) -> Option<WalkEndsByDepth> + 'a;

/// The snow of a scene with its optics, computed with `rays` rays through the grains of each kind.
///
/// # Errors
///
/// If the constants of some snow do not cover a wavelength.
pub fn optics_of_materials(
    scene: &Scene,
    kinds: &SnowOfMaterials<SnowKinds>,
    rays: u32,
    walk_ends: &WalkEndsOf,
) -> Result<SnowOfMaterials<BodyOptics>, SceneError> {
    let of_material = |(material, kinds): (usize, &Option<Arc<SnowKinds>>)| {
        let Some(kinds) = kinds else { return Ok(None) };
        let optics = kinds.samples.iter().enumerate().map(|(kind, sample)| {
            let optics = SnowOptics::new(sample, &wavelengths_nm(), rays)
                .map_err(|error| scene.material_path(material).error(format!("cannot be rendered: {error}")))?;
            let ends = walk_ends(material, kind, optics.transport_lengths_m[SAMPLES / 2]);
            Ok(KindOptics::new(optics, ends))
        });
        let optics = optics.collect::<Result<_, SceneError>>()?;
        Ok(Some(Arc::new(BodyOptics { kinds: Arc::clone(kinds), optics })))
    };
    kinds.iter().enumerate().map(of_material).collect()
}

impl LightField {
    /// Solves for the light in all snow of a scene, and reports the progress. If `has_one_view` holds, snow that the
    /// camera of the scene does not see has larger cells.
    ///
    /// # Errors
    ///
    /// If a body has no grid, or a light other than a point or a sphere lies inside snow.
    pub fn of_scene(
        scene: &Scene,
        snow: &SnowOfMaterials<BodyOptics>,
        has_one_view: bool,
        report: Report,
    ) -> Result<Self, SceneError> {
        let of_object = |object: usize| snow[scene.objects().list()[object].material].clone();
        with_field_scene(scene, &of_object, has_one_view, report, |field_scene| {
            Self::new(field_scene).map_err(|(object, reason)| {
                let name = &scene.objects().list()[object].name;
                KeyPath::root("object").error(format!("\"{name}\" {reason}")).into()
            })
        })
    }

    /// The light field in the same snow of a scene whose lights have changed. It reports the progress.
    ///
    /// # Errors
    ///
    /// If a light other than a point or a sphere lies inside snow.
    pub fn after_changes(self, scene: &Scene, changes: &Changes, report: Report) -> Result<Self, SceneError> {
        let has_one_view = self.has_one_view();
        with_field_scene(scene, &|_| None, has_one_view, report, |field_scene| {
            Ok(self.relit(field_scene, &|light| changes.has_light(light)))
        })
    }
}

/// Calls a function with the inputs of the light field from a scene. `snow` gives the snow of an object.
fn with_field_scene<T>(
    scene: &Scene,
    snow: &dyn Fn(usize) -> Option<Arc<BodyOptics>>,
    has_one_view: bool,
    report: Report,
    call: impl FnOnce(&FieldScene) -> Result<T, SceneError>,
) -> Result<T, SceneError> {
    let lamps_in_snow = lamps_in_snow(scene)?;
    call(&FieldScene {
        objects: scene.objects(),
        lights: scene.lights(),
        snow,
        lamps_in_snow: &lamps_in_snow,
        reflectance: &|surface| scene.materials()[surface.material].albedo(scene.objects(), surface),
        max_bounces: scene.integrator().max_bounces.get(),
        sight: Some(CameraCells::of(scene)),
        has_one_view,
        settings: scene.description().light_field,
        watch: WorkCounter::new(report),
    })
}

fn lamps_in_snow(scene: &Scene) -> Result<Vec<LampInSnow>, SceneError> {
    let mut found = Vec::new();
    for (index, light) in scene.lights().iter().enumerate() {
        found.extend(parts_in_snow(scene, index, light).map_err(|object| {
            let name = &scene.objects().list()[object].name;
            let reason = format!("lies inside the snow of \"{name}\"; there, lights are points or spheres");
            KeyPath::root("light").index(index).error(reason)
        })?);
    }
    Ok(found)
}
