//! Queries along a path of light: flights through a body of snow, solids on the way, and transmittance towards a light.

use std::sync::Arc;

use glam::Vec3A;
use snowblue_base::narrow;
use snowblue_geometry::body::TOUCH_DISTANCE_M;
use snowblue_geometry::ray::{Crossing, Ray, ShapeHit, off_surface};
use snowblue_transport::monte_carlo::{PathLengths, Volume};
use snowblue_transport::rng::Stream;

use super::snow_volumes::{SnowVolumes, attenuation};
use snowblue_scene::Scene;
use snowblue_scene::light::LightOrigin;
use snowblue_scene::objects::{Object, Objects, SurfaceInteraction};
use snowblue_scene::queries::Statistics;
use snowblue_scene::spectrum::Spectrum;
use snowblue_scene::transparency::{Segment, TransparentSurfaces};

/// The bodies of snow of a scene, and the other objects.
#[derive(Debug)]
pub(crate) struct SnowBodies {
    bodies: Vec<BodyId>,
    /// Opaque objects that are not snow.
    solids: Vec<usize>,
    /// For each object of snow, the objects of other materials that may lie in its body or touch it.
    neighbours: Vec<Arc<[usize]>>,
}

/// A body of snow.
#[derive(Debug, Clone, Copy)]
pub(super) struct BodyId {
    /// Its first object.
    pub(super) object: usize,
    pub(super) material: usize,
}

impl SnowBodies {
    pub(crate) fn new(scene: &Scene) -> Self {
        let (objects, list) = (scene.objects(), scene.objects().list());
        let is_snow = |object: &Object| scene.materials()[object.material].is_snow();
        let others: Vec<usize> = (0..list.len()).filter(|&index| !is_snow(&list[index])).collect();
        let none: Arc<[usize]> = Arc::new([]);
        let (mut bodies, mut neighbours) = (Vec::new(), vec![none; list.len()]);
        for (index, object) in list.iter().enumerate() {
            let members = objects.body_of(index);
            if !is_snow(object) || members[0] != index {
                continue;
            }
            bodies.push(BodyId { object: index, material: object.material });
            // Flights cross all objects of a body.
            let is_near = |solid: &usize| members.iter().any(|member| may_touch(objects, *member, *solid));
            let near: Arc<[usize]> = others.iter().copied().filter(is_near).collect();
            members.iter().for_each(|member| neighbours[*member] = Arc::clone(&near));
        }
        let transparent = TransparentSurfaces::new(objects, scene.materials());
        let solids = others.into_iter().filter(|&index| !transparent.holds(index)).collect();
        Self { bodies, solids, neighbours }
    }
}

/// Whether the bounds of two objects touch or overlap.
fn may_touch(objects: &Objects, first: usize, second: usize) -> bool {
    match (objects.bounds(first), objects.bounds(second)) {
        (Some(first), Some(second)) => {
            (first.low - TOUCH_DISTANCE_M).cmple(second.high).all()
                && (second.low - TOUCH_DISTANCE_M).cmple(first.high).all()
        }
        _ => true,
    }
}

/// Queries from inside snow, counted. Each thread has its own.
#[derive(Debug)]
pub(super) struct SnowQueries<'a> {
    scene: &'a Scene,
    bodies: &'a SnowBodies,
    transparent: TransparentSurfaces<'a>,
    /// The snow of each material for walks; empty where there are none.
    volumes: &'a [Option<Arc<SnowVolumes>>],
    /// Whether all snow is known to be closed.
    is_closed: bool,
    crossings: Vec<Crossing>,
    /// Lengths of the present line to a light in each body of snow, in m.
    snow_m: Vec<f64>,
    pub(super) statistics: Statistics,
}

/// The snow on the way to a light.
#[derive(Debug, Clone, Copy)]
pub(super) enum Medium {
    /// One kind of snow: the kind at the point where the walk entered, or the last kind in bodies with fewer kinds.
    /// Unscattered light passes only a few mm of snow, and hardly any snow of another body.
    Kind(usize),
    /// The snow at each point, at a node of the refractive index.
    EachPlace {
        /// Number of the node.
        node: usize,
    },
}

