//! Finer triangles where a mesh needs them: edges are split at their middle until none is too long.

use std::collections::BTreeMap;

use glam::Vec3;
use snowblue_geometry::triangle_mesh::TriangleMesh;

/// Splits edges while `is_long` says so of their ends, with at most `most` triangles; false if more are needed.
///
/// What is done to an edge depends on its ends only, so that triangles of both its sides still fit. Texture coordinates
/// and attributes of a middle are the means of those of the ends.
pub(crate) fn refine(mesh: &mut TriangleMesh, most: usize, is_long: impl Fn(Vec3, Vec3) -> bool) -> bool {
    // Edges that were found to be short, which stay so.
    let mut middles: BTreeMap<[u32; 2], Option<u32>> = BTreeMap::new();
    loop {
        let mut is_done = true;
        for triangle in 0..mesh.indices.len() {
            let [a, b, c] = mesh.indices[triangle];
            for edge in [[a, b], [b, c], [c, a]] {
                let [low, high] = [edge[0].min(edge[1]), edge[0].max(edge[1])];
                middles.entry([low, high]).or_insert_with(|| {
                    let [from, to] = [low, high].map(|end| mesh.positions[end as usize]);
                    let middle = is_long(from, to).then(|| add_middle(mesh, low, high));
                    is_done &= middle.is_none();
                    middle
                });
            }
        }
        if is_done {
            return true;
        }
        let middle = |from: u32, to: u32| middles[&[from.min(to), from.max(to)]];
        let mut finer = Vec::with_capacity(mesh.indices.len());
        for &[a, b, c] in &mesh.indices {
            split(&mesh.positions, [a, b, c], [middle(a, b), middle(b, c), middle(c, a)], &mut finer);
            if finer.len() > most {
                return false;
            }
        }
        mesh.indices = finer;
    }
}

#[expect(clippy::cast_possible_truncation, reason = "there are fewer vertices than three for each of few triangles")]
fn add_middle(mesh: &mut TriangleMesh, from: u32, to: u32) -> u32 {
    let [from, to] = [from as usize, to as usize];
    mesh.positions.push(mesh.positions[from].midpoint(mesh.positions[to]));
    if !mesh.uv.is_empty() {
        mesh.uv.push(mesh.uv[from].midpoint(mesh.uv[to]));
    }
    for values in mesh.attributes.values_mut() {
        values.push(values[from].midpoint(values[to]));
    }
    mesh.positions.len() as u32 - 1
}

/// Splits a triangle at the middles of its sides from the first corner to the second and so on.
fn split(positions: &[Vec3], corners: [u32; 3], middles: [Option<u32>; 3], finer: &mut Vec<[u32; 3]>) {
    // Turned so that the sides that are split come first.
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
        assert!(refine(&mut fine, 100_000, is_long));
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
        assert!(!refine(&mut coarse.clone(), 100, is_long));
    }
}
