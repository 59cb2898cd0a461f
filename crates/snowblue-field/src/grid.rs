//! The grid of a body: an octree of cells, finest at the surface.
//!
//! Cells that the surface cuts have the finest size, or sizes by a rule ([`crate::sizes`]). The width of a cell far
//! inside is about a third of its distance to the surface: light that varies on a shorter scale does not reach that
//! depth. Neighbouring cells differ by one level at most. A node on an edge or face of a larger cell takes the mean of
//! the corners of that edge or face.
//!
//! Memory grows with the surface area: no array covers all finest cells.

use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::body::{Body, Scanner};
use crate::cut_cells::{CutCells, INWARD};
use crate::element::{CELL_PARTS, CORNERS};
use crate::lattice::Lattice;
use crate::octree::{Leaf, NONE, Octree, key};
use crate::scan::SurfaceElement;
use crate::sizes::{CellSizes, LINES, demands};

/// Greatest depth to which a body may reach into a cell without crossing a line, as a fraction of the cell: half the
/// spacing of the lines that measure its volume, and a little more.
const SLIVER: f64 = 0.13;

/// How a body is divided into cells.
#[derive(Debug, Clone, Copy)]
pub struct GridOptions<'r> {
    /// Greatest size of the finest cells, in m.
    pub step_m: f64,
    /// Shift of the grid along each axis, as a fraction of a cell from 0 to 1. The light must not depend on the shift.
    pub shift: DVec3,
    /// Rule by which cells at the surface may be larger; without a rule, all of them have the finest size.
    pub sizes: Option<&'r dyn CellSizes>,
}

/// A cell of the octree.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cell {
    /// The finest cell at its corner of least coordinates.
    pub(crate) origin: [u32; 3],
    /// It spans 2^level finest cells along each axis.
    pub(crate) level: u8,
    /// Its number among the cells that the surface cuts, or [`NONE`].
    pub(crate) cut: u32,
    /// The nodes at its corners.
    pub(crate) corners: [u32; CORNERS],
}

/// A cell that the surface cuts or touches.
#[derive(Debug, Clone)]
pub(crate) struct CutCell {
    /// The fraction of each part of the cell that is inside the body; none if the whole cell is inside.
    pub(crate) inside: Option<Box<[f32; CELL_PARTS]>>,
    /// Its surface elements: a range of [`Grid::surface`].
    pub(crate) surface: [u32; 2],
}

/// A place on the surface of a body, for repeated reads of values.
#[derive(Debug, Clone, Copy)]
pub struct SurfacePlace {
    /// The number of the cell.
    pub(crate) cell: u32,
    /// Coordinates within the cell, between 0 and 1.
    pub(crate) at: [f32; 3],
    /// Outward unit normal of the surface.
    pub(crate) normal: Vec3,
}

/// A term of the value of a node, which is a weighted mean of the values of free nodes.
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
    octree: Octree,
    /// Surface elements, by cut cell.
    pub(crate) surface: Vec<SurfaceElement>,
    /// Thickness of the snow below each surface element, along the normal of the element, in m.
    pub(crate) thickness_m: Vec<f32>,
    /// The terms of node k are `terms[term_starts[k]..term_starts[k + 1]]`.
    term_starts: Vec<u32>,
    terms: Vec<Term>,
    /// Number of free nodes.
    pub(crate) free_count: usize,
}