impl Medium {
    /// The volume, and its node, that all snow of a body counts as; none if the snow at each point counts.
    fn volume_in(self, snow: &SnowVolumes) -> Option<(&Volume, usize)> {
        match (self, &*snow.volumes) {
            (Self::EachPlace { node }, [everywhere]) => Some((everywhere, node)),
            (Self::EachPlace { .. }, _) => None,
            (Self::Kind(kind), volumes) => volumes.get(kind).or(volumes.last()).map(|volume| (volume, 0)),
        }
    }
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

impl<'a> SnowQueries<'a> {
    pub(super) fn new(scene: &'a Scene, bodies: &'a SnowBodies, volumes: &'a [Option<Arc<SnowVolumes>>]) -> Self {
        Self {
            scene,
            bodies,
            transparent: TransparentSurfaces::new(scene.objects(), scene.materials()),
            volumes,
            is_closed: scene.integrator().kind.has_light_field(),
            crossings: Vec::with_capacity(16),
            snow_m: Vec::new(),
            statistics: Statistics::default(),
        }
    }

    fn objects(&self) -> &'a Objects {
        self.scene.objects()
    }

    /// Largest coordinate of an object in m.
    pub(super) fn reach_m(&self, object: usize) -> f32 {
        self.objects().reach_m(object)
    }

    /// The surface where a ray outside of snow ends, with the arguments of [`TransparentSurfaces::first_end`].
    pub(super) fn first_end(
        &mut self,
        ray: &mut Ray,
        number: impl FnMut() -> f32,
        visit: impl FnMut(&Segment),
    ) -> Option<SurfaceInteraction> {
        self.statistics.indirect_rays += 1;
        self.transparent.first_end(ray, number, visit)
    }

    /// The ray that goes on from a hit, with the arguments of [`TransparentSurfaces::onward`].
    pub(super) fn onward(&self, hit: &SurfaceInteraction, number: impl FnMut() -> f32) -> Option<Ray> {
        self.transparent.onward(hit, number)
    }

    /// Moves the origin of a ray that hits a body from outside to its entry point, and returns the flight to the
    /// exit.
    ///
    /// The search uses all crossings of the line, so that the result does not depend on the rounding of the hit
    /// point. It starts just before the hit point, because short distances have small rounding errors.
    pub(super) fn enter(&mut self, surface: &SurfaceInteraction, ray: &mut Ray) -> Option<Flight> {
        /// Distance before the hit point, as a fraction of the greatest coordinate: some rounding errors.
        const BEFORE: f32 = 1.0 / (1 << 18) as f32;
        let distance_m = surface.point.distance(ray.origin);
        let near_m = (distance_m - BEFORE * distance_m.max(self.reach_m(surface.object))).max(0.0);
        ray.advance(near_m);
        self.cross(surface.object, ray, f32::INFINITY);
        let pair = self.crossings.chunks_exact(2).find(|pair| pair[1].distance_m > 0.0)?;
        let (start_m, stop) = (pair[0].distance_m.max(-near_m), pair[1]);
        ray.advance(start_m);
        Some(self.out(ray, stop.distance_m - start_m, stop.normal, stop.object as usize))
    }

