//! Finer triangles where a mesh needs them: edges are split at their middle until none is too long.

use glam::Vec3;
use rayon::prelude::*;
use snowblue_geometry::triangle_mesh::TriangleMesh;

/// The new vertices of a refined mesh, and values of all vertices.
pub struct Refined<T> {
    /// For each new vertex in order, the two earlier vertices whose middle it is.
    pub ends: Vec<[u32; 2]>,
    /// A value of each vertex, including the new vertices.
    pub values: Vec<T>,
}

/// Splits edges while `is_long` holds for the places of their ends and the values there. The mesh gets at most `most`
/// triangles; none if more are needed.
///
/// The splitting of an edge depends on the places of its ends only. Triangles on both sides of the edge therefore
/// still fit, even where each side has vertices of its own. Texture coordinates and attributes of a middle are the
/// means of the values at the ends. Vertex normals are removed.
pub fn refine<T: Copy + Send + Sync>(
    mesh: &mut TriangleMesh,
    most: usize,
    value: impl Fn(Vec3) -> T + Sync,
    is_long: impl Fn([Vec3; 2], [T; 2]) -> bool + Sync,
) -> Option<Refined<T>> {
    mesh.normals = Default::default();
    let mut refined =
        Refined { ends: Vec::new(), values: mesh.positions.par_iter().map(|at| value(*at)).collect::<Vec<T>>() };
    // Triangles that may have a long edge, and finished triangles.
    let (mut active, mut done) = (std::mem::take(&mut mesh.indices), Vec::new());
    loop {
        let long = long_edges(&active, |ends: [u32; 2]| {
            let ends = ends.map(|end| end as usize);
            let [from, to] = ends.map(|end| mesh.positions[end]);
            let middle = from.midpoint(to);
            // Adjacent floating-point numbers have no number between them.
            middle != from && middle != to && is_long([from, to], ends.map(|end| refined.values[end]))
        });
        if long.is_empty() {
            done.append(&mut active);
            mesh.indices = done;
            return Some(refined);
        }
        let first_new = mesh.positions.len();
        let mut middles = vec![None; 3 * active.len()];
        for same in long.chunk_by(|one, other| one.ends == other.ends) {
            let middle = add_middle(mesh, same[0].ends)?;
            refined.ends.push(same[0].ends);
            same.iter().for_each(|side| middles[side.number] = Some(middle));
        }
        refined.values.par_extend(mesh.positions[first_new..].par_iter().map(|at| value(*at)));
        let mut finer = Vec::with_capacity(2 * active.len());
        for (corners, middles) in active.iter().zip(middles.as_chunks::<3>().0) {
            match middles {
                [None, None, None] => done.push(*corners),
                _ => split(&mesh.positions, *corners, *middles, &mut finer),
            }
            if finer.len() + done.len() > most {
                mesh.indices = done;
                return None;
            }
        }
        active = finer;
    }
}

/// A side of a triangle that is to be split.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct LongSide {
    /// Its end vertices, the lower number first.
    ends: [u32; 2],
    /// Three times the number of the triangle, and the number of its side.
    number: usize,
}

/// The sides that are too long, with the sides of one edge next to each other.
fn long_edges(triangles: &[[u32; 3]], is_long: impl Fn([u32; 2]) -> bool + Sync) -> Vec<LongSide> {
    let sides = triangles.par_iter().enumerate().flat_map_iter(|(triangle, &[a, b, c])| {
        let sides = [[a, b], [b, c], [c, a]].into_iter().enumerate();
        sides
            .map(move |(side, [from, to])| LongSide { ends: [from.min(to), from.max(to)], number: 3 * triangle + side })
    });
    let mut long: Vec<LongSide> = sides.filter(|side| is_long(side.ends)).collect();
    long.par_sort_unstable();
    long
}

