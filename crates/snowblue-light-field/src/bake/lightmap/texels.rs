//! The place on the surface of the snow that each texel of a lightmap shows.

use glam::{DVec2, Vec3, Vec3A};
use snowblue_geometry::ellipsoid::Ellipsoid;
use snowblue_geometry::ray::{SurfacePoint, narrow};

use crate::bake::surface_mesh::INSET;

/// Texels around each chart that belong to no other one.
pub(super) const GUTTER: i32 = 2;
/// How deep the middle of a texel lies in two triangles that overlap, in texels: more than coordinates are rounded.
const LEAST_DEPTH: f32 = 0.01;

/// A surface that is laid flat.
pub(in crate::bake) struct FlatSurface<'s> {
    /// Index of the object in the scene.
    pub(in crate::bake) object: usize,
    /// Name of the object.
    pub(in crate::bake) name: &'s str,
    /// The ellipsoid whose surface it is.
    pub(in crate::bake) ellipsoid: Option<Ellipsoid>,
    pub(in crate::bake) positions: &'s [Vec3],
    pub(in crate::bake) normals: &'s [Vec3],
    /// Places of the vertices in the lightmap, 0–1.
    pub(in crate::bake) uv: &'s [[f32; 2]],
    pub(in crate::bake) triangles: &'s [[u32; 3]],
}

/// The triangle that a texel shows: the one in which its middle lies, or beyond the edge of a chart the nearest one.
#[derive(Debug, Clone, Copy)]
pub(in crate::bake) struct Shown {
    /// Distance of the triangle from the middle, in texels: negative within it, infinite if no triangle is near.
    pub(super) distance: f32,
    pub(super) surface: u32,
    pub(super) triangle: u32,
}

/// The nearest point of a triangle.
struct Nearest {
    /// The distance from the edges: negative within the triangle.
    distance: f64,
    /// Weights of the corners.
    weights: [f64; 3],
}

/// What each texel shows, row by row.
///
/// # Errors
///
/// When triangles overlap.
pub(in crate::bake) fn shown(surfaces: &[FlatSurface], size: u32) -> Result<Vec<Shown>, String> {
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
                    if distance.max(known.distance) < -LEAST_DEPTH {
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
    /// Where the corners of a triangle lie, in texels.
    pub(super) fn corners(&self, triangle: u32, size: u32) -> [DVec2; 3] {
        self.triangles[triangle as usize]
            .map(|vertex| DVec2::from(self.uv[vertex as usize].map(f64::from)) * f64::from(size))
    }
}

/// The place of the surface that a texel shows.
///
/// Light is not known beyond edges. The place of a texel beyond the edge of a chart lies within the triangle.
pub(super) fn place(surface: &FlatSurface, triangle: u32, texel: usize, size: u32) -> SurfacePoint {
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

/// The least and the greatest x of a triangle in the gutter around a line y: long, thin triangles are not looked for in
/// all of the rectangle about them.
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

/// The nearest point of a triangle, in whatever direction it runs around.
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
