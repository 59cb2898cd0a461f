//! The light field inside each body of snow of a scene, for the integrators `diffusion` and `hybrid`.
//!
//! The light that enters at the surface, of lamps ([`surface_light`]) and by other surfaces ([`gather`]), determines
//! the fluence rate inside ([`snowblue_field`]), and that the net flux J through the surface at each wavelength. Snow
//! then sends out
//!
//! L(μ) = Σ R₀(μ, μ₀, Δϕ) F + K(μ) J/π.

mod bright_snow;
mod gather;
mod illumination;
mod near_light;
mod snowpack;
mod solid;
mod surface_light;

#[cfg(test)]
mod depth_tests;
#[cfg(test)]
mod tests;

use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

use glam::{DVec3, Vec3A};
use snowblue_field::{
    CellSizes, FieldError, Fluence, GridOptions, MOST_GROUPS, ScaledSizes, SizesByDistance, SnowBody, SolveOptions,
    SpectralNodes, SurfaceValues, Survey, VolumeSource, fit_sizes, solve_fixed_point,
};
use snowblue_transport::monte_carlo::WalkEnds;
use wide::f32x4;

use crate::geometry::ray::{SurfacePoint, narrow};
use crate::scene::integrator::LightFieldSettings;
use crate::scene::light::Light;
use crate::scene::objects::{Objects, SurfaceInteraction};
use crate::spectrum::Spectrum;

use bright_snow::BrightSnow;
use gather::{Exitance, GatheredPaths, Surroundings};
pub(crate) use illumination::LampInSnow;
use illumination::{Illumination, illuminations};
pub(crate) use near_light::{LightWeights, NearLight};
pub(crate) use snowpack::{SnowLayer, Snowpack};
pub(crate) use solid::Solid;
use surface_light::{EnteringLight, NOISE, entering_light};
pub(crate) use surface_light::{LitPoint, visit_lights};

/// How deep random walks end in the light field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum EndDepth {
    /// Under a surface that is flat for some transport mean free paths around.
    Flat,
    /// Near edges, and in bodies that are small or thin.
    Edge,
}

impl EndDepth {
    /// Both.
    pub(crate) const ALL: [Self; 2] = [Self::Flat, Self::Edge];

    /// The depth below the nearest surface from which on walks end, in transport mean free paths.
    ///
    /// Under flat surfaces light is diffuse from one on: the radiance is right within 1 %. Nearer to an edge than 10 it
    /// loses 7 % with an end at 1, 3 % at 2. An end at 1 halves the noise.
    pub(crate) const fn lengths(self) -> f32 {
        match self {
            Self::Flat => 1.0,
            Self::Edge => 2.0,
        }
    }
}

/// Where random walks end, for each depth.
pub(crate) type WalkEndsByDepth = [WalkEnds; EndDepth::ALL.len()];

/// Most reflections of light between pieces of snow that are computed.
const MOST_REFLECTIONS: usize = 40;
/// Relative residual of the light that snow receives from snow, over all surfaces. The light in a cave may be a small
/// part of that outside, and its error is some thirty times the residual there.
const GATHER_TOLERANCE: f64 = 1e-5;
/// Most diffuse surfaces between two pieces of snow.
const MOST_GATHER_SURFACES: u32 = 8;
/// Greatest cells of a wide body at its surface, in m.
const GREATEST_CELL_M: f64 = 1.0;
/// Most bodies of snow. Each has a grid, and is lit by all others.
const MOST_BODIES: usize = 1000;
/// Most spectral nodes.
const MOST_NODES: usize = MOST_GROUPS * snowblue_field::GROUP;

/// The light in all snow of a scene.
#[derive(Debug)]
pub(crate) struct LightField {
    bodies: Vec<BodyField>,
    /// The body of each object.
    body_of: Vec<Option<usize>>,
    lamps_in_snow: Vec<LampInSnow>,
    bright_snow: BrightSnow,
    /// The lights of each solution, by their indices in the scene.
    lights: Vec<Vec<usize>>,
    /// Solutions that are not of an earlier light field.
    solved_count: usize,
}

