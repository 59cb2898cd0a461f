//! Charts: connected parts of a surface that are laid flat without overlap.
//!
//! A chart grows from a facet across smooth edges, the facets first whose normals are nearest to that of the first one,
//! and is projected along that normal. No normal is inclined to it by more than [`GREATEST_INCLINATION_DEG`], so that
//! lengths shrink to 0.64 at the least. A facet that would overlap the chart is left to another one. Facets without
//! area join the chart of a neighbour.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};

use glam::{DVec2, DVec3, Vec3};
use snowblue_geometry::edges::visit_edges;
use snowblue_geometry::vertex_normals::face_normal;

use crate::bake::lightmap::packing::GUTTER;
use crate::bake::lightmap::rectangle::smallest_rectangle;
use crate::bake::surface_mesh::SurfaceMesh;
use crate::bake::vertices::{Vertices, is_smooth};

/// Greatest angle between the normal of a facet and the direction along which its chart is projected.
const GREATEST_INCLINATION_DEG: f32 = 50.0;
/// Overlaps of triangles by less than this fraction of their edges are rounding.
const ROUNDING: f64 = 1e-9;
/// Most halvings of squares. Smaller triangles are in squares that are wider than they are.
const MOST_HALVINGS: f64 = 40.0;
/// Triangles after which a report is due.
const TRIANGLES_PER_REPORT: usize = 1 << 12;
/// A triangle that no chart has yet.
const NO_CHART: u32 = u32::MAX;

/// A part of a surface that is laid flat.
#[derive(Debug)]
pub(in crate::bake) struct Chart {
    /// Its triangles.
    pub(super) triangles: Vec<u32>,
    /// Sides of the smallest rectangle about it, in m, the longer one first.
    pub(super) extent_m: DVec2,
}

/// The charts of a surface.
#[derive(Debug, Default)]
pub(in crate::bake) struct Charts {
    pub(super) list: Vec<Chart>,
    /// Where each vertex of the surface lies in the rectangle of its chart, in m.
    pub(super) flat_m: Vec<DVec2>,
}

impl Charts {
    /// Where the corners of a triangle lie in a chart with its gutter, in texels.
    pub(super) fn corners(&self, vertices: [u32; 3], texels_per_m: f64) -> [DVec2; 3] {
        vertices.map(|vertex| self.flat_m[vertex as usize] * texels_per_m + f64::from(GUTTER))
    }

    /// Lays a surface flat. Vertices at the edges of charts are divided, so that each has one place. It reports how
    /// many triangles have a chart.
    ///
    /// # Panics
    ///
    /// When there are 2³² vertices.
    pub(in crate::bake) fn of(mesh: &SurfaceMesh, vertices: &mut Vertices, report: &dyn Fn(usize)) -> Self {
        let mut charts = Self::default();
        let mut divided = Vertices { triangles: vertices.triangles.clone(), ..Vertices::default() };
        // For each vertex the last chart that has it, and its number there.
        let mut last = vec![(NO_CHART, 0); vertices.positions.len()];
        for (chart, grown) in (0..).zip(Growth::of(mesh).charts(report)) {
            let first = divided.positions.len();
            for &triangle in &grown.triangles {
                for vertex in &mut divided.triangles[triangle as usize] {
                    let old = *vertex as usize;
                    if last[old].0 != chart {
                        let number = u32::try_from(divided.positions.len());
                        last[old] = (chart, number.expect("a mesh in memory has fewer than 2^32 vertices"));
                        divided.positions.push(vertices.positions[old]);
                        divided.normals.push(vertices.normals[old]);
                        divided.points.push(vertices.points[old]);
                        charts.flat_m.push(grown.plane.flat(vertices.positions[old]));
                    }
                    *vertex = last[old].1;
                }
            }
            let extent_m = smallest_rectangle(&mut charts.flat_m[first..]);
            charts.list.push(Chart { triangles: grown.triangles, extent_m });
        }
        *vertices = divided;
        charts
    }
}

/// A chart that has grown.
struct Grown {
    triangles: Vec<u32>,
    plane: Plane,
}

/// The growth of all charts of a mesh.
struct Growth<'m> {
    mesh: &'m SurfaceMesh,
    /// Unit normal of each facet.
    normals: Vec<Vec3>,
    /// Neighbours of each facet across smooth edges that two facets share.
    neighbours: Vec<[Option<u32>; 3]>,
    /// The chart of each facet.
    chart_of: Vec<u32>,
    /// The longest edge, in m.
    longest_m: f64,
    /// Triangles that have a chart.
    done: usize,
}

