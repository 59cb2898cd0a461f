//! GeoTIFF: heights as a TIFF of one band, and tags that say where they lie (Open Geospatial Consortium 2019, *OGC
//! GeoTIFF Standard* 1.1, document 19-008r4).
//!
//! `ModelPixelScaleTag` and `ModelTiepointTag`, or `ModelTransformationTag`, map columns and rows to the east and
//! north. In `GeoKeyDirectoryTag`, the key 1024 distinguishes maps in metres from maps in degrees, and the key 1025
//! says whether a tie point is the corner or the middle of a pixel. Heights are in metres. GDAL's tag 42113 holds the
//! text of the value that marks missing heights.

use std::io::Cursor;

use glam::DVec2;
use snowblue_base::files::check_memory;
use snowblue_base::narrow;
use tiff::TiffError;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;
use tiff::{ColorType, decoder::ifd::Value};

use crate::height_files::height_grid::{Georeference, HeightGrid, check_cell, check_size};

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
    // The heights as decoded, in double precision at most, and the heights in single precision.
    let height_bytes = size_of::<f64>() + size_of::<f32>();
    check_memory(&format!("{columns} × {rows} heights"), (columns * rows * height_bytes) as f64, bytes.len())?;
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
        // In a map, NaN marks a missing height.
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

/// The value that marks missing heights.
fn no_data(file: &mut File) -> Result<Option<f32>, String> {
    let Some(value) = file.find_tag(Tag::GdalNodata).map_err(unreadable)? else { return Ok(None) };
    let text = value.into_string().map_err(unreadable)?;
    let text = text.trim_matches(|letter: char| letter.is_whitespace() || letter == '\0');
    let number: f64 = text.parse().map_err(|_| format!("GDAL_NODATA is \"{text}\", but must be a number"))?;
    Ok(Some(narrow(number)))
}

/// The place of the heights; none if the file does not give it.
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
    // A head of four numbers, then four numbers for each key: the key, the place of its value, the number of values,
    // and the value.
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

#[cfg(test)]
mod tests {
    use tiff::encoder::colortype::{ColorType as Encoded, Gray8, Gray16, Gray32Float, Gray64Float, GrayI16, GrayI32};
    use tiff::encoder::compression::DeflateLevel;
    use tiff::encoder::{Compression, Predictor, TiffEncoder, TiffValue};

    use super::*;

    /// How a file is written.
    #[derive(Clone, Copy)]
    struct Way {
        compression: Compression,
        predictor: Predictor,
        is_big: bool,
    }

    const PLAIN: Way = Way { compression: Compression::Uncompressed, predictor: Predictor::None, is_big: false };

    /// Tags of a map at 500 m east and 900 m north with pixels of 2 m by 3 m.
    struct Tags {
        scale: Vec<f64>,
        tie_point: Vec<f64>,
        matrix: Vec<f64>,
        keys: Vec<u16>,
        no_data: &'static str,
    }

    impl Tags {
        fn new(keys: &[[u16; 4]]) -> Self {
            let head = [1, 1, 1, u16::try_from(keys.len()).unwrap()];
            Self {
                scale: vec![2.0, 3.0, 0.0],
                tie_point: vec![0.0, 0.0, 0.0, 500.0, 900.0, 0.0],
                matrix: Vec::new(),
                keys: head.into_iter().chain(keys.iter().flatten().copied()).collect(),
                no_data: "-9999",
            }
        }
    }

