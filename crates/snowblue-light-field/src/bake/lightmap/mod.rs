//! The light of all snow in one texture: a lightmap.
//!
//! 1. Each surface has places in the texture: places of its mesh file, or `charts` that are laid flat and packed into a
//!    square of texels, all at one scale.
//! 2. The light field is read at the place that each texel shows. In the gutter around a chart this is the nearest
//!    place of its edge.
//! 3. Texels between the charts get the light of the nearest texels with light, so that compression and smaller levels
//!    of the texture do not mix in black.

mod charts;
#[cfg(test)]
mod tests;

use glam::{DVec2, Vec2, Vec3, Vec3A};
use guillotiere::{SimpleAtlasAllocator, Size, size2};
use rayon::prelude::*;
use snowblue_base::narrow;
use snowblue_color::LinearRgb;
use snowblue_geometry::ellipsoid::Ellipsoid;
use snowblue_geometry::ray::SurfacePoint;
use snowblue_scene::film::sensor::Sensor;
use snowblue_scene::progress::{Phase, Progress, Report};

use crate::LightField;
use crate::bake::lightmap::charts::{Chart, charts};
use crate::bake::surface_mesh::{INSET, SurfaceMesh};

/// Ratio of a scale at which charts are packed to the next greater scale.
const SCALE_RATIO: f64 = 0.98;
/// Least length that is assumed for charts, in m.
const MIN_LENGTH_M: f64 = 1e-12;
/// Number of texels that are read between two reports.
const TEXELS_PER_REPORT: usize = 1 << 15;
/// Columns and rows of a lightmap.
pub const LIGHTMAP_SIZES: std::ops::RangeInclusive<u32> = 64..=4096;

/// The exitance of all snow, as a square texture.
#[derive(Debug, Clone, PartialEq)]
pub struct Lightmap {
    /// Columns and rows.
    pub size: u32,
    /// Mean side of a texel on the surface, in m.
    pub texel_m: f64,
    /// Exitance as linear sRGB in W/m², row by row from v = 0: red, green and blue.
    pub texels: Vec<[f32; 3]>,
}

/// Gives each facet of the named meshes a place in a lightmap of `size` texels: the place in its file, if all files
/// have places, or else a place in a chart. It reports how many facets have a chart.
///
/// # Errors
///
/// When some meshes have places and some do not, places lie outside the lightmap, or the charts do not fit.
pub(super) fn lay_out(names: &[&str], meshes: &mut [SurfaceMesh], size: u32, report: Report) -> Result<(), String> {
    let Some(with) = meshes.iter().position(|mesh| mesh.has_uv) else {
        return lay_flat(meshes, size, report);
    };
    if let Some(without) = meshes.iter().position(|mesh| !mesh.has_uv) {
        return Err(format!(
            "object \"{}\" has a second UV set and object \"{}\" has none, but all snow must have one, or no snow",
            names[with], names[without]
        ));
    }
    for (name, mesh) in names.iter().zip(meshes) {
        let is_outside = |uv: &&Vec2| !(0.0..=1.0).contains(&uv.x) || !(0.0..=1.0).contains(&uv.y);
        if let Some(Vec2 { x, y }) = mesh.facets.iter().flat_map(|facet| &facet.uv).find(is_outside) {
            return Err(format!("the second UV set of object \"{name}\" reaches u {x}, v {y}, but must lie in 0–1"));
        }
        let has_area = |[a, b, c]: [Vec2; 3]| (b - a).perp_dot(c - a) != 0.0;
        if !mesh.facets.iter().any(|facet| has_area(facet.uv)) {
            return Err(format!("the second UV set of object \"{name}\" has no area: unwrap it, or remove the set"));
        }
    }
    Ok(())
}

/// Packs the charts of all meshes into a lightmap.
fn lay_flat(meshes: &mut [SurfaceMesh], size: u32, report: Report) -> Result<(), String> {
    let total: usize = meshes.iter().map(|mesh| mesh.facets.len()).sum();
    let (mut all, mut before) = (Vec::new(), 0);
    for (number, mesh) in meshes.iter().enumerate() {
        let report =
            |done| report(Progress { phase: Phase::Charts, done: (before + done) as u64, total: total as u64 });
        all.extend(charts(mesh, &report).into_iter().map(|chart| (number, chart)));
        before += mesh.facets.len();
    }
    let extents_m: Vec<DVec2> = all.iter().map(|(_, chart)| chart.extent_m).collect();
    let (texels_per_m, corners) = pack(&extents_m, size).ok_or_else(|| too_many_charts(all.len(), size))?;
    for ((number, Chart { facets, .. }), corner) in all.into_iter().zip(corners) {
        for (facet, places) in facets {
            let uv = places.map(|place| (corner + place * texels_per_m) / f64::from(size));
            meshes[number].facets[facet].uv = uv.map(|place| place.as_vec2());
        }
    }
    Ok(())
}

