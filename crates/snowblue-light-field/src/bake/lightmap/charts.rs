//! Charts: connected parts of a surface that are laid flat without overlap.
//!
//! A chart grows from a facet across smooth edges, and is projected along the normal of this facet. No normal is
//! inclined to this direction by more than [`MAX_INCLINATION_DEG`], so that lengths shrink to 0.64 at the least. A
//! facet that would overlap the chart is left to another chart. A quadtree finds overlaps of triangles of any size.

use std::collections::{HashMap, VecDeque};

use glam::{DVec2, Vec3};
use snowblue_geometry::bounds::Bounds;
use snowblue_geometry::edges::{Grouped, visit_edges};
use snowblue_geometry::vertex_normals::face_normal;

use crate::bake::surface_mesh::{SurfaceMesh, is_smooth};

/// Greatest angle between the normal of a facet and the direction along which its chart is projected.
const MAX_INCLINATION_DEG: f32 = 50.0;
/// Number of facets between two reports.
const FACETS_PER_REPORT: usize = 1 << 12;

/// A part of a surface that is laid flat.
pub(super) struct Chart {
    /// Its facets, with the places of their corners, in m.
    pub(super) facets: Vec<(usize, [DVec2; 3])>,
    /// Sides of its bounding rectangle, in m, the longer side first.
    pub(super) extent_m: DVec2,
}

/// The charts of a surface. Each facet is in one chart. It reports how many facets have a chart.
pub(super) fn charts(mesh: &SurfaceMesh, report: &dyn Fn(usize)) -> Vec<Chart> {
    let corners = |vertices: [u32; 3]| vertices.map(|vertex| mesh.positions[vertex as usize]);
    // Facets of an ellipsoid have the normal of the face that they were divided from.
    let normals: Vec<Vec3> = mesh.facets.iter().map(|facet| face_normal(corners(facet.vertices))).collect();
    let neighbours = neighbours(mesh, &normals);
    let size_m = f64::from(Bounds::of(mesh.positions.iter().copied()).diagonal_m());
    // Charts begin at facets with area, whose normals direct them.
    let mut seeds: Vec<usize> = (0..mesh.facets.len()).collect();
    seeds.sort_by_key(|facet| normals[*facet] == Vec3::ZERO);
    let mut is_laid = vec![false; mesh.facets.len()];
    let (mut charts, mut done) = (Vec::new(), 0);
    for seed in seeds {
        if is_laid[seed] {
            continue;
        }
        let axis = normals[seed].try_normalize().unwrap_or(Vec3::Z);
        let plane = axis.as_dvec3().normalize().any_orthonormal_pair();
        let origin = corners(mesh.facets[seed].vertices)[0].as_dvec3();
        let flat = |corner: Vec3| {
            let from_origin = corner.as_dvec3() - origin;
            DVec2::new(plane.0.dot(from_origin), plane.1.dot(from_origin))
        };
        let is_near_axis = |facet: usize| {
            normals[facet] == Vec3::ZERO || normals[facet].dot(axis) >= MAX_INCLINATION_DEG.to_radians().cos()
        };
        let mut quadtree = Quadtree::around(size_m);
        let (mut facets, mut waiting) = (Vec::new(), VecDeque::from([seed]));
        while let Some(facet) = waiting.pop_front() {
            let triangle = corners(mesh.facets[facet].vertices).map(flat);
            if is_laid[facet] || quadtree.overlaps(&triangle) {
                continue;
            }
            quadtree.add(triangle);
            facets.push((facet, triangle));
            is_laid[facet] = true;
            done += 1;
            if done % FACETS_PER_REPORT == 0 {
                report(done);
            }
            let next = neighbours.group(facet).iter().map(|neighbour| *neighbour as usize);
            waiting.extend(next.filter(|neighbour| !is_laid[*neighbour] && is_near_axis(*neighbour)));
        }
        charts.push(Chart::of(facets));
    }
    charts
}

/// The neighbours of each facet across smooth edges that two facets share.
fn neighbours(mesh: &SurfaceMesh, normals: &[Vec3]) -> Grouped<u32> {
    let triangles: Vec<[u32; 3]> = mesh.facets.iter().map(|facet| facet.vertices).collect();
    let mut pairs = Vec::new();
    visit_edges(mesh.positions.len(), &triangles, |sides| {
        let [one, other] = sides else { return };
        let [normal, beside] = [one, other].map(|side| normals[side.triangle as usize]);
        if one.from != other.from && is_smooth(normal, beside) {
            pairs.extend([(one.triangle, other.triangle), (other.triangle, one.triangle)]);
        }
    });
    Grouped::new(triangles.len(), pairs.into_iter())
}

