//! Directions towards bright snow, for the reflection at other surfaces.
//!
//! The light field gives the exitance of all snow. Rays from floors and walls therefore need not find the bright
//! places of snow by chance: half of the rays go to patches of the surface, chosen by the light that each patch may
//! send to the point. The estimate is unbiased, because it uses the density of the mixture (one-sample model of Veach
//! & Guibas 1995, "Optimally combining sampling techniques for Monte Carlo rendering", doi:10.1145/218380.218498).

use std::f32::consts::{FRAC_1_PI, PI};

use arrayvec::ArrayVec;
use glam::Vec3A;
use snowblue_geometry::ray::SurfacePoint;
use wide::f32x8;

use crate::body_solution::BodySolution;
use crate::direct_light::surface_point;
use snowblue_scene::directions::Directions;
use snowblue_scene::spectrum::Spectrum;

/// Greatest number of patches.
const MAX_PATCHES: usize = LANES * MAX_BLOCKS;
/// Number of patches in a block, and greatest number of blocks.
const LANES: usize = 8;
const MAX_BLOCKS: usize = 16;
/// Greatest number of surface elements that the patches are made of.
const MAX_ELEMENTS: usize = 1 << 16;
/// Share of the rays that are sampled as if there were no patches.
const OWN_SHARE: f32 = 0.5;

/// Cosine below which a patch counts as seen from its side, where rounding decides.
const LEAST_COS: f32 = 1e-3;

/// Approximate description of the snow that a surface sees.
#[derive(Debug, Clone, Copy)]
pub struct SnowSeen {
    /// Irradiance of the surface by the snow, in W/m² as a band density.
    pub irradiance: Spectrum,
    /// Share of the irradiance by a uniform sky that the snow hides, 0–1.
    pub share: f32,
}

/// The bright snow of a scene.
#[derive(Debug)]
pub(crate) struct BrightSnow(Vec<RadiantPatches>);

/// Patches of the surface, in the lanes of vectors. A patch has similar normals, and is approximated by a rectangle.
#[derive(Debug)]
struct RadiantPatches {
    /// Centres, in m.
    centre: [f32x8; 3],
    /// Mean normals, and unit vectors along both sides.
    normal: [f32x8; 3],
    sides: [[f32x8; 3]; 2],
    /// Half the lengths of the sides, in m.
    half_m: [f32x8; 2],
    /// Sines of the greatest angles between normals and their mean; 1 from 90° on.
    sin_spread: f32x8,
    /// The area of the surface.
    area_m2: f32x8,
    /// Mean exitance.
    exitance: f32x8,
    /// Mean radiance of each patch, in W m⁻² sr⁻¹ as a band density.
    radiance: [Spectrum; LANES],
}

/// A patch.
#[derive(Debug, Clone, Copy, Default)]
struct Patch {
    centre: Vec3A,
    normal: Vec3A,
    sides: [Vec3A; 2],
    half_m: [f32; 2],
    sin_spread: f32,
    area_m2: f32,
    exitance: f32,
    radiance: Spectrum,
}

/// Patches as seen from a point.
struct Views<'p> {
    patches: &'p RadiantPatches,
    /// Vectors to their centres, in m.
    way: [f32x8; 3],
    /// Estimates of the irradiance by each patch.
    weight: f32x8,
}

/// A piece of the surface.
#[derive(Debug, Clone, Copy)]
struct Element {
    surface: SurfacePoint,
    area_m2: f32,
    exitance: f32,
    radiance: Spectrum,
}

/// Elements that become a patch or are divided.
struct ElementGroup {
    elements: Vec<Element>,
    /// Corners of the box around them, in m.
    low: Vec3A,
    high: Vec3A,
    area_m2: f32,
    /// Mean exitance.
    exitance: f32,
    /// Size times the ratio of the root mean square of the exitance to its mean.
    variation: f32,
}

impl BrightSnow {
    pub(crate) fn new(bodies: &[BodySolution]) -> Self {
        let count: usize = bodies.iter().map(|body| body.system.cells.surface().len()).sum();
        let stride = count.div_ceil(MAX_ELEMENTS).max(1);
        let elements = bodies.iter().flat_map(|body| {
            body.system.cells.surface().iter().step_by(stride).filter_map(|element| {
                let surface = surface_point(element);
                let radiance = body.mean_radiance(&surface);
                let exitance = PI * radiance.0.iter().sum::<f32>();
                let area_m2 = element.area_m2 * stride as f32;
                (exitance > 0.0).then_some(Element { surface, area_m2, exitance, radiance })
            })
        });
        Self::of_elements(elements.collect())
    }