    /// A file of 3 columns and 2 rows.
    fn file<C: Encoded>(values: &[C::Inner; 6], tags: &Tags, way: Way) -> Vec<u8>
    where
        [C::Inner]: TiffValue,
    {
        fn write<C: Encoded, K: tiff::encoder::TiffKind>(
            encoder: TiffEncoder<&mut Cursor<Vec<u8>>, K>,
            values: &[C::Inner],
            tags: &Tags,
            way: Way,
        ) where
            [C::Inner]: TiffValue,
        {
            let mut encoder = encoder.with_compression(way.compression).with_predictor(way.predictor);
            let mut image = encoder.new_image::<C>(3, 2).unwrap();
            image.rows_per_strip(1).unwrap();
            let directory = image.encoder();
            for (tag, numbers) in [
                (Tag::ModelPixelScaleTag, &tags.scale),
                (Tag::ModelTiepointTag, &tags.tie_point),
                (Tag::ModelTransformationTag, &tags.matrix),
            ] {
                if !numbers.is_empty() {
                    directory.write_tag(tag, numbers.as_slice()).unwrap();
                }
            }
            directory.write_tag(Tag::GeoKeyDirectoryTag, tags.keys.as_slice()).unwrap();
            directory.write_tag(Tag::GdalNodata, tags.no_data).unwrap();
            image.write_data(values).unwrap();
        }
        let mut bytes = Cursor::new(Vec::new());
        if way.is_big {
            write::<C, _>(TiffEncoder::new_big(&mut bytes).unwrap(), values, tags, way);
        } else {
            write::<C, _>(TiffEncoder::new(&mut bytes).unwrap(), values, tags, way);
        }
        bytes.into_inner()
    }

    const HEIGHTS: [f32; 6] = [1.5, 2.0, -9999.0, 4.25, 5.0, 6.0];
    const PROJECTED: [u16; 4] = [MODEL_TYPE, 0, 1, 1];

    #[test]
    fn heights_and_places_survive_every_way_of_writing() {
        let tags = Tags::new(&[PROJECTED]);
        let deflate = Compression::Deflate(DeflateLevel::default());
        for compression in [Compression::Uncompressed, Compression::Lzw, deflate, Compression::Packbits] {
            for is_big in [false, true] {
                let grid = read(&file::<Gray32Float>(&HEIGHTS, &tags, Way { compression, is_big, ..PLAIN })).unwrap();
                assert_eq!(
                    (grid.columns, grid.values.as_slice(), grid.no_data),
                    (3, HEIGHTS.as_slice(), Some(-9999.0))
                );
                // The middle of the first pixel, of 2 m by 3 m.
                let place = Georeference { far_left_m: DVec2::new(501.0, 898.5), cell_m: DVec2::new(2.0, 3.0) };
                assert_eq!(grid.georeference, Some(place));
            }
        }
        let way = Way { predictor: Predictor::Horizontal, compression: Compression::Lzw, ..PLAIN };
        let whole = [1, 2, 250, 4, 0, 6];
        let expected = whole.map(f32::from);
        assert_eq!(read(&file::<Gray8>(&whole, &tags, way)).unwrap().values, expected);
        assert_eq!(read(&file::<Gray16>(&whole.map(u16::from), &tags, way)).unwrap().values, expected);
        let negative = expected.map(|height| -height);
        assert_eq!(
            read(&file::<GrayI16>(&whole.map(|height| -i16::from(height)), &tags, way)).unwrap().values,
            negative
        );
        assert_eq!(
            read(&file::<GrayI32>(&whole.map(|height| -i32::from(height)), &tags, way)).unwrap().values,
            negative
        );
        let values = file::<Gray64Float>(&whole.map(f64::from), &tags, PLAIN);
        assert_eq!(read(&values).unwrap().values, expected);
    }

