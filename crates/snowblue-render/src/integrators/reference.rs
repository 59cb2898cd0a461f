//! Volumetric path tracer, the ground truth: light is scattered from grain to grain in snow of any shape.
//!
//! A path runs backwards from the camera, which reciprocity allows because a grain's phase function depends on the
//! scattering angle alone. The refractive index does not change where it enters snow. There it continues by free
//! flights, t = −ln u / κ, from grain to grain ([`Volume`]), until it leaves. At each scattering every light without
//! extent contributes by next-event estimation (Veach 1997, *Robust Monte Carlo Methods for Light Transport
//! Simulation*, chapter 8):
//!
//! L += β(λ) P(cos Θ; λ) e^{−κd} V I(λ)/r²,   β(λ) = e^{−γ(λ)ℓ},
//!
//! where ℓ is the path length in ice so far, d the distance through snow to the light, and V its visibility otherwise.
//! The path's own rays find lights with extent. Three techniques reduce the cost without changing a mean:
//!
//! - e^{−κd} is the probability that a light contributes at all, so that deep in snow there is nothing to compute.
//! - The absorption of the least absorbed wavelength is the probability that a path ends. Other wavelengths are
//!   weighted.
//! - Scattering events are precomputed. Each path reads the list from a random position and draws its own flights and
//!   azimuths.
//!
//! All wavelengths share a path except for the refractive index of ice: a sample is one path for each of a few indices,
//! with the same random numbers, and wavelengths are interpolated between them.
//!
//! Snow of layers, or that varies by a mask, is traced by delta tracking (Woodcock et al. 1965): flights are drawn by the
//! greatest extinction coefficient κ_max of the body, and a share κ/κ_max of their ends are collisions, with the grains
//! of the snow there.
//!
//! Simplified: a solid in contact with snow has no air between; where two bodies of snow overlap, light is in the one
//! that it entered.

use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

use glam::Vec3A;
use snowblue_transport::monte_carlo::{PathLengths, Volume, VolumeNode};
use snowblue_transport::rng::Stream;

use crate::geometry::ray::{Ray, SurfacePoint, narrow, off_surface};
use crate::integrators::russian_roulette::survival_probability;
use crate::integrators::snow_volumes::{SnowVolumes, attenuation};
use crate::integrators::surroundings::{Flight, Medium, SnowBodies, Surroundings};
use crate::sampling::{Sampler, cosine_direction};
use crate::scene::Scene;
use crate::scene::light::{Light, LightHit, LightSample};
use crate::scene::material::Material;
use crate::scene::material::diffuse::Diffuse;
use crate::scene::objects::SurfaceInteraction;
use crate::scene::queries::Statistics;
use crate::spectrum::Spectrum;

/// Traces paths of light from grain to grain.
#[derive(Debug)]
pub(crate) struct ReferenceTracer<'scene> {
    scene: &'scene Scene,
    surroundings: Surroundings<'scene>,
    volumes: &'scene [Option<Arc<SnowVolumes>>],
    delta_lights: Vec<DeltaLight>,
    has_area_lights: bool,
    /// Weights of the wavelengths at each index node. A scene without snow has one node.
    weights: Vec<Spectrum>,
    /// Path lengths in each kind of the present snow.
    lengths: Vec<PathLengths>,
}

/// A light without extent, or a point of the sun.
#[derive(Debug, Clone, Copy)]
struct DeltaLight {
    sample: LightSample,
    power: Spectrum,
}

impl DeltaLight {
    fn new(light: &Light, sampler: &mut Sampler) -> Option<Self> {
        let sample = light.small_sample(sampler)?;
        Some(Self { sample, power: light.power(&sample.origin) })
    }
}

/// The state of a path.
struct Path {
    ray: Ray,
    /// A unit vector perpendicular to the ray from which azimuths are measured. It turns with the ray, so that a small
    /// change of the index changes the path little.
    side: Vec3A,
    stream: Stream,
    /// Number of the index node.
    node: usize,
    throughput: Spectrum,
    radiance: Spectrum,
}

/// How a path's stay in snow ends.
enum SnowEnd {
    /// Absorbed.
    Absorbed,
    /// Out of the snow.
    Outside,
    /// Not in the snow at all: the surface has no other side on the ray, because it is open or the ray grazes a rim.
    Missed,
    /// At a solid in the snow or in contact with it.
    Solid(SurfaceInteraction),
}

