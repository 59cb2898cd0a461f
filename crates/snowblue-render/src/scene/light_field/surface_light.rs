//! The light that lamps and skies bring to a surface.

use glam::Vec3A;
use rayon::prelude::*;
use snowblue_field::{SnowBody, SurfaceElement};
use snowblue_transport::ordinates::HalfSpace;

use crate::geometry::ray::{SurfacePoint, narrow};
use crate::sampling::Sampler;
use crate::scene::light::{Light, LightSample};
use crate::scene::light_field::solid::Solid;
use crate::scene::objects::Side;
use crate::scene::queries::SceneQueries;
use crate::spectrum::Spectrum;

/// Most samples of a light with extent at each surface element. Each node of the grid has some twenty elements.
const MOST_SAMPLES_PER_ELEMENT: usize = 16;
/// Most samples of a light with extent on a body, which bounds the time.
const MOST_SAMPLES: usize = 8 << 20;
/// Elements of a task.
pub(super) const ELEMENTS_PER_TASK: usize = 256;

/// The light at a surface element, in W m⁻² as a band density.
#[derive(Clone, Copy)]
pub(super) struct EnteringLight {
    /// Σ K F.
    pub(super) escape_weighted: Spectrum,
    /// Σ F.
    pub(super) irradiance: Spectrum,
}

/// A surface point to be lit, and the side that it is on.
pub(super) struct LitPoint {
    pub(super) surface: SurfacePoint,
    pub(super) side: Side,
}

/// Samples the lights at all surface elements of a body.
pub(super) fn entering_light(
    solid: &Solid,
    body: &SnowBody,
    lights: &[&Light],
    half_space: &HalfSpace,
) -> Vec<EnteringLight> {
    let samples = (MOST_SAMPLES / body.surface().len().max(1)).clamp(1, MOST_SAMPLES_PER_ELEMENT);
    let samples = u32::try_from(samples).unwrap_or(1);
    let task = |(task, elements): (usize, &[SurfaceElement])| {
        let mut queries = SceneQueries::new(solid.objects);
        let of_element = |(k, element): (usize, &SurfaceElement)| {
            let number = u32::try_from(task * ELEMENTS_PER_TASK + k).unwrap_or(u32::MAX);
            let mut entering = EnteringLight { escape_weighted: Spectrum::ZERO, irradiance: Spectrum::ZERO };
            let samples = (0..samples).map(|index| Sampler::new(1, number, index));
            let lit = LitPoint { surface: surface_point(element), side: Side::Outer(solid.object) };
            visit_lights(&mut queries, lights, &lit, samples, &mut |cos, irradiance| {
                entering.irradiance += irradiance;
                entering.escape_weighted += irradiance * narrow(half_space.escape(f64::from(cos)));
            });
            entering
        };
        elements.iter().enumerate().map(of_element).collect::<Vec<_>>()
    };
    let tasks: Vec<Vec<EnteringLight>> = body.surface().par_chunks(ELEMENTS_PER_TASK).enumerate().map(task).collect();
    tasks.into_iter().flatten().collect()
}

/// Visits the visible samples of all lights at a surface: the cosine of incidence and the irradiance. Lights with
/// extent are sampled once with each sampler.
pub(super) fn visit_lights(
    queries: &mut SceneQueries,
    lights: &[&Light],
    lit: &LitPoint,
    samplers: impl ExactSizeIterator<Item = Sampler> + Clone,
    visit: &mut dyn FnMut(f32, Spectrum),
) {
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
            for sample in light.samples_at(&lit.surface, &mut sampler).into_iter().flatten() {
                add(&sample, share);
            }
        }
    }
}

/// The point of a surface element.
pub(super) fn surface_point(element: &SurfaceElement) -> SurfacePoint {
    SurfacePoint { point: Vec3A::from(element.point), normal: Vec3A::from(element.normal) }
}
