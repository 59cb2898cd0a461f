//! Division of triangles until no edge is longer than a step.
//!
//! In each round every edge that is too long gets its midpoint, once for both of its faces, and each triangle is
//! divided into two, three or four by the midpoints of its edges. So no vertex ever lies within an edge of another
//! triangle, and a closed surface stays closed.
//!
//! Beside a sharp edge of the surface, light may fall off within a cell of the light field. Edges of triangles that
//! run away from a sharp edge are therefore shorter. Two triangles that form a rectangle are divided together, into
//! rectangles in rows along its sides. If the vertices of a row had different distances from the edge, the light that
//! is interpolated between them would rise and fall along the row.

use std::collections::{HashMap, HashSet};

use glam::{Vec2, Vec3};
use snowblue_geometry::edges::visit_edges;

use crate::bake::surface_mesh::{Facet, SurfaceMesh, is_smooth};

/// Greatest length of the sides of a rectangle, in steps: a little below √½, so that no diagonal is longer than a step.
const MAX_SIDE: f32 = 0.999 * std::f32::consts::FRAC_1_SQRT_2;
/// Greatest cosine of the angle between the sides of a parallelogram that counts as a rectangle: 15° from a right
/// angle.
const RECTANGLE_COS: f32 = 0.26;
/// Greatest distance of the fourth corner of a parallelogram from its place, as a fraction of the diagonal.
/// Coordinates of mesh corners have single precision of 24 bits, and may be far from the origin.
const ROUNDING: f32 = 1e-4;

/// Greatest cosine between a sharp edge and an edge that runs away from it: 26°.
const AWAY_COS: f32 = 0.9;

/// Greatest lengths of edges, in m.
#[derive(Debug, Clone, Copy)]
pub(super) struct Longest {
    /// Greatest length of all edges.
    pub(super) edge_m: f32,
    /// Greatest length of edges that run away from a sharp edge.
    pub(super) away_m: f32,
}

/// Divides the triangles of a mesh until no edge is longer than allowed. Returns false if more than `most_vertices`
/// vertices are needed.
pub(super) fn subdivide(mesh: &mut SurfaceMesh, longest: Longest, most_vertices: usize) -> bool {
    let mut sharp = SharpEdges::of(mesh);
    let mut faces = Faces::of(mesh);
    loop {
        // A closed surface has twice as many triangles as vertices; a malicious mesh may repeat triangles.
        let triangles = faces.triangles.len() + 2 * faces.rectangles.len();
        if mesh.positions.len() > most_vertices || triangles > 4 * most_vertices {
            return false;
        }
        let before = mesh.positions.len();
        faces = faces.divided(mesh, longest, &mut sharp);
        if mesh.positions.len() == before {
            mesh.facets = faces.into_triangles(&mesh.positions);
            return true;
        }
    }
}

/// The faces of a mesh.
struct Faces {
    triangles: Vec<Facet>,
    rectangles: Vec<Rectangle>,
}

/// Two triangles that make a rectangle.
#[derive(Clone, Copy)]
struct Rectangle {
    /// Its corners, counter-clockwise from outside.
    corners: [u32; 4],
    normal: Vec3,
}

impl Faces {
    /// The faces of a mesh; its facets are taken.
    fn of(mesh: &mut SurfaceMesh) -> Self {
        let facets = std::mem::take(&mut mesh.facets);
        // Further vertices lie on an ellipsoid, not in the plane of a rectangle. The triangles of a rectangle may lie
        // apart in a lightmap.
        if mesh.ellipsoid.is_some() || mesh.has_uv {
            return Self { triangles: facets, rectangles: Vec::new() };
        }
        let corners: Vec<[u32; 3]> = facets.iter().map(|facet| facet.vertices).collect();
        let mut is_taken = vec![false; facets.len()];
        let mut rectangles = Vec::new();
        visit_edges(mesh.positions.len(), &corners, |sides| {
            let [one, other] = sides else { return };
            let is_reversed = one.from == other.from;
            let [one, other] = [one.triangle, other.triangle].map(|triangle| triangle as usize);
            if is_reversed || is_taken[one] || is_taken[other] {
                return;
            }
            if let Some(rectangle) = rectangle([&facets[one], &facets[other]], &mesh.positions) {
                (is_taken[one], is_taken[other]) = (true, true);
                rectangles.push(rectangle);
            }
        });
        let triangles = facets.into_iter().zip(is_taken).filter(|(_, is_taken)| !is_taken).map(|(facet, _)| facet);
        Self { triangles: triangles.collect(), rectangles }
    }

