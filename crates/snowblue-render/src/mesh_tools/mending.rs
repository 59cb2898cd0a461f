//! Surfaces with small faults made closed, so that they can be snow: the faults that scanned and thinned-out meshes have.

use std::collections::BTreeMap;

use crate::geometry::triangles::Triangles;
use crate::mesh_tools::topology::merged;

/// A surface after mending, and what was done to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Mended {
    /// The surface: places and corners alone.
    pub surface: Triangles,
    /// Vertices that lay where another one does, and are that one now.
    pub merged_vertices: usize,
    /// Triangles with two corners in one place, which are gone.
    pub dropped_triangles: usize,
    /// Edges of the holes that were filled.
    pub filled_edges: Vec<usize>,
}

/// Merges vertices in one place, drops triangles with two corners there, and fills each hole with a fan of triangles.
///
/// A hole is a ring of edges of one triangle each. Rings that meet in a vertex are left open, as are those whose
/// triangles do not all face the same way: [`Topology::of`](crate::mesh_tools::topology::Topology::of) tells of them.
pub fn mend(surface: &Triangles) -> Mended {
    let vertices = merged(&surface.positions);
    let all = surface.corners.len();
    let mut corners: Vec<[u32; 3]> =
        surface.corners.iter().map(|triangle| triangle.map(|corner| vertices[corner as usize])).collect();
    corners.retain(|&[a, b, c]| a != b && b != c && c != a);
    let dropped_triangles = all - corners.len();
    let mut filled_edges = Vec::new();
    for hole in holes(&corners) {
        filled_edges.push(hole.len());
        corners.extend(hole[1..].windows(2).map(|pair| [hole[0], pair[0], pair[1]]));
    }
    let mut renumbered = BTreeMap::new();
    let mut positions = Vec::new();
    for corner in corners.iter_mut().flatten() {
        let old = *corner as usize;
        *corner = *renumbered.entry(old).or_insert_with(|| {
            positions.push(surface.positions[old]);
            index(positions.len() - 1)
        });
    }
    Mended {
        surface: Triangles { positions, corners, ..Triangles::default() },
        merged_vertices: vertices.iter().enumerate().filter(|&(own, &first)| own != first as usize).count(),
        dropped_triangles,
        filled_edges,
    }
}

/// The rings of edges of one triangle each, in the sense in which triangles that fill them go round.
fn holes(corners: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut edges: Vec<(u32, u32, bool)> = Vec::with_capacity(3 * corners.len());
    for &[a, b, c] in corners {
        edges.extend([(a, b), (b, c), (c, a)].map(|(from, to)| (from.min(to), from.max(to), from < to)));
    }
    edges.sort_unstable();
    // The filling goes along an open edge against the triangle that is there.
    let mut next = BTreeMap::new();
    let mut forks = Vec::new();
    for uses in edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)).filter(|uses| uses.len() == 1) {
        let (low, high, forward) = uses[0];
        let (from, to) = if forward { (high, low) } else { (low, high) };
        if next.insert(from, to).is_some() {
            forks.push(from);
        }
    }
    let mut holes = Vec::new();
    while let Some((start, mut at)) = next.pop_first() {
        let mut hole = vec![start];
        while at != start {
            hole.push(at);
            let Some(on) = next.remove(&at) else { break };
            at = on;
        }
        if at == start && !hole.iter().any(|vertex| forks.contains(vertex)) {
            holes.push(hole);
        }
    }
    holes
}

#[expect(clippy::cast_possible_truncation, reason = "no more vertices than before, and those were named by 32 bits")]
fn index(index: usize) -> u32 {
    index as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh_tools::topology::{Topology, volume};
    use crate::shapes::height_field::Heights;
    use glam::Vec3;

    fn solid() -> Triangles {
        Heights::new(4, vec![1.0; 12]).unwrap().solid(Vec3::new(3.0, 2.0, 0.5), 0.0).unwrap()
    }

    #[test]
    fn a_closed_surface_stays_as_it_is() {
        let mended = mend(&solid());
        assert_eq!(mended.surface.corners.len(), solid().corners.len());
        assert_eq!((mended.merged_vertices, mended.dropped_triangles), (0, 0));
        assert!(mended.filled_edges.is_empty());
    }

    #[test]
    fn doubled_vertices_flat_triangles_and_two_holes_are_mended() {
        let whole = solid();
        let mut torn = whole.clone();
        // Two holes that do not touch: one triangle of the top, and a whole square of it.
        torn.corners.drain(0..1);
        torn.corners.drain(9..11);
        torn.corners.push([0, 1, 1]);
        let torn = Triangles::loose(&(0..torn.corners.len()).map(|number| torn.places(number)).collect::<Vec<_>>());
        assert!(!Topology::of(&torn).is_closed());
        let mended = mend(&torn);
        let topology = Topology::of(&mended.surface);
        assert!(topology.is_closed() && topology.reversed_edges == 0, "{topology:?}");
        assert_eq!((mended.dropped_triangles, mended.filled_edges), (1, vec![3, 4]));
        assert_eq!(mended.surface.positions.len(), whole.positions.len());
        assert!((volume(&mended.surface) - 3.0).abs() < 1e-6);
    }

    #[test]
    fn holes_that_meet_in_a_vertex_are_left_open() {
        let mut torn = solid();
        // Two triangles of the upper grid with one vertex in common.
        let before = torn.corners.len();
        torn.corners.retain(|triangle| ![[0, 5, 1], [1, 6, 2]].contains(triangle));
        assert_eq!(torn.corners.len(), before - 2);
        let mended = mend(&torn);
        assert_eq!(Topology::of(&mended.surface).open_edges, Topology::of(&torn).open_edges);
    }
}
