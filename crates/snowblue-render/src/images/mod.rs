//! Images in memory, and PNG files as input.

pub(crate) mod exr_size;
pub(crate) mod png_image;
pub mod raster;
