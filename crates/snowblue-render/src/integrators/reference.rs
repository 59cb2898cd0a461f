//! Volumetric path tracer, the ground truth: light is scattered from grain to grain in snow of any shape.
//!
//! A path is a [`SnowWalk`]. The path enters snow without refraction. In snow it continues from grain to grain
//! ([`Volume`]) until it leaves. At each scattering every light without extent contributes:
//!
//! L += β(λ) P(cos Θ; λ) e^{−κd} V I(λ)/r²,   β(λ) = e^{−γ(λ)ℓ},
//!
//! where ℓ is the path length in ice so far, d the distance through snow to the light, and V the visibility of the
//! light past solids. The rays of the path itself find lights with extent. The sun, and the pixels of an image of the
//! sky that are far brighter than its mean, are too small for this: a direction of each, drawn once a path, acts as a
//! light without extent. Three techniques reduce the cost without
//! changing a mean:
//!
//! - A light contributes with the probability e^{−κd}, so deep in snow there is mostly nothing to compute.
//! - A path ends with the probability of absorption at the least absorbed wavelength. Other wavelengths are weighted.
//! - Scattering events are precomputed. Each path reads the list from a random position and draws its own flights and
//!   azimuths.
//!
//! All wavelengths share a path except for the refractive index of ice: a sample is one path for each of a few indices,
//! with the same random numbers, and wavelengths are interpolated between them.
//!
//! Snow of layers, or that varies by a mask, is traced by delta tracking (Woodcock et al. 1965): flights are drawn
//! with the greatest extinction coefficient κ_max of the body, and a share κ/κ_max of their ends are collisions with
//! grains of the snow there.
//!
//! Simplified: there is no air between snow and a solid in contact; where two bodies of snow overlap, light is in the
//! body that it entered.

use std::sync::Arc;

use glam::Vec3A;
use snowblue_base::narrow;
use snowblue_geometry::ray::{Ray, off_surface};
use snowblue_transport::monte_carlo::{PathLengths, Volume, VolumeNode};
use snowblue_transport::rng::Stream;

use crate::integrators::PathSample;
use crate::integrators::snow_volumes::{SnowVolumes, attenuation};
use crate::integrators::snow_walk::{SnowWalk, WalkLight};
use crate::integrators::surroundings::{BodyId, Flight, Medium, SnowBodies, SnowQueries};
use snowblue_scene::Scene;
use snowblue_scene::directions::Directions;
use snowblue_scene::light::{Light, LightHit};
use snowblue_scene::material::Material;
use snowblue_scene::objects::SurfaceInteraction;
use snowblue_scene::queries::Statistics;
use snowblue_scene::sampling::Sampler;
use snowblue_scene::spectrum::Spectrum;
use snowblue_scene::transparency::Segment;

/// Traces paths of light from grain to grain.
#[derive(Debug)]
pub(crate) struct ReferenceTracer<'scene> {
    scene: &'scene Scene,
    /// The lights of the scene, in parts of which each is found by rays, or is small.
    lights: &'scene [Arc<Light>],
    surroundings: SnowQueries<'scene>,
    volumes: &'scene [Option<Arc<SnowVolumes>>],
    delta_lights: Vec<WalkLight>,
    has_area_lights: bool,
    /// Weights of the wavelengths at each index node. A scene without snow has one node.
    weights: Vec<Spectrum>,
    /// Path lengths in each kind of the present snow.
    lengths: Vec<PathLengths>,
}

/// The state of a path.
struct Path {
    walk: SnowWalk,
    /// Number of the index node.
    node: usize,
}

/// How a path's stay in snow ends.
enum SnowEnd {
    /// Absorbed.
    Absorbed,
    /// Out of the snow.
    Outside,
    /// Not in the snow at all: the ray finds no second side of the surface, because the surface is open or the ray
    /// grazes a rim.
    Missed,
    /// At a solid in the snow or in contact with it.
    Solid(SurfaceInteraction),
}