/// The light in a body of snow.
pub(crate) struct BodyField {
    body: SnowBody,
    /// For lights of each spectrum.
    lit: Vec<LitFluence>,
    nodes: SpectralNodes,
    snow: Arc<Snowpack>,
    /// ℓ* of the whole pack at each wavelength, in m.
    transport_lengths_m: Vec<f64>,
    /// If its cells have sizes for a viewer: the factor of these sizes that makes them fit into the memory.
    view_factor: Option<f64>,
}

/// The light at a point of the surface of a body, with the snow there.
#[derive(Clone, Copy)]
pub(crate) struct SnowAt<'f> {
    pub(crate) field: &'f BodyField,
    /// The number of the layer.
    pub(crate) number: usize,
    pub(crate) layer: &'f SnowLayer,
}

/// The light in a body by lights of one spectrum.
struct LitFluence {
    fluence: Fluence,
    /// What the surface sends out, J + Σ F + H.
    exitance: SurfaceValues,
    /// The irradiance H by uniform skies and other surfaces, if there is any.
    diffuse: Option<SurfaceValues>,
    /// ℓ* times the spectrum: spectra over this are smooth in the absorption.
    scale: Spectrum,
}

/// What the light field needs of a scene.
pub(crate) struct FieldScene<'a> {
    pub(crate) objects: &'a Objects,
    pub(crate) lights: &'a [Light],
    /// The snow of an object, if it is snow.
    pub(crate) snow: &'a dyn Fn(usize) -> Option<Arc<Snowpack>>,
    /// Those of the lights that are inside snow.
    pub(crate) lamps_in_snow: &'a [LampInSnow],
    /// The reflectance of a diffuse surface; none for snow.
    pub(crate) reflectance: &'a (dyn Fn(&SurfaceInteraction) -> Option<Spectrum> + Sync),
    /// Most surfaces after the first on a path of light.
    pub(crate) max_bounces: u32,
    /// Who looks, if it is known: a wide body has small cells only where they are seen.
    pub(crate) viewer: Option<Viewer>,
    /// Memory and cells of the grid of a body.
    pub(crate) settings: LightFieldSettings,
}

/// A viewpoint, and the fineness of its picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Viewer {
    /// Where it is, in m.
    pub(crate) position: Vec3A,
    /// Angle of a pixel, in rad.
    pub(crate) pixel_rad: f64,
}

impl Viewer {
    /// Sizes of the cells of a wide body.
    fn sizes(&self) -> SizesByDistance {
        SizesByDistance::of_picture(self.position.as_dvec3(), self.pixel_rad, GREATEST_CELL_M)
    }
}

/// A body before its light is known.
struct PreparedBody<'a> {
    solid: Solid<'a>,
    body: SnowBody,
    nodes: SpectralNodes,
    snow: Arc<Snowpack>,
    /// ℓ* of the whole pack at each wavelength, in m.
    transport_lengths_m: Vec<f64>,
    /// If its cells have sizes for a viewer: the factor of these sizes that makes them fit into the memory.
    view_factor: Option<f64>,
    /// The solution for other light, from which the next starts.
    before: Option<Fluence>,
}

/// A solution: its lights, by their indices in the scene, and what it is in each body.
type LitBodies = (Vec<usize>, Vec<LitFluence>);

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

impl LightField {
    /// Solves for the light of all bodies.
    ///
    /// # Errors
    ///
    /// With the object's index and the reason, if a body has no grid.
    pub(crate) fn new(scene: &FieldScene) -> Result<Self, (usize, String)> {
        let mut body_of = vec![None; scene.objects.list().len()];
        let mut solids = Vec::new();
        for object in 0..body_of.len() {
            if body_of[object].is_some() {
                continue;
            }
            let Some(snow) = (scene.snow)(object) else { continue };
            if solids.len() == MOST_BODIES {
                return Err((
                    object,
                    format!(
                        "is one body of snow more than the {MOST_BODIES} that this integrator takes: give touching \
                         objects the same 'body'"
                    ),
                ));
            }
            scene.objects.body_of(object).iter().for_each(|member| body_of[*member] = Some(solids.len()));
            let solid = Solid::new(scene.objects, object)
                .ok_or_else(|| (object, "is infinite: only pcasnow can render infinite snow".to_owned()))?;
            let survey = Survey::new(&solid).map_err(|error| (object, error.to_string()))?;
            solids.push((solid, snow, survey));
        }
        // The thickest body needs the most wavelengths, and all bodies have the same, so that light can pass between.
        let thickest = solids
            .iter()
            .max_by(|(_, _, one), (_, _, other)| one.mean_thickness_m().total_cmp(&other.mean_thickness_m()));
        let nodes =
            thickest.map(|(_, snow, survey)| SpectralNodes::for_layers(&snow.spectra(survey.mean_thickness_m())));
        let mut prepared = Vec::with_capacity(solids.len());
        for (solid, snow, survey) in solids {
            let Some(nodes) = &nodes else { break };
            let object = solid.object;
            let one = PreparedBody::new(solid, &survey, snow, nodes, scene);
            prepared.push(one.map_err(|reason| (object, reason))?);
        }
        Ok(Self::lit(prepared, body_of, scene, Vec::new()))
    }

