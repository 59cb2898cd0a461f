//! Snow by random walks that end in the light field inside.
//!
//! A walk enters snow where a camera ray hits it, and goes backwards from grain to grain as in the reference
//! integrator. Each scattering has next-event estimation. Light at a scattering x that lies deeper than [`EndDepth`]
//! below the nearest surface is diffuse: the radiance from there is φ(x + ℓ* w)/4π, where w is the next direction of
//! the walk (Wang & Jacques 1993; Li, Pellacini & Torrance 2005). So walks are short. They are valid at edges and in
//! small bodies, where the light field at the surface is not valid.
//!
//! A walk alone is noisy: it ends inside or leaves by chance. A walk with the same random numbers in the half-space
//! that is tangent at the entry has a known mean, and nearly the same result where the surface is flat
//! ([`TangentHalfSpace`]). The sum
//!
//! ```text
//! L = mean of the half-space + (walk in the body − walk in the half-space)
//! ```
//!
//! has the mean of the walk in the body, and little noise.
//!
//! Where a ray soon leaves the body again, as at silhouettes and rims, the walk in the half-space says nothing about
//! the body and only adds noise. So the mean of the half-space less its walk counts by the factor 1 − e^{−d/2ℓ*},
//! where d is the length of the ray in the body. This difference is zero on average, except for the shading normals
//! of meshes.
//!
//! In snow of layers, or snow that varies by a mask, a walk of a few mm uses the snow at its entry throughout.
//!
//! Lights with extent are sampled once for each walk, as seen from the entry; the samples are points or directions.
//! Light of a uniform sky and of other surfaces comes from the light field: its radiance is H/π where a walk leaves,
//! with the irradiance H that the light field gathered.

mod tangent_half_space;

use std::f32::consts::FRAC_1_PI;
use std::iter::{Cycle, Skip};
use std::slice::Iter;
use std::sync::Arc;

use snowblue_base::narrow;
use snowblue_geometry::ray::{Ray, SurfacePoint, off_surface};
use snowblue_light_field::{EndDepth, LightField, NearLight, SnowAt};
use snowblue_scene::Scene;
use snowblue_scene::directions::Directions;
use snowblue_scene::light::{Light, LightSample};
use snowblue_scene::objects::SurfaceInteraction;
use snowblue_scene::queries::Statistics;
use snowblue_scene::sampling::Sampler;
use snowblue_scene::spectrum::Spectrum;
use snowblue_scene::transparency::Segment;
use snowblue_transport::monte_carlo::{PathLengths, ScatteringEvent, Volume, VolumeNode};
use snowblue_transport::rng::Stream;

use crate::integrators::snow_volumes::{SnowVolumes, attenuation};
use crate::integrators::snow_walk::{SnowWalk, WalkLight};
use crate::integrators::surroundings::{Flight, Medium, SnowBodies, SnowQueries};
use tangent_half_space::{TangentHalfSpace, TangentLight};

/// A ball inside the body, in transport mean free paths: its distance below an entry, and its radius. Where the ball
/// fits into the body, no edge is near, and the body is thick.
const BALL_LENGTHS: [f32; 2] = [7.0, 6.5];

/// Length of a ray in a body, in transport mean free paths, from which on the half-space counts by more than 1 − 1/e.
/// Among 1, 2 and 3, tried on a knot, a torus, a block and balls, 2 gives the least noise at rims, and no more noise
/// elsewhere.
const HALF_SPACE_LENGTHS: f32 = 2.0;

/// Follows walks into snow.
#[derive(Debug)]
pub(crate) struct WalkTracer<'scene> {
    scene: &'scene Scene,
    field: &'scene LightField,
    volumes: &'scene [Option<Arc<SnowVolumes>>],
    surroundings: SnowQueries<'scene>,
    /// The lights of the present walk.
    lights: Vec<WalkLight>,
}

/// A walk in snow, with its path lengths there.
struct Walk<'v> {
    walk: SnowWalk,
    /// The exit along the first flight, where it is known.
    way_out: Option<Flight>,
    events: Skip<Cycle<Iter<'v, ScatteringEvent>>>,
    lengths: PathLengths,
    /// Whether nothing in the body has turned the walk yet.
    is_straight: bool,
    /// Reflections at solids so far.
    bounces: u32,
}