fn too_many_charts(charts: usize, size: u32) -> String {
    let greatest = *LIGHTMAP_SIZES.end();
    // One texel with its gutter for each chart, in rows and columns.
    let enough = (2 * GUTTER + 1) as usize * ((charts - 1).isqrt() + 1);
    let advice = match enough <= greatest as usize {
        true => format!("{enough} × {enough} suffice"),
        false => format!("the largest one, {greatest} × {greatest}, does not suffice"),
    };
    format!("the surface is cut into {charts} parts, too many for a lightmap of {size} × {size} texels; {advice}")
}

/// The greatest scale at which rectangles, sides in m, are packed with their gutters into a square of texels, in texels
/// per m, and the lower corners of the rectangles. None if they do not fit at one texel each.
fn pack(extents_m: &[DVec2], size: u32) -> Option<(f64, Vec<DVec2>)> {
    let mut order: Vec<usize> = (0..extents_m.len()).collect();
    order.sort_by(|one, other| extents_m[*other].y.total_cmp(&extents_m[*one].y));
    let packed = |texels_per_m: f64| {
        #[expect(clippy::cast_possible_truncation, reason = "an extent is smaller than the square")]
        let texels = |length_m: f64| (length_m * texels_per_m).ceil().max(1.0) as i32 + 2 * GUTTER;
        let sides: Vec<Size> = extents_m.iter().map(|extent| size2(texels(extent.x), texels(extent.y))).collect();
        let mut square = SimpleAtlasAllocator::new(size2(size.cast_signed(), size.cast_signed()));
        let area: i64 = sides.iter().map(|side| i64::from(side.area())).sum();
        if area > square.size().area().into() {
            return None;
        }
        let mut corners = vec![DVec2::ZERO; extents_m.len()];
        for &chart in &order {
            let corner = square.allocate(sides[chart])?.min;
            corners[chart] = DVec2::new(corner.x.into(), corner.y.into()) + f64::from(GUTTER);
        }
        Some((texels_per_m, corners))
    };
    let area_m2: f64 = extents_m.iter().map(|extent| extent.element_product()).sum();
    let longest_m = extents_m.iter().map(|extent| extent.max_element()).fold(MIN_LENGTH_M, f64::max);
    let greatest = f64::from(size) / longest_m.max(area_m2.sqrt());
    // At this scale, each rectangle has one texel.
    let least = SCALE_RATIO / longest_m;
    let scales = std::iter::successors(Some(greatest), |scale| Some(SCALE_RATIO * scale));
    scales.take_while(|scale| *scale > least).chain([least]).find_map(packed)
}

/// Reads the light field at all texels. It reports how many texels are done, and how many there are.
pub(super) fn read(
    surfaces: &[FlatSurface],
    (shown, size): (&[Shown], u32),
    field: &LightField,
    sensor: &Sensor,
    report: impl Fn(usize, usize),
) -> Lightmap {
    let read = |texel: &usize| {
        let Shown { surface, triangle, .. } = shown[*texel];
        let surface = &surfaces[surface as usize];
        let place = place(surface, triangle, *texel, size);
        let exitance = field.of_object(surface.object)?.exitance(&place);
        let LinearRgb { r, g, b } = LinearRgb::from_xyz(sensor.xyz(&exitance));
        Some([r, g, b].map(narrow))
    };
    let lit: Vec<usize> = (0..shown.len()).filter(|texel| shown[*texel].distance.is_finite()).collect();
    let mut texels = vec![None; shown.len()];
    for (number, part) in lit.chunks(TEXELS_PER_REPORT).enumerate() {
        report(number * TEXELS_PER_REPORT, lit.len());
        let light: Vec<Option<[f32; 3]>> = part.par_iter().map(read).collect();
        part.iter().zip(light).for_each(|(texel, light)| texels[*texel] = light);
    }
    report(lit.len(), lit.len());
    Lightmap { size, texel_m: texel_m(surfaces, size), texels: spread(texels, size) }
}

