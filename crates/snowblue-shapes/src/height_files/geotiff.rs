//! GeoTIFF: heights as a TIFF of one band, and tags that say where they lie (Open Geospatial Consortium 2019, *OGC
//! GeoTIFF Standard* 1.1, document 19-008r4).
//!
//! `ModelPixelScaleTag` and `ModelTiepointTag`, or `ModelTransformationTag`, map columns and rows to the east and
//! north. `GeoKeyDirectoryTag` names the system of the map and of the heights, and their units. GDAL's tag 42113 holds
//! the text of the value that marks missing heights, and tag 42112 the unit, the scale and the offset of a band.

use std::io::Cursor;

use glam::DVec2;
use snowblue_base::files::check_memory;
use snowblue_base::narrow;
use tiff::decoder::ifd::Value;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::{PhotometricInterpretation, Tag};
use tiff::{ColorType, TiffError};

use crate::height_files::height_grid::{Georeference, HeightGrid, StatedByUser, check_size};
use crate::height_files::units;

/// Codes of the keys that are read, by table 2 of the standard, and of their values.
const MODEL_TYPE: u16 = 1024;
const PROJECTED_MODEL: u16 = 1;
const GEOGRAPHIC: u16 = 2;
const GEOCENTRIC: u16 = 3;
const RASTER_TYPE: u16 = 1025;
const PIXEL_IS_POINT: u16 = 2;
const GEOGRAPHIC_SYSTEM: u16 = 2048;
const PROJECTED_SYSTEM: u16 = 3072;
const PROJECTION_METHOD: u16 = 3075;
/// Methods that project the whole Earth: Mercator, equirectangular, Miller, Robinson, sinusoidal, Van der Grinten, and
/// of GDAL the cylindrical equal area.
const WORLD_PROJECTIONS: [u16; 7] = [7, 17, 20, 23, 24, 25, 28];
const LINEAR_UNITS: u16 = 3076;
const LINEAR_UNIT_SIZE: u16 = 3077;
const VERTICAL_SYSTEM: u16 = 4096;
const VERTICAL_UNITS: u16 = 4099;
/// The value of a key that the file defines itself.
const USER_DEFINED: u16 = 32_767;
/// The orientation whose first row is at the top and whose first column is on the left.
const UPRIGHT: u16 = 1;
/// Kinds of `ExtraSamples` that are alpha, with which colours are multiplied or not.
const ALPHA: [u16; 2] = [1, 2];
/// Bits of `NewSubfileType`.
const REDUCED: u32 = 1;
const MASK: u32 = 4;
/// GDAL's text about the bands.
const GDAL_METADATA: Tag = Tag::Unknown(42_112);

type File<'a> = Decoder<Cursor<&'a [u8]>>;

/// Reads a grid.
pub(super) fn read(bytes: &[u8], stated: &StatedByUser) -> Result<HeightGrid, String> {
    let mut file = Decoder::new(Cursor::new(bytes)).map_err(unreadable)?;
    let (width, height) = file.dimensions().map_err(unreadable)?;
    let (columns, rows) = (width as usize, height as usize);
    check_size(columns, rows)?;
    // The heights as decoded, in double precision at most, and the heights in single precision.
    let height_bytes = size_of::<f64>() + size_of::<f32>();
    check_memory(&format!("{columns} × {rows} heights"), (columns * rows * height_bytes) as f64, bytes.len())?;
    let orientation = file.find_tag_unsigned::<u16>(Tag::Orientation).map_err(unreadable)?.unwrap_or(UPRIGHT);
    if orientation != UPRIGHT {
        return Err(format!(
            "the orientation is {orientation}, but must be {UPRIGHT} (`gdal_translate IN.tif OUT.tif` takes the rows \
             as they are stored, and `magick IN.tif -auto-orient OUT.tif` turns them)"
        ));
    }
    let colour = file.colortype().map_err(unreadable)?;
    if !matches!(colour, ColorType::Gray(_)) {
        let extra = file.find_tag_unsigned_vec::<u16>(Tag::ExtraSamples).map_err(unreadable)?.unwrap_or_default();
        let way_out = if extra.iter().any(|kind| ALPHA.contains(kind)) {
            "gdalwarp -ot Float32 -dstnodata -9999 IN.tif OUT.tif` makes transparent heights missing"
        } else {
            "gdal_translate -b 1 IN.tif OUT.tif` takes the first"
        };
        return Err(format!("the image is {colour:?}, but must have one band of heights (`{way_out})"));
    }
    let band = Band::read(&mut file)?;
    let georeference = georeference(&mut file, [columns, rows], &band, stated);
    // The library inverts images in which 0 is white, which the programs of maps do not.
    let kind = file.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation).map_err(unreadable)?;
    if kind != Some(PhotometricInterpretation::BlackIsZero.to_u16()) {
        return Err("the value 0 is white, but must be black (`gdal_translate -co PHOTOMETRIC=MINISBLACK IN.tif \
                    OUT.tif` mends it)"
            .to_owned());
    }
    let values = heights(file.read_image().map_err(unreadable)?)?;
    if values.len() != columns * rows {
        return Err(format!("there are {} heights, but must be {columns} × {rows}", values.len()));
    }
    while file.more_images() {
        file.next_image().map_err(unreadable)?;
        let kind = file.find_tag_unsigned::<u32>(Tag::NewSubfileType).map_err(unreadable)?.unwrap_or(0);
        if kind & MASK != 0 {
            return Err(
                "missing heights are in a mask of the file, which is not read (`gdalwarp -dstnodata -9999 IN.tif \
                        OUT.tif` writes them into the map)"
                    .to_owned(),
            );
        }
        if kind & REDUCED == 0 {
            return Err("the file has several images, but must have one (`gdal_translate GTIFF_DIR:1:IN.tif OUT.tif` \
                        takes the first)"
                .to_owned());
        }
    }
    let grid = HeightGrid::new(columns, values, [band.no_data, stated.no_data], georeference)?;
    Ok(HeightGrid { values: grid.values.into_iter().map(|value| band.value(value)).collect(), ..grid })
}

