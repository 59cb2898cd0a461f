//! A scene under lights that the light field is solved for. The lights are grouped by their spectra.
//!
//! Light is solved for at few wavelengths, and interpolated between them relative to the spectrum of the light. Lights
//! of different spectra therefore have separate solutions.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use snowblue_base::KeyPath;
use snowblue_scene::light::Light;
use snowblue_scene::light::emitter::InnerLamp;
use snowblue_scene::objects::Object;
use snowblue_scene::progress::{Phase, Progress, Report};
use snowblue_scene::queries::SceneQueries;
use snowblue_scene::spectrum::Spectrum;
use snowblue_scene::{Scene, SceneError};

/// Largest relative difference of proportional spectra at a wavelength.
const SAME_SPECTRUM: f32 = 1e-3;
/// Distance in m of snow that touches a lamp.
const TOUCHING_M: f32 = 5e-5;
/// Least light of an emitter at any wavelength, relative to the light at its strongest wavelength, that solutions have.
const LEAST_LIGHT: f32 = 1e-3;

/// A scene, the lights that the light field is solved for, and the work so far.
pub(crate) struct LitScene<'a> {
    pub(crate) scene: &'a Scene,
    lights: &'a [Arc<Light>],
    /// The lamps, and parts of lamps, among the lights that are inside snow.
    pub(crate) lamps_in_snow: Vec<LampInSnow>,
    /// Greatest number of surfaces after the first surface on a path of light.
    pub(crate) max_bounces: u32,
    report: Report<'a>,
    solutions: AtomicU64,
    /// Number of rounds of light between bodies.
    pub(crate) rounds: AtomicU64,
    /// Number of rays from surfaces of snow to lights and other surfaces.
    pub(crate) rays: AtomicU64,
}

/// A lamp inside snow, or a part of a lamp.
pub(crate) struct LampInSnow {
    /// Index of the light among the lights that the light field is solved for.
    pub(crate) light: usize,
    /// An object of the body that holds the lamp.
    pub(crate) object: usize,
    pub(crate) lamp: InnerLamp,
    /// Whether the middle of the whole lamp is inside the snow.
    pub(crate) is_whole: bool,
}

/// Lights of proportional spectra.
pub(crate) struct Illumination<'a> {
    /// The indices of the lights.
    pub(crate) indices: Vec<usize>,
    pub(crate) lights: Vec<&'a Light>,
    /// The spectrum that the lights emit; none if the spectrum varies over a light, as in an image.
    pub(crate) spectrum: Option<Spectrum>,
    /// The radiance of uniform skies, with some light at all wavelengths, in W m⁻² sr⁻¹ as a band density.
    pub(crate) uniform_sky: Spectrum,
}

impl<'a> LitScene<'a> {
    /// The scene with all its lights.
    ///
    /// # Errors
    ///
    /// If a light other than a point or a sphere lies inside snow.
    pub(crate) fn new(scene: &'a Scene, report: Report<'a>) -> Result<Self, SceneError> {
        let mut lamps_in_snow = Vec::new();
        for (index, light) in scene.lights().iter().enumerate() {
            lamps_in_snow.extend(parts_in_snow(scene, index, light).map_err(|object| {
                let name = &scene.objects().list()[object].name;
                let reason = format!(
                    "lies inside the snow of \"{name}\", or faces the snow and touches it: inside, lights are points \
                     or spheres; before the snow, leave a gap of 0.0001 m or more"
                );
                KeyPath::root("light").index(index).error(reason)
            })?);
        }
        let max_bounces = scene.integrator().max_bounces.get();
        Ok(Self::with_lamps(scene, scene.lights(), lamps_in_snow, max_bounces, report))
    }

    /// The scene with one light, which need not be a light of the scene. A light that is neither a point nor a sphere
    /// counts as outside of the snow.
    pub(crate) fn with_light(scene: &'a Scene, light: &'a Arc<Light>, max_bounces: u32, report: Report<'a>) -> Self {
        let lamps_in_snow = parts_in_snow(scene, 0, light).unwrap_or_default();
        Self::with_lamps(scene, std::slice::from_ref(light), lamps_in_snow, max_bounces, report)
    }

    fn with_lamps(
        scene: &'a Scene,
        lights: &'a [Arc<Light>],
        lamps_in_snow: Vec<LampInSnow>,
        max_bounces: u32,
        report: Report<'a>,
    ) -> Self {
        let [solutions, rounds, rays] = [(); 3].map(|()| AtomicU64::new(0));
        Self { scene, lights, lamps_in_snow, max_bounces, report, solutions, rounds, rays }
    }

