//! Charts: connected parts of a surface that are laid flat without overlap.
//!
//! A chart grows from a facet across smooth edges, the facets first whose normals are nearest to that of the first one,
//! and is projected along that normal. No normal is inclined to it by more than [`GREATEST_INCLINATION_DEG`], so that
//! lengths shrink to 0.64 at the least. A facet that would overlap the chart is left to another one. Facets without
//! area join the chart of a neighbour.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

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

    /// Lays a surface flat. Vertices at the edges of charts are divided, so that each has one place.
    ///
    /// # Panics
    ///
    /// When there are 2³² vertices.
    pub(in crate::bake) fn of(mesh: &SurfaceMesh, vertices: &mut Vertices) -> Self {
        let mut charts = Self::default();
        let mut divided = Vertices { triangles: vertices.triangles.clone(), ..Vertices::default() };
        // For each vertex the last chart that has it, and its number there.
        let mut last = vec![(NO_CHART, 0); vertices.positions.len()];
        for (chart, grown) in (0..).zip(Growth::of(mesh).charts()) {
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
    /// Size of the squares in which triangles are sought, in m: the root mean square of the longest edges.
    square_m: f64,
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
        let longest_squared = |triangle: &[u32; 3]| {
            let [a, b, c] = corners(triangle);
            f64::from(a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a)))
        };
        let square_m = (triangles.iter().map(longest_squared).sum::<f64>() / triangles.len() as f64).sqrt();
        Self { mesh, normals, neighbours, chart_of: vec![NO_CHART; triangles.len()], square_m }
    }

    /// All charts. Together they have each facet once. They begin at facets with area, whose normals direct them;
    /// facets without area that none of them reaches have charts of their own.
    fn charts(mut self) -> Vec<Grown> {
        let mut charts = Vec::new();
        for has_area in [true, false] {
            for (first, number) in (0..).zip(0..self.chart_of.len()) {
                if self.chart_of[number] == NO_CHART && (self.normals[number] != Vec3::ZERO) == has_area {
                    charts.push(self.grow(charts.len(), first));
                }
            }
        }
        charts
    }

    /// The chart that grows from a facet.
    #[expect(clippy::cast_possible_truncation, reason = "a mesh in memory has fewer than 2^32 triangles")]
    fn grow(&mut self, number: usize, first: u32) -> Grown {
        let axis = self.normals[first as usize].try_normalize().unwrap_or(Vec3::Z);
        let least_cos = GREATEST_INCLINATION_DEG.to_radians().cos();
        let plane = Plane::new(self.mesh.positions[self.mesh.facets[first as usize].vertices[0] as usize], axis);
        let mut squares = Squares { square_m: self.square_m, triangles: HashMap::new() };
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

/// The triangles of a chart in squares of the plane, to find those near another one.
struct Squares {
    square_m: f64,
    triangles: HashMap<[i64; 2], Vec<[DVec2; 3]>>,
}

impl Squares {
    /// The squares of the rectangle about a triangle.
    #[expect(clippy::cast_possible_truncation, reason = "a chart has fewer than 2^63 squares")]
    fn around(&self, [a, b, c]: &[DVec2; 3]) -> impl Iterator<Item = [i64; 2]> + use<> {
        let square = |place: DVec2| (place / self.square_m).floor().to_array().map(|index| index as i64);
        let ([left, low], [right, high]) = (square(a.min(*b).min(*c)), square(a.max(*b).max(*c)));
        (left..=right).flat_map(move |column| (low..=high).map(move |row| [column, row]))
    }

    fn add(&mut self, triangle: [DVec2; 3]) {
        for square in self.around(&triangle) {
            self.triangles.entry(square).or_default().push(triangle);
        }
    }

    fn overlap(&self, triangle: &[DVec2; 3]) -> bool {
        let near = self.around(triangle).filter_map(|square| self.triangles.get(&square)).flatten();
        near.into_iter().any(|other| !are_apart(triangle, other) && !are_apart(other, triangle))
    }
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
