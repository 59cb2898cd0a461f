//! Checks that meshes of snow are closed. Integrators that solve for the light inside snow need closed meshes: a line
//! that enters through a hole never leaves, so that inside and outside are undefined.

use snowblue_geometry::coincident::weld;
use snowblue_geometry::repair::{remove_coincident, turn_alike};
use snowblue_geometry::topology::Topology;
use snowblue_geometry::triangle_mesh::TriangleMesh;

/// Greatest number of triangles that share an edge. Each further triangle makes lines through the edge slower to
/// follow.
const MAX_OF_AN_EDGE: usize = 100;

/// Joins vertices of equal position, removes triangles that bound no solid, gives the triangles of each connected part
/// one orientation, and reports the numbers of removed and turned triangles. Refuses a mesh without remaining
/// triangles.
pub(crate) fn solid(mesh: &mut TriangleMesh) -> Result<Option<String>, String> {
    let vertices = weld(&mut mesh.positions, &mesh.indices);
    let all = mesh.indices.len();
    let removed = remove_coincident(mesh);
    let reason = "have coincident corners or coincide with others";
    if removed == all {
        return Err(format!("all {all} triangles {reason}, so that nothing is inside"));
    }
    let turned = turn_alike(&mut mesh.indices, &vertices);
    let mut changes = Vec::new();
    if removed > 0 {
        changes.push(format!("{removed} of {all} triangles {reason}, and are left out"));
    }
    if turned > 0 {
        changes.push(format!("{turned} of {all} triangles face the other way than their neighbours, and are turned"));
    }
    Ok((!changes.is_empty()).then(|| changes.join("; ")))
}

/// Refuses an open mesh, and a mesh with an edge of many triangles.
pub(crate) fn check_closed(mesh: &TriangleMesh) -> Result<(), String> {
    let topology = Topology::of(mesh);
    if topology.most_of_an_edge > MAX_OF_AN_EDGE {
        return Err(format!(
            "an edge belongs to {} triangles, but for this integrator to at most {MAX_OF_AN_EDGE}",
            topology.most_of_an_edge
        ));
    }
    let Topology { open_edges, odd_shared_edges, reversed_edges, unbalanced_edges, .. } = topology;
    if topology.is_closed() {
        return match reversed_edges + unbalanced_edges {
            0 => Ok(()),
            count => Err(format!(
                "at {count} edges its triangles face different sides and cannot be turned alike, so that inside and \
                 outside are undefined; recalculate its normals"
            )),
        };
    }
    let odd = match odd_shared_edges {
        0 => String::new(),
        count => format!(" and {count} edges of an odd number of triangles"),
    };
    Err(format!(
        "it has {open_edges} open edges{odd}, but this integrator needs closed snow; `snowblue repair` \
         closes holes"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, Vec3};
    use std::f64::consts::{PI, TAU};

    /// A tetrahedron, several times.
    fn tetrahedra(count: usize) -> TriangleMesh {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let sides = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|side| side.map(|corner: usize| corners[corner]));
        TriangleMesh::from_triangles(&sides.repeat(count))
    }

    /// A ball of rings of vertices. Each pole is a ring of as many vertices, placed by rounded sines and cosines.
    fn ball(around: u32, rings: u32, radius: f64) -> TriangleMesh {
        let vertex = |ring: u32, place: u32| {
            let (polar, azimuth) =
                (PI * f64::from(ring) / f64::from(rings), TAU * f64::from(place) / f64::from(around));
            (radius * DVec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos())).as_vec3()
        };
        let positions = (0..=rings).flat_map(|ring| (0..around).map(move |place| vertex(ring, place))).collect();
        let square = |ring: u32, place: u32| {
            let [a, b] = [place, (place + 1) % around].map(|place| ring * around + place);
            [[a, a + around, b + around], [a, b + around, b]]
        };
        let indices = (0..rings).flat_map(|ring| (0..around).flat_map(move |place| square(ring, place))).collect();
        TriangleMesh { positions, indices, ..TriangleMesh::default() }
    }

    #[test]
    fn poles_of_many_vertices_close_a_ball_of_any_size() {
        for radius in [1e-6, 1.0, 3e7] {
            let mut mesh = ball(48, 24, radius);
            let pole = &mesh.positions[24 * 48..];
            assert!(pole.iter().any(|vertex| *vertex != pole[0]), "the vertices of a pole differ");
            let note = solid(&mut mesh).unwrap();
            // Two triangles of three at each pole have no area.
            assert!(note.unwrap().starts_with("96 of 2304 triangles"));
            assert_eq!(check_closed(&mesh), Ok(()));
            assert!(mesh.positions[24 * 48..].iter().all(|vertex| *vertex == mesh.positions[24 * 48]));
        }
    }

    #[test]
    fn triangles_are_turned_as_most_of_their_part() {
        let mut mesh = tetrahedra(1);
        let inner = mesh.positions.iter().map(|position| *position * 0.1 + 0.1).collect::<Vec<_>>();
        let cavity = mesh.indices.iter().map(|[a, b, c]| [a + 12, c + 12, b + 12]).collect::<Vec<_>>();
        mesh.positions.extend(inner);
        mesh.indices.extend(cavity);
        let before = mesh.clone();
        assert_eq!(solid(&mut mesh).unwrap(), None);
        mesh.indices[2].swap(1, 2);
        mesh.indices[5].swap(0, 1);
        let note = solid(&mut mesh).unwrap().unwrap();
        assert_eq!(note, "2 of 8 triangles face the other way than their neighbours, and are turned");
        let turns = |mesh: &TriangleMesh| -> Vec<Vec3> {
            let normal = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a);
            (0..mesh.indices.len()).map(|triangle| normal(mesh.corners(triangle))).collect()
        };
        assert_eq!(turns(&mesh), turns(&before));
    }

    #[test]
    fn coincident_triangles_are_left_out_and_edges_of_many_are_refused() {
        let mut twice = tetrahedra(2);
        assert_eq!(
            solid(&mut twice).unwrap().unwrap(),
            "4 of 8 triangles have coincident corners or coincide with others, and are left out"
        );
        assert_eq!(check_closed(&twice), Ok(()));
        let sheet = [[Vec3::ZERO, Vec3::X, Vec3::Y], [Vec3::ZERO, Vec3::Y, Vec3::X]];
        let message = solid(&mut TriangleMesh::from_triangles(&sheet)).unwrap_err();
        assert!(message.starts_with("all 2 triangles"), "{message}");
        assert_eq!(check_closed(&tetrahedra(50)), Ok(()));
        let message = check_closed(&tetrahedra(51)).unwrap_err();
        assert!(message.contains("102 triangles") && message.contains("at most 100"), "{message}");
    }
}
