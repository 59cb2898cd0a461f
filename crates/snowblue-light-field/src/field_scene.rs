//! The inputs of the light field from a scene, the geometry of a body of snow for its grid, and the progress and
//! statistics of the work.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DVec3, Vec3, Vec3A};
use snowblue_field::{AxisCrossing, Body};
use snowblue_geometry::bounds::Bounds;
use snowblue_geometry::ray::{Crossing, Ray};
use snowblue_scene::integrator::LightFieldSettings;
use snowblue_scene::light::Light;
use snowblue_scene::objects::{Objects, SurfaceInteraction};
use snowblue_scene::progress::{Phase, Progress, Report};
use snowblue_scene::spectrum::Spectrum;

use crate::body_optics::BodyOptics;
use crate::illumination::LampInSnow;
use crate::sight::CameraCells;

/// The inputs of the light field from a scene.
pub struct FieldScene<'a> {
    pub(crate) objects: &'a Objects,
    pub(crate) lights: &'a [Arc<Light>],
    /// The snow of an object, if it is snow.
    pub(crate) snow: &'a dyn Fn(usize) -> Option<Arc<BodyOptics>>,
    /// The lights that are inside snow.
    pub(crate) lamps_in_snow: &'a [LampInSnow],
    /// The reflectance of a diffuse surface; none for snow.
    pub(crate) reflectance: &'a (dyn Fn(&SurfaceInteraction) -> Option<Spectrum> + Sync),
    /// Greatest number of surfaces after the first surface on a path of light.
    pub(crate) max_bounces: u32,
    /// The camera with the places that it sees, if there is a camera.
    pub(crate) sight: Option<CameraCells<'a>>,
    /// Whether only this camera is used. Snow that it does not see then has larger cells.
    pub(crate) has_one_view: bool,
    /// Memory and cells of the grid of a body.
    pub(crate) settings: LightFieldSettings,
    /// Receives the progress, and counts.
    pub(crate) watch: WorkCounter<'a>,
}

/// A body of snow.
pub(crate) struct BodyGeometry<'scene> {
    pub(super) objects: &'scene Objects,
    /// One of its objects.
    pub(super) object: usize,
    pub(super) watch: &'scene WorkCounter<'scene>,
    bounds: Bounds,
}

thread_local! {
    /// Buffer for the crossings of a line.
    static CROSSINGS: RefCell<Vec<Crossing>> = const { RefCell::new(Vec::new()) };
}

impl<'scene> BodyGeometry<'scene> {
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

impl Body for BodyGeometry<'_> {
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

/// Reports the work on a light field and counts its steps.
pub(crate) struct WorkCounter<'a> {
    report: Report<'a>,
    solutions: AtomicU64,
    rounds: AtomicU64,
    rays: AtomicU64,
}

/// Statistics of the work on a light field.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SolveStatistics {
    /// Rounds of light between bodies.
    pub(crate) rounds: u64,
    /// Rays that found lights and other surfaces.
    pub(crate) rays: u64,
}

impl<'a> WorkCounter<'a> {
    /// Starts with nothing done.
    pub(crate) fn new(report: Report<'a>) -> Self {
        let [solutions, rounds, rays] = [(); 3].map(|()| AtomicU64::new(0));
        Self { report, solutions, rounds, rays }
    }

    /// Reports the number of bodies that have cells, and the number of all bodies; 0 if it is not known.
    pub(crate) fn cells(&self, done: usize, bodies: usize) {
        (self.report)(Progress { phase: Phase::Cells, done: done as u64, total: bodies as u64 });
    }

    /// Reports the solutions so far.
    pub(crate) fn light(&self) {
        let done = self.solutions.load(Ordering::Relaxed);
        (self.report)(Progress { phase: Phase::Light, done, total: 0 });
    }

    /// Counts a round of light between bodies.
    pub(crate) fn begin_round(&self) {
        self.rounds.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts and reports a solution in a body.
    pub(crate) fn add_solution(&self) {
        self.solutions.fetch_add(1, Ordering::Relaxed);
        self.light();
    }

    /// Counts rays.
    pub(crate) fn add_rays(&self, rays: u64) {
        self.rays.fetch_add(rays, Ordering::Relaxed);
    }

    /// The statistics.
    pub(crate) fn work(&self) -> SolveStatistics {
        SolveStatistics { rounds: self.rounds.load(Ordering::Relaxed), rays: self.rays.load(Ordering::Relaxed) }
    }
}
