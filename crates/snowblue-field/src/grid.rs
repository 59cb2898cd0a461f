//! The grid: an octree of cells through a body, finest at the surface.
//!
//! Cells that the surface cuts have the finest size. A cell far inside is as wide as about a third of its distance to
//! the surface: light that varies on a shorter scale does not reach that depth. Neighbours differ by one level at most,
//! and a node that lies on an edge or face of a larger cell takes the mean of that edge's or face's corners.

use std::ops::Range;

use glam::DVec3;

use crate::body::Body;
use crate::element::{CELL_PARTS, CORNERS};
use crate::lattice::Lattice;
use crate::scan::{Coverage, SurfaceElement, coverage, surface};

/// Marks the absence of a cell or node.
pub(crate) const NONE: u32 = u32::MAX;

/// How far inwards from the surface, in cells, its cell is looked for: the surface may lie on the face of a cell, just
/// outside of all, or where the body fills so little of a cell that its sampled volume is zero. Light cannot enter by a
/// cell without volume.
pub(crate) const INWARD: [f64; 4] = [1e-6, 0.1, 0.5, 1.0];
/// Cells of the same level around a block of eight that may become one larger cell.
const RING: usize = 3;
/// Most levels of coarsening.
const MOST_LEVELS: usize = 7;

/// A cell of the octree.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cell {
    /// The finest cell at its corner of least coordinates.
    pub(crate) origin: [u32; 3],
    /// It spans 2^level finest cells along each axis.
    pub(crate) level: u8,
    /// Its number among the cells that the surface cuts, or [`NONE`].
    pub(crate) cut: u32,
    /// Its nodes.
    pub(crate) corners: [u32; CORNERS],
}

/// A cell that the surface cuts or touches.
#[derive(Debug, Clone)]
pub(crate) struct CutCell {
    /// The part of the cell inside; none if all of it is.
    pub(crate) inside: Option<Box<[f32; CELL_PARTS]>>,
    /// Its surface elements: a range of [`Grid::surface`].
    pub(crate) surface: [u32; 2],
}

/// The value of a node as a mean of values of free nodes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Term {
    /// Number of the free node.
    pub(crate) free: u32,
    pub(crate) weight: f32,
}

/// The octree of a body.
#[derive(Debug)]
pub(crate) struct Grid {
    pub(crate) lattice: Lattice,
    pub(crate) cells: Vec<Cell>,
    pub(crate) cut_cells: Vec<CutCell>,
    /// The cell of each finest cell, or [`NONE`] outside.
    cell_of: Vec<u32>,
    /// Surface elements, by cut cell.
    pub(crate) surface: Vec<SurfaceElement>,
    /// The terms of node k are `terms[term_starts[k]..term_starts[k + 1]]`.
    term_starts: Vec<u32>,
    terms: Vec<Term>,
    /// Number of free nodes.
    pub(crate) free_count: usize,
}

impl Grid {
    /// Divides a body into cells of at most `step_m` at its surface.
    pub(crate) fn new(body: &dyn Body, step_m: f64, shift: DVec3) -> Self {
        let lattice = Lattice::around(body, step_m, shift);
        let mut inside = vec![None; lattice.cell_count()];
        let mut state = vec![Finest::Empty; lattice.cell_count()];
        for (column, cells) in coverage(body, &lattice).into_iter().enumerate() {
            for (iz, coverage) in cells {
                let index = column * lattice.counts[2] + iz;
                state[index] = match coverage {
                    Coverage::Whole => Finest::Whole,
                    Coverage::Parts(parts) => {
                        inside[index] = Some(parts);
                        Finest::Cut
                    }
                };
            }
        }
        let is_empty = |cell: usize| state[cell] == Finest::Empty;
        let (surface, elements_of) = sorted_by_cell(surface(body, &lattice), &lattice, &is_empty);
        let mut is_whole: Vec<bool> = state.iter().map(|state| *state == Finest::Whole).collect();
        for &(index, _) in &elements_of {
            // A cell that the surface only touches may be inside or outside.
            if state[index] == Finest::Empty {
                inside[index] = Some(Box::new([0.0; CELL_PARTS]));
            }
            state[index] = Finest::Cut;
            is_whole[index] = false;
        }
        let levels = levels(&lattice, is_whole);
        let mut cells = Vec::new();
        let mut cut_cells = Vec::new();
        let mut cell_of = vec![NONE; lattice.cell_count()];
        let mut elements = elements_of.into_iter().peekable();
        for index in 0..lattice.cell_count() {
            let place = lattice.cell(index);
            let width = 1 << levels[index];
            let is_origin = place.iter().all(|k| k % width == 0);
            if state[index] == Finest::Empty || !is_origin {
                continue;
            }
            let cut = if state[index] == Finest::Cut {
                let surface = elements.next_if(|(cell, _)| *cell == index).map_or([0, 0], |(_, range)| range);
                cut_cells.push(CutCell { inside: inside[index].take(), surface });
                number(cut_cells.len() - 1)
            } else {
                NONE
            };
            let cell = number(cells.len());
            for x in place[0]..place[0] + width {
                for y in place[1]..place[1] + width {
                    let start = lattice.index([x, y, place[2]]);
                    cell_of[start..start + width].fill(cell);
                }
            }
            cells.push(Cell { origin: place.map(number), level: levels[index], cut, corners: [NONE; CORNERS] });
        }
        let Nodes { term_starts, terms, free_count } = number_nodes(&lattice, &mut cells);
        Self { lattice, cells, cut_cells, cell_of, surface, term_starts, terms, free_count }
    }

