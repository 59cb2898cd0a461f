//! Charts and texels of shapes that are hard to lay flat, and places that meshes bring along.

#![expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "texels of a small texture")]

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Mat3A, Vec3, Vec3A};
use snowblue_geometry::cuboid::Cuboid;
use snowblue_geometry::ellipsoid::Ellipsoid;
use snowblue_geometry::instance::Instance;
use snowblue_geometry::mesh_bvh::MeshBvh;
use snowblue_geometry::shape::Shape;
use snowblue_geometry::transform::Transform;
use snowblue_geometry::triangle_mesh::{SECOND_UV, TriangleMesh};

use super::*;
use crate::bake::MAX_VERTICES;
use crate::bake::subdivision::subdivide;
use crate::bake::surface_mesh::Vertices;
use crate::bake::tests::longest;

/// Lengths shrink by the cosine of the greatest inclination at most.
const MIN_COS: f64 = 0.642;
const SIZE: u32 = 256;

/// A mesh of rows and columns of places, closed in both directions or open.
fn grid(rows: u32, columns: u32, is_closed: bool, place: impl Fn(f64, f64) -> DVec3) -> TriangleMesh {
    let cells = [rows, columns].map(|count| count - u32::from(!is_closed));
    let share = |number: u32, cells: u32| f64::from(number) / f64::from(cells);
    let places = (0..rows * columns).map(|number| (number / columns, number % columns));
    let positions = places.map(|(row, column)| place(share(row, cells[0]), share(column, cells[1])).as_vec3());
    let at = |row: u32, column: u32| row % rows * columns + column % columns;
    let squares = (0..cells[0] * cells[1]).map(|number| (number / cells[1], number % cells[1]));
    let indices = squares.flat_map(|(row, column)| {
        let [a, b, c, d] = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
        [[a, b, c], [a, c, d]]
    });
    TriangleMesh { positions: positions.collect(), indices: indices.collect(), ..TriangleMesh::default() }
}

/// A trefoil knot of a tube.
fn knot() -> TriangleMesh {
    let line = |along: f64| {
        let angle = TAU * along;
        let radius = 2.0 + (3.0 * angle).cos();
        DVec3::new(radius * (2.0 * angle).cos(), radius * (2.0 * angle).sin(), (3.0 * angle).sin())
    };
    grid(160, 12, true, |along, around| {
        let tangent = (line(along + 1e-4) - line(along - 1e-4)).normalize();
        let side = tangent.cross(DVec3::Z).normalize();
        let (sin, cos) = (-TAU * around).sin_cos();
        line(along) + 0.4 * (side * cos + tangent.cross(side) * sin)
    })
}

/// A spiral ramp of three turns: its top lies over itself, and is connected. Some of its triangles are small.
fn ramp() -> TriangleMesh {
    grid(90, 5, false, |along, across| {
        let (sin, cos) = (3.0 * TAU * along * along).sin_cos();
        DVec3::new((1.0 + across) * cos, (1.0 + across) * sin, 0.6 * along)
    })
}

/// Three triangles that share an edge, a triangle given twice, and a triangle without area.
fn bad() -> TriangleMesh {
    let positions = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [2, 0, 0]];
    let positions = positions.map(|place: [i8; 3]| Vec3::from_array(place.map(f32::from)));
    let indices = vec![[0, 1, 2], [1, 0, 3], [0, 1, 4], [0, 1, 2], [0, 1, 5], [0, 5, 2]];
    TriangleMesh { positions: positions.into(), indices, ..TriangleMesh::default() }
}

fn surface(mesh: TriangleMesh) -> SurfaceMesh {
    let transform = Transform::new(&DAffine3::IDENTITY).unwrap();
    SurfaceMesh::of(&Shape::Mesh(Instance::new(Arc::new(MeshBvh::new(mesh)), transform))).unwrap()
}

fn flat<'s>(name: &'s str, mesh: &SurfaceMesh, vertices: &'s Vertices, uv: &'s [[f32; 2]]) -> FlatSurface<'s> {
    let Vertices { positions, normals, triangles, .. } = vertices;
    FlatSurface { object: 0, name, ellipsoid: mesh.ellipsoid, positions, normals, uv, triangles }
}

fn places(vertices: &Vertices) -> Vec<[f32; 2]> {
    vertices.uv.iter().map(Vec2::to_array).collect()
}

