//! A body of snow with its cells and equations, before and after its light is known.

use std::sync::Arc;

use glam::DVec3;
use snowblue_field::{
    Body, CellSizes, FieldError, Fluence, GridOptions, KnownFactor, ScaledSizes, SizesByDistance, SnowBody,
    SnowOfCells, SolveOptions, SpectralNodes, Survey, VolumeSource, fit_sizes,
};
use wide::f32x4;

use super::body_optics::BodyOptics;
use super::body_solution::LitFluence;
use super::field_scene::{BodyGeometry, FieldScene};
use super::gather::ElementValues;
use super::illumination::{Illumination, LampInSnow};
use super::sight::{SizesBySight, greatest_cell_m};
use super::surface_light::{EnteringLight, entering_light};
use snowblue_scene::integrator::LightFieldSettings;
use snowblue_scene::spectrum::Spectrum;

/// Relative noise to which the irradiance by a sky is smoothed where it is read.
const SKY_NOISE: f32 = 0.01;

/// A body without cells.
pub(super) struct SurveyedBody<'a> {
    pub(super) solid: BodyGeometry<'a>,
    pub(super) snow: Arc<BodyOptics>,
    pub(super) survey: Survey,
}

/// A body before its light is known.
pub(super) struct BodySystem<'a> {
    pub(super) solid: BodyGeometry<'a>,
    pub(super) body: SnowBody,
    pub(super) nodes: SpectralNodes,
    pub(super) snow: Arc<BodyOptics>,
    /// ℓ* of the whole snowpack.
    pub(super) transport_length: KnownFactor,
    /// If its cell sizes are for a viewer: the factor of these sizes that makes the cells fit into the memory.
    pub(super) view_factor: Option<f64>,
}

/// The light of lamps and skies of one spectrum on and in a body.
pub(super) struct Lighting {
    pub(super) entering: EnteringLight,
    /// Lamps inside the body.
    sources: Vec<VolumeSource>,
}

/// The light at the surface of a body and inside.
pub(super) struct Solution {
    /// Σ K F + H.
    entering: ElementValues,
    /// Σ F + H.
    irradiance: ElementValues,
    pub(super) fluence: Fluence,
}

impl SurveyedBody<'_> {
    /// Memory of its cells and equations without a memory limit, in MiB, for `groups` groups of wavelengths.
    pub(super) fn wanted_mib(&self, groups: usize, scene: &FieldScene) -> Result<f64, FieldError> {
        let step_m = self.step_m(groups, scene, u64::from(u32::MAX))?;
        Ok(self.survey.memory_mib(step_m, groups))
    }

    /// Size of its smallest cells, in m.
    fn step_m(&self, groups: usize, scene: &FieldScene, memory_mib: u64) -> Result<f64, FieldError> {
        let Self { snow, survey, .. } = self;
        let shortest_m = snow.least_transport_length_m();
        let LightFieldSettings { step_mm, nodes, .. } = scene.settings;
        match (step_mm, nodes) {
            (Some(step_mm), _) => survey.check_step_m(1e-3 * step_mm.get(), shortest_m, groups, memory_mib),
            (None, Some(nodes)) => survey.step_of_nodes_m(nodes.get(), shortest_m, groups, memory_mib),
            (None, None) if self.is_wide(groups, scene, memory_mib) => Ok(survey.finest_step_m(shortest_m)),
            (None, None) => {
                let step_m = survey.choose_step_m(shortest_m, groups, memory_mib)?;
                let [low, high] = self.solid.bounds();
                let of_picture = self.sizes(groups, scene, memory_mib).map(|sizes| sizes.least_between(low, high));
                Ok(of_picture.map_or(step_m, |limits| step_m.max(limits.detailed_m)))
            }
        }
    }

    /// Sizes of its cells that follow the picture; none if all cells have one size.
    fn sizes<'s>(&self, groups: usize, scene: &'s FieldScene, memory_mib: u64) -> Option<SizesBySight<'s>> {
        let LightFieldSettings { step_mm: None, nodes: None, .. } = scene.settings else { return None };
        let sight = scene.sight.as_ref()?;
        let [low, high] = self.solid.bounds();
        let extent_m = (high - low).max_element();
        let is_wide = self.is_wide(groups, scene, memory_mib);
        let sizes: Option<SizesByDistance> = if is_wide {
            Some(sight.sizes_of_wide(extent_m))
        } else {
            let shortest_m = self.snow.least_transport_length_m();
            scene.has_one_view.then(|| sight.sizes(self.survey.coarsest_usual_step_m(shortest_m)))
        };
        let seen = scene.has_one_view.then(|| sight.seen());
        Some(SizesBySight { sizes: sizes?, seen, greatest_m: greatest_cell_m(extent_m) })
    }

    /// Whether its cells must follow a picture to fit into the memory.
    fn is_wide(&self, groups: usize, scene: &FieldScene, memory_mib: u64) -> bool {
        scene.sight.is_some() && self.survey.is_wide(self.snow.least_transport_length_m(), groups, memory_mib)
    }
}