/// The snow that a walk is in.
#[derive(Clone, Copy)]
struct WalkMedium<'a> {
    object: usize,
    volume: &'a Volume,
    node: &'a VolumeNode,
    at: SnowAt<'a>,
    end_depth: EndDepth,
}

impl WalkMedium<'_> {
    fn medium(&self) -> Medium {
        Medium::Kind(self.at.kind)
    }
}

/// How a walk in a body ends.
enum BodyEnd {
    /// In the light field.
    Inside,
    /// Out of the snow, at a point of its surface.
    Outside(SurfacePoint),
    /// At a solid in the snow or in contact with it.
    Solid(SurfaceInteraction),
}

impl<'scene> WalkTracer<'scene> {
    pub(crate) fn new(
        scene: &'scene Scene,
        field: &'scene LightField,
        bodies: &'scene SnowBodies,
        volumes: &'scene [Option<Arc<SnowVolumes>>],
    ) -> Self {
        Self { scene, field, volumes, surroundings: SnowQueries::new(scene, bodies, volumes), lights: Vec::new() }
    }

    pub(crate) fn statistics(&self) -> Statistics {
        self.surroundings.statistics
    }

    /// Follows the walk of a ray that hits snow. Returns the radiance along the ray, in W m⁻² sr⁻¹ as a band density.
    pub(crate) fn walk(
        &mut self,
        at: SnowAt,
        surface: &SurfaceInteraction,
        camera_ray: &Ray,
        sampler: &mut Sampler,
    ) -> Spectrum {
        let (field, transport_length_m) = (at.field, at.optics.transport_length_m());
        let Some(volumes) = &self.volumes[surface.material] else { return Spectrum::ZERO };
        let volume = &volumes.volumes[at.kind];
        let end_depth = self.end_depth(at, surface);
        let snow = WalkMedium { object: surface.object, volume, node: &volume.nodes()[0], at, end_depth };
        let mut ray = *camera_ray;
        let Some(way_out) = self.surroundings.enter(surface, &mut ray) else {
            // The ray grazes a rim: the surface has no other side.
            return field.mean_radiance(&surface.surface_point());
        };
        let half_space_share = -(-way_out.length_m() / (HALF_SPACE_LENGTHS * transport_length_m)).exp_m1();
        self.sample_lights(&surface.surface_point(), sampler);
        let [pixel, sample] = sampler.address();
        let mut stream = Stream::new(pixel.into(), sample.into());
        let events = snow.node.events_from(stream.uniform());
        let mut walk = Walk {
            walk: SnowWalk::new(ray, stream),
            way_out: Some(way_out),
            events,
            lengths: PathLengths::default(),
            is_straight: true,
            bounces: 0,
        };
        self.surroundings.statistics.walks += 1;
        let entry = SurfacePoint { point: ray.origin, normal: surface.normal };
        let lights = self.lights_at(snow, &entry, &mut walk);
        let mut entering = Spectrum::ZERO;
        lights.iter().for_each(|light| entering += light.irradiance * at.optics.surface().escape(light.cos_incidence));
        let near = NearLight::new(at, &entry, end_depth.match_lengths(), &entering);
        let mut tangent = near
            .as_ref()
            .map(|near| TangentHalfSpace::new((at.optics, end_depth), near, (walk.walk.ray, surface.normal), lights));
        loop {
            let end = self.follow(&mut walk, snow, near.as_ref(), tangent.as_mut());
            if let Some(tangent) = tangent.take() {
                walk.walk.radiance += tangent.correction(surface.shading_normal) * half_space_share;
            }
            match end {
                BodyEnd::Inside => {
                    self.surroundings.statistics.walks_into_field += 1;
                    return walk.walk.radiance;
                }
                BodyEnd::Outside(surface) => {
                    let throughput = walk.walk.throughput * attenuation(snow.volume, &walk.lengths, 0.0);
                    let irradiance = near
                        .as_ref()
                        .map_or_else(|| field.diffuse_irradiance(&surface), |near| near.diffuse_irradiance(&surface));
                    walk.walk.radiance.add_product(FRAC_1_PI, &throughput, &irradiance);
                    if walk.is_straight {
                        let ahead = Ray::new(surface.point, camera_ray.direction);
                        let ahead = self.lights_ahead(ahead, &mut walk.walk.stream);
                        walk.walk.radiance.add_product(1.0, &throughput, &ahead);
                    }
                    return walk.walk.radiance;
                }
                BodyEnd::Solid(surface) => {
                    if !self.reflect(&mut walk, snow, &surface) {
                        return walk.walk.radiance;
                    }
                }
            }
        }
    }