/// No texel lies in two triangles, areas shrink by the inclination only, and the texels that linear interpolation reads
/// at a corner show the chart of its triangle.
#[test]
fn every_triangle_has_a_part_of_the_texture_of_its_own() {
    let turn = Mat3A::from_rotation_z(0.4) * Mat3A::from_rotation_x(0.7);
    let block = Shape::Cuboid(Cuboid::new(Vec3A::ONE, Vec3A::new(2.0, 0.5, 1.0), turn));
    let ball = Shape::Ellipsoid(Ellipsoid::new(DAffine3::from_scale(DVec3::new(1.0, 0.6, 0.8))).unwrap());
    let torus = grid(40, 20, true, |along, around| {
        let (sin, cos) = (TAU * around).sin_cos();
        DVec3::new((2.0 + cos) * (TAU * along).cos(), (2.0 + cos) * (TAU * along).sin(), sin)
    });
    // Numbers of charts that were found, and a quarter more.
    let surfaces = [
        ("block", SurfaceMesh::of(&block).unwrap(), 6),
        ("ball", SurfaceMesh::of(&ball).unwrap(), 18),
        ("torus", surface(torus), 30),
        ("knot", surface(knot()), 89),
        ("ramp", surface(ramp()), 5),
        ("bad", surface(bad()), 163),
    ];
    for (name, mut mesh, most_charts) in surfaces {
        let step_m = mesh.longest_edge_m().min(0.2);
        assert!(subdivide(&mut mesh, longest(step_m), MAX_VERTICES));
        let found = charts(&mesh, &|_| ());
        assert!(found.len() <= most_charts, "{name}: {} charts", found.len());
        let mut chart_of = vec![None; mesh.facets.len()];
        for (number, chart) in found.iter().enumerate() {
            for (facet, _) in &chart.facets {
                assert_eq!(chart_of[*facet].replace(number), None, "{name}: a facet is in two charts");
            }
        }
        assert!(chart_of.iter().all(Option::is_some), "{name}: a facet is in no chart");
        let mut meshes = [mesh];
        lay_out(&[name], &mut meshes, SIZE, &|_| ()).unwrap();
        let [mesh] = meshes;
        let vertices = Vertices::of(&mesh);
        let uv = places(&vertices);
        let flat = flat(name, &mesh, &vertices, &uv);
        let shown = shown(std::slice::from_ref(&flat), SIZE).unwrap();
        let shares: Vec<f64> = (0..)
            .zip(&vertices.triangles)
            .filter_map(|(number, triangle)| {
                let [p, q, r] = triangle.map(|vertex| vertices.positions[vertex as usize].as_dvec3());
                let [a, b, c] = flat.corners(number, SIZE);
                let area_m2 = (q - p).cross(r - p).length();
                (area_m2 > 1e-6).then(|| (b - a).perp_dot(c - a) / area_m2)
            })
            .collect();
        let greatest = shares.iter().copied().fold(0.0, f64::max);
        // Places in the texture are rounded to 24 bits.
        assert!(shares.iter().all(|share| *share > 0.98 * MIN_COS * greatest), "{name}");
        let in_charts = shown.iter().filter(|texel| texel.distance < 0.0).count();
        assert!(in_charts * 5 > shown.len(), "{name}: {in_charts} texels show the surface");
        for (triangle, chart) in (0..).zip(&chart_of) {
            for corner in flat.corners(triangle, SIZE) {
                for step in [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE] {
                    let at = (corner - 0.5).floor() + step;
                    let texel = shown[at.y as usize * SIZE as usize + at.x as usize];
                    assert!(texel.distance.is_finite(), "{name}: {at}");
                    assert_eq!(chart_of[texel.triangle as usize], *chart, "{name}: {at}");
                }
            }
        }
    }
}

/// A sheet of two rows of squares with places of its own.
fn sheet(place: impl Fn(u16) -> [f32; 2]) -> SurfaceMesh {
    let mut mesh = grid(3, 3, false, |along, across| DVec3::new(along, across, (along - across).powi(2)));
    // The second row has vertices of its own.
    mesh.positions.extend_from_within(3..9);
    mesh.indices.iter_mut().skip(4).flatten().for_each(|vertex| *vertex += 6);
    for (axis, name) in SECOND_UV.into_iter().enumerate() {
        mesh.attributes.insert(name.to_owned(), (0..15).map(|vertex| place(vertex)[axis]).collect());
    }
    surface(mesh)
}

/// Two islands, turned over.
fn islands(vertex: u16) -> [f32; 2] {
    let (island, vertex) = if vertex < 9 { (0.0, vertex) } else { (1.0, vertex - 9) };
    [0.1 + 0.45 * island + 0.17 * f32::from(vertex / 3), 0.9 - 0.3 * f32::from(vertex % 3)]
}

