//! Charts and texels of shapes that are hard to lay flat.

#![expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "texels of a small texture")]

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3, Mat3A, Vec3, Vec3A};
use snowblue_geometry::cuboid::Cuboid;
use snowblue_geometry::ellipsoid::Ellipsoid;
use snowblue_geometry::instance::Instance;
use snowblue_geometry::mesh_bvh::MeshBvh;
use snowblue_geometry::shape::Shape;
use snowblue_geometry::transform::Transform;
use snowblue_geometry::triangle_mesh::TriangleMesh;

use super::charts::Chart;
use super::*;
use crate::bake::MOST_VERTICES;
use crate::bake::subdivision::subdivide;
use crate::bake::surface_mesh::SurfaceMesh;
use crate::bake::tests::longest;
use crate::bake::vertices::Vertices;

/// Lengths shrink by the cosine of the greatest inclination at most.
const LEAST_COS: f64 = 0.642;

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

/// A spiral ramp of three turns: its top lies over itself, and is connected.
fn ramp() -> TriangleMesh {
    grid(90, 5, false, |along, across| {
        let (sin, cos) = (3.0 * TAU * along).sin_cos();
        DVec3::new((1.0 + across) * cos, (1.0 + across) * sin, 0.6 * along)
    })
}

/// Triangles that share an edge by three, twice the same one, and one without area.
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

fn surfaces() -> Vec<(&'static str, SurfaceMesh, usize)> {
    let turn = Mat3A::from_rotation_z(0.4) * Mat3A::from_rotation_x(0.7);
    let block = Shape::Cuboid(Cuboid::new(Vec3A::ONE, Vec3A::new(2.0, 0.5, 1.0), turn));
    let ball = Shape::Ellipsoid(Ellipsoid::new(DAffine3::from_scale(DVec3::new(1.0, 0.6, 0.8))).unwrap());
    let torus = grid(40, 20, true, |along, around| {
        let (sin, cos) = (TAU * around).sin_cos();
        DVec3::new((2.0 + cos) * (TAU * along).cos(), (2.0 + cos) * (TAU * along).sin(), sin)
    });
    // Numbers of charts that were found, and a quarter more.
    vec![
        ("block", SurfaceMesh::of(&block).unwrap(), 6),
        ("ball", SurfaceMesh::of(&ball).unwrap(), 18),
        ("torus", surface(torus), 30),
        ("knot", surface(knot()), 89),
        ("ramp", surface(ramp()), 5),
        ("bad", surface(bad()), 163),
    ]
}

/// Corners of all triangles in texels of a lightmap.
fn laid_out(vertices: &Vertices, charts: &Charts, packing: &Packing) -> Vec<[DVec2; 3]> {
    let mut corners = vec![[DVec2::ZERO; 3]; vertices.triangles.len()];
    for (chart, corner) in charts.list.iter().zip(&packing.corners) {
        let corner = DVec2::from(corner.map(f64::from));
        for &triangle in &chart.triangles {
            let triangle = triangle as usize;
            corners[triangle] =
                charts.corners(vertices.triangles[triangle], packing.texels_per_m).map(|place| corner + place);
        }
    }
    corners
}

/// The places of a fine grid that lie in a triangle by more than rounding.
fn inside([a, b, c]: &[DVec2; 3], fineness: f64) -> Vec<[u64; 2]> {
    let (low, high) = (a.min(*b).min(*c) * fineness, a.max(*b).max(*c) * fineness);
    let range = |low: f64, high: f64| low.floor() as u64..high.ceil() as u64;
    let columns = range(low.x, high.x);
    let places = range(low.y, high.y).flat_map(|row| columns.clone().map(move |column| [column, row]));
    let is_inside = |place: &[u64; 2]| {
        let point = (DVec2::new(place[0] as f64, place[1] as f64) + 0.5) / fineness;
        let is_left = |(from, to): (DVec2, DVec2)| (to - from).perp_dot(point - from) > 1e-6 * from.distance(to);
        [(*a, *b), (*b, *c), (*c, *a)].into_iter().all(is_left)
    };
    places.filter(is_inside).collect()
}

