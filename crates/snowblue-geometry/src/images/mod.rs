//! Images as input: PNG, and the memory that an OpenEXR file takes.

pub mod exr_size;
pub mod png_image;