#[test]
fn places_of_a_mesh_are_kept_bit_by_bit() {
    let mut mesh = sheet(islands);
    assert!(subdivide(&mut mesh, longest(0.1), MAX_VERTICES));
    let before: Vec<[Vec2; 3]> = mesh.facets.iter().map(|facet| facet.uv).collect();
    let mut meshes = [mesh];
    lay_out(&["sheet"], &mut meshes, SIZE, &|_| ()).unwrap();
    let [mesh] = meshes;
    let vertices = Vertices::of(&mesh);
    for (facet, (triangle, before)) in mesh.facets.iter().zip(vertices.triangles.iter().zip(before)) {
        for ((vertex, uv), position) in triangle.iter().zip(before).zip(facet.vertices) {
            assert_eq!(vertices.uv[*vertex as usize], uv);
            assert_eq!(vertices.positions[*vertex as usize], mesh.positions[position as usize]);
        }
    }
    for vertex in (0..6).chain(9..15) {
        assert!(vertices.uv.contains(&Vec2::from(islands(vertex))), "{vertex}");
    }
    // Each texel within an island shows the place of the surface that the mesh gives it.
    let uv = places(&vertices);
    let flat = flat("sheet", &mesh, &vertices, &uv);
    let shown = shown(std::slice::from_ref(&flat), SIZE).unwrap();
    let mut count = 0;
    for (texel, one) in shown.iter().enumerate().filter(|(_, texel)| texel.distance < 0.0) {
        let point = place(&flat, one.triangle, texel, SIZE).point;
        let at = DVec2::new((texel % 256) as f64 + 0.5, (texel / 256) as f64 + 0.5) / 256.0;
        let along = if at.x < 0.5 { (at.x - 0.1) / 0.34 } else { 0.5 + (at.x - 0.55) / 0.34 };
        let expected = DVec2::new(along, (0.9 - at.y) / 0.6);
        assert!(point.truncate().as_dvec2().distance(expected) < 1e-5, "{point} {expected}");
        count += 1;
    }
    // Along half of the rim, a texel more or less.
    let texels = 2.0 * 0.17 * 0.6 * 256.0_f64.powi(2);
    assert!((f64::from(count) - texels).abs() < 2.0 * (0.17 + 0.6) * 256.0, "{count} {texels}");
}

#[test]
fn places_of_meshes_that_cannot_be_used_are_refused() {
    let refused = |mut meshes: Vec<SurfaceMesh>| {
        let names = &["one", "other"][..meshes.len()];
        let laid_out = lay_out(names, &mut meshes, SIZE, &|_| ());
        let vertices: Vec<Vertices> = meshes.iter().map(Vertices::of).collect();
        let uv: Vec<Vec<[f32; 2]>> = vertices.iter().map(places).collect();
        let surfaces = (0..meshes.len()).map(|k| flat(names[k], &meshes[k], &vertices[k], &uv[k]));
        laid_out.and_then(|()| shown(&surfaces.collect::<Vec<_>>(), SIZE).map(|_| ())).unwrap_err()
    };
    let error = refused(vec![sheet(|vertex| islands(if vertex < 9 { vertex } else { vertex - 8 }))]);
    assert!(error.starts_with("the second UV set of object \"one\" overlaps itself at u 0.2"), "{error}");
    assert!(error.ends_with("unwrap all snow again (Blender: Lightmap Pack), or remove the set"), "{error}");
    let error = refused(vec![sheet(islands), sheet(islands)]);
    assert!(error.starts_with("the second UV set of object \"other\" overlaps that of object \"one\" at u"), "{error}");
    assert_eq!(
        refused(vec![surface(ramp()), sheet(islands)]),
        "object \"other\" has a second UV set and object \"one\" has none, but all snow must have one, or no snow"
    );
    assert_eq!(
        refused(vec![sheet(|vertex| [islands(vertex)[0], -0.5])]),
        "the second UV set of object \"one\" reaches u 0.1, v -0.5, but must lie in 0–1"
    );
    assert!(refused(vec![sheet(|_| [0.5; 2])]).contains("has no area"));
}

/// The smallest charts take 5 × 5 texels each.
#[test]
fn a_lightmap_that_is_too_small_names_one_that_is_not() {
    let mut apart = TriangleMesh::default();
    for x in 0..145_u8 {
        let corner = Vec3::X * f32::from(x);
        let triangle = [corner, corner + 0.01 * Vec3::X, corner + 0.01 * Vec3::Y];
        apart.append(&TriangleMesh::from_triangles(&[triangle]), &DAffine3::IDENTITY).unwrap();
    }
    let mut meshes = [surface(apart)];
    let error = lay_out(&["dust"], &mut meshes, 64, &|_| ()).unwrap_err();
    assert_eq!(error, "the surface is cut into 145 parts, too many for a lightmap of 64 × 64 texels; 65 × 65 suffice");
    lay_out(&["dust"], &mut meshes, 65, &|_| ()).unwrap();
    assert!(too_many_charts(819 * 819, 64).ends_with("4095 × 4095 suffice"));
    assert!(too_many_charts(819 * 819 + 1, 64).ends_with("the largest one, 4096 × 4096, does not suffice"));
}

#[test]
fn texels_without_light_get_that_of_the_nearest() {
    let (one, other) = ([1.0; 3], [2.0; 3]);
    let mut texels = vec![None; 16];
    (texels[0], texels[15]) = (Some(one), Some(other));
    let filled = spread(texels, 4);
    assert_eq!([filled[1], filled[4], filled[5]], [one; 3]);
    assert_eq!([filled[14], filled[11], filled[10]], [other; 3]);
    assert_eq!(spread(vec![None; 4], 2), vec![[0.0; 3]; 4]);
}
