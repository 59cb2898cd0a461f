//! The bodies of snow of a scene, with their cells and equations.

use std::cell::RefCell;
use std::fmt::Display;
use std::sync::Arc;

use glam::{DVec3, Vec3, Vec3A};
use snowblue_base::KeyPath;
use snowblue_field::{
    AxisCrossing, Body, CellSizes, FieldError, GridOptions, KnownFactor, LayerSpectrum, ScaledSizes, SnowBody,
    SnowOfCells, SpectralNodes, SurfacePlace, Survey, fit_sizes,
};
use snowblue_geometry::bounds::Bounds;
use snowblue_geometry::ray::{Crossing, Ray, SurfacePoint, off_surface};
use snowblue_scene::integrator::LightFieldSettings;
use snowblue_scene::objects::Objects;
use snowblue_scene::progress::{Phase, Progress, Report};
use snowblue_scene::{Scene, SceneError};

use crate::body_optics::{BodyOptics, SnowOfMaterials};
use crate::sight::{Sight, SizesBySight};

/// Greatest number of bodies of snow. Each body has a grid, and is lit by all other bodies.
const MAX_BODIES: usize = 1000;

/// The bodies of snow of a scene.
#[derive(Clone)]
pub(crate) struct SceneBodies {
    pub(crate) systems: Vec<Arc<BodySystem>>,
    /// The number of the body of each object; none for other objects.
    pub(crate) of_object: Vec<Option<usize>>,
    /// Whether snow that the camera of the scene does not see has larger cells.
    pub(crate) has_one_view: bool,
}

/// A body of snow with its cells and equations.
pub(crate) struct BodySystem {
    /// One of its objects.
    pub(crate) object: usize,
    pub(crate) snow: Arc<BodyOptics>,
    pub(crate) cells: SnowBody,
    pub(crate) nodes: SpectralNodes,
    /// ℓ* of the whole snowpack.
    pub(crate) transport_length: KnownFactor,
    /// If its cell sizes are for a viewer: the factor of these sizes that makes the cells fit into the memory.
    pub(crate) view_factor: Option<f64>,
}

/// A body of snow without cells.
struct SurveyedBody<'a> {
    shape: BodyShape<'a>,
    snow: Arc<BodyOptics>,
    survey: Survey,
}

/// The shape of a body of snow.
struct BodyShape<'a> {
    objects: &'a Objects,
    /// One of its objects.
    object: usize,
    bounds: Bounds,
    /// The objects of other snow.
    other_snow: Vec<usize>,
}

impl SceneBodies {
    /// Divides all snow of a scene into cells, and reports the number of bodies that have cells. If `has_one_view`
    /// holds, snow that the camera of the scene does not see has larger cells.
    ///
    /// # Errors
    ///
    /// If a body has no grid.
    pub(crate) fn new(
        scene: &Scene,
        snow: &SnowOfMaterials<BodyOptics>,
        has_one_view: bool,
        report: Report,
    ) -> Result<Self, SceneError> {
        let report = |done: usize, total: usize| {
            report(Progress { phase: Phase::Cells, done: done as u64, total: total as u64 });
        };
        report(0, 0);
        let (surveyed, of_object) = surveyed_bodies(scene, snow)?;
        if surveyed.is_empty() {
            return Ok(Self { systems: Vec::new(), of_object, has_one_view });
        }
        // All bodies have the same wavelengths, so that light can pass between them.
        let spectra: Vec<Vec<LayerSpectrum>> =
            surveyed.iter().map(|body| body.snow.spectra(body.survey.mean_thickness_m())).collect();
        let nodes = SpectralNodes::for_bodies(&spectra);
        let groups = nodes.group_count();
        let sight = Sight::new(scene, has_one_view);
        let settings = &scene.description().light_field;
        let wanted_mib = surveyed.iter().map(|body| {
            let (step_m, _) = body
                .cell_sizes(settings, &sight, groups, u64::from(u32::MAX))
                .map_err(|error| refusal(scene, body.shape.object, &error))?;
            Ok(body.survey.memory_mib(step_m, groups))
        });
        let memory_mib = memory_of_each(wanted_mib.collect::<Result<_, SceneError>>()?, settings.memory_mib());
        let mut systems = Vec::with_capacity(surveyed.len());
        for body in &surveyed {
            report(systems.len(), surveyed.len());
            let system = body
                .cell_sizes(settings, &sight, groups, memory_mib)
                .and_then(|sizes| BodySystem::new(body, &nodes, sizes, memory_mib))
                .map_err(|error| refusal(scene, body.shape.object, &error))?;
            systems.push(Arc::new(system));
        }
        Ok(Self { systems, of_object, has_one_view })
    }
}

