//! Either way of following light through a scene: along straight lines through snow, or from grain to grain.

use crate::direct::DirectLight;
use crate::path::PathTracer;
use crate::probe::Statistics;
use crate::ray::Ray;
use crate::reference::ReferenceTracer;
use crate::retina::Colour;
use crate::sampling::Sampler;
use crate::scene::{Integrator, Scene};
use crate::spectrum::Spectrum;

/// Follows light through a scene as its settings say.
#[derive(Debug)]
pub(crate) enum Tracer<'scene> {
    Path(PathTracer<'scene>),
    Reference(Box<ReferenceTracer<'scene>>),
}

impl<'scene> Tracer<'scene> {
    /// A tracer that has not traced anything.
    pub(crate) fn new(scene: &'scene Scene) -> Self {
        match scene.integrator.integrator {
            Integrator::Path => Self::Path(PathTracer::new(scene)),
            Integrator::Reference => Self::Reference(Box::new(ReferenceTracer::new(scene))),
        }
    }

    /// One sample of the radiance that arrives along a camera ray, in W m⁻² sr⁻¹ as a band density.
    pub(crate) fn radiance(&mut self, camera_ray: &Ray, sampler: &mut Sampler) -> Spectrum {
        match self {
            Self::Path(tracer) => tracer.radiance(camera_ray, sampler),
            Self::Reference(tracer) => tracer.radiance(camera_ray, sampler),
        }
    }

    /// The colour of the light that arrives along a camera ray by the short way; none where the ray hits nothing.
    #[inline]
    pub(crate) fn colour(&mut self, direct: &DirectLight, camera_ray: &Ray) -> Option<Colour> {
        match self {
            Self::Path(tracer) => tracer.colour(direct, camera_ray),
            Self::Reference(_) => None,
        }
    }

    /// What was traced so far.
    pub(crate) fn statistics(&self) -> Statistics {
        match self {
            Self::Path(tracer) => tracer.statistics(),
            Self::Reference(tracer) => tracer.statistics(),
        }
    }
}
