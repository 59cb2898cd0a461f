//! Files of heights on a grid, chosen by file extension: grey PNG, OpenEXR, ESRI ASCII grids and GeoTIFF.
//!
//! ESRI ASCII grids and GeoTIFF are maps: they can give the place of their heights to the east and north. The system of
//! an ESRI ASCII grid stands in a file of the extension `prj` beside it.

mod esri_ascii;
mod geotiff;
mod height_grid;
mod pictures;
mod units;

use std::path::Path;

use snowblue_base::files::{FileError, FileSource, NamedFile, check_formats};
use snowblue_geometry::images::PngImage;

pub use height_grid::{Georeference, HeightGrid, StatedByUser, Window};

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
            let system = Path::new(name).with_extension("prj");
            let system = NamedFile::read(files, &system.to_string_lossy()).ok();
            let system = system.as_ref().map(NamedFile::text);
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
