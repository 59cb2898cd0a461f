//! Heights on a grid.

use glam::DVec2;

/// Greatest number of heights along a side of a map.
const MAX_SIDE: usize = 4096;
/// Values by which files often mark missing heights without saying so.
const USUAL_NO_DATA: [f32; 5] = [-9999.0, -10_000.0, -32_767.0, -32_768.0, -99_999.0];
/// Values of this magnitude are marks of missing heights: no height is as far from 0 in any unit.
const MIN_HUGE: f32 = 1e9;
/// Two huge values are one mark if they differ by this fraction: texts of the least number of single precision differ.
const ROUNDING: f32 = 1e-6;

/// Heights on a grid, row by row from the far side (greatest y, the north) to the near side, each from left to right.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightGrid {
    /// Number of columns.
    pub columns: usize,
    /// Heights in the unit of the file, or values of pixels, white being 1; NaN where a height is missing.
    pub values: Vec<f32>,
    /// Place of the heights, if the file gives it, or the reason why the place that it gives cannot be used.
    pub georeference: Result<Option<Georeference>, String>,
}

/// What the user says of a file of heights, instead of the file.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StatedByUser {
    /// The value that marks missing heights.
    pub no_data: Option<f32>,
    /// The unit of the heights, in m.
    pub height_unit_m: Option<f64>,
    /// The unit of the coordinates of a map, in m.
    pub map_unit_m: Option<f64>,
}

/// Place of the heights of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Georeference {
    /// Position of the first height of the first row, to the east and to the north, in m.
    pub far_left_m: DVec2,
    /// Distance between two columns and between two rows, in m.
    pub cell_m: DVec2,
    /// The unit of the heights, in m.
    pub height_unit_m: f64,
    /// Whether the file or the user states the unit of the coordinates. Otherwise they count as metres.
    pub states_unit: bool,
}

impl Georeference {
    /// The place of heights by the place of the first height and the cell in the unit of a map, this unit in m if it is
    /// stated, and the unit of the heights in m.
    pub(super) fn new(first: DVec2, cell: DVec2, map_unit_m: Option<f64>, height_unit_m: f64) -> Result<Self, String> {
        let states_unit = map_unit_m.is_some();
        let map_unit_m = map_unit_m.unwrap_or(1.0);
        let (far_left_m, cell_m) = (first * map_unit_m, cell * map_unit_m);
        if let Some(cell_m) = cell_m.to_array().into_iter().find(|cell_m| !(1e-4..=1e5).contains(cell_m)) {
            return Err(format!("the cell size is {cell_m} m, but must lie in 0.0001 to 100000 m"));
        }
        if !far_left_m.is_finite() {
            return Err(format!("the map begins at {far_left_m}, but must begin at a finite place"));
        }
        Ok(Self { far_left_m, cell_m, height_unit_m, states_unit })
    }
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
    /// A grid of values among which NaN and two values mark missing heights, stated by the file and by the user.
    ///
    /// # Errors
    ///
    /// When a height is a usual mark of missing heights that the file does not state, while the user states none.
    pub fn new(
        columns: usize,
        mut values: Vec<f32>,
        [by_file, by_user]: [Option<f32>; 2],
        georeference: Result<Option<Georeference>, String>,
    ) -> Result<Self, String> {
        let marks = [by_file, by_user].into_iter().flatten();
        values
            .iter_mut()
            .filter(|value| marks.clone().any(|mark| is_mark(**value, mark)))
            .for_each(|value| *value = f32::NAN);
        let mut unstated = values.iter().copied().filter(|value| by_user.is_none() && is_usual_mark(*value));
        let Some(mark) = unstated.next() else { return Ok(Self { columns, values, georeference }) };
        let way_out = match unstated.find(|value| !is_mark(*value, mark)) {
            None => format!("`nodata = {mark:?}` if they are missing, else `nodata` with a value that no height has"),
            Some(other) => format!(
                "others are {other:?}, and `gdalwarp -srcnodata {mark} -dstnodata {other} IN.tif OUT.tif` makes one \
                 mark of both"
            ),
        };
        Err(format!(
            "{} of {} heights are {mark:?}, which often marks missing heights, but the file does not say so: {way_out}",
            values.iter().filter(|value| is_mark(**value, mark)).count(),
            values.len()
        ))
    }

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
        let Georeference { far_left_m, cell_m, .. } = *georeference;
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
            georeference: self.georeference.clone(),
        };
        Ok((cropped, begins_m))
    }

    /// Replaces missing heights by `fill`.
    ///
    /// # Errors
    ///
    /// When heights are missing and `fill` is none.
    pub fn filled(mut self, fill: Option<f32>) -> Result<Self, String> {
        let Some(first) = self.values.iter().position(|value| value.is_nan()) else { return Ok(self) };
        let Some(fill) = fill else {
            let count = self.values.iter().filter(|value| value.is_nan()).count();
            return Err(format!(
                "{count} of {} heights are missing, the first in row {} and column {} (1 is the first)",
                self.values.len(),
                first / self.columns + 1,
                first % self.columns + 1
            ));
        };
        self.values.iter_mut().filter(|value| value.is_nan()).for_each(|value| *value = fill);
        Ok(self)
    }
}

