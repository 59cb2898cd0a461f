//! Light that is reflected back and forth between surfaces of snow.
//!
//! The irradiance is H = H₀ + G E(H). H₀ is the irradiance by everything but snow. E is the exitance of snow, which
//! needs a solution inside the bodies. G maps the exitance to the irradiance of each surface element. In a cavity of
//! snow hardly any light is lost from one reflection to the next, so that reflections are not summed one by one. The
//! exitance of a slab is (1 − a) H, with a known absorptance a. With the exitance of slabs the equation needs no
//! solutions inside, and its solution is near the true solution. The equation with slabs is therefore the
//! preconditioner: it is solved for the residual of each estimate. In a gap narrower than a cell, light that enters
//! the snow leaves it beside the gap, so there the exitance of slabs is reduced.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use snowblue_base::narrow;
use snowblue_field::{
    FixedPointOptions, Fluence, Groups, SolveOptions, SurfaceElement, SurfacePatches, SurfaceValues, solve_fixed_point,
};
use snowblue_scene::objects::SurfaceInteraction;
use wide::{f32x4, f64x4};

use crate::bodies::{BodySystem, SceneBodies};
use crate::direct_light::{ElementValues, LightOnBody, add, append, combine};
use crate::gather::{GatheredPaths, PlaceOnSnow};
use crate::lit_scene::{Illumination, LitScene};

/// Tolerance for the light: root mean square over the surface of the light that an estimate by slabs still adds,
/// relative to the light at each place.
const TOLERANCE: f64 = 3e-3;
/// Number of steps that are remembered.
const HISTORY: usize = 5;
/// Options of the iteration for light between slabs.
const LIGHT_OF_SLABS: FixedPointOptions = FixedPointOptions { tolerance: 1e-2, most_estimates: 60, history: 3 };
/// Relative residual of the first solutions inside, and residual of later solutions relative to the residual of the
/// previous solutions for the new light.
const FIRST_RESIDUAL: f64 = 1e-3;
const RESIDUAL_LEFT: f64 = 0.01;
/// Light, relative to the mean, below which an error is no longer compared with the light at its place.
const DARK: f32 = 0.03;
/// Least area of a surface element, relative to the mean area.
const MIN_AREA: f32 = 1e-4;
/// Least light that is used as a divisor.
const MIN_LIGHT: f32 = 1e-20;

/// The surfaces of all bodies, which exchange light. Their values are concatenated, body by body.
pub(crate) struct Exchange<'a> {
    lit_scene: &'a LitScene<'a>,
    systems: &'a [Arc<BodySystem>],
    patches: JoinedPatches,
    paths: Vec<GatheredPaths>,
    /// 1 − a of each surface element; empty if no path ends at snow.
    slab_reflectance: ElementValues,
}

/// The patches of all bodies. Single elements have so few rays that in a narrow gap some elements see only each other,
/// as if no light left the gap. Some of the elements of a patch see out of the gap.
struct JoinedPatches {
    /// The patches of each body, numbered on from the patches of the body before.
    bodies: Vec<SurfacePatches>,
    /// The area of each surface element, divided by the area of its patch.
    share: Vec<f32>,
    count: usize,
}

impl<'a> Exchange<'a> {
    /// Traces paths from the surface of each body to snow, other surfaces and uniform skies, for the lights of some
    /// spectra.
    pub(crate) fn new(lit_scene: &'a LitScene, bodies: &'a SceneBodies, illuminations: &[Illumination]) -> Self {
        let systems = &*bodies.systems;
        let patches = JoinedPatches::new(systems);
        let objects = lit_scene.scene.objects();
        let snow_at = |hit: &SurfaceInteraction| {
            let number = bodies.of_object[hit.object]?;
            let (BodySystem { cells, snow, .. }, surface) = (&*systems[number], hit.surface_point());
            let place = systems[number].place(&surface)?;
            let patch = cells.patch_at(&patches.bodies[number], &place);
            let place = PlaceOnSnow { body: u32::try_from(number).ok()?, place, patch };
            Some((place, snow.at_surface(objects, hit.object, &surface).surface()))
        };
        let of_body = |system: &Arc<BodySystem>| GatheredPaths::new(lit_scene, system, illuminations, &snow_at);
        let paths: Vec<GatheredPaths> = systems.iter().map(of_body).collect();
        let slab_reflectance = if paths.iter().any(GatheredPaths::reach_snow) {
            joined(systems.iter().map(|system| system.cells.slab_reflectance()))
        } else {
            ElementValues::new()
        };
        Self { lit_scene, systems, patches, paths, slab_reflectance }
    }

