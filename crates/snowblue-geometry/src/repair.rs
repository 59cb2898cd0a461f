//! Mesh repair: closes scanned and decimated meshes that have small defects, so that they are valid as snow.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::body::winding;
use crate::coincident::{keep_used, merged, merged_within, renumbered};
use crate::edges::{PartTriangle, parts, visit_edges};
use crate::mesh_bvh::MeshBvh;
use crate::mesh_files::faces::Faces;
use crate::ray::Ray;
use crate::topology::Topology;
use crate::triangle_mesh::TriangleMesh;

/// A repaired mesh, and the changes.
#[derive(Debug, Clone, PartialEq)]
pub struct RepairedMesh {
    /// The mesh, without texture coordinates, vertex normals and attributes.
    pub mesh: TriangleMesh,
    /// Number of duplicate vertices that were merged.
    pub merged_vertices: usize,
    /// Number of triangles that were dropped because they bound no solid.
    pub dropped_triangles: usize,
    /// Number of triangles that were turned.
    pub turned_triangles: usize,
    /// Number of edges of each hole that was filled.
    pub filled_holes: Vec<usize>,
}

/// Merges vertices that coincide or lie within `merge_distance`, drops triangles that bound no solid
/// ([`remove_coincident`]), turns triangles so that all triangles of a part face outwards, or
/// inwards if the part is a cavity, and fills each hole as a polygon.
///
/// A hole is a loop of boundary edges. Loops that share a vertex, and holes that no fan fills and that have more than
/// 30,000 edges, are left open; [`Topology::of`](crate::topology::Topology::of) counts their edges.
pub fn repair(mesh: &TriangleMesh, merge_distance: f64) -> RepairedMesh {
    let vertices = merged_within(&mesh.positions, &mesh.indices, merge_distance);
    let indices = renumbered(&mesh.indices, &vertices);
    let mut merged = TriangleMesh { positions: mesh.positions.clone(), indices, ..TriangleMesh::default() };
    let dropped_triangles = remove_coincident(&mut merged);
    let TriangleMesh { positions: old_positions, indices: mut triangles, .. } = merged;
    let before = triangles.clone();
    turn_alike(&mut triangles, &vertices);
    let (mut filled_holes, mut filling) = (Vec::new(), Faces::default());
    for hole in holes(old_positions.len(), &triangles) {
        if filling.add(&hole, &old_positions).is_ok() {
            filled_holes.push(hole.len());
        }
    }
    triangles.extend(filling.triangles);
    // The triangles of holes run as the triangles around them. The volume of a part is known once it is closed.
    turn_outwards(&mut triangles, &old_positions);
    let turned_triangles = before.iter().zip(&triangles).filter(|(before, after)| before != after).count();
    let mut filled = TriangleMesh { positions: old_positions, indices: triangles, ..TriangleMesh::default() };
    // A hole around a single triangle is filled by a coincident triangle.
    let dropped_triangles =
        dropped_triangles + if filled_holes.is_empty() { 0 } else { remove_coincident(&mut filled) };
    keep_used(&mut filled.positions, &mut filled.indices);
    RepairedMesh {
        mesh: filled,
        merged_vertices: vertices.iter().enumerate().filter(|&(own, &first)| own != first as usize).count(),
        dropped_triangles,
        turned_triangles,
        filled_holes,
    }
}

/// Turns the minority of the triangles of each connected part, so that all triangles of the part have one orientation.
/// `vertices` are the vertices that represent the vertices of the mesh ([`merged`]). Returns the number of turned
/// triangles.
pub fn turn_alike(triangles: &mut [[u32; 3]], vertices: &[u32]) -> usize {
    let mut count = 0;
    for part in parts(vertices.len(), &renumbered(triangles, vertices)) {
        let reversed = part.iter().filter(|triangle| triangle.is_reversed).count();
        let is_turned = |triangle: &&PartTriangle| triangle.is_reversed == (2 * reversed <= part.len());
        for PartTriangle { triangle, .. } in part.iter().filter(is_turned) {
            triangles[*triangle].swap(1, 2);
            count += 1;
        }
    }
    count
}

