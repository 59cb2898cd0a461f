//! Hierarchies of boxes that can be walked.
//!
//! A walk through a [`CwBvh`] keeps a stack of 32 places, and past that forgets some without a word. The usual way to build
//! pairs the boxes that are nearest to each other, level by level, and makes trees of seven or eight levels of a million
//! triangles; of slivers about one point, whose boxes all overlap, it makes a chain. Those are halved by their middles
//! instead: a slower tree, and never a deep one.

use std::time::Duration;

use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh, bvh2_to_cwbvh::bvh2_to_cwbvh};
use obvhs::{Boundable, BvhBuildParams};

/// Levels up to which a walk stays within its stack.
const MOST_LEVELS: usize = 31;

/// Most things in a leaf.
const LEAF: u32 = 3;

/// A hierarchy over things with boxes, of which there is at least one.
pub(crate) fn hierarchy_over<T: Boundable>(things: &[T]) -> CwBvh {
    let usual = build_cwbvh(things, BvhBuildParams::medium_build(), &mut Duration::default());
    if levels(&usual) <= MOST_LEVELS { usual } else { halved(things) }
}

/// The greatest number of nodes from the root to a leaf.
fn levels(hierarchy: &CwBvh) -> usize {
    let mut deepest = 0;
    let mut waiting = vec![(0, 1)];
    while let Some((index, level)) = waiting.pop() {
        deepest = deepest.max(level);
        let node = &hierarchy.nodes[index];
        let inner = (0..8).filter(|&child| !node.is_child_empty(child) && !node.is_leaf(child));
        waiting.extend(inner.map(|child| (node.child_node_index(child) as usize, level + 1)));
    }
    deepest
}

/// Halves the things by the order of their middles along the longest side of their box, again and again.
#[expect(clippy::cast_possible_truncation, reason = "a mesh has fewer than 2^32 triangles")]
fn halved<T: Boundable>(things: &[T]) -> CwBvh {
    let boxes: Vec<Aabb> = things.iter().map(Boundable::aabb).collect();
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = vec![Bvh2Node::default()];
    let mut waiting = vec![(0, 0..boxes.len())];
    while let Some((node, range)) = waiting.pop() {
        let part = &mut order[range.clone()];
        let around = part.iter().fold(Aabb::empty(), |around, &thing| around.union(&boxes[thing as usize]));
        if part.len() == 1 {
            nodes[node] = Bvh2Node::new(around, 1, range.start as u32);
            continue;
        }
        let axis = around.diagonal().max_position();
        let middle = |thing: &u32| boxes[*thing as usize].center()[axis];
        let half = part.len() / 2;
        part.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
        let children = nodes.len();
        nodes[node] = Bvh2Node::new(around, 0, children as u32);
        nodes.extend([Bvh2Node::default(); 2]);
        let split = range.start + half;
        waiting.extend([(children, range.start..split), (children + 1, split..range.end)]);
    }
    let binary = Bvh2 { nodes, primitive_indices: order, children_are_ordered_after_parents: true, ..Bvh2::default() };
    bvh2_to_cwbvh(&binary, LEAF, true, false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;
    use obvhs::ray::{Ray, RayHit};

    /// The box of a sliver from the middle of a square to its rim.
    struct Sliver(f32);

    impl Boundable for Sliver {
        fn aabb(&self) -> Aabb {
            let (sin, cos) = self.0.sin_cos();
            let rim = Vec3A::new(cos, sin, 0.0) / cos.abs().max(sin.abs());
            Aabb::new(rim.min(Vec3A::ZERO), rim.max(Vec3A::ZERO))
        }
    }

    /// How many boxes a walk along z through a place offers.
    fn offered(hierarchy: &CwBvh, place: Vec3A) -> usize {
        let mut count = 0;
        let ray = Ray::new(place - Vec3A::Z, Vec3A::Z, 0.0, f32::INFINITY);
        hierarchy.ray_traverse(ray, &mut RayHit::none(), |_, _| {
            count += 1;
            f32::INFINITY
        });
        count
    }

    #[test]
    fn slivers_about_a_point_make_no_deep_tree_and_none_is_forgotten() {
        for count in [1, 2, 10, 1900, 10_000_usize] {
            let fan: Vec<Sliver> =
                (0..count).map(|k| Sliver(std::f32::consts::TAU * k as f32 / count as f32)).collect();
            for hierarchy in [hierarchy_over(&fan), halved(&fan)] {
                assert!(levels(&hierarchy) <= MOST_LEVELS);
                let mut found = hierarchy.primitive_indices.clone();
                found.sort_unstable();
                assert!(found.iter().enumerate().all(|(k, &thing)| k == thing as usize) && found.len() == count);
                for place in [Vec3A::new(0.3, 0.2, 0.0), Vec3A::new(-0.7, 0.1, 0.0)] {
                    let inside = |thing: &&Sliver| {
                        let Aabb { min, max } = thing.aabb();
                        (min.x..=max.x).contains(&place.x) && (min.y..=max.y).contains(&place.y)
                    };
                    assert!(offered(&hierarchy, place) >= fan.iter().filter(inside).count());
                }
            }
        }
    }
}
