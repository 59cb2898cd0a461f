//! Either way of following light through a scene: along straight lines through snow, or from grain to grain.

use crate::direct::{Colours, DirectLight};
use crate::lanes::{Rays, Which};
use crate::path::PathTracer;
use crate::probe::Statistics;
use crate::ray::Ray;
use crate::reference::ReferenceTracer;
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

    /// The colours of the light that arrives along some camera rays by the short way, and which of them hit anything.
    #[inline]
    pub(crate) fn colours(&mut self, direct: &DirectLight, camera_rays: &Rays, which: Which) -> (Colours, Which) {
        match self {
            Self::Path(tracer) => tracer.colours(direct, camera_rays, which),
            Self::Reference(_) => Default::default(),
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
