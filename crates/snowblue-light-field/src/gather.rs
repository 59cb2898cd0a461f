//! Light that reaches snow from other surfaces (floors, walls and other snow) and from uniform skies.
//!
//! From each surface element a few rays with the density of the cosine find the surfaces that the element sees. A ray
//! that meets a diffuse surface continues there, as in a path tracer, until it meets snow or nothing. The exitance of
//! snow is read many times, so rays are traced once, for the lights of all spectra, and the places where they end are
//! stored.
//!
//! The same rays sample the sky and the snow around an element. In a cavity of snow, where light is reflected some
//! hundred times, the shares of sky and snow therefore add up to one.

use std::f32::consts::{FRAC_1_PI, PI};

use rayon::prelude::*;
use snowblue_base::narrow;
use snowblue_field::{Groups, SurfaceElement, SurfacePlace};
use snowblue_geometry::ray::{Ray, SurfacePoint};
use wide::f32x4;

use crate::bodies::BodySystem;
use crate::direct_light::{ELEMENTS_PER_TASK, ElementValues, append, push, surface_point, visit_lights};
use crate::lit_scene::{Illumination, LitScene};
use snowblue_scene::light::Light;
use snowblue_scene::material::Material;
use snowblue_scene::material::surface_optics::SurfaceOptics;
use snowblue_scene::objects::{Side, SurfaceInteraction};
use snowblue_scene::queries::SceneQueries;
use snowblue_scene::sampling::{Sampler, cosine_direction};
use snowblue_scene::spectrum::Spectrum;

/// Number of rays of a body above which each surface element has only one ray, which limits memory and time.
const MAX_RAYS: usize = 2 << 20;
/// Greatest number of rays of a surface element.
const MAX_RAYS_PER_ELEMENT: usize = 8;

/// Greatest number of diffuse surfaces between two pieces of snow.
const MAX_SURFACES: u32 = 8;

/// The results of the rays from a body's surface elements.
pub(crate) struct GatheredPaths {
    /// The irradiance by uniform skies and by diffuse surfaces that lamps light, for the lights of each spectrum.
    steady: Vec<ElementValues>,
    /// The paths of element k that end at snow are `ends[end_starts[k]..end_starts[k + 1]]`.
    end_starts: Vec<usize>,
    ends: Vec<SnowEnd>,
    /// Throughputs of paths via diffuse surfaces: a value for each group of each such path.
    throughputs: Vec<f32x4>,
    rays_per_element: u32,
}

/// A path that ends at snow.
#[derive(Debug, Clone, Copy)]
struct SnowEnd {
    place: PlaceOnSnow,
    /// The index of the throughput of its first group; none if the path met no other surface.
    throughput: Option<u32>,
    /// Share of the light in a lit gap of this width that the snow sends back into the gap, and not out beside the
    /// gap.
    kept_in_gap: f32,
}

/// A place on the surface of one of the bodies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlaceOnSnow {
    pub(crate) body: u32,
    pub(crate) place: SurfacePlace,
    /// The patch that holds the place, among the patches of all bodies; none in a cell without surface, which
    /// estimates treat as black.
    pub(crate) patch: Option<u32>,
}

/// The end of a path at snow.
struct PathEnd {
    hit: SurfaceInteraction,
    /// Throughput via other surfaces; none if the path met no other surface.
    throughput: Option<Spectrum>,
    /// Random numbers for lights at the end.
    sampler: Sampler,
    /// The distance from the last surface: the width of the gap.
    gap_m: f32,
}