fn unreadable(error: TiffError) -> String {
    let way_out = match &error {
        TiffError::UnsupportedError(_) => " (`gdal_translate -co COMPRESS=DEFLATE IN.tif OUT.tif` may mend it)",
        _ => "",
    };
    format!("not a readable TIFF file: {error}{way_out}").replace('\n', " ")
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
            return Err("the heights are of a kind that is not read (`gdal_translate -ot Float32 IN.tif OUT.tif` \
                        mends it)"
                .to_owned());
        }
    })
}

/// What GDAL says of the values of the first band: a height is the offset and the scale times the value, in the unit.
struct Band {
    /// The value that marks missing heights.
    no_data: Option<f32>,
    scale: Option<f64>,
    offset: Option<f64>,
    unit: Option<String>,
}

impl Band {
    fn read(file: &mut File) -> Result<Self, String> {
        let mut band = Self { no_data: None, scale: None, offset: None, unit: None };
        if let Some(text) = text(file, Tag::GdalNodata)? {
            let number = text.parse().map_err(|_| format!("GDAL_NODATA is \"{text}\", but must be a number"))?;
            band.no_data = Some(narrow(number));
        }
        let Some(text) = text(file, GDAL_METADATA)? else { return Ok(band) };
        let unreadable = |error| format!("GDAL_METADATA is not readable: {error}").replace('\n', " ");
        let document = roxmltree::Document::parse(&text).map_err(unreadable)?;
        for item in document.descendants().filter(|item| item.attribute("sample").unwrap_or("0") == "0") {
            let text = item.text().unwrap_or_default().trim();
            let number = || match text.parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(number),
                _ => Err(format!("GDAL_METADATA has \"{text}\", but must have a finite number")),
            };
            match item.attribute("role") {
                Some("scale") => band.scale = Some(number()?),
                Some("offset") => band.offset = Some(number()?),
                Some("unittype") => band.unit = Some(text.to_owned()).filter(|unit| !unit.is_empty()),
                _ => {}
            }
        }
        Ok(band)
    }

    fn value(&self, stored: f32) -> f32 {
        narrow(self.offset.unwrap_or(0.0) + self.scale.unwrap_or(1.0) * f64::from(stored))
    }
}

