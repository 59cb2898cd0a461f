//! The lamps of a scene.

use snowblue_scene::Scene;

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
