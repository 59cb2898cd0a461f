//! The light that enters a body of snow at its surface.

use glam::Vec3A;
use rayon::prelude::*;
use snowblue_field::{SnowBody, SpectralNodes, SurfaceElement};
use snowblue_transport::ordinates::HalfSpace;
use wide::f32x4;

use crate::geometry::ray::{SurfacePoint, narrow};
use crate::sampling::Sampler;
use crate::scene::light::{Light, LightSample};
use crate::scene::light_field::solid::Solid;
use crate::scene::objects::Side;
use crate::scene::queries::SceneQueries;
use crate::spectrum::Spectrum;

/// Samples of a light with extent at each surface element. Each node of the grid has some twenty elements about it.
const SAMPLES_PER_ELEMENT: u32 = 16;
/// Elements of a task.
const ELEMENTS_PER_TASK: usize = 256;

/// The light at all surface elements of a body.
pub(super) struct SurfaceLight {
    /// For each group of nodes and each element Σ K F.
    pub(super) groups: Vec<Vec<f32x4>>,
    /// Σ K F times area, summed over all elements.
    pub(super) reference: Spectrum,
}

/// Samples the lights at all surface elements.
pub(super) fn surface_light(
    solid: &Solid,
    body: &SnowBody,
    lights: &[Light],
    nodes: &SpectralNodes,
    half_space: &HalfSpace,
) -> SurfaceLight {
    let task = |(task, elements): (usize, &[SurfaceElement])| {
        let mut queries = SceneQueries::new(solid.objects);
        let mut spectra = Vec::with_capacity(elements.len());
        for (k, element) in elements.iter().enumerate() {
            let surface = SurfacePoint { point: Vec3A::from(element.point), normal: Vec3A::from(element.normal) };
            let number = u32::try_from(task * ELEMENTS_PER_TASK + k).unwrap_or(u32::MAX);
            let mut entering = Spectrum::ZERO;
            for light in lights {
                let mut add = |sample: &LightSample, share: f32| {
                    let Some(incident) = sample.incident_at(&surface) else { return };
                    if sample.is_visible(&mut queries, &surface, Side::Outer(solid.object)) {
                        let escape = narrow(half_space.escape(f64::from(incident.cos_incidence)));
                        let factor = share * escape * incident.irradiance_per_power;
                        entering.add_product(factor, &Spectrum::ONE, &light.power(&sample.origin));
                    }
                };
                if let Some(sample) = light.delta_sample() {
                    add(&sample, 1.0);
                    continue;
                }
                for index in 0..SAMPLES_PER_ELEMENT {
                    let mut sampler = Sampler::new(1, number, index);
                    for sample in light.samples_at(&surface, &mut sampler).into_iter().flatten() {
                        add(&sample, (SAMPLES_PER_ELEMENT as f32).recip());
                    }
                }
            }
            spectra.push(entering);
        }
        spectra
    };
    let elements = body.surface();
    let spectra: Vec<Vec<Spectrum>> = elements.par_chunks(ELEMENTS_PER_TASK).enumerate().map(task).collect();
    let mut light = SurfaceLight { groups: Vec::new(), reference: Spectrum::ZERO };
    let count = nodes.indices().len() / snowblue_field::GROUP;
    light.groups.resize_with(count, || Vec::with_capacity(elements.len()));
    for (entering, element) in spectra.iter().flatten().zip(elements) {
        light.reference.add_product(element.area_m2, &Spectrum::ONE, entering);
        for (group, values) in light.groups.iter_mut().zip(nodes.gather(|index| entering.0[index])) {
            group.push(values);
        }
    }
    light
}