impl Grid {
    /// Divides a body into cells.
    pub(crate) fn new(body: &dyn Body, options: GridOptions) -> Self {
        let lattice = Lattice::around(body, options.step_m, options.shift);
        let (mut octree, leaves, cut) = if let Some(sizes) = options.sizes {
            let demands = demands(body, &lattice, sizes);
            let (octree, leaves) = Octree::new(&lattice, &demands);
            let cut = CutCells::of_octree(body, &lattice, &octree, &leaves);
            (octree, leaves, cut)
        } else {
            let cut = CutCells::finest(body, &lattice);
            let (octree, leaves) = Octree::new(&lattice, &[cut.keys()]);
            (octree, leaves, cut)
        };
        let mut leaves: Vec<(u64, Leaf)> = leaves.into_iter().map(|leaf| (key(leaf.origin()), leaf)).collect();
        leaves.par_sort_unstable_by_key(|(key, _)| *key);
        let CutCells { cells: cuts, surface, thickness_m } = cut;
        let is_cut: Vec<bool> =
            leaves.iter().map(|(key, _)| cuts.binary_search_by_key(key, |cell| cell.key).is_ok()).collect();
        let uncut = leaves.iter().zip(&is_cut).filter(|(_, is_cut)| !**is_cut).map(|((_, leaf), _)| *leaf);
        let mut is_inside = inside(body, &lattice, &uncut.collect::<Vec<Leaf>>()).into_iter();
        let (mut cells, mut cut_cells) = (Vec::new(), Vec::with_capacity(cuts.len()));
        let mut cuts = cuts.into_iter();
        for ((_, leaf), is_cut) in leaves.iter().zip(is_cut) {
            let mut cut = NONE;
            if is_cut {
                cut = number(cut_cells.len());
                cut_cells.extend(cuts.next().map(|cell| CutCell { inside: cell.inside, surface: cell.surface }));
            } else if is_inside.next() != Some(true) {
                continue;
            }
            octree.set_cell(leaf, number(cells.len()));
            cells.push(Cell { origin: leaf.origin(), level: leaf.level, cut, corners: [NONE; CORNERS] });
        }
        let Nodes { term_starts, terms, free_count } = number_nodes(&mut cells);
        Self { lattice, cells, cut_cells, octree, surface, thickness_m, term_starts, terms, free_count }
    }

    /// Number of nodes, free or not.
    pub(crate) fn node_count(&self) -> usize {
        self.term_starts.len() - 1
    }

