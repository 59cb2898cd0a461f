//! Shading of snow with a light field at its surface: reflection of the lights, light from inside, and the single
//! scattering that a flat surface lacks. With [`hybrid`](super::hybrid) a random walk finds all three.

pub(super) mod single_scattering;

use snowblue_geometry::ray::Ray;
use snowblue_light_field::{LightField, SnowAt};
use snowblue_scene::Scene;
use snowblue_scene::objects::SurfaceInteraction;
use snowblue_scene::queries::Statistics;
use snowblue_scene::sampling::Sampler;
use snowblue_scene::spectrum::Spectrum;

use crate::integrators::camera_terms::CameraTerms;
use crate::integrators::diffusion::single_scattering::SingleScattering;
use crate::integrators::hybrid::WalkTracer;
use crate::integrators::surface::Surface;
use crate::integrators::surroundings::SnowBodies;

/// Shades snow by its light field.
#[derive(Debug)]
pub(super) struct FieldShader<'a> {
    scene: &'a Scene,
    pub(super) field: &'a LightField,
    pub(super) single_scattering: SingleScattering<'a>,
    /// Random walks, if there are any.
    walks: Option<WalkTracer<'a>>,
    is_filtered: bool,
}

impl<'a> FieldShader<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        field: &'a LightField,
        bodies: &'a SnowBodies,
        walks: Option<WalkTracer<'a>>,
    ) -> Self {
        let single_scattering = SingleScattering::new(scene, field, bodies);
        Self { scene, field, single_scattering, walks, is_filtered: scene.description().is_filtered() }
    }

    /// The snow at a hit.
    pub(super) fn at(&self, hit: &SurfaceInteraction, sampler: &mut Sampler) -> SnowAt<'a> {
        let body = self.field.of_object(hit.object).unwrap_or_else(|| unreachable!("all snow has a light field"));
        body.at(self.scene.objects(), hit, sampler)
    }

    /// The terms of the light that snow sends along a camera ray. With walks they are needed for the filter only.
    pub(super) fn camera_terms(
        &mut self,
        snow: SnowAt<'a>,
        surface: &Surface,
        camera_ray: &Ray,
        sampler: &mut Sampler,
    ) -> CameraTerms<'a> {
        if self.walks.is_some() && !self.is_filtered {
            return CameraTerms { has_reflection: false, ..CameraTerms::default() };
        }
        let [number, ..] = sampler.next_four();
        CameraTerms {
            has_smooth_skies: self.walks.is_none(),
            from_inside: surface.light_from_inside(),
            scattering: Some(self.single_scattering.point(snow, surface.hit, camera_ray, number)),
            ..CameraTerms::default()
        }
    }

    /// The radiance along a camera ray by a random walk in snow; none without walks.
    pub(super) fn walk(
        &mut self,
        snow: SnowAt,
        hit: &SurfaceInteraction,
        camera_ray: &Ray,
        sampler: &mut Sampler,
    ) -> Option<Spectrum> {
        Some(self.walks.as_mut()?.walk(snow, hit, camera_ray, sampler))
    }

    /// Counts of the queries so far.
    pub(super) fn statistics(&self) -> Statistics {
        let walks = self.walks.as_ref().map(WalkTracer::statistics).unwrap_or_default();
        walks.plus(self.single_scattering.statistics())
    }
}
