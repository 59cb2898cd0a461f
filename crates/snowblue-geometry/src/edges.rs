//! Edges of triangles, the sides of triangles along each edge, and the parts of a mesh that edges connect.
//!
//! [`Grouped`] lists such relations: items in groups by number, after a counting sort.

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

/// Calls `visit` for each edge with its sides. Backward sides come first; further order is by triangle.
///
/// Edges come in the order of their lower vertex, then of their higher vertex. Triangles with coincident corners have
/// no sides.
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

/// A triangle of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PartTriangle {
    /// Its number.
    pub triangle: usize,
    /// Whether its orientation is opposite to the orientation of the first triangle of the part, seen from one side
    /// of the surface.
    pub is_reversed: bool,
}

/// The parts of a mesh that are connected across edges of two triangles. Each triangle is in one part.
pub fn parts(vertices: usize, triangles: &[[u32; 3]]) -> Vec<Vec<PartTriangle>> {
    // For each triangle its neighbours across edges of two triangles, and whether the orientation of each neighbour
    // is opposite.
    let mut neighbours = vec![[None; 3]; triangles.len()];
    let mut link = |from: u32, to: u32, is_reversed: bool| {
        if let Some(place) = neighbours[from as usize].iter_mut().find(|place| place.is_none()) {
            *place = Some((to as usize, is_reversed));
        }
    };
    visit_edges(vertices, triangles, |sides| {
        if let [first, second] = sides {
            let is_reversed = first.from == second.from;
            link(first.triangle, second.triangle, is_reversed);
            link(second.triangle, first.triangle, is_reversed);
        }
    });
    let (mut parts, mut is_seen) = (Vec::new(), vec![false; triangles.len()]);
    for start in 0..triangles.len() {
        if std::mem::replace(&mut is_seen[start], true) {
            continue;
        }
        let (mut part, mut next) = (vec![PartTriangle { triangle: start, is_reversed: false }], 0);
        while let Some(&PartTriangle { triangle, is_reversed }) = part.get(next) {
            next += 1;
            for (neighbour, differs) in neighbours[triangle].into_iter().flatten() {
                if !std::mem::replace(&mut is_seen[neighbour], true) {
                    part.push(PartTriangle { triangle: neighbour, is_reversed: is_reversed != differs });
                }
            }
        }
        parts.push(part);
    }
    parts
}

/// Items in groups.
pub struct Grouped<T> {
    /// Where each group begins, and the end of the last.
    starts: Vec<usize>,
    items: Vec<T>,
}

impl<T: Copy + Default> Grouped<T> {
    /// Sorts items by their group number, which is below `groups`. Items of a group keep their order.
    pub fn new(groups: usize, items: impl Iterator<Item = (u32, T)> + Clone) -> Self {
        let mut starts = vec![0; groups + 1];
        items.clone().for_each(|(group, _)| starts[group as usize + 1] += 1);
        for group in 0..groups {
            starts[group + 1] += starts[group];
        }
        let (mut next, mut sorted) = (starts.clone(), vec![T::default(); starts[groups]]);
        for (group, item) in items {
            sorted[next[group as usize]] = item;
            next[group as usize] += 1;
        }
        Self { starts, items: sorted }
    }

    /// The items of a group.
    pub fn group(&self, group: usize) -> &[T] {
        &self.items[self.starts[group]..self.starts[group + 1]]
    }

    /// Calls `visit` for each group, which it may change.
    pub fn visit_mut(&mut self, mut visit: impl FnMut(&mut [T])) {
        for ends in self.starts.windows(2) {
            visit(&mut self.items[ends[0]..ends[1]]);
        }
    }
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

    #[test]
    fn triangles_are_connected_across_edges_of_two() {
        // The sides of two triangles run along a shared edge in one direction. The third triangle touches them in a
        // point only.
        let found = parts(6, &[[0, 1, 2], [0, 1, 3], [3, 4, 5]]);
        let triangle = |triangle, is_reversed| PartTriangle { triangle, is_reversed };
        assert_eq!(found, [vec![triangle(0, false), triangle(1, true)], vec![triangle(2, false)]]);
        // Three triangles at one edge are not connected.
        assert_eq!(parts(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]).len(), 3);
    }

    #[test]
    fn items_keep_their_order_in_their_groups() {
        let mut grouped = Grouped::new(4, [(2, 'a'), (0, 'b'), (2, 'c'), (3, 'd')].into_iter());
        assert_eq!(
            [0, 1, 2, 3].map(|group| grouped.group(group).to_vec()),
            [vec!['b'], vec![], vec!['a', 'c'], vec!['d']]
        );
        let mut sizes = Vec::new();
        grouped.visit_mut(|group| sizes.push(group.len()));
        assert_eq!(sizes, [1, 0, 2, 1]);
    }
}