    /// Groups the lights of proportional spectra. Dark lights are left out.
    pub(crate) fn illuminations(&self) -> Vec<Illumination<'a>> {
        let mut found: Vec<Illumination> = Vec::new();
        for (index, light) in self.lights.iter().enumerate() {
            let spectrum = light.uniform_power().copied();
            // A dark light would be proportional to all others.
            if spectrum.is_some_and(|spectrum| spectrum.maximum() <= 0.0) {
                continue;
            }
            let is_alike = |other: &Illumination| match (&other.spectrum, &spectrum) {
                (Some(other), Some(spectrum)) => are_proportional(other, spectrum),
                _ => false,
            };
            let number = found.iter().position(is_alike).unwrap_or_else(|| {
                let (indices, lights) = (Vec::new(), Vec::new());
                found.push(Illumination { indices, lights, spectrum, uniform_sky: Spectrum::ZERO });
                found.len() - 1
            });
            let illumination = &mut found[number];
            illumination.indices.push(index);
            illumination.lights.push(light);
            if let Some(radiance) = spectrum.filter(|_| light.is_diffuse()) {
                illumination.uniform_sky += with_all_wavelengths(&radiance);
            }
        }
        found
    }

    /// Reports the number of solutions so far.
    pub(crate) fn report_solutions(&self) {
        let done = self.solutions.load(Ordering::Relaxed);
        (self.report)(Progress { phase: Phase::Light, done, total: 0 });
    }

    /// Counts the rays of queries.
    pub(crate) fn add_rays(&self, queries: &SceneQueries) {
        self.rays.fetch_add(queries.statistics.rays(), Ordering::Relaxed);
    }

    /// Counts and reports a solution in a body.
    pub(crate) fn add_solution(&self) {
        self.solutions.fetch_add(1, Ordering::Relaxed);
        self.report_solutions();
    }
}

/// The parts of a light that are inside the snow of a scene. `index` is stored as the index of the light.
///
/// # Errors
///
/// The object that holds the light, if the light is neither a point nor a sphere.
fn parts_in_snow(scene: &Scene, index: usize, light: &Light) -> Result<Vec<LampInSnow>, usize> {
    let is_snow = |object: &Object| scene.materials()[object.material].is_snow();
    let lamp = light.inner_lamp();
    let before = if lamp.is_none() { light.points_before(TOUCHING_M) } else { Vec::new() };
    let centre = light.central_sample().and_then(|sample| sample.origin.position());
    let holder = centre.into_iter().chain(before).find_map(|point| scene.objects().around(point, is_snow));
    match (lamp, holder) {
        (None, None) => Ok(Vec::new()),
        (None, Some(object)) => Err(object),
        (Some(lamp), Some(object)) => Ok(vec![LampInSnow { light: index, object, lamp, is_whole: true }]),
        (Some(lamp), None) => {
            // A body of several objects has the largest cap of these objects.
            let mut caps: BTreeMap<usize, LampInSnow> = BTreeMap::new();
            for (object, snow) in scene.objects().list().iter().enumerate().filter(|(_, object)| is_snow(object)) {
                let holds = |point| scene.objects().holds(object, point);
                let Some(lamp) = lamp.cap_in(&snow.shape, holds) else { continue };
                let body = scene.objects().body_of(object)[0];
                if caps.get(&body).is_none_or(|cap| cap.lamp.radius_m < lamp.radius_m) {
                    caps.insert(body, LampInSnow { light: index, object, lamp, is_whole: false });
                }
            }
            Ok(caps.into_values().collect())
        }
    }
}

/// The power of an emitter, raised at wavelengths where the emitter has hardly any light. The light inside snow is
/// interpolated between few wavelengths, relative to the spectrum of the emitter, and therefore needs some light at
/// each wavelength. [`BodySolution`](crate::BodySolution) subtracts the added light when it is read. Images, and
/// reflection by coloured surfaces, may still lack wavelengths.
pub(crate) fn with_all_wavelengths(power: &Spectrum) -> Spectrum {
    let least = LEAST_LIGHT * power.maximum();
    Spectrum(power.0.map(|value| value.max(least)))
}

fn are_proportional(one: &Spectrum, other: &Spectrum) -> bool {
    let [scale, other_scale] = [one, other].map(Spectrum::maximum);
    one.0.iter().zip(other.0).all(|(a, b)| {
        let (a, b) = (a * other_scale, b * scale);
        (a - b).abs() <= SAME_SPECTRUM * a.max(b)
    })
}
