//! Tests of mesh queries.

use super::*;

/// A unit sphere of 8 · `steps`² triangles, subdivided from an octahedron.
fn sphere(steps: usize) -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    for octant in 0..8 {
        let sign = Vec3::from_array([1, 2, 4].map(|bit| if octant & bit == 0 { 1.0 } else { -1.0 }));
        let point = |i: usize, j: usize| (Vec3::new(i as f32, j as f32, (steps - i - j) as f32) * sign).normalize();
        for i in 0..steps {
            for j in 0..steps - i {
                triangles.push([point(i, j), point(i + 1, j), point(i, j + 1)]);
                if i + j + 1 < steps {
                    triangles.push([point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]);
                }
            }
        }
    }
    triangles
}

/// A cube with `steps²` squares on each side. `at` gives the coordinates of steps 0 to `steps`.
fn cube(steps: usize, at: impl Fn(usize) -> f32) -> Vec<[Vec3; 3]> {
    let mut triangles = Vec::new();
    for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, steps)]) {
        for (i, j) in (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
            let corner = |i: usize, j: usize| {
                let mut corner = Vec3::splat(at(side));
                (corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (at(i), at(j));
                corner
            };
            let (a, b, c, d) = (corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    triangles
}

fn directions(count: usize) -> impl Iterator<Item = Vec3A> {
    (0..count).map(move |k| {
        let z = 1.0 - 2.0 * (k as f32 + 0.5) / count as f32;
        let turn = 2.399_963 * k as f32;
        let radius = (1.0 - z * z).sqrt();
        Vec3A::new(radius * turn.cos(), radius * turn.sin(), z)
    })
}

#[test]
fn lines_through_vertices_and_edges_have_even_crossings() {
    let triangles = sphere(16);
    let mesh = MeshBvh::new(TriangleMesh::from_triangles(&triangles));
    let mut crossings = Vec::new();
    let mut through = 0;
    for (k, direction) in directions(4000).enumerate() {
        // Aim at a vertex or the middle of an edge, from near and far.
        let corners = &triangles[k * 7 % triangles.len()];
        let target: Vec3A = if k % 2 == 0 { corners[0].into() } else { ((corners[0] + corners[1]) * 0.5).into() };
        let origin = target - direction * [0.0, 2.0, 100.0][k % 3];
        crossings.clear();
        mesh.crossings(&Ray::new(origin, direction), f32::NEG_INFINITY, &mut crossings);
        assert_eq!(crossings.len() % 2, 0, "line {k}");
        through += usize::from(!crossings.is_empty());
    }
    assert!(through > 3500, "{through}");
}

/// Rounding errors of distant coordinates exceed the padding of the boxes.
#[test]
fn distant_lines_have_exact_crossings_and_first_hits() {
    for triangles in [cube(1, |step| step as f32), sphere(8)] {
        let mesh = MeshBvh::new(TriangleMesh::from_triangles(&triangles));
        let mut crossings = Vec::new();
        let mut through = 0;
        for (k, direction) in directions(20_000).enumerate() {
            let away_m = [1.0, 30.0, 1e3, 1e4, 1e5][k % 5];
            let aim = Vec3A::new(0.1 + 0.8 * (k as f32 * 0.618).fract(), 0.5, 0.3 + 0.4 * (k as f32 * 0.755).fract());
            let ray = Ray::new(0.5 * aim - direction * away_m, direction);
            crossings.clear();
            mesh.crossings(&ray, f32::NEG_INFINITY, &mut crossings);
            assert_eq!(crossings.len() % 2, 0, "line {k} from {away_m} m");
            let ahead = crossings.iter().map(|crossing| crossing.distance_m).filter(|distance_m| *distance_m > 0.0);
            let nearest_m = ahead.fold(f32::INFINITY, f32::min);
            let hit = mesh.first_hit(&ray, f32::INFINITY);
            assert_eq!(hit.is_some(), nearest_m.is_finite(), "line {k}");
            // Two roundings of the distance.
            let apart_m = hit.map_or(0.0, |hit| (hit.distance_m - nearest_m).abs());
            assert!(apart_m <= 2.0 * f32::EPSILON * away_m, "line {k}: {apart_m}");
            assert_eq!(mesh.occludes(&ray, f32::INFINITY), nearest_m.is_finite(), "line {k}");
            through += usize::from(nearest_m.is_finite());
        }
        assert!(through > 19_000, "{through}");
    }
}

#[test]
fn the_distance_to_the_nearest_point_is_that_to_the_nearest_triangle() {
    for triangles in [cube(3, |step| step as f32), sphere(12)] {
        let mesh = MeshBvh::new(TriangleMesh::from_triangles(&triangles));
        for (k, direction) in directions(2000).enumerate() {
            let point = direction * [0.0, 0.3, 0.999, 1.0, 1.3, 50.0][k % 6];
            let squares = triangles.iter().map(|corners| square_distance_to_triangle(point, &corners.map(Vec3A::from)));
            let expected = squares.fold(f32::INFINITY, f32::min).sqrt();
            let found = mesh.nearest(point).distance_m;
            // Coordinates are rounded.
            let slack = 8.0 * f32::EPSILON * point.length().max(3.0);
            assert!((found - expected).abs() <= slack, "{k}: {found} {expected}");
        }
    }
}

#[test]
fn the_sign_of_zero_directions_has_no_effect() {
    let mesh = MeshBvh::new(TriangleMesh::from_triangles(&sphere(8)));
    for along in [Vec3A::X, Vec3A::Y, Vec3A::Z, Vec3A::NEG_X, Vec3A::NEG_Y, Vec3A::NEG_Z] {
        for signs in 0..8 {
            let signed =
                |axis: usize| if along[axis].abs() < 0.5 && signs & (1 << axis) != 0 { -0.0 } else { along[axis] };
            let direction = Vec3A::new(signed(0), signed(1), signed(2));
            let ray = Ray::new(Vec3A::new(0.11, 0.07, 0.05) - 3.0 * along, direction);
            let mut crossings = Vec::new();
            mesh.crossings(&ray, f32::NEG_INFINITY, &mut crossings);
            assert_eq!(crossings.len(), 2, "{direction:?}");
            assert!(mesh.first_hit(&ray, f32::INFINITY).is_some(), "{direction:?}");
        }
    }
}

#[test]
fn lines_beside_vertices_have_exact_crossings() {
    // A small mesh far from the origin: rounding of coordinates is coarse relative to the triangles.
    let shift = Vec3::new(3.0, -5.0, 2.0);
    let triangles: Vec<_> = sphere(24).into_iter().map(|corners| corners.map(|c| c * 0.01 + shift)).collect();
    let mesh = MeshBvh::new(TriangleMesh::from_triangles(&triangles));
    let mut crossings = Vec::new();
    for (k, mut direction) in directions(30_000).enumerate() {
        if k % 4 == 0 {
            direction = [Vec3A::X, Vec3A::Y, Vec3A::Z, Vec3A::NEG_X][k / 4 % 4];
        }
        let beside = direction.any_orthonormal_vector() * (((k % 41) as f32 - 20.0) * 5e-8);
        let origin = Vec3A::from(triangles[k * 7 % triangles.len()][0]) + beside - direction * (k % 3) as f32;
        crossings.clear();
        mesh.crossings(&Ray::new(origin, direction), f32::NEG_INFINITY, &mut crossings);
        assert_eq!(crossings.len() % 2, 0, "line {k}");
    }
}

#[test]
fn lines_along_box_sides_have_exact_crossings() {
    // Lines parallel to the cube's edges through the corners of its squares.
    let at = |step: usize| 0.7 + step as f32 * 0.1;
    let mesh = MeshBvh::new(TriangleMesh::from_triangles(&cube(16, at)));
    let mut crossings = Vec::new();
    for axis in 0..3 {
        for (i, j) in (1..16).flat_map(|i| (1..16).map(move |j| (i, j))) {
            let mut origin = Vec3A::splat(-2.9);
            (origin[(axis + 1) % 3], origin[(axis + 2) % 3]) = (at(i), at(j));
            crossings.clear();
            let direction = Vec3A::from(Vec3::AXES[axis]);
            mesh.crossings(&Ray::new(origin, direction), f32::NEG_INFINITY, &mut crossings);
            assert_eq!(crossings.len(), 2, "axis {axis}, corner {i}, {j}");
        }
    }
}

#[test]
fn axis_parallel_lines_through_vertices_have_exact_crossings() {
    let mesh = MeshBvh::new(TriangleMesh::from_triangles(&sphere(16)));
    let mut crossings = Vec::new();
    for axis in [Vec3A::X, Vec3A::Y, Vec3A::Z] {
        for k in 0..64 {
            let side = axis.any_orthonormal_vector() * (k as f32 / 64.0);
            crossings.clear();
            mesh.crossings(&Ray::new(side - axis * 3.0, axis), f32::NEG_INFINITY, &mut crossings);
            assert_eq!(crossings.len(), 2, "{axis} {k}");
        }
    }
}

#[test]
fn first_hit_occlusion_and_crossings_agree() {
    let mesh = MeshBvh::new(TriangleMesh::from_triangles(&sphere(12)));
    for direction in directions(500) {
        let ray = Ray::new(direction * -3.0 + Vec3A::new(0.02, 0.3, -0.1), direction);
        let hit = mesh.first_hit(&ray, f32::INFINITY).unwrap();
        let mut crossings = Vec::new();
        mesh.crossings(&ray, f32::NEG_INFINITY, &mut crossings);
        crossings.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
        assert_eq!(crossings.len(), 2);
        assert!((crossings[0].distance_m - hit.distance_m).abs() < 2e-6);
        assert!((hit.point - ray.at(hit.distance_m)).length() < 2e-6);
        assert!(mesh.occludes(&ray, hit.distance_m + 1e-4));
        assert!(!mesh.occludes(&ray, hit.distance_m - 1e-4));
        assert!(mesh.first_hit(&ray, hit.distance_m - 1e-4).is_none());
        // From inside, the far crossing is the first hit.
        let inside = Ray::new(ray.at(3.0), direction);
        let far = mesh.first_hit(&inside, f32::INFINITY).unwrap();
        assert!((far.distance_m + 3.0 - crossings[1].distance_m).abs() < 2e-6);
    }
}

#[test]
fn a_single_triangle_can_be_hit() {
    let mesh = MeshBvh::new(TriangleMesh::from_triangles(&[[Vec3::ZERO, Vec3::X, Vec3::Y]]));
    let ray = Ray::new(Vec3A::new(0.2, 0.2, 1.0), Vec3A::NEG_Z);
    let hit = mesh.first_hit(&ray, f32::INFINITY).unwrap();
    assert!((hit.distance_m - 1.0).abs() < 1e-6 && (hit.normal.z.abs() - 1.0).abs() < 1e-6);
}