    /// Solves for the light of other lamps in the same bodies. The solutions start from one of the present light, so
    /// they depend on it within their tolerance.
    pub(crate) fn relit(self, scene: &FieldScene) -> Self {
        let (mut prepared, solutions, body_of) = self.into_parts(scene.objects);
        if let Some((_, lit)) = solutions.into_iter().next() {
            prepared.iter_mut().zip(lit).for_each(|(one, lit)| one.before = Some(lit.fluence));
        }
        Self::lit(prepared, body_of, scene, Vec::new())
    }

    /// Solves for the light of those lights in the same bodies for which `has_changed`, and keeps the solutions of the
    /// others. The light field is the same, to the last bit, as a new one.
    pub(crate) fn relit_where_changed(self, scene: &FieldScene, has_changed: &dyn Fn(usize) -> bool) -> Self {
        let (prepared, mut solutions, body_of) = self.into_parts(scene.objects);
        solutions.retain(|(lights, _)| !lights.iter().any(|light| has_changed(*light)));
        Self::lit(prepared, body_of, scene, solutions)
    }

    /// The bodies without light, the solutions, and the body of each object.
    fn into_parts(self, objects: &Objects) -> (Vec<PreparedBody<'_>>, Vec<LitBodies>, Vec<Option<usize>>) {
        let Self { bodies, body_of, lights, .. } = self;
        let mut solutions: Vec<LitBodies> = lights.into_iter().map(|lights| (lights, Vec::new())).collect();
        let prepared = bodies.into_iter().enumerate().map(|(number, one)| {
            let object = body_of.iter().position(|body| *body == Some(number));
            let solid = object.and_then(|object| Solid::new(objects, object));
            let BodyField { body, lit, nodes, snow, transport_lengths_m, view_factor } = one;
            solutions.iter_mut().zip(lit).for_each(|((_, bodies), lit)| bodies.push(lit));
            let solid = solid.expect("a body with a light field has an object and bounds");
            PreparedBody { solid, body, nodes, snow, transport_lengths_m, view_factor, before: None }
        });
        (prepared.collect(), solutions, body_of)
    }

    /// Solves for the light in bodies where it is not known.
    fn lit(
        prepared: Vec<PreparedBody>,
        body_of: Vec<Option<usize>>,
        scene: &FieldScene,
        mut known: Vec<LitBodies>,
    ) -> Self {
        let mut lit: Vec<Vec<LitFluence>> = prepared.iter().map(|_| Vec::new()).collect();
        let (mut lights, mut solved_count) = (Vec::new(), 0);
        for illumination in illuminations(scene.lights, scene.lamps_in_snow) {
            let of_bodies = match known.iter().position(|(lights, _)| *lights == illumination.indices) {
                Some(number) => known.swap_remove(number).1,
                None => {
                    solved_count += 1;
                    solve(scene, &illumination, &prepared, &body_of)
                }
            };
            lit.iter_mut().zip(of_bodies).for_each(|(lit, one)| lit.push(one));
            lights.push(illumination.indices);
        }
        let bodies = prepared.into_iter().zip(lit).map(|(one, lit)| {
            let PreparedBody { body, nodes, snow, transport_lengths_m, view_factor, .. } = one;
            BodyField { body, lit, nodes, snow, transport_lengths_m, view_factor }
        });
        let bodies: Vec<BodyField> = bodies.collect();
        let bright_snow = BrightSnow::new(if scene.max_bounces > 0 { &bodies } else { &[] });
        Self { bodies, body_of, lamps_in_snow: scene.lamps_in_snow.to_vec(), bright_snow, lights, solved_count }
    }

