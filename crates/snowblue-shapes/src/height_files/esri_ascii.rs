//! ESRI ASCII grids: lines of `ncols`, `nrows`, the place of the lower left corner (`xllcorner`, `yllcorner`) or of the
//! middle of the cell there (`xllcenter`, `yllcenter`), `cellsize` or `dx` and `dy`, and `NODATA_value`; then the
//! heights, row by row from the north (Esri, *ArcGIS Pro*, "Esri ASCII raster format"; `dx` and `dy` are GDAL's).

use std::collections::BTreeMap;

use glam::DVec2;
use snowblue_base::narrow;

use crate::height_files::height_grid::{Georeference, HeightGrid, check_cell, check_size};

/// The keys of the header.
const KEYS: [&str; 10] =
    ["ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "cellsize", "dx", "dy", "nodata_value"];

/// Reads a grid.
pub(super) fn read(text: &str) -> Result<HeightGrid, String> {
    let mut words = text.split_ascii_whitespace().peekable();
    let mut header = BTreeMap::new();
    // Words such as "nan" are numbers, though not finite numbers.
    let is_key =
        |word: &str| word.starts_with(|first: char| first.is_ascii_alphabetic()) && word.parse::<f64>().is_err();
    while let Some(word) = words.next_if(|word| is_key(word)) {
        let Some(key) = KEYS.into_iter().find(|key| word.eq_ignore_ascii_case(key)) else {
            return Err(format!("the key \"{}\" is unknown; known are {}", shortened(word), KEYS.join(", ")));
        };
        let value = words.next().ok_or_else(|| format!("{key} has no value"))?;
        // NaN may mark a missing height.
        let value = match key {
            "nodata_value" if value.eq_ignore_ascii_case("nan") => f64::NAN,
            _ => number(value, key)?,
        };
        if header.insert(key, value).is_some() {
            return Err(format!("{key} is given twice"));
        }
    }
    let value = |key: &str| header.get(key).copied();
    let required = |key: &str| value(key).ok_or_else(|| format!("{key} is missing"));
    let (columns, rows) = (count("ncols", required("ncols")?)?, count("nrows", required("nrows")?)?);
    check_size(columns, rows)?;
    // Each height has at least one digit, and each height but the last has a space behind it.
    if text.len() < 2 * columns * rows - 1 {
        return Err(format!("the file has {} bytes, too few for {columns} × {rows} heights", text.len()));
    }
    let cell_m = match (value("cellsize"), value("dx"), value("dy")) {
        (Some(side), None, None) => DVec2::splat(side),
        (None, Some(dx), Some(dy)) => DVec2::new(dx, dy),
        _ => return Err("the cell size is missing: either cellsize, or dx and dy".to_owned()),
    };
    check_cell(cell_m)?;
    let place = |corner: &str, centre: &str, cell: f64| match (value(corner), value(centre)) {
        (Some(corner), None) => Ok(corner + 0.5 * cell),
        (None, Some(centre)) => Ok(centre),
        _ => Err(format!("the place is missing: either {corner} or {centre}")),
    };
    let near_left_m =
        DVec2::new(place("xllcorner", "xllcenter", cell_m.x)?, place("yllcorner", "yllcenter", cell_m.y)?);
    let no_data = value("nodata_value").map(narrow);
    let mut values = Vec::with_capacity(columns * rows);
    let may_be_nan = no_data.is_some_and(f32::is_nan);
    for word in words.by_ref().take(columns * rows) {
        let height = match word {
            _ if may_be_nan && word.eq_ignore_ascii_case("nan") => f32::NAN,
            _ => narrow(number(word, "a height")?),
        };
        if height.is_infinite() {
            return Err(format!("a height is {}, but must be finite", shortened(word)));
        }
        values.push(height);
    }
    if values.len() < columns * rows {
        return Err(format!("there are {} heights, but must be {columns} × {rows}", values.len()));
    }
    if let Some(word) = words.next() {
        return Err(format!("\"{}\" follows the {columns} × {rows} heights", shortened(word)));
    }
    let far_left_m = near_left_m + DVec2::new(0.0, (rows - 1) as f64 * cell_m.y);
    Ok(HeightGrid { columns, values, georeference: Some(Georeference { far_left_m, cell_m }), no_data })
}

fn number(word: &str, what: &str) -> Result<f64, String> {
    let number: f64 = word.parse().map_err(|_| format!("{what} is \"{}\", but must be a number", shortened(word)))?;
    if number.is_finite() { Ok(number) } else { Err(format!("{what} is {number}, but must be finite")) }
}

/// A whole number of rows or columns.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a whole number below 2^32")]
fn count(key: &str, number: f64) -> Result<usize, String> {
    if number.fract().abs() <= 0.0 && (0.0..4_294_967_296.0).contains(&number) {
        return Ok(number as usize);
    }
    Err(format!("{key} is {number}, but must be a whole number"))
}

/// The beginning of a word, for messages.
fn shortened(word: &str) -> String {
    word.chars().take(24).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: &str = "NCOLS 3\nnrows 2\nxllcorner 1000\nyllcorner 2000\ncellsize 10\nNODATA_value -9999\n\
        1 2.5 -9999\n4e0 5 6\n";

    #[test]
    fn heights_have_the_places_of_cell_middles() {
        let grid = read(GRID).unwrap();
        assert_eq!((grid.columns, grid.values.as_slice()), (3, [1.0, 2.5, -9999.0, 4.0, 5.0, 6.0].as_slice()));
        assert_eq!(grid.no_data, Some(-9999.0));
        let place = Georeference { far_left_m: DVec2::new(1005.0, 2015.0), cell_m: DVec2::splat(10.0) };
        assert_eq!(grid.georeference, Some(place));
        let centred = GRID.replace("corner", "center").replace("cellsize 10", "dx 10\ndy 20");
        let place = Georeference { far_left_m: DVec2::new(1000.0, 2020.0), cell_m: DVec2::new(10.0, 20.0) };
        assert_eq!(read(&centred).unwrap().georeference, Some(place));
    }

    #[test]
    fn no_number_may_stand_for_no_height() {
        let grid = read(&GRID.replace("-9999", "nan")).unwrap();
        assert!(grid.values[2].is_nan());
        assert!(grid.filled(None).unwrap_err().contains("1 of 6 heights are missing, the first in row 1 and column 3"));
    }

    #[test]
    fn malformed_grids_are_named() {
        for (right, wrong, expected) in [
            ("NCOLS 3", "ncols 1000000000", "the grid is 1000000000 × 2, but must be 2 × 2 to 4096 × 4096"),
            ("NCOLS 3", "ncols 4000", "the file has"),
            ("NCOLS 3", "ncols 2.5", "ncols is 2.5, but must be a whole number"),
            ("NCOLS 3", "ncols -3", "ncols is -3, but must be a whole number"),
            ("NCOLS 3\n", "", "ncols is missing"),
            ("nrows 2", "nrows 2\nnrows 2", "nrows is given twice"),
            ("nrows 2", "rows 2", "the key \"rows\" is unknown; known are ncols"),
            ("cellsize 10", "cellsize 0", "the cell size is 0 m, but must lie in"),
            ("cellsize 10", "dx 10", "either cellsize, or dx and dy"),
            ("xllcorner", "xllcenter 0\nxllcorner", "either xllcorner or xllcenter"),
            ("1 2.5", "nan 2.5", "a height is NaN, but must be finite"),
            ("2.5", "1e39", "a height is 1e39, but must be finite"),
            ("2.5", "2,5", "a height is \"2,5\", but must be a number"),
            ("4e0 5 6", "4e0 5", "there are 5 heights, but must be 3 × 2"),
            ("4e0 5 6", "4e0 5 6 7", "\"7\" follows the 3 × 2 heights"),
            (GRID, "", "ncols is missing"),
            (GRID, "ncols", "ncols has no value"),
        ] {
            let message = read(&GRID.replacen(right, wrong, 1)).unwrap_err();
            assert!(message.contains(expected) && !message.contains('\n'), "{wrong}: {message}");
        }
    }
}
