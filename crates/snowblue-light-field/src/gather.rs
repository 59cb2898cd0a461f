//! Light that comes to snow by other surfaces, floors, walls and other snow, and by uniform skies.
//!
//! From each surface element a few rays with the density of the cosine find what the element sees. A ray that meets a
//! diffuse surface continues there, as a path tracer's does, until it meets snow or nothing. What snow sends out is
//! asked for many times, so rays are traced once, and their ends are kept.
//!
//! The sky and the snow around an element are seen by the same rays, so that in a cavity of snow, where light is
//! reflected some hundred times, their shares add up to one.

use arrayvec::ArrayVec;
use rayon::prelude::*;
use snowblue_field::{MOST_GROUPS, SnowBody, SpectralNodes, SurfaceElement};
use snowblue_geometry::ray::{Ray, SurfacePoint};
use wide::f32x4;

use crate::solid::Solid;
use crate::surface_light::{ELEMENTS_PER_TASK, LitPoint, push, surface_point, visit_lights};
use snowblue_scene::light::Light;
use snowblue_scene::objects::{Side, SurfaceInteraction};
use snowblue_scene::queries::SceneQueries;
use snowblue_scene::sampling::{Sampler, cosine_direction};
use snowblue_scene::spectrum::Spectrum;

/// Most rays of a body, which bounds memory and time.
const MOST_RAYS: usize = 2 << 20;
/// Most rays of a surface element.
const MOST_RAYS_PER_ELEMENT: usize = 16;

/// Ends of paths that are looked up at a time.
const ENDS_PER_BLOCK: usize = 1 << 16;

/// What snow sends out at a point, in W/m², for each group of nodes.
pub(super) type Exitance = ArrayVec<f32x4, MOST_GROUPS>;

/// What the rays of a body's surface elements found.
#[derive(Debug)]
pub(super) struct GatheredPaths {
    /// For each group of nodes and each element the irradiance by uniform skies and by diffuse surfaces that lamps
    /// light.
    steady: Vec<Vec<f32x4>>,
    /// Paths that end at snow.
    ends: Vec<SnowEnd>,
    /// Transmittance of paths by way of diffuse surfaces, for each group: a range for each such path.
    throughputs: Vec<f32x4>,
    rays_per_element: u32,
}

/// A path that ends at snow.
#[derive(Debug, Clone, Copy)]
struct SnowEnd {
    element: u32,
    /// Number of its throughput, or none if it met no other surface.
    throughput: Option<u32>,
    object: u32,
    surface: SurfacePoint,
}

/// What paths need of the scene.
pub(super) struct Surroundings<'a> {
    pub(super) lights: &'a [&'a Light],
    /// The reflectance of a diffuse surface; none for snow.
    pub(super) reflectance: &'a (dyn Fn(&SurfaceInteraction) -> Option<Spectrum> + Sync),
    /// Most surfaces on a path after the first, snow or not.
    pub(super) most_surfaces: u32,
    /// The radiance of uniform skies.
    pub(super) sky: Spectrum,
}

/// The paths of some elements, before those of all tasks are joined.
#[derive(Default)]
struct Task {
    steady: Vec<Spectrum>,
    ends: Vec<(SnowEnd, Option<Spectrum>)>,
}

impl GatheredPaths {
    /// Traces the rays of a body.
    pub(super) fn new(solid: &Solid, body: &SnowBody, nodes: &SpectralNodes, around: &Surroundings) -> Self {
        let elements = body.surface();
        let rays_per_element = (MOST_RAYS / elements.len().max(1)).clamp(1, MOST_RAYS_PER_ELEMENT);
        let is_dark = around.most_surfaces == 0 && around.sky == Spectrum::ZERO;
        let rays_per_element = if is_dark { 0 } else { u32::try_from(rays_per_element).unwrap_or(1) };
        let task = |(task, elements): (usize, &[SurfaceElement])| {
            let mut queries = SceneQueries::new(solid.objects);
            let mut found = Task::default();
            for (k, element) in elements.iter().enumerate() {
                let number = u32::try_from(task * ELEMENTS_PER_TASK + k).unwrap_or(u32::MAX);
                let mut steady = Spectrum::ZERO;
                for ray in 0..rays_per_element {
                    // One sequence for all elements, so that the rays of neighbours are well distributed together.
                    let sampler = Sampler::new(2, 0, number.wrapping_mul(rays_per_element).wrapping_add(ray));
                    let start = surface_point(element);
                    let (light, end) = trace(&mut queries, solid.object, start, sampler, around);
                    steady += light;
                    if let Some((surface, throughput)) = end {
                        let end = SnowEnd {
                            element: number,
                            throughput: None,
                            object: u32::try_from(surface.object).unwrap_or(u32::MAX),
                            surface: surface.surface_point(),
                        };
                        found.ends.push((end, throughput));
                    }
                }
                found.steady.push(steady * (std::f32::consts::PI / rays_per_element.max(1) as f32));
            }
            solid.watch.add_rays(queries.statistics.rays());
            found
        };
        let tasks: Vec<Task> = elements.par_chunks(ELEMENTS_PER_TASK).enumerate().map(task).collect();
        let groups = nodes.indices().len() / snowblue_field::GROUP;
        let mut paths = Self {
            steady: vec![Vec::with_capacity(elements.len()); groups],
            ends: Vec::new(),
            throughputs: Vec::new(),
            rays_per_element,
        };
        for Task { steady, ends } in tasks {
            steady.iter().for_each(|spectrum| push(&mut paths.steady, nodes, spectrum));
            for (mut end, throughput) in ends {
                if let Some(throughput) = throughput {
                    end.throughput = u32::try_from(paths.throughputs.len()).ok();
                    paths.throughputs.extend(nodes.gather(|index| throughput.0[index]));
                }
                paths.ends.push(end);
            }
        }
        paths
    }