    /// A flight through a body of snow, of length `flight_m` or up to the body's surface or a solid. `known` is the
    /// flight to the surface, if known.
    pub(super) fn fly(&mut self, object: usize, ray: &Ray, flight_m: f32, known: Option<Flight>) -> Flight {
        let flight = match known {
            Some(flight) if flight.length_m() < flight_m => flight,
            Some(_) => Flight::Free(flight_m),
            None => self.fly_through_snow(object, ray, flight_m),
        };
        let list = self.objects().list();
        let touching_m = flight.length_m() + TOUCH_DISTANCE_M;
        let mut nearest: Option<(usize, ShapeHit)> = None;
        for &solid in &*self.bodies.neighbours[object] {
            // The next ray from outside of the snow finds transparent surfaces that only touch it.
            let most_m = if self.transparent.holds(solid) { flight.length_m() } else { touching_m };
            let limit_m = nearest.map_or(most_m, |(_, hit)| hit.distance_m.min(most_m));
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

    /// A flight through a body of snow without solids.
    #[inline]
    fn fly_through_snow(&mut self, object: usize, ray: &Ray, flight_m: f32) -> Flight {
        let alone = &self.objects().list()[object];
        if alone.body.is_none() {
            match alone.shape.first_hit(ray, flight_m) {
                // A ray from a point exactly on the surface may miss the surface by rounding.
                None if self.objects().bounds(object).is_some_and(|bounds| !bounds.contains(ray.at(flight_m))) => {
                    return Flight::Out { length_m: 0.0, origin: ray.origin, normal: ray.direction };
                }
                None => return Flight::Free(flight_m),
                Some(hit) if alone.shape.is_convex() => return self.out(ray, hit.distance_m, hit.normal, object),
                // The ray may pass into another shell of the mesh.
                Some(_) => {}
            }
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

    /// Whether the line from the origin of a ray to a light is still inside the object after `flight_m`. A quick test
    /// of the nearest face only; it returns false for bodies of several objects.
    #[inline]
    pub(super) fn stays_inside(&self, object: usize, from: &Ray, origin: &LightOrigin, flight_m: f32) -> bool {
        let (alone, to_light) = (&self.objects().list()[object], origin.direction_from(from.origin));
        let ray = from.towards(to_light.direction);
        alone.body.is_none() && flight_m < to_light.distance_m && !alone.shape.occludes(&ray, flight_m)
    }

    /// Optical depth of the snow and of transparent surfaces along the line from the origin of a ray to a light, by the
    /// extinction coefficient of each object's snow in 1/m; none behind solids, or where hardly any light is left.
    pub(super) fn optical_depth(
        &mut self,
        from: &Ray,
        origin: &LightOrigin,
        extinction_per_m: &dyn Fn(usize) -> f32,
    ) -> Option<f32> {
        /// Optical depth beyond which light is lost in rounding.
        const DARK: f32 = 20.0;
        let to_light = origin.direction_from(from.origin);
        let ray = from.towards(to_light.direction);
        self.statistics.shadow_rays += 1;
        let mut depth = 0.0;
        for &BodyId { object, .. } in &self.bodies.bodies {
            depth += extinction_per_m(object) * narrow(self.snow_m(object, &ray, to_light.distance_m));
            if depth > DARK {
                return None;
            }
        }
        let past_solids = self.transmittance_past_solids(&ray, to_light.distance_m);
        (past_solids > 0.0).then(|| depth - past_solids.ln())
    }

    /// The share of light on a ray that the objects of other materials than snow let pass within `limit_m`.
    fn transmittance_past_solids(&self, ray: &Ray, limit_m: f32) -> f32 {
        let list = self.objects().list();
        let is_occluded = self.bodies.solids.iter().any(|&solid| list[solid].shape.occludes(ray, limit_m));
        if is_occluded { 0.0 } else { self.transparent.transmittance(ray, limit_m) }
    }

    /// Transmittance along the line to a light from the origin of a ray, whose direction has no effect: none behind
    /// solids or, with probability 1 − e^{−κd} decided by `chance`, in snow; else the transmittance by absorption in
    /// the pores.
    pub(super) fn transmitted(
        &mut self,
        from: &Ray,
        origin: &LightOrigin,
        medium: Medium,
        chance: f64,
    ) -> Option<Spectrum> {
        let to_light = origin.direction_from(from.origin);
        let ray = from.towards(to_light.direction);
        self.statistics.shadow_rays += 1;
        let mut depth = 0.0;
        self.snow_m.clear();
        for body in &self.bodies.bodies {
            let Some(snow) = self.snow_of(*body) else { continue };
            let snow_m = self.snow_m(body.object, &ray, to_light.distance_m);
            self.snow_m.push(snow_m);
            depth += match medium.volume_in(snow) {
                Some((volume, node)) => volume.nodes()[node].extinction_per_m() * snow_m,
                None if self.collides(*body, medium, &ray, (to_light.distance_m, chance)) => return None,
                None => 0.0,
            };
            // `chance` is at least 2⁻⁵⁴ = e^{−37.4}, so deep in snow no exponential is needed.
            if depth > 38.0 || chance > (-depth).exp() {
                return None;
            }
        }
        let past_solids = self.transmittance_past_solids(&ray, to_light.distance_m);
        if past_solids <= 0.0 {
            return None;
        }
        let mut transmittance = Spectrum::constant(past_solids);
        let with_snow = self.bodies.bodies.iter().filter_map(|body| Some((body, self.snow_of(*body)?)));
        for ((body, snow), pores_m) in with_snow.zip(&self.snow_m) {
            let pores_m = *pores_m;
            let volume = match medium.volume_in(snow) {
                Some((volume, _)) => volume,
                // The pores of a few mm of snow absorb little light, so the snow at the start of the line suffices.
                None => {
                    &snow.volumes[snow.kinds.at_point(self.objects(), body.object, from.origin).pick(narrow(chance))]
                }
            };
            let lengths = PathLengths { pores_m, ..PathLengths::default() };
            transmittance *= attenuation(volume, &lengths, 0.0);
        }
        Some(transmittance)
    }

    /// Whether light on a line collides with a grain of a body whose snow varies, by delta tracking (Woodcock et al.
    /// 1965): free flights are drawn with the greatest extinction coefficient κ_max, and a share κ/κ_max of their
    /// ends are collisions. The random numbers follow from `chance`.
    fn collides(&self, body: BodyId, medium: Medium, ray: &Ray, (limit_m, chance): (f32, f64)) -> bool {
        let (Medium::EachPlace { node }, Some(snow)) = (medium, self.snow_of(body)) else { return false };
        let mut stream = Stream::new(chance.to_bits(), body.object as u64);
        let greatest_per_m = snow.greatest_extinction_per_m(node);
        // `snow_m` has left the segments of this body.
        for segment in self.crossings.chunks_exact(2) {
            let mut at_m = f64::from(segment[0].distance_m.max(0.0));
            let end_m = f64::from(segment[1].distance_m.min(limit_m));
            loop {
                at_m -= stream.uniform().ln() / greatest_per_m;
                if at_m >= end_m {
                    break;
                }
                let mix = snow.kinds.at_point(self.objects(), body.object, ray.at(narrow(at_m)));
                let kind = mix.pick(narrow(stream.uniform()));
                if stream.uniform() * greatest_per_m < snow.volumes[kind].nodes()[node].extinction_per_m() {
                    return true;
                }
            }
        }
        false
    }

    /// The snow of a body, if there are walks in it.
    fn snow_of(&self, body: BodyId) -> Option<&'a SnowVolumes> {
        self.volumes.get(body.material)?.as_deref()
    }

    /// Length of a ray inside a body of snow within `limit_m`, in m.
    #[inline]
    fn snow_m(&mut self, object: usize, ray: &Ray, limit_m: f32) -> f64 {
        self.cross(object, ray, limit_m);
        let part = |pair: &[Crossing]| (pair[1].distance_m.min(limit_m) - pair[0].distance_m.max(0.0)).max(0.0);
        self.crossings.chunks_exact(2).map(|pair| f64::from(part(pair))).sum()
    }

    /// Sets `crossings` to the segments of a line inside a body.
    fn cross(&mut self, object: usize, ray: &Ray, limit_m: f32) {
        self.statistics.depth_lines += 1;
        let (objects, crossings) = (self.scene.objects(), &mut self.crossings);
        let odd = if self.is_closed {
            objects.segments_of_closed(object, ray, limit_m, crossings)
        } else {
            objects.segments(object, ray, limit_m, crossings)
        };
        self.statistics.odd_depth_lines += u64::from(odd);
    }
}