impl<'a> BodySystem<'a> {
    /// Divides a body into cells, within the memory limit `memory_mib`.
    pub(super) fn new(
        bare: SurveyedBody<'a>,
        nodes: &SpectralNodes,
        scene: &FieldScene,
        memory_mib: u64,
    ) -> Result<Self, FieldError> {
        let groups = nodes.indices().len() / snowblue_field::GROUP;
        let step_m = bare.step_m(groups, scene, memory_mib)?;
        let sizes_by_sight = bare.sizes(groups, scene, memory_mib);
        let SurveyedBody { solid, snow, survey } = bare;
        let transport_length = KnownFactor::new(nodes, &snow.transport_lengths_m(survey.mean_thickness_m()));
        let sizes = match &sizes_by_sight {
            Some(sizes) => {
                let (factor, _) = fit_sizes(&solid, step_m, sizes, groups, memory_mib)?;
                Some(ScaledSizes { sizes, factor })
            }
            None => None,
        };
        let view_factor = sizes.as_ref().map(|sizes| sizes.factor);
        let sizes = sizes.as_ref().map(|sizes| sizes as &dyn CellSizes);
        let options = GridOptions { step_m, shift: DVec3::ZERO, sizes };
        let of_cell = snow.diffusion(solid.objects, solid.object, nodes);
        // The extrapolation lengths of kinds of snow differ by less than 0.002.
        let extrapolation = snow.top().surface().half_space().extrapolation();
        let body = SnowBody::new(&solid, options, &SnowOfCells { groups, of_cell: &of_cell, extrapolation });
        drop(of_cell);
        Ok(Self { solid, body, nodes: nodes.clone(), snow, transport_length, view_factor })
    }

    /// The light of lamps and skies. `body_of` gives the body of each object.
    pub(super) fn lighting(&self, illumination: &Illumination, body_of: &[Option<usize>]) -> Lighting {
        let is_inside = |lamp: &&&LampInSnow| body_of[lamp.object] == body_of[self.solid.object];
        let inside = illumination.lamps.iter().filter(is_inside);
        Lighting {
            entering: entering_light(&self.solid, &self.body, &self.nodes, &illumination.lights, &self.snow),
            sources: inside.map(|lamp| lamp.source(&self.nodes)).collect(),
        }
    }

    /// The solution for the light of lamps and the diffuse irradiance H.
    pub(super) fn solve<'l>(
        &self,
        lighting: &'l Lighting,
        diffuse: &[Vec<f32x4>],
        options: SolveOptions<'l>,
    ) -> Solution {
        let (mut entering, mut irradiance) = (diffuse.to_vec(), diffuse.to_vec());
        add(&mut entering, &lighting.entering.escape_weighted);
        add(&mut irradiance, &lighting.entering.irradiance);
        let groups: Vec<&[f32x4]> = entering.iter().map(Vec::as_slice).collect();
        let options = SolveOptions { sources: &lighting.sources, ..options };
        let fluence = self.body.solve_inside(&groups, options);
        self.solid.watch.add_solution();
        Solution { entering, irradiance, fluence }
    }

    /// Prepares the light of a solution for reads, with the diffuse irradiance H. `sky` is the irradiance by smooth
    /// skies, if the lights are such skies.
    pub(super) fn lit(
        &self,
        solution: Solution,
        diffuse: &[Vec<f32x4>],
        sky: Option<&ElementValues>,
        spectrum: Spectrum,
    ) -> LitFluence {
        let is_dark = diffuse.iter().flatten().all(|values| *values == f32x4::ZERO);
        let sky = sky.map(|sky| {
            let mut sky = sky.clone();
            self.body.denoise(&mut sky, SKY_NOISE);
            self.body.smooth(&sky)
        });
        let flux = self.flux(&solution);
        let [flux, exitance] = self.body.smooth_light(&flux, &solution.exitance(flux.clone()));
        LitFluence {
            diffuse: (!is_dark).then(|| self.body.smooth(diffuse)),
            exitance,
            flux,
            fluence: solution.fluence,
            sky,
            spectrum,
        }
    }

    /// The net flux J of each surface element.
    fn flux(&self, solution: &Solution) -> ElementValues {
        let entering: Vec<&[f32x4]> = solution.entering.iter().map(Vec::as_slice).collect();
        self.body.element_flux(&solution.fluence, &entering)
    }

    /// The exitance of each surface element, J + Σ F + H.
    pub(super) fn exitance(&self, solution: &Solution) -> ElementValues {
        solution.exitance(self.flux(solution))
    }
}

impl Solution {
    /// The exitance of each surface element for a net flux J.
    fn exitance(&self, flux: ElementValues) -> ElementValues {
        let mut exitance = flux;
        add(&mut exitance, &self.irradiance);
        exitance
    }
}

/// Adds the values of each group.
pub(super) fn add(groups: &mut [Vec<f32x4>], others: &[Vec<f32x4>]) {
    for (group, other) in groups.iter_mut().zip(others) {
        group.iter_mut().zip(other).for_each(|(value, other)| *value += *other);
    }
}