/// Turns parts of one orientation each outwards, except for surfaces of cavities: parts that face inwards inside of
/// other parts.
fn turn_outwards(triangles: &mut [[u32; 3]], positions: &[Vec3]) {
    /// Distance of a point behind a triangle, as a fraction of the length of an edge.
    const BEHIND: f32 = 1e-3;
    let middle = positions.iter().map(|position| position.as_dvec3()).sum::<DVec3>() / positions.len().max(1) as f64;
    let volume = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|corner| positions[corner as usize].as_dvec3() - middle);
        a.dot(b.cross(c))
    };
    if triangles.iter().map(volume).sum::<f64>() < 0.0 {
        triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    let parts = parts(positions.len(), triangles);
    let inwards: Vec<_> = parts
        .iter()
        .filter(|part| part.iter().map(|triangle| volume(&triangles[triangle.triangle])).sum::<f64>() < 0.0)
        .collect();
    if inwards.is_empty() {
        return;
    }
    let mesh = TriangleMesh { positions: positions.to_vec(), indices: triangles.to_vec(), ..TriangleMesh::default() };
    let mesh = MeshBvh::new(mesh);
    let mut crossings = Vec::new();
    for part in inwards {
        let is_inside = [0, part.len() / 2, part.len() - 1].iter().all(|number| {
            let [a, b, c] = mesh.triangles().corners(part[*number].triangle);
            let behind = -(b - a).cross(c - a).normalize_or_zero();
            let point = (a + b + c) / 3.0 + behind * (BEHIND * a.distance(b));
            crossings.clear();
            mesh.crossings(&Ray::new(point.into(), behind.into()), 0.0, &mut crossings);
            winding(&crossings) != 0
        });
        if !is_inside {
            part.iter().for_each(|triangle| triangles[triangle.triangle].swap(1, 2));
        }
    }
}

/// Removes triangles that bound no solid: triangles with coincident corners, and triangles that coincide with other
/// triangles. Returns the number of removed triangles.
///
/// A line through such triangles crosses the surface where the solid neither begins nor ends. Of triangles with equal
/// corners one triangle remains if a majority faces one way, and none if equal numbers face either way. If this rule
/// leaves more open edges than removal of triangles in pairs, whichever way they face, triangles are removed in
/// pairs.
pub fn remove_coincident(mesh: &mut TriangleMesh) -> usize {
    let vertices = merged(&mesh.positions, &mesh.indices);
    // The corners in ascending order, whether the triangle runs in that order, and its number.
    let mut triangles: Vec<([u32; 3], bool, usize)> = (0..mesh.indices.len())
        .into_par_iter()
        .map(|number| {
            let corners = mesh.indices[number].map(|corner| vertices[corner as usize]);
            let mut sorted = corners;
            sorted.sort_unstable();
            let is_even = (0..3).any(|turn| [0, 1, 2].map(|corner| corners[(corner + turn) % 3]) == sorted);
            (sorted, is_even, number)
        })
        .collect();
    triangles.par_sort_unstable();
    // The removed triangles under two rules: removal by pairs, and by the side that most triangles face.
    let mut removed = [vec![false; mesh.indices.len()], vec![false; mesh.indices.len()]];
    let mut coincide = false;
    for group in triangles.chunk_by(|first, second| first.0 == second.0) {
        let [a, b, c] = group[0].0;
        let is_degenerate = a == b || b == c;
        if group.len() == 1 && !is_degenerate {
            continue;
        }
        coincide = true;
        let even = group.iter().filter(|(_, is_even, _)| *is_even).count();
        let is_most = |triangle: &&([u32; 3], bool, usize)| triangle.1 == (2 * even > group.len());
        let most = group.iter().find(is_most).filter(|_| !is_degenerate && 2 * even != group.len());
        let kept = [most.filter(|_| group.len() % 2 == 1), most];
        for (removed, kept) in removed.iter_mut().zip(kept) {
            group.iter().for_each(|triangle| removed[triangle.2] = kept.is_none_or(|kept| kept.2 != triangle.2));
        }
    }
    if !coincide {
        return 0;
    }
    let before = mesh.indices.len();
    let [by_pairs, by_sides] = removed.map(|removed| {
        let kept = mesh.indices.iter().zip(removed).filter(|(_, is_removed)| !is_removed);
        kept.map(|(triangle, _)| *triangle).collect::<Vec<[u32; 3]>>()
    });
    let open_edges = |triangles: &[[u32; 3]]| {
        let positions = mesh.positions.clone();
        let Topology { open_edges, odd_shared_edges, .. } =
            Topology::of(&TriangleMesh { positions, indices: triangles.to_vec(), ..TriangleMesh::default() });
        open_edges + odd_shared_edges
    };
    let open = open_edges(&by_sides);
    mesh.indices = if open > 0 && open_edges(&by_pairs) < open { by_pairs } else { by_sides };
    before - mesh.indices.len()
}

