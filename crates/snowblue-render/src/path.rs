//! The light that arrives along a ray: a path from surface to surface, lit at each of them.
//!
//! L = Σ_k β_k L_lit(x_k), β_{k+1} = β_k ρ(x_k), where the next direction is drawn with density cos θ / π, so that for
//! a diffuse surface only its reflectance ρ remains (Kajiya 1986, "The rendering equation",
//! doi:10.1145/15922.15902; the notation is that of Pharr, Jakob & Humphreys 2023, chapter 13). Long paths are ended
//! at random with a probability that the survivors make up for: nothing is lost on average.

use crate::probe::{Probe, Statistics};
use crate::ray::{Ray, off_surface};
use crate::sampling::{Sampler, cosine_direction};
use crate::scene::Scene;
use crate::spectrum::Spectrum;

/// Bounces that every path may make before chance can end it.
const SAFE_BOUNCES: u32 = 4;

/// Follows paths through a scene.
#[derive(Debug)]
pub(crate) struct PathTracer<'scene> {
    scene: &'scene Scene,
    probe: Probe<'scene>,
}

impl<'scene> PathTracer<'scene> {
    /// A tracer that has not traced anything.
    pub(crate) fn new(scene: &'scene Scene) -> Self {
        Self { scene, probe: Probe::new(&scene.objects) }
    }

    /// What was traced so far.
    pub(crate) fn statistics(&self) -> Statistics {
        self.probe.statistics
    }

    /// One sample of the radiance that arrives along a camera ray, in W m⁻² sr⁻¹ as a band density.
    pub(crate) fn radiance(&mut self, camera_ray: &Ray, sampler: &mut Sampler) -> Spectrum {
        let mut radiance = Spectrum::ZERO;
        let mut throughput = Spectrum::ONE;
        let mut hit = self.probe.camera_hit(camera_ray);
        for bounce in 0.. {
            let Some(surface) = hit else { break };
            let material = &self.scene.materials[surface.material];
            let shading = material.lit(&mut self.probe, &surface, &self.scene.lights);
            radiance.add_product(1.0, &throughput, &shading.radiance);
            if bounce >= self.scene.integrator.max_bounces {
                break;
            }
            let [u, v, chance, _] = sampler.next_four();
            let direction = cosine_direction(surface.normal, u, v);
            throughput *= material.reflectance(&shading, surface.normal.dot(direction).max(0.0));
            let survival = if bounce < SAFE_BOUNCES { 1.0 } else { throughput.maximum().min(1.0) };
            if chance >= survival || throughput.maximum() <= 0.0 {
                break;
            }
            throughput = throughput * survival.recip();
            let origin = off_surface(surface.point, surface.normal);
            hit = self.probe.indirect_hit(&Ray { origin, direction });
        }
        radiance
    }
}
