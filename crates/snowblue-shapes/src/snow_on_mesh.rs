//! Snow on a mesh: on all its faces that look upwards, raised vertically by the depth of the snow.
//!
//! Where such a face borders on one that does not look upwards, as at the side of a boulder, the snow ends in a wedge;
//! where it borders on nothing, as at the edge of a map, in a wall. What lies above a face does not shelter it.

use glam::{DVec2, Vec2, Vec3};
use snowblue_geometry::coincident::merged;
use snowblue_geometry::grouped::Grouped;
use snowblue_geometry::ray::narrow;
use snowblue_geometry::triangle_mesh::TriangleMesh;

use crate::sheet::{Sheet, SheetVertex};

/// The solid of snow on a mesh with z upwards. `depth_m` is the depth at a vertex, by its number and its texture
/// coordinates, and 0 where there is none; the underside lies `gap_m` above the mesh.
///
/// # Errors
///
/// When no face looks upwards or no snow lies anywhere.
pub fn snow_on_mesh(
    ground: &TriangleMesh,
    gap_m: f64,
    depth_m: impl Fn(usize, DVec2) -> f64,
) -> Result<TriangleMesh, String> {
    let first = merged(&ground.positions);
    let triangles = ground.indices.iter().map(|triangle| triangle.map(|corner| first[corner as usize]));
    let looks_up = |[a, b, c]: &[u32; 3]| {
        let [a, b, c] = [a, b, c].map(|at| ground.positions[*at as usize].as_dvec3());
        (b - a).cross(c - a).z > 0.0
    };
    let (upper, others): (Vec<_>, Vec<_>) = triangles.partition(looks_up);
    if upper.is_empty() {
        return Err("has no face that looks upwards".to_owned());
    }
    let mut holds_snow = vec![true; ground.positions.len()];
    others.iter().flatten().for_each(|at| holds_snow[*at as usize] = false);
    let vertex = |(number, position): (usize, &Vec3)| {
        let uv = ground.uv.get(number).copied().unwrap_or(Vec2::ZERO);
        let bottom_m = f64::from(position.z) + gap_m;
        let depth_m = if holds_snow[number] { depth_m(number, uv.as_dvec2()) } else { 0.0 };
        SheetVertex { position: position.with_z(narrow(bottom_m)), top: narrow(bottom_m + depth_m), uv }
    };
    let vertices = ground.positions.iter().enumerate().map(vertex).collect();
    let boundary = boundary(ground.positions.len(), &upper);
    let sheet = Sheet { vertices, boundary, triangles: upper, underside: None };
    let mut solid = sheet.solid();
    if solid.indices.is_empty() {
        return Err("has no snow anywhere".to_owned());
    }
    if ground.uv.is_empty() {
        solid.uv.clear();
    }
    Ok(solid)
}

/// The edges of an odd number of triangles, each in the direction of one of them.
fn boundary(vertices: usize, triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let edges = triangles.iter().flat_map(|&[a, b, c]| {
        // By the lower vertex: the higher one, and the direction.
        [(a, b), (b, c), (c, a)].map(|(from, to)| (from.min(to), (from.min(to), from.max(to), from < to)))
    });
    let mut boundary = Vec::new();
    Grouped::new(vertices, edges).visit_mut(|edges| {
        edges.sort_unstable();
        for uses in edges.chunk_by(|one, other| one.1 == other.1).filter(|uses| uses.len() % 2 == 1) {
            let forward = 2 * uses.iter().filter(|edge| edge.2).count() > uses.len();
            let (low, high, _) = uses[0];
            boundary.push(if forward { [low, high] } else { [high, low] });
        }
    });
    boundary
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowblue_geometry::topology::{Topology, volume};

    fn check(solid: &TriangleMesh, expected_m3: f64) {
        let topology = Topology::of(solid);
        assert!(topology.is_closed() && topology.reversed_edges == 0, "{topology:?}");
        assert!((volume(solid) - expected_m3).abs() < 1e-6, "{} m³", volume(solid));
    }

    #[test]
    fn snow_on_an_open_slope_has_the_volume_of_its_plan_times_its_depth() {
        let corners = [Vec3::ZERO, Vec3::new(3.0, 0.0, 1.0), Vec3::new(3.0, 2.0, 1.5), Vec3::new(0.0, 2.0, 0.5)];
        let slope =
            TriangleMesh::from_triangles(&[[0, 1, 2], [0, 2, 3]].map(|triangle| triangle.map(|at| corners[at])));
        check(&snow_on_mesh(&slope, 0.01, |_, _| 0.25).unwrap(), 3.0 * 2.0 * 0.25);
        let down = TriangleMesh::from_triangles(&[[corners[0], corners[2], corners[1]]]);
        assert_eq!(snow_on_mesh(&down, 0.0, |_, _| 1.0).unwrap_err(), "has no face that looks upwards");
        assert_eq!(snow_on_mesh(&slope, 0.0, |_, _| 0.0).unwrap_err(), "has no snow anywhere");
    }

    #[test]
    fn snow_on_a_closed_body_ends_in_a_wedge_at_its_sides() {
        // An octahedron: four faces look upwards, over a square of area 2, and only their common corner is raised.
        let [top, bottom] = [Vec3::Z, Vec3::NEG_Z];
        let around = [Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::NEG_Y];
        let faces = |at: usize| {
            let (corner, next) = (around[at], around[(at + 1) % 4]);
            [[corner, next, top], [next, corner, bottom]]
        };
        let octahedron = TriangleMesh::from_triangles(&(0..4).flat_map(faces).collect::<Vec<_>>());
        check(&snow_on_mesh(&octahedron, 0.0, |_, _| 0.3).unwrap(), 2.0 * 0.3 / 3.0);
    }
}
