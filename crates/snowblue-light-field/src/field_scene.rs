//! What the light field needs of a scene.

use std::sync::Arc;

use super::illumination::LampInSnow;
use super::sight::Sight;
use super::snowpack::Snowpack;
use super::watch::Watch;
use snowblue_scene::integrator::LightFieldSettings;
use snowblue_scene::light::Light;
use snowblue_scene::objects::{Objects, SurfaceInteraction};
use snowblue_scene::spectrum::Spectrum;

/// What the light field needs of a scene.
pub struct FieldScene<'a> {
    pub(crate) objects: &'a Objects,
    pub(crate) lights: &'a [Arc<Light>],
    /// The snow of an object, if it is snow.
    pub(crate) snow: &'a dyn Fn(usize) -> Option<Arc<Snowpack>>,
    /// Those of the lights that are inside snow.
    pub(crate) lamps_in_snow: &'a [LampInSnow],
    /// The reflectance of a diffuse surface; none for snow.
    pub(crate) reflectance: &'a (dyn Fn(&SurfaceInteraction) -> Option<Spectrum> + Sync),
    /// Most surfaces after the first on a path of light.
    pub(crate) max_bounces: u32,
    /// What the camera sees, if there is one.
    pub(crate) sight: Option<Sight<'a>>,
    /// Whether only that camera looks: snow that it does not see then has larger cells.
    pub(crate) has_one_view: bool,
    /// Memory and cells of the grid of a body.
    pub(crate) settings: LightFieldSettings,
    /// Receives the progress, and counts.
    pub(crate) watch: Watch<'a>,
}