    /// Number of nodes, free or not.
    pub(crate) fn node_count(&self) -> usize {
        self.term_starts.len() - 1
    }

    /// The value of a node in terms of free nodes.
    #[inline]
    pub(crate) fn terms(&self, node: u32) -> &[Term] {
        let node = node as usize;
        &self.terms[self.term_starts[node] as usize..self.term_starts[node + 1] as usize]
    }

    /// The cells at the surface, with the indices of their surface elements.
    pub(crate) fn surface_cells(&self) -> impl Iterator<Item = (&Cell, Range<usize>)> {
        self.numbered_surface_cells().map(|(number, elements)| (&self.cells[number], elements))
    }

    /// The numbers of the cells at the surface, with the indices of their surface elements.
    pub(crate) fn numbered_surface_cells(&self) -> impl Iterator<Item = (usize, Range<usize>)> {
        self.cells.iter().enumerate().filter(|(_, cell)| cell.cut != NONE).map(|(number, cell)| {
            let [start, end] = self.cut_cells[cell.cut as usize].surface;
            (number, start as usize..end as usize)
        })
    }

    /// Size of a cell, in m.
    pub(crate) fn cell_size(&self, cell: &Cell) -> DVec3 {
        self.lattice.step * f64::from(1u32 << cell.level)
    }

    /// Centre of a cell, in m.
    pub(crate) fn cell_centre(&self, cell: &Cell) -> DVec3 {
        let [x, y, z] = cell.origin.map(f64::from);
        self.lattice.low + self.lattice.step * DVec3::new(x, y, z) + 0.5 * self.cell_size(cell)
    }

    /// The cell that holds a point, with the point's coordinates within it; none outside of all cells.
    #[inline]
    pub(crate) fn find(&self, point: DVec3) -> Option<(&Cell, [f32; 3])> {
        let cell = &self.cells[self.number_at(point)?];
        Some((cell, self.within(cell, point)))
    }

    /// The number of the cell at a point, in m; none outside.
    #[inline]
    pub(crate) fn number_at(&self, point: DVec3) -> Option<usize> {
        let number = self.cell_of[self.lattice.index(self.lattice.cell_at(point))];
        (number != NONE).then_some(number as usize)
    }

    /// Coordinates of a point within a cell, between 0 and 1.
    #[inline]
    pub(crate) fn within(&self, cell: &Cell, point: DVec3) -> [f32; 3] {
        let place = (point - self.lattice.low) / self.lattice.step;
        let width = f64::from(1u32 << cell.level);
        #[expect(clippy::cast_possible_truncation, reason = "rounding is intended")]
        std::array::from_fn(|k| ((place[k] - f64::from(cell.origin[k])) / width).clamp(0.0, 1.0) as f32)
    }
}

/// A finest cell, before cells are merged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Finest {
    /// Outside.
    Empty,
    /// Inside, and away from the surface.
    Whole,
    /// At the surface.
    Cut,
}

/// Sorts surface elements by the finest cell that holds them, and gives the range of each cell that has any.
fn sorted_by_cell(
    elements: Vec<SurfaceElement>,
    lattice: &Lattice,
    is_empty: &dyn Fn(usize) -> bool,
) -> (Vec<SurfaceElement>, Vec<(usize, [u32; 2])>) {
    let cell = |element: &SurfaceElement| {
        let inward = element.normal.as_dvec3() * lattice.step;
        let cells = INWARD.map(|steps| lattice.index(lattice.cell_at(element.point.as_dvec3() - inward * steps)));
        cells.into_iter().find(|cell| !is_empty(*cell)).unwrap_or(cells[0])
    };
    let mut keyed: Vec<(usize, SurfaceElement)> =
        elements.into_iter().map(|element| (cell(&element), element)).collect();
    keyed.sort_by_key(|(cell, _)| *cell);
    let mut ranges: Vec<(usize, [u32; 2])> = Vec::new();
    for (place, (cell, _)) in keyed.iter().enumerate() {
        match ranges.last_mut() {
            Some((last, range)) if last == cell => range[1] = number(place + 1),
            _ => ranges.push((*cell, [number(place), number(place + 1)])),
        }
    }
    (keyed.into_iter().map(|(_, element)| element).collect(), ranges)
}

