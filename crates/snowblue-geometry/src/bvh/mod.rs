//! Bounding volume hierarchy with eight children per node: structure and traversal.
//!
//! A node tests its eight boxes at once in SIMD registers; a leaf holds at most four primitives, which the caller tests
//! together (Wald, Benthin & Boulos 2008, "Getting rid of packets", doi:10.1109/RT.2008.4634620).

mod build;

use std::cell::Cell;

use arrayvec::ArrayVec;
use glam::Vec3A;
use wide::f32x8;

use crate::bounds::{Bounds, Interval, finite_inverse};
use crate::ray::Ray;

/// Children per node.
const WIDTH: usize = 8;

/// Greatest number of primitives in a leaf.
const LEAF_WIDTH: usize = 4;

/// Marks unused slots of a leaf.
const NO_PRIMITIVE: u32 = u32::MAX;

/// Greatest number of levels of nodes: the levels of a balanced binary tree over 2³¹ primitives down to leaves of
/// four.
const MAX_DEPTH: usize = 29;

/// Traversal stack capacity: 7 per level + 1.
const STACK_CAPACITY: usize = (WIDTH - 1) * MAX_DEPTH + 1;

/// Bit that is set in the indices of leaves and clear in the indices of nodes.
const LEAF_FLAG: u32 = 1 << 31;

/// An eight-wide bounding volume hierarchy.
#[derive(Debug)]
pub struct Bvh8 {
    /// Index of the root node, or flagged index of the only leaf.
    root: u32,
    nodes: Vec<Node>,
    /// Primitive indices of each leaf.
    leaves: Vec<[u32; LEAF_WIDTH]>,
}

/// The boxes of eight children. Unused slots hold empty boxes, which no ray hits.
#[derive(Debug, Clone, Copy)]
struct Node {
    /// Lower and upper planes along each axis.
    planes: [[f32x8; 3]; 2],
    /// Indices of nodes, and flagged indices of leaves.
    children: [u32; WIDTH],
}

/// An interval of a ray, prepared for traversal.
#[derive(Debug, Clone, Copy)]
pub struct BvhRay {
    origin: [f32x8; 3],
    inverse_direction: [f32x8; 3],
    /// Index of the plane that the ray meets first, along each axis.
    near_plane: [usize; 3],
    interval: Interval,
}

impl BvhRay {
    /// Prepares an interval of a ray.
    #[inline]
    pub fn new(ray: &Ray, interval: Interval) -> Self {
        let inverse = finite_inverse(ray.direction);
        Self {
            origin: ray.origin.to_array().map(f32x8::splat),
            inverse_direction: inverse.to_array().map(f32x8::splat),
            near_plane: inverse.to_array().map(|inverse| usize::from(inverse < 0.0)),
            interval,
        }
    }
}

/// The children of a node whose boxes a ray hits.
struct HitChildren {
    /// One bit for each child.
    mask: u32,
    /// Entry distances, valid where the bit is set.
    enter_m: [f32; WIDTH],
}

impl Node {
    /// A node with at most eight boxes; child indices are zero.
    fn new(boxes: impl Iterator<Item = Bounds>) -> Self {
        let mut planes = [[[f32::INFINITY; WIDTH]; 3], [[f32::NEG_INFINITY; WIDTH]; 3]];
        for (slot, bounds) in boxes.enumerate() {
            for (planes, corner) in planes.iter_mut().zip([bounds.low, bounds.high]) {
                planes.iter_mut().zip(corner.to_array()).for_each(|(plane, coordinate)| plane[slot] = coordinate);
            }
        }
        Self { planes: planes.map(|planes| planes.map(f32x8::new)), children: [0; WIDTH] }
    }

    /// The children whose boxes a ray enters before `end_m`.
    #[inline(always)]
    fn intersect(&self, ray: &BvhRay, end_m: f32) -> HitChildren {
        let distance =
            |axis: usize, plane: usize| (self.planes[plane][axis] - ray.origin[axis]) * ray.inverse_direction[axis];
        let [near_x, near_y, near_z] = ray.near_plane;
        let (x, x_end) = (distance(0, near_x), distance(0, 1 - near_x));
        let (y, y_end) = (distance(1, near_y), distance(1, 1 - near_y));
        let (z, z_end) = (distance(2, near_z), distance(2, 1 - near_z));
        let enter = x.fast_max(y).fast_max(z.fast_max(f32x8::splat(ray.interval.start_m)));
        let leave = x_end.fast_min(y_end).fast_min(z_end.fast_min(f32x8::splat(end_m)));
        HitChildren { mask: enter.simd_le(leave).to_bitmask(), enter_m: enter.to_array() }
    }

