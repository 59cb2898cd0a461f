//! The light of lamps and skies at the surface of a body of snow, and the solution inside the body for this light.

use std::f32::consts::PI;

use glam::Vec3A;
use rayon::prelude::*;
use snowblue_field::{Fluence, SolveOptions, SpectralNodes, SurfaceElement, VolumeSource};
use snowblue_geometry::ray::SurfacePoint;
use wide::f32x4;

use crate::bodies::BodySystem;
use crate::lit_scene::{Illumination, LampInSnow, LitScene, with_all_wavelengths};
use snowblue_scene::directions::Directions;
use snowblue_scene::light::emitter::InnerLamp;
use snowblue_scene::light::{IncidentLight, Light, LightSample};
use snowblue_scene::objects::Side;
use snowblue_scene::queries::SceneQueries;
use snowblue_scene::sampling::Sampler;
use snowblue_scene::spectrum::Spectrum;

/// Greatest number of samples of a light with extent at each surface element. Each node of the grid has about twenty
/// elements.
const MAX_SAMPLES_PER_ELEMENT: usize = 16;
/// Greatest number of samples of the sun. Samples differ where the sun is partly hidden, and by its dark limb.
const MAX_SAMPLES_OF_SUN: usize = 8;
/// Greatest number of samples of a light with extent on a body, which limits the time.
const MAX_SAMPLES: usize = 4 << 20;
/// Number of elements of a task.
pub(crate) const ELEMENTS_PER_TASK: usize = 256;

/// Values at each surface element of a body, or of all bodies, for each group of spectral nodes.
pub(crate) type ElementValues = Vec<Vec<f32x4>>;

/// A body with the light of lamps and skies of one spectrum, without the light of uniform skies, and the lamps inside
/// the body. Values at each surface element are in W m⁻² as a band density.
pub(crate) struct LightOnBody<'a> {
    pub(crate) system: &'a BodySystem,
    /// Σ K F.
    pub(crate) escape_weighted: ElementValues,
    /// Σ F.
    pub(crate) irradiance: ElementValues,
    /// The sum of K F over all elements.
    pub(crate) spectrum: Spectrum,
    sources: Vec<VolumeSource>,
}

impl<'a> LightOnBody<'a> {
    /// Samples the lights of one spectrum at all surface elements of a body.
    pub(crate) fn new(lit_scene: &LitScene, system: &'a BodySystem, illumination: &Illumination) -> Self {
        let (objects, elements) = (lit_scene.scene.objects(), system.cells.surface());
        let samples = (MAX_SAMPLES / elements.len().max(1)).clamp(1, MAX_SAMPLES_PER_ELEMENT);
        let samples = u32::try_from(samples).unwrap_or(1);
        let lights = illumination.lights.iter().copied().filter(|light| !light.is_diffuse());
        let (small, wide): (Vec<&Light>, Vec<&Light>) = lights.partition(|light| light.is_small());
        let task = |(task, elements): (usize, &[SurfaceElement])| {
            let mut queries = SceneQueries::new(objects, lit_scene.scene.materials());
            let mut direct = Self::dark(system);
            for (k, element) in elements.iter().enumerate() {
                let number = u32::try_from(task * ELEMENTS_PER_TASK + k).unwrap_or(u32::MAX);
                let [mut escape_weighted, mut irradiance] = [Spectrum::ZERO; 2];
                // One sequence for all elements, so that the samples of neighbours are well distributed together.
                let first = number.wrapping_mul(samples);
                let samples = (0..samples).map(|index| Sampler::new(1, 0, first.wrapping_add(index)));
                let (surface, side) = (surface_point(element), Side::Outer(system.object));
                let optics = system.snow.at_surface(objects, system.object, &surface);
                let mut add = |incident: &IncidentLight, of_sample: Spectrum| {
                    escape_weighted += of_sample * optics.surface().escape(incident.cos_incidence);
                    irradiance += of_sample;
                };
                let samples_of_sun = samples.clone().take(MAX_SAMPLES_OF_SUN);
                visit_lights(&mut queries, &small, (&surface, side), samples_of_sun, &mut add);
                visit_lights(&mut queries, &wide, (&surface, side), samples, &mut add);
                push(&mut direct.escape_weighted, &system.nodes, &escape_weighted);
                push(&mut direct.irradiance, &system.nodes, &irradiance);
                direct.spectrum += escape_weighted;
            }
            lit_scene.add_rays(&queries);
            direct
        };
        let tasks: Vec<Self> = elements.par_chunks(ELEMENTS_PER_TASK).enumerate().map(task).collect();
        let mut direct = Self::dark(system);
        for task in tasks {
            append(&mut direct.escape_weighted, task.escape_weighted);
            append(&mut direct.irradiance, task.irradiance);
            direct.spectrum += task.spectrum;
        }
        let is_inside = |lamp: &&LampInSnow| {
            illumination.indices.contains(&lamp.light) && objects.body_of(lamp.object) == objects.body_of(system.object)
        };
        let lamps = lit_scene.lamps_in_snow.iter().filter(is_inside);
        direct.sources = lamps.map(|LampInSnow { lamp, .. }| source(lamp, &system.nodes)).collect();
        direct
    }

