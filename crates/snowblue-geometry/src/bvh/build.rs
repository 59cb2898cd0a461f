//! Construction of an eight-wide hierarchy by collapsing a binary tree.
//!
//! The binary tree comes from parallel locally-ordered clustering with reinsertion, by `obvhs` (Meister & Bittner
//! 2018, "Parallel locally-ordered clustering", doi:10.1109/TVCG.2017.2669983). Where all boxes overlap, like the
//! boxes of slivers that share a vertex, clustering makes a chain, in quadratic time. Where many neighbours overlap,
//! or if the tree gets too deep for the traversal stack, a median split replaces the clustering. Its tree is always
//! balanced, but traversal is slower.

use arrayvec::ArrayVec;
use obvhs::aabb::Aabb;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::ploc::PlocBuilder;
use obvhs::{Boundable, BvhBuildParams};

use crate::bounds::Bounds;
use crate::bvh::{Bvh8, LEAF_FLAG, LEAF_WIDTH, MAX_DEPTH, NO_PRIMITIVE, Node, WIDTH};

/// Greatest number of neighbouring primitives of which clustering may make a chain. Such a chain takes a tenth of a
/// second.
const MAX_IN_CHAIN: usize = 4096;
/// Neighbours overlap if the mean surface area of their boxes is this fraction of the surface area of the box around
/// them. In a smooth surface of [`MAX_IN_CHAIN`] triangles the fraction is a few ten-thousandths.
const OVERLAPPING: f64 = 1.0 / 64.0;

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        Aabb::new(self.low, self.high)
    }
}

impl Bvh8 {
    /// Builds a hierarchy over at least one primitive, given by its bounds.
    pub fn build(primitives: &[Bounds]) -> Self {
        let clusters = if neighbours_overlap(primitives) { None } else { collapse(&cluster(primitives)) };
        clusters.unwrap_or_else(|| Self::build_balanced(primitives))
    }

    /// Builds a hierarchy by median splits.
    pub(super) fn build_balanced(primitives: &[Bounds]) -> Self {
        collapse(&median_split(primitives)).expect("median splits of fewer than 2^31 primitives end after 29 levels")
    }
}

/// Whether boxes overlap with most of their neighbours, in some group of more than [`MAX_IN_CHAIN`] boxes.
#[expect(clippy::cast_possible_truncation, reason = "a mesh has fewer than 2^31 triangles")]
fn neighbours_overlap(primitives: &[Bounds]) -> bool {
    let mut order: Vec<u32> = (0..primitives.len() as u32).collect();
    let mut parts = vec![order.as_mut_slice()];
    while let Some(part) = parts.pop().filter(|part| part.len() > MAX_IN_CHAIN) {
        let area = |&primitive: &u32| f64::from(primitives[primitive as usize].aabb().half_area());
        let mean = part.iter().map(area).sum::<f64>() / part.len() as f64;
        if mean >= OVERLAPPING * f64::from(union(primitives, part).half_area()) {
            return true;
        }
        let half = halve(primitives, part);
        let (left, right) = part.split_at_mut(half);
        parts.extend([left, right].into_iter().filter(|half| half.len() > MAX_IN_CHAIN));
    }
    false
}

/// A binary tree by clustering and reinsertion, with one primitive in each leaf.
///
/// Uses the parameters of obvhs's medium build, but calls its parts: its convenience function panics on deep trees in
/// debug builds and reads the clock, which is not available on every target. It also reinserts twice as many nodes once
/// more, which takes a third of the build and does not make rays measurably faster.
#[expect(clippy::cast_possible_truncation, reason = "a mesh has fewer than 2^31 triangles")]
fn cluster(primitives: &[Bounds]) -> Bvh2 {
    const PARAMETERS: BvhBuildParams = BvhBuildParams::medium_build();
    let mut binary = PlocBuilder::with_capacity(primitives.len()).build(
        PARAMETERS.ploc_search_distance,
        primitives,
        (0..primitives.len() as u32).collect(),
        PARAMETERS.sort_precision,
        PARAMETERS.search_depth_threshold,
    );
    ReinsertionOptimizer::default().run(&mut binary, PARAMETERS.reinsertion_batch_ratio, None);
    binary
}

/// Collapses the levels of a binary tree into nodes of eight children; none if the result is too deep.
fn collapse(binary: &Bvh2) -> Option<Bvh8> {
    let counts = primitive_counts(binary);
    let mut wide = Bvh8 { root: 0, nodes: Vec::new(), leaves: Vec::new() };
    let collapser = Collapser { binary, counts: &counts };
    wide.root = collapser.add(&mut wide, 0, 0)?;
    wide.nodes.shrink_to_fit();
    wide.leaves.shrink_to_fit();
    Some(wide)
}

/// A binary tree with the number of primitives below each node.
struct Collapser<'tree> {
    binary: &'tree Bvh2,
    counts: &'tree [u32],
}