impl<'scene> ReferenceTracer<'scene> {
    /// Starts with zero counts. `lights` are the [parts](Light::parts) of the lights of the scene.
    pub(crate) fn new(
        (scene, lights): (&'scene Scene, &'scene [Arc<Light>]),
        bodies: &'scene SnowBodies,
        volumes: &'scene [Option<Arc<SnowVolumes>>],
    ) -> Self {
        // All volumes have the same nodes.
        let volume = volumes.iter().flatten().flat_map(|snow| &snow.volumes).next();
        let weights = |node: &VolumeNode| Spectrum(std::array::from_fn(|k| node.weights()[k]));
        Self {
            scene,
            lights,
            surroundings: SnowQueries::new(scene, bodies, volumes),
            volumes,
            delta_lights: Vec::with_capacity(lights.len()),
            has_area_lights: lights.iter().any(|light| !light.is_small()),
            weights: volume.map_or(vec![Spectrum::ONE], |volume| volume.nodes().iter().map(weights).collect()),
            lengths: Vec::new(),
        }
    }

    /// Counts of the queries so far.
    pub(crate) fn statistics(&self) -> Statistics {
        self.surroundings.statistics
    }

    /// One sample of the radiance along a camera ray, in W m⁻² sr⁻¹ as a band density.
    pub(crate) fn radiance(&mut self, camera_ray: &Ray, sampler: &Sampler) -> PathSample<Spectrum> {
        let [pixel, sample] = sampler.address();
        self.surroundings.statistics.camera_rays += 1;
        let mut of_lights = *sampler;
        self.delta_lights.clear();
        self.delta_lights.extend(self.lights.iter().filter_map(|light| {
            let sample = light.small_sample(&mut of_lights)?;
            Some(WalkLight { sample, power: light.power(&sample.origin) })
        }));
        let (mut radiance, mut sees_snow, mut distance_m) = (Spectrum::ZERO, false, None);
        for node in 0..self.weights.len() {
            let mut path = Path { walk: SnowWalk::new(*camera_ray, Stream::new(pixel.into(), sample.into())), node };
            (sees_snow, distance_m) = self.trace(&mut path);
            radiance.add_product(1.0, &self.weights[node], &path.walk.radiance);
        }
        PathSample { radiance, sees_snow, distance_m, filtered: None }
    }

    /// Traces a path to its end. Returns whether the first surface is snow, and its distance in m.
    fn trace(&mut self, path: &mut Path) -> (bool, Option<f32>) {
        let hit = self.next_surface(path, true);
        let sees_snow = hit.as_ref().is_some_and(|surface| self.scene.materials()[surface.material].looks_like_snow());
        let distance_m = hit.as_ref().map(|surface| surface.point.distance(path.walk.ray.origin));
        self.follow(path, hit);
        (sees_snow, distance_m)
    }

    /// Traces a path from its first surface to its end.
    fn follow(&mut self, path: &mut Path, mut hit: Option<SurfaceInteraction>) {
        let mut within = None;
        for bounce in 0..=self.scene.integrator().max_bounces.get() {
            let Some(surface) = hit else { return };
            match &self.scene.materials()[surface.material] {
                Material::Diffuse(diffuse, _) => {
                    let reflectance = diffuse.reflectance(self.scene.objects(), &surface);
                    let directions = Directions::Cosine(surface.surface_point());
                    if !self.reflect(path, &surface, (directions, |_| reflectance), bounce) {
                        return;
                    }
                }
                // Paths end at a pane only after many others.
                Material::Glass(_) => return,
                Material::Ground(ground) => {
                    let reflectance = |to_light| ground.reflectance(surface.normal, surface.direction, to_light);
                    let directions = ground.surface().directions(surface.surface_point(), surface.direction);
                    if !self.reflect(path, &surface, (directions, reflectance), bounce) {
                        return;
                    }
                }
                Material::Snow(_) => within = Some(BodyId { object: surface.object, material: surface.material }),
            }
            if let Some(snow) = within {
                let entering = self.scene.materials()[surface.material].is_snow();
                match self.scatter(path, snow, entering.then_some(&surface)) {
                    SnowEnd::Absorbed => return,
                    SnowEnd::Missed => {
                        let reach_m = self.scene.objects().reach_m(surface.object);
                        let behind = off_surface(surface.point, -surface.normal, reach_m);
                        path.walk.ray = Ray::new(behind, path.walk.ray.direction);
                        within = None;
                    }
                    SnowEnd::Solid(surface) => {
                        hit = Some(surface);
                        continue;
                    }
                    SnowEnd::Outside => within = None,
                }
            }
            hit = self.next_surface(path, false);
        }
    }