    /// Finds the irradiance H of each body for the lights of one spectrum. `spectrum` is the number of these lights
    /// among the illuminations, and `direct` is their direct light. If any path ends at snow, each irradiance comes
    /// with a solution inside the body for nearly this irradiance.
    pub(crate) fn balance(&self, spectrum: usize, direct: &[LightOnBody]) -> Vec<(ElementValues, Option<Fluence>)> {
        let steady = self.paths.iter().map(|paths| paths.steady(spectrum).clone());
        if self.slab_reflectance.is_empty() {
            return steady.map(|diffuse| (diffuse, None)).collect();
        }
        // In the iteration, light is H + Σ F, and outer light is H₀ + Σ F.
        let mut outer = joined(steady);
        let irradiance = joined(direct.iter().map(|direct| direct.irradiance.clone()));
        // The first estimate has slabs in place of solutions inside.
        let escape_weighted = joined(direct.iter().map(|direct| direct.escape_weighted.clone()));
        let mut exitance = outer.clone();
        add(&mut exitance, &escape_weighted);
        multiply(&mut exitance, &self.slab_reflectance);
        subtract(&mut exitance, &escape_weighted);
        add(&mut exitance, &irradiance);
        add(&mut outer, &irradiance);
        let mut light = self.of_slabs(self.received_of_patches(&self.patches.means(&exitance)));
        add(&mut light, &outer);
        // A round solves inside each body, and estimates the light that is missing in H₀ + G E(H) = H.
        let mut fluences: Vec<Fluence> = Vec::new();
        let mut round = |light: &[Vec<f32x4>]| {
            self.lit_scene.rounds.fetch_add(1, Ordering::Relaxed);
            let mut diffuse = light.to_vec();
            subtract(&mut diffuse, &irradiance);
            let mut solutions = Vec::with_capacity(direct.len());
            let mut exitances: Vec<SurfaceValues> = Vec::with_capacity(direct.len());
            for (number, (direct, diffuse)) in direct.iter().zip(self.parts(&diffuse)).enumerate() {
                let goal = match fluences.get(number) {
                    Some(start) => {
                        SolveOptions { start: Some(start), residual_left: RESIDUAL_LEFT, ..SolveOptions::default() }
                    }
                    None => SolveOptions { tolerance: FIRST_RESIDUAL, ..SolveOptions::default() },
                };
                let fluence = direct.solve(self.lit_scene, &diffuse, goal);
                let [_, exitance] = direct.flux_and_exitance(&diffuse, &fluence);
                exitances.push(direct.system.cells.smooth(&exitance));
                solutions.push(fluence);
            }
            fluences = solutions;
            let mut missing = self.received(diffuse.len(), &|snow, _| {
                let body = snow.body as usize;
                self.systems[body].cells.value_at(&exitances[body], &snow.place)
            });
            add(&mut missing, &outer);
            subtract(&mut missing, light);
            self.of_slabs(missing)
        };
        let first = round(&light);
        add(&mut light, &first);
        // Errors are weighted by area and relative to the light at their place. In gaps most light comes through snow,
        // which the first estimate leaves out.
        let mut scale = without_dark(&light);
        self.weigh_by_area(&mut scale);
        divide(&mut light, &scale);
        let mut missing = |relative: &[Vec<f32x4>]| {
            let mut light = relative.to_vec();
            multiply(&mut light, &scale);
            let mut missing = round(&light);
            divide(&mut missing, &scale);
            missing
        };
        let most_rounds = self.lit_scene.scene.description().light_field.most_rounds as usize;
        let most_estimates = most_rounds.saturating_sub(1);
        let options = FixedPointOptions { tolerance: TOLERANCE, most_estimates, history: HISTORY };
        let mut diffuse = solve_fixed_point(light, &mut missing, options);
        multiply(&mut diffuse, &scale);
        subtract(&mut diffuse, &irradiance);
        // Rounding can make a small difference negative.
        diffuse.iter_mut().flatten().for_each(|value| *value = value.max(f32x4::ZERO));
        self.parts(&diffuse).into_iter().zip(fluences.into_iter().map(Some)).collect()
    }

    /// Divides a scale by the square root of the area of each element relative to the mean area. Squares of values
    /// relative to this scale are then weighted by area.
    fn weigh_by_area(&self, groups: &mut [Vec<f32x4>]) {
        let elements = || elements_of(self.systems);
        let area_m2: f64 = elements().map(|element| f64::from(element.area_m2)).sum();
        let mean_m2 = area_m2 / elements().count().max(1) as f64;
        let root = |area_m2: f32| narrow(f64::from(area_m2) / mean_m2).max(MIN_AREA).sqrt();
        for group in groups {
            group.iter_mut().zip(elements()).for_each(|(value, element)| *value /= f32x4::splat(root(element.area_m2)));
        }
    }

    /// The irradiance of all elements by the exitance of snow at the places that they see, for each of some groups.
    fn received(&self, groups: usize, exitance: &(impl Fn(&PlaceOnSnow, f32) -> Groups + Sync)) -> ElementValues {
        joined(self.paths.iter().map(|paths| paths.irradiance_by_snow(groups, exitance)))
    }

