//! Coefficients of one snow sample over thickness and angle, in two ways: as splines, and resampled on a fine grid.
//!
//! **Splines** are the paper's interpolation: a natural cubic spline over the thickness at each of the table's angles,
//! and a straight line between two angles. It acts on the coefficients, which is exact because both steps are linear.
//!
//! **The fine grid** interpolates tables in log space. The coefficients are resampled once on a grid fine enough for
//! linear interpolation over thickness and angle. Its cells are found without a search and without a logarithm.
//!
//! The grid is uniform in the bits of a floating-point number, with eight cells per power of two: a cell's index is the
//! exponent and the first three mantissa bits. Along the thickness h the number is h + 2⁻⁶ cm: cells are 1/8 to 1/16 of
//! the thickness wide in deep snow and 20 µm wide near the surface, and the first starts at 0 cm. Along the angle θ it
//! is 96° − θ, since transmittance curves most near the horizon: cells are 8° wide near the normal and ½° wide at 89°.
//!
//! The nodes hold the table's own interpolation: the spline over the thickness at each of the table's angles, and a
//! cubic between these angles ([`crate::cubic::weights`]). Linear interpolation between nodes adds up to 0.2 % to
//! transmittance and 0.5 % to the reflectance of thin layers.

use wide::f32x4;

use crate::cubic::{self, Knots, Piece, Position, curvatures, piece};
use crate::lookup::basis::{PADDED_COMPONENTS, PaddedCoefficients};
use crate::pca::single;

/// Numbers in a SIMD register.
const REGISTER: usize = 4;

/// Splines of one quantity of one snow sample.
#[derive(Debug, Clone)]
pub(super) struct SplineGrid {
    angles_deg: Knots,
    knots: Knots,
    /// Registers for the components of one knot.
    registers: usize,
    /// [angle][knot][values, then second derivatives][register]
    pieces: Vec<f32x4>,
}

/// One of the table's angles with its weight.
#[derive(Debug, Clone, Copy)]
struct WeightedAngle {
    angle: usize,
    weight: f32,
}

impl SplineGrid {
    /// Splines through `values`, [angle][knot][component].
    pub(super) fn new(angles_deg: &[f64], knots: &[f64], values: &[f64]) -> Self {
        let count = values.len() / (angles_deg.len() * knots.len());
        let registers = count.div_ceil(REGISTER);
        let mut pieces = Vec::new();
        for values in values.chunks_exact(knots.len() * count) {
            let column = |c: usize| values.iter().skip(c).step_by(count).copied().collect::<Vec<f64>>();
            let columns: Vec<Vec<f64>> = (0..count).map(column).collect();
            let second_derivatives: Vec<Vec<f64>> = columns.iter().map(|column| curvatures(knots, column)).collect();
            for knot in 0..knots.len() {
                for columns in [&columns, &second_derivatives] {
                    let row = columns.iter().map(|column| single(column[knot])).collect::<Vec<f32>>();
                    pieces.extend(in_registers(&row));
                }
            }
        }
        Self { angles_deg: Knots::new(angles_deg), knots: Knots::new(knots), registers, pieces }
    }

    /// The first knot.
    pub(super) fn first_knot(&self) -> f32 {
        self.knots.first()
    }

    /// The last knot.
    pub(super) fn last_knot(&self) -> f32 {
        self.knots.last()
    }

    /// Writes the coefficients at knot coordinate `x` and an angle.
    #[inline]
    pub(super) fn coefficients(&self, x: f32, angle_deg: f32, coefficients: &mut PaddedCoefficients) {
        let Position { knot: angle, fraction, .. } = self.angle_position(angle_deg);
        // There is no angle after the last angle.
        let next = angle + usize::from(fraction > 0.0);
        let angles = [WeightedAngle { angle, weight: 1.0 - fraction }, WeightedAngle { angle: next, weight: fraction }];
        self.sum(angles, piece(&self.knots, x), coefficients);
    }

    /// The coefficients at knot coordinate `x` and one of the table's angles.
    pub(super) fn at_angle(&self, angle: usize, x: f32) -> PaddedCoefficients {
        let mut coefficients = [0.0; PADDED_COMPONENTS];
        let angles = [1.0, 0.0].map(|weight| WeightedAngle { angle, weight });
        self.sum(angles, piece(&self.knots, x), &mut coefficients);
        coefficients
    }

