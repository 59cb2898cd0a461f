//! Edges of triangles, and the sides of triangles that lie along each.

use crate::grouped::Grouped;

/// A side of a triangle, in the direction in which the triangle runs around.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Side {
    /// The vertex where it begins.
    pub from: u32,
    /// The vertex where it ends.
    pub to: u32,
    /// The triangle.
    pub triangle: u32,
}

impl Side {
    /// Whether it runs from the lower to the higher vertex.
    pub fn is_forward(self) -> bool {
        self.from < self.to
    }
}

/// Calls `visit` for each edge with its sides, those that run backwards first, then by triangle.
///
/// Edges come in the order of their lower vertex, then of their higher one. Triangles with coincident corners have no
/// sides.
#[expect(clippy::cast_possible_truncation, reason = "a mesh in memory has fewer than 2^32 triangles")]
pub fn visit_edges(vertices: usize, triangles: &[[u32; 3]], mut visit: impl FnMut(&[Side])) {
    let sides = triangles.iter().enumerate().filter(|(_, [a, b, c])| a != b && b != c && c != a);
    let sides = sides.flat_map(|(triangle, &[a, b, c])| {
        [(a, b), (b, c), (c, a)].map(|(from, to)| (from.min(to), Side { from, to, triangle: triangle as u32 }))
    });
    let high = |side: &Side| side.from.max(side.to);
    Grouped::new(vertices, sides).visit_mut(|sides| {
        sides.sort_unstable_by_key(|side| (high(side), side.is_forward(), side.triangle));
        sides.chunk_by(|one, other| high(one) == high(other)).for_each(&mut visit);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_edge_comes_once_with_all_its_sides() {
        let mut edges = Vec::new();
        visit_edges(5, &[[1, 0, 2], [0, 1, 3], [4, 4, 0], [1, 0, 4]], |sides| edges.push(sides.to_vec()));
        let side = |from, to, triangle| Side { from, to, triangle };
        assert_eq!(edges[0], [side(1, 0, 0), side(1, 0, 3), side(0, 1, 1)]);
        assert!(edges[0][2].is_forward() && !edges[0][0].is_forward());
        let ends: Vec<_> = edges.iter().map(|sides| [sides[0].from, sides[0].to]).collect();
        assert_eq!(ends, [[1, 0], [0, 2], [3, 0], [0, 4], [2, 1], [1, 3], [4, 1]]);
        assert_eq!(edges.iter().map(Vec::len).sum::<usize>(), 9);
    }
}
