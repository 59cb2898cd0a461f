//! What the light field needs of a scene.

use std::sync::Arc;

use glam::Vec3A;
use snowblue_field::SizesByDistance;

use super::illumination::LampInSnow;
use super::snowpack::Snowpack;
use super::watch::Watch;
use snowblue_scene::integrator::LightFieldSettings;
use snowblue_scene::light::Light;
use snowblue_scene::objects::{Objects, SurfaceInteraction};
use snowblue_scene::spectrum::Spectrum;

/// Greatest cells of a wide body at its surface, in m.
const GREATEST_CELL_M: f64 = 1.0;

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
    /// Who looks, if it is known: a wide body has small cells only where they are seen.
    pub(crate) viewer: Option<Viewer>,
    /// Memory and cells of the grid of a body.
    pub(crate) settings: LightFieldSettings,
    /// Receives the progress, and counts.
    pub(crate) watch: Watch<'a>,
}

/// A viewpoint, and the fineness of its picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Viewer {
    /// Where it is, in m.
    pub(crate) position: Vec3A,
    /// Angle of a pixel, in rad.
    pub(crate) pixel_rad: f64,
}

impl Viewer {
    /// Sizes of the cells of a wide body.
    pub(super) fn sizes(&self) -> SizesByDistance {
        SizesByDistance::of_picture(self.position.as_dvec3(), self.pixel_rad, GREATEST_CELL_M)
    }
}
