//! The lattice of cells about a carved solid, and the few cells among them that its surface passes through.

use std::cell::OnceCell;

use glam::{DVec3, UVec3};
use rayon::prelude::*;
use snowblue_base::narrow;

use super::patches::CORNERS;
use super::snow::Carved;

/// Greatest number of cells in the six sides of the lattice. It limits the surface of simple solids, and thereby time
/// and memory. It limits the number of all cells to 6·10⁸.
const MAX_OUTER_CELLS: f64 = 4_194_304.0;
/// Number of cells along a group. In a group, only the solids near it count.
const GROUP: u32 = 16;
/// Number of points along a group.
const POINTS: u32 = GROUP + 1;
/// Number of cells along a block that is searched cell by cell.
const BLOCK: u32 = 2;

/// A lattice of cubes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lattice {
    origin: DVec3,
    /// Length of a cell's edges, in m.
    pub(super) cell_m: f64,
    /// Number of cells along each axis.
    cells: UVec3,
}

/// The cells that the surface of carved snow passes through.
#[derive(Debug)]
pub(super) struct Surface {
    /// The cells, in order.
    pub(super) cells: Vec<SurfaceCell>,
    /// The snow of each group of cells.
    pub(super) groups: Vec<Carved>,
}

/// A cell that the surface passes through.
#[derive(Debug, Clone, Copy)]
pub(super) struct SurfaceCell {
    /// Its place in the lattice.
    pub(super) at: UVec3,
    /// The index of its group.
    pub(super) group: usize,
    /// The distances at its corners, in m.
    pub(super) distances_m: [f32; CORNERS],
}

impl Lattice {
    /// The lattice about a box, with cells of a size.
    ///
    /// # Errors
    ///
    /// With the least size that fits, in m, when the cells are too many.
    pub(super) fn new([low, high]: [DVec3; 2], cell_m: f64) -> Result<Self, f64> {
        let extent = high - low;
        if outer_cells(extent, cell_m) <= MAX_OUTER_CELLS {
            // The points lie half a cell off the box, so that sides of the box that are whole numbers of cells long
            // lie between points.
            let origin = low - 1.5 * cell_m;
            return Ok(Self { origin, cell_m, cells: cells(extent, cell_m).as_uvec3() });
        }
        let mut least_m = cell_m;
        while outer_cells(extent, least_m) > MAX_OUTER_CELLS {
            least_m *= 1.01;
        }
        Err(least_m)
    }

    /// A point of the lattice.
    pub(super) fn point(&self, at: UVec3) -> DVec3 {
        self.origin + self.cell_m * at.as_dvec3()
    }

    /// The cells that the surface of carved snow passes through.
    pub(super) fn surface(&self, carved: &Carved) -> Surface {
        let mut side = self.cells.max_element().max(GROUP).next_power_of_two();
        let mut blocks = vec![UVec3::ZERO];
        while side > GROUP {
            side /= 2;
            blocks = blocks.par_iter().flat_map_iter(|block| self.blocks_near_surface(*block, side, carved)).collect();
        }
        let groups: Vec<Carved> = blocks.par_iter().map(|block| self.snow_near(*block, carved)).collect();
        let of_group = |(group, block): (usize, &UVec3)| self.search(*block, (group, &groups[group]), carved);
        let mut cells: Vec<_> = blocks.par_iter().enumerate().flat_map_iter(of_group).collect();
        cells.par_sort_unstable_by_key(SurfaceCell::key);
        Surface { cells, groups }
    }

    /// The snow that counts in a group of cells and within a cell around it.
    fn snow_near(&self, group: UVec3, carved: &Carved) -> Carved {
        let half_m = 0.5 * self.cell_m * f64::from(GROUP);
        carved.near(self.point(group) + half_m, half_m * 3f64.sqrt() + self.cell_m)
    }

    /// The blocks that the surface may pass through, among the eight blocks of `side` cells within a block.
    fn blocks_near_surface(&self, block: UVec3, side: u32, carved: &Carved) -> impl Iterator<Item = UVec3> {
        let blocks = (0..8).map(move |half| block + side * corner(half));
        blocks.filter(move |block| block.cmplt(self.cells).all() && self.may_hold_surface(*block, side, carved))
    }