impl Collapser<'_> {
    /// Adds the subtree below a binary node and returns its index; none if it is too deep.
    #[expect(clippy::cast_possible_truncation, reason = "a mesh has fewer than 2^31 triangles")]
    fn add(&self, wide: &mut Bvh8, top: usize, depth: usize) -> Option<u32> {
        let nodes = &self.binary.nodes;
        if self.is_leaf(top) {
            let mut leaf = [NO_PRIMITIVE; LEAF_WIDTH];
            leaf.iter_mut().zip(primitives_below(self.binary, top)).for_each(|(slot, primitive)| *slot = primitive);
            wide.leaves.push(leaf);
            return Some((wide.leaves.len() as u32 - 1) | LEAF_FLAG);
        }
        if depth == MAX_DEPTH {
            return None;
        }
        // Replace the child of greatest surface area by its two children until there are eight.
        let pair = |node: usize| [0, 1].map(|other| nodes[node].first_index as usize + other);
        let mut children = ArrayVec::<usize, WIDTH>::from_iter(pair(top));
        while children.len() < WIDTH {
            let areas =
                children.iter().map(|&node| if self.is_leaf(node) { 0.0 } else { nodes[node].aabb().half_area() });
            let (largest, area) =
                areas.enumerate().fold((0, 0.0), |most, child| if child.1 > most.1 { child } else { most });
            if area <= 0.0 {
                break;
            }
            let [first, second] = pair(children[largest]);
            children[largest] = first;
            children.push(second);
        }
        let index = wide.nodes.len();
        let bounds = |&node: &usize| Bounds { low: nodes[node].aabb().min, high: nodes[node].aabb().max };
        wide.nodes.push(Node::new(children.iter().map(bounds)));
        for (slot, &node) in children.iter().enumerate() {
            wide.nodes[index].children[slot] = self.add(wide, node, depth + 1)?;
        }
        Some(index as u32)
    }

    /// Whether the primitives below a binary node fit into one leaf.
    fn is_leaf(&self, node: usize) -> bool {
        self.counts[node] as usize <= LEAF_WIDTH
    }
}

/// A node and all nodes below it, parents before children.
fn nodes_below(binary: &Bvh2, top: usize) -> impl Iterator<Item = usize> {
    let mut stack = vec![top];
    std::iter::from_fn(move || {
        let index = stack.pop()?;
        let node = &binary.nodes[index];
        if !node.is_leaf() {
            stack.extend([1, 0].map(|other| node.first_index as usize + other));
        }
        Some(index)
    })
}

/// The primitives below a node.
fn primitives_below(binary: &Bvh2, top: usize) -> impl Iterator<Item = u32> {
    nodes_below(binary, top).flat_map(|index| {
        let node = &binary.nodes[index];
        let first = node.first_index as usize;
        let range = if node.is_leaf() { first..first + node.prim_count as usize } else { 0..0 };
        range.map(|position| binary.primitive_indices[position])
    })
}

/// The number of primitives below each node.
fn primitive_counts(binary: &Bvh2) -> Vec<u32> {
    let mut counts = vec![0; binary.nodes.len()];
    let order: Vec<usize> = nodes_below(binary, 0).collect();
    for &index in order.iter().rev() {
        let node = &binary.nodes[index];
        let first = node.first_index as usize;
        counts[index] = if node.is_leaf() { node.prim_count } else { counts[first] + counts[first + 1] };
    }
    counts
}

/// A balanced binary tree: splits at the median of box centres along the longest axis, with one primitive in each leaf.
#[expect(clippy::cast_possible_truncation, reason = "a mesh has fewer than 2^32 triangles")]
fn median_split(primitives: &[Bounds]) -> Bvh2 {
    let mut order: Vec<u32> = (0..primitives.len() as u32).collect();
    let mut nodes = vec![Bvh2Node::default()];
    let mut stack = vec![(0, 0..primitives.len())];
    while let Some((node, range)) = stack.pop() {
        let part = &mut order[range.clone()];
        let bounds = union(primitives, part);
        if part.len() == 1 {
            nodes[node] = Bvh2Node::new(bounds, 1, range.start as u32);
            continue;
        }
        let half = halve(primitives, part);
        let children = nodes.len();
        nodes[node] = Bvh2Node::new(bounds, 0, children as u32);
        nodes.extend([Bvh2Node::default(); 2]);
        let split = range.start + half;
        stack.extend([(children, range.start..split), (children + 1, split..range.end)]);
    }
    Bvh2 { nodes, primitive_indices: order, children_are_ordered_after_parents: true, ..Bvh2::default() }
}

/// The box around some primitives.
fn union(primitives: &[Bounds], part: &[u32]) -> Aabb {
    part.iter().fold(Aabb::empty(), |union, &primitive| union.union(&primitives[primitive as usize].aabb()))
}

/// Puts the primitives below the median of box centres along the longest axis first, and returns their number.
fn halve(primitives: &[Bounds], part: &mut [u32]) -> usize {
    let axis = union(primitives, part).diagonal().max_position();
    let centre = |primitive: &u32| primitives[*primitive as usize].aabb().center()[axis];
    let half = part.len() / 2;
    part.select_nth_unstable_by(half, |a, b| centre(a).total_cmp(&centre(b)));
    half
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::*;
    use crate::bounds::Interval;
    use crate::bvh::BvhRay;
    use crate::ray::Ray;

    const AHEAD: Interval = Interval { start_m: 0.0, end_m: f32::INFINITY };

    /// Bounds of a sliver from the centre of a square to its rim.
    fn sliver(angle: f32) -> Bounds {
        let (sin, cos) = angle.sin_cos();
        let rim = Vec3A::new(cos, sin, 0.0) / cos.abs().max(sin.abs());
        Bounds { low: rim.min(Vec3A::ZERO), high: rim.max(Vec3A::ZERO) }
    }

    /// The primitives of all leaves that a line along z through a point hits. Both traversals find equal primitives.
    fn candidates(bvh: &Bvh8, point: Vec3A) -> Vec<usize> {
        let (mut found, mut found_ordered) = (Vec::new(), Vec::new());
        let ray = BvhRay::new(&Ray::new(point - Vec3A::Z, Vec3A::Z), AHEAD);
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
            let ray = Ray::new(Vec3A::new(298.5, 0.0, 0.0) - 400.0 * direction, direction);
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
            let fan: Vec<Bounds> =
                (0..count).map(|k| sliver(std::f32::consts::TAU * k as f32 / count as f32)).collect();
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
}
