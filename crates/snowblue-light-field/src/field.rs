//! The light in all snow of a scene, solved for by lights of each spectrum.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use glam::Vec3A;
use snowblue_field::{SnowBody, SolveOptions};
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
use crate::direct_light::LightOnBody;
use crate::exchange::Exchange;
use crate::lit_scene::{LitScene, with_all_wavelengths};

/// Relative noise to which the irradiance by other surfaces is smoothed.
const NOISE: f32 = 0.05;

/// The light in all snow of a scene.
pub struct LightField {
    bodies: SceneBodies,
    solutions: Solutions,
    /// The solutions of each body.
    by_body: Vec<BodySolution>,
    bright_snow: BrightSnow,
    /// Indices of the lights whose middles are inside snow.
    lamps_inside: Vec<usize>,
    /// Number of solutions that are not taken from an earlier light field.
    solved_count: usize,
    /// Rounds of light between bodies.
    rounds: u64,
    /// Rays from surfaces of snow to lights and other surfaces.
    rays: u64,
}

/// The light in each body by the lights of one spectrum. The key holds the indices of these lights among the lights
/// that are solved for.
type Solutions = BTreeMap<Vec<usize>, Vec<Arc<LitFluence>>>;

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
    /// Solutions in a body for a group of wavelengths since the cells were made, by all light fields that share these
    /// cells.
    pub solves: u64,
    /// Iterations of conjugate gradients in all solutions.
    pub iterations: u64,
    /// Rounds of light between bodies. Each takes a solution in each body.
    pub rounds: u64,
    /// Rays from surfaces of snow to lights and other surfaces.
    pub rays: u64,
}

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
        Ok(Self::solve(&lit_scene, bodies, Solutions::new()))
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
        let Self { bodies, solutions: mut known, by_body, .. } = self;
        // The solutions of changed lights are freed before new solutions need memory.
        drop(by_body);
        known.retain(|lights, _| !lights.iter().any(|light| changes.has_light(*light)));
        Ok(Self::solve(&lit_scene, bodies, known))
    }

    /// The light field in the same snow by a single light, which need not be a light of the scene. `max_bounces` is
    /// the greatest number of surfaces after the first surface on a path of light.
    pub(crate) fn of_light(&self, scene: &Scene, light: &Arc<Light>, max_bounces: u32, report: Report) -> Self {
        let lit_scene = LitScene::with_light(scene, light, max_bounces, report);
        Self::solve(&lit_scene, self.bodies.clone(), Solutions::new())
    }

    /// Solves for the light of all lights in all bodies, and keeps the solutions that are known.
    fn solve(lit_scene: &LitScene, bodies: SceneBodies, mut solutions: Solutions) -> Self {
        // Lights of one spectrum have one solution.
        let mut illuminations = lit_scene.illuminations();
        solutions.retain(|lights, _| illuminations.iter().any(|illumination| illumination.indices == *lights));
        illuminations.retain(|illumination| !solutions.contains_key(&illumination.indices));
        lit_scene.report_solutions();
        // Paths from all bodies to snow and other surfaces serve the lights of all spectra.
        let exchange = Exchange::new(lit_scene, &bodies, &illuminations);
        for (number, illumination) in illuminations.iter().enumerate() {
            // Lamps and skies light the surface of each body.
            let direct: Vec<LightOnBody> =
                bodies.systems.iter().map(|system| LightOnBody::new(lit_scene, system, illumination)).collect();
            // Bodies and other surfaces exchange light until it is in balance.
            let balance = exchange.balance(number, &direct);
            let spectrum = illumination.spectrum.as_ref().map_or_else(|| mean_spectrum(&direct), with_all_wavelengths);
            // The light inside each body follows from all light that enters at its surface.
            let lit = direct.iter().zip(balance).map(|(direct, (mut diffuse, start))| {
                direct.system.cells.denoise(&mut diffuse, NOISE);
                let options = SolveOptions { start: start.as_ref(), ..SolveOptions::default() };
                let fluence = direct.solve(lit_scene, &diffuse, options);
                Arc::new(LitFluence::new(illumination, direct, &diffuse, fluence, spectrum))
            });
            solutions.insert(illumination.indices.clone(), lit.collect());
        }
        let by_body = bodies.systems.iter().enumerate().map(|(body, system)| BodySolution {
            system: Arc::clone(system),
            lit: solutions.values().map(|lit| Arc::clone(&lit[body])).collect(),
        });
        let by_body: Vec<BodySolution> = by_body.collect();
        // Half of the paths that continue from other surfaces go towards bright snow.
        let bright_snow = BrightSnow::new(if lit_scene.max_bounces > 0 { &by_body } else { &[] });
        let [rounds, rays] = [&lit_scene.rounds, &lit_scene.rays].map(|count| count.load(Ordering::Relaxed));
        let whole_lamps = lit_scene.lamps_in_snow.iter().filter(|lamp| lamp.is_whole);
        let (lamps_inside, solved_count) = (whole_lamps.map(|lamp| lamp.light).collect(), illuminations.len());
        Self { solutions, by_body, bright_snow, lamps_inside, solved_count, rounds, rays, bodies }
    }

    /// The number of solutions that are not taken from an earlier light field.
    pub fn solved_count(&self) -> usize {
        self.solved_count
    }

    /// Whether a light of the scene is a lamp inside snow.
    pub fn is_inside(&self, light: usize) -> bool {
        self.lamps_inside.contains(&light)
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
        self.bodies.systems.iter().filter_map(|system| system.view_factor).max_by(f64::total_cmp)
    }

    /// Whether the light field is for the pictures of one camera. Snow that this camera does not see has larger cells.
    pub fn has_one_view(&self) -> bool {
        self.bodies.has_one_view
    }

    /// The statistics of the light field and of the work on it.
    pub fn statistics(&self) -> FieldStatistics {
        let cells = || self.bodies.systems.iter().map(|system| &system.cells);
        let [solves, iterations] = [0, 1].map(|of| cells().map(|body| body.solves_and_iterations()[of]).sum());
        FieldStatistics {
            bodies: self.bodies.systems.len(),
            cells: cells().map(SnowBody::cell_count).sum(),
            nodes: self.node_count(),
            bytes: cells().map(SnowBody::bytes).sum(),
            groups: self.bodies.systems.first().map_or(0, |system| system.nodes.group_count()),
            lights: self.solutions.len(),
            solves,
            iterations,
            rounds: self.rounds,
            rays: self.rays,
        }
    }

    /// Unknowns of a solution at each wavelength, of all bodies.
    pub(crate) fn node_count(&self) -> usize {
        self.bodies.systems.iter().map(|system| system.cells.node_count()).sum()
    }

    /// The light in the body that an object of snow belongs to.
    #[inline]
    pub fn of_object(&self, object: usize) -> Option<&BodySolution> {
        self.bodies.of_object[object].map(|body| &self.by_body[body])
    }
}

impl std::fmt::Debug for LightField {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.statistics().fmt(formatter)
    }
}

/// The spectrum of the light on all bodies; white if there is none.
fn mean_spectrum(direct: &[LightOnBody]) -> Spectrum {
    let mut sum = Spectrum::ZERO;
    direct.iter().for_each(|direct| sum += direct.spectrum);
    if sum.maximum() > 0.0 { sum } else { Spectrum::ONE }
}
