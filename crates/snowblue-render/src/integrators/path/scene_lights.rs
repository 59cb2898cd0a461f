//! The lights of a scene as a path tracer samples them.

use std::sync::Arc;

use snowblue_scene::Scene;
use snowblue_scene::light::{Light, LightSample};
use snowblue_scene::spectrum::Spectrum;

/// The lights of a scene.
#[derive(Debug)]
pub(in crate::integrators) struct SceneLights<'a> {
    scene: &'a Scene,
    /// The only sample of each light without extent.
    delta_samples: Vec<Option<LightSample>>,
    /// Luminance of one unit at each wavelength.
    luminance: Spectrum,
}

impl<'a> SceneLights<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        let delta_samples = scene.lights().iter().map(|light| light.delta_sample()).collect();
        Self { scene, delta_samples, luminance: scene.sensor().luminance() }
    }

    /// All lights.
    #[inline]
    pub(in crate::integrators) fn all(&self) -> &'a [Arc<Light>] {
        self.scene.lights()
    }

    /// The only sample of a light without extent.
    #[inline]
    pub(in crate::integrators) fn delta_sample(&self, light: usize) -> Option<&LightSample> {
        self.delta_samples[light].as_ref()
    }

    /// Luminance of a radiance.
    #[inline]
    pub(in crate::integrators) fn luminance(&self, radiance: &Spectrum) -> f32 {
        radiance.dot(&self.luminance)
    }
}