/// Adds the middle of an edge; none if the number of vertices has reached its limit.
fn add_middle(mesh: &mut TriangleMesh, ends: [u32; 2]) -> Option<u32> {
    let number = u32::try_from(mesh.positions.len()).ok()?;
    let [from, to] = ends.map(|end| end as usize);
    mesh.positions.push(mesh.positions[from].midpoint(mesh.positions[to]));
    if !mesh.uv.is_empty() {
        mesh.uv.push(mesh.uv[from].midpoint(mesh.uv[to]));
    }
    for values in mesh.attributes.values_mut() {
        values.push(values[from].midpoint(values[to]));
    }
    Some(number)
}

/// Splits a triangle at the middles of its sides. The first side runs from the first corner to the second corner, and
/// so on.
fn split(positions: &[Vec3], corners: [u32; 3], middles: [Option<u32>; 3], finer: &mut Vec<[u32; 3]>) {
    // The corners are rotated so that split sides come first.
    let turn = (0..3).max_by_key(|&turn| [0, 1, 2].map(|side| middles[(side + turn) % 3].is_some())).unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|corner| corners[(corner + turn) % 3]);
    match [0, 1, 2].map(|side| middles[(side + turn) % 3]) {
        [Some(ab), Some(bc), Some(ca)] => finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]),
        [Some(ab), Some(bc), None] => {
            let length = |from: u32, to: u32| positions[from as usize].distance_squared(positions[to as usize]);
            finer.push([ab, b, bc]);
            finer.extend(match length(a, bc) < length(ab, c) {
                true => [[a, ab, bc], [a, bc, c]],
                false => [[a, ab, c], [ab, bc, c]],
            });
        }
        [Some(ab), ..] => finer.extend([[a, ab, c], [ab, b, c]]),
        _ => finer.push([a, b, c]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    use glam::Vec2;
    use snowblue_geometry::topology::{Topology, volume};

    #[test]
    fn a_closed_mesh_stays_closed_and_keeps_its_volume() {
        let positions = vec![Vec3::ZERO, Vec3::new(3.0, 0.1, 0.0), Vec3::Y, Vec3::new(0.2, 0.3, 1.0)];
        let uv = positions.iter().map(|position| position.truncate()).collect();
        let heights = positions.iter().map(|position| position.z).collect();
        let indices = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let attributes = BTreeMap::from([("height".to_owned(), heights)]);
        let coarse = TriangleMesh { positions, indices, uv, attributes, ..TriangleMesh::default() };
        let mut fine = coarse.clone();
        let is_long = |from: Vec3, to: Vec3| from.distance(to) > 0.1 && from.midpoint(to).x < 1.0;
        let lowest = |at: Vec3| at.z;
        let by_ends = |[from, to]: [Vec3; 2], heights: [f32; 2]| {
            let of_places = [from.z, to.z].map(f32::to_bits);
            assert_eq!(heights.map(f32::to_bits), of_places, "values are those of the places");
            is_long(from, to)
        };
        let refined = refine(&mut fine, 100_000, lowest, by_ends).unwrap();
        assert_eq!(refined.values.len(), fine.positions.len());
        for (middle, ends) in fine.positions[coarse.positions.len()..].iter().zip(&refined.ends) {
            let [from, to] = ends.map(|end| fine.positions[end as usize]);
            assert_eq!(*middle, from.midpoint(to));
        }
        let topology = Topology::of(&fine);
        assert!(topology.is_closed() && topology.reversed_edges + topology.merged_vertices == 0, "{topology:?}");
        assert!((volume(&fine) - volume(&coarse)).abs() < 1e-6);
        for &[a, b, c] in &fine.indices {
            let at = |corner: u32| fine.positions[corner as usize];
            assert!(![(a, b), (b, c), (c, a)].into_iter().any(|(from, to)| is_long(at(from), at(to))));
        }
        for (vertex, position) in fine.positions.iter().enumerate() {
            assert!(fine.uv[vertex].abs_diff_eq(Vec2::new(position.x, position.y), 1e-6));
            assert!((fine.attributes["height"][vertex] - position.z).abs() < 1e-6);
        }
        assert!(refine(&mut coarse.clone(), 100, lowest, by_ends).is_none());
    }
}
