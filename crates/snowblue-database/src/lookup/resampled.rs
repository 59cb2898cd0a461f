//! Our form: coefficients resampled once on a grid so fine that straight lines are enough, in the thickness and in the
//! angle, and whose cells need no search and no logarithm.
//!
//! The grid is even in the bits of a number: eight cells from each power of two to the next, so that the number's exponent
//! and first three bits of mantissa are the cell's number. Along the thickness h that number is h + 2⁻⁶ cm: cells are
//! 1/8 to 1/16 of the thickness wide in deep snow, 20 µm in the thinnest, and the first starts at no snow. Along the
//! angle θ it is 96° − θ, as transmittance bends towards the horizon: cells are 8° wide near the normal, ½° at 89°.
//!
//! At its nodes the grid has what the table says: the spline over the thickness at each of the table's angles, and
//! between these angles a cubic ([`crate::cubic`]). Straight lines between the nodes add up to .2 % of transmittance and
//! .5 % of the reflectance of thin layers.

use wide::f32x4;

use super::basis::{LANES, Lanes};
use super::splines::{REGISTER, in_registers};
use crate::cubic;
use crate::pca::single;

/// Added to the thickness, in cm: below it cells are even.
pub(super) const THIN_CM: f32 = 0.015_625;
/// From this the angle is taken, in degrees.
const BEYOND_HORIZON_DEG: f32 = 96.0;
/// Bits of mantissa that tell a cell of coefficients.
const COARSE: u32 = 3;
/// Bits of a mantissa.
const MANTISSA: u32 = 23;

/// Coefficients of one quantity of one snow.
#[derive(Debug, Clone)]
pub(super) struct Resampled {
    angles: Cells,
    thicknesses: Cells,
    /// Angles of incidence from which and up to which there are values, in degrees.
    angles_deg: (f32, f32),
    /// Registers that hold the components of one node.
    registers: usize,
    /// [angle][thickness][register]
    nodes: Vec<f32x4>,
}

/// Cells of a grid that is even in the bits of a number above 0.
#[derive(Debug, Clone, Copy)]
struct Cells {
    first: u32,
    count: u32,
    /// Bits of a number that lie behind those of its cell.
    behind: u32,
}

