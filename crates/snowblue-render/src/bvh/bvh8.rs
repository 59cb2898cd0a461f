//! Hierarchies of boxes, eight to a node, and walks through them.
//!
//! The boxes of a node are tried at once, by registers of four numbers, and so are the things in a leaf, at most four (Wald, Benthin
//! & Boulos 2008, "Getting rid of packets", doi:10.1109/RT.2008.4634620). The tree comes from pairs: the usual way to build pairs the
//! boxes that are nearest to each other, level by level, with `obvhs` (Meister & Bittner 2018, "Parallel locally-ordered
//! clustering", doi:10.1109/TVCG.2017.2669983); of slivers about one point, whose boxes all overlap, it makes a chain. Those are
//! halved by their middles instead: a slower tree, and never a deep one.

use std::time::Duration;

use arrayvec::ArrayVec;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::{Boundable, BvhBuildParams};
use wide::f32x8;

use crate::geometry::bounds::{Bounds, finite_inverse};
use crate::geometry::ray::Ray;

/// Boxes of a node.
const WIDTH: usize = 8;

/// Most things in a leaf.
const LEAF_WIDTH: usize = 4;

/// In a leaf, the place of a thing that is not there.
const NOTHING: u32 = u32::MAX;

/// Levels up to which a walk stays within its stack: as many as halves of 2³¹ things have, down to leaves of four.
const MOST_LEVELS: usize = 29;

/// Room for what waits on a walk: all boxes but one of each level, and one.
const WAITING: usize = (WIDTH - 1) * MOST_LEVELS + 1;

/// Marks the number of a leaf among those of nodes.
const LEAF: u32 = 1 << 31;

/// Boxes about things, boxes about these, and so on.
#[derive(Debug)]
pub(crate) struct Bvh8 {
    root: u32,
    nodes: Vec<Node>,
    /// The things in each leaf, by their numbers.
    leaves: Vec<[u32; LEAF_WIDTH]>,
}

/// Some boxes; those that are not there are inside out, and nothing meets them.
#[derive(Debug, Clone, Copy)]
struct Node {
    /// Low and high sides along each axis.
    sides: [[f32x8; 3]; 2],
    /// Numbers of nodes, and of leaves with their mark.
    children: [u32; WIDTH],
}

/// The part of a line that walks through a hierarchy.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BvhRay {
    origin: [f32x8; 3],
    inverse: [f32x8; 3],
    /// Along each axis which side of a box it meets first.
    first_side: [usize; 3],
    from: f32,
    to: f32,
}

impl BvhRay {
    /// The part of a ray between two distances along it.
    #[inline]
    pub(crate) fn new(ray: &Ray, from: f32, to: f32) -> Self {
        let inverse = finite_inverse(ray.direction);
        Self {
            origin: ray.origin.to_array().map(f32x8::splat),
            inverse: inverse.to_array().map(f32x8::splat),
            first_side: inverse.to_array().map(|inverse| usize::from(inverse < 0.0)),
            from,
            to,
        }
    }
}

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        Aabb::new(self.low, self.high)
    }
}

impl Node {
    /// A node with some boxes, at most eight.
    fn around<'boxes>(boxes: impl Iterator<Item = &'boxes Aabb>) -> Self {
        let mut sides = [[[f32::INFINITY; WIDTH]; 3], [[f32::NEG_INFINITY; WIDTH]; 3]];
        for (place, one) in boxes.enumerate() {
            for (sides, corner) in sides.iter_mut().zip([one.min, one.max]) {
                sides.iter_mut().zip(corner.to_array()).for_each(|(side, at)| side[place] = at);
            }
        }
        Self { sides: sides.map(|sides| sides.map(f32x8::new)), children: [0; WIDTH] }
    }

    /// Which boxes a course meets before `to`, as bits, and where.
    #[inline(always)]
    fn met(&self, course: &BvhRay, to: f32) -> (u32, [f32; WIDTH]) {
        let distance = |axis: usize, side: usize| (self.sides[side][axis] - course.origin[axis]) * course.inverse[axis];
        let [first_x, first_y, first_z] = course.first_side;
        let (x, x_end) = (distance(0, first_x), distance(0, 1 - first_x));
        let (y, y_end) = (distance(1, first_y), distance(1, 1 - first_y));
        let (z, z_end) = (distance(2, first_z), distance(2, 1 - first_z));
        let enter = x.fast_max(y).fast_max(z.fast_max(f32x8::splat(course.from)));
        let leave = x_end.fast_min(y_end).fast_min(z_end.fast_min(f32x8::splat(to)));
        (enter.simd_le(leave).to_bitmask(), enter.to_array())
    }
}

