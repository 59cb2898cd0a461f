//! Light from grain to grain: what a picture of snow is without PCASnow's straight lines, a slab's curves, or light that
//! leaves snow alike in all directions. Slow, and true on average: PCASnow is measured by it.
//!
//! A path runs backwards from the camera, which reciprocity allows, since a grain's phase function depends on the angle
//! alone. Where it enters snow there is no step of the index; it goes on by free flights, t = −ln u / κ, from grain to
//! grain ([`Volume`](snowblue_transport::monte_carlo::Volume)), until it leaves. From each scattering every lamp without
//! extent is joined (next-event estimation; Veach 1997, *Robust Monte Carlo Methods for Light Transport Simulation*,
//! chapter 8):
//!
//! L += β(λ) P(cos Θ; λ) e^{−κd} V I(λ)/r²,   β(λ) = e^{−γ(λ)ℓ},
//!
//! ℓ being the path through ice so far, d that through snow to the lamp, and V whether it is free else. Lamps with extent
//! and skies are met by the path itself. Three things make that bearable, and none of them changes a mean:
//!
//! - e^{−κd} is the chance with which a lamp is joined at all: nothing more need be worked out deep in snow.
//! - So is the absorption of the least absorbed wavelength the chance with which a path goes on; the others are weighed.
//! - Grains are met beforehand, and paths go along their list from random places on: flights and azimuths are each one's own.
//!
//! All wavelengths go one way but for the index of ice: a sample is a walk at each of a few indices, with the same random
//! numbers, and the wavelengths are composed of these.
//!
//! Simplified: a solid that touches snow is the snow's neighbour, with no air between; where two bodies of snow overlap,
//! light is in the one that it entered. Roulette on dark paints as in [`path`](crate::integrators::pcasnow).

mod surroundings;

use glam::Vec3A;
use snowblue_transport::monte_carlo::{PathLengths, ScatteringEvent, Volume, VolumeNode};
use snowblue_transport::rng::Stream;

use crate::geometry::ray::{Ray, SurfacePoint, narrow, off_surface};
use crate::integrators::survival_probability;
use crate::sampling::{Sampler, cosine_direction};
use crate::scene::Scene;
use crate::scene::light::{Light, LightHit, LightSample};
use crate::scene::material::Material;
use crate::scene::material::diffuse::Diffuse;
use crate::scene::objects::SurfaceInteraction;
use crate::scene::queries::Statistics;
use crate::spectrum::{SAMPLES, Spectrum};

use surroundings::{Leg, Surroundings};

/// Follows light from grain to grain.
#[derive(Debug)]
pub(crate) struct ReferenceIntegrator<'scene> {
    scene: &'scene Scene,
    surroundings: Surroundings<'scene>,
    /// Lights without extent.
    delta_lights: Vec<DeltaLight>,
    sees_lights: bool,
    /// What the index nodes count for the wavelengths; a scene without snow has one.
    weights: Vec<Spectrum>,
}

/// A light without extent.
#[derive(Debug, Clone, Copy)]
struct DeltaLight {
    sample: LightSample,
    power: Spectrum,
}

impl DeltaLight {
    fn new(light: &Light) -> Option<Self> {
        let sample = light.delta_sample()?;
        Some(Self { sample, power: light.power(&sample.origin) })
    }
}

/// A path of light on its way.
struct Walk {
    ray: Ray,
    /// A direction across that turns with the ray, from which azimuths are counted: a small change of the index then
    /// changes the whole way but little.
    side: Vec3A,
    stream: Stream,
    node: usize,
    throughput: Spectrum,
    radiance: Spectrum,
}

/// How a path's stay in snow ends.
enum End {
    /// Absorbed.
    Dark,
    /// Out of the snow.
    Outside,
    /// Nowhere in it: the surface has no other side on the path's line, being open, or a rim that the path grazes.
    Missed,
    /// On something in the snow or beside it.
    Met(SurfaceInteraction),
}

impl<'scene> ReferenceIntegrator<'scene> {
    /// A tracer that has not traced anything.
    pub(crate) fn new(scene: &'scene Scene) -> Self {
        let volume = scene.volumes.iter().flatten().next();
        let weights = |node: &VolumeNode| Spectrum(std::array::from_fn(|k| node.weights()[k]));
        Self {
            scene,
            surroundings: Surroundings::new(scene),
            delta_lights: scene.lights.iter().filter_map(DeltaLight::new).collect(),
            sees_lights: scene.lights.iter().any(Light::has_extent),
            weights: volume.map_or(vec![Spectrum::ONE], |volume| volume.nodes().iter().map(weights).collect()),
        }
    }

    /// What was traced so far.
    pub(crate) fn statistics(&self) -> Statistics {
        self.surroundings.statistics
    }