    /// The depth at which walks end that enter at a point of a surface.
    fn end_depth(&self, at: SnowAt, surface: &SurfaceInteraction) -> EndDepth {
        let [below_m, radius_m] = BALL_LENGTHS.map(|lengths| lengths * at.optics.transport_length_m());
        let below = surface.point - surface.normal * below_m;
        let is_thick = self.scene.objects().holds_deeply(surface.object, below, radius_m);
        if is_thick { EndDepth::Thick } else { EndDepth::Thin }
    }

    /// Whether walks sample a light with extent: uniform skies and lamps inside snow are part of the light field.
    fn is_sampled(&self, index: usize, light: &Light) -> bool {
        !light.is_diffuse() && !self.field.is_inside(index)
    }

    /// The light of lamps with extent and of skies that a ray hits before any object. Sampling of lights begins at
    /// the first grain, so a walk without scattering has no other light of them. The sun counts as small, as in the
    /// reference.
    fn lights_ahead(&mut self, mut ray: Ray, stream: &mut Stream) -> Spectrum {
        let lights = self.scene.lights().iter().enumerate();
        let lights = lights.filter(|(index, light)| !light.is_small() && self.is_sampled(*index, light));
        let lights: Vec<&Light> = lights.map(|(_, light)| &**light).collect();
        let mut radiance = Spectrum::ZERO;
        if !lights.is_empty() {
            let visit = |Segment { ray, hit, .. }: &Segment| {
                let limit_m = hit.map_or(f32::INFINITY, |hit| hit.point.distance(ray.origin));
                let hits = lights.iter().filter_map(|light| light.full_hit_radiance(ray, limit_m));
                hits.for_each(|hit| radiance += hit.radiance);
            };
            self.surroundings.first_end(&mut ray, || narrow(stream.uniform()), visit);
        }
        radiance
    }

    /// Samples the lights as seen from the entry of a walk.
    fn sample_lights(&mut self, entry: &SurfacePoint, sampler: &mut Sampler) {
        self.lights.clear();
        for (index, light) in self.scene.lights().iter().enumerate() {
            let is_sampled = light.has_extent() && self.is_sampled(index, light);
            let mut add = |sample: Option<LightSample>| {
                self.lights.extend(sample.map(|sample| WalkLight { sample, power: light.power(&sample.origin) }));
            };
            if is_sampled {
                light.samples_at(&Directions::Cosine(*entry), sampler).into_iter().for_each(add);
            } else if !light.has_extent() {
                add(light.delta_sample());
            }
        }
    }

    /// The lights that shine on the entry of a walk.
    fn lights_at(&mut self, snow: WalkMedium, entry: &SurfacePoint, walk: &mut Walk) -> Vec<TangentLight> {
        let off_surface = off_surface(entry.point, entry.normal, self.scene.objects().reach_m(snow.object));
        let from = Ray::new(off_surface, entry.normal);
        let mut lights = Vec::new();
        for (index, WalkLight { sample, power }) in self.lights.iter().enumerate() {
            let Some(incident) = sample.incident_at(entry) else { continue };
            let chance = walk.walk.stream.uniform();
            if let Some(transmitted) = self.surroundings.transmitted(&from, &sample.origin, snow.medium(), chance) {
                lights.push(TangentLight::new(index, &incident, *power * transmitted));
            }
        }
        lights
    }

