//! The lamps of a scene, and the light of each of them alone.

use crate::field_scene::WorkCounter;
use crate::sight::CameraCells;
use crate::{BodySolution, FieldScene, LampInSnow, LightField};
use snowblue_scene::Scene;
use snowblue_scene::progress::Report;

/// A lamp whose light has an attribute of its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BakedLamp {
    /// What it is [called](snowblue_scene::light::Light::name): its `type` in a scene file, or `sun`.
    pub kind: &'static str,
    /// Index among the lights of the scene.
    pub(super) light: usize,
}

/// The lamps of a scene in its order: all lights but skies.
pub(super) fn lamps(scene: &Scene) -> Vec<BakedLamp> {
    let numbered = scene.lights().iter().enumerate();
    numbered.filter(|(_, one)| !one.is_sky()).map(|(light, one)| BakedLamp { kind: one.name(), light }).collect()
}

/// The light of one lamp in all snow, without other surfaces. `field` is the light field of all lights.
pub(super) fn field_of(
    lamp: &BakedLamp,
    scene: &Scene,
    field: &LightField,
    report: Report,
) -> Result<LightField, (usize, String)> {
    let light = &scene.lights()[lamp.light];
    let parts = field.parts_inside(lamp.light).map(|part| LampInSnow { light: 0, ..part.clone() });
    let inside: Vec<LampInSnow> = parts.collect();
    let alone = FieldScene {
        objects: scene.objects(),
        lights: std::slice::from_ref(light),
        snow: &|object| field.of_object(object).map(BodySolution::snow).cloned(),
        lamps_in_snow: &inside,
        reflectance: &|_| None,
        max_bounces: 0,
        // In wide snow, cells follow the camera; without it they would not fit into the memory.
        sight: Some(CameraCells::of(scene)),
        has_one_view: field.has_one_view(),
        settings: scene.description().light_field,
        watch: WorkCounter::new(report),
    };
    LightField::new(&alone)
}
