//! Mesh repair: closes scanned and decimated meshes that have small defects, so that they can be snow.

use std::collections::BTreeMap;

use crate::coincident::merged;
use crate::triangle_mesh::TriangleMesh;

/// A repaired mesh, and what was changed.
#[derive(Debug, Clone, PartialEq)]
pub struct RepairedMesh {
    /// The mesh, without texture coordinates, vertex normals and attributes.
    pub mesh: TriangleMesh,
    /// Number of duplicate vertices that were merged.
    pub merged_vertices: usize,
    /// Number of triangles that were dropped because two corners coincide.
    pub dropped_triangles: usize,
    /// Number of edges of each hole that was filled.
    pub filled_holes: Vec<usize>,
}

/// Merges coincident vertices, drops triangles with coincident corners, and fills each hole with a triangle fan.
///
/// A hole is a loop of boundary edges. Loops that share a vertex, and loops of triangles with inconsistent orientation,
/// are left open; [`Topology::of`](crate::topology::Topology::of) counts their edges.
pub fn repair(mesh: &TriangleMesh) -> RepairedMesh {
    let vertices = merged(&mesh.positions);
    let all = mesh.indices.len();
    let mut triangles: Vec<[u32; 3]> =
        mesh.indices.iter().map(|triangle| triangle.map(|corner| vertices[corner as usize])).collect();
    triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
    let dropped_triangles = all - triangles.len();
    let mut filled_holes = Vec::new();
    for hole in holes(&triangles) {
        filled_holes.push(hole.len());
        triangles.extend(hole[1..].windows(2).map(|pair| [hole[0], pair[0], pair[1]]));
    }
    let mut renumbered = BTreeMap::new();
    let mut positions = Vec::new();
    for corner in triangles.iter_mut().flatten() {
        let old = *corner as usize;
        *corner = *renumbered.entry(old).or_insert_with(|| {
            positions.push(mesh.positions[old]);
            index(positions.len() - 1)
        });
    }
    RepairedMesh {
        mesh: TriangleMesh { positions, indices: triangles, ..TriangleMesh::default() },
        merged_vertices: vertices.iter().enumerate().filter(|&(own, &first)| own != first as usize).count(),
        dropped_triangles,
        filled_holes,
    }
}

/// The loops of boundary edges, in the orientation of triangles that fill them.
fn holes(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut edges: Vec<(u32, u32, bool)> = Vec::with_capacity(3 * triangles.len());
    for &[a, b, c] in triangles {
        edges.extend([(a, b), (b, c), (c, a)].map(|(from, to)| (from.min(to), from.max(to), from < to)));
    }
    edges.sort_unstable();
    // A filling triangle runs along a boundary edge in the opposite direction of the existing triangle.
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

#[expect(
    clippy::cast_possible_truncation,
    reason = "there are no more vertices than before, and those had 32-bit indices"
)]
fn index(index: usize) -> u32 {
    index as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::{Topology, volume};
    use crate::triangle_mesh::closed_grids;
    use glam::Vec3;

    /// A box of 3 × 2 × 0.5, with 3 × 2 squares at its top and at its bottom.
    fn solid() -> TriangleMesh {
        let level = |z: f32| (0..12u8).map(move |k| Vec3::new(f32::from(k % 4) - 1.5, 1.0 - f32::from(k / 4), z));
        let positions = level(0.5).chain(level(0.0)).collect();
        TriangleMesh { positions, indices: closed_grids(4, 3), ..TriangleMesh::default() }
    }

    #[test]
    fn a_closed_mesh_is_unchanged() {
        let repaired = repair(&solid());
        assert_eq!(repaired.mesh.indices.len(), solid().indices.len());
        assert_eq!((repaired.merged_vertices, repaired.dropped_triangles), (0, 0));
        assert!(repaired.filled_holes.is_empty());
    }

    #[test]
    fn duplicate_vertices_degenerate_triangles_and_holes_are_repaired() {
        let whole = solid();
        let mut damaged = whole.clone();
        // Two separate holes: a triangle and a quad of the top.
        damaged.indices.drain(0..1);
        damaged.indices.drain(9..11);
        damaged.indices.push([0, 1, 1]);
        let damaged = TriangleMesh::from_triangles(
            &(0..damaged.indices.len()).map(|number| damaged.corners(number)).collect::<Vec<_>>(),
        );
        assert!(!Topology::of(&damaged).is_closed());
        let repaired = repair(&damaged);
        let topology = Topology::of(&repaired.mesh);
        assert!(topology.is_closed() && topology.reversed_edges == 0, "{topology:?}");
        assert_eq!((repaired.dropped_triangles, repaired.filled_holes), (1, vec![3, 4]));
        assert_eq!(repaired.mesh.positions.len(), whole.positions.len());
        assert!((volume(&repaired.mesh) - 3.0).abs() < 1e-6);
    }

    #[test]
    fn holes_that_share_a_vertex_are_left_open() {
        let mut damaged = solid();
        // Two triangles of the top that share one vertex.
        let before = damaged.indices.len();
        damaged.indices.retain(|triangle| ![[0, 5, 1], [1, 6, 2]].contains(triangle));
        assert_eq!(damaged.indices.len(), before - 2);
        let repaired = repair(&damaged);
        assert_eq!(Topology::of(&repaired.mesh).open_edges, Topology::of(&damaged).open_edges);
    }
}
