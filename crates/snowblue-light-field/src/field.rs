//! The light in all snow of a scene, solved for by lights of each spectrum.

use glam::Vec3A;
use snowblue_field::{FieldError, GROUP, LayerSpectrum, SnowBody, SolveOptions, SpectralNodes, Survey};
use snowblue_geometry::ray::SurfacePoint;
use snowblue_scene::directions::Directions;
use snowblue_scene::objects::SurfaceInteraction;
use snowblue_scene::spectrum::Spectrum;

use crate::body_solution::{BodySolution, LitFluence};
use crate::body_system::{BodySystem, Lighting, SurveyedBody};
use crate::bright_snow::{BrightSnow, SnowSeen};
use crate::exchange::{Balance, Exchange, JoinedPatches};
use crate::field_scene::{BodyGeometry, FieldScene, SolveStatistics};
use crate::gather::{GatherScene, GatheredPaths, LightsAround, PlaceOnSnow};
use crate::illumination::{Illumination, LampInSnow, illuminations};
use crate::surface_light::NOISE;

/// Greatest number of bodies of snow. Each body has a grid, and is lit by all other bodies.
const MAX_BODIES: usize = 1000;

/// The light in all snow of a scene.
#[derive(Debug)]
pub struct LightField {
    bodies: Vec<BodySolution>,
    /// The body of each object.
    body_of: Vec<Option<usize>>,
    lamps_in_snow: Vec<LampInSnow>,
    bright_snow: BrightSnow,
    /// The lights of each solution, by their indices in the scene.
    lights: Vec<Vec<usize>>,
    /// Number of solutions that are not taken from an earlier light field.
    solved_count: usize,
    /// Whether snow that the camera does not see has larger cells.
    has_one_view: bool,
    work: SolveStatistics,
}

/// Statistics of a light field and of the work on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FieldStatistics {
    /// Bodies of snow.
    pub bodies: usize,
    /// Cells of all bodies.
    pub cells: usize,
    /// Unknowns at each wavelength, of all bodies.
    pub nodes: usize,
    /// Approximate memory of the grids and their systems of equations, in bytes.
    pub bytes: usize,
    /// Groups of four wavelengths at which light is solved for.
    pub groups: usize,
    /// Sets of lights of one spectrum.
    pub lights: usize,
    /// Solutions in a body for a group of wavelengths, since the cells were made.
    pub solves: u64,
    /// Iterations of conjugate gradients in all solutions.
    pub iterations: u64,
    /// Rounds of light between bodies. Each takes a solution in each body.
    pub rounds: u64,
    /// Rays from surfaces of snow to lights and other surfaces.
    pub rays: u64,
}

/// A solution: the indices of its lights in the scene, and its light in each body.
type LitBodies = (Vec<usize>, Vec<LitFluence>);

