//! An octree of cells: the divided cells, and the cell that holds a point.
//!
//! Some places demand cells of at most some level. The octree is the coarsest octree that meets these demands and in
//! which cells grow slowly: a cell of level k + 1 has no divided cell of level k and no demand of level k within
//! [`RING`] cells of level k. Neighbouring cells therefore differ by one level at most.

use crate::lattice::Lattice;

/// Marks the absence of a cell or node.
pub(crate) const NONE: u32 = u32::MAX;
/// Marks a child that is divided itself.
const DIVIDED: u32 = 1 << 31;
/// Children of a divided cell.
const CHILDREN: usize = 8;
/// Width of the ring around a block of eight cells that may become one larger cell, in cells of the block's level.
const RING: u64 = 3;
/// Bits of a coordinate in a key.
const KEY_BITS: u32 = 21;

/// The place of a cell or node as one number. The numbers are sorted by x, then y, then z.
pub(crate) fn key(place: [u32; 3]) -> u64 {
    place.into_iter().fold(0, |key, k| key << KEY_BITS | u64::from(k))
}

/// The place of a key.
#[expect(clippy::cast_possible_truncation, reason = "masked")]
pub(crate) fn place(key: u64) -> [u32; 3] {
    std::array::from_fn(|k| (key >> (KEY_BITS * (2 - k as u32)) & ((1 << KEY_BITS) - 1)) as u32)
}

/// The divided cells and their children.
#[derive(Debug)]
pub(crate) struct Octree {
    /// The level of the root.
    top: u8,
    /// The children of each divided cell: the number of a divided cell, marked as [`DIVIDED`]; the number of a cell of
    /// the grid; or [`NONE`] outside of the body.
    children: Vec<[u32; CHILDREN]>,
}

/// A cell that is not divided.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leaf {
    pub(crate) level: u8,
    /// Its place among the cells of its level.
    pub(crate) place: [u32; 3],
    /// Whether the demands contain this cell or a larger cell around it.
    pub(crate) is_demanded: bool,
    parent: u32,
    child: u8,
}

impl Leaf {
    /// The finest cell at its corner of least coordinates.
    pub(crate) fn origin(&self) -> [u32; 3] {
        self.place.map(|k| k << self.level)
    }
}

impl Octree {
    /// Divides the cells around a lattice of finest cells. `demands[k]` holds the sorted keys of the cells of level k
    /// that must not be part of a larger cell. Also returns the cells that are not divided.
    pub(crate) fn new(lattice: &Lattice, demands: &[Vec<u64>]) -> (Self, Vec<Leaf>) {
        let top = lattice.top_level();
        let demands_of = |level: u8| demands.get(usize::from(level)).map_or(&[][..], Vec::as_slice);
        let mut divided: Vec<Vec<u64>> = vec![Vec::new()];
        for level in 0..top {
            let next = ringed(&divided[usize::from(level)], demands_of(level), lattice.coarsened(level + 1).counts);
            divided.push(next);
        }
        // The root is divided in any case.
        divided[usize::from(top)] = vec![key([0; 3])];
        let mut octree = Self { top, children: Vec::new() };
        let mut leaves = Vec::new();
        // For each divided cell of the level, whether the demands contain it or a larger cell around it.
        let mut demanded = vec![!demands_of(top).is_empty()];
        for level in (0..top).rev() {
            let (parents, inner) = (&divided[usize::from(level) + 1], &divided[usize::from(level)]);
            let own = demands_of(level);
            let counts = lattice.coarsened(level).counts.map(number);
            let (first, next) = (number(octree.children.len()), number(octree.children.len() + parents.len()));
            let mut inner_demanded = vec![false; inner.len()];
            for (parent, &parent_key) in parents.iter().enumerate() {
                let corner = place(parent_key).map(|k| 2 * k);
                let children = std::array::from_fn(|child| {
                    let place = std::array::from_fn(|k| corner[k] + (number(child) >> k & 1));
                    if (0..3).any(|k| place[k] >= counts[k]) {
                        return NONE;
                    }
                    let key = key(place);
                    let is_demanded = demanded[parent] || own.binary_search(&key).is_ok();
                    if let Ok(position) = inner.binary_search(&key) {
                        inner_demanded[position] = is_demanded;
                        return DIVIDED | (next + number(position));
                    }
                    let (parent, child) = (first + number(parent), u8::try_from(child).unwrap_or(0));
                    leaves.push(Leaf { level, place, is_demanded, parent, child });
                    NONE
                });
                octree.children.push(children);
            }
            demanded = inner_demanded;
        }
        (octree, leaves)
    }

    /// Memory, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.children)
    }

    /// Sets the number in the grid of a cell that is not divided.
    pub(crate) fn set_cell(&mut self, leaf: &Leaf, cell: u32) {
        self.children[leaf.parent as usize][usize::from(leaf.child)] = cell;
    }

    /// The number of the cell that contains a finest cell, or [`NONE`], and the level of the cell.
    #[inline]
    pub(crate) fn find(&self, finest: [u32; 3]) -> (u32, u8) {
        let (mut level, mut inner) = (self.top, 0);
        loop {
            level -= 1;
            let [x, y, z] = finest.map(|k| k >> level & 1);
            let child = self.children[inner as usize][(x | y << 1 | z << 2) as usize];
            if child == NONE || child & DIVIDED == 0 {
                return (child, level);
            }
            inner = child & !DIVIDED;
        }
    }
}

/// The sorted keys of the cells of the next level that have cells of this level within a ring: cells of `divided` or
/// `others`. `counts` is the number of cells of the next level along each axis.
fn ringed(divided: &[u64], others: &[u64], counts: [usize; 3]) -> Vec<u64> {
    let mut keys: Vec<u64> = divided.iter().chain(others).copied().collect();
    for (axis, count) in (0..).zip(counts) {
        let shift = KEY_BITS * (2 - axis);
        let mask = ((1 << KEY_BITS) - 1) << shift;
        let last = count as u64 - 1;
        let around = |key: u64| {
            let at = (key & mask) >> shift;
            // The ring around the block of cells 2k and 2k + 1 extends from cell 2k − RING to cell 2k + 1 + RING.
            let (low, high) = (at.saturating_sub(RING + 1).div_ceil(2), (at + RING) / 2);
            (low..=high.min(last)).map(move |at| key & !mask | at << shift)
        };
        keys = keys.into_iter().flat_map(around).collect();
        keys.sort_unstable();
        keys.dedup();
    }
    keys
}

#[expect(clippy::cast_possible_truncation, reason = "an octree has fewer than 2^31 cells")]
fn number(count: usize) -> u32 {
    count as u32
}
