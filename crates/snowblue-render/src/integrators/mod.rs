//! Integrators: the radiance along a camera ray.

pub(crate) mod first_hit;
mod path;
mod reference;
mod single_scattering;
mod surroundings;
mod walk;

use snowblue_transport::monte_carlo::{PathLengths, Volume};

use crate::film::sensor::SensorSample;
use crate::geometry::ray::Ray;
use crate::integrators::path::PathIntegrator;
use crate::integrators::reference::ReferenceIntegrator;
use crate::sampling::Sampler;
use crate::scene::queries::Statistics;
use crate::scene::{IntegratorKind, Scene};
use crate::spectrum::Spectrum;

pub(crate) use path::LightTables;

/// Bounces before Russian roulette begins.
const SAFE_BOUNCES: u32 = 4;

/// Probability with which a path of some throughput survives a bounce.
fn survival_probability(bounce: u32, throughput: &Spectrum) -> f32 {
    if bounce < SAFE_BOUNCES { 1.0 } else { throughput.maximum().min(1.0) }
}

/// Attenuation of each wavelength by absorption along a path, less the optical depth `accounted`.
fn attenuation(volume: &Volume, lengths: &PathLengths, accounted: f64) -> Spectrum {
    let mut attenuation = Spectrum::ZERO;
    volume.attenuation(lengths, accounted, &mut attenuation.0);
    attenuation
}

/// The integrator of a scene, with the state of one thread.
#[derive(Debug)]
pub(crate) enum Integrator<'scene> {
    Path(Box<PathIntegrator<'scene>>),
    Reference(Box<ReferenceIntegrator<'scene>>),
}

impl<'scene> Integrator<'scene> {
    /// Starts with zero counts.
    pub(crate) fn new(scene: &'scene Scene, tables: &'scene LightTables) -> Self {
        match scene.integrator.kind {
            IntegratorKind::Reference => Self::Reference(Box::new(ReferenceIntegrator::new(scene))),
            IntegratorKind::PcaSnow | IntegratorKind::Diffusion | IntegratorKind::Hybrid => {
                Self::Path(Box::new(PathIntegrator::new(scene, tables)))
            }
        }
    }

    /// One sample of the radiance along a camera ray, in W m⁻² sr⁻¹ as a band density.
    pub(crate) fn radiance(&mut self, camera_ray: &Ray, sampler: &mut Sampler) -> Spectrum {
        match self {
            Self::Path(integrator) => integrator.radiance(camera_ray, sampler),
            Self::Reference(integrator) => integrator.radiance(camera_ray, sampler),
        }
    }

    /// The sensor's response to one sample of the radiance along a camera ray.
    #[inline]
    pub(crate) fn response(&mut self, scene: &Scene, camera_ray: &Ray, sampler: &mut Sampler) -> SensorSample {
        match self {
            Self::Path(integrator) => integrator.response(camera_ray, sampler),
            Self::Reference(integrator) => scene.sensor.sample(&integrator.radiance(camera_ray, sampler)),
        }
    }

    /// Counts of the queries so far.
    pub(crate) fn statistics(&self) -> Statistics {
        match self {
            Self::Path(integrator) => integrator.statistics(),
            Self::Reference(integrator) => integrator.statistics(),
        }
    }
}