/// Whether a value is a mark of missing heights.
fn is_mark(value: f32, mark: f32) -> bool {
    let rounding = if mark.abs() < MIN_HUGE { 0.0 } else { ROUNDING * mark.abs() };
    value.to_bits() == mark.to_bits() || (value - mark).abs() <= rounding
}

fn is_usual_mark(value: f32) -> bool {
    value.is_finite() && (value.abs() >= MIN_HUGE || USUAL_NO_DATA.into_iter().any(|mark| is_mark(value, mark)))
}

/// Rejects a map with more heights than allowed, or with fewer heights than a surface needs.
pub(super) fn check_size(columns: usize, rows: usize) -> Result<(), String> {
    if (2..=MAX_SIDE).contains(&columns) && (2..=MAX_SIDE).contains(&rows) {
        return Ok(());
    }
    Err(format!("the grid is {columns} × {rows}, but must be 2 × 2 to {MAX_SIDE} × {MAX_SIDE}"))
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place within a grid")]
fn whole(place: f64) -> usize {
    place as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> HeightGrid {
        HeightGrid::new(4, (0..12u8).map(f32::from).collect(), [Some(6.0), None], Ok(None)).unwrap()
    }

    fn filled(fill: f32) -> HeightGrid {
        grid().filled(Some(fill)).unwrap()
    }

    #[test]
    fn a_window_holds_the_nearest_heights() {
        let place = Georeference::new(DVec2::new(100.0, 520.0), DVec2::new(5.0, 10.0), None, 1.0).unwrap();
        let window = Window { centre_m: DVec2::new(108.0, 506.0), size_m: DVec2::new(10.0, 10.0) };
        let (cropped, begins_m) = filled(-1.0).cropped(&place, &window).unwrap();
        // x = 103 to 113 m are columns 1 to 3, y = 511 to 501 m are rows 1 and 2.
        assert_eq!((cropped.columns, cropped.values), (3, vec![5.0, -1.0, 7.0, 9.0, 10.0, 11.0]));
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
        assert_eq!(filled(-1.0).values[6].to_bits(), (-1.0f32).to_bits());
        assert_eq!(filled(6.0).filled(None).unwrap(), filled(6.0));
    }

    #[test]
    fn usual_marks_of_missing_heights_must_be_stated() {
        // The least number of single precision as two programs print it, the marks of NetCDF and of Surfer, and the
        // least integer of 32 bits.
        let huge = [f32::MIN, -3.402_823e38, 1e20, 9.969_21e36, 1.701_41e38, -2_147_483_648.0];
        for mark in huge.into_iter().chain([-9999.0, -32_768.0, -32_767.0, -10_000.0, -99_999.0]) {
            let grid = |marks| HeightGrid::new(2, vec![1.0, mark, 2.0, 3.0], marks, Ok(None));
            // Another mark that the file states is no reason to overlook this one.
            for by_file in [None, Some(-1.0)] {
                let message = grid([by_file, None]).unwrap_err();
                assert!(message.starts_with(&format!("1 of 4 heights are {mark:?}")), "{message}");
                // The advice is a number of a scene file.
                let advice = message.split("`nodata = ").nth(1).unwrap().split('`').next().unwrap();
                assert_eq!(advice.parse::<f32>().unwrap().to_bits(), mark.to_bits());
                assert!(grid([by_file, Some(mark)]).unwrap().values[1].is_nan());
            }
            assert!(grid([Some(mark), None]).unwrap().values[1].is_nan());
            // A height that is known to be none of these is a height.
            assert_eq!(grid([None, Some(-7.0)]).unwrap().values[1].to_bits(), mark.to_bits());
        }
        // Nearly equal texts of the least number are one mark.
        let texts = HeightGrid::new(2, vec![1.0, -3.402_823e38, f32::MIN, 3.0], [Some(f32::MIN), None], Ok(None));
        assert_eq!(texts.unwrap().values.iter().filter(|value| value.is_nan()).count(), 2);
        let both =
            HeightGrid::new(2, vec![1.0, -9999.0, -32_768.0, 3.0], [Some(f32::MIN), None], Ok(None)).unwrap_err();
        assert!(both.contains("`gdalwarp -srcnodata -9999 -dstnodata -32768 IN.tif OUT.tif`"), "{both}");
        // The marks of the file and of the user are both marks.
        let both = HeightGrid::new(2, vec![1.0, -9999.0, -32_768.0, 3.0], [Some(-9999.0), Some(-32_768.0)], Ok(None));
        assert_eq!(both.unwrap().values.iter().filter(|value| value.is_nan()).count(), 2);
        // Neighbours of the marks are heights.
        let heights = vec![-9998.0, -9999.5, -32_766.0, 9e8];
        assert_eq!(HeightGrid::new(2, heights.clone(), [None; 2], Ok(None)).unwrap().values, heights);
    }
}
