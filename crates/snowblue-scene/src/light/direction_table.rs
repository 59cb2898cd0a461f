//! A table of brightness over all directions, by which directions are sampled.
//!
//! Rows run from straight up (+z) to straight down, columns around; the middle column looks along +y, and directions
//! turn clockwise to the right as seen from above, as in a view from inside. The density is constant over each pixel's
//! solid angle and proportional to its mean brightness: rows first, then columns, by inversion of cumulative sums
//! (Pharr, Jakob & Humphreys 2023, section A.5).

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::Vec3A;

use snowblue_geometry::ray::narrow;

use crate::sampling::{cumulative, invert, share};

/// Cumulative sums of brightness over all directions.
#[derive(Debug)]
pub(super) struct DirectionTable {
    width: usize,
    height: usize,
    turn_rad: f32,
    /// Cumulative fractions of the light over the rows, and over the columns of each row.
    rows: Vec<f32>,
    columns: Vec<f32>,
}

impl DirectionTable {
    /// A table of `width` columns from the brightness at the middle of each pixel, row by row, turned about z by
    /// `turn_rad`, counter-clockwise seen from above. None if all is dark.
    pub(super) fn new(width: usize, bright: &[f32], turn_rad: f32) -> Option<Self> {
        let height = bright.len() / width;
        let mut row_weights = Vec::with_capacity(height);
        let mut columns = Vec::with_capacity(width * height);
        for row in 0..height {
            // Mean of the bilinear interpolation over a pixel: weights 1/8, 6/8, 1/8 along both axes.
            let rows = [(row.saturating_sub(1), 0.125), (row, 0.75), ((row + 1).min(height - 1), 0.125)];
            let at =
                |column: usize| -> f32 { rows.iter().map(|(row, share)| share * bright[row * width + column]).sum() };
            let weights = (0..width).map(|column| {
                0.125 * at((column + width - 1) % width) + 0.75 * at(column) + 0.125 * at((column + 1) % width)
            });
            let (total, shares) = cumulative(weights);
            columns.extend(shares);
            let [top, bottom] = edge_cosines(row, height);
            row_weights.push(narrow(total) * (top - bottom));
        }
        let (total, rows) = cumulative(row_weights.into_iter());
        (total > 0.0).then_some(Self { width, height, turn_rad, rows, columns })
    }

    /// A direction with the density [`density_per_sr`](Self::density_per_sr), from two numbers in [0, 1).
    pub(super) fn sample(&self, [u, v]: [f32; 2]) -> Vec3A {
        let (row, down) = invert(&self.rows, v);
        let (column, across) = invert(&self.columns[row * self.width..][..self.width], u);
        let [top, bottom] = edge_cosines(row, self.height);
        let z = top + (bottom - top) * down;
        let longitude = longitude_rad((column as f32 + across) / self.width as f32) + self.turn_rad;
        let radius = (1.0 - z * z).max(0.0).sqrt();
        Vec3A::new(radius * longitude.cos(), radius * longitude.sin(), z)
    }

    /// Density of [`sample`](Self::sample), in 1/sr.
    pub(super) fn density_per_sr(&self, direction: Vec3A) -> f32 {
        let [across, down] = self.place(direction);
        let (column, row) = (whole(across, self.width), whole(down, self.height));
        let [top, bottom] = edge_cosines(row, self.height);
        let fraction = share(&self.rows, row) * share(&self.columns[row * self.width..][..self.width], column);
        fraction * self.width as f32 / (TAU * (top - bottom))
    }

    /// Position of a direction in the table, in pixels from its upper left corner.
    pub(super) fn place(&self, direction: Vec3A) -> [f32; 2] {
        let longitude = direction.y.atan2(direction.x) - self.turn_rad;
        let across = (0.5 + (FRAC_PI_2 - longitude) / TAU).rem_euclid(1.0);
        let down = direction.z.clamp(-1.0, 1.0).acos() / PI;
        [across * self.width as f32, down * self.height as f32]
    }
}

/// Longitude from x to y, in rad, of a place across a table from 0 to 1.
pub(super) fn longitude_rad(across: f32) -> f32 {
    FRAC_PI_2 - TAU * (across - 0.5)
}

/// Cosine of the polar angle at the upper and the lower edge of a row.
fn edge_cosines(row: usize, height: usize) -> [f32; 2] {
    [row, row + 1].map(|edge| (PI * edge as f32 / height as f32).cos())
}

/// Pixel index of a coordinate, clamped to 0..`count`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "kept within the pixels")]
pub(super) fn whole(place: f32, count: usize) -> usize {
    (place.max(0.0) as usize).min(count - 1)
}
