//! The place on the surface that each texel of a chart shows.

use glam::{DVec2, Vec3, Vec3A};

use crate::bake::lightmap::flat_surface::FlatSurface;
use crate::bake::lightmap::packing::GUTTER;
use crate::bake::vertices::INSET;
use snowblue_geometry::ray::{SurfacePoint, narrow};

/// Distances that are computed between two reports.
const DISTANCES_PER_REPORT: u32 = 1 << 20;
/// A texel that shows no place.
const NO_TRIANGLE: u32 = u32::MAX;

/// The texels of a chart, with its gutter.
pub(super) struct ChartTexels {
    pub(super) columns: u32,
    /// The triangle that each texel shows, row by row.
    triangles: Vec<u32>,
}

/// The nearest point of a triangle.
#[derive(Clone, Copy)]
struct Nearest {
    distance_squared: f64,
    /// Weights of the corners.
    weights: [f64; 3],
}

impl ChartTexels {
    /// Finds for each texel the triangle that is nearest to its centre: the one in which it lies, or beyond the edge of
    /// the chart one at the edge. Texels far from all triangles show none. It calls `report` now and then.
    pub(super) fn of(
        triangles: &[u32],
        [columns, rows]: [u32; 2],
        corners: impl Fn(u32) -> [DVec2; 3],
        report: &dyn Fn(),
    ) -> Self {
        let count = columns as usize * rows as usize;
        let mut nearest = vec![(f64::INFINITY, NO_TRIANGLE); count];
        let mut since = 0;
        for &triangle in triangles {
            let corners @ [a, b, c] = corners(triangle);
            for row in centres(a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y), rows) {
                let [left, right] = extent_around(&corners, f64::from(row) + 0.5);
                for column in centres(left, right, columns) {
                    let Nearest { distance_squared, .. } = nearest_point(&corners, centre(column, row));
                    let known = &mut nearest[(row * columns + column) as usize];
                    if distance_squared < known.0 {
                        *known = (distance_squared, triangle);
                    }
                    since += 1;
                }
            }
            if since >= DISTANCES_PER_REPORT {
                since = 0;
                report();
            }
        }
        Self { columns, triangles: nearest.into_iter().map(|(_, triangle)| triangle).collect() }
    }

    /// Texels that show a place: column and row in the chart, and the triangle.
    pub(super) fn shown(&self) -> Vec<([u32; 2], u32)> {
        let place = |number: u32| [number % self.columns, number / self.columns];
        let numbered = (0..).zip(&self.triangles).filter(|(_, triangle)| **triangle != NO_TRIANGLE);
        numbered.map(|(number, triangle)| (place(number), *triangle)).collect()
    }
}

/// The place of the surface that a texel of a chart shows, whose triangle has these corners in the chart.
///
/// Light is not known beyond edges. The place of a texel beyond the edge of a chart lies within the triangle.
pub(super) fn place(
    surface: &FlatSurface,
    triangle: u32,
    corners: &[DVec2; 3],
    [column, row]: [u32; 2],
) -> SurfacePoint {
    let Nearest { distance_squared, weights } = nearest_point(corners, centre(column, row));
    let inset = if distance_squared > 0.0 { f64::from(INSET) } else { 0.0 };
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

fn centre(column: u32, row: u32) -> DVec2 {
    DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5)
}

/// The texels of a row or column of `count` whose centres lie between two coordinates, or in the gutter around these.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the coordinates are those of texels")]
fn centres(low: f64, high: f64, count: u32) -> std::ops::Range<u32> {
    let gutter = f64::from(GUTTER);
    (low - 0.5 - gutter).ceil().max(0.0) as u32..((high - 0.5 + gutter).floor() + 1.0).clamp(0.0, count.into()) as u32
}

/// The least and the greatest x of a triangle in the gutter around a line y: long, thin triangles are not looked for in
/// all of the rectangle about them.
fn extent_around(corners: &[DVec2; 3], y: f64) -> [f64; 2] {
    let gutter = f64::from(GUTTER);
    let (low, high) = (y - gutter, y + gutter);
    let mut extent = [f64::INFINITY, f64::NEG_INFINITY];
    let mut add = |x: f64| extent = [extent[0].min(x), extent[1].max(x)];
    for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(from, to)| (corners[from], corners[to])) {
        if (low..=high).contains(&from.y) {
            add(from.x);
        }
        for line in [low, high] {
            if (from.y < line) != (to.y < line) {
                add(from.x + (to.x - from.x) * ((line - from.y) / (to.y - from.y)));
            }
        }
    }
    extent
}

/// The nearest point of a triangle that runs counter-clockwise.
fn nearest_point(corners: &[DVec2; 3], point: DVec2) -> Nearest {
    let opposite = |corner: usize| [corners[(corner + 1) % 3], corners[(corner + 2) % 3]];
    // Twice the areas of the triangles that the point makes with the edges.
    let areas = [0, 1, 2].map(|corner| {
        let [from, to] = opposite(corner);
        (to - from).perp_dot(point - from)
    });
    let sum: f64 = areas.iter().sum();
    if sum > 0.0 && areas.iter().all(|area| *area >= 0.0) {
        return Nearest { distance_squared: 0.0, weights: areas.map(|area| area / sum) };
    }
    let on_edge = |corner: usize| {
        let [from, to] = opposite(corner);
        let edge = to - from;
        let share = (edge.dot(point - from) / edge.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let mut weights = [0.0; 3];
        (weights[(corner + 1) % 3], weights[(corner + 2) % 3]) = (1.0 - share, share);
        Nearest { distance_squared: point.distance_squared(from + edge * share), weights }
    };
    let [first, rest @ ..] = [0, 1, 2].map(on_edge);
    rest.into_iter().fold(first, |best, one| if one.distance_squared < best.distance_squared { one } else { best })
}