    /// The position among the table's angles; outside them, the position of the nearest angle.
    #[inline]
    fn angle_position(&self, angle_deg: f32) -> Position {
        if self.angles_deg.len() == 1 || angle_deg <= self.angles_deg.first() {
            return Position { knot: 0, width: 0.0, fraction: 0.0 };
        }
        let position = self.angles_deg.position(angle_deg);
        Position { fraction: position.fraction.min(1.0), ..position }
    }

    /// The weighted sum of the splines at two angles.
    #[inline]
    fn sum(&self, angles: [WeightedAngle; 2], piece: Piece, coefficients: &mut PaddedCoefficients) {
        let n = self.registers;
        let row = |angle: usize| &self.pieces[(angle * self.knots.len() + piece.knot) * 2 * n..][..4 * n];
        let rows = [row(angles[0].angle), row(angles[1].angle)];
        let weights = [piece.values[0], piece.curvatures[0], piece.values[1], piece.curvatures[1]];
        for (r, four) in coefficients.chunks_exact_mut(REGISTER).take(n).enumerate() {
            let spline = |row: &[f32x4]| {
                let [a, b, c, d] = std::array::from_fn(|part| row[part * n + r] * weights[part]);
                (a + c) + (b + d)
            };
            let sum = spline(rows[0]) * angles[0].weight + spline(rows[1]) * angles[1].weight;
            four.copy_from_slice(&sum.to_array());
        }
    }
}

/// Packs numbers into registers and pads the last one with 0.
fn in_registers(values: &[f32]) -> impl Iterator<Item = f32x4> {
    values.chunks(REGISTER).map(|four| f32x4::new(std::array::from_fn(|lane| four.get(lane).copied().unwrap_or(0.0))))
}

/// Offset of the thickness, in cm. Cells are uniform below it.
pub(super) const OFFSET_CM: f32 = 0.015_625;
/// Angles are measured down from this angle, in degrees.
const ANGLE_ORIGIN_DEG: f32 = 96.0;
/// Mantissa bits of a cell index in a grid of coefficients.
const COARSE_BITS: u32 = 3;
/// Bits of a mantissa.
const MANTISSA_BITS: u32 = 23;

/// Coefficients of one quantity of one snow sample.
#[derive(Debug, Clone)]
pub(super) struct ResampledGrid {
    angles: Cells,
    thicknesses: Cells,
    extent: Extent,
    /// Registers for the components of one node.
    registers: usize,
    /// [angle][thickness][register]
    nodes: Vec<f32x4>,
}

/// The range of a grid, from 0 cm. Angles outside it are looked up at its ends; thicker snow is extrapolated linearly.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    pub(super) first_angle_deg: f32,
    pub(super) last_angle_deg: f32,
    pub(super) last_thickness_cm: f32,
}

/// A point within a cell of the grid.
#[derive(Debug, Clone, Copy)]
struct GridPoint {
    /// Index of the cell's first node.
    start: usize,
    /// Distance to the nodes of the next angle, which is the steeper angle.
    row: usize,
    /// Position within the cell along the angle and along the thickness, 0–1.
    angle_fraction: f32,
    thickness_fraction: f32,
}

/// Cells of a grid that is uniform in the bits of a positive number.
#[derive(Debug, Clone, Copy)]
struct Cells {
    /// The number's leading bits in the first cell.
    first: u32,
    count: u32,
    /// Number of bits that follow the bits of the cell index.
    shift: u32,
}

/// A position along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CellPosition {
    cell: usize,
    /// 0–1 within the cell, above 1 beyond the last cell.
    fraction: f32,
}