/// The level of the cell that covers each finest cell.
fn levels(lattice: &Lattice, is_whole: Vec<bool>) -> Vec<u8> {
    let mut levels = vec![0; is_whole.len()];
    let (mut counts, mut mergeable) = (lattice.counts, is_whole);
    for level in 1..=MOST_LEVELS {
        let inner = eroded(&mergeable, counts);
        let coarse = counts.map(|count| count / 2);
        let mut merged = vec![false; coarse.iter().product()];
        let mut any = false;
        for (index, merged) in merged.iter_mut().enumerate() {
            let [x, y, z] = [index / (coarse[1] * coarse[2]), index / coarse[2] % coarse[1], index % coarse[2]];
            *merged = (0..CORNERS).all(|corner| {
                let [x, y, z] = [2 * x + (corner & 1), 2 * y + (corner >> 1 & 1), 2 * z + (corner >> 2)];
                inner[(x * counts[1] + y) * counts[2] + z]
            });
            any |= *merged;
        }
        if !any {
            break;
        }
        for (index, of_cell) in levels.iter_mut().enumerate() {
            let [x, y, z] = lattice.cell(index).map(|k| k >> level);
            let is_within = x < coarse[0] && y < coarse[1] && z < coarse[2];
            if is_within && merged[(x * coarse[1] + y) * coarse[2] + z] {
                *of_cell = u8::try_from(level).unwrap_or(u8::MAX);
            }
        }
        (counts, mergeable) = (coarse, merged);
    }
    levels
}

/// The cells whose neighbours within [`RING`] cells are all marked.
fn eroded(marked: &[bool], counts: [usize; 3]) -> Vec<bool> {
    let strides = [counts[1] * counts[2], counts[2], 1];
    let mut eroded = marked.to_vec();
    for axis in 0..3 {
        let (stride, count) = (strides[axis], counts[axis]);
        let before = eroded;
        let kept = |index: usize| {
            let place = index / stride % count;
            place >= RING
                && place + RING < count
                && (index - RING * stride..=index + RING * stride).step_by(stride).all(|other| before[other])
        };
        eroded = (0..before.len()).map(kept).collect();
    }
    eroded
}

struct Nodes {
    term_starts: Vec<u32>,
    terms: Vec<Term>,
    free_count: usize,
}

/// The corners of edges and faces of a cell, and the offset of the middle of each from the cell's origin in half cells.
fn edges_and_faces() -> Vec<([usize; 3], Vec<usize>)> {
    let corner = |at: [usize; 3]| at[0] | at[1] << 1 | at[2] << 2;
    let mut middles = Vec::with_capacity(18);
    for place in 0..27 {
        let at = [place / 9, place / 3 % 3, place % 3];
        let free: Vec<usize> = (0..3).filter(|k| at[*k] == 1).collect();
        if free.is_empty() || free.len() == 3 {
            continue;
        }
        let ends = (0..1 << free.len()).map(|bits: usize| {
            let mut end = at.map(|k| k / 2);
            free.iter().enumerate().for_each(|(bit, k)| end[*k] = bits >> bit & 1);
            corner(end)
        });
        middles.push((at, ends.collect()));
    }
    middles
}