    /// Whether the surface may pass through a block of cells. If the surface is farther from the centre of the block
    /// than the corners are, all distances in the block have the sign of the distance at the centre.
    fn may_hold_surface(&self, block: UVec3, side: u32, carved: &Carved) -> bool {
        let half_m = 0.5 * self.cell_m * f64::from(side);
        // Rounding, and the omission of distant solids, change distances by less than the margin.
        let margin_m = 1e-6 * (self.cell_m + carved.rounding_m);
        let reach_m = half_m * 3f64.sqrt() + carved.greatest_relief_m() + margin_m;
        carved.smooth_distance_m(self.point(block) + half_m).abs() <= reach_m
    }

    /// The cells of a group that the surface passes through, from its number and its snow.
    ///
    /// The distance of a point is computed with the snow of the group whose lowest corner is next to the point, so
    /// that all cells around the point agree on which side of the surface the point lies.
    fn search(&self, origin: UVec3, (group, own): (usize, &Carved), carved: &Carved) -> Vec<SurfaceCell> {
        let next_groups = [const { OnceCell::new() }; CORNERS];
        let snow_at = |at: UVec3| match (0..CORNERS).rfind(|number| (at - origin).cmpge(GROUP * corner(*number)).all())
        {
            None | Some(0) => own,
            Some(number) => next_groups[number].get_or_init(|| self.snow_near(origin + GROUP * corner(number), carved)),
        };
        let (mut side, mut blocks) = (GROUP, vec![origin]);
        while side > BLOCK {
            side /= 2;
            blocks = blocks.iter().flat_map(|block| self.blocks_near_surface(*block, side, own)).collect();
        }
        let cube = |side: u32| (0..side.pow(3)).map(move |k| UVec3::new(k % side, k / side % side, k / side / side));
        let number = |at: UVec3| at.dot(UVec3::new(1, POINTS, POINTS * POINTS)) as usize;
        // The distances of the group's points, where they are known.
        let mut distances_m = vec![f32::NAN; number(UVec3::splat(GROUP)) + 1];
        let mut found = Vec::new();
        for block in blocks {
            for at in cube(BLOCK + 1).map(|at| block + at) {
                let distance_m = &mut distances_m[number(at - origin)];
                if distance_m.is_nan() {
                    *distance_m = narrow(snow_at(at).distance_m(self.point(at)));
                }
            }
            let cells = cube(BLOCK).map(|at| block + at).map(|at| {
                let distances_m = std::array::from_fn(|k| distances_m[number(at - origin + corner(k))]);
                SurfaceCell { at, group, distances_m }
            });
            found.extend(cells.filter(|cell| !matches!(cell.inside(), 0 | 255)));
        }
        found
    }
}

impl SurfaceCell {
    /// Its number in the order of cells.
    pub(super) fn key(&self) -> u64 {
        key(self.at)
    }

    /// Which of its corners are inside, as bits.
    pub(super) fn inside(&self) -> u8 {
        self.distances_m.iter().rev().fold(0, |bits, distance_m| bits << 1 | u8::from(*distance_m < 0.0))
    }
}

/// The number of a place in the order of cells. A lattice is at most 2¹⁹ cells long.
pub(super) fn key(at: UVec3) -> u64 {
    u64::from(at.z) << 42 | u64::from(at.y) << 21 | u64::from(at.x)
}

/// The place of a corner in its cell.
pub(super) fn corner(number: usize) -> UVec3 {
    UVec3::from([0, 1, 2].map(|axis| u32::from(number >> axis & 1 == 1)))
}

/// Numbers of cells along a box, with room for the surface on all sides.
fn cells(extent: DVec3, cell_m: f64) -> DVec3 {
    (extent / cell_m).ceil() + 3.0
}

fn outer_cells(extent: DVec3, cell_m: f64) -> f64 {
    let cells = cells(extent, cell_m);
    2.0 * cells.dot(DVec3::new(cells.y, cells.z, cells.x))
}
