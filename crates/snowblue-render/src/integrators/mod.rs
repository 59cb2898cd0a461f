//! Either way of following light through a scene: along straight lines through snow, or from grain to grain.

pub(crate) mod direct;
pub(crate) mod first_hit;
mod pcasnow;
mod reference;

use crate::geometry::lanes::{LaneMask, RayPacket4};
use crate::geometry::ray::Ray;
use crate::integrators::direct::{Colours, DirectLight};
use crate::integrators::pcasnow::PcaSnowIntegrator;
use crate::integrators::reference::ReferenceIntegrator;
use crate::sampling::Sampler;
use crate::scene::queries::Statistics;
use crate::scene::{IntegratorKind, Scene};
use crate::spectrum::Spectrum;

/// Follows light through a scene as its settings say.
#[derive(Debug)]
pub(crate) enum Integrator<'scene> {
    PcaSnow(PcaSnowIntegrator<'scene>),
    Reference(Box<ReferenceIntegrator<'scene>>),
}

impl<'scene> Integrator<'scene> {
    /// A tracer that has not traced anything.
    pub(crate) fn new(scene: &'scene Scene) -> Self {
        match scene.integrator.kind {
            IntegratorKind::PcaSnow => Self::PcaSnow(PcaSnowIntegrator::new(scene)),
            IntegratorKind::Reference => Self::Reference(Box::new(ReferenceIntegrator::new(scene))),
        }
    }

    /// One sample of the radiance that arrives along a camera ray, in W m⁻² sr⁻¹ as a band density.
    pub(crate) fn radiance(&mut self, camera_ray: &Ray, sampler: &mut Sampler) -> Spectrum {
        match self {
            Self::PcaSnow(tracer) => tracer.radiance(camera_ray, sampler),
            Self::Reference(tracer) => tracer.radiance(camera_ray, sampler),
        }
    }

    /// The colours of the light that arrives along some camera rays by the short way, and which of them hit anything.
    #[inline]
    pub(crate) fn colours(
        &mut self,
        direct: &DirectLight,
        camera_rays: &RayPacket4,
        which: LaneMask,
    ) -> (Colours, LaneMask) {
        match self {
            Self::PcaSnow(tracer) => tracer.colours(direct, camera_rays, which),
            Self::Reference(_) => Default::default(),
        }
    }

    /// What was traced so far.
    pub(crate) fn statistics(&self) -> Statistics {
        match self {
            Self::PcaSnow(tracer) => tracer.statistics(),
            Self::Reference(tracer) => tracer.statistics(),
        }
    }
}
