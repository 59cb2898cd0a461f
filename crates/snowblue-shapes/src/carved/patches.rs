//! Patches of a surface in a cell of a lattice, according to the cell's corners that are inside.
//!
//! An edge between a corner inside and a corner outside is crossed. Each face of the cell links its crossed edges in
//! pairs, and the linked edges around a cell make rings. Each ring bounds one patch of the surface, as in marching
//! cubes (Lorensen & Cline 1987, doi:10.1145/37401.37422). On a face with four crossed edges each corner inside is
//! cut off by itself. The choice depends on the face alone, so the patches of neighbours fit.
//!
//! A patch becomes a vertex, and a crossed edge becomes a face between the patches of the four cells around it (Nielson
//! 2004, *Dual marching cubes*, doi:10.1109/VISUAL.2004.28). That surface is a manifold unless two patches on either
//! side of a face touch along both links of the face. There the face cuts off the corners outside instead, which splits
//! both patches (Wenger 2013, *Isosurfaces: Geometry, Topology, and Algorithms*, ISBN 978-1-4665-7097-9).

/// Number of corners of a cell. Bit k of a corner's number is its place on axis k.
pub(super) const CORNERS: usize = 8;

/// A face of a cell: the axis that it faces, and whether it is the upper face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Face {
    pub(super) axis: usize,
    pub(super) is_upper: bool,
}

/// The patches in a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct CellPatches {
    /// The patch of each crossed edge. Entries of edges that are not crossed have no meaning.
    pub(super) edge_patches: [u8; 12],
    /// Number of patches.
    pub(super) count: u8,
}

/// The two axes after an axis, in the order of a right-handed system.
pub(super) fn other_axes(axis: usize) -> [usize; 2] {
    [(axis + 1) % 3, (axis + 2) % 3]
}

/// Number of the edge along an axis through a corner.
pub(super) fn edge(axis: usize, corner: usize) -> usize {
    let [u, v] = other_axes(axis);
    4 * axis + (corner >> u & 1) + 2 * (corner >> v & 1)
}

/// The lower and the upper corner of an edge.
pub(super) fn ends(edge: usize) -> [usize; 2] {
    let (axis, place) = (edge / 4, edge % 4);
    let [u, v] = other_axes(axis);
    let low = (place & 1) << u | (place >> 1) << v;
    [low, low | 1 << axis]
}

/// Whether an edge is crossed. Bit k of `inside` says whether corner k is inside.
pub(super) fn is_crossed(inside: u8, edge: usize) -> bool {
    let [low, high] = ends(edge);
    (inside >> low ^ inside >> high) & 1 == 1
}

impl Face {
    const ALL: [Self; 6] = [
        Self { axis: 0, is_upper: false },
        Self { axis: 0, is_upper: true },
        Self { axis: 1, is_upper: false },
        Self { axis: 1, is_upper: true },
        Self { axis: 2, is_upper: false },
        Self { axis: 2, is_upper: true },
    ];

    /// Its corners in turn.
    fn corners(self) -> [usize; 4] {
        let [u, v] = other_axes(self.axis).map(|axis| 1 << axis);
        [0, u, u | v, v].map(|corner| corner | usize::from(self.is_upper) << self.axis)
    }

    /// Its edges in turn. Each edge follows the corner with the same index.
    fn edges(self) -> [usize; 4] {
        let [u, v] = other_axes(self.axis);
        let corners = self.corners();
        [edge(u, corners[0]), edge(v, corners[1]), edge(u, corners[3]), edge(v, corners[0])]
    }

    /// Whether its four edges are crossed.
    fn is_ambiguous(self, inside: u8) -> bool {
        self.edges().iter().all(|edge| is_crossed(inside, *edge))
    }

    /// The pairs of crossed edges that the face links. `is_other` selects the other pairs of an ambiguous face.
    fn links(self, inside: u8, is_other: bool) -> impl Iterator<Item = [usize; 2]> {
        let edges = self.edges();
        let pairs = if self.is_ambiguous(inside) {
            let is_first_inside = inside >> self.corners()[0] & 1 == 1;
            // A corner is cut off between the edge before it and the edge after it.
            let first = if is_first_inside == is_other { 0 } else { 3 };
            [0, 2].map(|step| Some([edges[(first + step) % 4], edges[(first + step + 1) % 4]]))
        } else {
            let mut crossed = edges.into_iter().filter(|edge| is_crossed(inside, *edge));
            [crossed.next().zip(crossed.next()).map(|(one, other)| [one, other]), None]
        };
        pairs.into_iter().flatten()
    }
}

