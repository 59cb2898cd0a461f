//! The light that lamps and skies bring to a surface.

use glam::Vec3A;
use rayon::prelude::*;
use snowblue_field::{SnowBody, SpectralNodes, SurfaceElement};
use snowblue_geometry::ray::SurfacePoint;
use wide::f32x4;

use crate::body_optics::BodyOptics;
use crate::field_scene::BodyGeometry;
use snowblue_scene::directions::Directions;
use snowblue_scene::light::{Light, LightSample};
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
/// Relative noise to which sampled light is smoothed.
pub(super) const NOISE: f32 = 0.05;
/// Number of elements of a task.
pub(super) const ELEMENTS_PER_TASK: usize = 256;

/// The light of lamps and skies at all surface elements, without the light of uniform skies: values at the spectral
/// nodes, for each group and element, in W m⁻² as a band density.
pub(super) struct EnteringLight {
    /// Σ K F.
    pub(super) escape_weighted: Vec<Vec<f32x4>>,
    /// Σ F.
    pub(super) irradiance: Vec<Vec<f32x4>>,
    /// The sum of K F over all elements.
    pub(super) spectrum: Spectrum,
}

/// A surface point to be lit, and the side that it is on.
pub(crate) struct LitPoint {
    pub(crate) surface: SurfacePoint,
    pub(crate) side: Side,
}

/// Samples the lights at all surface elements of a body.
pub(super) fn entering_light(
    solid: &BodyGeometry,
    body: &SnowBody,
    nodes: &SpectralNodes,
    lights: &[&Light],
    snow: &BodyOptics,
) -> EnteringLight {
    let samples = (MAX_SAMPLES / body.surface().len().max(1)).clamp(1, MAX_SAMPLES_PER_ELEMENT);
    let samples = u32::try_from(samples).unwrap_or(1);
    let groups = nodes.indices().len() / snowblue_field::GROUP;
    let lights = lights.iter().copied().filter(|light| !light.is_diffuse());
    let (small, wide): (Vec<&Light>, Vec<&Light>) = lights.partition(|light| light.is_small());
    let task = |(task, elements): (usize, &[SurfaceElement])| {
        let mut queries = SceneQueries::new(solid.objects);
        let mut entering = EnteringLight::with_capacity(groups, elements.len());
        for (k, element) in elements.iter().enumerate() {
            let number = u32::try_from(task * ELEMENTS_PER_TASK + k).unwrap_or(u32::MAX);
            let [mut escape_weighted, mut total] = [Spectrum::ZERO; 2];
            // One sequence for all elements, so that the samples of neighbours are well distributed together.
            let first = number.wrapping_mul(samples);
            let samples = (0..samples).map(|index| Sampler::new(1, 0, first.wrapping_add(index)));
            let lit = LitPoint { surface: surface_point(element), side: Side::Outer(solid.object) };
            let optics = snow.at_surface(solid.objects, solid.object, &lit.surface);
            let mut add = |cos: f32, irradiance: Spectrum| {
                escape_weighted += irradiance * optics.surface().escape(cos);
                total += irradiance;
            };
            visit_lights(&mut queries, &small, &lit, samples.clone().take(MAX_SAMPLES_OF_SUN), &mut add);
            visit_lights(&mut queries, &wide, &lit, samples, &mut add);
            push(&mut entering.escape_weighted, nodes, &escape_weighted);
            push(&mut entering.irradiance, nodes, &total);
            entering.spectrum += escape_weighted;
        }
        solid.watch.add_rays(queries.statistics.rays());
        entering
    };
    let tasks: Vec<EnteringLight> = body.surface().par_chunks(ELEMENTS_PER_TASK).enumerate().map(task).collect();
    let mut all = EnteringLight::with_capacity(groups, body.surface().len());
    for task in tasks {
        append(&mut all.escape_weighted, task.escape_weighted);
        append(&mut all.irradiance, task.irradiance);
        all.spectrum += task.spectrum;
    }
    all
}

impl EnteringLight {
    fn with_capacity(groups: usize, elements: usize) -> Self {
        let empty = || (0..groups).map(|_| Vec::with_capacity(elements)).collect();
        Self { escape_weighted: empty(), irradiance: empty(), spectrum: Spectrum::ZERO }
    }
}

/// Adds an element with a spectrum.
pub(super) fn push(groups: &mut [Vec<f32x4>], nodes: &SpectralNodes, spectrum: &Spectrum) {
    groups.iter_mut().zip(nodes.gather(|index| spectrum.0[index])).for_each(|(group, values)| group.push(values));
}

/// Adds the elements of others.
pub(super) fn append(groups: &mut [Vec<f32x4>], others: Vec<Vec<f32x4>>) {
    groups.iter_mut().zip(others).for_each(|(group, other)| group.extend(other));
}

/// Visits the visible samples of all lights at a surface: the cosine of incidence and the irradiance. Lights with
/// extent are sampled once with each sampler.
pub(crate) fn visit_lights(
    queries: &mut SceneQueries,
    lights: &[&Light],
    lit: &LitPoint,
    samplers: impl ExactSizeIterator<Item = Sampler> + Clone,
    visit: &mut dyn FnMut(f32, Spectrum),
) {
    let directions = Directions::Cosine(lit.surface);
    for light in lights {
        let mut add = |sample: &LightSample, share: f32| {
            let Some(incident) = sample.incident_at(&lit.surface) else { return };
            if sample.is_visible(queries, &lit.surface, lit.side) {
                let power = light.power(&sample.origin);
                visit(incident.cos_incidence, power * (share * incident.irradiance_per_power));
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
pub(super) fn surface_point(element: &SurfaceElement) -> SurfacePoint {
    SurfacePoint { point: Vec3A::from(element.point), normal: Vec3A::from(element.normal) }
}