/// Mean side of a texel on the surface, in m.
fn texel_m(surfaces: &[FlatSurface], size: u32) -> f64 {
    let (mut area_m2, mut texels) = (0.0, 0.0);
    for surface in surfaces {
        for (number, triangle) in (0..).zip(surface.triangles) {
            let [a, b, c] = triangle.map(|vertex| surface.positions[vertex as usize].as_dvec3());
            area_m2 += (b - a).cross(c - a).length();
            let [a, b, c] = surface.corners(number, size);
            texels += (b - a).perp_dot(c - a).abs();
        }
    }
    (area_m2 / texels).sqrt()
}

/// Fills texels without a value with the value of the nearest texel, by steps to the four neighbours.
fn spread(mut texels: Vec<Option<[f32; 3]>>, size: u32) -> Vec<[f32; 3]> {
    let size = size as usize;
    let mut edge: Vec<usize> = (0..texels.len()).filter(|texel| texels[*texel].is_some()).collect();
    while !edge.is_empty() {
        let mut next = Vec::new();
        for texel in edge {
            let (column, value) = (texel % size, texels[texel]);
            let neighbours = [
                (column > 0).then(|| texel - 1),
                (column + 1 < size).then(|| texel + 1),
                texel.checked_sub(size),
                Some(texel + size).filter(|texel| *texel < texels.len()),
            ];
            for neighbour in neighbours.into_iter().flatten() {
                if texels[neighbour].is_none() {
                    texels[neighbour] = value;
                    next.push(neighbour);
                }
            }
        }
        edge = next;
    }
    texels.into_iter().map(Option::unwrap_or_default).collect()
}

/// Number of texels around each chart that belong to no other chart.
const GUTTER: i32 = 2;
/// Least depth of a texel's middle in two triangles that counts as an overlap, in texels: more than the rounding of
/// coordinates.
const MIN_DEPTH: f32 = 0.01;

/// A surface that is laid flat.
pub(super) struct FlatSurface<'s> {
    /// Index of the object in the scene.
    pub(super) object: usize,
    /// Name of the object.
    pub(super) name: &'s str,
    /// The ellipsoid whose surface it is.
    pub(super) ellipsoid: Option<Ellipsoid>,
    pub(super) positions: &'s [Vec3],
    pub(super) normals: &'s [Vec3],
    /// Places of the vertices in the lightmap, 0–1.
    pub(super) uv: &'s [[f32; 2]],
    pub(super) triangles: &'s [[u32; 3]],
}

/// The triangle that a texel shows: the triangle that contains its middle, or the nearest triangle beyond the edge of
/// a chart.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shown {
    /// Distance of the triangle from the middle, in texels: negative within it, infinite if no triangle is near.
    distance: f32,
    surface: u32,
    triangle: u32,
}

/// The nearest point of a triangle.
struct Nearest {
    /// The distance from the edges: negative within the triangle.
    distance: f64,
    /// Weights of the corners.
    weights: [f64; 3],
}

/// The triangle that each texel shows, row by row.
///
/// # Errors
///
/// When triangles overlap.
pub(super) fn shown(surfaces: &[FlatSurface], size: u32) -> Result<Vec<Shown>, String> {
    let mut shown = vec![Shown { distance: f32::INFINITY, surface: 0, triangle: 0 }; size as usize * size as usize];
    for (number, surface) in (0..).zip(surfaces) {
        for triangle in (0..).take(surface.triangles.len()) {
            let corners @ [a, b, c] = surface.corners(triangle, size);
            if (b - a).perp_dot(c - a) == 0.0 {
                continue;
            }
            for row in centres(a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y), size) {
                let [left, right] = extent_around(&corners, f64::from(row) + 0.5);
                for column in centres(left, right, size) {
                    let texel = row as usize * size as usize + column as usize;
                    let distance = narrow(nearest(&corners, centre(texel, size)).distance);
                    let known = shown[texel];
                    if distance.max(known.distance) < -MIN_DEPTH {
                        let other = surfaces[known.surface as usize].name;
                        let whose = match known.surface == number {
                            true => "itself".to_owned(),
                            false => format!("that of object \"{other}\""),
                        };
                        return Err(overlap(surface.name, &whose, centre(texel, size) / f64::from(size)));
                    }
                    if distance < known.distance {
                        shown[texel] = Shown { distance, surface: number, triangle };
                    }
                }
            }
        }
    }
    Ok(shown)
}

