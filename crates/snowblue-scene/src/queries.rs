//! Ray queries to the objects of a scene, with counts. Each thread has its own queries and counts.

use glam::Vec3A;
use snowblue_geometry::body::{Chord, Line, chord};
use snowblue_geometry::ray::{Crossing, Ray, SurfacePoint, off_surface};

use crate::material::Material;
use crate::objects::{Objects, Side, SurfaceInteraction, set_object};
use crate::transparency::{Segment, TransparentSurfaces};

/// Counts of a rendering.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Statistics {
    /// Samples of all pixels, including the samples that a pixel below its noise target repeats.
    pub samples: u64,
    /// Camera rays.
    pub camera_rays: u64,
    /// Rays from one surface to the next.
    pub indirect_rays: u64,
    /// Shadow rays.
    pub shadow_rays: u64,
    /// Lines through snow.
    pub depth_lines: u64,
    /// Lines through snow that crossed its surface an odd number of times, because the mesh is open. The last crossing
    /// is ignored, and with it the snow behind it.
    pub odd_depth_lines: u64,
    /// Random walks into snow.
    pub walks: u64,
    /// Random walks that ended in the light field inside the snow.
    pub walks_into_field: u64,
    /// Flights from grain to grain of all walks.
    pub flights: u64,
    /// Samples that are not numbers or too bright to be summed; they count as black.
    pub unusable_samples: u64,
}

impl Statistics {
    /// The sum of two counts.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            samples: self.samples + other.samples,
            camera_rays: self.camera_rays + other.camera_rays,
            indirect_rays: self.indirect_rays + other.indirect_rays,
            shadow_rays: self.shadow_rays + other.shadow_rays,
            depth_lines: self.depth_lines + other.depth_lines,
            odd_depth_lines: self.odd_depth_lines + other.odd_depth_lines,
            walks: self.walks + other.walks,
            walks_into_field: self.walks_into_field + other.walks_into_field,
            flights: self.flights + other.flights,
            unusable_samples: self.unusable_samples + other.unusable_samples,
        }
    }

    /// Rays and lines of all kinds.
    pub fn rays(&self) -> u64 {
        self.camera_rays + self.indirect_rays + self.shadow_rays + self.depth_lines
    }
}

/// Queries to the objects of a scene.
#[derive(Debug)]
pub struct SceneQueries<'scene> {
    objects: &'scene Objects,
    transparent: TransparentSurfaces<'scene>,
    /// Buffer for the crossings of one line.
    crossings: Vec<Crossing>,
    /// Counts of the queries so far.
    pub statistics: Statistics,
}

impl<'scene> SceneQueries<'scene> {
    /// Starts with zero counts.
    pub fn new(objects: &'scene Objects, materials: &'scene [Material]) -> Self {
        Self {
            objects,
            transparent: TransparentSurfaces::new(objects, materials),
            crossings: Vec::with_capacity(16),
            statistics: Statistics::default(),
        }
    }

    /// The objects of the scene.
    pub fn objects(&self) -> &'scene Objects {
        self.objects
    }

    /// The surface where a ray from the camera or from a surface ends, with the arguments of
    /// [`TransparentSurfaces::first_end`]. The caller counts the ray.
    #[inline]
    pub fn hit(
        &self,
        ray: &mut Ray,
        number: impl FnMut() -> f32,
        visit: impl FnMut(&Segment),
    ) -> Option<SurfaceInteraction> {
        self.transparent.first_end(ray, number, visit)
    }

    /// Origin of a ray that leaves an object's surface on the side of the normal.
    #[inline]
    pub fn off_surface(&self, object: usize, surface: &SurfacePoint) -> Vec3A {
        off_surface(surface.point, surface.normal, self.objects.reach_m(object))
    }

    /// The share of light that passes from a target to a point just off one side of a surface.
    #[inline]
    pub(crate) fn transmittance_to(&mut self, from: Vec3A, side: Side, target: Vec3A) -> f32 {
        let offset = target - from;
        let distance_m = offset.length();
        self.transmittance(&Ray::new(from, offset / distance_m), distance_m, side)
    }

    /// The share of light that passes from a distant light to a point just off one side of a surface.
    #[inline]
    pub(crate) fn transmittance_to_distant(&mut self, from: Vec3A, side: Side, direction: Vec3A) -> f32 {
        self.transmittance(&Ray::new(from, direction), f32::INFINITY, side)
    }

    #[inline]
    fn transmittance(&mut self, ray: &Ray, limit_m: f32, side: Side) -> f32 {
        self.statistics.shadow_rays += 1;
        let Self { objects, transparent, .. } = self;
        let is_opaque = |index: usize| objects.can_occlude(index, side) && !transparent.holds(index);
        if objects.occluded_by(ray, limit_m, is_opaque) { 0.0 } else { transparent.transmittance(ray, limit_m) }
    }

    /// Depth of a straight path through the solid that an object is or belongs to.
    #[inline]
    pub fn chord(&mut self, object: usize, line: &Line) -> Option<Chord> {
        self.statistics.depth_lines += 1;
        let ray = Ray::new(line.point, line.direction);
        if let Some(convex) = self.objects.convex(object) {
            let mut pair = convex.pair(&ray)?;
            set_object(object, &mut pair);
            return chord(std::iter::once(&pair), line);
        }
        let odd = self.objects.segments(object, &ray, line.end_m, &mut self.crossings);
        self.statistics.odd_depth_lines += u64::from(odd);
        Some(chord(self.crossings.as_chunks().0.iter(), line)?.with_unit_normal())
    }
}
