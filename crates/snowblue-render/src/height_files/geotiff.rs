//! GeoTIFF: heights as a TIFF of one band, and tags that say where they lie (Open Geospatial Consortium 2019, *OGC
//! GeoTIFF Standard* 1.1, document 19-008r4).
//!
//! `ModelPixelScaleTag` and `ModelTiepointTag`, or `ModelTransformationTag`, map columns and rows to the east and
//! north. The key 1024 of `GeoKeyDirectoryTag` distinguishes maps in metres from those in degrees, the key 1025 whether
//! a tie point is the corner of a pixel or its middle. Heights are in metres. GDAL's tag 42113 is the text of the value
//! that stands for no height.

use std::io::Cursor;

use glam::DVec2;
use tiff::TiffError;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;
use tiff::{ColorType, decoder::ifd::Value};

use crate::geometry::ray::narrow;
use crate::height_files::{Georeference, HeightGrid, check_cell, check_size};

/// Codes of the keys that are read, by table 2 of the standard, and of their values.
const MODEL_TYPE: u16 = 1024;
const GEOGRAPHIC: u16 = 2;
const GEOCENTRIC: u16 = 3;
const RASTER_TYPE: u16 = 1025;
const PIXEL_IS_POINT: u16 = 2;
const LINEAR_UNITS: u16 = 3076;
const VERTICAL_UNITS: u16 = 4099;
const METRE: u16 = 9001;
/// The value of a key that the file defines itself, and one that stands for none.
const USER_DEFINED: u16 = 32_767;

type File<'a> = Decoder<Cursor<&'a [u8]>>;

/// Reads a grid.
pub(super) fn read(bytes: &[u8]) -> Result<HeightGrid, String> {
    let mut file = Decoder::new(Cursor::new(bytes)).map_err(unreadable)?;
    let (width, height) = file.dimensions().map_err(unreadable)?;
    let (columns, rows) = (width as usize, height as usize);
    check_size(columns, rows)?;
    let colour = file.colortype().map_err(unreadable)?;
    if !matches!(colour, ColorType::Gray(_)) {
        return Err(format!("the image is {colour:?}, but must have one band of heights"));
    }
    let georeference = georeference(&mut file)?;
    let no_data = no_data(&mut file)?;
    let mut values = heights(file.read_image().map_err(unreadable)?)?;
    if values.len() != columns * rows {
        return Err(format!("there are {} heights, but must be {columns} × {rows}", values.len()));
    }
    for value in &mut values {
        // In a map, a value that is no number stands for no height.
        if value.is_infinite() && no_data.is_none_or(|no_data| no_data.to_bits() != value.to_bits()) {
            return Err(format!("a height is {value}, but must be finite"));
        }
    }
    Ok(HeightGrid { columns, values, georeference, no_data })
}

fn unreadable(error: TiffError) -> String {
    format!("not a readable TIFF file: {error}").replace('\n', " ")
}

/// The values in single precision.
fn heights(decoded: DecodingResult) -> Result<Vec<f32>, String> {
    Ok(match decoded {
        DecodingResult::U8(values) => values.into_iter().map(f32::from).collect(),
        DecodingResult::I8(values) => values.into_iter().map(f32::from).collect(),
        DecodingResult::U16(values) => values.into_iter().map(f32::from).collect(),
        DecodingResult::I16(values) => values.into_iter().map(f32::from).collect(),
        DecodingResult::U32(values) => values.into_iter().map(|value| narrow(value.into())).collect(),
        DecodingResult::I32(values) => values.into_iter().map(|value| narrow(value.into())).collect(),
        DecodingResult::F32(values) => values,
        DecodingResult::F64(values) => values.into_iter().map(narrow).collect(),
        DecodingResult::F16(_) | DecodingResult::U64(_) | DecodingResult::I64(_) => {
            return Err("the heights are of a kind that is not read; write them as Float32".to_owned());
        }
    })
}

