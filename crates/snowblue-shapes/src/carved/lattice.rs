//! The lattice of cells about a carved solid, and the few cells among them that its surface passes through.

use glam::{DVec3, UVec3};
use rayon::prelude::*;
use snowblue_geometry::ray::narrow;

use super::patches::CORNERS;
use super::snow::Carved;

/// Most cells in the six sides of the lattice. It bounds the surface of simple solids, and with it time and memory, and
/// all cells to 6·10⁸.
const MOST_OUTER_CELLS: f64 = 4_194_304.0;
/// Number of cells along a block that is searched cell by cell.
const BLOCK: u32 = 4;
/// Number of points along such a block.
const POINTS: u32 = BLOCK + 1;

/// A lattice of cubes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lattice {
    origin: DVec3,
    /// Length of a cell's edges, in m.
    pub(super) cell_m: f64,
    /// Number of cells along each axis.
    cells: UVec3,
}

/// A cell that the surface passes through.
#[derive(Debug, Clone, Copy)]
pub(super) struct SurfaceCell {
    /// Its place in the lattice.
    pub(super) at: UVec3,
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
        if outer_cells(extent, cell_m) <= MOST_OUTER_CELLS {
            // By half a cell off the box: sides of the box that are whole numbers of cells long lie between points.
            let origin = low - 1.5 * cell_m;
            return Ok(Self { origin, cell_m, cells: cells(extent, cell_m).as_uvec3() });
        }
        let mut least_m = cell_m;
        while outer_cells(extent, least_m) > MOST_OUTER_CELLS {
            least_m *= 1.01;
        }
        Err(least_m)
    }

    /// A point of the lattice.
    pub(super) fn point(&self, at: UVec3) -> DVec3 {
        self.origin + self.cell_m * at.as_dvec3()
    }

    /// The cells that the surface of a solid passes through, in order.
    pub(super) fn surface_cells(&self, carved: &Carved) -> Vec<SurfaceCell> {
        let mut side = self.cells.max_element().max(BLOCK).next_power_of_two();
        let mut blocks = vec![UVec3::ZERO];
        while side > BLOCK {
            side /= 2;
            let halves = |block: &UVec3| (0..8).map(|half| block + side * corner(half)).collect::<Vec<_>>();
            let is_near = |block: &UVec3| block.cmplt(self.cells).all() && self.may_hold_surface(*block, side, carved);
            blocks = blocks.par_iter().flat_map_iter(halves).filter(is_near).collect();
        }
        let mut found: Vec<_> = blocks.par_iter().flat_map_iter(|block| self.search(*block, carved)).collect();
        found.par_sort_unstable_by_key(SurfaceCell::key);
        found
    }

    /// Whether the surface may pass through a block of cells. Farther from its centre than its corners are, distances
    /// have the sign of that at the centre.
    fn may_hold_surface(&self, block: UVec3, side: u32, carved: &Carved) -> bool {
        let half_m = 0.5 * self.cell_m * f64::from(side);
        // Rounding moves distances by far less than the margin.
        let reach_m = half_m * 3f64.sqrt() + carved.greatest_relief_m() + 1e-6 * self.cell_m;
        carved.smooth_distance_m(self.point(block) + half_m).abs() <= reach_m
    }

    /// The cells of a block that the surface passes through.
    fn search(&self, block: UVec3, carved: &Carved) -> Vec<SurfaceCell> {
        let number = |at: UVec3| ((at.z * POINTS + at.y) * POINTS + at.x) as usize;
        let points = (0..POINTS.pow(3)).map(|k| UVec3::new(k % POINTS, k / POINTS % POINTS, k / POINTS / POINTS));
        let distances_m: Vec<f32> = points.map(|at| narrow(carved.distance_m(self.point(block + at)))).collect();
        let places = (0..BLOCK.pow(3)).map(|k| UVec3::new(k % BLOCK, k / BLOCK % BLOCK, k / BLOCK / BLOCK));
        let cells = places.map(|at| SurfaceCell {
            at: block + at,
            distances_m: std::array::from_fn(|k| distances_m[number(at + corner(k))]),
        });
        cells.filter(|cell| !matches!(cell.inside(), 0 | 255)).collect()
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