    fn of_elements(elements: Vec<Element>) -> Self {
        Self(patches(elements).chunks(LANES).map(RadiantPatches::new).collect())
    }

    /// The irradiance of a surface by the snow if no part of the snow hides another part, and the share of the light
    /// of a uniform sky that the snow hides.
    pub(crate) fn seen_from(&self, surface: &SurfacePoint) -> SnowSeen {
        let (mut share, mut irradiance) = (0.0, Spectrum::ZERO);
        for patches in &self.0 {
            let factors = patches.form_factors(surface).to_array();
            for (factor, radiance) in factors.iter().zip(&patches.radiance).filter(|(factor, _)| **factor > 0.0) {
                share += factor;
                irradiance += *radiance * (PI * factor);
            }
        }
        // Patches behind other patches count too.
        SnowSeen { irradiance: irradiance * share.max(1.0).recip(), share: share.min(1.0) }
    }

    /// Samples the direction of a path that continues from a surface. Returns the direction with the factor cos θ / (π
    /// p) of the path's throughput, where p is the density of the direction.
    pub(crate) fn sample(&self, directions: &Directions, [u, v, choice]: [f32; 3]) -> (Vec3A, f32) {
        let surface = directions.surface();
        let views: ArrayVec<Views, MAX_BLOCKS> = self.0.iter().map(|patches| patches.views(surface)).collect();
        let total = views.iter().fold(f32x8::ZERO, |sum, views| sum + views.weight).reduce_add();
        if total <= 0.0 {
            return directions.sample_weighted([u, v]);
        }
        let towards_snow =
            if choice < OWN_SHARE { None } else { choose(&views, (choice - OWN_SHARE) / (1.0 - OWN_SHARE) * total) };
        let direction = match towards_snow {
            Some((views, lane)) => views.direction(lane, [u, v]),
            None => directions.sample([u, v]),
        };
        let cosine_density = surface.normal.dot(direction).max(0.0) * FRAC_1_PI;
        if cosine_density <= 0.0 {
            return (direction, 0.0);
        }
        let densities = views.iter().fold(f32x8::ZERO, |sum, views| sum + views.density(direction));
        let (own, towards) = (directions.density_per_sr(direction), densities.reduce_add() / total);
        (direction, cosine_density / (OWN_SHARE * own + (1.0 - OWN_SHARE) * towards))
    }
}

/// The patch, with its lane, at which the cumulative sum of the weights exceeds a number.
fn choose<'v>(views: &'v [Views], number: f32) -> Option<(&'v Views<'v>, usize)> {
    let mut left = number;
    let mut last = None;
    for views in views {
        for (lane, weight) in views.weight.to_array().into_iter().enumerate().filter(|(_, weight)| *weight > 0.0) {
            last = Some((views, lane));
            left -= weight;
            if left < 0.0 {
                return last;
            }
        }
    }
    // Through rounding, the number may exceed the sum.
    last
}

/// Joins elements whose normals are nearest to the same half axis to patches. Patches are small where the exitance
/// varies.
fn patches(elements: Vec<Element>) -> Vec<Patch> {
    let mut facing: [Vec<Element>; 6] = Default::default();
    for element in elements {
        facing[facing_of(element.surface.normal)].push(element);
    }
    let mut parts: Vec<ElementGroup> = facing.into_iter().filter_map(ElementGroup::new).collect();
    for _ in parts.len()..MAX_PATCHES {
        let by_variation = |one: &(usize, &ElementGroup), other: &(usize, &ElementGroup)| {
            one.1.variation.total_cmp(&other.1.variation)
        };
        let Some((most_varied, _)) = parts.iter().enumerate().max_by(by_variation) else { break };
        let part = parts.swap_remove(most_varied);
        parts.extend(part.halves());
    }
    let mut patches: Vec<Patch> = parts.into_iter().map(Patch::new).collect();
    // Patches that face the same way are either all seen or all hidden.
    patches.sort_by_key(|patch| facing_of(patch.normal));
    patches
}