impl Resampled {
    /// Resamples what `at` says of a thickness in cm at each of the table's angles: `count` components, as exact as
    /// single precision goes, from no snow to a cell beyond `most_cm`.
    pub(super) fn new(table_angles_deg: &[f64], most_cm: f32, count: usize, at: impl Fn(usize, f32) -> Lanes) -> Self {
        let angles_deg = (single(table_angles_deg[0]), single(table_angles_deg[table_angles_deg.len() - 1]));
        let mut resampled = Self::empty(angles_deg, most_cm, COARSE, count);
        let heights = resampled.heights_cm();
        let at_angle = |angle| heights.iter().map(|height_cm| at(angle, *height_cm)).collect::<Vec<Lanes>>();
        let at_angles = (0..table_angles_deg.len()).map(at_angle).collect::<Vec<_>>();
        for node_deg in resampled.node_angles_deg() {
            let weights = cubic::weights(table_angles_deg, f64::from(node_deg));
            for (height, _) in heights.iter().enumerate() {
                let mut sums = [0.0; LANES];
                for (angle, weight) in &weights {
                    let values = &at_angles[*angle][height];
                    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * f64::from(*value));
                }
                resampled.nodes.extend(in_registers(&sums.map(single)[..count]));
            }
        }
        resampled
    }

    /// Four numbers at the nodes of a grid whose cells along the thickness are 2⁻ᵇ of those of powers of two, b being `bits`:
    /// what `at` says of a thickness in cm and an angle in degrees.
    pub(super) fn of_four(
        (angles_deg, most_cm): ((f32, f32), f32),
        bits: u32,
        mut at: impl FnMut(f32, f32) -> [f32; REGISTER],
    ) -> Self {
        let mut resampled = Self::empty(angles_deg, most_cm, bits, REGISTER);
        let heights = resampled.heights_cm();
        for node_deg in resampled.node_angles_deg() {
            resampled.nodes.extend(heights.iter().map(|height_cm| f32x4::new(at(*height_cm, node_deg))));
        }
        resampled
    }

    fn empty(angles_deg: (f32, f32), most_cm: f32, bits: u32, count: usize) -> Self {
        let (low, high) = (BEYOND_HORIZON_DEG - angles_deg.1, BEYOND_HORIZON_DEG - angles_deg.0);
        let angles = Cells::covering(low, high, COARSE);
        // One cell more, which lies where the splines have become straight lines, and which goes on for ever.
        let mut thicknesses = Cells::covering(THIN_CM, most_cm + THIN_CM, bits);
        thicknesses.count += 1;
        Self { angles, thicknesses, angles_deg, registers: count.div_ceil(REGISTER), nodes: Vec::new() }
    }

    fn heights_cm(&self) -> Vec<f32> {
        self.thicknesses.nodes().map(|node| node - THIN_CM).collect()
    }

    fn node_angles_deg(&self) -> Vec<f32> {
        self.angles.nodes().map(|node| BEYOND_HORIZON_DEG - node).collect()
    }

    /// The angles of incidence from which and up to which there are values, in degrees.
    pub(super) fn angles_deg(&self) -> (f32, f32) {
        self.angles_deg
    }

    /// The four numbers of a thickness and an angle on a grid of four.
    #[inline]
    pub(super) fn four(&self, thickness_cm: f32, angle_deg: f32) -> f32x4 {
        let ((start, row), (steep, thick)) = self.place(thickness_cm, angle_deg, 1);
        let (grazing, steeper) = (&self.nodes[start..][..2], &self.nodes[start + row..][..2]);
        mixed([grazing[0], grazing[1]], [steeper[0], steeper[1]], (steep, thick))
    }

    /// Where the corners of a cell start, and how far in it the place is: along the angle, along the thickness.
    #[inline]
    fn place(&self, thickness_cm: f32, angle_deg: f32, registers: usize) -> ((usize, usize), (f32, f32)) {
        let (low, high) = self.angles_deg;
        let angle_deg = if angle_deg < low { low } else { angle_deg };
        let angle_deg = if angle_deg > high { high } else { angle_deg };
        let (angle, steep) = self.angles.cell(BEYOND_HORIZON_DEG - angle_deg);
        let (thickness, thick) = self.thicknesses.cell(thickness_cm + THIN_CM);
        let row = (self.thicknesses.count as usize + 1) * registers;
        ((angle * row + thickness * registers, row), (steep, thick))
    }

    /// The components of a thickness and an angle, into `coefficients`; beyond the table's angles those of the nearest.
    #[inline]
    pub(super) fn coefficients(&self, thickness_cm: f32, angle_deg: f32, coefficients: &mut Lanes) {
        let n = self.registers;
        let ((start, row), (steep, thick)) = self.place(thickness_cm, angle_deg, n);
        let (grazing, steeper) = (&self.nodes[start..][..2 * n], &self.nodes[start + row..][..2 * n]);
        for (r, four) in coefficients.chunks_exact_mut(REGISTER).take(n).enumerate() {
            let [grazing, steeper] = [grazing, steeper].map(|nodes| [nodes[r], nodes[n + r]]);
            four.copy_from_slice(&mixed(grazing, steeper, (steep, thick)).to_array());
        }
    }
}

/// On straight lines between the corners of a cell, of which each pair is a thin and a thicker one.
#[inline(always)]
fn mixed(grazing: [f32x4; 2], steeper: [f32x4; 2], (steep, thick): (f32, f32)) -> f32x4 {
    let thin = grazing[0] + (steeper[0] - grazing[0]) * steep;
    let thicker = grazing[1] + (steeper[1] - grazing[1]) * steep;
    thin + (thicker - thin) * thick
}