    /// The irradiance by uniform skies and by diffuse surfaces that lamps light: for each group a value at each
    /// element.
    pub(super) fn steady(&self) -> &[Vec<f32x4>] {
        &self.steady
    }

    /// Whether any path ends at snow.
    pub(super) fn reach_snow(&self) -> bool {
        !self.ends.is_empty()
    }

    /// The irradiance of each element by snow, for each group. `exitance` gives what an object of snow sends out at a
    /// point.
    pub(super) fn irradiance_by_snow(
        &self,
        exitance: &(dyn Fn(usize, &SurfacePoint) -> Exitance + Sync),
    ) -> Vec<Vec<f32x4>> {
        let mut irradiance: Vec<Vec<f32x4>> = self.steady.iter().map(|group| vec![f32x4::ZERO; group.len()]).collect();
        let share = f32x4::splat((self.rays_per_element as f32).recip());
        for ends in self.ends.chunks(ENDS_PER_BLOCK) {
            let of_end = |end: &SnowEnd| exitance(end.object as usize, &end.surface);
            let values: Vec<Exitance> = ends.par_iter().map(of_end).collect();
            for (end, values) in ends.iter().zip(values) {
                for (k, (group, value)) in irradiance.iter_mut().zip(values).enumerate() {
                    let throughput = end.throughput.map_or(f32x4::ONE, |start| self.throughputs[start as usize + k]);
                    group[end.element as usize] += value * throughput * share;
                }
            }
        }
        irradiance
    }
}

/// Follows a path from a surface element. Gives the radiance of uniform skies or, by diffuse surfaces, of all lamps,
/// and where it ends at snow, with its throughput if it met another surface before.
fn trace(
    queries: &mut SceneQueries,
    object: usize,
    start: SurfacePoint,
    mut sampler: Sampler,
    around: &Surroundings,
) -> (Spectrum, Option<(SurfaceInteraction, Option<Spectrum>)>) {
    let (mut light, mut throughput) = (Spectrum::ZERO, None);
    let (mut object, mut surface) = (object, start);
    for bounce in 0..=around.most_surfaces {
        let [u, v, ..] = sampler.next_four();
        let direction = cosine_direction(surface.normal, u, v);
        let ray = Ray { origin: queries.off_surface(object, &surface), direction };
        let Some(hit) = queries.indirect_hit(&ray) else {
            // Lamps at diffuse surfaces include the sky.
            if throughput.is_none() {
                light += around.sky;
            }
            break;
        };
        if around.most_surfaces == 0 {
            break;
        }
        let Some(reflectance) = (around.reflectance)(&hit) else {
            return (light, Some((hit, throughput)));
        };
        if bounce == around.most_surfaces {
            break;
        }
        let through = throughput.unwrap_or(Spectrum::ONE) * reflectance;
        (object, surface) = (hit.object, hit.surface_point());
        let lit = LitPoint { surface, side: Side::Outer(object) };
        let samplers = std::iter::once(sampler);
        visit_lights(queries, around.lights, &lit, samplers, &mut |_, irradiance| {
            light.add_product(std::f32::consts::FRAC_1_PI, &through, &irradiance);
        });
        sampler.next_four();
        throughput = Some(through);
        if through.maximum() < 1e-3 {
            break;
        }
    }
    (light, None)
}