    /// One sample of the radiance that arrives along a camera ray, in W m⁻² sr⁻¹ as a band density.
    pub(crate) fn radiance(&mut self, camera_ray: &Ray, sampler: &Sampler) -> Spectrum {
        let [pixel, sample] = sampler.address();
        self.surroundings.statistics.camera_rays += 1;
        let mut radiance = Spectrum::ZERO;
        for node in 0..self.weights.len() {
            let mut walk = Walk {
                ray: *camera_ray,
                side: camera_ray.direction.any_orthonormal_vector(),
                stream: Stream::new(pixel.into(), sample.into()),
                node,
                throughput: Spectrum::ONE,
                radiance: Spectrum::ZERO,
            };
            self.follow(&mut walk);
            radiance.add_product(1.0, &self.weights[node], &walk.radiance);
        }
        radiance
    }

    /// Follows a path to its end.
    fn follow(&mut self, walk: &mut Walk) {
        let mut met = self.surroundings.first_hit(&walk.ray);
        self.add_seen_lights(walk, met.as_ref());
        // The object in whose snow the path is.
        let mut within = None;
        for bounce in 0..=self.scene.integrator.max_bounces {
            let Some(surface) = met else { return };
            match &self.scene.materials[surface.material] {
                Material::Diffuse(diffuse) => {
                    if !self.bounce(walk, diffuse, &surface, bounce) {
                        return;
                    }
                }
                Material::PcaSnow(_) => within = Some((surface.object, surface.material)),
            }
            if let Some(snow) = within {
                let entering = matches!(self.scene.materials[surface.material], Material::PcaSnow(_));
                match self.through_snow(walk, snow, entering) {
                    End::Dark => return,
                    End::Missed => {
                        let reach_m = self.scene.objects.reach_m(surface.object);
                        walk.ray.origin = off_surface(surface.point, -surface.normal, reach_m);
                        within = None;
                    }
                    End::Met(surface) => {
                        met = Some(surface);
                        continue;
                    }
                    End::Outside => within = None,
                }
            }
            met = self.surroundings.first_hit(&walk.ray);
            let limit_m = met.map_or(f32::INFINITY, |surface| surface.point.distance(walk.ray.origin));
            self.add_lights(walk, limit_m, None);
        }
    }

    /// Joins the lamps from a painted surface and sends the path on from there; false if it ends.
    fn bounce(&mut self, walk: &mut Walk, diffuse: &Diffuse, surface: &SurfaceInteraction, bounce: u32) -> bool {
        let reflectance = diffuse.reflectance(&self.scene.objects, surface);
        walk.throughput *= reflectance;
        let reach_m = self.scene.objects.reach_m(surface.object);
        let from = off_surface(surface.point, surface.normal, reach_m);
        for index in 0..self.delta_lights.len() {
            let (DeltaLight { sample, power }, chance) = (self.delta_lights[index], walk.stream.uniform());
            let place = SurfacePoint { point: surface.point, normal: surface.normal };
            if let Some(incident) = sample.incident_at(&place)
                && let Some(passed) = self.surroundings.passed(from, &sample.origin, walk.node, chance)
            {
                let factor = incident.irradiance_per_power * std::f32::consts::FRAC_1_PI;
                walk.radiance.add_product(factor, &(walk.throughput * passed), &power);
            }
        }
        let [u, v, chance] = [(); 3].map(|()| narrow(walk.stream.uniform()));
        let direction = cosine_direction(surface.normal, u, v);
        let survival = survival_probability(bounce, &walk.throughput);
        if chance >= survival {
            return false;
        }
        walk.throughput = walk.throughput * survival.recip();
        walk.ray = Ray { origin: from, direction };
        walk.side = direction.any_orthonormal_vector();
        true
    }

    /// From grain to grain through an object's snow, on its surface at first or within it.
    fn through_snow(&mut self, walk: &mut Walk, (object, material): (usize, usize), entering: bool) -> End {
        let Some(volume) = &self.scene.volumes[material] else { return End::Dark };
        let node = &volume.nodes()[walk.node];
        let mean_flight_m = node.extinction_per_m().recip();
        let mut way = PathLengths::default();
        // What chance lets a path pay of the least absorption.
        let fortune = -walk.stream.uniform().ln();
        let mut grains = grains_from(node.events(), walk.stream.uniform());
        let mut left_m = None;
        if entering {
            left_m = self.surroundings.enter(object, &mut walk.ray);
            if left_m.is_none() {
                return End::Missed;
            }
        }
        loop {
            let flight_m = narrow(-walk.stream.uniform().ln() * mean_flight_m);
            let leg = self.surroundings.leg(object, &walk.ray, flight_m, left_m.take());
            let length_m = leg.length_m();
            self.add_lights(walk, length_m, Some((volume, &way)));
            way.pores_m += f64::from(length_m);
            if volume.least_absorption(&way) > fortune {
                return End::Dark;
            }
            if let Leg::Flown(_) = leg {
                walk.ray.origin = walk.ray.at(length_m);
                self.join_lamps(walk, object, volume, &way);
                let Some(grain) = grains.next() else { return End::Dark };
                way.ice_in_air_m += f64::from(grain.ice_in_air_m);
                way.ice_in_water_m += f64::from(grain.ice_in_water_m);
                walk.turn(grain.cos_scattering);
                if volume.least_absorption(&way) > fortune {
                    return End::Dark;
                }
                continue;
            }
            walk.throughput *= left(volume, &way, volume.least_absorption(&way));
            return match leg {
                Leg::Out { origin, .. } => {
                    walk.ray.origin = origin;
                    End::Outside
                }
                Leg::Met(surface, _) => End::Met(surface),
                Leg::Flown(_) => End::Dark,
            };
        }
    }

