//! The closed solid between a sheet and the same sheet raised at each vertex, as snow on the ground.
//!
//! Where the sheet is not raised there is no solid. A triangle that is raised nowhere is left out. A triangle that
//! is raised at some of its vertices makes a wedge. Every edge then belongs to an even number of triangles.

use glam::{Vec2, Vec3};

use snowblue_geometry::triangle_mesh::TriangleMesh;

/// A vertex of a sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SheetVertex {
    /// Its position.
    pub(crate) position: Vec3,
    /// Height of the raised vertex; the height of the vertex itself where there is no solid.
    pub(crate) top: f32,
    /// Its texture coordinates.
    pub(crate) uv: Vec2,
}

impl SheetVertex {
    /// Whether there is a solid.
    pub(crate) fn is_raised(&self) -> bool {
        self.top > self.position.z
    }
}

/// Triangles, counter-clockwise as seen from above, and the edges that have a triangle on one side only.
#[derive(Debug, Default)]
pub(crate) struct Sheet {
    pub(crate) vertices: Vec<SheetVertex>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Separate triangles for the underside, if any, with the same edges at the boundary. All vertices are then
    /// raised.
    pub(crate) underside: Option<Vec<[u32; 3]>>,
    /// The edges at the boundary, each in the direction of its triangle.
    pub(crate) boundary: Vec<[u32; 2]>,
}

impl Sheet {
    /// The solid between the sheet and its raised vertices, with the texture coordinates of the sheet above and below.
    /// It has no triangle if the sheet is raised nowhere.
    pub(crate) fn solid(&self) -> TriangleMesh {
        let is_raised = |vertex: &u32| self.vertices[*vertex as usize].is_raised();
        let kept = || self.triangles.iter().filter(|triangle| triangle.iter().any(is_raised));
        let under = || {
            let same = self.underside.is_none().then(kept).into_iter().flatten();
            same.chain(self.underside.iter().flatten())
        };
        let mut solid = TriangleMesh::default();
        let mut below = vec![u32::MAX; self.vertices.len()];
        for &at in under().flatten() {
            let (number, vertex) = (&mut below[at as usize], &self.vertices[at as usize]);
            if *number == u32::MAX {
                *number = add(&mut solid, vertex.position, vertex.uv);
            }
        }
        // A vertex that is not raised belongs to both the upper side and the underside.
        let mut above = vec![u32::MAX; self.vertices.len()];
        for &at in kept().flatten() {
            let (number, vertex) = (&mut above[at as usize], &self.vertices[at as usize]);
            if *number == u32::MAX {
                *number = match vertex.is_raised() {
                    true => add(&mut solid, vertex.position.with_z(vertex.top), vertex.uv),
                    false => below[at as usize],
                };
            }
        }
        let (below, above) = (|at: u32| below[at as usize], |at: u32| above[at as usize]);
        solid.indices.extend(kept().map(|triangle| triangle.map(above)));
        solid.indices.extend(under().map(|&[a, b, c]| [a, c, b].map(below)));
        for &[a, b] in &self.boundary {
            if is_raised(&b) {
                solid.indices.push([below(a), below(b), above(b)]);
            }
            if is_raised(&a) {
                solid.indices.push([below(a), above(b), above(a)]);
            }
        }
        solid
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a mesh in memory has fewer than 2^32 vertices")]
fn add(solid: &mut TriangleMesh, position: Vec3, uv: Vec2) -> u32 {
    solid.positions.push(position);
    solid.uv.push(uv);
    solid.positions.len() as u32 - 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_geometry::topology::{Topology, volume};

    /// A square of two triangles, raised by some heights at its corners in order.
    fn square(raised: [f32; 4]) -> Sheet {
        let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        let vertex = |(uv, raised): (Vec2, f32)| SheetVertex { position: uv.extend(2.0), top: 2.0 + raised, uv };
        Sheet {
            vertices: corners.into_iter().zip(raised).map(vertex).collect(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            underside: None,
            boundary: vec![[0, 1], [1, 2], [2, 3], [3, 0]],
        }
    }

    #[test]
    fn solids_are_closed_wherever_there_is_no_snow() {
        for bits in 0..16u8 {
            let raised = [1, 2, 4, 8].map(|bit| if bits & bit == 0 { 0.0 } else { 0.5 });
            let solid = square(raised).solid();
            let topology = Topology::of(&solid);
            assert!(topology.is_closed() && topology.reversed_edges == 0, "{bits}: {topology:?}");
            assert_eq!((topology.merged_vertices, topology.degenerate_triangles), (0, 0), "{bits}");
            // Over each triangle of area 1/2, the mean of the heights at its corners.
            let expected = (raised[0] + raised[1] + raised[2] + raised[0] + raised[2] + raised[3]) / 6.0;
            assert!((volume(&solid) - f64::from(expected)).abs() < 1e-6, "{bits}");
        }
        assert!(square([0.0; 4]).solid().indices.is_empty());
    }

    #[test]
    fn the_underside_may_have_other_triangles() {
        let sheet = Sheet { underside: Some(vec![[0, 1, 3], [1, 2, 3]]), ..square([0.5; 4]) };
        let solid = sheet.solid();
        let topology = Topology::of(&solid);
        assert!(topology.is_closed() && topology.reversed_edges == 0, "{topology:?}");
        assert!((volume(&solid) - 0.5).abs() < 1e-6);
    }
}