    /// The surface where the ray of a path ends outside of snow. Adds the lights with extent on the way: the lights
    /// that the camera sees if the ray starts there, with the sun and all lamps in mirrors, or else all but the sun.
    fn next_surface(&mut self, path: &mut Path, is_camera_ray: bool) -> Option<SurfaceInteraction> {
        let Self { lights, surroundings, .. } = self;
        let SnowWalk { ray, stream, throughput, radiance, .. } = &mut path.walk;
        let origin = ray.origin;
        let visit = |Segment { ray, hit, is_mirrored }: &Segment| {
            let limit_m = hit.map_or(f32::INFINITY, |hit| hit.point.distance(ray.origin));
            let of_light = |light: &Arc<Light>| {
                if is_camera_ray && !is_mirrored {
                    return light.hit_radiance(ray, limit_m, None);
                }
                let counts = is_camera_ray || !light.is_small();
                counts.then(|| light.full_hit_radiance(ray, limit_m))?.map(|hit| hit.radiance)
            };
            lights.iter().filter_map(of_light).for_each(|light| radiance.add_product(1.0, throughput, &light));
        };
        let hit = surroundings.first_end(ray, || narrow(stream.uniform()), visit);
        if ray.origin != origin {
            let ray = *ray;
            path.walk.continue_along(ray);
        }
        hit
    }

    /// Reflects a path. Returns false if it ends.
    fn reflect(
        &mut self,
        path: &mut Path,
        surface: &SurfaceInteraction,
        reflection: (Directions, impl Fn(Vec3A) -> Spectrum),
        bounce: u32,
    ) -> bool {
        let at_surface = (&*self.delta_lights, path.medium(), bounce);
        path.walk.reflect(&mut self.surroundings, surface, reflection, at_surface)
    }