    /// The number of its solutions that are not of an earlier light field.
    pub(crate) fn solved_count(&self) -> usize {
        self.solved_count
    }

    /// A light of the scene as a lamp inside snow, if it is one.
    pub(crate) fn lamp_inside(&self, light: usize) -> Option<&LampInSnow> {
        self.lamps_in_snow.iter().find(|lamp| lamp.light == light)
    }

    /// Samples the direction of a path that goes on from a diffuse surface, from three numbers in [0, 1): half of the
    /// paths go towards bright snow. Returns it with the factor cos θ / (π p) of the path's throughput, p its density.
    pub(crate) fn sample_reflection(&self, surface: &SurfacePoint, numbers: [f32; 3]) -> (Vec3A, f32) {
        self.bright_snow.sample(surface, numbers)
    }

    /// If cells have sizes for a viewer: the greatest factor of these sizes that makes them fit into the memory.
    pub(crate) fn view_factor(&self) -> Option<f64> {
        self.bodies.iter().filter_map(|body| body.view_factor).max_by(f64::total_cmp)
    }

    /// Unknowns of a solution at each wavelength, of all bodies.
    pub(crate) fn node_count(&self) -> usize {
        self.bodies.iter().map(|body| body.body.node_count()).sum()
    }

    /// The light in the body that an object of snow belongs to.
    #[inline]
    pub(crate) fn of_object(&self, object: usize) -> Option<&BodyField> {
        self.body_of[object].map(|body| &self.bodies[body])
    }
}

/// Solves for the light of lights of one spectrum in all bodies.
fn solve(
    scene: &FieldScene,
    illumination: &Illumination,
    prepared: &[PreparedBody],
    body_of: &[Option<usize>],
) -> Vec<LitFluence> {
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
        for (diffuse, by_snow) in diffuse.iter_mut().zip(irradiance_by_snow(prepared, &lightings, &first, body_of)) {
            add(diffuse, &by_snow);
        }
    }
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
        let options = SolveOptions { tolerance, ..SolveOptions::default() };
        let solutions = prepared.iter().zip(of_bodies(joined)).map(|(one, diffuse)| one.solve(None, &diffuse, options));
        received(&solutions.collect::<Vec<Solution>>())
    };
    of_bodies(&solve_fixed_point(&received(first), &mut reflected, GATHER_TOLERANCE, MOST_REFLECTIONS))
}

