//! Files of heights on a grid, chosen by file extension: grey PNG, OpenEXR, ESRI ASCII grids and GeoTIFF.
//!
//! ESRI ASCII grids and GeoTIFF are maps: they can give the place of their heights to the east and north. The system of
//! an ESRI ASCII grid stands in a file of the extension `prj` beside it.

mod esri_ascii;
mod geotiff;
mod height_grid;
mod pictures;
mod units;

use std::io;
use std::path::Path;

use snowblue_base::files::{FileError, FileSource, NamedFile, check_formats, checked_text, one_line};
use snowblue_geometry::images::DecodedImage;

pub use height_grid::{Georeference, HeightGrid, StatedByUser, Window};
pub use units::of_code as length_unit_m;

impl HeightGrid {
    /// Reads a file of heights.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, is malformed, has another extension, or has too many heights.
    pub fn read(files: &dyn FileSource, name: &str, stated: &StatedByUser) -> Result<Self, FileError> {
        let file = NamedFile::read(files, name)?;
        let wrong = |reason: String| FileError::Content { path: file.path.clone(), reason };
        let extension = file.extension();
        if ["asc", "tif", "tiff"].contains(&extension.as_str()) && check_formats(&file.path).is_ok() {
            check_beside(files, name).map_err(wrong)?;
        }
        if extension == "asc" {
            let system = ["prj", "PRJ"].map(|extension| Path::new(name).with_extension(extension));
            let system = system.iter().find_map(|name| beside(files, name).transpose()).transpose()?;
            let system = system.map(|system| checked_text(&system.path, &system.bytes)).transpose()?;
            return esri_ascii::read(&file.text(), system.as_deref(), stated).map_err(wrong);
        }
        check_formats(&file.path)?;
        match extension.as_str() {
            "png" => pictures::read_png(&DecodedImage::decode(&file)?, stated).map_err(wrong),
            "exr" => pictures::read_exr(&file.bytes, stated).map_err(wrong),
            "tif" | "tiff" => {
                let mut grid = geotiff::read(&file.bytes, stated).map_err(wrong)?;
                let world_files =
                    ["tfw", "TFW", "tifw", "wld"].map(|extension| Path::new(name).with_extension(extension));
                let mut world_files = world_files.iter().filter(|name| exists(files, name));
                if let (Ok(None), Some(world_file)) = (&grid.georeference, world_files.next()) {
                    grid.georeference = Err(not_read("the place is", &world_file.to_string_lossy(), "gdal_translate"));
                }
                Ok(grid)
            }
            other => Err(wrong(format!("the extension is \"{other}\", but must be png, exr, asc, tif or tiff"))),
        }
    }
}

/// Elements of the files of the extension `aux.xml` that change heights or their place.
const AUXILIARY_ELEMENTS: [&str; 8] =
    ["SRS", "GeoTransform", "GCPList", "GeodataXform", "NoDataValue", "UnitType", "Offset", "Scale"];

/// Refuses a map if a mask, or what GDAL writes beside a file that it does not change, would change its heights.
fn check_beside(files: &dyn FileSource, name: &str) -> Result<(), String> {
    let [mask, auxiliary] = ["msk", "aux.xml"].map(|extension| format!("{name}.{extension}"));
    if exists(files, mask.as_ref()) {
        return Err(not_read("missing heights are", &mask, "gdalwarp -dstnodata -9999"));
    }
    let Some(file) = beside(files, auxiliary.as_ref()).map_err(|error| error.to_string())? else { return Ok(()) };
    let text = file.text();
    let unreadable = |error| one_line(&format!("{auxiliary} is not readable: {error}"));
    let document = roxmltree::Document::parse(&text).map_err(unreadable)?;
    let mut names = document.descendants().map(|element| element.tag_name().name());
    match names.find(|name| AUXILIARY_ELEMENTS.contains(name)) {
        Some(element) => Err(not_read(&format!("{element} is"), &auxiliary, "gdal_translate")),
        None => Ok(()),
    }
}

/// Why a map cannot be used while a file beside it says something of it.
fn not_read(what: &str, file: &str, program: &str) -> String {
    format!("{what} in {file}, which is not read (`{program} IN.tif OUT.tif` writes it into the map)")
}

fn exists(files: &dyn FileSource, name: &Path) -> bool {
    !matches!(beside(files, name), Ok(None))
}