/// The number of the half axis that a normal is nearest to.
fn facing_of(normal: Vec3A) -> usize {
    let axis = normal.abs().max_position();
    2 * axis + usize::from(normal[axis] < 0.0)
}

impl ElementGroup {
    fn new(elements: Vec<Element>) -> Option<Self> {
        let low = elements.iter().fold(Vec3A::INFINITY, |low, element| low.min(element.surface.point));
        let high = elements.iter().fold(Vec3A::NEG_INFINITY, |high, element| high.max(element.surface.point));
        let sum = |of_element: &dyn Fn(&Element) -> f32| -> f32 { elements.iter().map(of_element).sum() };
        let area_m2 = sum(&|element| element.area_m2);
        let power = sum(&|element| element.area_m2 * element.exitance);
        let mean_square = sum(&|element| element.area_m2 * element.exitance * element.exitance) / area_m2;
        let exitance = power / area_m2;
        let variation = (high - low).max_element() * mean_square.sqrt() / exitance;
        (!elements.is_empty()).then_some(Self { elements, low, high, area_m2, exitance, variation })
    }

    /// The parts on both sides of the middle.
    fn halves(self) -> impl Iterator<Item = Self> {
        let axis = (self.high - self.low).max_position();
        let middle = 0.5 * (self.low[axis] + self.high[axis]);
        let (before, after) = self.elements.into_iter().partition(|element| element.surface.point[axis] < middle);
        [before, after].into_iter().filter_map(Self::new)
    }
}

impl Patch {
    fn new(part: ElementGroup) -> Self {
        let ElementGroup { elements, low, high, area_m2, exitance, .. } = part;
        let weighted = |element: &Element| element.surface.normal * element.area_m2;
        let normal = elements.iter().map(weighted).sum::<Vec3A>().normalize_or_zero();
        let cos_spread = elements.iter().fold(1.0_f32, |least, element| least.min(element.surface.normal.dot(normal)));
        let any = Vec3A::AXES[(normal.abs().max_position() + 1) % 3];
        let first = (any - normal * any.dot(normal)).normalize_or(normal.any_orthonormal_vector());
        let sides = [first, normal.cross(first)];
        let middle = (low + high) * 0.5;
        let mut radiance = Spectrum::ZERO;
        elements.iter().for_each(|element| radiance += element.radiance * element.area_m2);
        // An element reaches about as far as a square of its area.
        let extents = sides.map(|side| {
            let along = |element: &Element| (element.surface.point - middle).dot(side);
            let reach_m = |element: &Element| 0.5 * element.area_m2.sqrt();
            let least = elements.iter().map(|one| along(one) - reach_m(one)).fold(f32::INFINITY, f32::min);
            let greatest = elements.iter().map(|one| along(one) + reach_m(one)).fold(f32::NEG_INFINITY, f32::max);
            [0.5 * (greatest + least), 0.5 * (greatest - least)]
        });
        Self {
            centre: middle + sides[0] * extents[0][0] + sides[1] * extents[1][0],
            normal,
            sides,
            half_m: extents.map(|[_, half_m]| half_m),
            sin_spread: if cos_spread > 0.0 { (1.0 - cos_spread * cos_spread).max(0.0).sqrt() } else { 1.0 },
            area_m2,
            exitance,
            radiance: radiance * area_m2.recip(),
        }
    }
}

impl RadiantPatches {
    /// At most eight patches.
    fn new(patches: &[Patch]) -> Self {
        let mut lanes = [Patch::default(); LANES];
        lanes[..patches.len()].copy_from_slice(patches);
        let gather = |value: &dyn Fn(&Patch) -> f32| f32x8::new(std::array::from_fn(|lane| value(&lanes[lane])));
        let vector = |value: &dyn Fn(&Patch) -> Vec3A| std::array::from_fn(|axis| gather(&|patch| value(patch)[axis]));
        Self {
            centre: vector(&|patch| patch.centre),
            normal: vector(&|patch| patch.normal),
            sides: [vector(&|patch| patch.sides[0]), vector(&|patch| patch.sides[1])],
            half_m: [gather(&|patch| patch.half_m[0]), gather(&|patch| patch.half_m[1])],
            sin_spread: gather(&|patch| patch.sin_spread),
            area_m2: gather(&|patch| patch.area_m2),
            exitance: gather(&|patch| patch.exitance),
            radiance: lanes.map(|patch| patch.radiance),
        }
    }

