//! Closed and divided surfaces.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Mat3A, Vec3A};
use snowblue_geometry::cuboid::Cuboid;
use snowblue_geometry::ellipsoid::Ellipsoid;
use snowblue_geometry::instance::Instance;
use snowblue_geometry::mesh_bvh::MeshBvh;
use snowblue_geometry::shape::Shape;
use snowblue_geometry::topology::Topology;
use snowblue_geometry::transform::Transform;
use snowblue_geometry::triangle_mesh::TriangleMesh;

use super::*;

/// Equal greatest lengths for all edges.
pub(super) fn longest(edge_m: f32) -> Longest {
    Longest { edge_m, away_m: edge_m }
}

fn closed(mesh: &SurfaceMesh) -> TriangleMesh {
    let indices = mesh.facets.iter().map(|facet| facet.vertices).collect();
    let mesh = TriangleMesh { positions: mesh.positions.clone(), indices, ..TriangleMesh::default() };
    let topology = Topology::of(&mesh);
    assert!(topology.is_closed() && topology.shared_edges == 0 && topology.reversed_edges == 0, "{topology:?}");
    assert_eq!((topology.merged_vertices, topology.degenerate_triangles), (0, 0));
    mesh
}

/// Volume by Gauss's theorem, positive if the triangles face outwards.
fn volume_m3(mesh: &TriangleMesh) -> f64 {
    let corners = (0..mesh.indices.len()).map(|triangle| mesh.corners(triangle).map(|corner| corner.as_dvec3()));
    corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

fn longest_edge_m(mesh: &TriangleMesh) -> f32 {
    let corners = (0..mesh.indices.len()).map(|triangle| mesh.corners(triangle));
    corners.flat_map(|[a, b, c]| [a.distance(b), b.distance(c), c.distance(a)]).fold(0.0, f32::max)
}

/// No vertex lies within an edge of another triangle, for steps that divide sides unevenly.
#[test]
fn divided_surfaces_stay_closed() {
    let turn = Mat3A::from_rotation_z(0.4);
    let block = Shape::Cuboid(Cuboid::new(Vec3A::new(3.0, 1.0, 0.2), Vec3A::new(0.6, 0.15, 0.37), turn));
    let stretched = DAffine3::from_scale_rotation_translation(
        DVec3::new(0.3, -0.1, 0.2),
        DQuat::from_rotation_x(0.7),
        DVec3::new(1.0, 2.0, 3.0),
    );
    let ball = Shape::Ellipsoid(Ellipsoid::new(stretched).unwrap());
    let volumes = [0.6 * 0.15 * 0.37, 4.0 / 3.0 * PI * 0.3 * 0.1 * 0.2];
    for (shape, volume) in [block, ball].iter().zip(volumes) {
        let steps = [0.5, 0.11, 0.031, 0.013].into_iter().flat_map(|step_m| [(step_m, 1.0), (step_m, 4.0)]);
        for (step_m, finer) in steps {
            let mut mesh = SurfaceMesh::of(shape).unwrap();
            let edge_m = mesh.longest_edge_m().min(step_m);
            assert!(subdivide(&mut mesh, Longest { edge_m, away_m: edge_m / finer }, MAX_VERTICES));
            let triangles = closed(&mesh);
            assert!(longest_edge_m(&triangles) <= edge_m);
            // The ellipsoid is cut off by the flat triangles.
            let error = volume_m3(&triangles) / volume - 1.0;
            assert!(error.abs() < if mesh.ellipsoid.is_some() { 0.03 } else { 1e-4 }, "{step_m}: {error}");
        }
    }
    let mut mesh = SurfaceMesh::of(&Shape::Cuboid(Cuboid::new(Vec3A::ZERO, Vec3A::ONE, turn))).unwrap();
    assert!(!subdivide(&mut mesh, longest(1e-3), 10_000), "the bound of the vertices holds");
}

/// A mesh with separate triangles, half of them reversed, and a mirroring transform.
#[test]
fn triangles_of_meshes_are_turned_outwards() {
    let round = Shape::Ellipsoid(Ellipsoid::new(DAffine3::from_scale(DVec3::splat(0.4))).unwrap());
    let mut icosphere = SurfaceMesh::of(&round).unwrap();
    assert!(subdivide(&mut icosphere, longest(0.1), MAX_VERTICES));
    let corners = |facet: &surface_mesh::Facet| facet.vertices.map(|vertex| icosphere.positions[vertex as usize]);
    let triangles: Vec<[Vec3; 3]> = icosphere.facets.iter().map(corners).collect();
    let reversed = |(number, [a, b, c]): (usize, &[Vec3; 3])| if number % 2 == 0 { [*a, *c, *b] } else { [*a, *b, *c] };
    let mixed: Vec<[Vec3; 3]> = triangles.iter().enumerate().map(reversed).collect();
    let transform = Transform::new(&DAffine3::from_scale(DVec3::new(-1.0, 1.5, 1.0))).unwrap();
    let mesh = Arc::new(MeshBvh::new(TriangleMesh::from_triangles(&mixed)));
    let mut mesh = SurfaceMesh::of(&Shape::Mesh(Instance::new(mesh, transform))).unwrap();
    assert_eq!(mesh.positions.len(), icosphere.positions.len());
    assert!(subdivide(&mut mesh, longest(0.07), MAX_VERTICES));
    let triangles = closed(&mesh);
    assert!((volume_m3(&triangles) / (4.0 / 3.0 * PI * 0.4_f64.powi(3) * 1.5) - 1.0).abs() < 0.1);
    // The icosahedron's parts are smooth: a normal for each vertex, and it points outwards.
    let vertices = Vertices::of(&mesh);
    assert_eq!(vertices.positions.len(), mesh.positions.len());
    assert!(vertices.positions.iter().zip(&vertices.normals).all(|(position, normal)| position.dot(*normal) > 0.0));
}

/// A box on another box in the same mesh. The upper box covers the middles of both triangles that it stands on, so
/// that lines through these middles do not show where the solid lies.
#[test]
fn faces_that_another_part_covers_are_turned_outwards() {
    let lower = Cuboid::new(Vec3A::ZERO, Vec3A::ONE, Mat3A::IDENTITY).triangles();
    let upper = Cuboid::new(Vec3A::new(0.0, 0.0, 0.7), Vec3A::new(0.6, 0.6, 0.4), Mat3A::IDENTITY).triangles();
    let triangles: Vec<[Vec3; 3]> = [&lower, &upper]
        .into_iter()
        .flat_map(|mesh| (0..mesh.indices.len()).map(|triangle| mesh.corners(triangle)))
        .enumerate()
        .map(|(number, [a, b, c])| if number % 3 == 0 { [a, c, b] } else { [a, b, c] })
        .collect();
    let mesh = Arc::new(MeshBvh::new(TriangleMesh::from_triangles(&triangles)));
    let identity = Transform::new(&DAffine3::IDENTITY).unwrap();
    let mesh = SurfaceMesh::of(&Shape::Mesh(Instance::new(mesh, identity))).unwrap();
    let outward = |facet: &surface_mesh::Facet| {
        let corners = facet.vertices.map(|vertex| mesh.positions[vertex as usize]);
        let middle = corners.iter().sum::<Vec3>() / 3.0;
        let is_upper = corners.iter().all(|corner| corner.x.abs() < 0.4);
        let centre = if is_upper { Vec3::new(0.0, 0.0, 0.7) } else { Vec3::ZERO };
        facet.normal.dot(middle - centre) > 0.0
    };
    assert_eq!(mesh.facets.iter().filter(|facet| outward(facet)).count(), 24);
    assert!((volume_m3(&closed(&mesh)) - 1.0 - 0.6 * 0.6 * 0.4).abs() < 1e-6);
}

/// The wall of a hollow faces into it.
#[test]
fn walls_of_a_hollow_face_into_it() {
    let boxed = |size: f32| Cuboid::new(Vec3A::ZERO, Vec3A::splat(size), Mat3A::IDENTITY).triangles();
    let triangles: Vec<[Vec3; 3]> = [boxed(1.0), boxed(0.5)]
        .iter()
        .flat_map(|mesh| (0..mesh.indices.len()).map(|triangle| mesh.corners(triangle)).collect::<Vec<_>>())
        .collect();
    let mesh = Arc::new(MeshBvh::new(TriangleMesh::from_triangles(&triangles)));
    let identity = Transform::new(&DAffine3::IDENTITY).unwrap();
    let mesh = SurfaceMesh::of(&Shape::Mesh(Instance::new(mesh, identity))).unwrap();
    assert!((volume_m3(&closed(&mesh)) - 1.0 + 0.125).abs() < 1e-6);
}

#[test]
fn sharp_edges_have_vertices_on_both_sides() {
    let mut cube = SurfaceMesh::of(&Shape::Cuboid(Cuboid::new(Vec3A::ZERO, Vec3A::ONE, Mat3A::IDENTITY))).unwrap();
    let vertices = Vertices::of(&cube);
    assert_eq!((vertices.positions.len(), vertices.triangles.len()), (24, 12));
    assert!(subdivide(&mut cube, longest(0.3), MAX_VERTICES));
    let vertices = Vertices::of(&cube);
    for (position, (normal, point)) in vertices.positions.iter().zip(vertices.normals.iter().zip(&vertices.points)) {
        assert!((normal.abs().max_element() - 1.0).abs() < 1e-6, "{normal}");
        assert!((position.dot(*normal) - 0.5).abs() < 1e-6 && (point.dot(*normal) - 0.5).abs() < 1e-6);
        assert!(point.abs().to_array().iter().filter(|x| **x > 0.4999).count() == 1, "{point}");
    }
}