/// The loops of boundary edges, in the orientation of triangles that fill them.
fn holes(vertices: usize, triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    // A filling triangle runs along a boundary edge in the opposite direction of the existing triangle.
    let mut next = BTreeMap::new();
    let mut forks = Vec::new();
    visit_edges(vertices, triangles, |sides| {
        if let [side] = sides
            && next.insert(side.to, side.from).is_some()
        {
            forks.push(side.to);
        }
    });
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cuboid::Cuboid;
    use crate::topology::volume;
    use crate::triangle_mesh::closed_grids;
    use glam::{Mat3A, Vec3A};

    /// A box of 3 × 2 × 0.5, with 3 × 2 squares at its top and at its bottom.
    fn solid() -> TriangleMesh {
        let level = |z: f32| (0..12u8).map(move |k| Vec3::new(f32::from(k % 4) - 1.5, 1.0 - f32::from(k / 4), z));
        let positions = level(0.5).chain(level(0.0)).collect();
        TriangleMesh { positions, indices: closed_grids(4, 3), ..TriangleMesh::default() }
    }

    #[test]
    fn triangles_that_bound_no_solid_are_removed() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let sides = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|side| side.map(|corner: usize| corners[corner]));
        let tetrahedron = TriangleMesh::from_triangles(&sides);
        let [a, b, c] = [Vec3::X, 2.0 * Vec3::X, Vec3::splat(2.0)];
        // Two sheets face each other; a side occurs three times, once turned; a triangle is a line.
        let more = [[a, b, c], [b, a, c], sides[3], [sides[3][1], sides[3][0], sides[3][2]], [a, b, a]];
        let mut mesh = TriangleMesh::from_triangles(&[&sides[..], &more].concat());
        assert!(!Topology::of(&mesh).is_closed() || Topology::of(&mesh).most_of_an_edge > 2);
        assert_eq!(remove_coincident(&mut mesh), 5);
        assert_eq!(mesh.indices.len(), tetrahedron.indices.len());
        let topology = Topology::of(&mesh);
        assert!(topology.is_closed() && topology.most_of_an_edge == 2 && topology.reversed_edges == 0, "{topology:?}");
        assert_eq!(remove_coincident(&mut mesh), 0);
        // A side that occurs twice closes the mesh once.
        let mut doubled = TriangleMesh::from_triangles(&[&sides[..], &sides[3..]].concat());
        assert_eq!(remove_coincident(&mut doubled), 1);
        assert!(Topology::of(&doubled).is_closed());
    }

    /// The unit cube, and a cube of some size around a point, which may be turned inside out.
    fn two_cubes(middle: Vec3, size: f32, is_turned: bool) -> TriangleMesh {
        let mut mesh = Cuboid::new(Vec3A::splat(0.5), Vec3A::ONE, Mat3A::IDENTITY).triangles();
        let count = u32::try_from(mesh.positions.len()).unwrap();
        let second: Vec<Vec3> = mesh.positions.iter().map(|position| middle + (*position - 0.5) * size).collect();
        let turn = |[a, b, c]: [u32; 3]| if is_turned { [a, c, b] } else { [a, b, c] };
        let triangles: Vec<[u32; 3]> =
            mesh.indices.iter().map(|triangle| turn(triangle.map(|corner| corner + count))).collect();
        mesh.positions.extend(second);
        mesh.indices.extend(triangles);
        mesh
    }

    #[test]
    fn cavities_stay_and_other_parts_face_outwards() {
        let volume_of = |mesh: &TriangleMesh| volume(&repair(mesh, 0.0).mesh);
        let inside_out = |mut mesh: TriangleMesh| {
            mesh.indices.iter_mut().for_each(|triangle| triangle.swap(1, 2));
            mesh
        };
        let cavity = two_cubes(Vec3::splat(0.5), 0.5, true);
        assert!((volume_of(&cavity) - 0.875).abs() < 1e-6, "{}", volume_of(&cavity));
        assert!((volume_of(&inside_out(cavity)) - 0.875).abs() < 1e-6);
        let beside = two_cubes(Vec3::splat(5.0), 0.5, true);
        assert!((volume_of(&beside) - 1.125).abs() < 1e-6, "{}", volume_of(&beside));
        assert!((volume_of(&inside_out(beside)) - 1.125).abs() < 1e-6);
    }

    #[test]
    fn a_closed_mesh_is_unchanged() {
        let repaired = repair(&solid(), 0.0);
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
        let repaired = repair(&damaged, 0.0);
        let topology = Topology::of(&repaired.mesh);
        assert!(topology.is_closed() && topology.reversed_edges == 0, "{topology:?}");
        assert_eq!((repaired.dropped_triangles, repaired.filled_holes), (1, vec![3, 4]));
        assert_eq!(repaired.mesh.positions.len(), whole.positions.len());
        assert!((volume(&repaired.mesh) - 3.0).abs() < 1e-6);
    }

    #[test]
    fn vertices_within_the_merge_distance_become_one() {
        // Each triangle has corners of its own, up to 0.01 from the corners of its neighbours.
        let whole = solid();
        let corners = (0..whole.indices.len()).flat_map(|triangle| whole.corners(triangle));
        let moved = corners.enumerate().map(|(k, corner)| corner + Vec3::splat(0.005 * (k as f32).sin()));
        let positions: Vec<Vec3> = moved.collect();
        let triangles: Vec<[Vec3; 3]> = positions.as_chunks().0.to_vec();
        let apart = TriangleMesh::from_triangles(&triangles);
        assert!(!Topology::of(&repair(&apart, 0.001).mesh).is_closed());
        let repaired = repair(&apart, 0.02);
        assert_eq!((repaired.mesh.positions.len(), repaired.dropped_triangles), (whole.positions.len(), 0));
        assert!(Topology::of(&repaired.mesh).is_closed() && repaired.filled_holes.is_empty());
        assert!((volume(&repaired.mesh) - 3.0).abs() < 0.2);
    }

    #[test]
    fn a_concave_hole_is_filled_within_its_edges() {
        let area = |mesh: &TriangleMesh| -> f32 {
            let doubled = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).length();
            (0..mesh.indices.len()).map(|triangle| 0.5 * doubled(mesh.corners(triangle))).sum()
        };
        let whole = solid();
        // Three squares of the top, in the form of an L.
        let is_cut = |middle: Vec3| middle.z > 0.49 && middle.x < 0.5 && !(middle.x > -0.5 && middle.y < 0.0);
        let mut damaged = whole.clone();
        damaged.indices.retain(|triangle| {
            !is_cut(triangle.map(|corner| whole.positions[corner as usize]).into_iter().sum::<Vec3>() / 3.0)
        });
        assert_eq!(damaged.indices.len(), whole.indices.len() - 6);
        let repaired = repair(&damaged, 0.0);
        assert_eq!(repaired.filled_holes, [8]);
        assert!(Topology::of(&repaired.mesh).is_closed());
        assert!((area(&repaired.mesh) - area(&whole)).abs() < 1e-5, "{} {}", area(&repaired.mesh), area(&whole));
    }

    #[test]
    fn holes_that_share_a_vertex_are_left_open() {
        let mut damaged = solid();
        // Two triangles of the top that share one vertex.
        let before = damaged.indices.len();
        damaged.indices.retain(|triangle| ![[0, 5, 1], [1, 6, 2]].contains(triangle));
        assert_eq!(damaged.indices.len(), before - 2);
        let repaired = repair(&damaged, 0.0);
        assert_eq!(Topology::of(&repaired.mesh).open_edges, Topology::of(&damaged).open_edges);
    }
}
