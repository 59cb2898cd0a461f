//! Pixels of an image: rectangles of pixels, blocks of their samples, and neighbourhoods.

use std::ops::Range;

use rayon::prelude::*;
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

/// The pixels in the square around a pixel, with `distance` pixels on each side and the pixel itself.
pub(crate) fn square_around(pixel: usize, distance: usize, [width, height]: [usize; 2]) -> impl Iterator<Item = usize> {
    let range = |middle: usize, end: usize| middle.saturating_sub(distance)..(middle + distance + 1).min(end);
    let columns = range(pixel % width, width);
    range(pixel / width, height).flat_map(move |row| columns.clone().map(move |column| row * width + column))
}

/// Whether each pixel is at most `distance` rows and columns from a chosen pixel.
pub(crate) fn near(chosen: &[bool], distance: usize, width: usize) -> Vec<bool> {
    if chosen.is_empty() {
        return Vec::new();
    }
    let height = chosen.len() / width;
    let in_lines = |pixels: &[bool], length: usize| -> Vec<bool> {
        pixels.par_chunks(length).flat_map_iter(|line| near_in_line(line, distance)).collect()
    };
    let by_rows = transposed(&in_lines(chosen, width), width);
    transposed(&in_lines(&by_rows, height), height)
}

/// Whether each place of a line is at most `distance` places from a chosen place.
fn near_in_line(chosen: &[bool], distance: usize) -> Vec<bool> {
    let mut counts = vec![0];
    for (place, is_chosen) in chosen.iter().enumerate() {
        counts.push(counts[place] + u32::from(*is_chosen));
    }
    let end = chosen.len();
    (0..end).map(|place| counts[(place + distance + 1).min(end)] > counts[place.saturating_sub(distance)]).collect()
}

/// The transpose of rows of `width` values.
fn transposed(values: &[bool], width: usize) -> Vec<bool> {
    (0..width).flat_map(|column| values.iter().skip(column).step_by(width).copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_near_chosen_ones_are_those_whose_squares_have_one() {
        let size @ [width, height] = [13, 7];
        let chosen: Vec<bool> = (0..width * height).map(|pixel| [0, 20, 60].contains(&pixel)).collect();
        for distance in [0, 1, 3, 20] {
            let expected = |pixel: usize| square_around(pixel, distance, size).any(|other| chosen[other]);
            let expected: Vec<bool> = (0..chosen.len()).map(expected).collect();
            assert_eq!(near(&chosen, distance, width), expected, "{distance}");
        }
        assert!(square_around(20, 1, size).eq([6, 7, 8, 19, 20, 21, 32, 33, 34]));
        assert!(square_around(12, 1, size).eq([11, 12, 24, 25]));
    }
}