/// Numbers the nodes of all cells and finds those that hang on a larger cell.
fn number_nodes(lattice: &Lattice, cells: &mut [Cell]) -> Nodes {
    let [_, ny, nz] = lattice.counts.map(|count| count + 1);
    let key = |[x, y, z]: [usize; 3]| (x * ny + y) * nz + z;
    let mut numbers = vec![NONE; lattice.counts.iter().map(|count| count + 1).product()];
    let corner_key = |cell: &Cell, corner: usize| {
        let width = 1 << cell.level;
        key(std::array::from_fn(|k| cell.origin[k] as usize + (corner >> k & 1) * width))
    };
    for cell in cells.iter() {
        (0..CORNERS).for_each(|corner| numbers[corner_key(cell, corner)] = 0);
    }
    let mut count = 0;
    for number in numbers.iter_mut().filter(|number| **number != NONE) {
        *number = count;
        count += 1;
    }
    for cell in cells.iter_mut() {
        cell.corners = std::array::from_fn(|corner| numbers[corner_key(cell, corner)]);
    }
    let mut parents: Vec<Vec<u32>> = vec![Vec::new(); count as usize];
    // Nodes that hang on larger cells come first, since others may hang on them.
    let mut hanging = Vec::new();
    let middles = edges_and_faces();
    for level in (1..=MOST_LEVELS).rev() {
        for cell in cells.iter().filter(|cell| usize::from(cell.level) == level) {
            let half = 1 << (level - 1);
            for (at, ends) in &middles {
                let node = numbers[key(std::array::from_fn(|k| cell.origin[k] as usize + at[k] * half))];
                if node != NONE && parents[node as usize].is_empty() {
                    parents[node as usize] = ends.iter().map(|end| cell.corners[*end]).collect();
                    hanging.push(node);
                }
            }
        }
    }
    let mut expansions: Vec<Vec<Term>> = vec![Vec::new(); count as usize];
    let mut free_count = 0;
    for (node, parents) in parents.iter().enumerate() {
        if parents.is_empty() {
            expansions[node].push(Term { free: number(free_count), weight: 1.0 });
            free_count += 1;
        }
    }
    for node in hanging {
        let parents = &parents[node as usize];
        let share = (parents.len() as f32).recip();
        let mut terms: Vec<Term> = Vec::new();
        for parent in parents {
            for term in &expansions[*parent as usize] {
                let weight = share * term.weight;
                match terms.iter_mut().find(|one| one.free == term.free) {
                    Some(one) => one.weight += weight,
                    None => terms.push(Term { weight, ..*term }),
                }
            }
        }
        expansions[node as usize] = terms;
    }
    let mut term_starts = Vec::with_capacity(count as usize + 1);
    let mut terms = Vec::new();
    for expansion in expansions {
        term_starts.push(number(terms.len()));
        terms.extend(expansion);
    }
    term_starts.push(number(terms.len()));
    Nodes { term_starts, terms, free_count }
}

/// A count as a 32-bit number.
#[expect(clippy::cast_possible_truncation, reason = "a lattice has fewer than 2^31 cells")]
fn number(count: usize) -> u32 {
    count as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{Ball, BoxBody};

    #[test]
    fn cells_cover_the_body_and_neighbours_differ_by_one_level() {
        let body = BoxBody::aligned(DVec3::ZERO, DVec3::new(1.0, 0.9, 0.8));
        let grid = Grid::new(&body, 0.02, DVec3::ZERO);
        let volume: f64 = grid.cells.iter().map(|cell| grid.cell_size(cell).to_array().iter().product::<f64>()).sum();
        assert!((volume / 0.72 - 1.0).abs() < 1e-9, "{volume}");
        assert!(grid.cells.iter().any(|cell| cell.level >= 2));
        assert!(grid.free_count < 50 * 45 * 40 * 6 / 10, "{}", grid.free_count);
        let counts = grid.lattice.counts;
        for index in 0..grid.lattice.cell_count() {
            let place = grid.lattice.cell(index);
            let level = |place| grid.cells[grid.cell_of[grid.lattice.index(place)] as usize].level;
            for k in 0..3 {
                let mut next = place;
                next[k] += 1;
                assert!(next[k] >= counts[k] || level(place).abs_diff(level(next)) <= 1);
            }
        }
    }

    #[test]
    fn hanging_nodes_reproduce_linear_functions() {
        let ball = Ball { centre: DVec3::ZERO, radius: 0.5 };
        let grid = Grid::new(&ball, 0.02, DVec3::new(0.3, 0.2, 0.4));
        let (mut free, mut nodes) = (vec![DVec3::NAN; grid.free_count], vec![DVec3::NAN; grid.node_count()]);
        for cell in &grid.cells {
            for corner in 0..CORNERS {
                let at = DVec3::from_array(std::array::from_fn(|k| {
                    f64::from(cell.origin[k] + number((corner >> k & 1) << cell.level))
                }));
                nodes[cell.corners[corner] as usize] = at;
                if let [Term { free: number, .. }] = grid.terms(cell.corners[corner]) {
                    free[*number as usize] = at;
                }
            }
        }
        let mut hanging = 0;
        for (node, at) in nodes.iter().enumerate() {
            let terms = grid.terms(number(node));
            hanging += usize::from(terms.len() > 1);
            let mean: DVec3 = terms.iter().map(|term| free[term.free as usize] * f64::from(term.weight)).sum();
            assert!((mean - *at).length() < 1e-4, "{mean} {at}");
        }
        assert!(hanging > 100, "{hanging}");
    }
}