    /// Memory, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let parts = self.cut_cells.iter().filter(|cell| cell.inside.is_some()).count() * size_of::<[f32; CELL_PARTS]>();
        parts
            + size_of_val(&*self.cells)
            + size_of_val(&*self.cut_cells)
            + size_of_val(&*self.surface)
            + size_of_val(&*self.thickness_m)
            + size_of_val(&*self.terms)
            + size_of_val(&*self.term_starts)
            + self.octree.bytes()
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
        let cells = self.cells.iter().enumerate().filter(|(_, cell)| cell.cut != NONE);
        cells.map(|(number, cell)| (number, self.elements(cell)))
    }

    /// The indices of the surface elements of a cell.
    pub(crate) fn elements(&self, cell: &Cell) -> Range<usize> {
        let [start, end] = self.cut_cells.get(cell.cut as usize).map_or([0; 2], |cut| cut.surface);
        start as usize..end as usize
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

    /// The number of the cell at a point, in m; none outside.
    #[inline]
    pub(crate) fn number_at(&self, point: DVec3) -> Option<usize> {
        let number = self.octree.find(self.lattice.cell_at(point)).0;
        (number != NONE).then_some(number as usize)
    }

    /// The cell that holds a point of the body, or the nearest cell, with the point's coordinates within the cell or
    /// on its faces; none further outside.
    ///
    /// Lines miss a part of the body that reaches into a cell by less than [`SLIVER`] of the cell. The grid then lacks
    /// this cell.
    #[inline]
    pub(crate) fn find_inside(&self, point: DVec3) -> Option<(&Cell, [f32; 3])> {
        let cell = &self.cells[self.number_at(point).or_else(|| self.number_beside(point))?];
        Some((cell, self.within(cell, point)))
    }

    /// The number of a cell next to a point that lies in a cell that the grid lacks; none if the distance exceeds
    /// [`SLIVER`] of the lacking cell.
    #[cold]
    fn number_beside(&self, point: DVec3) -> Option<usize> {
        let (_, level) = self.octree.find(self.lattice.cell_at(point));
        let reach = self.lattice.step * (SLIVER * f64::from(1u32 << level));
        let offset = |place: i32| [place / 9 - 1, place / 3 % 3 - 1, place % 3 - 1];
        // Across faces first, then across edges and corners.
        (1..=3).find_map(|axes: usize| {
            let offsets = (0..27).map(offset).filter(|offset| offset.iter().filter(|step| **step != 0).count() == axes);
            offsets
                .map(|offset| DVec3::from_array(offset.map(f64::from)))
                .find_map(|offset| self.number_at(point + offset * reach))
        })
    }

    /// The place of a point of the surface, in m, with an outward unit normal; none if there is no cell within a step
    /// of the point.
    #[inline]
    pub(crate) fn find_at_surface(&self, point: DVec3, normal: DVec3) -> Option<SurfacePlace> {
        let (_, level) = self.octree.find(self.lattice.cell_at(point));
        let step = self.lattice.step * f64::from(1u32 << level);
        INWARD.iter().find_map(|inward| {
            let point = point - normal * step * *inward;
            let cell = self.number_at(point)?;
            Some(SurfacePlace {
                cell: number(cell),
                at: self.within(&self.cells[cell], point),
                normal: normal.as_vec3(),
            })
        })
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

/// Whether each of the given cells, which the surface does not cut, is inside the body.
fn inside(body: &dyn Body, lattice: &Lattice, leaves: &[Leaf]) -> Vec<bool> {
    // One line serves all cells of a column.
    let column = |leaf: &Leaf| (leaf.level, leaf.place[0], leaf.place[1]);
    let mut order: Vec<usize> = (0..leaves.len()).collect();
    order.par_sort_unstable_by_key(|leaf| column(&leaves[*leaf]));
    let columns: Vec<&[usize]> =
        order.chunk_by(|one, other| column(&leaves[*one]) == column(&leaves[*other])).collect();
    let of_column = |scanner: &mut Scanner, members: &[usize]| -> Vec<(usize, bool)> {
        let lattice = lattice.coarsened(leaves[members[0]].level);
        let corner = lattice.corner(leaves[members[0]].place);
        let points = LINES.map(|[x, y]| corner + lattice.step * DVec3::new(x, y, 0.0));
        let segments: Vec<[f64; 2]> = scanner
            .sound_segments(2, points)
            .map(|segment| [segment.enter.coordinate_m, segment.leave.coordinate_m])
            .collect();
        let is_inside = |leaf: usize| {
            let height = lattice.corner(leaves[leaf].place).z + 0.5 * lattice.step.z;
            segments.iter().any(|[enter, leave]| *enter < height && height < *leave)
        };
        members.iter().map(|leaf| (*leaf, is_inside(*leaf))).collect()
    };
    let found: Vec<Vec<(usize, bool)>> = columns.into_par_iter().map_init(|| Scanner::new(body), of_column).collect();
    let mut inside = vec![false; leaves.len()];
    found.into_iter().flatten().for_each(|(leaf, is_inside)| inside[leaf] = is_inside);
    inside
}

struct Nodes {
    term_starts: Vec<u32>,
    terms: Vec<Term>,
    free_count: usize,
}

/// For each edge and face of a cell: the offset of its middle from the cell's origin in half cells, and its corners.
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

/// Numbers the nodes of all cells and finds the nodes that hang on a larger cell.
fn number_nodes(cells: &mut [Cell]) -> Nodes {
    let corner_key = |cell: &Cell, corner: usize| {
        key(std::array::from_fn(|k| cell.origin[k] + (number(corner) >> k & 1) * (1 << cell.level)))
    };
    let mut keys: Vec<u64> =
        cells.par_iter().flat_map_iter(|cell| (0..CORNERS).map(|corner| corner_key(cell, corner))).collect();
    keys.par_sort_unstable();
    keys.dedup();
    let node = |key: u64| keys.binary_search(&key).map_or(NONE, number);
    cells.par_iter_mut().for_each(|cell| {
        cell.corners = std::array::from_fn(|corner| node(corner_key(cell, corner)));
    });
    let count = keys.len();
    let most_levels = cells.iter().map(|cell| cell.level).max().unwrap_or(0);
    let mut parents: Vec<Vec<u32>> = vec![Vec::new(); count];
    // Nodes that hang on larger cells come first, since nodes of smaller cells may hang on them.
    let mut hanging = Vec::new();
    let middles = edges_and_faces();
    for level in (1..=most_levels).rev() {
        for cell in cells.iter().filter(|cell| cell.level == level) {
            let half = 1 << (level - 1);
            for (at, ends) in &middles {
                let node = node(key(std::array::from_fn(|k| cell.origin[k] + number(at[k]) * half)));
                if node != NONE && parents[node as usize].is_empty() {
                    parents[node as usize] = ends.iter().map(|end| cell.corners[*end]).collect();
                    hanging.push(node);
                }
            }
        }
    }
    let mut expansions: Vec<Vec<Term>> = vec![Vec::new(); count];
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
                match terms.iter_mut().find(|known| known.free == term.free) {
                    Some(known) => known.weight += weight,
                    None => terms.push(Term { weight, ..*term }),
                }
            }
        }
        expansions[node as usize] = terms;
    }
    let mut term_starts = Vec::with_capacity(count + 1);
    let mut terms = Vec::new();
    for expansion in expansions {
        term_starts.push(number(terms.len()));
        terms.extend(expansion);
    }
    term_starts.push(number(terms.len()));
    Nodes { term_starts, terms, free_count }
}

