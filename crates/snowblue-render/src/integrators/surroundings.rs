//! Queries along a path of light: flights through a body of snow, solids on the way, and transmittance towards a light.

use glam::Vec3A;

use crate::geometry::body::{TOUCH_DISTANCE_M, pair_up};
use crate::geometry::ray::{Crossing, Ray, ShapeHit, narrow, off_surface};
use crate::scene::Scene;
use crate::scene::light::LightOrigin;
use crate::scene::objects::{Object, Objects, SurfaceInteraction};
use crate::scene::queries::Statistics;
use crate::spectrum::Spectrum;
use snowblue_transport::monte_carlo::{PathLengths, Volume};

/// The objects of a scene, sorted for queries from inside snow.
#[derive(Debug)]
pub(super) struct Surroundings<'scene> {
    scene: &'scene Scene,
    /// The bodies of snow.
    bodies: Vec<SnowBody>,
    /// Objects that are not snow.
    solids: Vec<usize>,
    /// For each object of snow, the solids that may lie in it or touch it.
    neighbours: Vec<Vec<usize>>,
    crossings: Vec<Crossing>,
    pub(super) statistics: Statistics,
}

/// A body of snow.
#[derive(Debug, Clone, Copy)]
struct SnowBody {
    /// Its first object.
    object: usize,
    material: usize,
}

/// The snow on the way to a light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Medium {
    /// The layer that a path is in. Light passes a few mm of snow unscattered, and hardly any of another body.
    pub(super) layer: usize,
    /// Number of the index node.
    pub(super) node: usize,
}

/// How a flight in snow ends.
pub(super) enum Flight {
    /// At a grain, after a length in m.
    Free(f32),
    /// Out of the snow, after a length in m, with a point just outside and the outward normal.
    Out { length_m: f32, origin: Vec3A, normal: Vec3A },
    /// At a solid, after a length in m.
    Solid(SurfaceInteraction, f32),
}

impl Flight {
    pub(super) fn length_m(&self) -> f32 {
        match self {
            Self::Free(length_m) | Self::Out { length_m, .. } | Self::Solid(_, length_m) => *length_m,
        }
    }
}

impl<'scene> Surroundings<'scene> {
    pub(super) fn new(scene: &'scene Scene) -> Self {
        let list = scene.objects.list();
        let is_snow = |object: &Object| scene.materials[object.material].is_snow();
        let solids: Vec<usize> = (0..list.len()).filter(|&index| !is_snow(&list[index])).collect();
        let is_first = |index: usize| {
            let body = &list[index].body;
            body.is_none() || list.iter().position(|other| other.body == *body) == Some(index)
        };
        let bodies = (0..list.len()).filter(|&index| is_snow(&list[index]) && is_first(index));
        let are_near = |index: usize, solid: usize| match (scene.objects.bounds(index), scene.objects.bounds(solid)) {
            (Some(one), Some(other)) => {
                (one.low - TOUCH_DISTANCE_M).cmple(other.high).all()
                    && (other.low - TOUCH_DISTANCE_M).cmple(one.high).all()
            }
            _ => true,
        };
        // Flights cross all objects of a body.
        let near = |index: usize| {
            let is_near = |solid: &usize| scene.objects.body_of(index).iter().any(|member| are_near(*member, *solid));
            if is_snow(&list[index]) { solids.iter().copied().filter(is_near).collect() } else { Vec::new() }
        };
        Self {
            scene,
            bodies: bodies.map(|object| SnowBody { object, material: list[object].material }).collect(),
            neighbours: (0..list.len()).map(near).collect(),
            solids,
            crossings: Vec::with_capacity(16),
            statistics: Statistics::default(),
        }
    }

