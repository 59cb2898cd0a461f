//! A quadtree over a rectangle, in which neighbours along an edge differ by at most one level (a restricted quadtree;
//! Von Herzen & Barr 1987, "Accurate triangulations of deformed, intersecting surfaces", doi:10.1145/37402.37415).
//!
//! A side of a cell is then halved at most once, by the corner that two smaller neighbours share, and triangles that
//! use this corner leave no crack.

use rayon::prelude::*;

/// A square of whole units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Cell {
    /// Units from the left.
    pub(crate) x: u32,
    /// Units from the far side.
    pub(crate) y: u32,
    /// Its side, a power of two.
    pub(crate) size: u32,
}

/// The sides of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    /// Of least y.
    Far,
    /// Of greatest x.
    Right,
    /// Of greatest y.
    Near,
    /// Of least x.
    Left,
}

impl Side {
    /// All sides, clockwise as seen from above where y runs from far to near.
    pub(crate) const ALL: [Self; 4] = [Self::Far, Self::Right, Self::Near, Self::Left];
}

impl Cell {
    fn quarters(self) -> [Self; 4] {
        let size = self.size / 2;
        [(0, 0), (size, 0), (0, size), (size, size)].map(|(x, y)| Self { x: self.x + x, y: self.y + y, size })
    }

    /// The unit square just across a side, at the side's beginning; none at negative coordinates.
    fn across(self, side: Side) -> Option<[u32; 2]> {
        let Self { x, y, size } = self;
        Some(match side {
            Side::Far => [x, y.checked_sub(1)?],
            Side::Right => [x + size, y],
            Side::Near => [x, y + size],
            Side::Left => [x.checked_sub(1)?, y],
        })
    }
}

/// A node without parts.
const LEAF: u32 = 0;
/// A node outside the rectangle.
const OUTSIDE: u32 = u32::MAX;

/// The cells of a rectangle.
#[derive(Debug)]
pub(crate) struct Quadtree {
    /// For each node the first of its four parts, or [`LEAF`] or [`OUTSIDE`].
    nodes: Vec<u32>,
    /// Units along a side of the root.
    size: u32,
    columns: u32,
    rows: u32,
}

/// A cell with its node.
type Leaf = (usize, Cell);

impl Quadtree {
    /// Splits the cells of a rectangle of `columns` × `rows` units, at most 2³⁰ each, as long as `must_split` holds
    /// and the cells are larger than a unit. Cells that reach out of the rectangle are always split.
    pub(crate) fn new(columns: u32, rows: u32, must_split: &(dyn Fn(Cell) -> bool + Sync)) -> Self {
        let size = columns.max(rows).next_power_of_two();
        let mut tree = Self { nodes: vec![LEAF], size, columns, rows };
        let mut fresh = vec![(0, Cell { x: 0, y: 0, size })];
        while !fresh.is_empty() {
            let split = |&(_, cell): &Leaf| cell.size > 1 && (tree.reaches_out(cell) || must_split(cell));
            let to_split: Vec<Leaf> = fresh.into_par_iter().filter(split).collect();
            fresh = to_split.into_iter().flat_map(|leaf| tree.split(leaf)).collect();
        }
        tree.balance(tree.leaves());
        tree
    }

    /// Splits leaves once more where `must_split` holds, and their neighbours as far as needed. Returns whether any
    /// leaf was split.
    pub(crate) fn refine(&mut self, must_split: &(dyn Fn(&Self, Cell) -> bool + Sync)) -> bool {
        let leaves = self.leaves();
        let split = |&&(_, cell): &&Leaf| cell.size > 1 && must_split(self, cell);
        let to_split: Vec<Leaf> = leaves.par_iter().filter(split).copied().collect();
        let fresh: Vec<Leaf> = to_split.iter().flat_map(|leaf| self.split(*leaf)).collect();
        self.balance(fresh);
        !to_split.is_empty()
    }

    /// The leaves, quarter by quarter.
    pub(crate) fn cells(&self) -> Vec<Cell> {
        self.leaves().into_iter().map(|(_, cell)| cell).collect()
    }

    /// Whether a cell is divided into smaller cells.
    pub(crate) fn is_split(&self, cell: Cell) -> bool {
        self.leaf_at([cell.x, cell.y]).is_some_and(|(_, leaf)| leaf.size < cell.size)
    }

    /// Whether the neighbours across a side are smaller, so that they share a corner in its middle.
    pub(crate) fn is_halved(&self, cell: Cell, side: Side) -> bool {
        self.neighbour(cell, side).is_some_and(|(_, other)| other.size < cell.size)
    }

    /// Whether a side lies on the edge of the rectangle.
    pub(crate) fn is_edge(&self, cell: Cell, side: Side) -> bool {
        match side {
            Side::Far => cell.y == 0,
            Side::Right => cell.x + cell.size == self.columns,
            Side::Near => cell.y + cell.size == self.rows,
            Side::Left => cell.x == 0,
        }
    }

    fn reaches_out(&self, cell: Cell) -> bool {
        cell.x + cell.size > self.columns || cell.y + cell.size > self.rows
    }

