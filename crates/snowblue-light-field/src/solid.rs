//! A body of snow of a scene, as its grid sees it.

use std::cell::RefCell;

use glam::{DVec3, Vec3, Vec3A};
use snowblue_field::{AxisCrossing, Body};
use snowblue_geometry::bounds::Bounds;
use snowblue_geometry::ray::{Crossing, Ray};

use super::field_scene::FieldScene;
use super::watch::Watch;
use snowblue_scene::objects::Objects;

/// A body of snow.
pub(crate) struct Solid<'scene> {
    pub(super) objects: &'scene Objects,
    /// One of its objects.
    pub(super) object: usize,
    pub(super) watch: &'scene Watch<'scene>,
    bounds: Bounds,
}

thread_local! {
    /// Buffer for the crossings of a line.
    static CROSSINGS: RefCell<Vec<Crossing>> = const { RefCell::new(Vec::new()) };
}

impl<'scene> Solid<'scene> {
    /// The body that an object belongs to; none if it has no bounds.
    pub(crate) fn new(scene: &'scene FieldScene, object: usize) -> Option<Self> {
        let objects = scene.objects;
        let mut bounds = Bounds::of(std::iter::empty());
        for member in objects.body_of(object) {
            let of_member = objects.list()[*member].shape.bounds()?;
            bounds = Bounds { low: bounds.low.min(of_member.low), high: bounds.high.max(of_member.high) };
        }
        Some(Self { objects, object, watch: &scene.watch, bounds })
    }
}

impl Body for Solid<'_> {
    fn bounds(&self) -> [DVec3; 2] {
        [self.bounds.low, self.bounds.high].map(|corner| corner.as_dvec3())
    }

    fn crossings(&self, axis: usize, point: DVec3, crossings: &mut Vec<AxisCrossing>) {
        let mut origin = Vec3A::from(point.as_vec3());
        // Well before the body, so that all crossings lie ahead.
        let margin = 0.1 * (self.bounds.high - self.bounds.low).max_element();
        origin[axis] = self.bounds.low[axis] - margin;
        let ray = Ray { origin, direction: Vec3A::AXES[axis] };
        CROSSINGS.with_borrow_mut(|found| {
            self.objects.crossings(self.object, &ray, f32::INFINITY, found);
            crossings.extend(found.iter().map(|crossing| AxisCrossing {
                coordinate_m: f64::from(origin[axis]) + f64::from(crossing.distance_m),
                normal: Vec3::from(crossing.normal).normalize_or_zero(),
            }));
        });
    }
}