    /// Estimates the irradiance of all elements by snow: each place has the mean exitance of its patch, and less in a
    /// narrow gap.
    fn received_of_patches(&self, exitance: &[Vec<f32x4>]) -> ElementValues {
        self.received(exitance.len(), &|snow, kept| {
            let mut groups = Groups::default();
            if let Some(patch) = snow.patch {
                let kept = f32x4::splat(kept);
                groups.iter_mut().zip(exitance).for_each(|(value, exitance)| *value = exitance[patch as usize] * kept);
            }
            groups
        })
    }

    /// Adds the irradiance by reflections between surfaces to an irradiance, if the snow at each element is a slab.
    fn of_slabs(&self, mut irradiance: ElementValues) -> ElementValues {
        let reflected = |irradiance: &[Vec<f32x4>]| {
            let mut exitance = irradiance.to_vec();
            multiply(&mut exitance, &self.slab_reflectance);
            self.patches.means(&exitance)
        };
        let start = reflected(&irradiance);
        let mut missing = |exitance: &[Vec<f32x4>]| {
            let mut missing = reflected(&self.received_of_patches(exitance));
            add(&mut missing, &start);
            subtract(&mut missing, exitance);
            missing
        };
        let exitance = solve_fixed_point(start.clone(), &mut missing, LIGHT_OF_SLABS);
        add(&mut irradiance, &self.received_of_patches(&exitance));
        irradiance
    }

    /// The values of each body.
    fn parts(&self, joined: &[Vec<f32x4>]) -> Vec<ElementValues> {
        let mut end = 0;
        let of_body = |system: &Arc<BodySystem>| {
            let start = end;
            end += system.cells.surface().len();
            joined.iter().map(|group| group[start..end].to_vec()).collect()
        };
        self.systems.iter().map(of_body).collect()
    }
}

impl JoinedPatches {
    fn new(systems: &[Arc<BodySystem>]) -> Self {
        let mut bodies: Vec<SurfacePatches> = Vec::with_capacity(systems.len());
        for system in systems {
            let first = bodies.last().map_or(0, |patches| patches.end);
            bodies.push(system.cells.patches(first));
        }
        let count = bodies.last().map_or(0, |patches| patches.end as usize);
        let mut patches = Self { bodies, share: Vec::new(), count };
        let elements = || elements_of(systems).map(|element| element.area_m2).zip(patches.of_elements());
        let mut area_m2 = vec![0.0; count];
        elements().for_each(|(area, patch)| area_m2[patch] += area);
        patches.share = elements().map(|(area, patch)| area / area_m2[patch]).collect();
        patches
    }

    /// The number of the patch of each surface element.
    fn of_elements(&self) -> impl Iterator<Item = usize> {
        self.bodies.iter().flat_map(|patches| &patches.of_element).map(|patch| *patch as usize)
    }

    /// The means over each patch of values at the surface elements.
    fn means(&self, elements: &[Vec<f32x4>]) -> ElementValues {
        let of_group = |elements: &Vec<f32x4>| {
            let mut means = vec![f32x4::ZERO; self.count];
            for ((value, share), patch) in elements.iter().zip(&self.share).zip(self.of_elements()) {
                means[patch] += *value * *share;
            }
            means
        };
        elements.iter().map(of_group).collect()
    }
}

/// The surface elements of all bodies, one body after the other.
fn elements_of(systems: &[Arc<BodySystem>]) -> impl Iterator<Item = &SurfaceElement> {
    systems.iter().flat_map(|system| system.cells.surface())
}

/// The values of all bodies, one body after the other.
fn joined(bodies: impl IntoIterator<Item = ElementValues>) -> ElementValues {
    let mut bodies = bodies.into_iter();
    let mut all = bodies.next().unwrap_or_default();
    bodies.for_each(|values| append(&mut all, values));
    all
}

fn subtract(groups: &mut [Vec<f32x4>], others: &[Vec<f32x4>]) {
    combine(groups, others, |value, other| *value -= other);
}

fn multiply(groups: &mut [Vec<f32x4>], factors: &[Vec<f32x4>]) {
    combine(groups, factors, |value, factor| *value *= factor);
}

fn divide(groups: &mut [Vec<f32x4>], divisors: &[Vec<f32x4>]) {
    combine(groups, divisors, |value, divisor| *value /= divisor);
}

/// The light, raised to at least a small part of the mean light.
fn without_dark(light: &[Vec<f32x4>]) -> ElementValues {
    let of_group = |group: &Vec<f32x4>| {
        let sum = group.iter().fold(f64x4::ZERO, |sum, value| sum + f64x4::from(value.to_array().map(f64::from)));
        #[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
        let mean = f32x4::from(sum.to_array().map(|sum| (sum / group.len() as f64) as f32));
        // Some wavelengths may have no light.
        let is_lit = mean.simd_gt(f32x4::ZERO);
        let least = is_lit.select((mean * DARK).max(f32x4::splat(MIN_LIGHT)), f32x4::ONE);
        group.iter().map(|value| value.max(least)).collect()
    };
    light.iter().map(of_group).collect()
}
