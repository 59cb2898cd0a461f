//! Surfaces that light passes straight on: panes of glass, and surfaces with an opacity below 1.
//!
//! A ray that meets such a surface passes it by chance, with the probability of its transmittance. A ray that does not
//! pass a pane is mirrored. A ray that does not pass another surface ends there. Shadow rays pass all of these
//! surfaces, and their light is multiplied by the transmittances. Light that panes mirror towards other surfaces is
//! therefore only found by rays that are mirrored there, and not by shadow rays.

use snowblue_geometry::ray::{Ray, off_surface};

use crate::material::Material;
use crate::objects::{Objects, SurfaceInteraction};

/// Greatest number of surfaces that a ray passes or that mirror it. The next pane counts as black.
const MAX_PASSED: u32 = 64;

/// The transparent surfaces among the objects of a scene.
#[derive(Debug, Clone, Copy)]
pub struct TransparentSurfaces<'scene> {
    objects: &'scene Objects,
    materials: &'scene [Material],
    /// Whether there are any.
    exist: bool,
}

/// A part of a ray from one surface to the next.
#[derive(Debug, Clone, Copy)]
pub struct Segment {
    /// The ray, from the point where the segment begins.
    pub ray: Ray,
    /// Where the segment ends; none if there is no further surface.
    pub hit: Option<SurfaceInteraction>,
    /// Whether a pane has mirrored the ray before.
    pub is_mirrored: bool,
}

impl<'scene> TransparentSurfaces<'scene> {
    /// The transparent surfaces among some objects, whose materials are `materials`.
    pub fn new(objects: &'scene Objects, materials: &'scene [Material]) -> Self {
        Self { objects, materials, exist: materials.iter().any(Material::is_transparent) }
    }

    /// Whether an object is transparent.
    #[inline]
    pub fn holds(&self, object: usize) -> bool {
        self.exist && self.materials[self.objects.list()[object].material].is_transparent()
    }

    /// The share of light along a ray that the transparent surfaces nearer than `limit_m` let pass.
    #[inline]
    pub fn transmittance(&self, ray: &Ray, limit_m: f32) -> f32 {
        if self.exist { self.product_of_transmittances(*ray, limit_m) } else { 1.0 }
    }

    fn product_of_transmittances(&self, mut ray: Ray, mut limit_m: f32) -> f32 {
        let mut product = 1.0;
        while product > 0.0
            && let Some(hit) = self.objects.first_hit_of(&ray, limit_m, |index| self.holds(index))
        {
            product *= self.transmittance_at(&hit);
            let behind = self.behind(&hit);
            limit_m -= ray.origin.distance(behind.origin);
            ray = behind;
        }
        product
    }

    /// Follows a ray past transparent surfaces to the surface where it ends; none if it meets no such surface. Where
    /// a surface lets only a share of the light pass, `number` chooses by a number in [0, 1): the ray passes if the
    /// number is below the share. `visit` sees each segment. A ray that passes keeps its origin, and a mirrored ray
    /// begins at the pane.
    #[inline]
    pub fn first_end(
        &self,
        ray: &mut Ray,
        mut number: impl FnMut() -> f32,
        mut visit: impl FnMut(&Segment),
    ) -> Option<SurfaceInteraction> {
        let mut segment = Segment { ray: *ray, hit: self.objects.first_hit(ray), is_mirrored: false };
        for _ in 0..MAX_PASSED {
            visit(&segment);
            let hit = segment.hit?;
            let Some(onward) = self.onward(&hit, &mut number) else { break };
            if onward.direction != ray.direction {
                *ray = onward;
                segment.is_mirrored = true;
            }
            (segment.ray, segment.hit) = (onward, self.objects.first_hit(&onward));
        }
        segment.hit
    }

    /// The ray that goes on from a hit, chosen by a number as by [`first_end`](Self::first_end); none if the ray ends
    /// there.
    #[inline]
    pub fn onward(&self, hit: &SurfaceInteraction, mut number: impl FnMut() -> f32) -> Option<Ray> {
        let material = &self.materials[hit.material];
        if !material.is_transparent() {
            return None;
        }
        let share = self.transmittance_at(hit);
        if share >= 1.0 || share > 0.0 && number() < share {
            return Some(self.behind(hit));
        }
        let mirrored = hit.direction - 2.0 * hit.direction.dot(hit.normal) * hit.normal;
        let origin = off_surface(hit.point, hit.normal, self.objects.reach_m(hit.object));
        material.is_mirror().then_some(Ray::new(origin, mirrored.normalize()))
    }

    fn transmittance_at(&self, hit: &SurfaceInteraction) -> f32 {
        self.materials[hit.material].transmittance(self.objects, hit)
    }

    /// The ray from just behind a hit.
    fn behind(&self, hit: &SurfaceInteraction) -> Ray {
        let origin = off_surface(hit.point, -hit.normal, self.objects.reach_m(hit.object));
        Ray::new(origin, hit.direction)
    }
}
