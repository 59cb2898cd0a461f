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
/// Bits of a number that lie behind those of its cell: 23 of mantissa but for the first three.
const BEHIND: u32 = 20;

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
}

impl Resampled {
    /// Resamples what `at` says of a thickness in cm at each of the table's angles: `count` components, as exact as
    /// single precision goes, from no snow to a cell beyond `most_cm`.
    pub(super) fn new(table_angles_deg: &[f64], most_cm: f32, count: usize, at: impl Fn(usize, f32) -> Lanes) -> Self {
        let angles_deg = (single(table_angles_deg[0]), single(table_angles_deg[table_angles_deg.len() - 1]));
        let angles = Cells::covering(BEYOND_HORIZON_DEG - angles_deg.1, BEYOND_HORIZON_DEG - angles_deg.0);
        // One cell more, which lies where the splines have become straight lines, and which goes on for ever.
        let mut thicknesses = Cells::covering(THIN_CM, most_cm + THIN_CM);
        thicknesses.count += 1;
        let heights = thicknesses.nodes().map(|node| node - THIN_CM).collect::<Vec<f32>>();
        let at_angle = |angle| heights.iter().map(|height_cm| at(angle, *height_cm)).collect::<Vec<Lanes>>();
        let at_angles = (0..table_angles_deg.len()).map(at_angle).collect::<Vec<_>>();
        let mut nodes = Vec::new();
        for node in angles.nodes() {
            let weights = cubic::weights(table_angles_deg, f64::from(BEYOND_HORIZON_DEG - node));
            for (height, _) in heights.iter().enumerate() {
                let mut sums = [0.0; LANES];
                for (angle, weight) in &weights {
                    let values = &at_angles[*angle][height];
                    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * f64::from(*value));
                }
                nodes.extend(in_registers(&sums.map(single)[..count]));
            }
        }
        Self { angles, thicknesses, angles_deg, registers: count.div_ceil(REGISTER), nodes }
    }

    /// The components of a thickness and an angle, into `coefficients`; beyond the table's angles those of the nearest.
    #[inline]
    pub(super) fn coefficients(&self, thickness_cm: f32, angle_deg: f32, coefficients: &mut Lanes) {
        let (low, high) = self.angles_deg;
        let angle_deg = if angle_deg < low { low } else { angle_deg };
        let angle_deg = if angle_deg > high { high } else { angle_deg };
        let (angle, steep) = self.angles.cell(BEYOND_HORIZON_DEG - angle_deg);
        let (thickness, thick) = self.thicknesses.cell(thickness_cm + THIN_CM);
        let n = self.registers;
        let row = (self.thicknesses.count as usize + 1) * n;
        let start = angle * row + thickness * n;
        let (grazing, steeper) = (&self.nodes[start..][..2 * n], &self.nodes[start + row..][..2 * n]);
        for (r, four) in coefficients.chunks_exact_mut(REGISTER).take(n).enumerate() {
            let thin = grazing[r] + (steeper[r] - grazing[r]) * steep;
            let thicker = grazing[n + r] + (steeper[n + r] - grazing[n + r]) * steep;
            four.copy_from_slice(&(thin + (thicker - thin) * thick).to_array());
        }
    }
}

impl Cells {
    /// The fewest cells that cover all numbers from `low` to `high`, at least one.
    fn covering(low: f32, high: f32) -> Self {
        let first = low.to_bits() >> BEHIND;
        // The last of the bits before those of `high`: a number that ends a cell starts no other.
        let last = ((high.to_bits() - 1) >> BEHIND).max(first);
        Self { first, count: last - first + 1 }
    }

    /// Where cells start and end, one number more than there are cells.
    fn nodes(self) -> impl Iterator<Item = f32> {
        (self.first..=self.first + self.count).map(|cell| f32::from_bits(cell << BEHIND))
    }

    /// The cell of a number from the first cell on, and how far in it; beyond the last cell that goes above 1.
    #[inline]
    fn cell(self, x: f32) -> (usize, f32) {
        /// The bits of 1, before which no mantissa stands.
        const ONE: u32 = 0x3F80_0000;
        let bits = x.to_bits();
        let cell = (bits >> BEHIND) - self.first;
        if cell < self.count {
            let behind = (bits << (32 - BEHIND)) >> (32 - 23);
            return (cell as usize, f32::from_bits(ONE | behind) - 1.0);
        }
        let last = self.first + self.count - 1;
        let [start, end] = [last, last + 1].map(|cell| f32::from_bits(cell << BEHIND));
        (self.count as usize - 1, (x - start) / (end - start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_follow_one_another_and_cover_their_range() {
        let cells = Cells::covering(7.0, 96.0);
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
