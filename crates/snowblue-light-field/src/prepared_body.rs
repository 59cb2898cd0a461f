//! A body of snow with its cells and equations, before and after its light is known.

use std::sync::Arc;

use glam::DVec3;
use snowblue_field::{
    CellSizes, FieldError, Fluence, GridOptions, ScaledSizes, SnowBody, SnowOfCells, SolveOptions, SpectralNodes,
    Survey, VolumeSource, fit_sizes,
};
use wide::f32x4;

use super::body_field::LitFluence;
use super::field_scene::FieldScene;
use super::gather::ElementValues;
use super::illumination::{Illumination, LampInSnow};
use super::snowpack::Snowpack;
use super::solid::Solid;
use super::surface_light::{EnteringLight, entering_light};
use snowblue_scene::integrator::LightFieldSettings;
use snowblue_scene::spectrum::Spectrum;

/// A body before its light is known.
pub(super) struct PreparedBody<'a> {
    pub(super) solid: Solid<'a>,
    pub(super) body: SnowBody,
    pub(super) nodes: SpectralNodes,
    pub(super) snow: Arc<Snowpack>,
    /// ℓ* of the whole pack at each wavelength, in m.
    pub(super) transport_lengths_m: Vec<f64>,
    /// If its cells have sizes for a viewer: the factor of these sizes that makes them fit into the memory.
    pub(super) view_factor: Option<f64>,
    /// The solution for other light, from which the next starts.
    pub(super) before: Option<Fluence>,
}

/// The light of lamps and skies of one spectrum on and in a body.
pub(super) struct Lighting {
    pub(super) entering: EnteringLight,
    /// Lamps inside.
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

impl<'a> PreparedBody<'a> {
    pub(super) fn new(
        solid: Solid<'a>,
        survey: &Survey,
        snow: Arc<Snowpack>,
        nodes: &SpectralNodes,
        scene: &FieldScene,
    ) -> Result<Self, String> {
        let thickness_m = survey.mean_thickness_m();
        let nodes = nodes.with_layers(&snow.spectra(thickness_m));
        let transport_lengths_m = snow.transport_lengths_m(thickness_m);
        let groups = nodes.indices().len() / snowblue_field::GROUP;
        let shortest_m = snow.least_transport_length_m();
        let memory_mib = u64::from(scene.settings.memory_mib);
        let refusal = |error: FieldError| error.to_string();
        let LightFieldSettings { step_mm, nodes: wanted_nodes, .. } = scene.settings;
        let is_chosen = step_mm.is_none() && wanted_nodes.is_none();
        let viewer = scene.viewer.filter(|_| is_chosen && survey.is_wide(shortest_m, groups, memory_mib));
        let viewer_sizes = viewer.map(|viewer| viewer.sizes());
        let step_m = match (step_mm, wanted_nodes) {
            (Some(step_mm), _) => survey.check_step_m(1e-3 * step_mm, shortest_m, groups, memory_mib),
            (None, Some(nodes)) => survey.step_of_nodes_m(nodes, shortest_m, groups, memory_mib),
            (None, None) if viewer.is_some() => Ok(survey.finest_step_m(shortest_m)),
            (None, None) => survey.choose_step_m(shortest_m, groups, memory_mib),
        };
        let step_m = step_m.map_err(refusal)?;
        let sizes = match &viewer_sizes {
            Some(sizes) => {
                let (factor, _) = fit_sizes(&solid, step_m, sizes, groups, memory_mib).map_err(refusal)?;
                Some(ScaledSizes { sizes, factor })
            }
            None => None,
        };
        let view_factor = sizes.as_ref().map(|sizes| sizes.factor);
        let sizes = sizes.as_ref().map(|sizes| sizes as &dyn CellSizes);
        let options = GridOptions { step_m, shift: DVec3::ZERO, sizes };
        let of_cell = snow.diffusion(solid.objects, solid.object, &nodes);
        // The extrapolation lengths of kinds of snow differ by less than 0.002.
        let extrapolation = snow.top().half_space().extrapolation();
        let body = SnowBody::new(&solid, options, &SnowOfCells { groups, of_cell: &of_cell, extrapolation });
        drop(of_cell);
        Ok(Self { solid, body, nodes, snow, transport_lengths_m, view_factor, before: None })
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

    /// The light to be read.
    pub(super) fn lit(&self, solution: Solution, diffuse: &[Vec<f32x4>], scale: Spectrum) -> LitFluence {
        let is_dark = diffuse.iter().flatten().all(|values| *values == f32x4::ZERO);
        LitFluence {
            diffuse: (!is_dark).then(|| self.body.smooth(diffuse)),
            exitance: self.body.smooth(&self.exitance(&solution)),
            flux: self.body.smooth(&self.flux(&solution)),
            fluence: solution.fluence,
            scale,
        }
    }

    /// The net flux J of each surface element.
    fn flux(&self, solution: &Solution) -> ElementValues {
        let entering: Vec<&[f32x4]> = solution.entering.iter().map(Vec::as_slice).collect();
        self.body.element_flux(&solution.fluence, &entering)
    }

    /// What each surface element sends out, J + Σ F + H.
    pub(super) fn exitance(&self, solution: &Solution) -> ElementValues {
        let mut exitance = self.flux(solution);
        add(&mut exitance, &solution.irradiance);
        exitance
    }
}

/// Adds the values of each group.
pub(super) fn add(groups: &mut [Vec<f32x4>], others: &[Vec<f32x4>]) {
    for (group, other) in groups.iter_mut().zip(others) {
        group.iter_mut().zip(other).for_each(|(value, other)| *value += *other);
    }
}
