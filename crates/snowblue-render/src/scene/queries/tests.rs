//! Tests: what four samples find side by side is what each finds alone, to the last bit.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Mat3A, Vec3A};
use wide::f32x4;

use super::{Lines, SceneQueries, Surfaces};
use crate::geometry::chord::{ChordEnd, Exit, Line};
use crate::geometry::cuboid::Cuboid;
use crate::geometry::ellipsoid::Ellipsoid;
use crate::geometry::instance::Instance;
use crate::geometry::lanes::{LANES, RayPacket4, SurfacePoints4, Vec3x4, groups, in_lane, lanes};
use crate::geometry::mesh::Mesh;
use crate::geometry::mesh::tests::{directions, sphere};
use crate::geometry::placement::Placement;
use crate::geometry::plane::Plane;
use crate::geometry::ray::{Ray, off_surface};
use crate::geometry::shape::Shape;
use crate::geometry::triangle_mesh::TriangleMesh;
use crate::scene::objects::{Object, Objects, Side, SurfaceInteraction};

/// An upright box, a turned one that touches it, a ball, a mesh and a plane; as many more boxes as are asked for.
fn objects(more: usize, body: Option<&str>) -> Objects {
    let turned = Mat3A::from_rotation_z(0.5) * Mat3A::from_rotation_x(0.3);
    let at = |x: f64| DAffine3::from_translation(DVec3::new(x, 0.2, 0.1)) * DAffine3::from_scale(DVec3::splat(0.4));
    let mesh = Arc::new(Mesh::new(TriangleMesh::from_triangles(&sphere(6))));
    let cube = |centre, axes| Shape::Cuboid(Cuboid::new(centre, Vec3A::new(0.8, 0.6, 0.7), axes));
    let mut shapes = vec![
        cube(Vec3A::ZERO, Mat3A::IDENTITY),
        cube(Vec3A::new(0.5, 0.4, 0.1), turned),
        Shape::Ellipsoid(Ellipsoid::new(at(-1.0)).unwrap()),
        Shape::Mesh(Instance::new(mesh, Placement::new(&at(1.4)).unwrap())),
        Shape::Plane(Plane::new(Vec3A::new(0.0, 0.0, -0.4), Mat3A::IDENTITY)),
    ];
    shapes.extend((0..more).map(|k| cube(Vec3A::new(0.0, 2.0 + k as f32, 0.0), Mat3A::IDENTITY)));
    let object = |(index, shape)| {
        let body = body.filter(|_| index < 2).map(str::to_owned);
        Object { name: String::new(), shape, material: 0, body }
    };
    Objects::new(shapes.into_iter().enumerate().map(object).collect())
}

/// Rays towards the objects, four at a time: neighbours, from all around, along the axes or nearly, from within, and from faces.
fn rays() -> impl Iterator<Item = [Ray; LANES]> {
    let ways: Vec<Vec3A> = directions(4000).collect();
    (0..1000).map(move |k| {
        std::array::from_fn(|lane| {
            let (from, to) = (ways[4 * k], ways[(4 * k + if k % 2 == 0 { 0 } else { lane }) * 7 % 4000]);
            let target = to * Vec3A::new(1.8, 0.5, 0.4) + Vec3A::splat(0.01 * lane as f32);
            let axis = Vec3A::AXES[k / 50 % 3] * -from.signum();
            let beside = [0.0, -0.0, 1e-20, 1e-8][k / 10 % 4];
            let (way, before) = match k % 10 {
                0 => (axis + Vec3A::splat(beside) * axis.any_orthonormal_vector(), 4.0),
                1 => (target - from, 0.0),
                _ => (target - from * 4.0, 4.0),
            };
            let origin = target - way.normalize() * before;
            // On the side of the upright box, to the last bit.
            let origin = if k % 40 == 1 { Vec3A::new(0.4, 0.1 * origin.y, 0.1 * origin.z) } else { origin };
            Ray { origin, direction: way.normalize() }
        })
    })
}

fn side_by_side(rays: &[Ray; LANES]) -> RayPacket4 {
    let [mut origin, mut direction] = [Vec3x4::ZERO; 2];
    for (lane, ray) in rays.iter().enumerate() {
        origin.set(lane, ray.origin);
        direction.set(lane, ray.direction);
    }
    RayPacket4::new(origin, direction)
}

fn same(four: f32x4, lane: usize, one: f32) -> bool {
    four.as_array()[lane].to_bits() == one.to_bits()
}

