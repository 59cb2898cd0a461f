//! The terms of the light that a surface sends along a camera ray.

use snowblue_light_field::LightFromInside;
use snowblue_scene::light::{IncidentLight, Light, LightSample};
use snowblue_scene::spectrum::Spectrum;

use crate::integrators::diffusion::single_scattering::ScatteringPoint;
use crate::integrators::sparkle::SparklingPoint;
use crate::integrators::surface::{Shading, Surface};

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
    /// The change of the light from inside of snow by the light of a light sample that enters; none where the cells of
    /// the light field resolve this light.
    pub(super) fn change_from_inside(
        &self,
        surface: &Surface,
        (light, sample): (&Light, &LightSample),
        incident: &IncidentLight,
    ) -> Option<Spectrum> {
        let decrease_per_sr = self.from_inside.as_ref()?.decrease_per_sr?;
        let Shading::Field(snow) = &surface.shading else { return None };
        let entering = incident.irradiance_per_power * snow.optics.surface().escape(incident.cos_incidence);
        Some(light.power(&sample.origin) * decrease_per_sr * -entering)
    }

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