impl<'m> Growth<'m> {
    fn of(mesh: &'m SurfaceMesh) -> Self {
        let triangles: Vec<[u32; 3]> = mesh.facets.iter().map(|facet| facet.vertices).collect();
        let corners = |triangle: &[u32; 3]| triangle.map(|vertex| mesh.positions[vertex as usize]);
        // Facets of an ellipsoid have the normal of the face that they were divided from.
        let normal = |(triangle, whole): (&[u32; 3], Vec3)| {
            let normal = face_normal(corners(triangle));
            if normal == Vec3::ZERO { whole } else { normal }
        };
        let normals: Vec<Vec3> =
            triangles.iter().zip(mesh.facets.iter().map(|facet| facet.normal)).map(normal).collect();
        let mut neighbours = vec![[None; 3]; triangles.len()];
        let mut link = |from: u32, to: u32| {
            if let Some(place) = neighbours[from as usize].iter_mut().find(|place| place.is_none()) {
                *place = Some(to);
            }
        };
        visit_edges(mesh.positions.len(), &triangles, |sides| {
            let [one, other] = sides else { return };
            let [normal, beside] = [one, other].map(|side| normals[side.triangle as usize]);
            if one.from != other.from && is_smooth(normal, beside) {
                link(one.triangle, other.triangle);
                link(other.triangle, one.triangle);
            }
        });
        let longest = |triangle: &[u32; 3]| {
            let [a, b, c] = corners(triangle);
            a.distance(b).max(b.distance(c)).max(c.distance(a))
        };
        let longest_m = triangles.iter().map(longest).fold(f32::MIN_POSITIVE, f32::max).into();
        Self { mesh, normals, neighbours, chart_of: vec![NO_CHART; triangles.len()], longest_m, done: 0 }
    }

    /// All charts. Together they have each facet once. They begin at facets with area, whose normals direct them;
    /// facets without area that none of them reaches have charts of their own.
    fn charts(mut self, report: &dyn Fn(usize)) -> Vec<Grown> {
        let mut charts = Vec::new();
        for has_area in [true, false] {
            for (first, number) in (0..).zip(0..self.chart_of.len()) {
                if self.chart_of[number] == NO_CHART && (self.normals[number] != Vec3::ZERO) == has_area {
                    charts.push(self.grow(charts.len(), first, report));
                }
            }
        }
        charts
    }

    /// The chart that grows from a facet.
    #[expect(clippy::cast_possible_truncation, reason = "a mesh in memory has fewer than 2^32 triangles")]
    fn grow(&mut self, number: usize, first: u32, report: &dyn Fn(usize)) -> Grown {
        let axis = self.normals[first as usize].try_normalize().unwrap_or(Vec3::Z);
        let least_cos = GREATEST_INCLINATION_DEG.to_radians().cos();
        let plane = Plane::new(self.mesh.positions[self.mesh.facets[first as usize].vertices[0] as usize], axis);
        let mut squares = Squares::new(self.longest_m);
        let mut triangles = Vec::new();
        // Positive numbers are in the order of their bits.
        let mut waiting = BinaryHeap::from([(1.0_f32.to_bits(), Reverse(first))]);
        while let Some((_, Reverse(facet))) = waiting.pop() {
            let index = facet as usize;
            if self.chart_of[index] != NO_CHART {
                continue;
            }
            let flat = self.mesh.facets[index].vertices.map(|vertex| plane.flat(self.mesh.positions[vertex as usize]));
            if self.normals[index] != Vec3::ZERO {
                if squares.overlap(&flat) {
                    continue;
                }
                squares.add(flat);
            }
            self.chart_of[index] = number as u32;
            triangles.push(facet);
            self.done += 1;
            if self.done.is_multiple_of(TRIANGLES_PER_REPORT) {
                report(self.done);
            }
            for neighbour in self.neighbours[index].into_iter().flatten() {
                let normal = self.normals[neighbour as usize];
                let cos = if normal == Vec3::ZERO { 1.0 } else { normal.dot(axis) };
                if self.chart_of[neighbour as usize] == NO_CHART && cos >= least_cos {
                    waiting.push((cos.to_bits(), Reverse(neighbour)));
                }
            }
        }
        Grown { triangles, plane }
    }
}

/// The plane onto which a chart is projected.
struct Plane {
    origin: DVec3,
    axes: [DVec3; 2],
}

impl Plane {
    fn new(origin: Vec3, normal: Vec3) -> Self {
        let (one, other) = normal.as_dvec3().normalize().any_orthonormal_pair();
        Self { origin: origin.as_dvec3(), axes: [one, other] }
    }