    /// The light that lamps without extent send to the end of a flight, and a grain there into the path.
    fn join_lamps(&mut self, walk: &mut Walk, object: usize, volume: &Volume, way: &PathLengths) {
        for index in 0..self.delta_lights.len() {
            let (DeltaLight { sample, power }, chance) = (self.delta_lights[index], walk.stream.uniform());
            let point = walk.ray.origin;
            let mean_flight_m = volume.nodes()[walk.node].extinction_per_m().recip();
            if self.surroundings.stays(object, point, &sample.origin, narrow(-chance.ln() * mean_flight_m)) {
                continue;
            }
            let Some(passed) = self.surroundings.passed(point, &sample.origin, walk.node, chance) else { continue };
            let direction = sample.origin.direction_from(point).direction;
            let Some(incident) = sample.incident_at(&SurfacePoint { point, normal: direction }) else { continue };
            let phase = volume.nodes()[walk.node].phase_per_sr(f64::from(walk.ray.direction.dot(direction)));
            let mut share = walk.throughput * left(volume, way, volume.least_absorption(way)) * passed;
            share.0.iter_mut().zip(phase).for_each(|(share, phase)| *share *= phase);
            walk.radiance.add_product(incident.irradiance_per_power, &share, &power);
        }
    }

    /// The lights with extent that the camera's ray meets.
    fn add_seen_lights(&self, walk: &mut Walk, met: Option<&SurfaceInteraction>) {
        let limit_m = met.map_or(f32::INFINITY, |surface| surface.point.distance(walk.ray.origin));
        for light in &self.scene.lights {
            if let Some(radiance) = light.hit_radiance(&walk.ray, limit_m, None) {
                walk.radiance += radiance;
            }
        }
    }

    /// The lights with extent on the next `limit_m` of a path, in snow after a way there.
    #[inline]
    fn add_lights(&self, walk: &mut Walk, limit_m: f32, snow: Option<(&Volume, &PathLengths)>) {
        if !self.sees_lights {
            return;
        }
        for LightHit { radiance, distance_m } in
            self.scene.lights.iter().filter_map(|light| light.full_hit_radiance(&walk.ray, limit_m))
        {
            let share = snow.map_or(Spectrum::ONE, |(volume, way)| {
                let to_lamp = PathLengths { pores_m: way.pores_m + f64::from(distance_m), ..*way };
                left(volume, &to_lamp, volume.least_absorption(way))
            });
            walk.radiance.add_product(1.0, &(walk.throughput * share), &radiance);
        }
    }
}

impl Walk {
    /// Turns the ray by an angle, about a random azimuth.
    #[inline]
    fn turn(&mut self, cos_scattering: f32) {
        let (sin_turn, cos_turn) = (std::f32::consts::TAU * narrow(self.stream.uniform())).sin_cos();
        let ahead = self.ray.direction;
        let aside = self.side * cos_turn + ahead.cross(self.side) * sin_turn;
        let sin_scattering = (1.0 - cos_scattering * cos_scattering).max(0.0).sqrt();
        self.ray.direction = renormalized(ahead * cos_scattering + aside * sin_scattering);
        let side = aside * cos_scattering - ahead * sin_scattering;
        self.side = renormalized(side - self.ray.direction * self.ray.direction.dot(side));
    }
}

/// A vector of nearly unit length at unit length: one step of Newton's for 1/√x from 1 on.
#[inline]
fn renormalized(vector: Vec3A) -> Vec3A {
    vector * (1.5 - 0.5 * vector.length_squared())
}

/// The grains of a list from a random place on, again and again.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative, and below the length")]
fn grains_from(events: &[ScatteringEvent], chance: f64) -> impl Iterator<Item = &ScatteringEvent> {
    events.iter().cycle().skip((chance * events.len() as f64) as usize)
}

/// What is left of each wavelength after a way through snow, with some absorption already paid.
fn left(volume: &Volume, way: &PathLengths, paid: f64) -> Spectrum {
    let mut left = Spectrum([0.0; SAMPLES]);
    volume.attenuation(way, paid, &mut left.0);
    left
}