/// A file beside a file of heights; none if it does not exist.
fn beside(files: &dyn FileSource, name: &Path) -> Result<Option<NamedFile>, FileError> {
    match NamedFile::read(files, &name.to_string_lossy()) {
        Err(FileError::Read { source, .. }) if source.kind() == io::ErrorKind::NotFound => Ok(None),
        read => read.map(Some),
    }
}

#[cfg(test)]
mod tests {
    use snowblue_base::files::FilesInMemory;

    use super::*;

    const GRID: &str = "ncols 2\nnrows 2\nxllcorner 1000\nyllcorner 2000\ncellsize 10\n1 2 3 4\n";

    #[test]
    fn the_system_of_a_grid_stands_beside_it_in_small_or_capital_letters() {
        let read = |name: &str, system: &[u8]| {
            let files = FilesInMemory::from([("hill.asc", GRID.as_bytes()), (name, system)]);
            HeightGrid::read(&files, "hill.asc", &StatedByUser { height_unit_m: Some(1.0), ..StatedByUser::default() })
        };
        let kilometres = b"PROJCS[\"x\",UNIT[\"kilometre\",1000]]";
        for name in ["hill.prj", "hill.PRJ"] {
            let place = read(name, kilometres).unwrap().georeference.unwrap().unwrap();
            assert_eq!((place.cell_m.x, place.states_unit), (10_000.0, true));
        }
        let place = read("other.prj", kilometres).unwrap().georeference.unwrap().unwrap();
        assert_eq!((place.cell_m.x, place.states_unit), (10.0, false));
        let message = read("hill.prj", b"PROJCS[\"\xff\"]").unwrap_err().to_string();
        assert!(message.contains("hill.prj:1: the line is not text"), "{message}");
        let locked = |name: &str| match name {
            "hill.asc" => Ok(GRID.into()),
            "hill.prj" => Err(io::Error::from(io::ErrorKind::PermissionDenied)),
            _ => Err(io::Error::from(io::ErrorKind::NotFound)),
        };
        let message = HeightGrid::read(&locked, "hill.asc", &StatedByUser::default()).unwrap_err().to_string();
        assert!(message.contains("cannot read hill.prj: permission denied"), "{message}");
    }

    #[test]
    fn masks_and_statements_beside_a_map_are_refused_with_a_way_out() {
        let read = |name: &str, text: &str| {
            let files = FilesInMemory::from([("hill.asc", GRID), (name, text)]);
            HeightGrid::read(&files, "hill.asc", &StatedByUser::default()).map_err(|error| error.to_string())
        };
        let of_band = |text: &str| {
            read(
                "hill.asc.aux.xml",
                &format!("<PAMDataset><PAMRasterBand band=\"1\">{text}</PAMRasterBand></PAMDataset>"),
            )
        };
        let mask = read("hill.asc.msk", "").unwrap_err();
        assert!(mask.contains("are in hill.asc.msk, which is not read (`gdalwarp -dstnodata"), "{mask}");
        let statistics = "<Metadata><MDI key=\"STATISTICS_MEAN\">2.5</MDI></Metadata><Histograms/>";
        assert_eq!(of_band(statistics).unwrap().values, [1.0, 2.0, 3.0, 4.0]);
        let scale = of_band(&format!("{statistics}<Scale>0.1</Scale>")).unwrap_err();
        assert!(scale.contains("Scale is in hill.asc.aux.xml, which is not read (`gdal_translate"), "{scale}");
        let broken = read("hill.asc.aux.xml", "<PAMDataset>").unwrap_err();
        assert!(broken.contains("hill.asc.aux.xml is not readable") && !broken.contains('\n'), "{broken}");
    }

    #[test]
    fn a_world_file_is_named_where_the_map_does_not_say_its_place() {
        let mut tiff = io::Cursor::new(Vec::new());
        let mut encoder = tiff::encoder::TiffEncoder::new(&mut tiff).unwrap();
        encoder.write_image::<tiff::encoder::colortype::Gray32Float>(2, 2, &[1.0, 2.0, 3.0, 4.0]).unwrap();
        let place = |name: &str| {
            let files = FilesInMemory::from([("hill.tif", tiff.get_ref().clone()), (name, Vec::new())]);
            HeightGrid::read(&files, "hill.tif", &StatedByUser::default()).unwrap().georeference
        };
        assert_eq!(place("other.tfw"), Ok(None));
        for name in ["hill.tfw", "hill.TFW", "hill.wld"] {
            let message = place(name).unwrap_err();
            assert!(
                message.contains(&format!("the place is in {name}, which is not read (`gdal_translate")),
                "{message}"
            );
        }
    }
}
