//! The paper's interpolation: a natural cubic spline over the thickness at each of the table's angles, and a straight
//! line between two angles. It acts on the coefficients, which is exact because both steps are linear.

use wide::f32x4;

use super::basis::{PADDED_COMPONENTS, PaddedCoefficients};
use crate::pca::single;
use crate::spline::{Knots, Piece, Position, curvatures, piece};

/// Numbers in a SIMD register.
pub(super) const REGISTER: usize = 4;

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
        // There is no angle after the last one.
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

    /// The position among the table's angles; outside them, that of the nearest one.
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
pub(super) fn in_registers(values: &[f32]) -> impl Iterator<Item = f32x4> {
    values.chunks(REGISTER).map(|four| f32x4::new(std::array::from_fn(|lane| four.get(lane).copied().unwrap_or(0.0))))
}
