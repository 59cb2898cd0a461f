//! The light in all snow of a scene, solved for by lights of each spectrum.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use glam::Vec3A;
use snowblue_field::{GROUP, SnowBody, SolveOptions};
use snowblue_geometry::ray::SurfacePoint;
use snowblue_scene::directions::Directions;
use snowblue_scene::light::Light;
use snowblue_scene::progress::Report;
use snowblue_scene::spectrum::Spectrum;
use snowblue_scene::{Changes, Scene, SceneError};

use crate::bodies::SceneBodies;
use crate::body_optics::{BodyOptics, SnowOfMaterials};
use crate::body_solution::{BodySolution, LitFluence};
use crate::bright_snow::{BrightSnow, SnowSeen};
use crate::direct_light::DirectLight;
use crate::exchange::Exchange;
use crate::lit_scene::{Illumination, LampInSnow, LitScene};

/// Relative noise to which the irradiance by other surfaces is smoothed.
const NOISE: f32 = 0.05;

/// The light in all snow of a scene.
#[derive(Debug)]
pub struct LightField {
    bodies: Vec<BodySolution>,
    /// The number of the body of each object.
    body_of: Vec<Option<usize>>,
    lamps_in_snow: Vec<LampInSnow>,
    bright_snow: BrightSnow,
    /// The lights of each solution, by their indices in the scene.
    lights: Vec<Vec<usize>>,
    /// Number of solutions that are not taken from an earlier light field.
    solved_count: usize,
    /// Whether snow that the camera does not see has larger cells.
    has_one_view: bool,
    /// Rounds of light between bodies.
    rounds: u64,
    /// Rays from surfaces of snow to lights and other surfaces.
    rays: u64,
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

/// The light of lights, by their indices in the scene, in each body.
type Solutions = BTreeMap<Vec<usize>, Vec<LitFluence>>;

impl LightField {
    /// Solves for the light in all snow of a scene, and reports the progress. If `has_one_view` holds, snow that the
    /// camera of the scene does not see has larger cells.
    ///
    /// # Errors
    ///
    /// If a body has no grid, or a light other than a point or a sphere lies inside snow.
    pub fn new(
        scene: &Scene,
        snow: &SnowOfMaterials<BodyOptics>,
        has_one_view: bool,
        report: Report,
    ) -> Result<Self, SceneError> {
        let lit_scene = LitScene::new(scene, report)?;
        let bodies = SceneBodies::new(scene, snow, has_one_view, report)?;
        Ok(Self::solve(&lit_scene, bodies, Solutions::new(), has_one_view))
    }

    /// The light field in the same snow of a scene whose lights have changed. It reports the progress, and keeps the
    /// solutions of lights that have not changed. The light field is identical, to the last bit, to a newly computed
    /// light field.
    ///
    /// # Errors
    ///
    /// If a light other than a point or a sphere lies inside snow.
    pub fn after_changes(self, scene: &Scene, changes: &Changes, report: Report) -> Result<Self, SceneError> {
        let lit_scene = LitScene::new(scene, report)?;
        if !(0..scene.lights().len()).any(|light| changes.has_light(light)) {
            return Ok(Self { solved_count: 0, ..self });
        }
        let bodies = self.scene_bodies();
        let unchanged = self.lights.iter().filter(|lights| !lights.iter().any(|light| changes.has_light(*light)));
        let mut known: Solutions = unchanged.map(|lights| (lights.clone(), Vec::new())).collect();
        for body in self.bodies {
            for (lights, lit) in self.lights.iter().zip(body.lit) {
                if let Some(of_bodies) = known.get_mut(lights) {
                    of_bodies.push(lit);
                }
            }
        }
        Ok(Self::solve(&lit_scene, bodies, known, self.has_one_view))
    }

    /// The light field in the same snow by a single light, which need not be a light of the scene. `max_bounces` is
    /// the greatest number of surfaces after the first surface on a path of light.
    pub(crate) fn of_light(&self, scene: &Scene, light: &Arc<Light>, max_bounces: u32, report: Report) -> Self {
        let lit_scene = LitScene::with_light(scene, light, max_bounces, report);
        Self::solve(&lit_scene, self.scene_bodies(), Solutions::new(), self.has_one_view)
    }

