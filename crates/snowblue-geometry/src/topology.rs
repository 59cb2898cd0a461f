//! Mesh topology: whether a triangle mesh is closed, after coincident vertices are merged.
//!
//! If every edge belongs to an even number of triangles, every line crosses the surface an even number of times. If as
//! many triangles run along each edge in one direction as in the other, every line enters the surface as often as it
//! leaves it. Depths through a solid rely on both.

use glam::DVec3;
use rayon::prelude::*;

use crate::coincident::{merged, renumbered};
use crate::edges::{Side, visit_edges};
use crate::triangle_mesh::TriangleMesh;

/// Counts of triangles, vertices and edges by kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Topology {
    /// Number of triangles.
    pub triangles: usize,
    /// Number of vertices that coincide with an earlier one, as at texture seams, and are merged with it.
    pub merged_vertices: usize,
    /// Number of triangles without area. Triangles with coincident corners do not count for the edges.
    pub degenerate_triangles: usize,
    /// Number of edges of exactly one triangle.
    pub open_edges: usize,
    /// Number of edges of more than two triangles.
    pub shared_edges: usize,
    /// Number of edges of an odd number of triangles, at least three.
    pub odd_shared_edges: usize,
    /// Number of edges of two triangles with inconsistent orientation.
    pub reversed_edges: usize,
    /// Number of edges of an even number of triangles, at least four, of which more run in one direction.
    pub unbalanced_edges: usize,
    /// Greatest number of triangles of an edge.
    pub most_of_an_edge: usize,
}

impl Topology {
    /// Analyses a mesh.
    pub fn of(mesh: &TriangleMesh) -> Self {
        let vertices = merged(&mesh.positions, &mesh.indices);
        let mut topology = Self { triangles: mesh.indices.len(), ..Self::default() };
        topology.merged_vertices =
            vertices.iter().enumerate().filter(|&(index, &merged)| index != merged as usize).count();
        let is_degenerate = |triangle: &usize| {
            let [p, q, r] = mesh.corners(*triangle).map(|corner| corner.as_dvec3());
            (q - p).cross(r - p) == DVec3::ZERO
        };
        topology.degenerate_triangles = (0..mesh.indices.len()).into_par_iter().filter(is_degenerate).count();
        visit_edges(vertices.len(), &renumbered(&mesh.indices, &vertices), |sides: &[Side]| {
            topology.open_edges += usize::from(sides.len() == 1);
            topology.shared_edges += usize::from(sides.len() > 2);
            topology.odd_shared_edges += usize::from(sides.len() > 2 && sides.len() % 2 == 1);
            topology.most_of_an_edge = topology.most_of_an_edge.max(sides.len());
            let forward = sides.iter().filter(|side| side.is_forward()).count();
            let is_even = sides.len() > 2 && sides.len().is_multiple_of(2);
            topology.unbalanced_edges += usize::from(is_even && 2 * forward != sides.len());
            topology.reversed_edges += usize::from(sides.len() == 2 && sides[0].from == sides[1].from);
        });
        topology
    }

    /// Whether every line crosses the surface an even number of times.
    pub fn is_closed(&self) -> bool {
        self.open_edges == 0 && self.odd_shared_edges == 0
    }
}

/// Volume of a closed mesh of consistent orientation, in the cube of its unit of length.
pub fn volume(mesh: &TriangleMesh) -> f64 {
    let corners = |triangle| mesh.corners(triangle).map(|corner| corner.as_dvec3());
    let sum: f64 = (0..mesh.indices.len()).map(corners).map(|[a, b, c]| a.dot(b.cross(c))).sum();
    (sum / 6.0).abs()
}

#[cfg(test)]
mod tests {
    use glam::{Mat3A, Vec3A};

    use super::*;
    use crate::cuboid::Cuboid;

    /// The unit cube with separate triangles.
    fn cube() -> TriangleMesh {
        let joined = Cuboid::new(Vec3A::splat(0.5), Vec3A::ONE, Mat3A::IDENTITY).triangles();
        let triangles: Vec<_> = (0..joined.indices.len()).map(|triangle| joined.corners(triangle)).collect();
        TriangleMesh::from_triangles(&triangles)
    }

    #[test]
    fn a_cube_of_separate_triangles_is_closed_and_has_volume_one() {
        let topology = Topology::of(&cube());
        let expected = Topology { triangles: 12, merged_vertices: 28, most_of_an_edge: 2, ..Topology::default() };
        assert_eq!(topology, expected);
        assert!(topology.is_closed());
        assert!((volume(&cube()) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_cube_without_a_side_has_four_open_edges() {
        let mut open = cube();
        open.indices.truncate(10);
        assert_eq!(Topology::of(&open).open_edges, 4);
        assert!(!Topology::of(&open).is_closed());
    }

    #[test]
    fn a_reversed_triangle_has_reversed_edges_and_a_duplicate_has_shared_edges() {
        let mut reversed = cube();
        reversed.indices[0].swap(1, 2);
        assert_eq!(Topology::of(&reversed).reversed_edges, 3);
        assert!(Topology::of(&reversed).is_closed());
        let mut duplicate = cube();
        duplicate.indices.push(duplicate.indices[0]);
        let topology = Topology::of(&duplicate);
        assert_eq!((topology.shared_edges, topology.odd_shared_edges, topology.most_of_an_edge), (3, 3, 3));
        assert!(!topology.is_closed());
    }

    #[test]
    fn degenerate_triangles_are_counted_and_open_no_edges() {
        let mut degenerate = cube();
        degenerate.indices.push([0, 0, 1]);
        let topology = Topology::of(&degenerate);
        assert_eq!(topology.degenerate_triangles, 1);
        assert!(topology.is_closed());
    }
}