impl<'a> PreparedBody<'a> {
    fn new(
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
        let step_mm = scene.settings.step_mm;
        let viewer = scene.viewer.filter(|_| step_mm.is_none() && survey.is_wide(shortest_m, groups, memory_mib));
        let viewer_sizes = viewer.map(|viewer| viewer.sizes());
        let step_m = match step_mm {
            Some(step_mm) => survey.check_step_m(1e-3 * step_mm, shortest_m, groups, memory_mib),
            None if viewer.is_some() => Ok(survey.finest_step_m(shortest_m)),
            None => survey.choose_step_m(shortest_m, groups, memory_mib),
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
        let body = SnowBody::new(&solid, options, groups, &of_cell, snow.top().half_space().extrapolation());
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

impl BodyField {
    /// The light at a point of the surface, with the snow there. `object` is the object at the point.
    #[inline]
    pub(crate) fn at(&self, objects: &Objects, object: usize, surface: &SurfacePoint) -> SnowAt<'_> {
        let number = self.snow.number_at(objects, object, surface);
        SnowAt { field: self, number, layer: &self.snow.layers[number] }
    }

    /// The snow.
    pub(crate) fn snow(&self) -> &Arc<Snowpack> {
        &self.snow
    }

    /// The irradiance H by uniform skies and other surfaces, in W m⁻² as a band density.
    pub(crate) fn diffuse_irradiance(&self, surface: &SurfacePoint) -> Spectrum {
        let (point, normal) = (surface.point.as_dvec3(), surface.normal.as_dvec3());
        self.sum(|lit| {
            let groups = self.body.surface_value(lit.diffuse.as_ref()?, point, normal)?;
            Some(self.spectrum(groups, &lit.scale))
        })
    }

    /// Radiance that leaves a surface point, the same in all directions: the exitance over π.
    pub(crate) fn mean_radiance(&self, surface: &SurfacePoint) -> Spectrum {
        self.exitance(surface.point, surface.normal) * FRAC_1_PI
    }

    /// The fluence rate inside, in W m⁻² as a band density.
    pub(crate) fn fluence(&self, point: Vec3A) -> Spectrum {
        self.sum(|lit| Some(self.spectrum(self.body.fluence(&lit.fluence, point.as_dvec3())?, &lit.scale)))
    }

    /// Size of the cells at the surface, in m.
    pub(crate) fn step_m(&self) -> f64 {
        self.body.step_m()
    }

    /// What leaves the surface, the net flux and the irradiance, in W m⁻² as a band density.
    pub(crate) fn exitance(&self, point: Vec3A, normal: Vec3A) -> Spectrum {
        let (point, normal) = (point.as_dvec3(), normal.as_dvec3());
        self.sum(|lit| Some(self.spectrum(self.body.surface_value(&lit.exitance, point, normal)?, &lit.scale)))
    }

    /// What leaves the surface, as a sum over the spectral nodes.
    fn brightness(&self, surface: &SurfacePoint) -> f32 {
        let (point, normal) = (surface.point.as_dvec3(), surface.normal.as_dvec3());
        let values = self.lit.iter().filter_map(|lit| self.body.surface_value(&lit.exitance, point, normal));
        values.flatten().map(f32x4::reduce_add).sum()
    }

    /// The net flux outwards through the surface, in W m⁻² as a band density.
    pub(crate) fn flux(&self, point: Vec3A, normal: Vec3A) -> Spectrum {
        let (point, normal) = (point.as_dvec3(), normal.as_dvec3());
        self.sum(|lit| Some(self.spectrum(self.body.flux(&lit.fluence, point, normal)?, &lit.scale)))
    }

    /// The sum over the lights of all spectra.
    fn sum(&self, term: impl Fn(&LitFluence) -> Option<Spectrum>) -> Spectrum {
        let mut sum = Spectrum::ZERO;
        self.lit.iter().filter_map(term).for_each(|spectrum| sum += spectrum);
        sum
    }

    /// All wavelengths of a quantity at the spectral nodes: by its logarithm, or directly where it is not positive.
    fn spectrum(&self, groups: impl Iterator<Item = f32x4>, scale: &Spectrum) -> Spectrum {
        let mut at_nodes = [0.0; MOST_NODES];
        for (values, group) in at_nodes.chunks_exact_mut(snowblue_field::GROUP).zip(groups) {
            values.copy_from_slice(group.as_array());
        }
        let indices = self.nodes.indices();
        let at_nodes = &mut at_nodes[..indices.len()];
        let is_positive = at_nodes.iter().all(|value| *value > 0.0);
        for (value, index) in at_nodes.iter_mut().zip(indices) {
            let scale = scale.0[*index];
            *value = if scale > 0.0 { *value / scale } else { 0.0 };
            if is_positive {
                *value = value.max(f32::MIN_POSITIVE).ln();
            }
        }
        let value = |wavelength: usize| {
            let value = self.nodes.interpolate(wavelength, at_nodes);
            (if is_positive { value.exp() } else { value }) * scale.0[wavelength]
        };
        Spectrum(std::array::from_fn(value))
    }
}

impl SnowAt<'_> {
    /// Radiance that leaves a surface point without that of directed light, (K(μ) J + H)/π, in W m⁻² sr⁻¹ as a band
    /// density. It may be negative where the surface is lit: it lacks what does not return of the light that the
    /// reflection function reflects.
    pub(crate) fn diffuse_radiance(&self, surface: &SurfacePoint, cos_exit: f32) -> Spectrum {
        let flux = self.field.flux(surface.point, surface.normal) * (self.layer.escape(cos_exit) * FRAC_1_PI);
        let mut sum = self.field.diffuse_irradiance(surface) * FRAC_1_PI;
        sum += flux;
        sum
    }
}

impl std::fmt::Debug for BodyField {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("BodyField").field("nodes", &self.body.node_count()).finish_non_exhaustive()
    }
}
