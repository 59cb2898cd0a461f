//! The lattice of finest cells around a body.

use glam::DVec3;

use crate::body::Body;

/// A box divided into equal cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lattice {
    /// The corner of least coordinates, in m.
    pub(crate) low: DVec3,
    /// Size of a cell, in m.
    pub(crate) step: DVec3,
    /// Number of cells along each axis.
    pub(crate) counts: [usize; 3],
}

impl Lattice {
    /// Cells of at most `step_m` around a body, which fit its bounds exactly unless they are shifted: by `shift` of a
    /// cell along each axis.
    pub(crate) fn around(body: &dyn Body, step_m: f64, shift: DVec3) -> Self {
        let [low, high] = body.bounds();
        let size = high - low;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive, and checked by the grid"
        )]
        let mut counts = size.to_array().map(|size| (size / step_m - 1e-6).ceil().max(1.0) as usize);
        let step = DVec3::from_array(std::array::from_fn(|k| size[k] / counts[k] as f64));
        for k in 0..3 {
            counts[k] += usize::from(shift[k] > 0.0);
        }
        Self { low: low - shift * step, step, counts }
    }

    /// Number of cells.
    pub(crate) fn cell_count(&self) -> usize {
        self.counts.iter().product()
    }

    /// The number of a cell.
    #[inline]
    pub(crate) fn index(&self, cell: [usize; 3]) -> usize {
        (cell[0] * self.counts[1] + cell[1]) * self.counts[2] + cell[2]
    }

    /// The cell of a number.
    pub(crate) fn cell(&self, index: usize) -> [usize; 3] {
        let [_, ny, nz] = self.counts;
        [index / (ny * nz), index / nz % ny, index % nz]
    }

    /// The cell that holds a point, or the nearest one.
    #[inline]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the lattice")]
    pub(crate) fn cell_at(&self, point: DVec3) -> [usize; 3] {
        let place = (point - self.low) / self.step;
        std::array::from_fn(|k| (place[k].max(0.0) as usize).min(self.counts[k] - 1))
    }
}
