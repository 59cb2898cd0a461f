//! The lattice of finest cells around a body, and the lattices of coarser cells.

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

/// Greatest number of cells along an axis: places have 21 bits, and cells and nodes may lie beyond the end.
pub(crate) const MAX_ALONG_AXIS: usize = 1 << 20;

impl Lattice {
    /// The lattice with cells of at most `step_m` around a body. Without a shift, the cells fit the bounds exactly.
    /// `shift` is a fraction of a cell along each axis.
    pub(crate) fn around(body: &dyn Body, step_m: f64, shift: DVec3) -> Self {
        let [low, high] = body.bounds();
        let size = high - low;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive, and bounded by the plan of the grid"
        )]
        let mut counts = size.to_array().map(|size| (size / step_m - 1e-6).ceil().max(1.0) as usize);
        let step = DVec3::from_array(std::array::from_fn(|k| size[k] / counts[k] as f64));
        for k in 0..3 {
            counts[k] += usize::from(shift[k] > 0.0);
        }
        Self { low: low - shift * step, step, counts }
    }

    /// The lattice of cells of a level. Each spans 2^level cells of this lattice along each axis. The last cells may
    /// extend beyond the end.
    pub(crate) fn coarsened(&self, level: u8) -> Self {
        let step = self.step * f64::from(1u32 << level);
        Self { step, counts: self.counts.map(|count| count.div_ceil(1 << level)), ..*self }
    }

    /// The least level, from 1, at which one cell covers the lattice.
    pub(crate) fn top_level(&self) -> u8 {
        let most = self.counts.into_iter().max().unwrap_or(1);
        u8::try_from(most.next_power_of_two().trailing_zeros()).unwrap_or(u8::MAX).max(1)
    }

    /// All columns of cells along an axis, in order, by their places on the next two axes.
    pub(crate) fn columns(&self, axis: usize) -> Vec<[u32; 2]> {
        let [u, v] = across(axis).map(|k| self.counts[k]);
        let number = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        (0..number(u)).flat_map(|u| (0..number(v)).map(move |v| [u, v])).collect()
    }

    /// The corner of least coordinates of a cell, in m.
    pub(crate) fn corner(&self, place: [u32; 3]) -> DVec3 {
        self.low + self.step * DVec3::from_array(place.map(f64::from))
    }

    /// The cell that holds a point, or the nearest cell.
    #[inline]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the lattice")]
    pub(crate) fn cell_at(&self, point: DVec3) -> [u32; 3] {
        let place = (point - self.low) / self.step;
        std::array::from_fn(|k| (place[k].max(0.0) as usize).min(self.counts[k] - 1) as u32)
    }
}

/// The two axes that follow an axis, in cyclic order.
#[inline]
pub(crate) fn across(axis: usize) -> [usize; 2] {
    [(axis + 1) % 3, (axis + 2) % 3]
}