fn has_same_surface(surfaces: &Surfaces, lane: usize, alone: &SurfaceInteraction) -> bool {
    surfaces.objects.as_array()[lane] == in_lane(alone.object)
        && surfaces.places.point.lane(lane) == alone.point
        && surfaces.places.normal.lane(lane) == alone.normal
        && surfaces.direction.lane(lane) == alone.direction
}

#[test]
fn rays_side_by_side_meet_what_each_meets_alone() {
    for objects in [objects(0, None), objects(4, Some("wall"))] {
        let (mut probe, mut alone) = (SceneQueries::new(&objects), SceneQueries::new(&objects));
        let mut found = 0;
        for (k, four) in rays().enumerate() {
            let which = [0b1111, 0b0111, 0b1010, 0b0001][k % 4];
            let surfaces = probe.camera_hits(&side_by_side(&four), which);
            assert_eq!(surfaces.found & !which, 0);
            for lane in lanes(which) {
                let hit = alone.camera_hit(&four[lane]);
                assert_eq!(hit.is_some(), surfaces.found >> lane & 1 == 1, "ray {k}, {lane}");
                assert!(hit.is_none_or(|hit| has_same_surface(&surfaces, lane, &hit)), "ray {k}, {lane}");
            }
            found += surfaces.found.count_ones();
            for (object, here) in groups(surfaces.found, surfaces.objects) {
                let reach_m = objects.reach_m(object);
                let moved = surfaces.places.off_surface(reach_m);
                for side in [Side::Outer(object), Side::Inner(object), Side::Last(object)] {
                    let limits_m = [0.3, f32::INFINITY, 1.0, 0.02];
                    let beyond = RayPacket4::new(moved, surfaces.places.normal);
                    let free = probe.free((&beyond, f32x4::new(limits_m)), side, here);
                    for lane in lanes(here) {
                        let SurfacePoints4 { point, normal } = surfaces.places;
                        let origin = off_surface(point.lane(lane), normal.lane(lane), reach_m);
                        assert_eq!(moved.lane(lane), origin);
                        let ray = Ray { origin, direction: normal.lane(lane) };
                        let hidden = objects.occluded(&ray, limits_m[lane], side);
                        assert_eq!(hidden, free >> lane & 1 == 0, "ray {k}, {lane}, {side:?}");
                    }
                }
            }
        }
        assert!(found > 2000, "{found}");
    }
}

#[test]
fn lines_side_by_side_are_as_deep_as_each_alone() {
    for objects in [objects(0, None), objects(0, Some("wall"))] {
        let (mut probe, mut alone) = (SceneQueries::new(&objects), SceneQueries::new(&objects));
        let (mut found, mut inside) = (0, 0);
        for (k, four) in rays().enumerate() {
            let surfaces = probe.camera_hits(&side_by_side(&four), 0b1111);
            for (object, here) in groups(surfaces.found, surfaces.objects) {
                let direction = if k % 3 == 0 { -surfaces.places.normal } else { surfaces.direction };
                let end_m = [0.2, 0.5, f32::INFINITY][k % 3];
                let lines = Lines { from: surfaces.places, direction, end_m: f32x4::splat(end_m) };
                let exit = [Exit::Last, Exit::First][k % 2];
                let chords = probe.chords(object, &lines, exit, here);
                for lane in lanes(here) {
                    let SurfacePoints4 { point, normal } = surfaces.places;
                    let [point, normal, direction] = [point, normal, direction].map(|four| four.lane(lane));
                    let chord = alone.chord(object, &Line { point, normal, direction, end_m }, exit);
                    assert_eq!(chord.is_some(), chords.found >> lane & 1 == 1, "line {k}, {lane}");
                    let Some(chord) = chord else {
                        assert!(same(chords.depth_cm(), lane, 0.0));
                        continue;
                    };
                    assert!(same(chords.depth_m, lane, chord.depth_m), "line {k}, {lane}");
                    assert_eq!(matches!(chord.exit, ChordEnd::Inside), chords.inside >> lane & 1 == 1);
                    if let ChordEnd::Surface { object, point, normal } = chord.exit {
                        assert_eq!(chords.objects.as_array()[lane], in_lane(object));
                        assert_eq!((chords.exits.point.lane(lane), chords.exits.normal.lane(lane)), (point, normal));
                    }
                }
                found += chords.found.count_ones();
                inside += chords.inside.count_ones();
            }
        }
        assert!(found > 1500 && inside > 700, "{found} {inside}");
        assert_eq!(probe.statistics.depth_lines, alone.statistics.depth_lines);
    }
}