/// The bodies of snow of a scene, and the number of the body of each object.
fn surveyed_bodies<'a>(
    scene: &'a Scene,
    snow: &SnowOfMaterials<BodyOptics>,
) -> Result<(Vec<SurveyedBody<'a>>, Vec<Option<usize>>), SceneError> {
    let objects = scene.objects();
    let mut of_object = vec![None; objects.list().len()];
    let mut surveyed: Vec<SurveyedBody> = Vec::new();
    for (object, listed) in objects.list().iter().enumerate() {
        let Some(snow) = snow[listed.material].as_ref().filter(|_| of_object[object].is_none()) else { continue };
        if surveyed.len() == MAX_BODIES {
            let reason = format!(
                "is one body of snow more than the {MAX_BODIES} that this integrator takes: give touching objects the \
                 same 'body'"
            );
            return Err(refusal(scene, object, &reason));
        }
        objects.body_of(object).iter().for_each(|member| of_object[*member] = Some(surveyed.len()));
        let infinite = || refusal(scene, object, &"is infinite: only pcasnow can render infinite snow");
        let shape = BodyShape::new(scene, object).ok_or_else(infinite)?;
        let survey = Survey::new(&shape).map_err(|error| refusal(scene, object, &error))?;
        surveyed.push(SurveyedBody { shape, snow: Arc::clone(snow), survey });
    }
    Ok((surveyed, of_object))
}

/// The reason why a body has no grid, as an error at one of its objects.
fn refusal(scene: &Scene, object: usize, reason: &dyn Display) -> SceneError {
    let name = &scene.objects().list()[object].name;
    KeyPath::root("object").error(format!("\"{name}\" {reason}")).into()
}

/// The memory limit of each body, in MiB, with which all bodies together stay within `memory_mib`. Bodies that want
/// less leave the rest to the other bodies.
fn memory_of_each(mut wanted_mib: Vec<f64>, memory_mib: u32) -> u64 {
    wanted_mib.sort_by(f64::total_cmp);
    let (mut rest_mib, mut bodies) = (f64::from(memory_mib), wanted_mib.len());
    for wanted in &wanted_mib {
        let share = rest_mib / bodies as f64;
        if *wanted > share {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "rounding down is intended")]
            return (share as u64).max(1);
        }
        rest_mib -= wanted;
        bodies -= 1;
    }
    memory_mib.into()
}

impl SurveyedBody<'_> {
    /// The size of the smallest cells of the body, in m, and the rule for the sizes of other cells if these follow the
    /// picture. The cells of `groups` groups of wavelengths stay within `memory_mib` MiB.
    fn cell_sizes<'s>(
        &self,
        settings: &LightFieldSettings,
        sight: &'s Sight,
        groups: usize,
        memory_mib: u64,
    ) -> Result<(f64, Option<SizesBySight<'s>>), FieldError> {
        let Self { snow, survey, shape } = self;
        let shortest_m = snow.least_transport_length_m();
        let LightFieldSettings { step_mm, nodes, .. } = settings;
        match (step_mm, nodes) {
            (Some(step_mm), _) => {
                Ok((survey.check_step_m(1e-3 * step_mm.get(), shortest_m, groups, memory_mib)?, None))
            }
            (None, Some(nodes)) => Ok((survey.step_of_nodes_m(nodes.get(), shortest_m, groups, memory_mib)?, None)),
            (None, None) => {
                let [low, high] = shape.bounds();
                let extent_m = (high - low).max_element();
                if survey.is_wide(shortest_m, groups, memory_mib) {
                    let even_m = survey.smallest_step_m(groups, memory_mib);
                    let sizes = sight.sizes_of_wide(extent_m, shortest_m, even_m);
                    return Ok((survey.finest_step_m(shortest_m), Some(sizes)));
                }
                let step_m = survey.choose_step_m(shortest_m, groups, memory_mib)?;
                let sizes = sight.sizes(extent_m, survey.coarsest_usual_step_m(shortest_m));
                let least_m = sizes.as_ref().map_or(0.0, |sizes| sizes.least_between(low, high).thin_m);
                Ok((step_m.max(least_m), sizes))
            }
        }
    }
}

