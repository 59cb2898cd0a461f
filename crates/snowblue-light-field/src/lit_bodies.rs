//! The light in all bodies of a scene, by lights of one spectrum.

use std::sync::Arc;

use glam::DVec3;
use snowblue_field::{
    CellSizes, FieldError, Fluence, GridOptions, ScaledSizes, SnowBody, SnowOfCells, SolveOptions, SpectralNodes,
    SurfaceValues, Survey, VolumeSource, fit_sizes, solve_fixed_point,
};
use snowblue_geometry::ray::{SurfacePoint, narrow};
use wide::f32x4;

use super::body_field::LitFluence;
use super::field_scene::FieldScene;
use super::gather::{Exitance, GatheredPaths, Surroundings};
use super::illumination::{Illumination, LampInSnow};
use super::snowpack::Snowpack;
use super::solid::Solid;
use super::surface_light::{EnteringLight, NOISE, entering_light};
use snowblue_scene::integrator::LightFieldSettings;
use snowblue_scene::spectrum::Spectrum;

/// Relative residual of the light that snow receives from snow, over all surfaces. The light in a cave may be a small
/// part of that outside, and its error is some thirty times the residual there.
const GATHER_TOLERANCE: f64 = 1e-5;
/// Most diffuse surfaces between two pieces of snow.
const MOST_GATHER_SURFACES: u32 = 8;

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
struct Lighting {
    entering: EnteringLight,
    /// What the surface sees besides lamps.
    paths: GatheredPaths,
    /// Lamps inside.
    sources: Vec<VolumeSource>,
}

/// Values at each surface element, for each group of spectral nodes.
type ElementValues = Vec<Vec<f32x4>>;

/// The light at the surface of a body and inside.
struct Solution {
    /// Σ K F + H.
    entering: ElementValues,
    /// Σ F + H.
    irradiance: ElementValues,
    fluence: Fluence,
}

/// Solves for the light of lights of one spectrum in all bodies.
pub(super) fn solve(
    scene: &FieldScene,
    illumination: &Illumination,
    prepared: &[PreparedBody],
    body_of: &[Option<usize>],
) -> Vec<LitFluence> {
    scene.watch.begin_light(prepared.len());
    let lightings: Vec<Lighting> = prepared.iter().map(|one| one.lighting(scene, illumination, body_of)).collect();
    let bodies = || prepared.iter().zip(&lightings);
    let mut diffuse: Vec<ElementValues> = lightings.iter().map(|lighting| lighting.paths.steady().to_vec()).collect();
    let mut first: Vec<Solution> = Vec::new();
    if lightings.iter().any(|lighting| lighting.paths.reach_snow()) {
        first.extend(bodies().zip(&diffuse).map(|((one, lighting), diffuse)| {
            let start = one.before.as_ref();
            let options = SolveOptions { start, sources: &lighting.sources, tolerance: GATHER_TOLERANCE };
            one.solve(Some(&lighting.entering), diffuse, options)
        }));
        for (diffuse, by_snow) in
            diffuse.iter_mut().zip(irradiance_by_snow(scene, prepared, &lightings, &first, body_of))
        {
            add(diffuse, &by_snow);
        }
    }
    scene.watch.end_rounds();
    let spectrum = illumination.spectrum.unwrap_or_else(|| mean_spectrum(&lightings));
    let lit = bodies().zip(diffuse).enumerate().map(|(number, ((one, lighting), mut diffuse))| {
        one.body.denoise(&mut diffuse, NOISE);
        let start = first.get(number).map(|first| &first.fluence).or(one.before.as_ref());
        let options = SolveOptions { start, sources: &lighting.sources, ..SolveOptions::default() };
        let solution = one.solve(Some(&lighting.entering), &diffuse, options);
        let scale = |k: usize| narrow(one.transport_lengths_m[k]) * spectrum.0[k];
        one.lit(solution, &diffuse, Spectrum(std::array::from_fn(scale)))
    });
    lit.collect()
}

/// The spectrum of the light on all bodies; white if there is none.
fn mean_spectrum(lightings: &[Lighting]) -> Spectrum {
    let mut sum = Spectrum::ZERO;
    lightings.iter().for_each(|lighting| sum += lighting.entering.spectrum);
    if sum.maximum() > 0.0 { sum } else { Spectrum::ONE }
}