    /// No light at no element.
    fn dark(system: &'a BodySystem) -> Self {
        let empty = || vec![Vec::new(); system.nodes.group_count()];
        let (escape_weighted, irradiance) = (empty(), empty());
        Self { system, escape_weighted, irradiance, spectrum: Spectrum::ZERO, sources: Vec::new() }
    }

    /// Solves for the light inside the body, lit by this light and by the diffuse irradiance H.
    pub(crate) fn solve<'f>(
        &'f self,
        lit_scene: &LitScene,
        diffuse: &[Vec<f32x4>],
        options: SolveOptions<'f>,
    ) -> Fluence {
        let options = SolveOptions { sources: &self.sources, ..options };
        let fluence = self.system.cells.solve(&self.entering(diffuse), options);
        lit_scene.add_solution();
        fluence
    }

    /// The net flux J and the exitance J + Σ F + H of each surface element, for the diffuse irradiance H and the light
    /// inside.
    pub(crate) fn flux_and_exitance(&self, diffuse: &[Vec<f32x4>], fluence: &Fluence) -> [ElementValues; 2] {
        let flux = self.system.cells.element_flux(fluence, &self.entering(diffuse));
        let mut exitance = diffuse.to_vec();
        add(&mut exitance, &self.irradiance);
        add(&mut exitance, &flux);
        [flux, exitance]
    }

    /// The light that enters at each surface element, Σ K F + H.
    fn entering(&self, diffuse: &[Vec<f32x4>]) -> ElementValues {
        let mut entering = diffuse.to_vec();
        add(&mut entering, &self.escape_weighted);
        entering
    }
}

/// A lamp inside snow as a source of diffuse light.
fn source(lamp: &InnerLamp, nodes: &SpectralNodes) -> VolumeSource {
    let intensity = with_all_wavelengths(&lamp.intensity);
    VolumeSource {
        centre: lamp.position.as_dvec3(),
        radius_m: f64::from(lamp.radius_m),
        power: nodes.gather(|wavelength| 4.0 * PI * intensity.0[wavelength]).collect(),
    }
}

/// Adds an element with a spectrum.
pub(crate) fn push(groups: &mut [Vec<f32x4>], nodes: &SpectralNodes, spectrum: &Spectrum) {
    groups.iter_mut().zip(nodes.gather(|index| spectrum.0[index])).for_each(|(group, values)| group.push(values));
}

/// Adds the elements of others.
pub(crate) fn append(groups: &mut [Vec<f32x4>], others: ElementValues) {
    groups.iter_mut().zip(others).for_each(|(group, other)| group.extend(other));
}

/// Adds the values at each element.
pub(crate) fn add(groups: &mut [Vec<f32x4>], others: &[Vec<f32x4>]) {
    combine(groups, others, |value, other| *value += other);
}

/// Changes each value by the other value at the same element.
pub(crate) fn combine(groups: &mut [Vec<f32x4>], others: &[Vec<f32x4>], change: impl Fn(&mut f32x4, f32x4)) {
    for (group, other) in groups.iter_mut().zip(others) {
        group.iter_mut().zip(other).for_each(|(value, other)| change(value, *other));
    }
}

/// Visits the visible samples of all lights at a surface point on a side of an object, with the irradiance. Lights with
/// extent are sampled once with each sampler. Uniform lights have some light at all wavelengths
/// ([`with_all_wavelengths`]).
pub(crate) fn visit_lights(
    queries: &mut SceneQueries,
    lights: &[&Light],
    (surface, side): (&SurfacePoint, Side),
    samplers: impl ExactSizeIterator<Item = Sampler> + Clone,
    visit: &mut dyn FnMut(&IncidentLight, Spectrum),
) {
    let directions = Directions::Cosine(*surface);
    for light in lights {
        let uniform = light.uniform_power().map(with_all_wavelengths);
        let mut add = |sample: &LightSample, share: f32| {
            let Some(incident) = sample.incident_at(surface) else { return };
            let transmittance = sample.transmittance(queries, surface, side);
            if transmittance > 0.0 {
                let power = uniform.unwrap_or_else(|| light.power(&sample.origin));
                visit(&incident, power * (share * transmittance * incident.irradiance_per_power));
            }
        };
        if let Some(sample) = light.delta_sample() {
            add(&sample, 1.0);
            continue;
        }
        let share = (samplers.len() as f32).recip();
        for mut sampler in samplers.clone() {
            for sample in light.samples_at(&directions, &mut sampler).into_iter().flatten() {
                add(&sample, share);
            }
        }
    }
}

/// The point of a surface element.
pub(crate) fn surface_point(element: &SurfaceElement) -> SurfacePoint {
    SurfacePoint { point: Vec3A::from(element.point), normal: Vec3A::from(element.normal) }
}
