//! A walk of light from grain to grain, as in the reference and the hybrid integrator: free flights, turns at grains,
//! and the lights at each grain and at each solid on the way.
//!
//! A walk runs backwards from the camera, which reciprocity allows because a grain's phase function depends on the
//! scattering angle alone. Each light contributes by next-event estimation (Veach 1997, *Robust Monte Carlo Methods for
//! Light Transport Simulation*, chapter 8).

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::Vec3A;
use snowblue_base::narrow;
use snowblue_geometry::ray::{Ray, SurfacePoint, off_surface};
use snowblue_transport::monte_carlo::VolumeNode;
use snowblue_transport::rng::Stream;

use super::sample::survival_probability;
use super::surroundings::{Medium, SnowQueries};
use snowblue_scene::directions::Directions;
use snowblue_scene::light::LightSample;
use snowblue_scene::objects::SurfaceInteraction;
use snowblue_scene::spectrum::Spectrum;

/// A walk between two scatterings.
#[derive(Debug)]
pub(super) struct SnowWalk {
    pub(super) ray: Ray,
    /// A unit vector perpendicular to the ray, from which azimuths are measured. The vector turns with the ray, so
    /// that a small change of the refractive index changes the walk little.
    side: Vec3A,
    pub(super) stream: Stream,
    /// The share of the light that comes along the ray, before absorption in the present snow.
    pub(super) throughput: Spectrum,
    /// The light found so far, in W m⁻² sr⁻¹ as a band density.
    pub(super) radiance: Spectrum,
}

/// A light of a walk: a point of the light, or a direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct WalkLight {
    pub(super) sample: LightSample,
    pub(super) power: Spectrum,
}

impl SnowWalk {
    /// A walk along a ray, without light.
    pub(super) fn new(ray: Ray, stream: Stream) -> Self {
        let side = ray.direction.any_orthonormal_vector();
        Self { ray, side, stream, throughput: Spectrum::ONE, radiance: Spectrum::ZERO }
    }

    /// Continues along another ray.
    pub(super) fn continue_along(&mut self, ray: Ray) {
        self.ray = ray;
        self.side = ray.direction.any_orthonormal_vector();
    }

    /// Goes on from a surface that the walk passes or that mirrors it. Returns false if the walk ends there or is
    /// reflected diffusely.
    pub(super) fn goes_on(&mut self, surroundings: &SnowQueries, surface: &SurfaceInteraction) -> bool {
        let onward = surroundings.onward(surface, || narrow(self.stream.uniform()));
        onward.into_iter().for_each(|ray| self.continue_along(ray));
        onward.is_some()
    }

    /// A free flight through snow, t = −ln u / κ, in m.
    #[inline]
    pub(super) fn flight_m(&mut self, mean_flight_m: f64) -> f32 {
        narrow(-self.stream.uniform().ln() * mean_flight_m)
    }

    /// Turns by a scattering angle, at a random azimuth.
    #[inline]
    pub(super) fn turn(&mut self, cos_scattering: f32) {
        let (sin_azimuth, cos_azimuth) = (TAU * narrow(self.stream.uniform())).sin_cos();
        let ahead = self.ray.direction;
        let aside = self.side * cos_azimuth + ahead.cross(self.side) * sin_azimuth;
        let sin_scattering = (1.0 - cos_scattering * cos_scattering).max(0.0).sqrt();
        self.ray.direction = renormalized(ahead * cos_scattering + aside * sin_scattering);
        let side = aside * cos_scattering - ahead * sin_scattering;
        self.side = renormalized(side - self.ray.direction * self.ray.direction.dot(side));
    }

    /// Reflects the walk at a surface outside of snow, in snow, or in contact with snow, and adds the lights there.
    /// `reflectance` gives π times the reflection function for light from a direction, and the next direction of the
    /// walk is sampled from `directions`. Returns false if the walk ends.
    pub(super) fn reflect(
        &mut self,
        surroundings: &mut SnowQueries,
        surface: &SurfaceInteraction,
        (directions, reflectance): (Directions, impl Fn(Vec3A) -> Spectrum),
        (lights, medium, bounce): (&[WalkLight], Medium, u32),
    ) -> bool {
        let off_surface = off_surface(surface.point, surface.normal, surroundings.reach_m(surface.object));
        let from = Ray::new(off_surface, surface.normal);
        for WalkLight { sample, power } in lights {
            let chance = self.stream.uniform();
            if let Some(incident) = sample.incident_at(&surface.surface_point())
                && let Some(transmitted) = surroundings.transmitted(&from, &sample.origin, medium, chance)
            {
                let factor = incident.irradiance_per_power * FRAC_1_PI;
                let reflected = self.throughput * reflectance(incident.direction);
                self.radiance.add_product(factor, &(reflected * transmitted), power);
            }
        }
        let [u, v, chance] = [(); 3].map(|()| narrow(self.stream.uniform()));
        let (direction, factor) = directions.sample_weighted([u, v]);
        self.throughput *= reflectance(direction) * factor;
        let survival = survival_probability(bounce, &self.throughput);
        if chance >= survival {
            return false;
        }
        self.throughput = self.throughput * survival.recip();
        self.continue_along(from.towards(direction));
        true
    }
}

impl WalkLight {
    /// The light that a grain at the origin of a ray scatters into it, P(cos Θ; λ) e^{−κd} V I(λ)/r², per unit of
    /// throughput: none with probability 1 − e^{−κd}, decided by `chance`.
    pub(super) fn scattered(
        &self,
        surroundings: &mut SnowQueries,
        node: &VolumeNode,
        ray: &Ray,
        (medium, chance): (Medium, f64),
    ) -> Option<Spectrum> {
        let (point, Self { sample, power }) = (ray.origin, self);
        let mut scattered = surroundings.transmitted(ray, &sample.origin, medium, chance)?;
        let normal = sample.origin.direction_from(point).direction;
        let incident = sample.incident_at(&SurfacePoint { point, normal })?;
        let phase = node.phase_per_sr(f64::from(ray.direction.dot(normal)));
        scattered.0.iter_mut().zip(phase).for_each(|(scattered, phase)| *scattered *= phase);
        Some(scattered * *power * incident.irradiance_per_power)
    }
}

/// Scales a vector of nearly unit length to unit length: one Newton step for 1/√x from 1.
#[inline]
fn renormalized(vector: Vec3A) -> Vec3A {
    vector * (1.5 - 0.5 * vector.length_squared())
}