impl ResampledGrid {
    /// Resamples `at`, which gives the first `count` coefficients at the index of a table angle and a thickness in cm,
    /// in single precision. The grid extends one cell beyond `last_thickness_cm`.
    pub(super) fn new(
        table_angles_deg: &[f64],
        last_thickness_cm: f32,
        count: usize,
        at: impl Fn(usize, f32) -> PaddedCoefficients,
    ) -> Self {
        let extent = Extent {
            first_angle_deg: single(table_angles_deg[0]),
            last_angle_deg: single(table_angles_deg[table_angles_deg.len() - 1]),
            last_thickness_cm,
        };
        let mut grid = Self::empty(extent, COARSE_BITS, count);
        let thicknesses_cm = grid.node_thicknesses_cm();
        let at_angle = |angle| thicknesses_cm.iter().map(|h| at(angle, *h)).collect::<Vec<PaddedCoefficients>>();
        let at_angles = (0..table_angles_deg.len()).map(at_angle).collect::<Vec<_>>();
        for node_deg in grid.node_angles_deg() {
            let weights = cubic::weights(table_angles_deg, f64::from(node_deg));
            for (thickness, _) in thicknesses_cm.iter().enumerate() {
                let mut sums = [0.0; PADDED_COMPONENTS];
                for (angle, weight) in &weights {
                    let values = &at_angles[*angle][thickness];
                    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * f64::from(*value));
                }
                grid.nodes.extend(in_registers(&sums.map(single)[..count]));
            }
        }
        grid
    }

    /// A grid of four numbers, `at` a thickness in cm and an angle in degrees, with 2^`bits` cells along the thickness
    /// for each power of two.
    pub(super) fn of_four(extent: Extent, bits: u32, mut at: impl FnMut(f32, f32) -> [f32; REGISTER]) -> Self {
        let mut grid = Self::empty(extent, bits, REGISTER);
        let thicknesses_cm = grid.node_thicknesses_cm();
        for node_deg in grid.node_angles_deg() {
            grid.nodes.extend(thicknesses_cm.iter().map(|h| f32x4::new(at(*h, node_deg))));
        }
        grid
    }

    fn empty(extent: Extent, bits: u32, count: usize) -> Self {
        let (low, high) = (ANGLE_ORIGIN_DEG - extent.last_angle_deg, ANGLE_ORIGIN_DEG - extent.first_angle_deg);
        let angles = Cells::covering(low, high, COARSE_BITS);
        // One more cell, in which the splines are straight lines. Thicker snow is extrapolated from it.
        let mut thicknesses = Cells::covering(OFFSET_CM, extent.last_thickness_cm + OFFSET_CM, bits);
        thicknesses.count += 1;
        Self { angles, thicknesses, extent, registers: count.div_ceil(REGISTER), nodes: Vec::new() }
    }

    fn node_thicknesses_cm(&self) -> Vec<f32> {
        self.thicknesses.nodes().map(|node| node - OFFSET_CM).collect()
    }

    fn node_angles_deg(&self) -> Vec<f32> {
        self.angles.nodes().map(|node| ANGLE_ORIGIN_DEG - node).collect()
    }

    pub(super) fn extent(&self) -> Extent {
        self.extent
    }

    /// The four numbers at a thickness and an angle, of a grid made by [`of_four`](Self::of_four).
    #[inline]
    pub(super) fn four(&self, thickness_cm: f32, angle_deg: f32) -> f32x4 {
        let point = self.point(thickness_cm, angle_deg, 1);
        let (grazing, steeper) = (&self.nodes[point.start..][..2], &self.nodes[point.start + point.row..][..2]);
        point.interpolate([grazing[0], grazing[1]], [steeper[0], steeper[1]])
    }

    #[inline]
    fn point(&self, thickness_cm: f32, angle_deg: f32, registers: usize) -> GridPoint {
        let Extent { first_angle_deg, last_angle_deg, .. } = self.extent;
        let angle_deg = if angle_deg < first_angle_deg { first_angle_deg } else { angle_deg };
        let angle_deg = if angle_deg > last_angle_deg { last_angle_deg } else { angle_deg };
        let angle = self.angles.position(ANGLE_ORIGIN_DEG - angle_deg);
        let thickness = self.thicknesses.position(thickness_cm + OFFSET_CM);
        let row = (self.thicknesses.count as usize + 1) * registers;
        GridPoint {
            start: angle.cell * row + thickness.cell * registers,
            row,
            angle_fraction: angle.fraction,
            thickness_fraction: thickness.fraction,
        }
    }

    /// Writes the coefficients at a thickness and an angle.
    #[inline]
    pub(super) fn coefficients(&self, thickness_cm: f32, angle_deg: f32, coefficients: &mut PaddedCoefficients) {
        let n = self.registers;
        let point = self.point(thickness_cm, angle_deg, n);
        let (grazing, steeper) = (&self.nodes[point.start..][..2 * n], &self.nodes[point.start + point.row..][..2 * n]);
        for (r, four) in coefficients.chunks_exact_mut(REGISTER).take(n).enumerate() {
            let [grazing, steeper] = [grazing, steeper].map(|nodes| [nodes[r], nodes[n + r]]);
            four.copy_from_slice(&point.interpolate(grazing, steeper).to_array());
        }
    }
}