    /// The vectors from a point of a surface to the centres, in m.
    #[inline]
    fn way(&self, from: &SurfacePoint) -> [f32x8; 3] {
        let point = from.point.to_array().map(f32x8::splat);
        std::array::from_fn(|axis| self.centre[axis] - point[axis])
    }

    /// The form factors from a point of a surface to the patches that face it, by the formula of Lambert (1760) for
    /// polygons: the sum over the edges of the angle that an edge subtends, times the cosine between the normals of
    /// the surface and of the plane through the edge and the point. Parts of a patch below the surface count as
    /// negative.
    #[inline]
    fn form_factors(&self, from: &SurfacePoint) -> f32x8 {
        let (way, surface_normal) = (self.way(from), from.normal.to_array().map(f32x8::splat));
        let is_faced = dot(&way, &self.normal).simd_lt(f32x8::ZERO);
        if is_faced.none() {
            return f32x8::ZERO;
        }
        let corner = |along: f32, across: f32| -> [f32x8; 3] {
            let (along, across) = (self.half_m[0] * f32x8::splat(along), self.half_m[1] * f32x8::splat(across));
            let corner: [f32x8; 3] =
                std::array::from_fn(|axis| way[axis] + self.sides[0][axis] * along + self.sides[1][axis] * across);
            let per_length = f32x8::ONE / dot(&corner, &corner).fast_max(f32x8::splat(f32::MIN_POSITIVE)).sqrt();
            corner.map(|value| value * per_length)
        };
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let mut sum = f32x8::ZERO;
        for (number, start) in corners.iter().enumerate() {
            let end = &corners[(number + 1) % corners.len()];
            let cross: [f32x8; 3] = std::array::from_fn(|axis| {
                let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
                start[next] * end[last] - start[last] * end[next]
            });
            sum += angle_over_sine(dot(start, end)) * dot(&cross, &surface_normal);
        }
        // The corners run counter-clockwise around the normal, as seen from its side.
        is_faced & (-sum).fast_max(f32x8::ZERO)
    }

    /// The patches as seen from a point of a surface.
    #[inline]
    fn views(&self, from: &SurfacePoint) -> Views<'_> {
        let unit = |value: f32x8| value.fast_max(f32x8::ZERO).fast_min(f32x8::ONE);
        let way = self.way(from);
        let distance_squared = dot(&way, &way).fast_max(f32x8::splat(f32::MIN_POSITIVE));
        let per_distance = f32x8::ONE / distance_squared.sqrt();
        // The height of the highest corner above the surface and the height of the point above the patch, divided by
        // the distance. A patch below the surface and a patch that faces away are not seen.
        let normal = from.normal.to_array().map(f32x8::splat);
        let [along, across] = [0, 1].map(|side| self.half_m[side] * dot(&self.sides[side], &normal).abs());
        let cos_from = unit((dot(&way, &normal) + along + across) * per_distance - LEAST_COS);
        let cos_to = unit(self.sin_spread - dot(&way, &self.normal) * per_distance - LEAST_COS);
        let seen_sr = (self.area_m2 * cos_to / distance_squared).fast_min(f32x8::splat(PI));
        Views { patches: self, way, weight: self.exitance * seen_sr * cos_from }
    }
}

