//! The light that arrives along a ray: a path from surface to surface, lit at each of them.
//!
//! L = Σ_k β_k L_lit(x_k), β_{k+1} = β_k ρ(x_k), where the next direction is drawn with density cos θ / π, so that for
//! a diffuse surface only its reflectance ρ remains (Kajiya 1986, "The rendering equation",
//! doi:10.1145/15922.15902; the notation is that of Pharr, Jakob & Humphreys 2023, chapter 13). Long paths are ended
//! at random with a probability that the survivors make up for: nothing is lost on average.
//!
//! Lights with extent are found in two ways, by drawing a point of them and by the path's next ray; each counts with its
//! share of the density of both (see [`light`](crate::scene::light)).

use crate::geometry::lanes::{LaneMask, RayPacket4};
use crate::geometry::ray::Ray;
use crate::integrators::direct::{Colours, DirectLight};
use crate::sampling::{Sampler, cosine_direction};
use crate::scene::Scene;
use crate::scene::light::{Light, SurfacePoint, TOUCHING};
use crate::scene::objects::SurfaceInteraction;
use crate::scene::queries::{SceneQueries, Statistics};
use crate::spectrum::Spectrum;

/// Bounces that every path may make before chance can end it.
const SAFE_BOUNCES: u32 = 4;

/// Follows paths through a scene.
#[derive(Debug)]
pub(crate) struct PcaSnowIntegrator<'scene> {
    scene: &'scene Scene,
    probe: SceneQueries<'scene>,
    sees_lights: bool,
}

impl<'scene> PcaSnowIntegrator<'scene> {
    /// A tracer that has not traced anything.
    pub(crate) fn new(scene: &'scene Scene) -> Self {
        let sees_lights = scene.lights.iter().any(Light::has_extent);
        Self { scene, probe: SceneQueries::new(&scene.objects), sees_lights }
    }

    /// What was traced so far.
    pub(crate) fn statistics(&self) -> Statistics {
        self.probe.statistics
    }

    /// The colours of the light that arrives along some camera rays by the short way, and which of them hit anything.
    #[inline]
    pub(crate) fn colours(
        &mut self,
        direct: &DirectLight,
        camera_rays: &RayPacket4,
        which: LaneMask,
    ) -> (Colours, LaneMask) {
        direct.colours(&mut self.probe, camera_rays, which)
    }

    /// One sample of the radiance that arrives along a camera ray, in W m⁻² sr⁻¹ as a band density.
    pub(crate) fn radiance(&mut self, camera_ray: &Ray, sampler: &mut Sampler) -> Spectrum {
        let mut radiance = Spectrum::ZERO;
        let mut throughput = Spectrum::ONE;
        let mut ray = *camera_ray;
        let mut from = None;
        let mut hit = self.probe.camera_hit(camera_ray);
        for bounce in 0.. {
            if self.sees_lights {
                radiance.add_product(1.0, &throughput, &self.met(&ray, hit.as_ref(), from.as_ref()));
            }
            let Some(surface) = hit.filter(|_| bounce <= self.scene.integrator.max_bounces) else { break };
            let material = &self.scene.materials[surface.material];
            let shading = material.lit(&mut self.probe, &surface, &self.scene.lights, sampler);
            radiance.add_product(1.0, &throughput, &shading.radiance);
            // The last ray shows lights alone.
            if bounce == self.scene.integrator.max_bounces && !self.sees_lights {
                break;
            }
            let [u, v, chance, _] = sampler.next_four();
            let direction = cosine_direction(surface.normal, u, v);
            throughput *= shading.reflectance(surface.normal.dot(direction).max(0.0));
            let survival = if bounce < SAFE_BOUNCES { 1.0 } else { throughput.maximum().min(1.0) };
            if chance >= survival || throughput.maximum() <= 0.0 {
                break;
            }
            throughput = throughput * survival.recip();
            ray = Ray { origin: self.probe.off_surface(surface.object, surface.point, surface.normal), direction };
            from = Some(SurfacePoint { point: surface.point, normal: surface.normal });
            hit = self.probe.indirect_hit(&ray);
        }
        radiance
    }

    /// The lights on a ray before what it hits.
    fn met(&self, ray: &Ray, hit: Option<&SurfaceInteraction>, from: Option<&SurfacePoint>) -> Spectrum {
        // As far as beams reach: a lamp that lies on what is hit is met.
        let limit_m = hit.map_or(f32::INFINITY, |surface| surface.point.distance(ray.origin) / (1.0 - TOUCHING));
        let mut radiance = Spectrum::ZERO;
        for light in self.scene.lights.iter().filter_map(|light| light.met(ray, limit_m, from)) {
            radiance += light;
        }
        radiance
    }
}
