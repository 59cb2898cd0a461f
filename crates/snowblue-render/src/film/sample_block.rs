//! Which samples of which pixels: a box of columns, rows and samples.

use std::ops::Range;

use crate::film::window::{Window, range_length};

/// Some samples of the pixels of a rectangle. All ranges are half-open; the upper left pixel is (0, 0).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SampleBlock {
    /// Columns of pixels.
    pub columns: Range<u32>,
    /// Rows of pixels.
    pub rows: Range<u32>,
    /// Samples of each pixel.
    pub samples: Range<u32>,
}

impl SampleBlock {
    /// Its pixels.
    pub fn window(&self) -> Window {
        Window { columns: self.columns.clone(), rows: self.rows.clone() }
    }

    /// Number of samples, over all pixels.
    pub fn count(&self) -> u64 {
        [&self.columns, &self.rows, &self.samples].into_iter().map(|range| u64::from(range_length(range))).product()
    }
}