/// The body of snow in which a path is.
#[derive(Clone, Copy)]
struct Snow {
    object: usize,
    material: usize,
}

impl<'scene> ReferenceTracer<'scene> {
    /// Starts with zero counts.
    pub(crate) fn new(
        scene: &'scene Scene,
        bodies: &'scene SnowBodies,
        volumes: &'scene [Option<Arc<SnowVolumes>>],
    ) -> Self {
        // All volumes have the same nodes.
        let volume = volumes.iter().flatten().flat_map(|snow| &snow.volumes).next();
        let weights = |node: &VolumeNode| Spectrum(std::array::from_fn(|k| node.weights()[k]));
        Self {
            scene,
            surroundings: Surroundings::new(scene, bodies, volumes),
            volumes,
            delta_lights: Vec::with_capacity(scene.lights.len()),
            has_area_lights: scene.lights.iter().any(|light| !light.is_small()),
            weights: volume.map_or(vec![Spectrum::ONE], |volume| volume.nodes().iter().map(weights).collect()),
            lengths: Vec::new(),
        }
    }

    /// Counts of the queries so far.
    pub(crate) fn statistics(&self) -> Statistics {
        self.surroundings.statistics
    }

    /// One sample of the radiance along a camera ray, in W m⁻² sr⁻¹ as a band density.
    pub(crate) fn radiance(&mut self, camera_ray: &Ray, sampler: &Sampler) -> Spectrum {
        let [pixel, sample] = sampler.address();
        self.surroundings.statistics.camera_rays += 1;
        let mut of_lights = *sampler;
        self.delta_lights.clear();
        self.delta_lights.extend(self.scene.lights.iter().filter_map(|light| DeltaLight::new(light, &mut of_lights)));
        let mut radiance = Spectrum::ZERO;
        for node in 0..self.weights.len() {
            let mut path = Path {
                ray: *camera_ray,
                side: camera_ray.direction.any_orthonormal_vector(),
                stream: Stream::new(pixel.into(), sample.into()),
                node,
                throughput: Spectrum::ONE,
                radiance: Spectrum::ZERO,
            };
            self.trace(&mut path);
            radiance.add_product(1.0, &self.weights[node], &path.radiance);
        }
        radiance
    }

    /// Traces a path to its end.
    fn trace(&mut self, path: &mut Path) {
        let mut hit = self.surroundings.first_hit(&path.ray);
        self.add_visible_lights(path, hit.as_ref());
        let mut within = None;
        for bounce in 0..=self.scene.integrator.max_bounces {
            let Some(surface) = hit else { return };
            match &self.scene.materials[surface.material] {
                Material::Diffuse(diffuse) => {
                    if !self.reflect(path, diffuse, &surface, bounce) {
                        return;
                    }
                }
                Material::Snow(_) => within = Some(Snow { object: surface.object, material: surface.material }),
            }
            if let Some(snow) = within {
                let entering = self.scene.materials[surface.material].is_snow();
                match self.scatter(path, snow, entering) {
                    SnowEnd::Absorbed => return,
                    SnowEnd::Missed => {
                        let reach_m = self.scene.objects.reach_m(surface.object);
                        path.ray.origin = off_surface(surface.point, -surface.normal, reach_m);
                        within = None;
                    }
                    SnowEnd::Solid(surface) => {
                        hit = Some(surface);
                        continue;
                    }
                    SnowEnd::Outside => within = None,
                }
            }
            hit = self.surroundings.first_hit(&path.ray);
            let limit_m = hit.map_or(f32::INFINITY, |surface| surface.point.distance(path.ray.origin));
            self.add_area_lights(path, limit_m, None);
        }
    }

    /// Adds the lights without extent at a diffuse surface and samples the next ray there. Returns false if the path
    /// ends.
    fn reflect(&mut self, path: &mut Path, diffuse: &Diffuse, surface: &SurfaceInteraction, bounce: u32) -> bool {
        path.throughput *= diffuse.reflectance(&self.scene.objects, surface);
        let reach_m = self.scene.objects.reach_m(surface.object);
        let from = off_surface(surface.point, surface.normal, reach_m);
        for index in 0..self.delta_lights.len() {
            let (DeltaLight { sample, power }, chance) = (self.delta_lights[index], path.stream.uniform());
            if let Some(incident) = sample.incident_at(&surface.surface_point())
                && let Some(transmitted) = self.surroundings.transmitted(from, &sample.origin, path.medium(), chance)
            {
                let factor = incident.irradiance_per_power * FRAC_1_PI;
                path.radiance.add_product(factor, &(path.throughput * transmitted), &power);
            }
        }
        let [u, v, chance] = [(); 3].map(|()| narrow(path.stream.uniform()));
        let direction = cosine_direction(surface.normal, u, v);
        let survival = survival_probability(bounce, &path.throughput);
        if chance >= survival {
            return false;
        }
        path.throughput = path.throughput * survival.recip();
        path.ray = Ray { origin: from, direction };
        path.side = direction.any_orthonormal_vector();
        true
    }