impl GatheredPaths {
    /// Traces the rays of a body. `snow_at` gives the place of a hit of snow, and the optics of its surface.
    pub(crate) fn new<'a>(
        lit_scene: &LitScene,
        system: &BodySystem,
        illuminations: &[Illumination],
        snow_at: &(dyn Fn(&SurfaceInteraction) -> Option<(PlaceOnSnow, &'a SurfaceOptics)> + Sync),
    ) -> Self {
        let elements = system.cells.surface();
        let rays_per_element = (MAX_RAYS / elements.len().max(1)).clamp(1, MAX_RAYS_PER_ELEMENT);
        let has_sky = illuminations.iter().any(|lights| lights.uniform_sky != Spectrum::ZERO);
        let is_dark = illuminations.is_empty() || lit_scene.max_bounces == 0 && !has_sky;
        let rays_per_element = if is_dark { 0 } else { u32::try_from(rays_per_element).unwrap_or(1) };
        // Light leaves snow some transport lengths from where it enters, and the exitance is known for each cell. This
        // length need not be exact: only estimates use it.
        let spread_m = narrow(system.cells.step_m());
        let empty = || Self {
            steady: vec![vec![Vec::new(); system.nodes.group_count()]; illuminations.len()],
            end_starts: vec![0],
            ends: Vec::new(),
            throughputs: Vec::new(),
            rays_per_element,
        };
        let small_lights: Vec<Vec<&Light>> = illuminations
            .iter()
            .map(|lights| lights.lights.iter().copied().filter(|light| light.is_small()).collect())
            .collect();
        let task = |(task, elements): (usize, &[SurfaceElement])| {
            let mut queries = SceneQueries::new(lit_scene.scene.objects(), lit_scene.scene.materials());
            let mut paths = empty();
            let mut sums = vec![Spectrum::ZERO; illuminations.len()];
            for (k, element) in elements.iter().enumerate() {
                let number = u32::try_from(task * ELEMENTS_PER_TASK + k).unwrap_or(u32::MAX);
                sums.fill(Spectrum::ZERO);
                for ray in 0..rays_per_element {
                    // One sequence for all elements, so that the rays of neighbours are well distributed together.
                    let sampler = Sampler::new(2, 0, number.wrapping_mul(rays_per_element).wrapping_add(ray));
                    let start = (system.object, surface_point(element));
                    let end = trace(&mut queries, start, sampler, (lit_scene, illuminations), &mut sums);
                    let Some(PathEnd { hit, throughput, sampler, gap_m }) = end else { continue };
                    let Some((place, optics)) = snow_at(&hit) else { continue };
                    let light = (&*small_lights, &mut *sums);
                    add_reflection(&mut queries, (&hit, optics), throughput.as_ref(), sampler, light);
                    let throughput = throughput.map(|throughput| {
                        let first = number_of(&paths.throughputs);
                        paths.throughputs.extend(system.nodes.gather(|index| throughput.0[index]));
                        first
                    });
                    paths.ends.push(SnowEnd { place, throughput, kept_in_gap: gap_m / (gap_m + spread_m) });
                }
                let share = PI / rays_per_element.max(1) as f32;
                for (sum, steady) in sums.iter().zip(&mut paths.steady) {
                    push(steady, &system.nodes, &(*sum * share));
                }
                paths.end_starts.push(paths.ends.len());
            }
            lit_scene.add_rays(&queries);
            paths
        };
        let tasks: Vec<Self> = elements.par_chunks(ELEMENTS_PER_TASK).enumerate().map(task).collect();
        tasks.into_iter().fold(empty(), Self::followed_by)
    }

    /// The paths of these elements and then of others.
    fn followed_by(mut self, others: Self) -> Self {
        self.steady.iter_mut().zip(others.steady).for_each(|(all, steady)| append(all, steady));
        let first = self.ends.len();
        self.end_starts.extend(others.end_starts[1..].iter().map(|end| first + end));
        let first = number_of(&self.throughputs);
        self.ends.extend(
            others
                .ends
                .into_iter()
                .map(|end| SnowEnd { throughput: end.throughput.map(|throughput| first + throughput), ..end }),
        );
        self.throughputs.extend(others.throughputs);
        self
    }

    /// The irradiance by uniform skies and by diffuse surfaces that lamps light, for the lights of one spectrum.
    pub(crate) fn steady(&self, spectrum: usize) -> &ElementValues {
        &self.steady[spectrum]
    }

    /// Whether any path ends at snow.
    pub(crate) fn reach_snow(&self) -> bool {
        !self.ends.is_empty()
    }

    /// The irradiance of each element by snow, for each of some groups. `exitance` gives the exitance of snow at a
    /// place. Its second argument is the share of light that stays in a gap of the width there.
    pub(crate) fn irradiance_by_snow(
        &self,
        groups: usize,
        exitance: &(impl Fn(&PlaceOnSnow, f32) -> Groups + Sync),
    ) -> ElementValues {
        let share = f32x4::splat((self.rays_per_element as f32).recip());
        let of_element = |range: &[usize]| {
            let mut sums = Groups::default();
            for end in &self.ends[range[0]..range[1]] {
                let mut values = exitance(&end.place, end.kept_in_gap);
                if let Some(first) = end.throughput {
                    let throughputs = &self.throughputs[first as usize..][..groups];
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

/// The number of values in a list of throughputs.
#[expect(clippy::cast_possible_truncation, reason = "a body has fewer than 2^30 paths, with at most four groups each")]
fn number_of(throughputs: &[f32x4]) -> u32 {
    throughputs.len() as u32
}

/// Follows a path from a surface element. Adds to `light`, for the lights of each spectrum, the radiance of uniform
/// skies or, via diffuse surfaces, the radiance by all lamps. Returns the end of the path at snow.
fn trace(
    queries: &mut SceneQueries,
    (mut object, mut surface): (usize, SurfacePoint),
    mut sampler: Sampler,
    (lit_scene, illuminations): (&LitScene, &[Illumination]),
    light: &mut [Spectrum],
) -> Option<PathEnd> {
    let most_surfaces = lit_scene.max_bounces.min(MAX_SURFACES);
    let mut throughput = None;
    for bounce in 0..=most_surfaces {
        let [u, v, ..] = sampler.next_four();
        let direction = cosine_direction(surface.normal, u, v);
        let mut ray = Ray::new(queries.off_surface(object, &surface), direction);
        queries.statistics.indirect_rays += 1;
        let Some(hit) = queries.hit(&mut ray, || sampler.next_four()[0], |_| {}) else {
            // The lights at diffuse surfaces include the sky.
            if throughput.is_none() {
                light.iter_mut().zip(illuminations).for_each(|(light, lights)| *light += lights.uniform_sky);
            }
            break;
        };
        if most_surfaces == 0 {
            break;
        }
        let Some(reflectance) = lit_scene.scene.materials()[hit.material].albedo(lit_scene.scene.objects(), &hit)
        else {
            return Some(PathEnd { gap_m: hit.point.distance(surface.point), hit, throughput, sampler });
        };
        if bounce == most_surfaces {
            break;
        }
        let through = throughput.unwrap_or(Spectrum::ONE);
        (object, surface) = (hit.object, hit.surface_point());
        let place = (&surface, Side::Outer(object));
        let material = &lit_scene.scene.materials()[hit.material];
        for (light, Illumination { lights, .. }) in light.iter_mut().zip(illuminations) {
            let samplers = std::iter::once(sampler);
            visit_lights(queries, lights, place, samplers, &mut |incident, irradiance| {
                let reflectance = match material {
                    Material::Ground(snow) => snow.reflectance(hit.normal, hit.direction, incident.direction),
                    Material::Diffuse(..) | Material::Glass(_) | Material::Snow(_) => reflectance,
                };
                light.add_product(FRAC_1_PI, &(through * reflectance), &irradiance);
            });
        }
        let through = through * reflectance;
        sampler.next_four();
        throughput = Some(through);
        if through.maximum() < 1e-3 {
            break;
        }
    }
    None
}

/// Adds, for the small lights of each spectrum, the difference of the light that snow reflects along a path's last ray
/// from the reflected light in the exitance divided by π. Snow reflects light at grazing angles forwards.
fn add_reflection(
    queries: &mut SceneQueries,
    (hit, optics): (&SurfaceInteraction, &SurfaceOptics),
    throughput: Option<&Spectrum>,
    sampler: Sampler,
    (small_lights, light): (&[Vec<&Light>], &mut [Spectrum]),
) {
    let (surface, through) = (hit.surface_point(), throughput.unwrap_or(&Spectrum::ONE));
    for (light, lights) in light.iter_mut().zip(small_lights) {
        let (place, samplers) = ((&surface, Side::Outer(hit.object)), std::iter::once(sampler));
        visit_lights(queries, lights, place, samplers, &mut |incident, irradiance| {
            let per_sr = optics.reflection_per_sr(hit.normal, hit.direction, incident.direction);
            light.add_product(per_sr - FRAC_1_PI, through, &irradiance);
        });
    }
}