    #[test]
    fn tie_points_of_pixel_middles_and_matrices_are_understood() {
        let read_place = |tags: &Tags| read(&file::<Gray32Float>(&HEIGHTS, tags, PLAIN)).unwrap().georeference;
        let place = |x: f64, y: f64| Some(Georeference { far_left_m: DVec2::new(x, y), cell_m: DVec2::new(2.0, 3.0) });
        let points = Tags::new(&[PROJECTED, [RASTER_TYPE, 0, 1, PIXEL_IS_POINT]]);
        assert_eq!(read_place(&points), place(500.0, 900.0));
        let other_corner = Tags { tie_point: vec![3.0, 2.0, 0.0, 506.0, 894.0, 0.0], ..Tags::new(&[PROJECTED]) };
        assert_eq!(read_place(&other_corner), place(501.0, 898.5));
        let matrix = vec![2.0, 0.0, 0.0, 500.0, 0.0, -3.0, 0.0, 900.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let none = Tags { scale: vec![], tie_point: vec![], ..Tags::new(&[]) };
        assert_eq!(read_place(&Tags { matrix: matrix.clone(), ..Tags::new(&[]) }), place(501.0, 898.5));
        assert_eq!(read_place(&Tags { matrix, ..none }), place(501.0, 898.5));
        assert_eq!(read_place(&Tags { scale: vec![], ..Tags::new(&[]) }), None, "a TIFF that is no map");
    }

    #[test]
    fn maps_that_are_not_in_metres_are_refused() {
        let message = |tags: &Tags| read(&file::<Gray32Float>(&HEIGHTS, tags, PLAIN)).unwrap_err();
        assert!(message(&Tags::new(&[[MODEL_TYPE, 0, 1, GEOGRAPHIC]])).contains("in degrees, but must be in metres"));
        let feet = message(&Tags::new(&[PROJECTED, [LINEAR_UNITS, 0, 1, 9003]]));
        assert_eq!(feet, "the unit of lengths is EPSG:9003, but must be the metre (EPSG:9001)");
        let turned = vec![2.0, 0.5, 0.0, 500.0, 0.0, -3.0, 0.0, 900.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let turned = Tags { matrix: turned, scale: vec![], ..Tags::new(&[PROJECTED]) };
        assert!(message(&turned).contains("turned or mirrored"));
        let flat = Tags { scale: vec![0.0, 3.0, 0.0], ..Tags::new(&[PROJECTED]) };
        assert!(message(&flat).contains("the cell size is 0 m"));
        assert!(message(&Tags { no_data: "none", ..Tags::new(&[]) }).contains("GDAL_NODATA is \"none\""));
        let mut infinite = HEIGHTS;
        infinite[1] = f32::INFINITY;
        let bytes = file::<Gray32Float>(&infinite, &Tags::new(&[PROJECTED]), PLAIN);
        assert_eq!(read(&bytes).unwrap_err(), "a height is inf, but must be finite");
        let mut missing = HEIGHTS;
        missing[1] = f32::NAN;
        let grid = read(&file::<Gray32Float>(&missing, &Tags::new(&[PROJECTED]), PLAIN)).unwrap();
        assert!(grid.filled(None).unwrap_err().contains("2 of 6 heights are missing, the first in row 1 and column 2"));
    }

    /// A file that is cut off anywhere, or has any byte changed, gives a grid or a message of one line. Reading never
    /// panics.
    #[test]
    fn broken_files_are_refused() {
        let tags = Tags::new(&[PROJECTED]);
        for compression in [Compression::Uncompressed, Compression::Lzw] {
            let whole = file::<Gray32Float>(&HEIGHTS, &tags, Way { compression, ..PLAIN });
            for length in 0..whole.len() {
                let message = read(&whole[..length]).unwrap_err();
                assert!(message.contains("not a readable TIFF file") && !message.contains('\n'), "{message}");
            }
            for place in 0..whole.len() {
                for byte in [0, 1, 0x7f, 0x80, 0xff, whole[place].wrapping_add(1)] {
                    let mut changed = whole.clone();
                    changed[place] = byte;
                    if let Err(message) = read(&changed) {
                        assert!(!message.contains('\n'), "{message}");
                    }
                }
            }
        }
        // A header that promises 10⁹ columns.
        let mut wide = file::<Gray32Float>(&HEIGHTS, &tags, PLAIN);
        let entry = [0x00, 0x01, 0x04, 0x00, 1, 0, 0, 0, 3, 0, 0, 0];
        let place = wide.windows(12).position(|bytes| bytes == entry).unwrap();
        wide[place + 8..place + 12].copy_from_slice(&1_000_000_000u32.to_le_bytes());
        assert_eq!(read(&wide).unwrap_err(), "the grid is 1000000000 × 2, but must be 2 × 2 to 4096 × 4096");
    }
}