impl LightField {
    /// Solves for the light of all bodies.
    ///
    /// # Errors
    ///
    /// With the object's index and the reason, if a body has no grid.
    pub(crate) fn new(scene: &FieldScene) -> Result<Self, (usize, String)> {
        scene.watch.cells(0, 0);
        let mut body_of = vec![None; scene.objects.list().len()];
        let mut bare: Vec<SurveyedBody> = Vec::new();
        for object in 0..body_of.len() {
            if body_of[object].is_some() {
                continue;
            }
            let Some(snow) = (scene.snow)(object) else { continue };
            if bare.len() == MAX_BODIES {
                return Err((
                    object,
                    format!(
                        "is one body of snow more than the {MAX_BODIES} that this integrator takes: give touching \
                         objects the same 'body'"
                    ),
                ));
            }
            scene.objects.body_of(object).iter().for_each(|member| body_of[*member] = Some(bare.len()));
            let solid = BodyGeometry::new(scene, object)
                .ok_or_else(|| (object, "is infinite: only pcasnow can render infinite snow".to_owned()))?;
            let survey = Survey::new(&solid).map_err(|error| (object, error.to_string()))?;
            bare.push(SurveyedBody { solid, snow, survey });
        }
        let refusal = |object: usize| move |error: FieldError| (object, error.to_string());
        // All bodies have the same wavelengths, so that light can pass between them.
        let spectra: Vec<Vec<LayerSpectrum>> =
            bare.iter().map(|body| body.snow.spectra(body.survey.mean_thickness_m())).collect();
        let nodes = (!spectra.is_empty()).then(|| SpectralNodes::for_bodies(&spectra));
        let count = bare.len();
        let mut prepared = Vec::with_capacity(count);
        if let Some(nodes) = &nodes {
            let groups = nodes.indices().len() / GROUP;
            let wanted = bare.iter().map(|body| body.wanted_mib(groups, scene).map_err(refusal(body.solid.object)));
            let memory_mib = memory_of_each(wanted.collect::<Result<_, _>>()?, scene.settings.memory_mib());
            for body in bare {
                scene.watch.cells(prepared.len(), count);
                let object = body.solid.object;
                prepared.push(BodySystem::new(body, nodes, scene, memory_mib).map_err(refusal(object))?);
            }
        }
        Ok(Self::lit(prepared, body_of, scene, Vec::new()))
    }

    /// Solves again for the lights for which `has_changed` holds, in the same bodies, and keeps the solutions of the
    /// other lights. The light field is identical, to the last bit, to a newly computed light field.
    pub(crate) fn relit(self, scene: &FieldScene, has_changed: &dyn Fn(usize) -> bool) -> Self {
        if !(0..scene.lights.len()).any(has_changed) {
            return Self { solved_count: 0, ..self };
        }
        let (prepared, mut solutions, body_of) = self.into_parts(scene);
        solutions.retain(|(lights, _)| !lights.iter().any(|light| has_changed(*light)));
        Self::lit(prepared, body_of, scene, solutions)
    }

