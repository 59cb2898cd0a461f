//! The terms of the light that a surface sends along a camera ray.

use snowblue_light_field::LightFromInside;
use snowblue_scene::light::Light;

use crate::integrators::diffusion::single_scattering::ScatteringPoint;
use crate::integrators::sparkle::SparklingPoint;

/// Terms of the light from a surface to the camera, beside transmission and smooth reflection.
pub(super) struct CameraTerms<'a> {
    /// Whether smooth reflection counts; else a random walk finds it.
    pub(super) has_reflection: bool,
    /// Whether samples of smooth skies count; else a random walk samples them.
    pub(super) has_smooth_skies: bool,
    /// The light from inside of snow with a light field.
    pub(super) from_inside: Option<LightFromInside>,
    /// A point in snow for the single scattering that the reflection of a half-space misses.
    pub(super) scattering: Option<ScatteringPoint<'a>>,
    /// Facets that mirror lights.
    pub(super) sparkling: Option<SparklingPoint<'a>>,
}

impl Default for CameraTerms<'_> {
    fn default() -> Self {
        Self { has_reflection: true, has_smooth_skies: true, from_inside: None, scattering: None, sparkling: None }
    }
}

impl CameraTerms<'_> {
    /// Whether a light contributes.
    #[inline]
    pub(super) fn count(&self, light: &Light) -> bool {
        if self.has_reflection {
            self.has_smooth_skies || !light.is_smooth_sky()
        } else {
            self.sparkling.is_some() && !light.is_sky()
        }
    }
}
