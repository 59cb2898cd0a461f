//! Division of triangles until no edge is longer than a step.
//!
//! In each round every edge that is too long gets its midpoint, once for both of its triangles, and each triangle is
//! divided into two, three or four by the midpoints of its edges. So no vertex ever lies within an edge of another
//! triangle, and a closed surface stays closed.

use std::collections::HashMap;

use glam::Vec3;

use crate::bake::surface_mesh::{Facet, SurfaceMesh};

/// Divides the triangles of a mesh until no edge is longer than `step_m`. False if that takes more than
/// `most_vertices`.
pub(super) fn subdivide(mesh: &mut SurfaceMesh, step_m: f32, most_vertices: usize) -> bool {
    loop {
        // A closed surface has twice as many facets as vertices; a hostile one may repeat them.
        if mesh.positions.len() > most_vertices || mesh.facets.len() > 4 * most_vertices {
            return false;
        }
        let before = mesh.positions.len();
        let mut midpoints = Midpoints { step_m, of_edge: HashMap::new() };
        let facets = std::mem::take(&mut mesh.facets);
        let mut divided = Vec::with_capacity(facets.len());
        for facet in facets {
            let [a, b, c] = facet.vertices;
            let middles = [[a, b], [b, c], [c, a]].map(|edge| midpoints.of(edge, mesh));
            divide(&facet, middles, &mesh.positions, &mut divided);
        }
        mesh.facets = divided;
        if mesh.positions.len() == before {
            return true;
        }
    }
}

/// The midpoints of long edges.
struct Midpoints {
    step_m: f32,
    /// The vertex in the middle of an edge, by its ends in ascending order.
    of_edge: HashMap<[u32; 2], u32>,
}

impl Midpoints {
    /// The vertex in the middle of an edge; none if the edge is short enough.
    fn of(&mut self, [a, b]: [u32; 2], mesh: &mut SurfaceMesh) -> Option<u32> {
        let ends = [a.min(b), a.max(b)].map(|vertex| mesh.positions[vertex as usize]);
        let middle = ends[0].midpoint(ends[1]);
        // Far from the origin an edge may have no point between its ends.
        if ends[0].distance(ends[1]) <= self.step_m || middle == ends[0] || middle == ends[1] {
            return None;
        }
        Some(*self.of_edge.entry([a.min(b), a.max(b)]).or_insert_with(|| mesh.add_midpoint(middle)))
    }
}

/// Divides a facet by the midpoints of its edges, which begin at its first, second and third vertex.
fn divide(facet: &Facet, middles: [Option<u32>; 3], positions: &[Vec3], divided: &mut Vec<Facet>) {
    let [a, b, c] = facet.vertices;
    let mut add = |vertices: [u32; 3]| divided.push(Facet { vertices, ..*facet });
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

/// The triangle a, b, c divided by the midpoints of a and b, and of b and c. Of the quadrilateral at a and c the
/// shorter diagonal is taken.
fn thirds([a, b, c]: [u32; 3], [ab, bc]: [u32; 2], positions: &[Vec3]) -> [[u32; 3]; 3] {
    let length = |one: u32, other: u32| positions[one as usize].distance(positions[other as usize]);
    let tip = [ab, b, bc];
    if length(ab, c) <= length(a, bc) { [tip, [a, ab, c], [ab, bc, c]] } else { [tip, [a, ab, bc], [a, bc, c]] }
}
