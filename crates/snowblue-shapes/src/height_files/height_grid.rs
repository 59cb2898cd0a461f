//! Heights on a grid.

use glam::DVec2;

/// Greatest number of heights along a side of a map.
const MAX_SIDE: usize = 4096;

/// Heights on a grid, row by row from the far side (greatest y, the north) to the near side, each from left to right.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightGrid {
    /// Number of columns.
    pub columns: usize,
    /// Heights in m where there is a georeference; else values of pixels, white being 1.
    pub values: Vec<f32>,
    /// Place of the heights, if the file gives it.
    pub georeference: Option<Georeference>,
    /// The value that marks missing heights.
    pub no_data: Option<f32>,
}

/// Place of the heights of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Georeference {
    /// Position of the first height of the first row, to the east and to the north, in m.
    pub far_left_m: DVec2,
    /// Distance between two columns and between two rows, in m.
    pub cell_m: DVec2,
}

/// The part of a map that is used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Its middle, in the coordinates of the grid.
    pub centre_m: DVec2,
    /// Its lengths to the east and to the north.
    pub size_m: DVec2,
}

impl HeightGrid {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.values.len() / self.columns
    }

    /// The heights of this grid in a window, and the position of the first of these heights. The edges of the window
    /// are rounded to heights of the grid.
    ///
    /// # Errors
    ///
    /// When the window reaches beyond the grid, or has fewer than two rows or columns.
    pub fn cropped(&self, georeference: &Georeference, window: &Window) -> Result<(Self, DVec2), String> {
        let Georeference { far_left_m, cell_m } = *georeference;
        let (columns, rows) = (self.columns, self.rows());
        let half_m = 0.5 * window.size_m;
        let left_m = window.centre_m.x - half_m.x - far_left_m.x;
        let far_m = far_left_m.y - (window.centre_m.y + half_m.y);
        let first = |from_m: f64, cell_m: f64| (from_m / cell_m).round();
        let (left, far) = (first(left_m, cell_m.x), first(far_m, cell_m.y));
        let (right, near) = (first(left_m + window.size_m.x, cell_m.x), first(far_m + window.size_m.y, cell_m.y));
        if left < 0.0 || far < 0.0 || right > (columns - 1) as f64 || near > (rows - 1) as f64 {
            let size_m = cell_m * DVec2::new((columns - 1) as f64, (rows - 1) as f64);
            let (east, north) = (far_left_m.x + size_m.x, far_left_m.y);
            return Err(format!(
                "reaches beyond the grid, which covers x = {} to {east} m and y = {} to {north} m",
                far_left_m.x,
                north - size_m.y
            ));
        }
        if right < left + 1.0 || near < far + 1.0 {
            return Err(format!("holds fewer than 2 × 2 heights, which are {} by {} m apart", cell_m.x, cell_m.y));
        }
        let [left, right, far, near] = [left, right, far, near].map(whole);
        let row = |row: usize| &self.values[row * columns + left..=row * columns + right];
        let begins_m = far_left_m + cell_m * DVec2::new(left as f64, -(far as f64));
        let cropped = Self {
            columns: right - left + 1,
            values: (far..=near).flat_map(row).copied().collect(),
            georeference: self.georeference,
            no_data: self.no_data,
        };
        Ok((cropped, begins_m))
    }

    /// Replaces missing heights by `fill`.
    ///
    /// # Errors
    ///
    /// When heights are missing and `fill` is none.
    pub fn filled(mut self, fill: Option<f32>) -> Result<Self, String> {
        let no_data = self.no_data;
        let is_missing = |value: &f32| {
            // Readers store NaN only for missing heights.
            value.is_nan() || no_data.is_some_and(|no_data| no_data.to_bits() == value.to_bits())
        };
        let Some(first) = self.values.iter().position(is_missing) else { return Ok(self) };
        let Some(fill) = fill else {
            let count = self.values.iter().filter(|value| is_missing(value)).count();
            return Err(format!(
                "{count} of {} heights are missing, the first in row {} and column {} (1 is the first)",
                self.values.len(),
                first / self.columns + 1,
                first % self.columns + 1
            ));
        };
        self.values.iter_mut().filter(|value| is_missing(value)).for_each(|value| *value = fill);
        Ok(self)
    }
}

/// Rejects a map with more heights than allowed, or with fewer heights than a surface needs.
pub(super) fn check_size(columns: usize, rows: usize) -> Result<(), String> {
    if (2..=MAX_SIDE).contains(&columns) && (2..=MAX_SIDE).contains(&rows) {
        return Ok(());
    }
    Err(format!("the grid is {columns} × {rows}, but must be 2 × 2 to {MAX_SIDE} × {MAX_SIDE}"))
}

/// Rejects distances between heights that are out of range.
pub(super) fn check_cell(cell_m: DVec2) -> Result<(), String> {
    match cell_m.to_array().into_iter().find(|cell| !(1e-4..=1e5).contains(cell)) {
        Some(cell) => Err(format!("the cell size is {cell} m, but must lie in 0.0001 to 100000 m")),
        None => Ok(()),
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place within a grid")]
fn whole(place: f64) -> usize {
    place as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> HeightGrid {
        HeightGrid { columns: 4, values: (0..12u8).map(f32::from).collect(), georeference: None, no_data: Some(6.0) }
    }

    #[test]
    fn a_window_holds_the_nearest_heights() {
        let place = Georeference { far_left_m: DVec2::new(100.0, 520.0), cell_m: DVec2::new(5.0, 10.0) };
        let window = Window { centre_m: DVec2::new(108.0, 506.0), size_m: DVec2::new(10.0, 10.0) };
        let (cropped, begins_m) = grid().cropped(&place, &window).unwrap();
        // x = 103 to 113 m are columns 1 to 3, y = 511 to 501 m are rows 1 and 2.
        assert_eq!((cropped.columns, cropped.values), (3, vec![5.0, 6.0, 7.0, 9.0, 10.0, 11.0]));
        assert_eq!(begins_m, DVec2::new(105.0, 510.0));
        let beyond = Window { centre_m: DVec2::new(130.0, 506.0), ..window };
        let message = grid().cropped(&place, &beyond).unwrap_err();
        assert_eq!(message, "reaches beyond the grid, which covers x = 100 to 115 m and y = 500 to 520 m");
        let narrow = Window { size_m: DVec2::new(0.1, 10.0), ..window };
        assert!(grid().cropped(&place, &narrow).unwrap_err().contains("fewer than 2 × 2 heights"));
    }

    #[test]
    fn missing_heights_are_counted_or_filled() {
        let message = grid().filled(None).unwrap_err();
        assert!(message.contains("1 of 12 heights are missing, the first in row 2 and column 3"), "{message}");
        assert_eq!(grid().filled(Some(-1.0)).unwrap().values[6].to_bits(), (-1.0f32).to_bits());
        let whole = HeightGrid { no_data: None, ..grid() };
        assert_eq!(whole.clone().filled(None).unwrap(), whole);
    }
}