    fn objects(&self) -> &'scene Objects {
        &self.scene.objects
    }

    /// First hit of a ray outside of snow.
    pub(super) fn first_hit(&mut self, ray: &Ray) -> Option<SurfaceInteraction> {
        self.statistics.indirect_rays += 1;
        self.objects().first_hit(ray)
    }

    /// Moves the origin of a ray that hits a body from outside to where it enters, and returns the flight to the other
    /// side.
    ///
    /// It uses all crossings of the whole line, so that the result does not depend on the rounding of the hit point.
    pub(super) fn enter(&mut self, surface_object: usize, ray: &mut Ray) -> Option<Flight> {
        self.cross(surface_object, ray, f32::INFINITY);
        let pair = self.crossings.chunks_exact(2).find(|pair| pair[1].distance_m > 0.0)?;
        let (start_m, stop) = (pair[0].distance_m.max(0.0), pair[1]);
        ray.origin = ray.at(start_m);
        Some(self.out(ray, stop.distance_m - start_m, stop.normal, stop.object as usize))
    }

    /// A flight through a body of snow, of length `flight_m` or to its surface or a solid. `known` is the flight to the
    /// surface if it is known.
    pub(super) fn fly(&mut self, object: usize, ray: &Ray, flight_m: f32, known: Option<Flight>) -> Flight {
        let flight = match known {
            Some(flight) if flight.length_m() < flight_m => flight,
            Some(_) => Flight::Free(flight_m),
            None => self.fly_through_snow(object, ray, flight_m),
        };
        let list = self.objects().list();
        let touching_m = flight.length_m() + TOUCH_DISTANCE_M;
        let mut nearest: Option<(usize, ShapeHit)> = None;
        for &solid in &self.neighbours[object] {
            let limit_m = nearest.map_or(touching_m, |(_, hit)| hit.distance_m);
            nearest = list[solid].shape.first_hit(ray, limit_m).map(|hit| (solid, hit)).or(nearest);
        }
        let Some((solid, hit)) = nearest.filter(|(_, hit)| !matches!(flight, Flight::Free(m) if m <= hit.distance_m))
        else {
            return flight;
        };
        let normal = if hit.normal.dot(ray.direction) <= 0.0 { hit.normal } else { -hit.normal };
        let (direction, location) = (ray.direction, hit.location);
        let surface = SurfaceInteraction {
            object: solid,
            material: list[solid].material,
            point: hit.point,
            normal,
            shading_normal: list[solid].shape.shading_normal(&location, normal, direction),
            direction,
            location,
        };
        Flight::Solid(surface, hit.distance_m)
    }

    /// The same without solids.
    #[inline]
    fn fly_through_snow(&mut self, object: usize, ray: &Ray, flight_m: f32) -> Flight {
        let one = &self.objects().list()[object];
        if one.body.is_none() {
            return match one.shape.first_hit(ray, flight_m) {
                // From a point on the very surface, a ray may miss it by rounding.
                None if self.objects().bounds(object).is_some_and(|bounds| !bounds.contains(ray.at(flight_m))) => {
                    Flight::Out { length_m: 0.0, origin: ray.origin, normal: ray.direction }
                }
                None => Flight::Free(flight_m),
                Some(hit) => self.out(ray, hit.distance_m, hit.normal, object),
            };
        }
        self.cross(object, ray, flight_m);
        let around = |pair: &&[Crossing]| pair[0].distance_m <= TOUCH_DISTANCE_M && pair[1].distance_m > 0.0;
        match self.crossings.chunks_exact(2).find(around).map(|pair| pair[1]) {
            Some(stop) if stop.distance_m > flight_m => Flight::Free(flight_m),
            Some(stop) => self.out(ray, stop.distance_m, stop.normal, stop.object as usize),
            None => Flight::Out { length_m: 0.0, origin: ray.origin, normal: ray.direction },
        }
    }

    /// A flight that leaves through a face.
    fn out(&self, ray: &Ray, length_m: f32, normal: Vec3A, object: usize) -> Flight {
        let normal = normal.normalize();
        let outward = if normal.dot(ray.direction) < 0.0 { -normal } else { normal };
        let origin = off_surface(ray.at(length_m), outward, self.objects().reach_m(object));
        Flight::Out { length_m, origin, normal: outward }
    }

    /// Whether the line to a light is still inside the object after `flight_m`. A quick test of the nearest face only;
    /// it returns false for bodies of several objects.
    #[inline]
    pub(super) fn stays_inside(&self, object: usize, from: Vec3A, origin: &LightOrigin, flight_m: f32) -> bool {
        let (one, to_light) = (&self.objects().list()[object], origin.direction_from(from));
        let ray = Ray { origin: from, direction: to_light.direction };
        one.body.is_none() && flight_m < to_light.distance_m && !one.shape.occludes(&ray, flight_m)
    }

    /// Optical depth of the snow along the line to a light, by the extinction coefficient of each object's snow in 1/m;
    /// none behind solids. It stops counting where nothing is left.
    pub(super) fn optical_depth(
        &mut self,
        from: Vec3A,
        origin: &LightOrigin,
        extinction_per_m: &dyn Fn(usize) -> f32,
    ) -> Option<f32> {
        /// Depth beyond which light is lost in rounding.
        const DARK: f32 = 20.0;
        let to_light = origin.direction_from(from);
        let ray = Ray { origin: from, direction: to_light.direction };
        self.statistics.shadow_rays += 1;
        let mut depth = 0.0;
        for index in 0..self.bodies.len() {
            let object = self.bodies[index].object;
            depth += extinction_per_m(object) * narrow(self.snow_m(object, &ray, to_light.distance_m));
            if depth > DARK {
                return None;
            }
        }
        (!self.is_behind_solid(&ray, to_light.distance_m)).then_some(depth)
    }

    fn is_behind_solid(&self, ray: &Ray, limit_m: f32) -> bool {
        let list = self.objects().list();
        self.solids.iter().any(|&solid| list[solid].shape.occludes(ray, limit_m))
    }

    /// Transmittance along the line to a light: none behind solids or, with probability 1 − e^{−κd} decided by
    /// `chance`, in snow; else what the pores do not absorb.
    pub(super) fn transmitted(
        &mut self,
        from: Vec3A,
        origin: &LightOrigin,
        medium: Medium,
        chance: f64,
    ) -> Option<Spectrum> {
        let to_light = origin.direction_from(from);
        let ray = Ray { origin: from, direction: to_light.direction };
        self.statistics.shadow_rays += 1;
        let mut depth = 0.0;
        for index in 0..self.bodies.len() {
            let body = self.bodies[index];
            if let Some(volume) = self.volume(body, medium) {
                let snow_m = self.snow_m(body.object, &ray, to_light.distance_m);
                depth += volume.nodes()[medium.node].extinction_per_m() * snow_m;
            }
            // `chance` is at least 2⁻⁵⁴ = e^{−37.4}, so deep in snow no exponential is needed.
            if depth > 38.0 || chance > (-depth).exp() {
                return None;
            }
        }
        if self.is_behind_solid(&ray, to_light.distance_m) {
            return None;
        }
        let mut transmittance = Spectrum::ONE;
        for index in 0..self.bodies.len() {
            let body = self.bodies[index];
            if let Some(volume) = self.volume(body, medium) {
                let pores_m = self.snow_m(body.object, &ray, to_light.distance_m);
                let mut attenuation = Spectrum::ZERO;
                volume.attenuation(&PathLengths { pores_m, ..PathLengths::default() }, 0.0, &mut attenuation.0);
                transmittance *= attenuation;
            }
        }
        Some(transmittance)
    }

    /// The snow of a body: that of the layer, or its last one.
    fn volume(&self, body: SnowBody, medium: Medium) -> Option<&'scene Volume> {
        let layers = &self.scene.volumes[body.material];
        layers.get(medium.layer).or(layers.last())
    }

    /// Length of a ray inside a body of snow within `limit_m`, in m.
    #[inline]
    fn snow_m(&mut self, object: usize, ray: &Ray, limit_m: f32) -> f64 {
        self.cross(object, ray, limit_m);
        let part = |pair: &[Crossing]| (pair[1].distance_m.min(limit_m) - pair[0].distance_m.max(0.0)).max(0.0);
        self.crossings.chunks_exact(2).map(|pair| f64::from(part(pair))).sum()
    }

    /// Sets `crossings` to the segments of a line inside a body, as ordered pairs.
    fn cross(&mut self, object: usize, ray: &Ray, limit_m: f32) {
        self.statistics.depth_lines += 1;
        let odd = self.objects().crossings(object, ray, limit_m, &mut self.crossings);
        self.statistics.odd_depth_lines += u64::from(odd);
        pair_up(&mut self.crossings, 0);
    }
}
