//! Whether a surface of triangles is closed: how often each edge is used, once vertices in the same place are one.
//!
//! A line crosses a surface an even number of times, always, if every edge is used by an even number of triangles: that
//! is what depths rest on. Front and back of a triangle do not matter, so reversed triangles are told but harm nothing.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};

use crate::geometry::triangles::Triangles;

/// What is to be known about a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Topology {
    /// Triangles.
    pub triangles: usize,
    /// Vertices that lie where another one does, as at seams of a texture; they count as that one.
    pub merged_vertices: usize,
    /// Triangles without area; those with two corners in one place are left out of the count of edges.
    pub degenerate_triangles: usize,
    /// Edges of one triangle only.
    pub open_edges: usize,
    /// Edges of more than two triangles.
    pub shared_edges: usize,
    /// Edges of an odd number of triangles, three or more.
    pub odd_shared_edges: usize,
    /// Edges of two triangles that go round it in the same sense: one of both is turned inside out.
    pub reversed_edges: usize,
}

impl Topology {
    /// Counts the edges of a surface.
    pub fn of(surface: &Triangles) -> Self {
        let vertices = merged(&surface.positions);
        let mut topology = Self { triangles: surface.corners.len(), ..Self::default() };
        topology.merged_vertices =
            vertices.iter().enumerate().filter(|&(index, &merged)| index != merged as usize).count();
        let mut edges = Vec::with_capacity(3 * surface.corners.len());
        for (triangle, corners) in surface.corners.iter().enumerate() {
            let [a, b, c] = corners.map(|corner| vertices[corner as usize]);
            let [p, q, r] = surface.places(triangle).map(|place| place.as_dvec3());
            topology.degenerate_triangles += usize::from((q - p).cross(r - p) == DVec3::ZERO);
            if a != b && b != c && c != a {
                edges.extend([(a, b), (b, c), (c, a)].map(|(from, to)| (from.min(to), from.max(to), from < to)));
            }
        }
        edges.sort_unstable();
        for uses in edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
            topology.open_edges += usize::from(uses.len() == 1);
            topology.shared_edges += usize::from(uses.len() > 2);
            topology.odd_shared_edges += usize::from(uses.len() > 2 && uses.len() % 2 == 1);
            topology.reversed_edges += usize::from(uses.len() == 2 && uses[0].2 == uses[1].2);
        }
        topology
    }

    /// Whether every line crosses the surface an even number of times.
    pub fn is_closed(&self) -> bool {
        self.open_edges == 0 && self.odd_shared_edges == 0
    }
}

/// For each vertex the first one in the same place.
#[expect(clippy::cast_possible_truncation, reason = "triangles name vertices by 32 bits")]
pub(crate) fn merged(positions: &[Vec3]) -> Vec<u32> {
    let mut first = BTreeMap::new();
    // Adding zero makes negative zeros positive: both are the same place.
    let key = |place: &Vec3| (*place + 0.0).to_array().map(f32::to_bits);
    positions.iter().enumerate().map(|(index, place)| *first.entry(key(place)).or_insert(index as u32)).collect()
}

/// The volume within a closed surface whose triangles all face outwards, or all inwards, in the cube of its unit.
pub(crate) fn volume(surface: &Triangles) -> f64 {
    let corners = |triangle| surface.places(triangle).map(|place| place.as_dvec3());
    let sum: f64 = (0..surface.corners.len()).map(corners).map(|[a, b, c]| a.dot(b.cross(c))).sum();
    (sum / 6.0).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The unit cube; every side has corners of its own, as a mesh with a texture has.
    fn cube() -> Triangles {
        let corner = |bits: usize| Vec3::from_array([1, 2, 4].map(|bit| if bits & bit == 0 { 0.0 } else { 1.0 }));
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<_> =
            sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|bits| bits.map(corner)).collect();
        Triangles::loose(&triangles)
    }

    #[test]
    fn a_cube_with_seams_is_closed_and_has_its_volume() {
        let topology = Topology::of(&cube());
        assert_eq!(topology, Topology { triangles: 12, merged_vertices: 28, ..Topology::default() });
        assert!(topology.is_closed());
        assert!((volume(&cube()) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_missing_side_opens_four_edges() {
        let mut open = cube();
        open.corners.truncate(10);
        assert_eq!(Topology::of(&open).open_edges, 4);
        assert!(!Topology::of(&open).is_closed());
    }

    #[test]
    fn a_turned_triangle_reverses_its_edges_and_a_doubled_one_shares_them() {
        let mut turned = cube();
        turned.corners[0].swap(1, 2);
        assert_eq!(Topology::of(&turned).reversed_edges, 3);
        assert!(Topology::of(&turned).is_closed());
        let mut doubled = cube();
        doubled.corners.push(doubled.corners[0]);
        let topology = Topology::of(&doubled);
        assert_eq!((topology.shared_edges, topology.odd_shared_edges), (3, 3));
        assert!(!topology.is_closed());
    }

    #[test]
    fn triangles_without_area_are_told_and_open_nothing() {
        let mut degenerate = cube();
        degenerate.corners.push([0, 0, 1]);
        let topology = Topology::of(&degenerate);
        assert_eq!(topology.degenerate_triangles, 1);
        assert!(topology.is_closed());
    }
}