/// The irradiance H of each body by what snow sends out. `first` are the solutions without it.
///
/// It is H = b + M H, where b is by the first solutions, and M H by solutions for H alone. In a cavity of snow hardly
/// any light is lost from one reflection to the next, so reflections are not added up one by one.
fn irradiance_by_snow(
    scene: &FieldScene,
    prepared: &[PreparedBody],
    lightings: &[Lighting],
    first: &[Solution],
    body_of: &[Option<usize>],
) -> Vec<ElementValues> {
    // The values of all bodies are joined, body by body.
    let received = |solutions: &[Solution]| {
        let exitances: Vec<SurfaceValues> =
            prepared.iter().zip(solutions).map(|(one, solution)| one.exitance(solution)).collect();
        let exitance = |object: usize, surface: &SurfacePoint| {
            let Some(body) = body_of[object] else { return Exitance::new() };
            let (point, normal) = (surface.point.as_dvec3(), surface.normal.as_dvec3());
            prepared[body].body.surface_value(&exitances[body], point, normal).into_iter().flatten().collect()
        };
        let mut joined = ElementValues::new();
        for lighting in lightings {
            let values = lighting.paths.irradiance_by_snow(&exitance);
            joined.resize(values.len(), Vec::new());
            joined.iter_mut().zip(values).for_each(|(group, values)| group.extend(values));
        }
        joined
    };
    let of_bodies = |joined: &[Vec<f32x4>]| -> Vec<ElementValues> {
        let mut end = 0;
        let of_body = |one: &PreparedBody| {
            let start = end;
            end += one.body.surface().len();
            joined.iter().map(|group| group[start..end].to_vec()).collect()
        };
        prepared.iter().map(of_body).collect()
    };
    let mut reflected = |joined: &[Vec<f32x4>], tolerance: f64| {
        scene.watch.begin_round(1.0 - tolerance.ln() / GATHER_TOLERANCE.ln());
        let options = SolveOptions { tolerance, ..SolveOptions::default() };
        let solutions = prepared.iter().zip(of_bodies(joined)).map(|(one, diffuse)| one.solve(None, &diffuse, options));
        received(&solutions.collect::<Vec<Solution>>())
    };
    of_bodies(&solve_fixed_point(
        &received(first),
        &mut reflected,
        GATHER_TOLERANCE,
        scene.settings.most_rounds as usize,
    ))
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
    fn lighting(&self, scene: &FieldScene, illumination: &Illumination, body_of: &[Option<usize>]) -> Lighting {
        let mut sky = Spectrum::ZERO;
        let skies = illumination.lights.iter().filter(|light| light.is_diffuse());
        skies.filter_map(|light| light.uniform_power()).for_each(|radiance| sky += *radiance);
        let around = Surroundings {
            lights: &illumination.lights,
            reflectance: scene.reflectance,
            most_surfaces: scene.max_bounces.min(MOST_GATHER_SURFACES),
            sky,
        };
        let is_inside = |lamp: &&&LampInSnow| body_of[lamp.object] == body_of[self.solid.object];
        let inside = illumination.lamps.iter().filter(is_inside);
        Lighting {
            entering: entering_light(&self.solid, &self.body, &self.nodes, &illumination.lights, &self.snow),
            paths: GatheredPaths::new(&self.solid, &self.body, &self.nodes, &around),
            sources: inside.map(|lamp| lamp.source(&self.nodes)).collect(),
        }
    }

    /// The solution for light of lamps, if there is any, and the diffuse irradiance H.
    fn solve(&self, lamps: Option<&EnteringLight>, diffuse: &[Vec<f32x4>], options: SolveOptions) -> Solution {
        let (mut entering, mut irradiance) = (diffuse.to_vec(), diffuse.to_vec());
        if let Some(lamps) = lamps {
            add(&mut entering, &lamps.escape_weighted);
            add(&mut irradiance, &lamps.irradiance);
        }
        let groups: Vec<&[f32x4]> = entering.iter().map(Vec::as_slice).collect();
        let fluence = self.body.solve(&groups, options);
        self.solid.watch.add_solution();
        Solution { entering, irradiance, fluence }
    }

    /// The light to be read.
    fn lit(&self, solution: Solution, diffuse: &[Vec<f32x4>], scale: Spectrum) -> LitFluence {
        let is_dark = diffuse.iter().flatten().all(|values| *values == f32x4::ZERO);
        LitFluence {
            diffuse: (!is_dark).then(|| self.body.smooth(diffuse)),
            exitance: self.exitance(&solution),
            fluence: solution.fluence,
            scale,
        }
    }

    /// What the surface sends out, J + Σ F + H.
    fn exitance(&self, solution: &Solution) -> SurfaceValues {
        let entering: Vec<&[f32x4]> = solution.entering.iter().map(Vec::as_slice).collect();
        let mut exitance = solution.irradiance.clone();
        for (group, flux) in exitance.iter_mut().zip(self.body.element_flux(&solution.fluence, &entering)) {
            group.iter_mut().zip(flux).for_each(|(value, flux)| *value += flux);
        }
        self.body.smooth(&exitance)
    }
}

/// Adds the values of each group.
fn add(groups: &mut [Vec<f32x4>], others: &[Vec<f32x4>]) {
    for (group, other) in groups.iter_mut().zip(others) {
        group.iter_mut().zip(other).for_each(|(value, other)| *value += *other);
    }
}