    /// Divides the faces at the midpoints of long edges.
    fn divided(self, mesh: &mut SurfaceMesh, longest: Longest, sharp: &mut SharpEdges) -> Self {
        let edges = self.rectangles.iter().flat_map(Rectangle::sides).map(ascending);
        let mut midpoints = Midpoints { longest, sharp, sides: edges.collect(), of_edge: HashMap::new() };
        let mut divided = Self { triangles: Vec::with_capacity(self.triangles.len()), rectangles: Vec::new() };
        let mut triangles = self.triangles;
        for rectangle in self.rectangles {
            let middles = rectangle.sides().map(|side| midpoints.of(side, mesh));
            if let Some(parts) = rectangle.divided(middles, mesh) {
                divided.rectangles.extend(parts);
            } else {
                // Through rounding, only one of two opposite sides is too long.
                triangles.extend(rectangle.triangles(&mesh.positions));
            }
        }
        for facet in triangles {
            let [a, b, c] = facet.vertices;
            let middles = [[a, b], [b, c], [c, a]].map(|edge| midpoints.of(edge, mesh));
            divide(&facet, middles, &mesh.positions, &mut divided.triangles);
        }
        divided
    }

    fn into_triangles(self, positions: &[Vec3]) -> Vec<Facet> {
        let halves = self.rectangles.iter().flat_map(|rectangle| rectangle.triangles(positions));
        self.triangles.into_iter().chain(halves).collect()
    }
}

/// The rectangle that two facets with a common edge make, if they do.
fn rectangle(facets: [&Facet; 2], positions: &[Vec3]) -> Option<Rectangle> {
    let [[a, b, c], other] = facets.map(|facet| facet.vertices);
    let normal = facets[0].normal;
    if normal == Vec3::ZERO || normal.distance(facets[1].normal) > ROUNDING {
        return None;
    }
    let at = |vertex: u32| positions[vertex as usize];
    // The corner of the first facet that the second facet lacks, with the next two corners, the ends of the diagonal.
    let turns = [[a, b, c], [b, c, a], [c, a, b]];
    let [corner, from, to] = turns.into_iter().find(|[corner, ..]| !other.contains(corner))?;
    let opposite = other.into_iter().find(|vertex| *vertex != from && *vertex != to)?;
    let (along, across) = (at(from) - at(corner), at(to) - at(corner));
    let is_right = along.dot(across).abs() <= RECTANGLE_COS * along.length() * across.length();
    let is_opposite = at(opposite).distance(at(from) + across) <= ROUNDING * at(from).distance(at(to));
    (is_right && is_opposite).then_some(Rectangle { corners: [corner, from, opposite, to], normal })
}

impl Rectangle {
    fn sides(&self) -> [[u32; 2]; 4] {
        let [a, b, c, d] = self.corners;
        [[a, b], [b, c], [c, d], [d, a]]
    }

    /// The rectangles between the midpoints of its sides; none if only one of two opposite sides has a midpoint.
    fn divided(self, middles: [Option<u32>; 4], mesh: &mut SurfaceMesh) -> Option<Vec<Self>> {
        let [a, b, c, d] = self.corners;
        let parts = match middles {
            [None, None, None, None] => vec![[a, b, c, d]],
            [Some(ab), None, Some(cd), None] => vec![[a, ab, cd, d], [ab, b, c, cd]],
            [None, Some(bc), None, Some(da)] => vec![[a, b, bc, da], [da, bc, c, d]],
            [Some(ab), Some(bc), Some(cd), Some(da)] => {
                let [one, other] = [ab, cd].map(|vertex| mesh.positions[vertex as usize]);
                let middle = mesh.add_midpoint(one.midpoint(other));
                vec![[a, ab, middle, da], [ab, b, bc, middle], [middle, bc, c, cd], [da, middle, cd, d]]
            }
            _ => return None,
        };
        Some(parts.into_iter().map(|corners| Self { corners, ..self }).collect())
    }

    /// Its halves along the shorter diagonal.
    fn triangles(&self, positions: &[Vec3]) -> [Facet; 2] {
        let [a, b, c, d] = self.corners;
        let length = |one: u32, other: u32| positions[one as usize].distance(positions[other as usize]);
        let halves = if length(b, d) <= length(a, c) { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] };
        halves.map(|vertices| Facet { vertices, normal: self.normal, uv: [Vec2::ZERO; 3] })
    }
}

/// The edges of a mesh at which its surface is not smooth.
#[derive(Default)]
struct SharpEdges {
    /// The edges, as their ends in ascending order.
    edges: HashSet<[u32; 2]>,
    /// Their directions at each of their vertices.
    directions: HashMap<u32, Vec<Vec3>>,
}

impl SharpEdges {
    fn of(mesh: &SurfaceMesh) -> Self {
        let mut sharp = Self::default();
        // The triangles of an ellipsoid stand for a round surface.
        if mesh.ellipsoid.is_some() {
            return sharp;
        }
        let corners: Vec<[u32; 3]> = mesh.facets.iter().map(|facet| facet.vertices).collect();
        visit_edges(mesh.positions.len(), &corners, |sides| {
            let [one, other] = sides else { return };
            let [normal, beside] = [one, other].map(|side| mesh.facets[side.triangle as usize].normal);
            if !is_smooth(normal, beside) {
                let edge = ascending([one.from, one.to]);
                let [from, to] = edge.map(|vertex| mesh.positions[vertex as usize]);
                sharp.edges.insert(edge);
                for vertex in edge {
                    sharp.directions.entry(vertex).or_default().push((to - from).normalize_or_zero());
                }
            }
        });
        sharp
    }