impl Views<'_> {
    /// The direction to a point of a patch, from two numbers in [0, 1).
    fn direction(&self, lane: usize, [u, v]: [f32; 2]) -> Vec3A {
        let vector = |value: &[f32x8; 3]| Vec3A::from_array(value.map(|value| value.to_array()[lane]));
        let RadiantPatches { sides, half_m, .. } = self.patches;
        let [along_m, across_m] = half_m.map(|half_m| half_m.to_array()[lane]);
        let aside = vector(&sides[0]) * ((2.0 * u - 1.0) * along_m) + vector(&sides[1]) * ((2.0 * v - 1.0) * across_m);
        (vector(&self.way) + aside).normalize_or(vector(&self.patches.normal))
    }

    /// Weights times the density of a direction towards each patch, in 1/sr: r² / (A cos θ) where the direction meets
    /// the patch.
    #[inline]
    fn density(&self, direction: Vec3A) -> f32x8 {
        let RadiantPatches { normal, sides, half_m, .. } = self.patches;
        let direction = direction.to_array().map(f32x8::splat);
        let cos = dot(&direction, normal);
        let distance_m = dot(&self.way, normal) / cos;
        let beside = std::array::from_fn(|axis| direction[axis] * distance_m - self.way[axis]);
        // Directions that were sampled meet the patch up to rounding.
        let slack = f32x8::splat(1.0 + 1e-4);
        let is_hit = distance_m.simd_gt(f32x8::ZERO)
            & dot(&beside, &sides[0]).abs().simd_le(half_m[0] * slack)
            & dot(&beside, &sides[1]).abs().simd_le(half_m[1] * slack);
        let area_m2 = half_m[0] * half_m[1] * f32x8::splat(4.0);
        is_hit & (self.weight * distance_m * distance_m / (area_m2 * cos.abs()))
    }
}

/// An angle divided by 2π times its sine, from its cosine, within 2·10⁻⁶ (Heitz & Hill 2016, "Real-time area lighting:
/// a journey from research to production", SIGGRAPH course).
#[inline]
fn angle_over_sine(cosine: f32x8) -> f32x8 {
    let size = cosine.abs();
    let above = (size * 0.014_520_6 + 0.496_515_5) * size + 0.854_398_5;
    let acute = above / ((size + 4.161_672_4) * size + 3.417_594);
    let sine = (f32x8::ONE - cosine * cosine).fast_max(f32x8::splat(1e-7)).sqrt();
    cosine.simd_gt(f32x8::ZERO).select(acute, f32x8::splat(0.5) / sine - acute)
}