#[test]
fn every_triangle_has_a_part_of_the_texture_of_its_own() {
    for (name, mut mesh, most_charts) in surfaces() {
        let step_m = mesh.longest_edge_m().min(0.2);
        assert!(subdivide(&mut mesh, longest(step_m), MOST_VERTICES));
        let mut vertices = Vertices::of(&mesh);
        let smooth = Vertices { triangles: vertices.triangles.clone(), ..Vertices::of(&mesh) };
        let charts = Charts::of(&mesh, &mut vertices, &|_| ());
        assert!(charts.list.len() <= most_charts, "{name}: {} charts", charts.list.len());
        // The surface is the same: each triangle once, with its places and normals.
        let mut triangles: Vec<u32> = charts.list.iter().flat_map(|chart| chart.triangles.clone()).collect();
        triangles.sort_unstable();
        assert!(triangles.iter().copied().eq(0..u32::try_from(mesh.facets.len()).unwrap()), "{name}");
        for (new, old) in vertices.triangles.iter().flatten().zip(smooth.triangles.iter().flatten()) {
            let (new, old) = (*new as usize, *old as usize);
            assert_eq!(vertices.positions[new], smooth.positions[old], "{name}");
            assert_eq!(vertices.normals[new], smooth.normals[old], "{name}");
        }
        // Areas shrink by the inclination only, and no triangle is turned over.
        let extents: Vec<DVec2> = charts.list.iter().map(|chart| chart.extent_m).collect();
        let packing = pack(&extents, 512).unwrap();
        let corners = laid_out(&vertices, &charts, &packing);
        for ([a, b, c], triangle) in corners.iter().zip(&vertices.triangles) {
            let [p, q, r] = triangle.map(|vertex| vertices.positions[vertex as usize].as_dvec3());
            let area_m2 = (q - p).cross(r - p).length();
            let share = (*b - *a).perp_dot(*c - *a) / packing.texels_per_m.powi(2) / area_m2;
            assert!(area_m2 < 1e-9 || (LEAST_COS..1.0 + 1e-4).contains(&share), "{name}: {share}");
        }
        // On a grid of four places a texel in each direction.
        let fineness = 4.0;
        let mut owner = BTreeMap::new();
        for (number, corners) in corners.iter().enumerate() {
            for place in inside(corners, fineness) {
                let other = owner.insert(place, number);
                assert_eq!(other, None, "{name}: triangles {number} and {other:?} overlap at {place:?}");
            }
        }
        let share = owner.len() as f64 / (512.0 * fineness).powi(2);
        assert!(share > 0.2 && share < 1.0, "{name}: {share}");
    }
}

/// All texels of a chart and of its gutter show it, those that lie in a triangle show that triangle, and no gutter lies
/// in another chart.
#[test]
fn the_gutter_shows_the_edge_of_its_chart() {
    for (name, mut mesh, _) in surfaces() {
        let step_m = mesh.longest_edge_m().min(0.2);
        assert!(subdivide(&mut mesh, longest(step_m), MOST_VERTICES));
        let mut vertices = Vertices::of(&mesh);
        let charts = Charts::of(&mesh, &mut vertices, &|_| ());
        let extents: Vec<DVec2> = charts.list.iter().map(|chart| chart.extent_m).collect();
        let packing = pack(&extents, 256).unwrap();
        let mut is_taken = vec![false; 256 * 256];
        for (chart, [left, top]) in charts.list.iter().zip(&packing.corners) {
            let corners = |triangle: u32| charts.corners(vertices.triangles[triangle as usize], packing.texels_per_m);
            let texels =
                ChartTexels::of(&chart.triangles, with_gutter(chart.extent_m, packing.texels_per_m), corners, &|| ());
            let shown: BTreeMap<_, _> = texels.shown().into_iter().collect();
            for [column, row] in shown.keys() {
                let texel = (top + row) * 256 + left + column;
                assert!(!std::mem::replace(&mut is_taken[texel as usize], true), "{name}");
            }
            for &triangle in &chart.triangles {
                for place in inside(&corners(triangle), 1.0) {
                    assert_eq!(shown.get(&place.map(|k| k as u32)), Some(&triangle), "{name}");
                }
                // Linear interpolation at a corner reads the four texels around it.
                for corner in corners(triangle) {
                    let [column, row] = (corner - 0.5).floor().to_array().map(|k| k as u32);
                    for texel in [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[x, y]| [column + x, row + y]) {
                        assert!(shown.contains_key(&texel), "{name}: {texel:?} at {corner}");
                    }
                }
            }
        }
    }
}

/// Charts without area take 5 × 5 texels each.
#[test]
fn a_lightmap_that_is_too_small_names_one_that_is_not() {
    let enough = |charts: usize, size: u32| {
        let chart = || Chart { triangles: Vec::new(), extent_m: DVec2::ZERO };
        let charts = Charts { list: std::iter::repeat_with(chart).take(charts).collect(), ..Charts::default() };
        let surface =
            FlatSurface { object: 0, charts: &charts, ellipsoid: None, positions: &[], normals: &[], triangles: &[] };
        packed(&[surface], size).map(|_| ()).map_err(|error| error.enough)
    };
    assert_eq!(enough(144, 64), Ok(()));
    assert_eq!(enough(145, 64), Err(Some(128)));
    assert_eq!(enough(600_usize.pow(2) + 1, 3000), Err(Some(4096)), "not a doubling of the size");
    assert_eq!(enough(819_usize.pow(2) + 1, 64), Err(None));
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
