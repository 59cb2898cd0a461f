//! A table of brightness over all directions, by which directions are sampled.
//!
//! Rows run from straight up (+z) to straight down, and columns run around. The middle column looks along +y. Seen
//! from above, directions turn clockwise to the right, as in a view from inside. The density is the density of the
//! bilinear interpolation between pixels, which is constant beyond the first and the last row. Sampling inverts
//! cumulative sums to choose a row of cells between the middles of pixels, then a cell of this row, and then draws a
//! point in the cell (Pharr, Jakob & Humphreys 2023, sections A.4 and A.5). With a constant density in each pixel,
//! the edges of a small sun are noisy.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::Vec3A;

use snowblue_base::narrow;

use crate::sampling::{cumulative, invert, share};

/// Cumulative sums of brightness over all directions.
#[derive(Debug)]
pub(crate) struct DirectionTable {
    width: usize,
    height: usize,
    turn_rad: f32,
    /// Brightness at the middle of each pixel.
    bright: Vec<f32>,
    /// Mean brightness over all directions.
    mean: f32,
    /// Cumulative fractions of the light over the rows of cells, and over the columns of each row.
    rows: Vec<f32>,
    columns: Vec<f32>,
}

impl DirectionTable {
    /// A table of `width` columns from the brightness at the middle of each pixel, row by row, turned about z by
    /// `turn_rad`, counter-clockwise seen from above. None if all is dark.
    pub(super) fn new(width: usize, bright: Vec<f32>, turn_rad: f32) -> Option<Self> {
        let height = bright.len() / width;
        let mut table = Self { width, height, turn_rad, bright, mean: 0.0, rows: Vec::new(), columns: Vec::new() };
        let mut row_weights = Vec::with_capacity(height + 1);
        table.columns.reserve_exact(width * (height + 1));
        for row in 0..=height {
            let mean = |column| 0.25 * table.corners(row, column).as_flattened().iter().sum::<f32>();
            let (total, shares) = cumulative((0..width).map(mean));
            let [top, bottom] = table.edge_cosines(row);
            row_weights.push(narrow(total) * (top - bottom));
            table.columns.extend(shares);
        }
        let (total, rows) = cumulative(row_weights.into_iter());
        table.rows = rows;
        // The weights of rows add up to 2 for each column.
        table.mean = narrow(total / (2 * width) as f64);
        (total > 0.0).then_some(table)
    }

    /// Mean brightness over all directions.
    pub(super) fn mean(&self) -> f32 {
        self.mean
    }

    /// A direction with the density [`density_per_sr`](Self::density_per_sr), from two numbers in [0, 1).
    pub(super) fn sample(&self, [u, v]: [f32; 2]) -> Vec3A {
        let (row, down) = invert(&self.rows, v);
        let (column, across) = invert(self.columns_of(row), u);
        let corners = self.corners(row, column);
        let down = invert_linear(corners.map(|[left, right]| left + right), down);
        let [above, below] = corners;
        let across = invert_linear([0, 1].map(|side| above[side] + (below[side] - above[side]) * down), across);
        let [top, bottom] = self.edge_cosines(row);
        let z = top + (bottom - top) * down;
        let longitude = longitude_rad((column as f32 + 0.5 + across) / self.width as f32) + self.turn_rad;
        let radius = (1.0 - z * z).max(0.0).sqrt();
        Vec3A::new(radius * longitude.cos(), radius * longitude.sin(), z)
    }

    /// Density of [`sample`](Self::sample), in 1/sr.
    pub(super) fn density_per_sr(&self, direction: Vec3A) -> f32 {
        let [across, down] = self.place(direction);
        let (row, shifted) = (whole(down + 0.5, self.height + 1), across + self.width as f32 - 0.5);
        let (column, across) = (whole(shifted, 2 * self.width) % self.width, shifted.fract());
        let [top, bottom] = self.edge_cosines(row);
        let down = ((top - direction.z) / (top - bottom)).clamp(0.0, 1.0);
        let [above, below] =
            self.corners(row, column).map(|[left, right]| [left + (right - left) * across, left + right]);
        let mean = 0.25 * (above[1] + below[1]);
        if mean <= 0.0 {
            return 0.0;
        }
        let fraction = share(&self.rows, row) * share(self.columns_of(row), column);
        let in_cell = (above[0] + (below[0] - above[0]) * down) / mean;
        fraction * in_cell * self.width as f32 / (TAU * (top - bottom))
    }

    /// Brightness at the corners of a cell: above and below, on the left and on the right.
    fn corners(&self, row: usize, column: usize) -> [[f32; 2]; 2] {
        let columns = [column, (column + 1) % self.width];
        [row.saturating_sub(1), row.min(self.height - 1)]
            .map(|row| columns.map(|column| self.bright[row * self.width + column]))
    }

    /// Cumulative fractions of the light over the columns of a row of cells.
    fn columns_of(&self, row: usize) -> &[f32] {
        &self.columns[row * self.width..][..self.width]
    }

    /// Cosine of the polar angle at the upper and the lower edge of a row of cells.
    fn edge_cosines(&self, row: usize) -> [f32; 2] {
        let height = self.height as f32;
        [row as f32 - 0.5, row as f32 + 0.5].map(|edge| (PI * edge.clamp(0.0, height) / height).cos())
    }

    /// Position of a direction in the table, in pixels from its upper left corner.
    pub(super) fn place(&self, direction: Vec3A) -> [f32; 2] {
        let longitude = direction.y.atan2(direction.x) - self.turn_rad;
        let across = (0.5 + (FRAC_PI_2 - longitude) / TAU).rem_euclid(1.0);
        let down = direction.z.clamp(-1.0, 1.0).acos() / PI;
        [across * self.width as f32, down * self.height as f32]
    }
}

/// Longitude from x to y, in rad, at a horizontal position from 0 to 1 in a table.
pub(super) fn longitude_rad(across: f32) -> f32 {
    FRAC_PI_2 - TAU * (across - 0.5)
}

/// The position in [0, 1] below which a density that is linear between two values has the fraction `u`.
fn invert_linear([from, to]: [f32; 2], u: f32) -> f32 {
    if from + to <= 0.0 {
        return u;
    }
    (u * (from + to) / (from + (from * from + (to * to - from * from) * u).sqrt())).min(1.0)
}

/// Pixel index of a coordinate, clamped to 0..`count`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "kept within the pixels")]
pub(super) fn whole(place: f32, count: usize) -> usize {
    (place.max(0.0) as usize).min(count - 1)
}