    /// Scatters a path in snow, from its surface if `entering`, else from inside.
    fn scatter(&mut self, path: &mut Path, Snow { object, material }: Snow, entering: bool) -> SnowEnd {
        let Some(snow) = self.volumes[material].as_deref() else { return SnowEnd::Absorbed };
        let greatest_per_m = snow.greatest_extinction_per_m(path.node);
        let mean_flight_m = greatest_per_m.recip();
        self.lengths.clear();
        self.lengths.resize(snow.volumes.len(), PathLengths::default());
        // Optical depth of absorption, at the least absorbed wavelength, at which the path ends.
        let absorption_limit = -path.stream.uniform().ln();
        let first_event = path.stream.uniform();
        let mut events: Vec<_> =
            snow.volumes.iter().map(|kind| kind.nodes()[path.node].events_from(first_event)).collect();
        // The way out along the first flight, where it is known.
        let mut known_exit = None;
        if entering {
            known_exit = self.surroundings.enter(object, &mut path.ray);
            if known_exit.is_none() {
                return SnowEnd::Missed;
            }
        }
        let mut kind = self.kind_at(snow, object, path);
        loop {
            let flight_m = narrow(-path.stream.uniform().ln() * mean_flight_m);
            let flight = self.surroundings.fly(object, &path.ray, flight_m, known_exit.take());
            let length_m = flight.length_m();
            self.add_area_lights(path, length_m, Some((snow, kind)));
            self.lengths[kind].pores_m += f64::from(length_m);
            if self.least_absorption(snow) > absorption_limit {
                return SnowEnd::Absorbed;
            }
            match flight {
                Flight::Free(_) => {
                    path.ray.origin = path.ray.at(length_m);
                    kind = self.kind_at(snow, object, path);
                    if !snow.kinds.is_uniform() {
                        let extinction_per_m = snow.volumes[kind].nodes()[path.node].extinction_per_m();
                        if path.stream.uniform() * greatest_per_m >= extinction_per_m {
                            continue;
                        }
                    }
                    self.add_delta_lights(path, object, snow, kind);
                    let Some(event) = events[kind].next() else { return SnowEnd::Absorbed };
                    self.lengths[kind].ice_in_air_m += f64::from(event.ice_in_air_m);
                    self.lengths[kind].ice_in_water_m += f64::from(event.ice_in_water_m);
                    path.turn(event.cos_scattering);
                    if self.least_absorption(snow) > absorption_limit {
                        return SnowEnd::Absorbed;
                    }
                }
                Flight::Out { origin, .. } => {
                    path.throughput *= self.attenuation(snow, (kind, 0.0));
                    path.ray.origin = origin;
                    return SnowEnd::Outside;
                }
                Flight::Solid(surface, _) => {
                    path.throughput *= self.attenuation(snow, (kind, 0.0));
                    return SnowEnd::Solid(surface);
                }
            }
        }
    }

    /// The kind of snow where a path is.
    #[inline]
    fn kind_at(&self, snow: &SnowVolumes, object: usize, path: &mut Path) -> usize {
        if snow.kinds.is_uniform() {
            return 0;
        }
        let mix = snow.kinds.at_point(&self.scene.objects, object, path.ray.origin);
        if mix.is_mixed() { mix.pick(narrow(path.stream.uniform())) } else { mix.first }
    }

    /// The optical depth of absorption so far, at the least absorbed wavelength of each kind.
    #[inline]
    fn least_absorption(&self, snow: &SnowVolumes) -> f64 {
        snow.volumes.iter().zip(&self.lengths).map(|(volume, lengths)| volume.least_absorption(lengths)).sum()
    }