    /// The children whose boxes are within a distance of a point, one bit each.
    #[inline(always)]
    fn near(&self, point: &[f32x8; 3], distance: f32) -> u32 {
        let [low, high] = &self.planes;
        let outside = |axis: usize| (low[axis] - point[axis]).fast_max(point[axis] - high[axis]).fast_max(f32x8::ZERO);
        let [x, y, z] = [0, 1, 2].map(outside);
        (x * x + y * y + z * z).simd_le(f32x8::splat(distance * distance)).to_bitmask()
    }
}

impl Bvh8 {
    /// Number of leaves.
    pub(crate) fn leaf_count(&self) -> usize {
        self.leaves.len()
    }

    /// The indices of a leaf's primitives, at most four.
    pub fn primitives(&self, leaf: usize) -> impl Iterator<Item = usize> {
        self.leaves[leaf].iter().filter(|primitive| **primitive != NO_PRIMITIVE).map(|primitive| *primitive as usize)
    }

    /// The index of the primitive in a slot of a leaf.
    pub(crate) fn primitive(&self, leaf: usize, slot: usize) -> u32 {
        self.leaves[leaf][slot]
    }

    /// Calls `visit` for each leaf that the ray hits, in order of entry. `visit` returns the distance at which the
    /// traversal ends from then on.
    #[inline]
    pub fn traverse_ordered(&self, ray: &BvhRay, mut visit: impl FnMut(usize) -> f32) {
        let mut end_m = ray.interval.end_m;
        let mut stack = ArrayVec::<(f32, u32), STACK_CAPACITY>::new();
        let mut next = self.root;
        loop {
            if next & LEAF_FLAG == 0 {
                let node = &self.nodes[next as usize];
                let HitChildren { mut mask, enter_m } = node.intersect(ray, end_m);
                // Insertion sort: the nearest child is on top of the stack.
                let base = stack.len();
                while mask != 0 {
                    let child = mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    stack.push((enter_m[child], node.children[child]));
                    let mut at = stack.len() - 1;
                    while at > base && stack[at - 1].0 < stack[at].0 {
                        stack.swap(at - 1, at);
                        at -= 1;
                    }
                }
            } else {
                end_m = end_m.min(visit((next & !LEAF_FLAG) as usize));
            }
            next = loop {
                match stack.pop() {
                    Some((enter_m, child)) if enter_m <= end_m => break child,
                    Some(_) => {}
                    None => return,
                }
            };
        }
    }

    /// Calls `visit` for each leaf whose box is within a distance of a point, in any order. `visit` returns the
    /// distance from then on. A negative distance ends the traversal.
    #[inline]
    pub(crate) fn visit_near(&self, point: Vec3A, distance: f32, mut visit: impl FnMut(usize) -> f32) {
        let (point, distance) = (point.to_array().map(f32x8::splat), Cell::new(distance));
        let visit = |leaf| {
            distance.set(visit(leaf));
            distance.get() < 0.0
        };
        self.visit_leaves(|node| node.near(&point, distance.get()), visit);
    }

    /// Calls `visit` for each leaf that the ray hits, in any order, until it returns true.
    #[inline]
    pub fn traverse(&self, ray: &BvhRay, visit: impl FnMut(usize) -> bool) {
        self.visit_leaves(|node| node.intersect(ray, ray.interval.end_m).mask, visit);
    }

    /// Calls `visit` for each leaf below chosen children, one bit each, in any order, until it returns true.
    #[inline]
    fn visit_leaves(&self, children: impl Fn(&Node) -> u32, mut visit: impl FnMut(usize) -> bool) {
        let mut stack = ArrayVec::<u32, STACK_CAPACITY>::new();
        stack.push(self.root);
        while let Some(next) = stack.pop() {
            if next & LEAF_FLAG == 0 {
                let node = &self.nodes[next as usize];
                let mut mask = children(node);
                while mask != 0 {
                    stack.push(node.children[mask.trailing_zeros() as usize]);
                    mask &= mask - 1;
                }
            } else if visit((next & !LEAF_FLAG) as usize) {
                return;
            }
        }
    }
}
