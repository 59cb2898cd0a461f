//! Rectangles of pixels.

use std::ops::Range;

use snowblue_scene::film::ImageSize;

/// A rectangle of pixels. Both ranges are half-open; the upper left pixel of the image is (0, 0).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Window {
    /// Columns, from the left.
    pub columns: Range<u32>,
    /// Rows, from the top.
    pub rows: Range<u32>,
}

impl Window {
    /// All pixels of an image.
    pub fn of_image(size: ImageSize) -> Self {
        Self { columns: 0..size.width, rows: 0..size.height }
    }

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