impl CellPatches {
    /// The patches for corners that are inside according to the bits of `inside`. `other` is a face that links its
    /// edges the other way.
    pub(super) fn new(inside: u8, other: Option<Face>) -> Self {
        let mut rings: [u8; 12] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
        for face in Face::ALL {
            for [edge, other_edge] in face.links(inside, other == Some(face)) {
                let (joined, into) = (rings[edge], rings[other_edge]);
                rings.iter_mut().filter(|ring| **ring == joined).for_each(|ring| *ring = into);
            }
        }
        let mut patches = Self { edge_patches: [0; 12], count: 0 };
        let mut known = [None; 12];
        for edge in (0..12).filter(|edge| is_crossed(inside, *edge)) {
            let patch = known[usize::from(rings[edge])].get_or_insert(patches.count);
            patches.edge_patches[edge] = *patch;
            patches.count = patches.count.max(*patch + 1);
        }
        patches
    }

    /// An ambiguous face whose two links belong to one patch, if there is such a face.
    pub(super) fn pinched_face(inside: u8) -> Option<Face> {
        let mut ambiguous = Face::ALL.into_iter().filter(|face| face.is_ambiguous(inside)).peekable();
        ambiguous.peek()?;
        let patches = Self::new(inside, None);
        ambiguous.find(|face| {
            let [first, rest @ ..] = face.edges().map(|edge| patches.edge_patches[edge]);
            rest.iter().all(|patch| *patch == first)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_inside(inside: u8, corner: usize) -> bool {
        inside >> corner & 1 == 1
    }

    #[test]
    fn edges_and_corners_belong_together() {
        for number in 0..12 {
            let [low, high] = ends(number);
            assert_eq!(
                (edge(number / 4, low), edge(number / 4, high), high - low),
                (number, number, 1 << (number / 4))
            );
        }
        for face in Face::ALL {
            let (corners, edges) = (face.corners(), face.edges());
            for place in 0..4 {
                let mut expected = [corners[place], corners[(place + 1) % 4]];
                expected.sort_unstable();
                assert_eq!(ends(edges[place]), expected);
            }
        }
    }

    #[test]
    fn every_crossed_edge_has_two_links() {
        for inside in 0..=255 {
            for other in Face::ALL.map(Some).into_iter().chain([None]) {
                let mut links = [0; 12];
                for face in Face::ALL {
                    face.links(inside, other == Some(face)).flatten().for_each(|edge| links[edge] += 1);
                }
                for (edge, count) in links.into_iter().enumerate() {
                    assert_eq!(count, if is_crossed(inside, edge) { 2 } else { 0 }, "{inside:08b}");
                }
            }
        }
    }

    #[test]
    fn patches_have_known_numbers() {
        let count = |inside| CellPatches::new(inside, None).count;
        assert_eq!([0, 255, 0b1, 0b1111, 0b1001, 0b1001_0110, 0b0110_1001].map(count), [0, 0, 1, 1, 2, 4, 4]);
        // Two corners outside on a diagonal of a face: the four edges of the face are one patch.
        assert_eq!(count(!0b1001), 1);
        let base = Face { axis: 2, is_upper: false };
        assert_eq!(CellPatches::pinched_face(!0b1001), Some(base));
        assert_eq!(CellPatches::new(!0b1001, Some(base)).count, 2);
    }

    #[test]
    fn a_pinched_face_is_the_only_ambiguous_one_and_the_other_links_split_its_patch() {
        let mut pinched = 0;
        for inside in 0..=255 {
            let Some(face) = CellPatches::pinched_face(inside) else { continue };
            pinched += 1;
            assert_eq!(Face::ALL.iter().filter(|face| face.is_ambiguous(inside)).count(), 1, "{inside:08b}");
            let [first, second, third, last] =
                face.edges().map(|edge| CellPatches::new(inside, Some(face)).edge_patches[edge]);
            assert!(first != third && second != last && (first == second) != (first == last), "{inside:08b}");
        }
        assert!(pinched > 0);
    }

    #[test]
    fn corners_inside_that_are_joined_by_an_edge_are_not_cut_apart() {
        for inside in 0..=255u8 {
            let patches = CellPatches::new(inside, None);
            for face in Face::ALL {
                for [edge, other_edge] in face.links(inside, false) {
                    assert_eq!(patches.edge_patches[edge], patches.edge_patches[other_edge]);
                    // A link of an ambiguous face cuts off a corner inside.
                    if face.is_ambiguous(inside) {
                        let shared: Vec<_> =
                            ends(edge).into_iter().filter(|corner| ends(other_edge).contains(corner)).collect();
                        assert!(shared.len() == 1 && is_inside(inside, shared[0]), "{inside:08b}");
                    }
                }
            }
        }
    }
}