#[inline]
fn dot([x, y, z]: &[f32x8; 3], [a, b, c]: &[f32x8; 3]) -> f32x8 {
    *x * *a + *y * *b + *z * *c
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_scene::sampling::Sampler;
    use snowblue_scene::sampling::cosine_direction;

    /// A wall at x = 1 m that faces the origin, with a bright stripe.
    fn wall() -> BrightSnow {
        let element = |k: usize| {
            let (y, z) = ((k % 64) as f32 / 32.0 - 1.0, (k / 64) as f32 / 32.0);
            let exitance = if (0.5..0.6).contains(&y) { 1000.0 } else { 1.0 };
            let surface = SurfacePoint { point: Vec3A::new(1.0, y, z), normal: Vec3A::NEG_X };
            Element { surface, area_m2: 1.0 / 1024.0, exitance, radiance: Spectrum::constant(exitance * FRAC_1_PI) }
        };
        BrightSnow::of_elements((0..4096).map(element).collect())
    }

    #[test]
    fn the_factor_makes_up_for_the_density() {
        // With the density cos θ / π, ⟨1⟩ = 1 and ⟨ω⟩ = 2/3 n. The factor is at most 2, so that the standard error of
        // 2¹⁶ random samples is below 2/2⁸ = 0.008. The standard error of the samples of a scrambled Sobol set is far
        // lower.
        let snow = wall();
        let tilted = Vec3A::new(0.48, 0.6, 0.64);
        for (point, normal) in [(Vec3A::ZERO, Vec3A::Z), (Vec3A::new(0.9, 0.0, 0.1), Vec3A::Z), (Vec3A::ZERO, tilted)] {
            let surface = SurfacePoint { point, normal };
            let hits_stripe = |direction: Vec3A| {
                let hit = point + direction * ((1.0 - point.x) / direction.x);
                direction.x > 0.0 && (0.5..0.6).contains(&hit.y) && (0.0..2.0).contains(&hit.z)
            };
            let (mut total, mut mean, mut hits, mut hits_by_cosine) = (0.0, Vec3A::ZERO, 0, 0);
            for sample in 0..1 << 16 {
                let [u, v, _, choice] = Sampler::new(1, 3, sample).next_four();
                let (direction, factor) = snow.sample(&Directions::Cosine(surface), [u, v, choice]);
                total += factor / 65536.0;
                mean += direction * factor / 65536.0;
                hits += u32::from(hits_stripe(direction));
                hits_by_cosine += u32::from(hits_stripe(cosine_direction(normal, u, v)));
            }
            assert!((total - 1.0).abs() < 0.008, "{total}");
            assert!(mean.distance(normal * (2.0 / 3.0)) < 0.008, "{mean}");
            assert!(hits > 2 * hits_by_cosine, "{hits} {hits_by_cosine}");
        }
    }

    #[test]
    fn angles_are_found_by_their_cosine() {
        for cosine in [-0.95_f32, -0.5, 0.0, 0.3, 0.9, 0.999] {
            let expected = cosine.acos() / ((1.0 - cosine * cosine).sqrt() * 2.0 * PI);
            let found = angle_over_sine(f32x8::splat(cosine)).to_array()[0];
            // Rounding of the sine near 1.
            assert!((found / expected - 1.0).abs() < 1e-4, "{cosine}: {found} {expected}");
        }
    }

    /// A point of the floor in front of the middle of the wall, 2 m wide and high, at a distance of 1 m: the form
    /// factor is (atan 1 − atan(1/√5)/√5) / π (Howell, Mengüç, Daun & Siegel 2020, *Thermal Radiation Heat Transfer*,
    /// C-4, twice). A wall behind the point is not seen, and neither is a wall whose snow faces away.
    #[test]
    fn the_snow_that_is_seen_has_the_form_factor_of_its_rectangles() {
        let snow = wall();
        let at = |x: f32| SurfacePoint { point: Vec3A::new(x, 0.0, 0.0), normal: Vec3A::Z };
        let root = 5.0_f32.sqrt();
        let expected = (1.0_f32.atan() - root.recip().atan() / root) * FRAC_1_PI;
        let seen = snow.seen_from(&at(0.0));
        // Elements reach half their size beyond the ends of the wall.
        assert!((seen.share / expected - 1.0).abs() < 0.02, "{} {expected}", seen.share);
        // The wall's exitance is 1 but for the stripe of 1000, which is 4 of 64 columns: 63.4 in the mean by area.
        let mean = seen.irradiance.0[0] / seen.share;
        assert!((57.0..70.0).contains(&mean), "{mean}");
        assert!(snow.seen_from(&at(2.0)).share <= 0.0);
        let below = SurfacePoint { point: Vec3A::ZERO, normal: Vec3A::NEG_X };
        assert!(snow.seen_from(&below).share <= 0.0);
    }

    /// A floor in front of a wall at x = 1 m. The last millimetre of the wall, of narrow elements, is as bright as lit
    /// snow next to it. The density of each ray that finds this millimetre must be high, or the ray makes a white dot.
    #[test]
    fn bright_edges_are_sampled_up_to_the_edge() {
        let element = |k: usize| {
            let (column, row) = (k % 64, k / 64);
            let z = (row as f32 + 0.5) / 64.0;
            let (y, width, exitance) = if column == 63 {
                (0.9995, 0.001, 1e4)
            } else {
                ((column as f32 + 0.5) / 63.0 * 0.999, 0.999 / 63.0, 1.0)
            };
            let surface = SurfacePoint { point: Vec3A::new(1.0, y, z), normal: Vec3A::NEG_X };
            Element { surface, area_m2: width / 64.0, exitance, radiance: Spectrum::constant(exitance * FRAC_1_PI) }
        };
        let snow = BrightSnow::of_elements((0..4096).map(element).collect());
        let surface = SurfacePoint { point: Vec3A::new(0.0, 0.5, 0.0), normal: Vec3A::Z };
        let (mut hits, mut greatest) = (0, 0.0_f32);
        for sample in 0..1 << 16 {
            let [u, v, _, choice] = Sampler::new(1, 5, sample).next_four();
            let (direction, factor) = snow.sample(&Directions::Cosine(surface), [u, v, choice]);
            let hit = surface.point + direction / direction.x;
            if direction.x > 0.0 && (0.999..1.0).contains(&hit.y) && hit.z < 1.0 {
                (hits, greatest) = (hits + 1, greatest.max(factor));
            }
        }
        // With the density of the cosine, about 10 rays would find the bright millimetre. Of the half of the rays that
        // go to snow, most go to the patch that ends with this millimetre, which is a seventeenth of the patch.
        assert!(hits > 1000, "{hits}");
        assert!(greatest < 0.1, "{greatest}");
    }
}