impl Bvh8 {
    /// A hierarchy over things with boxes, of which there is at least one.
    pub(crate) fn over(boxes: &[Bounds]) -> Self {
        let usual = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::medium_build() };
        Self::widened(&build_bvh2(boxes, usual, &mut Duration::default())).unwrap_or_else(|| Self::halved(boxes))
    }

    fn halved(boxes: &[Bounds]) -> Self {
        Self::widened(&halved(boxes)).expect("halves of fewer than 2^31 things end after 29 levels")
    }

    /// How many leaves there are.
    pub(crate) fn leaf_count(&self) -> usize {
        self.leaves.len()
    }

    /// The numbers of the things in a leaf, at most four.
    pub(crate) fn things(&self, leaf: usize) -> impl Iterator<Item = usize> {
        self.leaves[leaf].iter().filter(|thing| **thing != NOTHING).map(|thing| *thing as usize)
    }

    /// The number of one of a leaf's things, by its place among them.
    pub(crate) fn thing(&self, leaf: usize, place: usize) -> u32 {
        self.leaves[leaf][place]
    }

    /// Calls `visit` with the leaves whose boxes a course meets, in the order in which it meets them; it returns the distance up to
    /// which to look on.
    #[inline]
    pub(crate) fn traverse_ordered(&self, course: &BvhRay, mut visit: impl FnMut(usize) -> f32) {
        let mut to = course.to;
        let mut waiting = ArrayVec::<(f32, u32), WAITING>::new();
        let mut next = self.root;
        loop {
            if next & LEAF == 0 {
                let node = &self.nodes[next as usize];
                let (mut met, enter) = node.met(course, to);
                let base = waiting.len();
                while met != 0 {
                    let child = met.trailing_zeros() as usize;
                    met &= met - 1;
                    waiting.push((enter[child], node.children[child]));
                    let mut at = waiting.len() - 1;
                    while at > base && waiting[at - 1].0 < waiting[at].0 {
                        waiting.swap(at - 1, at);
                        at -= 1;
                    }
                }
            } else {
                to = to.min(visit((next & !LEAF) as usize));
            }
            next = loop {
                match waiting.pop() {
                    Some((enter, child)) if enter <= to => break child,
                    Some(_) => {}
                    None => return,
                }
            };
        }
    }

    /// Calls `visit` with the leaves whose boxes a course meets, in no particular order, until it has seen enough.
    #[inline]
    pub(crate) fn walk(&self, course: &BvhRay, mut visit: impl FnMut(usize) -> bool) {
        let mut waiting = ArrayVec::<u32, WAITING>::new();
        waiting.push(self.root);
        while let Some(next) = waiting.pop() {
            if next & LEAF == 0 {
                let node = &self.nodes[next as usize];
                let (mut met, _) = node.met(course, course.to);
                while met != 0 {
                    waiting.push(node.children[met.trailing_zeros() as usize]);
                    met &= met - 1;
                }
            } else if visit((next & !LEAF) as usize) {
                return;
            }
        }
    }

    /// Eight boxes out of some levels of pairs, unless there are too many levels.
    fn widened(binary: &Bvh2) -> Option<Self> {
        let counts = thing_counts(binary);
        let mut wide = Self { root: 0, nodes: Vec::new(), leaves: Vec::new() };
        wide.root = wide.add((binary, &counts), 0, 0)?;
        wide.nodes.shrink_to_fit();
        wide.leaves.shrink_to_fit();
        Some(wide)
    }

    /// Adds what is below a box of a pair, on some level, and returns its number; none if it goes too deep.
    #[expect(clippy::cast_possible_truncation, reason = "a mesh has fewer than 2^31 triangles")]
    fn add(&mut self, (binary, counts): (&Bvh2, &[u32]), top: usize, level: usize) -> Option<u32> {
        if counts[top] as usize <= LEAF_WIDTH {
            let mut things = [NOTHING; LEAF_WIDTH];
            things.iter_mut().zip(things_below(binary, top)).for_each(|(place, thing)| *place = thing);
            self.leaves.push(things);
            return Some((self.leaves.len() as u32 - 1) | LEAF);
        }
        if level == MOST_LEVELS {
            return None;
        }
        // The widest of the boxes that can be opened gives way to its pair, until there are eight.
        let pair = |node: usize| [0, 1].map(|other| binary.nodes[node].first_index as usize + other);
        let mut open = ArrayVec::<usize, WIDTH>::from_iter(pair(top));
        while open.len() < WIDTH {
            let areas = open.iter().map(|&node| {
                if counts[node] as usize <= LEAF_WIDTH { 0.0 } else { binary.nodes[node].aabb().half_area() }
            });
            let (widest, area) = areas.enumerate().fold((0, 0.0), |most, one| if one.1 > most.1 { one } else { most });
            if area <= 0.0 {
                break;
            }
            let [first, second] = pair(open[widest]);
            open[widest] = first;
            open.push(second);
        }
        let number = self.nodes.len();
        self.nodes.push(Node::around(open.iter().map(|&node| binary.nodes[node].aabb())));
        for (place, &node) in open.iter().enumerate() {
            self.nodes[number].children[place] = self.add((binary, counts), node, level + 1)?;
        }
        Some(number as u32)
    }
}