    #[expect(clippy::cast_possible_truncation, reason = "a tree in memory has fewer than 2^32 nodes")]
    fn split(&mut self, (node, cell): Leaf) -> Vec<Leaf> {
        let first = self.nodes.len();
        self.nodes[node] = first as u32;
        let mut fresh = Vec::with_capacity(4);
        for (number, quarter) in cell.quarters().into_iter().enumerate() {
            let is_outside = quarter.x >= self.columns || quarter.y >= self.rows;
            self.nodes.push(if is_outside { OUTSIDE } else { LEAF });
            if !is_outside {
                fresh.push((first + number, quarter));
            }
        }
        fresh
    }

    fn leaves(&self) -> Vec<Leaf> {
        let mut leaves = Vec::with_capacity(self.nodes.len() / 4 * 3 + 1);
        let mut stack = vec![(0, Cell { x: 0, y: 0, size: self.size })];
        while let Some((node, cell)) = stack.pop() {
            match self.nodes[node] {
                LEAF => leaves.push((node, cell)),
                OUTSIDE => {}
                first => stack.extend((first as usize..).zip(cell.quarters()).collect::<Vec<_>>().into_iter().rev()),
            }
        }
        leaves
    }

    /// The leaf that holds a unit square, if it lies in the rectangle.
    fn leaf_at(&self, [x, y]: [u32; 2]) -> Option<Leaf> {
        if x >= self.columns || y >= self.rows {
            return None;
        }
        let (mut node, mut cell) = (0, Cell { x: 0, y: 0, size: self.size });
        while self.nodes[node] != LEAF {
            let size = cell.size / 2;
            let (right, near) = (x >= cell.x + size, y >= cell.y + size);
            node = self.nodes[node] as usize + usize::from(right) + 2 * usize::from(near);
            cell = cell.quarters()[usize::from(right) + 2 * usize::from(near)];
        }
        Some((node, cell))
    }

    fn neighbour(&self, cell: Cell, side: Side) -> Option<Leaf> {
        self.leaf_at(cell.across(side)?)
    }

    /// Splits neighbours that are more than twice as large as a pending leaf, until no such neighbour is left.
    fn balance(&mut self, mut pending: Vec<Leaf>) {
        while !pending.is_empty() {
            // If a leaf has been split meanwhile, its parts are pending instead.
            pending.retain(|(node, _)| self.nodes[*node] == LEAF);
            let tree = &*self;
            let too_large = |leaf: Leaf| {
                let neighbours = Side::ALL.map(|side| tree.neighbour(leaf.1, side)).into_iter().flatten();
                let found: Vec<Leaf> = neighbours.filter(|(_, other)| other.size > 2 * leaf.1.size).collect();
                (!found.is_empty()).then_some((leaf, found))
            };
            let found: Vec<(Leaf, Vec<Leaf>)> = pending.into_par_iter().filter_map(too_large).collect();
            pending = Vec::new();
            for (leaf, neighbours) in found {
                pending.push(leaf);
                for neighbour in neighbours {
                    if self.nodes[neighbour.0] == LEAF {
                        pending.extend(self.split(neighbour));
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_cover_the_rectangle_and_neighbours_differ_by_one_level() {
        // One corner is split to single units, in a rectangle that is neither a square nor a power of two.
        let corner = |cell: Cell| cell.x < 5 && 5 < cell.x + cell.size && cell.y < 3 && 3 < cell.y + cell.size;
        let tree = Quadtree::new(96, 37, &corner);
        let cells = tree.cells();
        let area: u32 = cells.iter().map(|cell| cell.size * cell.size).sum();
        assert_eq!(area, 96 * 37);
        assert!(cells.iter().any(|cell| cell.size == 1) && cells.iter().any(|cell| cell.size >= 8));
        for &cell in &cells {
            for side in Side::ALL {
                let neighbour = tree.neighbour(cell, side);
                assert_eq!(neighbour.is_none(), tree.is_edge(cell, side), "{cell:?} {side:?}");
                let ratio = neighbour.map_or(1.0, |(_, other)| f64::from(other.size) / f64::from(cell.size));
                assert!((0.5..=2.0).contains(&ratio), "{cell:?} {side:?}");
            }
        }
    }

    #[test]
    fn refining_splits_once_and_keeps_the_balance() {
        let mut tree = Quadtree::new(64, 64, &|cell| cell.size > 16);
        assert!(tree.refine(&|_, cell| cell.x == 0 && cell.y == 0));
        assert!(tree.refine(&|_, cell| cell.x == 0 && cell.y == 0));
        assert!(!tree.refine(&|_, _| false));
        let cells = tree.cells();
        assert_eq!(cells.iter().map(|cell| cell.size * cell.size).sum::<u32>(), 64 * 64);
        // 16 cells of 16 units. One cell is split into quarters, and one quarter is split again. Their neighbours
        // stay.
        assert_eq!((cells.len(), cells[0].size), (22, 4));
        let second = cells.iter().find(|cell| cell.x == 8 && cell.y == 0).unwrap();
        assert!(tree.is_halved(*second, Side::Left) && !tree.is_halved(*second, Side::Right));
    }
}