/// The place of the heights; none if the file does not give it.
fn georeference(
    file: &mut File,
    [columns, rows]: [usize; 2],
    band: &Band,
    stated: &StatedByUser,
) -> Result<Option<Georeference>, String> {
    let scale = numbers(file, Tag::ModelPixelScaleTag)?;
    let tie_point = numbers(file, Tag::ModelTiepointTag)?;
    let matrix = numbers(file, Tag::ModelTransformationTag)?;
    let (corner, cell, [height_scale, height_offset]) =
        match (scale.as_deref(), tie_point.as_deref(), matrix.as_deref()) {
            (Some([dx, dy, dz, ..]), Some([column, row, value, x, y, z, ..]), _) => {
                (DVec2::new(x - column * dx, y + row * dy), DVec2::new(*dx, *dy), [*dz, z - value * dz])
            }
            (_, _, Some([dx, by_row, _, x, by_column, dy, _, y, _, _, dz, z, ..])) => {
                if *by_row != 0.0 || *by_column != 0.0 || *dx < 0.0 || *dy > 0.0 {
                    return Err(
                        "the map is turned or mirrored, but its rows must run from west to east and its columns \
                            from north to south (gdalwarp makes such a map)"
                            .to_owned(),
                    );
                }
                (DVec2::new(*x, *y), DVec2::new(*dx, -dy), [*dz, *z])
            }
            _ => return Ok(None),
        };
    // The scale 0 says nothing of heights.
    let changes_heights = height_scale != 0.0 && ((height_scale - 1.0).abs() > 0.0 || height_offset != 0.0);
    if changes_heights && band.scale.or(band.offset).is_none() {
        return Err(format!(
            "the tags of its place multiply heights by {height_scale} and add {height_offset}, which is not read \
             (`gdal_translate -a_scale {height_scale} -a_offset {height_offset} IN.tif OUT.tif` says so of the band)"
        ));
    }
    let keys = Keys::read(file)?;
    let far = corner + cell * DVec2::new(columns as f64, -(rows as f64));
    let map_m = keys.map_unit_m([corner, far], cell, stated.map_unit_m)?;
    let height_m = stated.height_unit_m.map_or_else(|| keys.height_unit_m(band, map_m), Ok)?;
    let is_point = keys.value(RASTER_TYPE) == Some(PIXEL_IS_POINT);
    let middle = if is_point { DVec2::ZERO } else { 0.5 * cell * DVec2::new(1.0, -1.0) };
    Georeference::new(corner + middle, cell, map_m, height_m).map(Some)
}

/// The directory of keys: after a head of four numbers, four numbers for each key, which are the key, the tag of its
/// value or 0, the number of values, and the value or its place in the tag.
struct Keys {
    directory: Vec<u16>,
    doubles: Vec<f64>,
    /// The system in well-known text, as programs of Esri and GDAL write it among the texts of keys.
    system: Option<String>,
}

impl Keys {
    fn read(file: &mut File) -> Result<Self, String> {
        let directory = file.find_tag_unsigned_vec(Tag::GeoKeyDirectoryTag).map_err(unreadable)?;
        let doubles = numbers(file, Tag::GeoDoubleParamsTag)?;
        let texts = text(file, Tag::GeoAsciiParamsTag)?.unwrap_or_default();
        let system = texts.split_once("ESRI PE String = ").map(|(_, system)| system.to_owned());
        Ok(Self { directory: directory.unwrap_or_default(), doubles: doubles.unwrap_or_default(), system })
    }

    fn entry(&self, key: u16) -> Option<&[u16; 4]> {
        self.directory.as_chunks().0.iter().skip(1).find(|entry| entry[0] == key)
    }

    /// The value of a key; none if the key is absent or undefined, which is 0.
    fn value(&self, key: u16) -> Option<u16> {
        self.entry(key).filter(|entry| entry[1] == 0 && entry[3] != 0).map(|entry| entry[3])
    }

    /// The unit of a key of units in m; none if the key is absent.
    fn unit_m(&self, key: u16) -> Result<Option<f64>, String> {
        let Some(unit) = self.value(key) else { return Ok(None) };
        let own_size = || self.doubles.get(usize::from(self.entry(LINEAR_UNIT_SIZE)?[3])).copied();
        let length_m = match unit {
            USER_DEFINED if key == LINEAR_UNITS => own_size(),
            unit => units::of_code(unit),
        };
        length_m.map(Some).ok_or_else(|| format!("the key {key} has the unit {unit}, which is no known unit of length"))
    }

    /// The unit of the map in m: the unit that the user states, of the file, or of its system, if any. A map in
    /// degrees, in a projection of the whole Earth or around the middle of the Earth is refused whatever the user says.
    fn map_unit_m(&self, corners: [DVec2; 2], cell: DVec2, stated_m: Option<f64>) -> Result<Option<f64>, String> {
        if let Some(text) = &self.system {
            return units::of_well_known_text(text, corners[0], stated_m).map(Some);
        }
        let system = self.value(PROJECTED_SYSTEM);
        match self.value(MODEL_TYPE) {
            Some(GEOGRAPHIC) => return Err(units::degrees(corners[0])),
            Some(GEOCENTRIC) => return Err(units::geocentric()),
            Some(PROJECTED_MODEL) => {}
            _ if system.is_none() && self.value(GEOGRAPHIC_SYSTEM).is_some() => return Err(units::degrees(corners[0])),
            _ => {}
        }
        if let Some(reason) = system.and_then(|code| units::world_system(code, corners[0])) {
            return Err(reason);
        }
        if self.value(PROJECTION_METHOD).is_some_and(|method| WORLD_PROJECTIONS.contains(&method)) {
            return Err(units::world(None));
        }
        if let Some(unit_m) = stated_m.map_or_else(|| self.unit_m(LINEAR_UNITS), |unit_m| Ok(Some(unit_m)))? {
            return Ok(Some(unit_m));
        }
        match system.map(|code| (code, units::of_system(code))) {
            Some((_, Some(unit_m))) => Ok(Some(unit_m)),
            Some((code, None)) => Err(format!("the unit of EPSG:{code} is unknown; `map_unit` says it")),
            None if self.value(MODEL_TYPE).is_some() => {
                Err("the file does not say the unit of its coordinates; `map_unit` says it".to_owned())
            }
            None => units::check_unstated(corners, cell).map(|()| None),
        }
    }