/// The nodes below one and itself, each before those below it.
fn nodes_below(binary: &Bvh2, top: usize) -> impl Iterator<Item = usize> {
    let mut waiting = vec![top];
    std::iter::from_fn(move || {
        let index = waiting.pop()?;
        let node = &binary.nodes[index];
        if !node.is_leaf() {
            waiting.extend([1, 0].map(|other| node.first_index as usize + other));
        }
        Some(index)
    })
}

/// The things below a node.
fn things_below(binary: &Bvh2, top: usize) -> impl Iterator<Item = u32> {
    nodes_below(binary, top).flat_map(|index| {
        let node = &binary.nodes[index];
        let first = node.first_index as usize;
        let things = if node.is_leaf() { first..first + node.prim_count as usize } else { 0..0 };
        things.map(|place| binary.primitive_indices[place])
    })
}

/// How many things there are below each node.
fn thing_counts(binary: &Bvh2) -> Vec<u32> {
    let mut counts = vec![0; binary.nodes.len()];
    let order: Vec<usize> = nodes_below(binary, 0).collect();
    for &index in order.iter().rev() {
        let node = &binary.nodes[index];
        let first = node.first_index as usize;
        counts[index] = if node.is_leaf() { node.prim_count } else { counts[first] + counts[first + 1] };
    }
    counts
}

