//! Light that reaches snow from other surfaces (floors, walls and other snow) and from uniform skies.
//!
//! From each surface element a few rays with the density of the cosine find the surfaces that the element sees. A ray
//! that meets a diffuse surface continues there, as in a path tracer, until it meets snow or nothing. The exitance of
//! snow is read many times, so rays are traced once, for the lights of all spectra, and the places where they end are
//! stored.
//!
//! The same rays sample the sky and the snow around an element. In a cavity of snow, where light is reflected some
//! hundred times, the shares of sky and snow therefore add up to one.

use rayon::prelude::*;
use snowblue_base::narrow;
use snowblue_field::{Groups, SnowBody, SpectralNodes, SurfaceElement, SurfacePlace};
use snowblue_geometry::ray::{Ray, SurfacePoint};
use wide::f32x4;

use crate::field_scene::BodyGeometry;
use crate::surface_light::{ELEMENTS_PER_TASK, LitPoint, append, push, surface_point, visit_lights};
use snowblue_scene::light::Light;
use snowblue_scene::objects::{Side, SurfaceInteraction};
use snowblue_scene::queries::SceneQueries;
use snowblue_scene::sampling::{Sampler, cosine_direction};
use snowblue_scene::spectrum::Spectrum;

/// Greatest number of rays of a body, which limits memory and time.
const MAX_RAYS: usize = 2 << 20;
/// Greatest number of rays of a surface element.
const MAX_RAYS_PER_ELEMENT: usize = 16;

/// Marks the absence of other surfaces on a path.
const NONE: u32 = u32::MAX;

/// Values at each surface element, for each group of spectral nodes.
pub(super) type ElementValues = Vec<Vec<f32x4>>;

/// The results of the rays from a body's surface elements.
#[derive(Debug)]
pub(super) struct GatheredPaths {
    /// The irradiance by uniform skies and by diffuse surfaces that lamps light, for the lights of each spectrum.
    steady: Vec<ElementValues>,
    /// The paths of element k that end at snow are `ends[end_starts[k]..end_starts[k + 1]]`.
    end_starts: Vec<usize>,
    ends: Vec<SnowEnd>,
    /// Throughputs of paths via diffuse surfaces, for each group: a range for each such path.
    throughputs: Vec<f32x4>,
    rays_per_element: u32,
}

/// A path that ends at snow.
#[derive(Debug, Clone, Copy)]
struct SnowEnd {
    place: PlaceOnSnow,
    /// Number of its throughput, or [`NONE`] if it met no other surface.
    throughput: u32,
    /// Share of the light in a lit gap of this width that the snow sends back into the gap, and not out beside the
    /// gap.
    kept_in_gap: f32,
}

/// A place on the surface of one of the bodies.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlaceOnSnow {
    pub(super) body: u32,
    pub(super) place: SurfacePlace,
    /// The patch that holds the place, among the patches of all bodies; none in a cell without surface, which
    /// estimates treat as black.
    pub(super) patch: Option<u32>,
}

/// The inputs of paths from the scene.
pub(super) struct GatherScene<'a> {
    /// The lights of each spectrum.
    pub(super) lit: Vec<LightsAround<'a>>,
    /// The reflectance of a diffuse surface; none for snow.
    pub(super) reflectance: &'a (dyn Fn(&SurfaceInteraction) -> Option<Spectrum> + Sync),
    /// Greatest number of surfaces on a path after the first surface, snow or not.
    pub(super) most_surfaces: u32,
    /// The place of a hit of snow.
    pub(super) place_at: &'a (dyn Fn(&SurfaceInteraction) -> Option<PlaceOnSnow> + Sync),
}

/// The end of a path at snow.
struct PathEnd {
    hit: SurfaceInteraction,
    /// Throughput via other surfaces; none if the path met no other surface.
    throughput: Option<Spectrum>,
    /// The distance from the last surface: the width of the gap.
    gap_m: f32,
}

/// Lights of one spectrum.
pub(super) struct LightsAround<'a> {
    pub(super) lights: &'a [&'a Light],
    /// The radiance of uniform skies.
    pub(super) sky: Spectrum,
}

/// The paths of some elements, before the paths of all tasks are joined.
#[derive(Default)]
struct Task {
    steady: Vec<ElementValues>,
    end_counts: Vec<usize>,
    ends: Vec<SnowEnd>,
    throughputs: Vec<f32x4>,
}