/// A count as a 32-bit number.
#[expect(clippy::cast_possible_truncation, reason = "a grid has fewer than 2^31 cells, elements and nodes")]
fn number(count: usize) -> u32 {
    count as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::across;
    use crate::shapes::{Ball, BoxBody, BoxWithHole};
    use crate::sizes::SizesByDistance;
    use glam::{DMat3, EulerRot};

    #[test]
    fn cells_cover_the_body_and_neighbours_differ_by_one_level() {
        let body = BoxBody::aligned(DVec3::ZERO, DVec3::new(1.0, 0.9, 0.8));
        let grid = Grid::new(&body, GridOptions { step_m: 0.02, shift: DVec3::ZERO, sizes: None });
        let volume: f64 = grid.cells.iter().map(|cell| grid.cell_size(cell).to_array().iter().product::<f64>()).sum();
        assert!((volume / 0.72 - 1.0).abs() < 1e-9, "{volume}");
        assert!(grid.cells.iter().any(|cell| cell.level >= 2));
        assert!(grid.free_count < 50 * 45 * 40 * 6 / 10, "{}", grid.free_count);
        assert_is_balanced(&grid);
    }

    /// Every finest cell on the faces of every cell has a neighbour that differs by one level at most.
    fn assert_is_balanced(grid: &Grid) {
        for cell in &grid.cells {
            let width = 1u32 << cell.level;
            for (axis, place) in (0..3).flat_map(|axis| (0..width * width).map(move |place| (axis, place))) {
                let mut beside = cell.origin;
                let [u, v] = across(axis);
                beside[u] += place / width;
                beside[v] += place % width;
                beside[axis] += width;
                if (0..3).all(|k| (beside[k] as usize) < grid.lattice.counts[k]) {
                    let (_, level) = grid.octree.find(beside);
                    assert!(level.abs_diff(cell.level) <= 1, "{cell:?} {beside:?} {level}");
                }
            }
        }
    }

    /// A cell is as wide as the ring of cells around it allows: it has no cell at the surface within 3 (2^level − 1)
    /// finest cells. The next larger cell at its place has a cell at the surface within its ring.
    #[test]
    fn cells_are_as_large_as_their_distance_to_the_surface_allows() {
        let ball = Ball { centre: DVec3::ZERO, radius: 0.6 };
        let grid = Grid::new(&ball, GridOptions { step_m: 0.02, shift: DVec3::new(0.3, 0.2, 0.4), sizes: None });
        let is_inner = |level: u8, place: [u32; 3]| {
            let ring = 3 * ((1i64 << level) - 1);
            let range = |k: usize| {
                let start = i64::from(place[k]) << level;
                start - ring..start + (1i64 << level) + ring
            };
            range(0).all(|x| {
                range(1).all(|y| {
                    range(2).all(|z| {
                        let at = [x, y, z].map(|k| u32::try_from(k).ok());
                        let [Some(x), Some(y), Some(z)] = at else { return false };
                        let is_within = (0..3).all(|k| ([x, y, z][k] as usize) < grid.lattice.counts[k]);
                        is_within
                            && grid
                                .cells
                                .get(grid.octree.find([x, y, z]).0 as usize)
                                .is_some_and(|cell| cell.cut == NONE)
                    })
                })
            })
        };
        assert!(grid.cells.iter().any(|cell| cell.level == 2));
        for cell in grid.cells.iter().filter(|cell| cell.cut == NONE).step_by(23) {
            assert!(cell.level == 0 || is_inner(cell.level, cell.origin.map(|k| k >> cell.level)), "{cell:?}");
            let level = cell.level + 1;
            assert!(!is_inner(level, cell.origin.map(|k| k >> level)), "{cell:?}");
        }
    }

    #[test]
    fn cells_of_a_rule_cover_the_body_and_neighbours_differ_by_one_level() {
        let axes = DMat3::from_euler(EulerRot::XYZ, 0.3, -0.2, 0.8);
        let body = BoxWithHole {
            outer: BoxBody { centre: DVec3::ZERO, size: DVec3::new(4.0, 3.0, 0.8), axes },
            hole_centre: axes * DVec3::Z * 0.4,
            hole_size: DVec3::new(0.1, 0.1, 0.2),
        };
        let viewpoint = axes * DVec3::Z * 0.8;
        let sizes =
            SizesByDistance { viewpoint, sizes_per_distance: [0.02, 0.02, 0.25], greatest_m: 0.4, thin_below_m: 0.1 };
        let grid = Grid::new(&body, GridOptions { step_m: 0.01, shift: DVec3::ZERO, sizes: Some(&sizes) });
        let surface_levels: Vec<u8> = grid.surface_cells().map(|(cell, _)| cell.level).collect();
        assert!(surface_levels.iter().any(|level| *level <= 1) && surface_levels.iter().any(|level| *level >= 4));
        assert_is_balanced(&grid);
        let inside = |cell: &Cell| {
            let parts = grid.cut_cells.get(cell.cut as usize).and_then(|cut| cut.inside.as_ref());
            parts.map_or(1.0, |parts| f64::from(parts.iter().sum::<f32>()) / CELL_PARTS as f64)
        };
        let volume: f64 = grid.cells.iter().map(|cell| grid.cell_size(cell).element_product() * inside(cell)).sum();
        // The lines resolve a cut-off corner to within an eighth of a cell.
        assert!((volume / (4.0 * 3.0 * 0.8 - 0.001) - 1.0).abs() < 2e-3, "{volume}");
        let area: f64 = grid.surface.iter().map(|element| f64::from(element.area_m2)).sum();
        assert!((area / (2.0 * (12.0 + 3.2 + 2.4) + 0.04) - 1.0).abs() < 0.01, "{area}");
    }

    /// Tests points just below the surface of a ball. Some lie where the ball reaches into a cell without crossing a
    /// line.
    #[test]
    fn every_point_of_a_body_has_a_cell_near() {
        let ball = Ball { centre: DVec3::new(0.01, -0.02, 0.03), radius: 0.5 };
        let options = GridOptions { step_m: 0.07, shift: DVec3::new(0.3, 0.2, 0.4), sizes: None };
        let grid = Grid::new(&ball, options);
        let mut without = 0;
        for k in 0..20_000 {
            let number = |factor: f64| (f64::from(k) * factor).fract();
            let (z, turn) = (2.0 * number(0.618_034) - 1.0, std::f64::consts::TAU * number(0.754_878));
            let across = (1.0 - z * z).sqrt();
            let point = ball.centre + 0.499 * DVec3::new(across * turn.cos(), across * turn.sin(), z);
            without += usize::from(grid.number_at(point).is_none());
            assert!(grid.find_inside(point).is_some(), "{point}");
        }
        assert!(without > 10, "{without}");
    }

    #[test]
    fn hanging_nodes_reproduce_linear_functions() {
        let ball = Ball { centre: DVec3::ZERO, radius: 0.5 };
        let grid = Grid::new(&ball, GridOptions { step_m: 0.02, shift: DVec3::new(0.3, 0.2, 0.4), sizes: None });
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