impl Cells {
    /// The fewest cells that cover all numbers from `low` to `high`, at least one.
    fn covering(low: f32, high: f32, bits: u32) -> Self {
        let behind = MANTISSA - bits;
        let first = low.to_bits() >> behind;
        // The last of the bits before those of `high`: a number that ends a cell starts no other.
        let last = ((high.to_bits() - 1) >> behind).max(first);
        Self { first, count: last - first + 1, behind }
    }

    /// Where cells start and end, one number more than there are cells.
    fn nodes(self) -> impl Iterator<Item = f32> {
        (self.first..=self.first + self.count).map(move |cell| f32::from_bits(cell << self.behind))
    }

    /// The cell of a number from the first cell on, and how far in it; beyond the last cell that goes above 1.
    #[inline]
    fn cell(self, x: f32) -> (usize, f32) {
        /// The bits of 1, before which no mantissa stands.
        const ONE: u32 = 0x3F80_0000;
        let bits = x.to_bits();
        let cell = (bits >> self.behind) - self.first;
        if cell < self.count {
            let behind = (bits << (32 - self.behind)) >> (32 - MANTISSA);
            return (cell as usize, f32::from_bits(ONE | behind) - 1.0);
        }
        let last = self.first + self.count - 1;
        let [start, end] = [last, last + 1].map(|cell| f32::from_bits(cell << self.behind));
        (self.count as usize - 1, (x - start) / (end - start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_follow_one_another_and_cover_their_range() {
        let cells = Cells::covering(7.0, 96.0, COARSE);
        let nodes = cells.nodes().collect::<Vec<_>>();
        assert_eq!((nodes[0].to_bits(), nodes[nodes.len() - 1].to_bits()), (7.0_f32.to_bits(), 96.0_f32.to_bits()));
        for (number, pair) in nodes.windows(2).enumerate() {
            for (share, x) in [(0.0, pair[0]), (0.25, 0.75 * pair[0] + 0.25 * pair[1]), (1.0, pair[1].next_down())] {
                let (cell, found) = cells.cell(x);
                assert!(cell == number && (found - share).abs() < 1e-5, "{x}: {cell} {found}");
            }
        }
        // The end belongs to the last cell, and beyond it goes straight on.
        let (last, width) = (nodes.len() - 2, nodes[nodes.len() - 1] - nodes[nodes.len() - 2]);
        assert_eq!(cells.cell(96.0), (last, 1.0));
        assert_eq!(cells.cell(96.0 + 2.0 * width), (last, 3.0));
    }

    /// What is straight in thickness and angle is met everywhere, between the nodes and beyond.
    #[test]
    fn planes_are_met() {
        let angles = [0.0, 30.0, 60.0, 80.0];
        let plane = |thickness_cm: f32, angle_deg: f32| 3.0 - 0.5 * thickness_cm + 0.01 * angle_deg;
        let at = |angle: usize, thickness_cm: f32| {
            let mut lanes = [0.0; LANES];
            lanes[0] = plane(thickness_cm, single(angles[angle]));
            lanes[5] = 1.0;
            lanes
        };
        let resampled = Resampled::new(&angles, 20.0, 6, at);
        for thickness_cm in [0.0, 1e-5, 0.003, 0.7, 19.0, 21.5, 80.0] {
            for (angle_deg, taken_deg) in [(0.0, 0.0), (17.0, 17.0), (79.0, 79.0), (80.0, 80.0), (88.0, 80.0)] {
                let mut found = [0.0; LANES];
                resampled.coefficients(thickness_cm, angle_deg, &mut found);
                let expected = plane(thickness_cm, taken_deg);
                assert!((found[0] - expected).abs() < 1e-5 * expected.abs().max(1.0), "{thickness_cm} {angle_deg}");
                assert!((found[5] - 1.0).abs() < 1e-6);
            }
        }
    }
}