/// Halves the things by the order of their middles along the longest side of their box, again and again.
#[expect(clippy::cast_possible_truncation, reason = "a mesh has fewer than 2^32 triangles")]
fn halved(boxes: &[Bounds]) -> Bvh2 {
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = vec![Bvh2Node::default()];
    let mut waiting = vec![(0, 0..boxes.len())];
    while let Some((node, range)) = waiting.pop() {
        let part = &mut order[range.clone()];
        let around = part.iter().fold(Aabb::empty(), |around, &thing| around.union(&boxes[thing as usize].aabb()));
        if part.len() == 1 {
            nodes[node] = Bvh2Node::new(around, 1, range.start as u32);
            continue;
        }
        let axis = around.diagonal().max_position();
        let middle = |thing: &u32| boxes[*thing as usize].aabb().center()[axis];
        let half = part.len() / 2;
        part.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
        let children = nodes.len();
        nodes[node] = Bvh2Node::new(around, 0, children as u32);
        nodes.extend([Bvh2Node::default(); 2]);
        let split = range.start + half;
        waiting.extend([(children, range.start..split), (children + 1, split..range.end)]);
    }
    Bvh2 { nodes, primitive_indices: order, children_are_ordered_after_parents: true, ..Bvh2::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;

    /// The box of a sliver from the middle of a square to its rim.
    fn sliver(turn: f32) -> Bounds {
        let (sin, cos) = turn.sin_cos();
        let rim = Vec3A::new(cos, sin, 0.0) / cos.abs().max(sin.abs());
        Bounds { low: rim.min(Vec3A::ZERO), high: rim.max(Vec3A::ZERO) }
    }

    /// The things that walks along z through a place offer, the same on either kind of walk.
    fn offered(hierarchy: &Bvh8, place: Vec3A) -> Vec<usize> {
        let (mut things, mut in_order) = (Vec::new(), Vec::new());
        let course = BvhRay::new(&Ray { origin: place - Vec3A::Z, direction: Vec3A::Z }, 0.0, f32::INFINITY);
        hierarchy.walk(&course, |leaf| {
            things.extend(hierarchy.things(leaf));
            false
        });
        hierarchy.traverse_ordered(&course, |leaf| {
            in_order.extend(hierarchy.things(leaf));
            f32::INFINITY
        });
        things.sort_unstable();
        in_order.sort_unstable();
        assert_eq!(things, in_order);
        things
    }

    #[test]
    fn a_walk_in_order_meets_the_nearest_first_and_ends_where_it_is_told() {
        let beads: Vec<Bounds> = (0..200u8)
            .map(|k| Vec3A::new(f32::from(k) * 3.0, 0.0, 0.0))
            .map(|middle| Bounds { low: middle - 1.0, high: middle + 1.0 })
            .collect();
        let hierarchy = Bvh8::over(&beads);
        for (direction, sign) in [(Vec3A::X, 1.0), (Vec3A::NEG_X, -1.0)] {
            let ray = Ray { origin: Vec3A::new(298.5, 0.0, 0.0) - 400.0 * direction, direction };
            let (mut before, mut met) = (f32::NEG_INFINITY, 0);
            hierarchy.traverse_ordered(&BvhRay::new(&ray, 0.0, f32::INFINITY), |leaf| {
                let places = hierarchy.things(leaf).map(|thing| sign * 3.0 * thing as f32);
                let begin = places.fold(f32::INFINITY, f32::min);
                assert!(begin > before, "{begin} after {before}");
                before = begin;
                met += hierarchy.things(leaf).count();
                // The way to the middle of the string.
                400.0
            });
            assert!((100..110).contains(&met), "{met}");
        }
    }

    #[test]
    fn slivers_about_a_point_make_no_deep_tree_and_none_is_forgotten() {
        for count in [1, 2, 10, 1900, 10_000_usize] {
            let fan: Vec<Bounds> =
                (0..count).map(|k| sliver(std::f32::consts::TAU * k as f32 / count as f32)).collect();
            for hierarchy in [Bvh8::over(&fan), Bvh8::halved(&fan)] {
                let mut found: Vec<usize> =
                    (0..hierarchy.leaf_count()).flat_map(|leaf| hierarchy.things(leaf)).collect();
                found.sort_unstable();
                assert!(found.iter().enumerate().all(|(k, &thing)| k == thing) && found.len() == count);
                for place in [Vec3A::new(0.3, 0.2, 0.0), Vec3A::new(-0.7, 0.1, 0.0)] {
                    let things = offered(&hierarchy, place);
                    for (thing, Bounds { low, high }) in fan.iter().enumerate() {
                        let inside = (low.x..=high.x).contains(&place.x) && (low.y..=high.y).contains(&place.y);
                        assert!(!inside || things.contains(&thing), "{thing} of {count}");
                    }
                }
            }
        }
    }
}
