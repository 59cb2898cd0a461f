//! Files of heights on a grid, chosen by file extension: grey PNG, OpenEXR, ESRI ASCII grids and GeoTIFF.
//!
//! ESRI ASCII grids and GeoTIFF are maps: they can give the place of their heights, in metres to the east and north.

mod esri_ascii;
mod geotiff;
mod height_grid;
mod pictures;

use snowblue_base::files::{FileError, FileSource, NamedFile, check_formats};

pub use height_grid::{Georeference, HeightGrid, Window};

impl HeightGrid {
    /// Reads a file of heights.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, is malformed, has another extension, or has too many heights.
    pub fn read(files: &dyn FileSource, name: &str) -> Result<Self, FileError> {
        let file = NamedFile::read(files, name)?;
        let wrong = |reason: String| FileError::Content { path: file.path.clone(), reason };
        let extension = file.extension();
        if extension == "asc" {
            return esri_ascii::read(&file.text()).map_err(wrong);
        }
        check_formats(&file.path)?;
        match extension.as_str() {
            "png" => pictures::read_png(&file),
            "exr" => pictures::read_exr(&file.bytes).map_err(wrong),
            "tif" | "tiff" => geotiff::read(&file.bytes).map_err(wrong),
            other => Err(wrong(format!("the extension is \"{other}\", but must be png, exr, asc, tif or tiff"))),
        }
    }
}