impl Chart {
    /// Turns facets into the lowest bounding rectangle along or across an edge of the first facet, with its lower
    /// corner at 0.
    fn of(mut facets: Vec<(usize, [DVec2; 3])>) -> Self {
        let turned = |point: DVec2, along: DVec2| DVec2::new(along.dot(point), along.perp_dot(point));
        let around =
            |along: DVec2| bounds(facets.iter().flat_map(|(_, corners)| corners).map(|point| turned(*point, along)));
        let height = |along: &DVec2| {
            let (low, high) = around(*along);
            high.y - low.y
        };
        let [a, b, c] = facets[0].1;
        let directions = [b - a, c - b, a - c].into_iter().filter_map(DVec2::try_normalize);
        let lowest = directions
            .flat_map(|along| [along, along.perp()])
            .min_by(|one, other| height(one).total_cmp(&height(other)));
        let along = lowest.unwrap_or(DVec2::X);
        let (low, high) = around(along);
        facets.iter_mut().flat_map(|(_, corners)| corners).for_each(|point| *point = turned(*point, along) - low);
        Self { facets, extent_m: high - low }
    }
}

/// Overlaps of triangles by less than this fraction of their edges are rounding.
const ROUNDING: f64 = 1e-9;
/// Greatest number of halvings of squares. Smaller triangles are in squares that are wider than the triangles.
const MAX_HALVINGS: f64 = 40.0;

/// A square of the plane: the number of halvings of the first square for its side, its column and its row.
type Square = (i32, [i64; 2]);

const FIRST_SQUARE: Square = (0, [0; 2]);

/// Triangles, each in the smallest square that is as wide as the triangle and contains its middle.
struct Quadtree {
    /// Side of the first square, in m. Its middle is the origin.
    side_m: f64,
    /// Squares with triangles in them, or in a part of them.
    squares: HashMap<Square, Vec<[DVec2; 3]>>,
}

impl Quadtree {
    /// An empty quadtree for triangles whose coordinates are at most `reach_m`.
    pub(super) fn around(reach_m: f64) -> Self {
        // Twice as wide as the places, for rounding.
        Self { side_m: 4.0 * reach_m, squares: HashMap::new() }
    }

    #[expect(clippy::cast_possible_truncation, reason = "there are 2⁴⁰ squares in a row at most")]
    pub(super) fn add(&mut self, triangle: [DVec2; 3]) {
        let (low, high) = bounds(triangle.into_iter());
        let halvings = (self.side_m / (high - low).max_element()).log2().floor().clamp(0.0, MAX_HALVINGS);
        let place = (low.midpoint(high) / self.side_m + 0.5) * halvings.exp2();
        let mut square = (halvings as i32, place.floor().to_array().map(|index| index as i64));
        self.squares.entry(square).or_default().push(triangle);
        while square != FIRST_SQUARE {
            square = (square.0 - 1, square.1.map(|index| index / 2));
            self.squares.entry(square).or_default();
        }
    }

    /// Whether a triangle, counter-clockwise, overlaps a triangle of the quadtree.
    pub(super) fn overlaps(&self, triangle: &[DVec2; 3]) -> bool {
        self.overlaps_in(triangle, FIRST_SQUARE)
    }

    /// Whether a triangle overlaps a triangle in a square.
    fn overlaps_in(&self, triangle: &[DVec2; 3], square: Square) -> bool {
        let Some(triangles) = self.squares.get(&square) else { return false };
        let (halvings, [column, row]) = square;
        let side_m = self.side_m * f64::from(-halvings).exp2();
        let middle = DVec2::new(column as f64 + 0.5, row as f64 + 0.5) * side_m - 0.5 * self.side_m;
        // Triangles reach beyond their square by half of its side.
        let (low, high) = bounds(triangle.iter().copied());
        if (middle - side_m).cmpgt(high).any() || (middle + side_m).cmplt(low).any() {
            return false;
        }
        triangles.iter().any(|other| !are_apart(triangle, other) && !are_apart(other, triangle))
            || [(0, 0), (0, 1), (1, 0), (1, 1)]
                .into_iter()
                .any(|(right, up)| self.overlaps_in(triangle, (halvings + 1, [2 * column + right, 2 * row + up])))
    }
}

/// The corners of least and greatest coordinates of the rectangle about points.
pub(super) fn bounds(points: impl Iterator<Item = DVec2>) -> (DVec2, DVec2) {
    points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)))
}

/// Whether an edge of the first triangle, counter-clockwise, has all of the second triangle on its outer side.
fn are_apart([a, b, c]: &[DVec2; 3], other: &[DVec2; 3]) -> bool {
    [(a, b), (b, c), (c, a)].into_iter().any(|(from, to)| {
        let edge = *to - *from;
        other.iter().all(|corner| {
            let across = *corner - *from;
            edge.perp_dot(across) <= ROUNDING * edge.length() * (edge.length() + across.length())
        })
    })
}