    /// Scatters a path in snow, from the surface where it enters, else from inside.
    fn scatter(
        &mut self,
        path: &mut Path,
        BodyId { object, material }: BodyId,
        entering: Option<&SurfaceInteraction>,
    ) -> SnowEnd {
        let Some(snow) = self.volumes[material].as_deref() else { return SnowEnd::Absorbed };
        let greatest_per_m = snow.greatest_extinction_per_m(path.node);
        let mean_flight_m = greatest_per_m.recip();
        self.lengths.clear();
        self.lengths.resize(snow.volumes.len(), PathLengths::default());
        // Optical depth of absorption, at the least absorbed wavelength, at which the path ends.
        let absorption_limit = -path.walk.stream.uniform().ln();
        let first_event = path.walk.stream.uniform();
        let mut events: Vec<_> =
            snow.volumes.iter().map(|kind| kind.nodes()[path.node].events_from(first_event)).collect();
        // The exit along the first flight, where it is known.
        let mut known_exit = None;
        if let Some(surface) = entering {
            known_exit = self.surroundings.enter(surface, &mut path.walk.ray);
            if known_exit.is_none() {
                return SnowEnd::Missed;
            }
        }
        self.surroundings.statistics.walks += 1;
        let mut kind = self.kind_at(snow, object, path);
        loop {
            self.surroundings.statistics.flights += 1;
            let flight_m = path.walk.flight_m(mean_flight_m);
            let flight = self.surroundings.fly(object, &path.walk.ray, flight_m, known_exit.take());
            let length_m = flight.length_m();
            self.add_area_lights(path, length_m, (snow, kind));
            self.lengths[kind].pores_m += f64::from(length_m);
            if self.least_absorption(snow) > absorption_limit {
                return SnowEnd::Absorbed;
            }
            match flight {
                Flight::Free(_) => {
                    path.walk.ray.advance(length_m);
                    kind = self.kind_at(snow, object, path);
                    if !snow.kinds.is_uniform() {
                        let extinction_per_m = snow.volumes[kind].nodes()[path.node].extinction_per_m();
                        if path.walk.stream.uniform() * greatest_per_m >= extinction_per_m {
                            continue;
                        }
                    }
                    self.add_delta_lights(path, object, snow, kind);
                    let Some(event) = events[kind].next() else { return SnowEnd::Absorbed };
                    self.lengths[kind].ice_in_air_m += f64::from(event.ice_in_air_m);
                    self.lengths[kind].ice_in_water_m += f64::from(event.ice_in_water_m);
                    path.walk.turn(event.cos_scattering);
                    if self.least_absorption(snow) > absorption_limit {
                        return SnowEnd::Absorbed;
                    }
                }
                Flight::Out { origin, .. } => {
                    path.walk.throughput *= self.attenuation(snow, (kind, 0.0));
                    path.walk.ray = Ray::new(origin, path.walk.ray.direction);
                    return SnowEnd::Outside;
                }
                Flight::Solid(surface, _) if path.walk.goes_on(&self.surroundings, &surface) => {
                    kind = self.kind_at(snow, object, path);
                }
                Flight::Solid(surface, _) => {
                    path.walk.throughput *= self.attenuation(snow, (kind, 0.0));
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
        let mix = snow.kinds.at_point(self.scene.objects(), object, path.walk.ray.origin);
        mix.draw(|| narrow(path.walk.stream.uniform()))
    }

    /// The optical depth of absorption so far, at the least absorbed wavelength of each kind.
    #[inline]
    fn least_absorption(&self, snow: &SnowVolumes) -> f64 {
        snow.volumes.iter().zip(&self.lengths).map(|(volume, lengths)| volume.least_absorption(lengths)).sum()
    }

    /// Attenuation by absorption so far and over a further length in m in a kind of snow, beyond the absorption that
    /// Russian roulette accounts for so far.
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
        let medium = path.medium();
        for light in &self.delta_lights {
            let chance = path.walk.stream.uniform();
            let (ray, flight_m) = (&path.walk.ray, narrow(-chance.ln() * mean_flight_m));
            let origin = &light.sample.origin;
            if snow.kinds.is_uniform() && self.surroundings.stays_inside(object, ray, origin, flight_m) {
                continue;
            }
            let found = light.scattered(&mut self.surroundings, node, &path.walk.ray, (medium, chance));
            if let Some(scattered) = found {
                let absorbed = self.attenuation(snow, (kind, 0.0));
                path.walk.radiance.add_product(1.0, &(path.walk.throughput * absorbed), &scattered);
            }
        }
    }

    /// Adds the lights with extent within `limit_m` along the ray, in a kind of snow after the path lengths so far.
    #[inline]
    fn add_area_lights(&self, path: &mut Path, limit_m: f32, (snow, kind): (&SnowVolumes, usize)) {
        if !self.has_area_lights {
            return;
        }
        let lights = self.lights.iter().filter(|light| !light.is_small());
        let hits = lights.filter_map(|light| light.full_hit_radiance(&path.walk.ray, limit_m));
        for LightHit { radiance, distance_m } in hits {
            let absorbed = self.attenuation(snow, (kind, distance_m.into()));
            path.walk.radiance.add_product(1.0, &(path.walk.throughput * absorbed), &radiance);
        }
    }
}

impl Path {
    /// The snow on the way from the path to a light.
    fn medium(&self) -> Medium {
        Medium::EachPlace { node: self.node }
    }
}