    /// Solves for the light of all lights in bodies of snow, except for lights whose solutions are known.
    fn solve(scene: &LitScene, bodies: SceneBodies, mut known: Solutions, has_one_view: bool) -> Self {
        // Lights of one spectrum have a solution.
        let illuminations = scene.illuminations();
        let is_known = |lights: &&Illumination| known.contains_key(&lights.indices);
        let unknown: Vec<&Illumination> = illuminations.iter().filter(|lights| !is_known(lights)).collect();
        let solved_count = unknown.len();
        scene.report_solutions();
        // Paths between surfaces serve all spectra.
        let exchange = Exchange::new(scene, &bodies, &unknown);
        for (number, illumination) in unknown.into_iter().enumerate() {
            let solution = solve_illumination(scene, &bodies, (number, illumination), &exchange);
            known.insert(illumination.indices.clone(), solution);
        }
        drop(exchange);
        // Each body keeps its part of all solutions.
        let with_light = |system| BodySolution { system, lit: Vec::with_capacity(illuminations.len()) };
        let mut solutions: Vec<BodySolution> = bodies.systems.into_iter().map(with_light).collect();
        for illumination in &illuminations {
            let of_bodies = known.remove(&illumination.indices).unwrap_or_default();
            solutions.iter_mut().zip(of_bodies).for_each(|(body, lit)| body.lit.push(lit));
        }
        Self {
            bright_snow: BrightSnow::new(if scene.max_bounces > 0 { &solutions } else { &[] }),
            bodies: solutions,
            body_of: bodies.of_object,
            lamps_in_snow: scene.lamps_in_snow.clone(),
            lights: illuminations.into_iter().map(|illumination| illumination.indices).collect(),
            solved_count,
            has_one_view,
            rounds: scene.rounds.load(Ordering::Relaxed),
            rays: scene.rays.load(Ordering::Relaxed),
        }
    }

    /// The bodies without light.
    fn scene_bodies(&self) -> SceneBodies {
        let systems = self.bodies.iter().map(|body| Arc::clone(&body.system)).collect();
        SceneBodies { systems, of_object: self.body_of.clone() }
    }

    /// The number of solutions that are not taken from an earlier light field.
    pub fn solved_count(&self) -> usize {
        self.solved_count
    }

    /// Whether a light of the scene is a lamp inside snow.
    pub fn is_inside(&self, light: usize) -> bool {
        self.lamps_in_snow.iter().any(|lamp| lamp.light == light && lamp.is_whole)
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
        self.bodies.iter().filter_map(|body| body.system.view_factor).max_by(f64::total_cmp)
    }

    /// Whether the light field is for the pictures of one camera. Snow that this camera does not see has larger cells.
    pub fn has_one_view(&self) -> bool {
        self.has_one_view
    }

    /// The statistics of the light field and of the work on it.
    pub fn statistics(&self) -> FieldStatistics {
        let bodies = || self.bodies.iter().map(|body| &body.system.cells);
        let [solves, iterations] = [0, 1].map(|of| bodies().map(|body| body.solves_and_iterations()[of]).sum());
        FieldStatistics {
            bodies: self.bodies.len(),
            cells: bodies().map(SnowBody::cell_count).sum(),
            nodes: self.node_count(),
            bytes: bodies().map(SnowBody::bytes).sum(),
            groups: self.bodies.first().map_or(0, |body| body.system.nodes.indices().len() / GROUP),
            lights: self.lights.len(),
            solves,
            iterations,
            rounds: self.rounds,
            rays: self.rays,
        }
    }

    /// Unknowns of a solution at each wavelength, of all bodies.
    pub(crate) fn node_count(&self) -> usize {
        self.bodies.iter().map(|body| body.system.cells.node_count()).sum()
    }

    /// The light in the body that an object of snow belongs to.
    #[inline]
    pub fn of_object(&self, object: usize) -> Option<&BodySolution> {
        self.body_of[object].map(|body| &self.bodies[body])
    }
}

/// Solves for the light in each body by the lights of one spectrum, with their number among the spectra of the
/// exchange.
fn solve_illumination(
    scene: &LitScene,
    bodies: &SceneBodies,
    (number, illumination): (usize, &Illumination),
    exchange: &Exchange,
) -> Vec<LitFluence> {
    // The light of lamps and skies enters each body.
    let of_lights = |system| DirectLight::new(scene, system, illumination);
    let direct: Vec<DirectLight> = bodies.systems.iter().map(|system| of_lights(system)).collect();
    // Bodies and other surfaces exchange light until it is in balance.
    let (diffuse, starts) = exchange.balance(number, &direct);
    let spectrum = illumination.spectrum.unwrap_or_else(|| mean_spectrum(&direct));
    // The solution inside each body follows from all light that enters.
    let bodies = direct.iter().zip(diffuse).enumerate().map(|(body, (direct, mut diffuse))| {
        direct.system.cells.denoise(&mut diffuse, NOISE);
        let fluence = direct.solve(&diffuse, SolveOptions { start: starts.get(body), ..SolveOptions::default() });
        scene.add_solution();
        LitFluence::new(illumination, direct, &diffuse, fluence, spectrum)
    });
    bodies.collect()
}

/// The spectrum of the light on all bodies; white if there is none.
fn mean_spectrum(direct: &[DirectLight]) -> Spectrum {
    let mut sum = Spectrum::ZERO;
    direct.iter().for_each(|direct| sum += direct.spectrum);
    if sum.maximum() > 0.0 { sum } else { Spectrum::ONE }
}
