//! One thread's way of asking the scene: counts what it asks and keeps the room for the answers.

use glam::Vec3A;

use crate::chord::{Chord, Exit, Line, chord};
use crate::objects::{Objects, Surface};
use crate::ray::{Crossing, Ray, off_surface};

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
        }
    }

    /// Rays and lines of all kinds.
    pub fn rays(&self) -> u64 {
        self.camera_rays + self.indirect_rays + self.shadow_rays + self.depth_lines
    }
}

/// Asks the objects of a scene, and counts.
#[derive(Debug)]
pub(crate) struct Probe<'scene> {
    objects: &'scene Objects,
    crossings: Vec<Crossing>,
    /// What was asked so far.
    pub(crate) statistics: Statistics,
}

impl<'scene> Probe<'scene> {
    /// A probe that has asked nothing.
    pub(crate) fn new(objects: &'scene Objects) -> Self {
        Self { objects, crossings: Vec::with_capacity(16), statistics: Statistics::default() }
    }

    /// What a ray from the camera hits first.
    pub(crate) fn camera_hit(&mut self, ray: &Ray) -> Option<Surface> {
        self.statistics.camera_rays += 1;
        self.objects.first_hit(ray)
    }

    /// What a ray that leaves a surface hits first.
    pub(crate) fn indirect_hit(&mut self, ray: &Ray) -> Option<Surface> {
        self.statistics.indirect_rays += 1;
        self.objects.first_hit(ray)
    }

    /// Whether a place is seen from a surface point, on the side of the normal; `left` is the object that a path leaves
    /// there, if one does.
    pub(crate) fn sees(&mut self, point: Vec3A, normal: Vec3A, left: Option<usize>, target: Vec3A) -> bool {
        let origin = off_surface(point, normal);
        let way = target - origin;
        let distance_m = way.length();
        self.is_free(&Ray { origin, direction: way / distance_m }, distance_m, left)
    }

    /// Whether nothing lies in a direction from a surface point, on the side of the normal.
    pub(crate) fn sees_far(&mut self, point: Vec3A, normal: Vec3A, left: Option<usize>, direction: Vec3A) -> bool {
        self.is_free(&Ray { origin: off_surface(point, normal), direction }, f32::INFINITY, left)
    }

    /// Whether nothing blocks a ray; where it starts at the exit from an object, the rest of its body does not.
    fn is_free(&mut self, ray: &Ray, limit_m: f32, left: Option<usize>) -> bool {
        self.statistics.shadow_rays += 1;
        !match left {
            None => self.objects.blocked(ray, limit_m),
            Some(object) => self.objects.blocked_from(object, ray, limit_m),
        }
    }

    /// The depth of a straight path through the solid that an object is or belongs to.
    pub(crate) fn chord(&mut self, object: usize, line: &Line, exit: Exit) -> Option<Chord> {
        self.statistics.depth_lines += 1;
        let ray = Ray { origin: line.point, direction: line.direction };
        let odd = self.objects.crossings(object, &ray, line.end_m, &mut self.crossings);
        self.statistics.odd_depth_lines += u64::from(odd);
        chord(&mut self.crossings, line, exit)
    }
}
