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

use snowblue_base::files::{FileError, FileSource, NamedFile, check_formats, checked_text};
use snowblue_geometry::images::PngImage;

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
        if extension == "asc" {
            let system = ["prj", "PRJ"].map(|extension| Path::new(name).with_extension(extension));
            let system = system.iter().find_map(|name| beside(files, name).transpose()).transpose()?;
            let system = system.map(|system| checked_text(&system.path, &system.bytes)).transpose()?;
            return esri_ascii::read(&file.text(), system.as_deref(), stated).map_err(wrong);
        }
        check_formats(&file.path)?;
        match extension.as_str() {
            "png" => pictures::read_png(&PngImage::decode(&file)?, stated).map_err(wrong),
            "exr" => pictures::read_exr(&file.bytes, stated).map_err(wrong),
            "tif" | "tiff" => geotiff::read(&file.bytes, stated).map_err(wrong),
            other => Err(wrong(format!("the extension is \"{other}\", but must be png, exr, asc, tif or tiff"))),
        }
    }
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
            _ => Err(io::Error::from(io::ErrorKind::PermissionDenied)),
        };
        let message = HeightGrid::read(&locked, "hill.asc", &StatedByUser::default()).unwrap_err().to_string();
        assert!(message.contains("cannot read hill.prj: permission denied"), "{message}");
    }
}