    /// Follows a walk in the body, and with the same random numbers in the half-space, until both have ended.
    fn follow(
        &mut self,
        walk: &mut Walk,
        snow: WalkMedium,
        near: Option<&NearLight>,
        mut tangent: Option<&mut TangentHalfSpace>,
    ) -> BodyEnd {
        let transport_length_m = snow.at.optics.transport_length_m();
        let mean_flight_m = snow.node.extinction_per_m().recip();
        let mut end: Option<BodyEnd> = None;
        loop {
            let flight_m = walk.walk.flight_m(mean_flight_m);
            if let Some(tangent) = &mut tangent {
                tangent.fly(&walk.walk.ray, flight_m);
            }
            if end.is_none() {
                self.surroundings.statistics.flights += 1;
                let flight = self.surroundings.fly(snow.object, &walk.walk.ray, flight_m, walk.way_out.take());
                walk.lengths.pores_m += f64::from(flight.length_m());
                end = match flight {
                    Flight::Free(_) => None,
                    Flight::Out { origin, normal, .. } => {
                        Some(BodyEnd::Outside(SurfacePoint { point: origin, normal }))
                    }
                    Flight::Solid(surface, _) => Some(BodyEnd::Solid(surface)),
                };
            }
            if let Some(end) = finished(&mut end, tangent.as_deref()) {
                return end;
            }
            walk.walk.ray.advance(flight_m);
            self.join_lights(walk, snow, end.is_none(), tangent.as_deref_mut());
            let Some(event) = walk.events.next() else { return BodyEnd::Inside };
            if end.is_none() {
                walk.lengths.ice_in_air_m += f64::from(event.ice_in_air_m);
                walk.lengths.ice_in_water_m += f64::from(event.ice_in_water_m);
            }
            walk.walk.turn(event.cos_scattering);
            walk.is_straight &= end.is_some();
            let ahead = walk.walk.ray.at(transport_length_m);
            let end_depth_m = snow.end_depth.lengths() * transport_length_m;
            if end.is_none() && self.scene.objects().holds_deeply(snow.object, walk.walk.ray.origin, end_depth_m) {
                let fluence = near.map_or_else(|| snow.at.field.fluence(ahead), |near| near.fluence(ahead));
                let through = walk.walk.throughput * attenuation(snow.volume, &walk.lengths, 0.0);
                walk.walk.radiance.add_product(0.25 * FRAC_1_PI, &through, &fluence);
                end = Some(BodyEnd::Inside);
            }
            if end.is_some()
                && let Some(tangent) = &mut tangent
            {
                tangent.end_below(&walk.walk.ray);
            }
            if let Some(end) = finished(&mut end, tangent.as_deref()) {
                return end;
            }
        }
    }

    /// Joins the lights to the scattering at the origin of a walk's ray: in the body if the walk is still there, and
    /// in the half-space.
    fn join_lights(
        &mut self,
        walk: &mut Walk,
        snow: WalkMedium,
        is_in_body: bool,
        mut tangent: Option<&mut TangentHalfSpace>,
    ) {
        for (index, light) in self.lights.iter().enumerate() {
            // A light contributes with the probability e^{−κd} that it is seen through snow of the depth d: deep
            // inside, there is nothing to compute.
            let chance = walk.walk.stream.uniform();
            let seen_m = narrow(-chance.ln() / snow.node.extinction_per_m());
            if let Some(tangent) = &mut tangent {
                tangent.join(index, &walk.walk.ray, seen_m);
            }
            if !is_in_body || self.surroundings.stays_inside(snow.object, &walk.walk.ray, &light.sample.origin, seen_m)
            {
                continue;
            }
            let found = light.scattered(&mut self.surroundings, snow.node, &walk.walk.ray, (snow.medium(), chance));
            if let Some(scattered) = found {
                let absorbed = attenuation(snow.volume, &walk.lengths, 0.0);
                walk.walk.radiance.add_product(1.0, &(walk.walk.throughput * absorbed), &scattered);
            }
        }
    }

    /// Reflects a walk at a solid in the snow or in contact with it. Returns false if the walk ends.
    fn reflect(&mut self, walk: &mut Walk, snow: WalkMedium, surface: &SurfaceInteraction) -> bool {
        if walk.walk.goes_on(&self.surroundings, surface) {
            walk.is_straight &= walk.walk.ray.direction == surface.direction;
            return true;
        }
        let material = &self.scene.materials()[surface.material];
        let Some(albedo) = material.albedo(self.scene.objects(), surface) else { return false };
        let reflectance = albedo * attenuation(snow.volume, &walk.lengths, 0.0);
        walk.lengths = PathLengths::default();
        walk.bounces += 1;
        walk.is_straight = false;
        let directions = Directions::Cosine(surface.surface_point());
        let at_surface = (&*self.lights, snow.medium(), walk.bounces);
        walk.walk.reflect(&mut self.surroundings, surface, (directions, |_| reflectance), at_surface)
    }
}

/// The end of the walk in the body, once the walk in the half-space has ended, too.
fn finished(end: &mut Option<BodyEnd>, tangent: Option<&TangentHalfSpace>) -> Option<BodyEnd> {
    end.take_if(|_| tangent.is_none_or(TangentHalfSpace::has_ended))
}