    /// The bodies without light, the solutions, and the body of each object.
    fn into_parts<'s>(self, scene: &'s FieldScene) -> (Vec<BodySystem<'s>>, Vec<LitBodies>, Vec<Option<usize>>) {
        let Self { bodies, body_of, lights, .. } = self;
        let mut solutions: Vec<LitBodies> = lights.into_iter().map(|lights| (lights, Vec::new())).collect();
        let prepared = bodies.into_iter().enumerate().map(|(number, one)| {
            let object = body_of.iter().position(|body| *body == Some(number));
            let solid = object.and_then(|object| BodyGeometry::new(scene, object));
            let BodySolution { body, lit, nodes, snow, transport_length, view_factor } = one;
            solutions.iter_mut().zip(lit).for_each(|((_, bodies), lit)| bodies.push(lit));
            let solid = solid.expect("a body with a light field has an object and bounds");
            BodySystem { solid, body, nodes, snow, transport_length, view_factor }
        });
        (prepared.collect(), solutions, body_of)
    }

    /// Solves for the light in bodies, except for lights whose solutions are known.
    fn lit(
        prepared: Vec<BodySystem>,
        body_of: Vec<Option<usize>>,
        scene: &FieldScene,
        mut known: Vec<LitBodies>,
    ) -> Self {
        let mut lit: Vec<Vec<LitFluence>> = prepared.iter().map(|_| Vec::new()).collect();
        let illuminations = illuminations(scene.lights, scene.lamps_in_snow);
        let is_known = |illumination: &&Illumination| known.iter().any(|(lights, _)| *lights == illumination.indices);
        let unknown: Vec<&Illumination> = illuminations.iter().filter(|illumination| !is_known(illumination)).collect();
        let solved_count = unknown.len();
        scene.watch.light();
        let mut solved = solve(scene, &unknown, &prepared, &body_of).into_iter();
        let mut lights = Vec::new();
        for illumination in illuminations {
            let of_bodies = match known.iter().position(|(lights, _)| *lights == illumination.indices) {
                Some(number) => known.swap_remove(number).1,
                None => solved.next().unwrap_or_default(),
            };
            lit.iter_mut().zip(of_bodies).for_each(|(lit, one)| lit.push(one));
            lights.push(illumination.indices);
        }
        let bodies = prepared.into_iter().zip(lit).map(|(one, lit)| {
            let BodySystem { body, nodes, snow, transport_length, view_factor, .. } = one;
            BodySolution { body, lit, nodes, snow, transport_length, view_factor }
        });
        let bodies: Vec<BodySolution> = bodies.collect();
        let bright_snow = BrightSnow::new(if scene.max_bounces > 0 { &bodies } else { &[] });
        Self {
            bodies,
            body_of,
            lamps_in_snow: scene.lamps_in_snow.to_vec(),
            bright_snow,
            lights,
            solved_count,
            has_one_view: scene.has_one_view,
            work: scene.watch.work(),
        }
    }

    /// The number of solutions that are not taken from an earlier light field.
    pub fn solved_count(&self) -> usize {
        self.solved_count
    }

    /// Whether a light of the scene is a lamp inside snow.
    pub fn is_inside(&self, light: usize) -> bool {
        self.parts_inside(light).any(|part| part.is_whole)
    }

    /// The parts of a light of the scene that are inside snow.
    pub(crate) fn parts_inside(&self, light: usize) -> impl Iterator<Item = &LampInSnow> {
        self.lamps_in_snow.iter().filter(move |lamp| lamp.light == light)
    }

    /// Samples the direction of a path that continues from a surface, from three numbers in [0, 1). Half of the paths
    /// go towards bright snow, and the other half are sampled by `directions`. Returns the direction with the factor
    /// cos θ / (π p) of the path's throughput, where p is the density of the direction.
    pub fn sample_reflection(&self, directions: &Directions, numbers: [f32; 3]) -> (Vec3A, f32) {
        self.bright_snow.sample(directions, numbers)
    }

    /// Approximates the snow that another surface sees, as if no part of the snow hid another part.
    pub fn snow_seen_from(&self, surface: &SurfacePoint) -> SnowSeen {
        self.bright_snow.seen_from(surface)
    }

    /// If cell sizes are for a viewer: the greatest factor of these sizes that makes the cells fit into the memory.
    pub fn view_factor(&self) -> Option<f64> {
        self.bodies.iter().filter_map(|body| body.view_factor).max_by(f64::total_cmp)
    }

    /// Whether the light field is for the pictures of one camera. Snow that this camera does not see has larger cells.
    pub fn has_one_view(&self) -> bool {
        self.has_one_view
    }

    /// The statistics of the light field and of the work on it.
    pub fn statistics(&self) -> FieldStatistics {
        let bodies = || self.bodies.iter().map(|body| &body.body);
        let [solves, iterations] = [0, 1].map(|of| bodies().map(|body| body.solves_and_iterations()[of]).sum());
        FieldStatistics {
            bodies: self.bodies.len(),
            cells: bodies().map(SnowBody::cell_count).sum(),
            nodes: self.node_count(),
            bytes: bodies().map(SnowBody::bytes).sum(),
            groups: self.bodies.first().map_or(0, |body| body.nodes.indices().len() / GROUP),
            lights: self.lights.len(),
            solves,
            iterations,
            rounds: self.work.rounds,
            rays: self.work.rays,
        }
    }

    /// Unknowns of a solution at each wavelength, of all bodies.
    pub(crate) fn node_count(&self) -> usize {
        self.bodies.iter().map(|body| body.body.node_count()).sum()
    }

    /// The light in the body that an object of snow belongs to.
    #[inline]
    pub fn of_object(&self, object: usize) -> Option<&BodySolution> {
        self.body_of[object].map(|body| &self.bodies[body])
    }
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