impl BodySystem {
    /// Divides a body into cells of given sizes, within the memory limit `memory_mib`.
    fn new(
        surveyed: &SurveyedBody,
        nodes: &SpectralNodes,
        (step_m, sizes): (f64, Option<SizesBySight>),
        memory_mib: u64,
    ) -> Result<Self, FieldError> {
        let SurveyedBody { shape, snow, survey } = surveyed;
        let groups = nodes.group_count();
        let scaled = |sizes| -> Result<ScaledSizes, FieldError> {
            let (factor, _) = fit_sizes(shape, step_m, sizes, groups, memory_mib)?;
            Ok(ScaledSizes { sizes, factor })
        };
        let sizes = sizes.as_ref().map(|sizes| scaled(sizes)).transpose()?;
        let options =
            GridOptions { step_m, shift: DVec3::ZERO, sizes: sizes.as_ref().map(|sizes| sizes as &dyn CellSizes) };
        let snow_of_cells = SnowOfCells {
            groups,
            of_cell: &snow.diffusion(shape.objects, shape.object, nodes),
            // The extrapolation lengths of kinds of snow differ by less than 0.002.
            extrapolation: snow.top().surface().half_space().extrapolation(),
        };
        Ok(Self {
            object: shape.object,
            snow: Arc::clone(snow),
            cells: SnowBody::new(shape, options, &snow_of_cells),
            nodes: nodes.clone(),
            transport_length: KnownFactor::new(nodes, &snow.transport_lengths_m(survey.mean_thickness_m())),
            view_factor: sizes.map(|sizes| sizes.factor),
        })
    }
}

impl BodySystem {
    /// The place of a point of the surface; none if there is no cell near the point.
    #[inline]
    pub(crate) fn place(&self, surface: &SurfacePoint) -> Option<SurfacePlace> {
        self.cells.surface_place(surface.point.as_dvec3(), surface.normal.as_dvec3())
    }
}

thread_local! {
    /// Buffer for the crossings of a line.
    static CROSSINGS: RefCell<Vec<Crossing>> = const { RefCell::new(Vec::new()) };
}

impl<'a> BodyShape<'a> {
    /// The body that an object belongs to; none if it has no bounds.
    fn new(scene: &'a Scene, object: usize) -> Option<Self> {
        let objects = scene.objects();
        let mut bounds = Bounds::of(std::iter::empty());
        let members = objects.body_of(object);
        for member in members {
            bounds = bounds.around(objects.list()[*member].shape.bounds()?);
        }
        let is_other = |index: &usize| {
            let overlaps = |other: Bounds| bounds.common(other).is_some();
            let is_snow = scene.materials()[objects.list()[*index].material].looks_like_snow();
            is_snow && !members.contains(index) && objects.bounds(*index).is_none_or(overlaps)
        };
        let other_snow = (0..objects.list().len()).filter(is_other).collect();
        Some(Self { objects, object, bounds, other_snow })
    }
}

impl Body for BodyShape<'_> {
    fn bounds(&self) -> [DVec3; 2] {
        [self.bounds.low, self.bounds.high].map(|corner| corner.as_dvec3())
    }

    fn crossings(&self, axis: usize, point: DVec3, crossings: &mut Vec<AxisCrossing>) {
        let mut origin = Vec3A::from(point.as_vec3());
        // Well before the body, so that all crossings lie ahead.
        let margin = 0.1 * (self.bounds.high - self.bounds.low).max_element();
        origin[axis] = self.bounds.low[axis] - margin;
        let ray = Ray::new(origin, Vec3A::AXES[axis]);
        CROSSINGS.with_borrow_mut(|found| {
            let is_open = self.objects.segments(self.object, &ray, f32::INFINITY, found);
            if is_open {
                // An odd number of crossings says that the line is not sound.
                crossings.push(AxisCrossing { coordinate_m: point[axis], normal: Vec3::ZERO });
                return;
            }
            crossings.extend(found.iter().map(|crossing| AxisCrossing {
                coordinate_m: f64::from(origin[axis]) + f64::from(crossing.distance_m),
                normal: Vec3::from(crossing.normal).normalize_or_zero(),
            }));
        });
    }

    fn is_covered(&self, point: DVec3, normal: Vec3) -> bool {
        let above = off_surface(Vec3A::from(point.as_vec3()), normal.into(), self.objects.reach_m(self.object));
        self.other_snow.iter().any(|other| self.objects.holds(*other, above))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_share_the_memory_of_the_scene() {
        assert_eq!(memory_of_each(vec![200.0, 100.0, 300.0], 1024), 1024);
        // The two small bodies take 300 MiB.
        assert_eq!(memory_of_each(vec![5000.0, 200.0, 1e9, 100.0], 1024), 362);
        assert_eq!(memory_of_each(vec![90.0; 1000], 500), 1);
    }
}
