//! Pixels near others, in images whose pixels are stored row by row.

use rayon::prelude::*;

/// The pixels in the square around a pixel, with so many on each side, and itself.
pub(crate) fn square_around(pixel: usize, distance: usize, [width, height]: [usize; 2]) -> impl Iterator<Item = usize> {
    let range = |middle: usize, end: usize| middle.saturating_sub(distance)..(middle + distance + 1).min(end);
    let columns = range(pixel % width, width);
    range(pixel / width, height).flat_map(move |row| columns.clone().map(move |column| row * width + column))
}

/// Whether each pixel is at most `distance` rows and columns from one that is chosen.
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

/// Whether each place of a line is at most `distance` places from one that is chosen.
fn near_in_line(chosen: &[bool], distance: usize) -> Vec<bool> {
    let mut counts = vec![0];
    for (place, is_chosen) in chosen.iter().enumerate() {
        counts.push(counts[place] + u32::from(*is_chosen));
    }
    let end = chosen.len();
    (0..end).map(|place| counts[(place + distance + 1).min(end)] > counts[place.saturating_sub(distance)]).collect()
}

/// The transpose of rows of so many values.
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
