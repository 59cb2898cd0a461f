//! ESRI ASCII grids: lines of `ncols`, `nrows`, the place of the lower left corner (`xllcorner`, `yllcorner`) or of the
//! middle of the cell there (`xllcenter`, `yllcenter`), `cellsize` or `dx` and `dy`, and `NODATA_value`; then the
//! heights, row by row from the north (Esri, *ArcGIS Pro*, "Esri ASCII raster format"; `dx` and `dy` are GDAL's). The
//! system of the map stands in another file, in well-known text.

use std::collections::BTreeMap;

use glam::DVec2;
use snowblue_base::narrow;

use crate::height_files::height_grid::{Georeference, HeightGrid, StatedByUser, check_size};
use crate::height_files::units;

/// The value that marks missing heights where the header does not state one, by the format.
const USUAL_NO_DATA: f64 = -9999.0;

/// The keys of the header.
const KEYS: [&str; 10] =
    ["ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "cellsize", "dx", "dy", "nodata_value"];

/// Reads a grid. `system` is the system of the map, in well-known text.
pub(super) fn read(text: &str, system: Option<&str>, stated: &StatedByUser) -> Result<HeightGrid, String> {
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
    let cell = match (value("cellsize"), value("dx"), value("dy")) {
        (Some(side), None, None) => DVec2::splat(side),
        (None, Some(dx), Some(dy)) => DVec2::new(dx, dy),
        _ => return Err("the cell size is missing: either cellsize, or dx and dy".to_owned()),
    };
    let place = |corner: &str, centre: &str, cell: f64| match (value(corner), value(centre)) {
        (Some(corner), None) => Ok(corner + 0.5 * cell),
        (None, Some(centre)) => Ok(centre),
        _ => Err(format!("the place is missing: either {corner} or {centre}")),
    };
    let near_left = DVec2::new(place("xllcorner", "xllcenter", cell.x)?, place("yllcorner", "yllcenter", cell.y)?);
    let no_data = narrow(value("nodata_value").unwrap_or(USUAL_NO_DATA));
    let mut values = Vec::with_capacity(columns * rows);
    let may_be_nan = no_data.is_nan();
    for word in words.by_ref().take(columns * rows) {
        values.push(match word {
            _ if may_be_nan && word.eq_ignore_ascii_case("nan") => f32::NAN,
            _ => narrow(number(word, "a height")?),
        });
    }
    if values.len() < columns * rows {
        return Err(format!("there are {} heights, but must be {columns} × {rows}", values.len()));
    }
    if let Some(word) = words.next() {
        return Err(format!("\"{}\" follows the {columns} × {rows} heights", shortened(word)));
    }
    let size = cell * DVec2::new((columns - 1) as f64, (rows - 1) as f64);
    let far_left = near_left + DVec2::new(0.0, size.y);
    let unit_m = match (stated.map_unit_m, system) {
        (stated_m, Some(text)) => units::of_well_known_text(text, far_left, stated_m).map(Some),
        (Some(unit_m), None) => Ok(Some(unit_m)),
        (None, None) => units::check_unstated([far_left, near_left + DVec2::new(size.x, 0.0)], cell).map(|()| None),
    };
    let georeference = unit_m.and_then(|unit_m| {
        let height_unit_m = stated.height_unit_m.map_or_else(|| units::of_unstated_heights(unit_m), Ok)?;
        Georeference::new(far_left, cell, unit_m, height_unit_m)
    });
    HeightGrid::new(columns, values, [Some(no_data), stated.no_data], georeference.map(Some))
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

    fn read(text: &str) -> Result<HeightGrid, String> {
        super::read(text, None, &StatedByUser::default())
    }

    const GRID: &str = "NCOLS 3\nnrows 2\nxllcorner 1000\nyllcorner 2000\ncellsize 10\nNODATA_value -9999\n\
        1 2.5 -9999\n4e0 5 6\n";

    #[test]
    fn heights_have_the_places_of_cell_middles() {
        let grid = read(GRID).unwrap();
        assert_eq!((grid.columns, &grid.values[..2], &grid.values[3..]), (3, &[1.0, 2.5][..], &[4.0, 5.0, 6.0][..]));
        assert!(grid.values[2].is_nan());
        let place = |x: f64, y: f64, cell: [f64; 2]| {
            Ok(Some(Georeference::new(DVec2::new(x, y), cell.into(), None, 1.0).unwrap()))
        };
        assert_eq!(grid.georeference, place(1005.0, 2015.0, [10.0; 2]));
        let centred = GRID.replace("corner", "center").replace("cellsize 10", "dx 10\ndy 20");
        assert_eq!(read(&centred).unwrap().georeference, place(1000.0, 2020.0, [10.0, 20.0]));
    }

    #[test]
    fn a_height_of_9999_below_zero_is_missing_where_the_header_states_no_other_value() {
        let unstated = read(&GRID.replace("NODATA_value -9999\n", "")).unwrap();
        assert_eq!(unstated.values.iter().filter(|value| value.is_nan()).count(), 1);
        let message = read(&GRID.replace("NODATA_value -9999\n", "NODATA_value -1\n")).unwrap_err();
        assert!(message.starts_with("1 of 6 heights are -9999.0, which often marks missing heights"), "{message}");
    }

    /// The system of a map in Washington in feet, as ArcGIS writes it.
    const FEET: &str = "PROJCS[\"NAD_1983_StatePlane_Washington_North_FIPS_4601_Feet\",\
        GEOGCS[\"GCS_North_American_1983\",\
        DATUM[\"D_North_American_1983\",SPHEROID[\"GRS_1980\",6378137.0,298.257222101]],PRIMEM[\"Greenwich\",0.0],\
        UNIT[\"Degree\",0.0174532925199433]],PROJECTION[\"Lambert_Conformal_Conic\"],PARAMETER[\"Latitude_Of_Origin\",\
        47.0],UNIT[\"Foot_US\",0.3048006096012192]]";

    #[test]
    fn the_unit_is_the_unit_of_the_file_beside_it_or_the_users() {
        let stated = StatedByUser::default();
        let cell_m = |system: &str, stated: &StatedByUser| {
            super::read(GRID, Some(system), stated).unwrap().georeference.map(|place| place.unwrap().cell_m.x)
        };
        // Ten US survey feet of 1200/3937 m.
        let metres_high = StatedByUser { height_unit_m: Some(1.0), ..stated };
        assert!((cell_m(FEET, &metres_high).unwrap() - 12_000.0 / 3937.0).abs() < 1e-12);
        assert!(cell_m(FEET, &stated).unwrap_err().contains("`unit = \"ft\"` or `unit = \"m\"` says it"));
        assert_eq!(cell_m("PROJCRS[\"x\",CS[Cartesian,2],LENGTHUNIT[\"metre\",1]]", &stated), Ok(10.0));
        assert_eq!(cell_m(FEET, &StatedByUser { map_unit_m: Some(2.0), ..metres_high }), Ok(20.0));
        // A stated unit makes no metres of degrees or of a distorted map.
        let refused = |system: &str| {
            let metres = StatedByUser { map_unit_m: Some(1.0), ..metres_high };
            assert!(cell_m(system, &metres).is_err() || cell_m(system, &stated).unwrap_err().contains("`map_unit`"));
            cell_m(system, &stated).unwrap_err()
        };
        assert!(refused("GEOGCS[\"WGS 84\",UNIT[\"degree\",0.0174]]").contains("the map is in degrees: `gdalwarp"));
        for degrees in [
            "Projection    GEOGRAPHIC\nUnits DD",
            "GEOGCRS[\"WGS 84\",CS[ellipsoidal,2],ANGLEUNIT[\"degree\",0.0174]]",
            "COMPD_CS[\"x\",GEOGCS[\"WGS 84\",UNIT[\"degree\",0.0174]],VERT_CS[\"EGM96\",UNIT[\"metre\",1]]]",
        ] {
            assert!(refused(degrees).contains("the map is in degrees: `gdalwarp"), "{degrees}");
        }
        assert!(refused("GEODCRS[\"WGS 84\",CS[Cartesian,3],LENGTHUNIT[\"metre\",1]]").contains("geocentric"));
        assert!(refused("Projection UTM\nZone 32\nUnits METERS").contains("`map_unit` says its unit"));
        for name in ["Mercator", "Plate_Carree", "Cylindrical_Equal_Area", "Mollweide", "Equidistant_Cylindrical"] {
            let world = FEET.replace("Lambert_Conformal_Conic", name);
            assert!(
                refused(&world).contains("a projection of the whole Earth") && refused(&world).contains("EPSG:326ZZ")
            );
        }
        // The place of a web map is known: x = 1005 m lies just east of Greenwich.
        let web = FEET.replace("Lambert_Conformal_Conic", "Mercator_Auxiliary_Sphere");
        assert!(refused(&web).contains("EPSG:32631"));
        let conversion =
            "PROJCRS[\"x\",CONVERSION[\"y\",METHOD[\"Lambert Cylindrical Equal Area\"]],LENGTHUNIT[\"m\",1]]";
        assert!(refused(conversion).contains("a projection of the whole Earth"));
        assert!(refused("Projection  MERCATOR\nUnits METERS").contains("a projection of the whole Earth"));
        for local in ["Transverse_Mercator", "Hotine_Oblique_Mercator_Azimuth_Center", "Lambert_Azimuthal_Equal_Area"] {
            assert!(cell_m(&FEET.replace("Lambert_Conformal_Conic", local), &metres_high).is_ok());
        }
        // ArcGIS appends the system of the heights.
        let with_heights = format!("{FEET},VERTCS[\"NAVD_1988\",VDATUM[\"x\"],UNIT[\"Meter\",1.0]]");
        assert_eq!(cell_m(&with_heights, &metres_high), cell_m(FEET, &metres_high));
        let compound = format!("COMPD_CS[\"x\",{with_heights}]");
        assert_eq!(cell_m(&compound, &metres_high), cell_m(FEET, &metres_high));
    }

    #[test]
    fn grids_that_may_be_in_degrees_need_a_unit() {
        // One second of arc south of Zermatt, 46° N and 7.7° E, which lies in zone 32 of UTM.
        let degrees =
            GRID.replace("1000", "7.7").replace("2000", "46").replace("cellsize 10", "cellsize 0.000277777778");
        let message = read(&degrees).unwrap().georeference.unwrap_err();
        assert!(message.contains("are degrees or metres: `gdalwarp -s_srs EPSG:4326 -t_srs EPSG:32632"), "{message}");
        assert!(message.contains("`map_unit = \"m\"` says that they are metres"), "{message}");
        let south = degrees.replace("yllcorner 46", "yllcorner -46");
        assert!(read(&south).unwrap().georeference.unwrap_err().contains("EPSG:32732"));
        let metres = StatedByUser { map_unit_m: Some(1.0), height_unit_m: Some(0.3048), ..StatedByUser::default() };
        let place = super::read(&degrees, None, &metres).unwrap().georeference.unwrap().unwrap();
        assert_eq!((place.cell_m.x, place.height_unit_m), (0.000_277_777_778, 0.3048));
        // Longitudes that count from 0: 352.3° E is 7.7° W, in zone 29.
        let west = degrees.replace("xllcorner 7.7", "xllcorner 352.3");
        assert!(read(&west).unwrap().georeference.unwrap_err().contains("-t_srs EPSG:32629"));
        // A cell of a degree would be wider than any map.
        assert!(read(&degrees.replace("0.000277777778", "1")).unwrap().georeference.is_ok());
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
            ("cellsize 10", "dx 10", "either cellsize, or dx and dy"),
            ("xllcorner", "xllcenter 0\nxllcorner", "either xllcorner or xllcenter"),
            ("1 2.5", "nan 2.5", "a height is NaN, but must be finite"),
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