    /// What is not absorbed so far and over a further length in m in a kind of snow, beyond what Russian roulette
    /// accounts for so far.
    fn attenuation(&self, snow: &SnowVolumes, (kind, further_m): (usize, f64)) -> Spectrum {
        let of_kind = |(number, (volume, lengths)): (usize, (&Volume, &PathLengths))| {
            let further_m = if number == kind { further_m } else { 0.0 };
            let whole = PathLengths { pores_m: lengths.pores_m + further_m, ..*lengths };
            attenuation(volume, &whole, volume.least_absorption(lengths))
        };
        let mut of_kinds = snow.volumes.iter().zip(&self.lengths).enumerate().map(of_kind);
        let first = of_kinds.next().unwrap_or(Spectrum::ONE);
        of_kinds.fold(first, |product, kind| product * kind)
    }

    /// Adds the lights without extent that a grain at the end of a flight scatters into the path.
    fn add_delta_lights(&mut self, path: &mut Path, object: usize, snow: &SnowVolumes, kind: usize) {
        let node = &snow.volumes[kind].nodes()[path.node];
        let mean_flight_m = snow.greatest_extinction_per_m(path.node).recip();
        for index in 0..self.delta_lights.len() {
            let (DeltaLight { sample, power }, chance) = (self.delta_lights[index], path.stream.uniform());
            let point = path.ray.origin;
            let flight_m = narrow(-chance.ln() * mean_flight_m);
            if snow.kinds.is_uniform() && self.surroundings.stays_inside(object, point, &sample.origin, flight_m) {
                continue;
            }
            let Some(transmitted) = self.surroundings.transmitted(point, &sample.origin, path.medium(), chance) else {
                continue;
            };
            let normal = sample.origin.direction_from(point).direction;
            let Some(incident) = sample.incident_at(&SurfacePoint { point, normal }) else { continue };
            let phase = node.phase_per_sr(f64::from(path.ray.direction.dot(normal)));
            let mut scattered = path.throughput * self.attenuation(snow, (kind, 0.0)) * transmitted;
            scattered.0.iter_mut().zip(phase).for_each(|(scattered, phase)| *scattered *= phase);
            path.radiance.add_product(incident.irradiance_per_power, &scattered, &power);
        }
    }

    /// Adds the lights with extent that the camera sees.
    fn add_visible_lights(&self, path: &mut Path, hit: Option<&SurfaceInteraction>) {
        let limit_m = hit.map_or(f32::INFINITY, |surface| surface.point.distance(path.ray.origin));
        for light in &self.scene.lights {
            if let Some(radiance) = light.hit_radiance(&path.ray, limit_m, None) {
                path.radiance += radiance;
            }
        }
    }

    /// Adds the lights with extent within `limit_m` along the ray, in a kind of snow after the path lengths so far.
    #[inline]
    fn add_area_lights(&self, path: &mut Path, limit_m: f32, snow: Option<(&SnowVolumes, usize)>) {
        if !self.has_area_lights {
            return;
        }
        let lights = self.scene.lights.iter().filter(|light| !light.is_small());
        let hits = lights.filter_map(|light| light.full_hit_radiance(&path.ray, limit_m));
        for LightHit { radiance, distance_m } in hits {
            let absorbed = snow.map_or(Spectrum::ONE, |(snow, kind)| self.attenuation(snow, (kind, distance_m.into())));
            path.radiance.add_product(1.0, &(path.throughput * absorbed), &radiance);
        }
    }
}

impl Path {
    /// The snow on its way to a light.
    fn medium(&self) -> Medium {
        Medium::EachPlace { node: self.node }
    }

    /// Turns the ray by a scattering angle, at a random azimuth.
    #[inline]
    fn turn(&mut self, cos_scattering: f32) {
        let (sin_azimuth, cos_azimuth) = (std::f32::consts::TAU * narrow(self.stream.uniform())).sin_cos();
        let ahead = self.ray.direction;
        let aside = self.side * cos_azimuth + ahead.cross(self.side) * sin_azimuth;
        let sin_scattering = (1.0 - cos_scattering * cos_scattering).max(0.0).sqrt();
        self.ray.direction = renormalized(ahead * cos_scattering + aside * sin_scattering);
        let side = aside * cos_scattering - ahead * sin_scattering;
        self.side = renormalized(side - self.ray.direction * self.ray.direction.dot(side));
    }
}

/// Scales a vector of nearly unit length to unit length: one Newton step for 1/√x from 1.
#[inline]
fn renormalized(vector: Vec3A) -> Vec3A {
    vector * (1.5 - 0.5 * vector.length_squared())
}