impl GatheredPaths {
    /// Traces the rays of a body.
    pub(super) fn new(solid: &BodyGeometry, body: &SnowBody, nodes: &SpectralNodes, around: &GatherScene) -> Self {
        let elements = body.surface();
        let rays_per_element = (MAX_RAYS / elements.len().max(1)).clamp(1, MAX_RAYS_PER_ELEMENT);
        let is_dark = around.most_surfaces == 0 && around.lit.iter().all(|lit| lit.sky == Spectrum::ZERO);
        let rays_per_element = if is_dark { 0 } else { u32::try_from(rays_per_element).unwrap_or(1) };
        let groups = nodes.indices().len() / snowblue_field::GROUP;
        // Light leaves snow some transport lengths from where it enters, and the exitance is known for each cell. This
        // length need not be exact: only estimates use it.
        let spread_m = narrow(body.step_m());
        let task = |(task, elements): (usize, &[SurfaceElement])| {
            let mut queries = SceneQueries::new(solid.objects);
            let steady = vec![vec![Vec::with_capacity(elements.len()); groups]; around.lit.len()];
            let mut found = Task { steady, ..Task::default() };
            let mut sums = vec![Spectrum::ZERO; around.lit.len()];
            for (k, element) in elements.iter().enumerate() {
                let number = u32::try_from(task * ELEMENTS_PER_TASK + k).unwrap_or(u32::MAX);
                let first_end = found.ends.len();
                sums.fill(Spectrum::ZERO);
                for ray in 0..rays_per_element {
                    // One sequence for all elements, so that the rays of neighbours are well distributed together.
                    let sampler = Sampler::new(2, 0, number.wrapping_mul(rays_per_element).wrapping_add(ray));
                    let start = (solid.object, surface_point(element));
                    let end = trace(&mut queries, start, sampler, around, &mut sums);
                    let Some(PathEnd { hit, throughput, gap_m }) = end else { continue };
                    let Some(place) = (around.place_at)(&hit) else { continue };
                    let mut end = SnowEnd { place, throughput: NONE, kept_in_gap: gap_m / (gap_m + spread_m) };
                    if let Some(throughput) = throughput {
                        end.throughput = u32::try_from(found.throughputs.len()).unwrap_or(NONE);
                        found.throughputs.extend(nodes.gather(|index| throughput.0[index]));
                    }
                    found.ends.push(end);
                }
                let share = std::f32::consts::PI / rays_per_element.max(1) as f32;
                sums.iter().zip(&mut found.steady).for_each(|(sum, steady)| push(steady, nodes, &(*sum * share)));
                found.end_counts.push(found.ends.len() - first_end);
            }
            solid.watch.add_rays(queries.statistics.rays());
            found
        };
        let tasks: Vec<Task> = elements.par_chunks(ELEMENTS_PER_TASK).enumerate().map(task).collect();
        let mut paths = Self {
            steady: vec![vec![Vec::with_capacity(elements.len()); groups]; around.lit.len()],
            end_starts: vec![0],
            ends: Vec::new(),
            throughputs: Vec::new(),
            rays_per_element,
        };
        for Task { steady, end_counts, ends, throughputs } in tasks {
            paths.steady.iter_mut().zip(steady).for_each(|(all, steady)| append(all, steady));
            let mut end = paths.ends.len();
            paths.end_starts.extend(end_counts.into_iter().map(|count| {
                end += count;
                end
            }));
            let first = u32::try_from(paths.throughputs.len()).unwrap_or(NONE);
            paths.ends.extend(ends.into_iter().map(|end| match end.throughput {
                NONE => end,
                throughput => SnowEnd { throughput: first + throughput, ..end },
            }));
            paths.throughputs.extend(throughputs);
        }
        paths
    }

    /// The irradiance by uniform skies and by diffuse surfaces that lamps light, for the lights of one spectrum.
    pub(super) fn steady(&self, spectrum: usize) -> &ElementValues {
        &self.steady[spectrum]
    }

    /// Whether any path ends at snow.
    pub(super) fn reach_snow(&self) -> bool {
        !self.ends.is_empty()
    }

    /// The irradiance of each element by snow, for each of some groups. `exitance` gives the exitance of snow at a
    /// place. Its second argument is the share of light that stays in a gap of the width there.
    pub(super) fn irradiance_by_snow(
        &self,
        groups: usize,
        exitance: &(impl Fn(&PlaceOnSnow, f32) -> Groups + Sync),
    ) -> ElementValues {
        let share = f32x4::splat((self.rays_per_element as f32).recip());
        let of_element = |range: &[usize]| {
            let mut sums = Groups::default();
            for end in &self.ends[range[0]..range[1]] {
                let mut values = exitance(&end.place, end.kept_in_gap);
                if end.throughput != NONE {
                    let throughputs = &self.throughputs[end.throughput as usize..][..groups];
                    values.iter_mut().zip(throughputs).for_each(|(value, throughput)| *value *= *throughput);
                }
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            }
            sums.map(|sum| sum * share)
        };
        let elements: Vec<Groups> = self.end_starts.par_windows(2).map(of_element).collect();
        (0..groups).map(|group| elements.iter().map(|groups| groups[group]).collect()).collect()
    }
}

/// Follows a path from a surface element. Adds to `light`, for the lights of each spectrum, the radiance of uniform
/// skies or, via diffuse surfaces, the radiance by all lamps. Returns the end of the path at snow.
fn trace(
    queries: &mut SceneQueries,
    (mut object, mut surface): (usize, SurfacePoint),
    mut sampler: Sampler,
    around: &GatherScene,
    light: &mut [Spectrum],
) -> Option<PathEnd> {
    let mut throughput = None;
    for bounce in 0..=around.most_surfaces {
        let [u, v, ..] = sampler.next_four();
        let direction = cosine_direction(surface.normal, u, v);
        let ray = Ray { origin: queries.off_surface(object, &surface), direction };
        let Some(hit) = queries.indirect_hit(&ray) else {
            // The lights at diffuse surfaces include the sky.
            if throughput.is_none() {
                light.iter_mut().zip(&around.lit).for_each(|(light, lit)| *light += lit.sky);
            }
            break;
        };
        if around.most_surfaces == 0 {
            break;
        }
        let Some(reflectance) = (around.reflectance)(&hit) else {
            return Some(PathEnd { gap_m: hit.point.distance(surface.point), hit, throughput });
        };
        if bounce == around.most_surfaces {
            break;
        }
        let through = throughput.unwrap_or(Spectrum::ONE) * reflectance;
        (object, surface) = (hit.object, hit.surface_point());
        let lit = LitPoint { surface, side: Side::Outer(object) };
        for (light, LightsAround { lights, .. }) in light.iter_mut().zip(&around.lit) {
            let samplers = std::iter::once(sampler);
            visit_lights(queries, lights, &lit, samplers, &mut |_, irradiance| {
                light.add_product(std::f32::consts::FRAC_1_PI, &through, &irradiance);
            });
        }
        sampler.next_four();
        throughput = Some(through);
        if through.maximum() < 1e-3 {
            break;
        }
    }
    None
}
