//! One thread's way of asking the scene: counts what it asks and keeps the room for the answers.

mod lanes;
#[cfg(test)]
mod tests;

use glam::Vec3A;

use crate::geometry::chord::{Chord, Exit, Line, chord, parts};
use crate::geometry::ray::{Crossing, Ray, off_surface};
use crate::scene::objects::{Objects, Side, SurfaceInteraction, name_crossings};

pub(crate) use lanes::{Chords, Lines, Surfaces};

/// What a rendering did, in counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Statistics {
    /// Rays from the camera.
    pub camera_rays: u64,
    /// Rays from surface to surface.
    pub indirect_rays: u64,
    /// Rays towards lights.
    pub shadow_rays: u64,
    /// Lines through snow.
    pub depth_lines: u64,
    /// Lines through snow that crossed its surface an odd number of times: the mesh is open there. The last crossing
    /// was left out, and with it whatever lay behind.
    pub odd_depth_lines: u64,
    /// Samples of pixels that are no number or too bright to be added up; they count as dark.
    pub unusable_samples: u64,
}

impl Statistics {
    /// The counts of two parts of a picture together.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            camera_rays: self.camera_rays + other.camera_rays,
            indirect_rays: self.indirect_rays + other.indirect_rays,
            shadow_rays: self.shadow_rays + other.shadow_rays,
            depth_lines: self.depth_lines + other.depth_lines,
            odd_depth_lines: self.odd_depth_lines + other.odd_depth_lines,
            unusable_samples: self.unusable_samples + other.unusable_samples,
        }
    }

    /// Rays and lines of all kinds.
    pub fn rays(&self) -> u64 {
        self.camera_rays + self.indirect_rays + self.shadow_rays + self.depth_lines
    }
}

/// Asks the objects of a scene, and counts.
#[derive(Debug)]
pub(crate) struct SceneQueries<'scene> {
    objects: &'scene Objects,
    crossings: Vec<Crossing>,
    /// What was asked so far.
    pub(crate) statistics: Statistics,
}

impl<'scene> SceneQueries<'scene> {
    /// A probe that has asked nothing.
    pub(crate) fn new(objects: &'scene Objects) -> Self {
        Self { objects, crossings: Vec::with_capacity(16), statistics: Statistics::default() }
    }

    /// The objects that are asked.
    pub(crate) fn objects(&self) -> &'scene Objects {
        self.objects
    }

    /// What a ray from the camera hits first.
    pub(crate) fn camera_hit(&mut self, ray: &Ray) -> Option<SurfaceInteraction> {
        self.statistics.camera_rays += 1;
        self.objects.first_hit(ray)
    }

    /// What a ray that leaves a surface hits first.
    pub(crate) fn indirect_hit(&mut self, ray: &Ray) -> Option<SurfaceInteraction> {
        self.statistics.indirect_rays += 1;
        self.objects.first_hit(ray)
    }

    /// A point of an object's surface moved off it towards `normal`, for a ray to start from.
    pub(crate) fn off_surface(&self, object: usize, point: Vec3A, normal: Vec3A) -> Vec3A {
        off_surface(point, normal, self.objects.reach_m(object))
    }

    /// Whether a place is seen from a point off a surface.
    pub(crate) fn sees(&mut self, from: Vec3A, side: Side, target: Vec3A) -> bool {
        let way = target - from;
        let distance_m = way.length();
        self.is_free(&Ray { origin: from, direction: way / distance_m }, distance_m, side)
    }

    /// Whether nothing lies in a direction from a point off a surface.
    pub(crate) fn sees_far(&mut self, from: Vec3A, side: Side, direction: Vec3A) -> bool {
        self.is_free(&Ray { origin: from, direction }, f32::INFINITY, side)
    }

    fn is_free(&mut self, ray: &Ray, limit_m: f32, side: Side) -> bool {
        self.statistics.shadow_rays += 1;
        !self.objects.occluded(ray, limit_m, side)
    }

    /// The depth of a straight path through the solid that an object is or belongs to.
    pub(crate) fn chord(&mut self, object: usize, line: &Line, exit: Exit) -> Option<Chord> {
        self.statistics.depth_lines += 1;
        let ray = Ray { origin: line.point, direction: line.direction };
        if let Some(convex) = self.objects.convex(object) {
            let mut pair = convex.pair(&ray)?;
            name_crossings(object, &mut pair);
            return chord(std::iter::once(&pair), line, exit);
        }
        let odd = self.objects.crossings(object, &ray, line.end_m, &mut self.crossings);
        self.statistics.odd_depth_lines += u64::from(odd);
        Some(chord(parts(&mut self.crossings), line, exit)?.with_unit_normal())
    }
}