/// The value that stands for no height.
fn no_data(file: &mut File) -> Result<Option<f32>, String> {
    let Some(value) = file.find_tag(Tag::GdalNodata).map_err(unreadable)? else { return Ok(None) };
    let text = value.into_string().map_err(unreadable)?;
    let text = text.trim_matches(|letter: char| letter.is_whitespace() || letter == '\0');
    let number: f64 = text.parse().map_err(|_| format!("GDAL_NODATA is \"{text}\", but must be a number"))?;
    Ok(Some(narrow(number)))
}

/// Where the heights lie; none if the file does not say it.
fn georeference(file: &mut File) -> Result<Option<Georeference>, String> {
    let scale = numbers(file, Tag::ModelPixelScaleTag)?;
    let tie_point = numbers(file, Tag::ModelTiepointTag)?;
    let matrix = numbers(file, Tag::ModelTransformationTag)?;
    let (corner_m, cell_m) = match (scale.as_deref(), tie_point.as_deref(), matrix.as_deref()) {
        (Some([dx, dy, ..]), Some([column, row, _, x, y, ..]), _) => {
            (DVec2::new(x - column * dx, y + row * dy), DVec2::new(*dx, *dy))
        }
        (_, _, Some([dx, by_row, _, x, by_column, dy, _, y, ..])) => {
            if *by_row != 0.0 || *by_column != 0.0 || *dx < 0.0 || *dy > 0.0 {
                return Err("the map is turned or mirrored, but its rows must run from west to east and its columns \
                            from north to south (gdalwarp makes such a map)"
                    .to_owned());
            }
            (DVec2::new(*x, *y), DVec2::new(*dx, -dy))
        }
        _ => return Ok(None),
    };
    let is_point = check_keys(file)?;
    check_cell(cell_m)?;
    let middle = if is_point { DVec2::ZERO } else { 0.5 * cell_m * DVec2::new(1.0, -1.0) };
    let far_left_m = corner_m + middle;
    if !far_left_m.is_finite() {
        return Err(format!("the map begins at {far_left_m}, but must begin at a finite place"));
    }
    Ok(Some(Georeference { far_left_m, cell_m }))
}

/// Refuses maps that are not in metres. Returns whether a tie point is the middle of a pixel.
fn check_keys(file: &mut File) -> Result<bool, String> {
    let directory = match file.find_tag(Tag::GeoKeyDirectoryTag).map_err(unreadable)? {
        Some(directory) => directory.into_u16_vec().map_err(unreadable)?,
        None => Vec::new(),
    };
    // A head of four numbers, then four for each key: the key, where its value is stored, how many values, the value.
    let (keys, _) = directory.as_chunks::<4>();
    let value = |key: u16| keys.iter().skip(1).find(|entry| entry[0] == key && entry[1] == 0).map(|entry| entry[3]);
    match value(MODEL_TYPE) {
        Some(GEOGRAPHIC) => {
            return Err("the map is in degrees, but must be in metres (`gdalwarp -t_srs EPSG:32632` makes such a map \
                        of 6° to 12° east); or leave its place out with `size`"
                .to_owned());
        }
        Some(GEOCENTRIC) => return Err("the map is geocentric, but must be projected in metres".to_owned()),
        _ => {}
    }
    for (key, what) in [(LINEAR_UNITS, "lengths"), (VERTICAL_UNITS, "heights")] {
        if let Some(unit) = value(key).filter(|unit| ![0, METRE, USER_DEFINED].contains(unit)) {
            return Err(format!("the unit of {what} is EPSG:{unit}, but must be the metre (EPSG:9001)"));
        }
    }
    Ok(value(RASTER_TYPE) == Some(PIXEL_IS_POINT))
}

/// The numbers of a tag.
fn numbers(file: &mut File, tag: Tag) -> Result<Option<Vec<f64>>, String> {
    file.find_tag(tag).map_err(unreadable)?.map(Value::into_f64_vec).transpose().map_err(unreadable)
}
