//! Tests of construction and traversal.

use glam::Vec3A;

use crate::bounds::{Bounds, Interval};
use crate::bvh::bvh8::{Bvh8, BvhRay};
use crate::ray::Ray;

const AHEAD: Interval = Interval { start_m: 0.0, end_m: f32::INFINITY };

/// Bounds of a sliver from the centre of a square to its rim.
fn sliver(angle: f32) -> Bounds {
    let (sin, cos) = angle.sin_cos();
    let rim = Vec3A::new(cos, sin, 0.0) / cos.abs().max(sin.abs());
    Bounds { low: rim.min(Vec3A::ZERO), high: rim.max(Vec3A::ZERO) }
}

/// The primitives of all leaves that a line along z through a point hits, which are the same for both traversals.
fn candidates(bvh: &Bvh8, point: Vec3A) -> Vec<usize> {
    let (mut found, mut found_ordered) = (Vec::new(), Vec::new());
    let ray = BvhRay::new(&Ray { origin: point - Vec3A::Z, direction: Vec3A::Z }, AHEAD);
    bvh.traverse(&ray, |leaf| {
        found.extend(bvh.primitives(leaf));
        false
    });
    bvh.traverse_ordered(&ray, |leaf| {
        found_ordered.extend(bvh.primitives(leaf));
        f32::INFINITY
    });
    found.sort_unstable();
    found_ordered.sort_unstable();
    assert_eq!(found, found_ordered);
    found
}

#[test]
fn ordered_traversal_visits_leaves_by_distance_and_ends_at_the_returned_distance() {
    let beads: Vec<Bounds> = (0..200u8)
        .map(|k| Vec3A::new(f32::from(k) * 3.0, 0.0, 0.0))
        .map(|centre| Bounds { low: centre - 1.0, high: centre + 1.0 })
        .collect();
    let bvh = Bvh8::build(&beads);
    for (direction, sign) in [(Vec3A::X, 1.0), (Vec3A::NEG_X, -1.0)] {
        let ray = Ray { origin: Vec3A::new(298.5, 0.0, 0.0) - 400.0 * direction, direction };
        let (mut previous, mut visited) = (f32::NEG_INFINITY, 0);
        bvh.traverse_ordered(&BvhRay::new(&ray, AHEAD), |leaf| {
            let positions = bvh.primitives(leaf).map(|bead| sign * 3.0 * bead as f32);
            let first = positions.fold(f32::INFINITY, f32::min);
            assert!(first > previous, "{first} after {previous}");
            previous = first;
            visited += bvh.primitives(leaf).count();
            // The distance to the middle of the row.
            400.0
        });
        assert!((100..110).contains(&visited), "{visited}");
    }
}

/// Clustering of these takes half a minute.
#[test]
fn boxes_that_overlap_by_the_hundred_thousand_are_split_at_medians() {
    let same = vec![Bounds { low: Vec3A::ZERO, high: Vec3A::ONE }; 100_000];
    let nested: Vec<Bounds> =
        (1..=100_000u32).map(|k| Bounds { low: Vec3A::ZERO, high: Vec3A::splat(k as f32) }).collect();
    let mut fan: Vec<Bounds> = (0..100_000).map(|k| sliver(std::f32::consts::TAU * k as f32 / 1e5)).collect();
    // A distant box, beside which the slivers are small.
    fan.push(Bounds { low: Vec3A::splat(1e4), high: Vec3A::splat(2e4) });
    for boxes in [same, nested, fan] {
        let bvh = Bvh8::build(&boxes);
        let mut found: Vec<usize> = (0..bvh.leaf_count()).flat_map(|leaf| bvh.primitives(leaf)).collect();
        found.sort_unstable();
        assert!(found.iter().enumerate().all(|(k, &primitive)| k == primitive) && found.len() == boxes.len());
    }
}

#[test]
fn trees_over_slivers_that_share_a_vertex_are_complete() {
    for count in [1, 2, 10, 1900, 10_000_usize] {
        let fan: Vec<Bounds> = (0..count).map(|k| sliver(std::f32::consts::TAU * k as f32 / count as f32)).collect();
        for bvh in [Bvh8::build(&fan), Bvh8::build_balanced(&fan)] {
            let mut found: Vec<usize> = (0..bvh.leaf_count()).flat_map(|leaf| bvh.primitives(leaf)).collect();
            found.sort_unstable();
            assert!(found.iter().enumerate().all(|(k, &primitive)| k == primitive) && found.len() == count);
            for point in [Vec3A::new(0.3, 0.2, 0.0), Vec3A::new(-0.7, 0.1, 0.0)] {
                let candidates = candidates(&bvh, point);
                for (primitive, Bounds { low, high }) in fan.iter().enumerate() {
                    let inside = (low.x..=high.x).contains(&point.x) && (low.y..=high.y).contains(&point.y);
                    assert!(!inside || candidates.contains(&primitive), "{primitive} of {count}");
                }
            }
        }
    }
}
