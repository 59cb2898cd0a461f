//! Connected parts of a mesh, and which of their triangles run the same way around.

use crate::edges::visit_edges;

/// A triangle of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PartTriangle {
    /// Its number.
    pub triangle: usize,
    /// Whether it runs the other way around than the first of the part, seen from the same side of the surface.
    pub is_reversed: bool,
}

/// The parts of a mesh that are connected across edges of two triangles. Each triangle is in one part.
pub fn parts(vertices: usize, triangles: &[[u32; 3]]) -> Vec<Vec<PartTriangle>> {
    // For each triangle its neighbours across edges of two, and whether those run the other way around.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_are_connected_across_edges_of_two() {
        // Two triangles share an edge in the same direction. The third one touches them in a point only.
        let found = parts(6, &[[0, 1, 2], [0, 1, 3], [3, 4, 5]]);
        let triangle = |triangle, is_reversed| PartTriangle { triangle, is_reversed };
        assert_eq!(found, [vec![triangle(0, false), triangle(1, true)], vec![triangle(2, false)]]);
        // Three at one edge are not connected.
        assert_eq!(parts(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]).len(), 3);
    }
}