    /// The unit of the heights in m: the unit of the band, of the key, of the system of heights, or the metre on a map
    /// in metres.
    fn height_unit_m(&self, band: &Band, map_unit_m: Option<f64>) -> Result<f64, String> {
        if let Some(name) = &band.unit {
            return units::of_name(name)
                .ok_or_else(|| format!("the unit of the heights is \"{name}\", which is unknown; `unit` says it"));
        }
        if let Some(unit_m) = self.unit_m(VERTICAL_UNITS)? {
            return Ok(unit_m);
        }
        match self.value(VERTICAL_SYSTEM) {
            Some(code) => units::of_system(code).ok_or_else(|| {
                format!(
                    "the heights are in EPSG:{code}, which is no known system of heights that count upwards; `unit` \
                     says their unit"
                )
            }),
            None => units::of_unstated_heights(map_unit_m),
        }
    }
}

/// The text of a tag.
fn text(file: &mut File, tag: Tag) -> Result<Option<String>, String> {
    let text = file.find_tag(tag).map_err(unreadable)?.map(Value::into_string).transpose().map_err(unreadable)?;
    Ok(text.map(|text| text.trim_matches(['\0', ' ', '\n']).to_owned()))
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

    fn read(bytes: &[u8]) -> Result<HeightGrid, String> {
        super::read(bytes, &StatedByUser::default())
    }

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
        metadata: String,
        texts: String,
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
                metadata: String::new(),
                texts: String::new(),
            }
        }

        /// The tags with what GDAL says of the first band, and of another band.
        fn with_metadata(self, role: &str, value: &str) -> Self {
            let metadata = format!(
                "<GDALMetadata><Item name=\"A\" sample=\"0\" role=\"{role}\">{value}</Item>\
                 <Item name=\"A\" sample=\"1\" role=\"{role}\">7</Item></GDALMetadata>"
            );
            Self { metadata, ..self }
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
            directory.write_tag(Tag::GeoDoubleParamsTag, [0.5].as_slice()).unwrap();
            if !tags.texts.is_empty() {
                directory.write_tag(Tag::GeoAsciiParamsTag, tags.texts.as_str()).unwrap();
            }
            if !tags.metadata.is_empty() {
                directory.write_tag(GDAL_METADATA, tags.metadata.as_str()).unwrap();
            }
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
    const METRES: [u16; 4] = [LINEAR_UNITS, 0, 1, 9001];

    /// A place with pixels of 2 m by 3 m.
    fn place(x: f64, y: f64, unit_m: Option<f64>) -> Result<Option<Georeference>, String> {
        Ok(Some(Georeference::new(DVec2::new(x, y), DVec2::new(2.0, 3.0), unit_m, 1.0).unwrap()))
    }

    #[test]
    fn heights_and_places_survive_every_way_of_writing() {
        let tags = Tags::new(&[PROJECTED, METRES]);
        let deflate = Compression::Deflate(DeflateLevel::default());
        for compression in [Compression::Uncompressed, Compression::Lzw, deflate, Compression::Packbits] {
            for is_big in [false, true] {
                let grid = read(&file::<Gray32Float>(&HEIGHTS, &tags, Way { compression, is_big, ..PLAIN })).unwrap();
                assert!(grid.values[2].is_nan());
                assert_eq!((grid.columns, &grid.values[..2], &grid.values[3..]), (3, &HEIGHTS[..2], &HEIGHTS[3..]));
                // The middle of the first pixel, of 2 m by 3 m.
                assert_eq!(grid.georeference, place(501.0, 898.5, Some(1.0)));
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
        let points = Tags::new(&[PROJECTED, METRES, [RASTER_TYPE, 0, 1, PIXEL_IS_POINT]]);
        assert_eq!(read_place(&points), place(500.0, 900.0, Some(1.0)));
        let other_corner =
            Tags { tie_point: vec![3.0, 2.0, 0.0, 506.0, 894.0, 0.0], ..Tags::new(&[PROJECTED, METRES]) };
        assert_eq!(read_place(&other_corner), place(501.0, 898.5, Some(1.0)));
        let matrix = vec![2.0, 0.0, 0.0, 500.0, 0.0, -3.0, 0.0, 900.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let none = Tags { scale: vec![], tie_point: vec![], ..Tags::new(&[]) };
        assert_eq!(read_place(&Tags { matrix: matrix.clone(), ..Tags::new(&[]) }), place(501.0, 898.5, None));
        assert_eq!(read_place(&Tags { matrix, ..none }), place(501.0, 898.5, None));
        assert_eq!(read_place(&Tags { scale: vec![], ..Tags::new(&[]) }), Ok(None), "a TIFF that is no map");
    }

    /// Lengths of the cell along x and of a height of 1, in m, or the reason why the map has no place.
    fn units_m(tags: &Tags) -> Result<[f64; 2], String> {
        let place = read(&file::<Gray32Float>(&HEIGHTS, tags, PLAIN)).unwrap().georeference;
        place.map(|place| place.unwrap()).map(|place| [place.cell_m.x, place.height_unit_m])
    }

    #[test]
    fn scales_of_heights_by_the_place_are_refused_unless_the_band_states_them() {
        let place = |scale: f64, z: f64| Tags {
            scale: vec![2.0, 3.0, scale],
            tie_point: vec![0.0, 0.0, 10.0, 500.0, 900.0, z],
            ..Tags::new(&[PROJECTED, METRES])
        };
        for (scale, z) in [(0.0, 0.0), (0.0, 250.0), (1.0, 10.0)] {
            assert!(units_m(&place(scale, z)).is_ok(), "{scale} {z}");
        }
        // Ten steps of 0.5 m below 105 m is 100 m at 0, and a shift alone changes heights too.
        for (scale, z, expected) in
            [(0.5, 105.0, "-a_scale 0.5 -a_offset 100 IN"), (1.0, 0.0, "-a_scale 1 -a_offset -10 IN")]
        {
            let message = units_m(&place(scale, z)).unwrap_err();
            assert!(message.contains(expected), "{message}");
            let stated = place(scale, z).with_metadata("scale", "0.5");
            assert_eq!(read(&file::<Gray32Float>(&HEIGHTS, &stated, PLAIN)).unwrap().values[3..], [2.125, 2.5, 3.0]);
        }
        let matrix = vec![2.0, 0.0, 0.0, 500.0, 0.0, -3.0, 0.0, 900.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 1.0];
        let tags = Tags { matrix, scale: vec![], ..Tags::new(&[PROJECTED, METRES]) };
        assert!(units_m(&tags).unwrap_err().contains("-a_scale 0.1 -a_offset 0 IN"));
    }

    #[test]
    fn units_are_the_units_of_keys_and_systems() {
        const FOOT: f64 = 0.3048;
        const SURVEY_FOOT: f64 = 1200.0 / 3937.0;
        let system = |code: u16| [PROJECTED_SYSTEM, 0, 1, code];
        let heights = |code: u16| [VERTICAL_SYSTEM, 0, 1, code];
        let own_size = [LINEAR_UNIT_SIZE, 34_736, 1, 0];
        for (keys, expected) in [
            // UTM zone 32 north, the Swiss grid and the British grid.
            (vec![PROJECTED, system(32_632)], [2.0, 1.0]),
            (vec![system(2056)], [2.0, 1.0]),
            (vec![system(27_700), heights(5701)], [2.0, 1.0]),
            // Washington North in US survey feet, with NAVD88 in the same feet, and Oregon in international feet.
            (vec![PROJECTED, system(2285), heights(6360)], [2.0 * SURVEY_FOOT, SURVEY_FOOT]),
            (vec![system(2992), heights(8228)], [2.0 * FOOT, FOOT]),
            // Heights in feet on a map in metres, by their system or by their unit.
            (vec![system(32_632), heights(6360)], [2.0, SURVEY_FOOT]),
            (vec![system(32_632), [VERTICAL_UNITS, 0, 1, 9002]], [2.0, FOOT]),
            // The unit of the file is stronger than the unit of the system.
            (vec![system(2285), METRES], [2.0, 1.0]),
            // A unit of half a metre.
            (vec![system(USER_DEFINED), [LINEAR_UNITS, 0, 1, USER_DEFINED], own_size, heights(5703)], [1.0, 1.0]),
            // A map without keys.
            (vec![], [2.0, 1.0]),
        ] {
            let found = units_m(&Tags::new(&keys)).unwrap();
            assert!(
                found.iter().zip(expected).all(|(found, expected)| (found / expected - 1.0).abs() < 1e-8),
                "{keys:?}: {found:?}"
            );
        }
        // The unit of a band is stronger than a system of heights.
        for (name, unit_m) in
            [("US survey foot", SURVEY_FOOT), ("ft", FOOT), ("Metre", 1.0), ("cm", 0.01), ("", 0.3048)]
        {
            let tags = Tags::new(&[PROJECTED, METRES, heights(8228)]).with_metadata("unittype", name);
            assert!((units_m(&tags).unwrap()[1] / unit_m - 1.0).abs() < 1e-8, "{name}");
        }
    }

    #[test]
    fn maps_of_unknown_units_are_refused_with_a_way_out() {
        let system = |code: u16| [PROJECTED_SYSTEM, 0, 1, code];
        // 8° E and 46.6° N, in zone 32 of UTM.
        let degrees = |keys: &[[u16; 4]]| Tags { tie_point: vec![0.0, 0.0, 0.0, 8.0, 46.6, 0.0], ..Tags::new(keys) };
        let mercator =
            |keys: &[[u16; 4]]| Tags { tie_point: vec![0.0, 0.0, 0.0, 890_000.0, 5_870_000.0, 0.0], ..Tags::new(keys) };
        for (tags, expected) in [
            (
                degrees(&[[MODEL_TYPE, 0, 1, GEOGRAPHIC]]),
                "the map is in degrees: `gdalwarp -t_srs EPSG:32632 -r cubic -dstnodata -9999 IN.tif OUT.tif`",
            ),
            (degrees(&[[GEOGRAPHIC_SYSTEM, 0, 1, 4326]]), "degrees: `gdalwarp -t_srs EPSG:32632"),
            (Tags { scale: vec![1e-4, 1e-4, 0.0], ..degrees(&[]) }, "are degrees or metres"),
            (Tags::new(&[[MODEL_TYPE, 0, 1, GEOCENTRIC]]), "geocentric"),
            // x = 890,000 m is 8° E on the maps that begin at Greenwich, of Mercator and of degrees as metres.
            (mercator(&[PROJECTED, system(3857), METRES]), "lengths are not true: `gdalwarp -t_srs EPSG:32632"),
            (mercator(&[PROJECTED, system(4087)]), "lengths are not true: `gdalwarp -t_srs EPSG:32632"),
            (
                mercator(&[PROJECTED, [PROJECTION_METHOD, 0, 1, 7], METRES]),
                "lengths are not true: `gdalwarp -t_srs EPSG:326ZZ",
            ),
            (Tags::new(&[PROJECTED, [LINEAR_UNITS, 0, 1, 9102]]), "the unit 9102, which is no known unit of length"),
            (Tags::new(&[PROJECTED]), "does not say the unit of its coordinates; `map_unit` says it"),
            (Tags::new(&[PROJECTED, system(1)]), "the unit of EPSG:1 is unknown; `map_unit` says it"),
            (Tags::new(&[PROJECTED, system(2285)]), "the unit of its heights; `unit = \"ft\"`"),
            // Depths below the sea surface count downwards.
            (
                Tags::new(&[PROJECTED, METRES, [VERTICAL_SYSTEM, 0, 1, 5715]]),
                "EPSG:5715, which is no known system of heights",
            ),
            (Tags::new(&[PROJECTED, METRES]).with_metadata("unittype", "Kelvin"), "\"Kelvin\", which is unknown"),
        ] {
            let message = units_m(&tags).unwrap_err();
            assert!(message.contains(expected) && !message.contains('\n'), "{expected}: {message}");
            // The user may state an unknown unit, but cannot turn degrees or a distorted map into metres.
            let stated = StatedByUser { map_unit_m: Some(1.0), height_unit_m: Some(1.0), no_data: None };
            let place = super::read(&file::<Gray32Float>(&HEIGHTS, &tags, PLAIN), &stated).unwrap().georeference;
            let is_refused =
                ["the map is in degrees", "whole Earth", "geocentric"].iter().any(|kind| message.contains(kind));
            if is_refused {
                assert_eq!(place, Err(message));
            } else {
                assert!(place.unwrap().is_some(), "{expected}");
            }
        }
    }

    #[test]
    fn projections_of_the_whole_earth_are_refused_in_every_unit() {
        for code in [3832, 3994, 3857, 4087, 4088, 32_662, 32_663, 6933, 3410, 3395, 8857, 54_004, 54_009] {
            let message = units_m(&Tags::new(&[PROJECTED, [PROJECTED_SYSTEM, 0, 1, code], METRES])).unwrap_err();
            assert!(message.contains("a projection of the whole Earth") && message.contains("`gdalwarp"), "{message}");
        }
        // A system of Esri, as GDAL writes it.
        let system = |method: &str| Tags {
            texts: format!(
                "x|ESRI PE String = PROJCS[\"y\",GEOGCS[\"z\"],PROJECTION[\"{method}\"],UNIT[\"Foot\",0.3048]]|"
            ),
            ..Tags::new(&[[MODEL_TYPE, 0, 1, USER_DEFINED], [GEOGRAPHIC_SYSTEM, 0, 1, USER_DEFINED]])
        };
        assert!(units_m(&system("Mollweide")).unwrap_err().contains("a projection of the whole Earth"));
        let albers = system("Albers").with_metadata("unittype", "m");
        assert_eq!(units_m(&albers), Ok([0.6096, 1.0]));
        // Their neighbours in the register: UTM, a polar map and a Lambert grid.
        for code in [32_660, 3995, 3833, 3856, 6931, 3409] {
            let found = units_m(&Tags::new(&[PROJECTED, [PROJECTED_SYSTEM, 0, 1, code]]));
            assert!(found == Ok([2.0, 1.0]) || found.as_ref().unwrap_err().contains("is unknown"), "{code}: {found:?}");
        }
    }

    #[test]
    fn a_height_is_the_offset_and_the_scale_times_the_value() {
        let tags = Tags { no_data: "250", ..Tags::new(&[PROJECTED, METRES]).with_metadata("scale", "0.1") };
        let values = read(&file::<Gray8>(&[1, 2, 250, 4, 0, 6], &tags, PLAIN)).unwrap().values;
        assert!(values[2].is_nan());
        assert_eq!((values[0], values[3], values[5]), (0.1, 0.4, 0.6));
        let tags = Tags::new(&[PROJECTED, METRES]).with_metadata("offset", "-100");
        assert_eq!(
            read(&file::<Gray8>(&[1, 2, 250, 4, 0, 6], &tags, PLAIN)).unwrap().values[3..],
            [-96.0, -100.0, -94.0]
        );
        for (role, value) in [("scale", "a"), ("offset", "nan")] {
            let tags = Tags::new(&[]).with_metadata(role, value);
            let message = read(&file::<Gray32Float>(&HEIGHTS, &tags, PLAIN)).unwrap_err();
            assert_eq!(message, format!("GDAL_METADATA has \"{value}\", but must have a finite number"));
        }
        let tags = Tags { metadata: "<GDALMetadata>".to_owned(), ..Tags::new(&[]) };
        let message = read(&file::<Gray32Float>(&HEIGHTS, &tags, PLAIN)).unwrap_err();
        assert!(message.contains("GDAL_METADATA is not readable"), "{message}");
    }

    /// The tags and the strip of an image.
    type Tagged<'image> = (&'image [(Tag, u32)], &'image [u8]);

    /// A file of images of 3 by 2 pixels in one strip.
    fn images(images: &[Tagged]) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
        for (tags, strip) in images {
            let mut image = encoder.image_directory().unwrap();
            let place = image.write_data(*strip).unwrap();
            let size = [(Tag::ImageWidth, 3), (Tag::ImageLength, 2), (Tag::SamplesPerPixel, 1), (Tag::RowsPerStrip, 2)];
            let strip = [
                (Tag::StripOffsets, u32::try_from(place).unwrap()),
                (Tag::StripByteCounts, u32::try_from(strip.len()).unwrap()),
            ];
            for (tag, value) in size.iter().chain(&strip).chain(*tags) {
                match u16::try_from(*value) {
                    Ok(short) if *tag == Tag::ExtraSamples => image.write_tag(*tag, short).unwrap(),
                    _ => image.write_tag(*tag, *value).unwrap(),
                }
            }
            image.finish().unwrap();
        }
        bytes.into_inner()
    }

    const GREY_BYTES: [(Tag, u32); 3] =
        [(Tag::BitsPerSample, 8), (Tag::Compression, 1), (Tag::PhotometricInterpretation, 1)];

    #[test]
    fn masks_and_other_images_are_refused_with_a_way_out() {
        let heights: Tagged = (&GREY_BYTES, &[1, 2, 3, 4, 5, 6]);
        let of_kind = |kind: u32| [&GREY_BYTES[..], &[(Tag::NewSubfileType, kind)]].concat();
        for kind in [MASK, MASK | REDUCED] {
            let message = read(&images(&[heights, (&of_kind(kind), heights.1)])).unwrap_err();
            assert!(message.contains("in a mask of the file, which is not read (`gdalwarp -dstnodata"), "{message}");
        }
        // A smaller copy is no other height.
        let overview: Tagged = (&of_kind(REDUCED), heights.1);
        assert_eq!(read(&images(&[heights, overview])).unwrap().values, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let message = read(&images(&[heights, heights])).unwrap_err();
        assert!(message.contains("the file has several images, but must have one (`gdal_translate GTIFF_DIR:1:"));
    }

    #[test]
    fn turned_images_and_more_bands_are_refused_with_a_way_out() {
        let with = |tag: Tag, value: u32| [&GREY_BYTES[..], &[(tag, value)]].concat();
        let message = read(&images(&[(&with(Tag::Orientation, 4), &[1, 2, 3, 4, 5, 6])])).unwrap_err();
        assert!(message.contains("the orientation is 4, but must be 1 (`gdal_translate IN.tif OUT.tif`"), "{message}");
        assert!(read(&images(&[(&with(Tag::Orientation, 1), &[1, 2, 3, 4, 5, 6])])).is_ok());
        let bands = [
            (Tag::SamplesPerPixel, 2),
            (Tag::BitsPerSample, 8),
            (Tag::Compression, 1),
            (Tag::PhotometricInterpretation, 1),
        ];
        for (kind, expected) in [(0, "`gdal_translate -b 1"), (1, "`gdalwarp -ot Float32 -dstnodata"), (2, "`gdalwarp")]
        {
            let tags = [&bands[..], &[(Tag::ExtraSamples, kind)]].concat();
            let message = read(&images(&[(&tags, &[0; 12])])).unwrap_err();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn heights_whose_zero_is_white_are_refused_with_a_way_out() {
        let is_white = [&GREY_BYTES[..2], &[(Tag::PhotometricInterpretation, 0)]].concat();
        let message = read(&images(&[(&is_white, &[1, 2, 0, 255, 5, 6])])).unwrap_err();
        assert!(message.contains("`gdal_translate -co PHOTOMETRIC=MINISBLACK IN.tif OUT.tif`"), "{message}");
    }

    #[test]
    fn strips_in_zstandard_are_read_and_in_lerc_refused_with_a_way_out() {
        let tags = |compression: u32| {
            [
                (Tag::BitsPerSample, 32),
                (Tag::SampleFormat, 3),
                (Tag::Compression, compression),
                (Tag::PhotometricInterpretation, 1),
            ]
        };
        let read = |tags: &[(Tag, u32)], strip: &[u8]| {
            super::read(&images(&[(tags, strip)]), &StatedByUser { no_data: Some(6.0), ..StatedByUser::default() })
        };
        // A frame of one block of 24 bytes that are not compressed (RFC 8878).
        let mut strip = vec![0x28, 0xb5, 0x2f, 0xfd, 0x20, 24, 0xc1, 0, 0];
        strip.extend(HEIGHTS.iter().flat_map(|height| height.to_ne_bytes()));
        let zstandard = tags(50_000);
        let values = read(&zstandard, &strip).unwrap().values;
        assert_eq!(values[..5], HEIGHTS[..5]);
        assert!(values[5].is_nan(), "the user's value marks missing heights");
        let message = read(&zstandard, &strip[1..]).unwrap_err();
        assert!(message.contains("not a readable TIFF file") && !message.contains('\n'), "{message}");
        let message = read(&tags(34_887), &strip).unwrap_err();
        assert!(message.contains("`gdal_translate -co COMPRESS=DEFLATE IN.tif OUT.tif`"), "{message}");
    }

    #[test]
    fn malformed_maps_are_refused() {
        let message = |tags: &Tags| {
            read(&file::<Gray32Float>(&HEIGHTS, tags, PLAIN)).and_then(|grid| grid.georeference).unwrap_err()
        };
        let turned = vec![2.0, 0.5, 0.0, 500.0, 0.0, -3.0, 0.0, 900.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let turned = Tags { matrix: turned, scale: vec![], ..Tags::new(&[PROJECTED, METRES]) };
        assert!(message(&turned).contains("turned or mirrored"));
        let flat = Tags { scale: vec![0.0, 3.0, 0.0], ..Tags::new(&[PROJECTED, METRES]) };
        assert!(message(&flat).contains("the cell size is 0 m"));
        assert!(message(&Tags { no_data: "none", ..Tags::new(&[]) }).contains("GDAL_NODATA is \"none\""));
        let mut missing = HEIGHTS;
        missing[1] = f32::NAN;
        let grid = read(&file::<Gray32Float>(&missing, &Tags::new(&[PROJECTED, METRES]), PLAIN)).unwrap();
        assert!(grid.filled(None).unwrap_err().contains("2 of 6 heights are missing, the first in row 1 and column 2"));
    }

    /// A file that is cut off anywhere, or has any byte changed, gives a grid or a message of one line. Reading never
    /// panics.
    #[test]
    fn broken_files_are_refused() {
        let tags = Tags::new(&[PROJECTED, METRES]);
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
