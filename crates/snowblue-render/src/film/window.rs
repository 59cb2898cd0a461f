//! Image sizes, pixels and rectangles of pixels.

use std::ops::Range;

/// Size of an image in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageSize {
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

impl ImageSize {
    /// Number of pixels.
    pub fn pixel_count(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// All pixels of the image.
    pub fn window(self) -> Window {
        Window { columns: 0..self.width, rows: 0..self.height }
    }
}

/// Position of a pixel. The upper left pixel is (0, 0).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pixel {
    /// Column, from the left.
    pub column: u32,
    /// Row, from the top.
    pub row: u32,
}

/// A rectangle of pixels. Both ranges are half-open; the upper left pixel of the image is (0, 0).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Window {
    /// Columns, from the left.
    pub columns: Range<u32>,
    /// Rows, from the top.
    pub rows: Range<u32>,
}

impl Window {
    /// Number of columns and rows.
    pub fn size(&self) -> ImageSize {
        ImageSize { width: range_length(&self.columns), height: range_length(&self.rows) }
    }

    /// The smallest window that contains both.
    #[must_use]
    pub fn enclosing(&self, other: &Self) -> Self {
        let around = |one: &Range<u32>, other: &Range<u32>| one.start.min(other.start)..one.end.max(other.end);
        Self { columns: around(&self.columns, &other.columns), rows: around(&self.rows, &other.rows) }
    }

    /// Whether all pixels of `other` lie in this window.
    pub fn contains(&self, other: &Self) -> bool {
        self.enclosing(other) == *self
    }
}

/// Number of values in a range; 0 if it is reversed.
pub(crate) fn range_length(range: &Range<u32>) -> u32 {
    range.end.saturating_sub(range.start)
}