    fn flat(&self, position: Vec3) -> DVec2 {
        let from_origin = position.as_dvec3() - self.origin;
        DVec2::new(self.axes[0].dot(from_origin), self.axes[1].dot(from_origin))
    }
}

/// A square of a plane: how often [`Squares::widest_m`] is halved for its side, its column and its row.
type Square = (i32, [i64; 2]);

/// The triangles of a chart in squares of the plane, to find those near another one. A triangle is in the one to four
/// squares that it reaches of those that are as wide as it or less than twice as wide: of the triangles in the squares
/// of one size only few are near another one, whatever sizes there are.
struct Squares {
    /// Side of the widest squares, in m. No triangle is wider.
    widest_m: f64,
    triangles: HashMap<Square, Vec<[DVec2; 3]>>,
    /// Squares with triangles in narrower ones within them.
    divided: HashSet<Square>,
}

impl Squares {
    fn new(widest_m: f64) -> Self {
        Self { widest_m, triangles: HashMap::new(), divided: HashSet::new() }
    }

    /// The squares in which a triangle is.
    fn of(&self, triangle: &[DVec2; 3]) -> impl Iterator<Item = Square> + use<> {
        let (low, high) = bounds(triangle);
        let halvings = (self.widest_m / (high - low).max_element()).log2().floor();
        #[expect(clippy::cast_possible_truncation, reason = "clamped")]
        self.around(triangle, halvings.clamp(0.0, MOST_HALVINGS) as i32)
    }

    /// The squares of a size that the rectangle about a triangle reaches.
    #[expect(clippy::cast_possible_truncation, reason = "a chart has fewer than 2^63 squares")]
    fn around(&self, triangle: &[DVec2; 3], halvings: i32) -> impl Iterator<Item = Square> + use<> {
        let (low, high) = bounds(triangle);
        let per_m = f64::from(halvings).exp2() / self.widest_m;
        let [[left, bottom], [right, top]] =
            [low, high].map(|place| (place * per_m).floor().to_array().map(|index| index as i64));
        (left..=right).flat_map(move |column| (bottom..=top).map(move |row| (halvings, [column, row])))
    }

    fn add(&mut self, triangle: [DVec2; 3]) {
        for mut square in self.of(&triangle) {
            self.triangles.entry(square).or_default().push(triangle);
            while square.0 > 0 {
                square = wider(square);
                if !self.divided.insert(square) {
                    break;
                }
            }
        }
    }

    fn overlap(&self, triangle: &[DVec2; 3]) -> bool {
        let overlaps = |square: &Square| {
            let mut near = self.triangles.get(square).into_iter().flatten();
            near.any(|other| !are_apart(triangle, other) && !are_apart(other, triangle))
        };
        let own: Vec<Square> = self.of(triangle).collect();
        let Some((halvings, _)) = own.first().copied() else { return false };
        let mut narrower = own.clone();
        if own.iter().any(overlaps) || (0..halvings).any(|wide| self.around(triangle, wide).any(|at| overlaps(&at))) {
            return true;
        }
        let (low, high) = bounds(triangle);
        while let Some((halvings, [column, row])) = narrower.pop() {
            if !self.divided.contains(&(halvings, [column, row])) {
                continue;
            }
            for (right, up) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let part = (halvings + 1, [2 * column + right, 2 * row + up]);
                let side_m = self.widest_m * f64::from(-part.0).exp2();
                let corner = DVec2::from(part.1.map(|index| index as f64 * side_m));
                if corner.cmple(high).all() && (corner + side_m).cmpge(low).all() {
                    if overlaps(&part) {
                        return true;
                    }
                    narrower.push(part);
                }
            }
        }
        false
    }
}

/// The square of twice the side around a square.
fn wider((halvings, [column, row]): Square) -> Square {
    (halvings - 1, [column.div_euclid(2), row.div_euclid(2)])
}

/// The corners of least and greatest coordinates of the rectangle about a triangle.
fn bounds([a, b, c]: &[DVec2; 3]) -> (DVec2, DVec2) {
    (a.min(*b).min(*c), a.max(*b).max(*c))
}

/// Whether an edge of the first triangle, counter-clockwise, has all of the other one on its outer side.
fn are_apart([a, b, c]: &[DVec2; 3], other: &[DVec2; 3]) -> bool {
    [(a, b), (b, c), (c, a)].into_iter().any(|(from, to)| {
        let edge = *to - *from;
        other.iter().all(|corner| {
            let across = *corner - *from;
            edge.perp_dot(across) <= ROUNDING * edge.length() * (edge.length() + across.length())
        })
    })
}
