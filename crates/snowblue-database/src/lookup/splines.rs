//! The paper's form: a natural cubic spline over the thickness at each of the table's angles, and a straight line between
//! two angles. It acts on the coefficients, which is exact, as both steps are linear.

use wide::f32x4;

use super::basis::{LANES, Lanes};
use crate::pca::single;
use crate::spline::{Knots, Piece, curvatures, piece};

/// Numbers in a register.
pub(super) const REGISTER: usize = 4;

/// Splines of one quantity of one snow.
#[derive(Debug, Clone)]
pub(super) struct Splines {
    angles_deg: Knots,
    knots: Knots,
    /// Registers that hold the components of one knot.
    registers: usize,
    /// [angle][knot][values, then second derivatives][register]
    pieces: Vec<f32x4>,
}

impl Splines {
    /// Splines through `values`, [angle][knot][component].
    pub(super) fn new(angles_deg: &[f64], knots: &[f64], values: &[f64]) -> Self {
        let count = values.len() / (angles_deg.len() * knots.len());
        let registers = count.div_ceil(REGISTER);
        let mut pieces = Vec::new();
        for values in values.chunks_exact(knots.len() * count) {
            let column = |c: usize| values.iter().skip(c).step_by(count).copied().collect::<Vec<f64>>();
            let columns: Vec<Vec<f64>> = (0..count).map(column).collect();
            let bends: Vec<Vec<f64>> = columns.iter().map(|column| curvatures(knots, column)).collect();
            for knot in 0..knots.len() {
                for columns in [&columns, &bends] {
                    let row = columns.iter().map(|column| single(column[knot])).collect::<Vec<f32>>();
                    pieces.extend(in_registers(&row));
                }
            }
        }
        Self { angles_deg: Knots::new(angles_deg), knots: Knots::new(knots), registers, pieces }
    }

    /// Where the splines start and end.
    pub(super) fn range(&self) -> (f32, f32) {
        self.knots.ends()
    }

    /// The coefficients at spline place `x` and an angle, into `coefficients`.
    #[inline]
    pub(super) fn coefficients(&self, x: f32, angle_deg: f32, coefficients: &mut Lanes) {
        let (angle, share) = self.between_angles(angle_deg);
        // At the last angle the next one does not count, and is not there.
        let angles = [(angle, 1.0 - share), (angle + usize::from(share > 0.0), share)];
        self.sum(angles, piece(&self.knots, x), coefficients);
    }

    /// The coefficients at spline place `x` and one of the table's angles.
    pub(super) fn at_angle(&self, angle: usize, x: f32) -> Lanes {
        let mut coefficients = [0.0; LANES];
        self.sum([(angle, 1.0), (angle, 0.0)], piece(&self.knots, x), &mut coefficients);
        coefficients
    }

    /// The angle on the axis below, and how far on the way to the next.
    #[inline]
    fn between_angles(&self, angle_deg: f32) -> (usize, f32) {
        if self.angles_deg.len() == 1 || angle_deg <= self.angles_deg.ends().0 {
            return (0, 0.0);
        }
        let (angle, _, share) = self.angles_deg.place(angle_deg);
        (angle, share.min(1.0))
    }

    /// The splines at two angles, each with its share.
    #[inline]
    fn sum(&self, angles: [(usize, f32); 2], piece: Piece, coefficients: &mut Lanes) {
        let n = self.registers;
        let rows = angles.map(|(angle, _)| &self.pieces[(angle * self.knots.len() + piece.knot) * 2 * n..][..4 * n]);
        let weights = [piece.values[0], piece.curvatures[0], piece.values[1], piece.curvatures[1]];
        for (r, four) in coefficients.chunks_exact_mut(REGISTER).take(n).enumerate() {
            let spline = |row: &[f32x4]| {
                let [a, b, c, d] = std::array::from_fn(|part| row[part * n + r] * weights[part]);
                (a + c) + (b + d)
            };
            let sum = spline(rows[0]) * angles[0].1 + spline(rows[1]) * angles[1].1;
            four.copy_from_slice(&sum.to_array());
        }
    }
}

/// Numbers in registers, of which the last is filled up with 0.
pub(super) fn in_registers(values: &[f32]) -> impl Iterator<Item = f32x4> {
    values.chunks(REGISTER).map(|four| f32x4::new(std::array::from_fn(|lane| four.get(lane).copied().unwrap_or(0.0))))
}