    /// Whether an edge runs away from a sharp edge at one of its ends.
    fn is_left_by(&self, edge: [u32; 2], direction: Vec3) -> bool {
        let is_away = |sharp: &Vec3| sharp.dot(direction).abs() < AWAY_COS;
        edge.iter().any(|vertex| self.directions.get(vertex).is_some_and(|sharp| sharp.iter().any(is_away)))
    }

    /// Divides an edge if it is a sharp edge.
    fn divide(&mut self, [from, to]: [u32; 2], middle: u32, direction: Vec3) {
        if self.edges.contains(&[from, to]) {
            self.edges.extend([ascending([from, middle]), ascending([to, middle])]);
            self.directions.insert(middle, vec![direction]);
        }
    }
}

/// The midpoints of long edges.
struct Midpoints<'s> {
    longest: Longest,
    sharp: &'s mut SharpEdges,
    /// The sides of rectangles. A side counts as long if the diagonal may be too long.
    sides: HashSet<[u32; 2]>,
    /// The vertex in the middle of an edge, by its ends in ascending order.
    of_edge: HashMap<[u32; 2], u32>,
}

impl Midpoints<'_> {
    /// The vertex in the middle of an edge; none if the edge is short enough.
    fn of(&mut self, edge: [u32; 2], mesh: &mut SurfaceMesh) -> Option<u32> {
        let edge = ascending(edge);
        let ends = edge.map(|vertex| mesh.positions[vertex as usize]);
        let middle = ends[0].midpoint(ends[1]);
        let direction = (ends[1] - ends[0]).normalize_or_zero();
        let Longest { edge_m, away_m } = self.longest;
        let longest_m = if self.sides.contains(&edge) { MAX_SIDE * edge_m } else { edge_m };
        let longest_m = if self.sharp.is_left_by(edge, direction) { longest_m.min(away_m) } else { longest_m };
        // Far from the origin an edge may have no point between its ends.
        if ends[0].distance(ends[1]) <= longest_m || middle == ends[0] || middle == ends[1] {
            return None;
        }
        let number = *self.of_edge.entry(edge).or_insert_with(|| mesh.add_midpoint(middle));
        self.sharp.divide(edge, number, direction);
        Some(number)
    }
}

fn ascending([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Divides a facet by the midpoints of its edges, which begin at its first, second and third vertex.
fn divide(facet: &Facet, middles: [Option<u32>; 3], positions: &[Vec3], divided: &mut Vec<Facet>) {
    let [a, b, c] = facet.vertices;
    let [at_a, at_b, at_c] = facet.uv;
    let places = [at_a, at_b, at_c, at_a.midpoint(at_b), at_b.midpoint(at_c), at_c.midpoint(at_a)];
    let uv_of = |vertex: u32| {
        let vertices = facet.vertices.map(Some).into_iter().chain(middles);
        vertices.zip(places).find(|(other, _)| *other == Some(vertex)).map_or(at_a, |(_, place)| place)
    };
    let mut add = |vertices: [u32; 3]| divided.push(Facet { vertices, uv: vertices.map(uv_of), ..*facet });
    match middles {
        [None, None, None] => add([a, b, c]),
        [Some(ab), Some(bc), Some(ca)] => {
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].into_iter().for_each(add)
        }
        [Some(ab), None, None] => halves([a, b, c], ab).into_iter().for_each(add),
        [None, Some(bc), None] => halves([b, c, a], bc).into_iter().for_each(add),
        [None, None, Some(ca)] => halves([c, a, b], ca).into_iter().for_each(add),
        [Some(ab), Some(bc), None] => thirds([a, b, c], [ab, bc], positions).into_iter().for_each(add),
        [None, Some(bc), Some(ca)] => thirds([b, c, a], [bc, ca], positions).into_iter().for_each(add),
        [Some(ab), None, Some(ca)] => thirds([c, a, b], [ca, ab], positions).into_iter().for_each(add),
    }
}

/// The triangle a, b, c divided by the midpoint of a and b.
fn halves([a, b, c]: [u32; 3], ab: u32) -> [[u32; 3]; 2] {
    [[a, ab, c], [ab, b, c]]
}

/// The triangle a, b, c divided by the midpoints of a and b, and of b and c. The quadrilateral at a and c is divided
/// along its shorter diagonal.
fn thirds([a, b, c]: [u32; 3], [ab, bc]: [u32; 2], positions: &[Vec3]) -> [[u32; 3]; 3] {
    let length = |one: u32, other: u32| positions[one as usize].distance(positions[other as usize]);
    let tip = [ab, b, bc];
    if length(ab, c) <= length(a, bc) { [tip, [a, ab, c], [ab, bc, c]] } else { [tip, [a, ab, bc], [a, bc, c]] }
}