impl GridPoint {
    /// Bilinear interpolation between the corners of the cell. Each pair holds the thinner and the thicker node.
    #[inline(always)]
    fn interpolate(&self, grazing: [f32x4; 2], steeper: [f32x4; 2]) -> f32x4 {
        let thin = grazing[0] + (steeper[0] - grazing[0]) * self.angle_fraction;
        let thick = grazing[1] + (steeper[1] - grazing[1]) * self.angle_fraction;
        thin + (thick - thin) * self.thickness_fraction
    }
}

impl Cells {
    /// The fewest cells that cover `low` to `high`, at least one.
    fn covering(low: f32, high: f32, bits: u32) -> Self {
        let shift = MANTISSA_BITS - bits;
        let first = low.to_bits() >> shift;
        // A number at the end of a cell does not start a further cell.
        let last = ((high.to_bits() - 1) >> shift).max(first);
        Self { first, count: last - first + 1, shift }
    }

    /// The boundaries of the cells, one more than there are cells.
    fn nodes(self) -> impl Iterator<Item = f32> {
        (self.first..=self.first + self.count).map(move |cell| f32::from_bits(cell << self.shift))
    }

    /// The position of a number at or above the first boundary.
    #[inline]
    fn position(self, x: f32) -> CellPosition {
        /// Bits of 1.0, whose mantissa is 0.
        const ONE: u32 = 0x3F80_0000;
        let bits = x.to_bits();
        let cell = (bits >> self.shift) - self.first;
        if cell < self.count {
            let rest = (bits << (32 - self.shift)) >> (32 - MANTISSA_BITS);
            return CellPosition { cell: cell as usize, fraction: f32::from_bits(ONE | rest) - 1.0 };
        }
        let last = self.first + self.count - 1;
        let [start, end] = [last, last + 1].map(|cell| f32::from_bits(cell << self.shift));
        CellPosition { cell: self.count as usize - 1, fraction: (x - start) / (end - start) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_contiguous_and_cover_their_range() {
        let cells = Cells::covering(7.0, 96.0, COARSE_BITS);
        let nodes = cells.nodes().collect::<Vec<_>>();
        assert_eq!((nodes[0].to_bits(), nodes[nodes.len() - 1].to_bits()), (7.0_f32.to_bits(), 96.0_f32.to_bits()));
        for (number, pair) in nodes.windows(2).enumerate() {
            for (fraction, x) in [(0.0, pair[0]), (0.25, 0.75 * pair[0] + 0.25 * pair[1]), (1.0, pair[1].next_down())] {
                let found = cells.position(x);
                assert!(found.cell == number && (found.fraction - fraction).abs() < 1e-5, "{x}: {found:?}");
            }
        }
        // The end belongs to the last cell, which extends beyond it.
        let (last, width) = (nodes.len() - 2, nodes[nodes.len() - 1] - nodes[nodes.len() - 2]);
        assert_eq!(cells.position(96.0), CellPosition { cell: last, fraction: 1.0 });
        assert_eq!(cells.position(96.0 + 2.0 * width), CellPosition { cell: last, fraction: 3.0 });
    }

    #[test]
    fn functions_linear_in_thickness_and_angle_are_exact() {
        let angles = [0.0, 30.0, 60.0, 80.0];
        let plane = |thickness_cm: f32, angle_deg: f32| 3.0 - 0.5 * thickness_cm + 0.01 * angle_deg;
        let at = |angle: usize, thickness_cm: f32| {
            let mut coefficients = [0.0; PADDED_COMPONENTS];
            coefficients[0] = plane(thickness_cm, single(angles[angle]));
            coefficients[5] = 1.0;
            coefficients
        };
        let grid = ResampledGrid::new(&angles, 20.0, 6, at);
        for thickness_cm in [0.0, 1e-5, 0.003, 0.7, 19.0, 21.5, 80.0] {
            for (angle_deg, taken_deg) in [(0.0, 0.0), (17.0, 17.0), (79.0, 79.0), (80.0, 80.0), (88.0, 80.0)] {
                let mut found = [0.0; PADDED_COMPONENTS];
                grid.coefficients(thickness_cm, angle_deg, &mut found);
                let expected = plane(thickness_cm, taken_deg);
                assert!((found[0] - expected).abs() < 1e-5 * expected.abs().max(1.0), "{thickness_cm} {angle_deg}");
                assert!((found[5] - 1.0).abs() < 1e-6);
            }
        }
    }
}