fn overlap(name: &str, whose: &str, DVec2 { x: u, y: v }: DVec2) -> String {
    format!(
        "the second UV set of object \"{name}\" overlaps {whose} at u {u:.4}, v {v:.4}, but each triangle needs a \
         place of its own: unwrap all snow again (Blender: Lightmap Pack), or remove the set"
    )
}

impl FlatSurface<'_> {
    /// The corners of a triangle, in texels.
    fn corners(&self, triangle: u32, size: u32) -> [DVec2; 3] {
        self.triangles[triangle as usize]
            .map(|vertex| DVec2::from(self.uv[vertex as usize].map(f64::from)) * f64::from(size))
    }
}

/// The place of the surface that a texel shows.
///
/// Light is not known beyond edges. The place of a texel beyond the edge of a chart lies within the triangle.
fn place(surface: &FlatSurface, triangle: u32, texel: usize, size: u32) -> SurfacePoint {
    let Nearest { distance, weights } = nearest(&surface.corners(triangle, size), centre(texel, size));
    let inset = if distance > 0.0 { f64::from(INSET) } else { 0.0 };
    let weights = weights.map(|weight| narrow((1.0 - inset) * weight + inset / 3.0));
    let vertices = surface.triangles[triangle as usize].map(|vertex| vertex as usize);
    let mean = |values: &[Vec3]| -> Vec3 { vertices.iter().zip(weights).map(|(k, weight)| values[*k] * weight).sum() };
    let point = Vec3A::from(mean(surface.positions));
    if let Some(ellipsoid) = &surface.ellipsoid {
        return ellipsoid.project(point);
    }
    let normal = mean(surface.normals).try_normalize().unwrap_or(surface.normals[vertices[0]]);
    SurfacePoint { point, normal: normal.into() }
}

fn centre(texel: usize, size: u32) -> DVec2 {
    let (column, row) = (texel % size as usize, texel / size as usize);
    DVec2::new(column as f64 + 0.5, row as f64 + 0.5)
}

/// The texels of a row or column whose centres lie between two coordinates, or in the gutter around these.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the coordinates are those of texels")]
fn centres(low: f64, high: f64, size: u32) -> std::ops::Range<u32> {
    let gutter = f64::from(GUTTER);
    (low - 0.5 - gutter).ceil().max(0.0) as u32..((high + 0.5 + gutter).floor()).clamp(0.0, size.into()) as u32
}

/// The least and the greatest x of a triangle in the gutter around a line y. Long, thin triangles are therefore not
/// searched for in the whole rectangle around them.
fn extent_around(corners: &[DVec2; 3], y: f64) -> [f64; 2] {
    let gutter = f64::from(GUTTER);
    let mut extent = [f64::INFINITY, f64::NEG_INFINITY];
    for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(from, to)| (corners[from], corners[to])) {
        let (low, high) = (from.y.min(to.y), from.y.max(to.y));
        if low > y + gutter || high < y - gutter || low >= high {
            continue;
        }
        for end in [y - gutter, y + gutter] {
            let x = from.x + (to.x - from.x) * ((end.clamp(low, high) - from.y) / (to.y - from.y));
            extent = [extent[0].min(x), extent[1].max(x)];
        }
    }
    extent
}

/// The nearest point of a triangle of either orientation.
fn nearest(corners: &[DVec2; 3], point: DVec2) -> Nearest {
    let edge = |from: usize| {
        let to = (from + 1) % 3;
        let along = corners[to] - corners[from];
        let share = along.dot(point - corners[from]) / along.length_squared().max(f64::MIN_POSITIVE);
        let share = share.clamp(0.0, 1.0);
        let mut weights = [0.0; 3];
        (weights[from], weights[to]) = (1.0 - share, share);
        Nearest { distance: point.distance(corners[from] + along * share), weights }
    };
    let [first, others @ ..] = [0, 1, 2].map(edge);
    let on_edge = others.into_iter().fold(first, |best, one| if one.distance < best.distance { one } else { best });
    // Twice the areas of the triangles that the point makes with the edges.
    let areas = [1, 2, 0].map(|from| {
        let along = corners[(from + 1) % 3] - corners[from];
        along.perp_dot(point - corners[from])
    });
    let sum: f64 = areas.iter().sum();
    if sum != 0.0 && areas.iter().all(|area| area * sum >= 0.0) {
        return Nearest { distance: -on_edge.distance, weights: areas.map(|area| area / sum) };
    }
    on_edge
}