/// Greatest number of diffuse surfaces between two pieces of snow.
const MAX_GATHER_SURFACES: u32 = 8;

/// Solves for the light of each of some illuminations in all bodies.
pub(super) fn solve(
    scene: &FieldScene,
    illuminations: &[&Illumination],
    prepared: &[BodySystem],
    body_of: &[Option<usize>],
) -> Vec<Vec<LitFluence>> {
    if illuminations.is_empty() {
        return Vec::new();
    }
    let patches = JoinedPatches::new(prepared);
    let paths = gathered_paths(scene, illuminations, (prepared, &patches), body_of);
    let exchange = paths.iter().any(GatheredPaths::reach_snow).then(|| Exchange::new(prepared, &patches, &paths));
    let solve = |(number, illumination): (usize, &&Illumination)| {
        let lightings: Vec<Lighting> = prepared.iter().map(|body| body.lighting(illumination, body_of)).collect();
        let steady = paths.iter().map(|paths| paths.steady(number).clone()).collect();
        let balance = match &exchange {
            Some(exchange) => exchange.balance(&lightings, steady, scene),
            None => Balance { diffuse: steady, fluences: Vec::new() },
        };
        let spectrum = illumination.spectrum.unwrap_or_else(|| mean_spectrum(&lightings));
        let is_of_sky = illumination.lights.iter().all(|light| light.is_smooth_sky());
        let Balance { diffuse, fluences } = balance;
        let bodies = prepared.iter().zip(&lightings).zip(diffuse).enumerate();
        let lit = bodies.map(|(number, ((prepared, lighting), mut diffuse))| {
            prepared.body.denoise(&mut diffuse, NOISE);
            let options = SolveOptions { start: fluences.get(number), ..SolveOptions::default() };
            let solution = prepared.solve(lighting, &diffuse, options);
            let sky = is_of_sky.then_some(&lighting.entering.irradiance);
            prepared.lit(solution, &diffuse, sky, spectrum)
        });
        lit.collect()
    };
    illuminations.iter().enumerate().map(solve).collect()
}

/// Traces paths from the surface of each body to snow, other surfaces and uniform skies.
fn gathered_paths(
    scene: &FieldScene,
    illuminations: &[&Illumination],
    (prepared, patches): (&[BodySystem], &JoinedPatches),
    body_of: &[Option<usize>],
) -> Vec<GatheredPaths> {
    let place_at = |hit: &SurfaceInteraction| {
        let number = body_of[hit.object]?;
        let surface = hit.surface_point();
        let (point, normal) = (surface.point.as_dvec3(), surface.normal.as_dvec3());
        let body = &prepared[number].body;
        let place = body.surface_place(point, normal)?;
        Some(PlaceOnSnow { body: u32::try_from(number).ok()?, place, patch: patches.at(number, body, &place) })
    };
    let lit = illuminations.iter().map(|illumination| {
        let mut sky = Spectrum::ZERO;
        let skies = illumination.lights.iter().filter(|light| light.is_diffuse());
        skies.filter_map(|light| light.uniform_power()).for_each(|radiance| sky += *radiance);
        LightsAround { lights: &illumination.lights, sky }
    });
    let around = GatherScene {
        lit: lit.collect(),
        reflectance: scene.reflectance,
        most_surfaces: scene.max_bounces.min(MAX_GATHER_SURFACES),
        place_at: &place_at,
    };
    prepared.iter().map(|body| GatheredPaths::new(&body.solid, &body.body, &body.nodes, &around)).collect()
}

/// The spectrum of the light on all bodies; white if there is none.
fn mean_spectrum(lightings: &[Lighting]) -> Spectrum {
    let mut sum = Spectrum::ZERO;
    lightings.iter().for_each(|lighting| sum += lighting.entering.spectrum);
    if sum.maximum() > 0.0 { sum } else { Spectrum::ONE }
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
