//! Every reader of files as a function of bytes: whatever the bytes are, it returns within seconds, and takes less than
//! half a gigabyte.
//!
//! The targets in `fuzz` call these functions with the inputs of a fuzzer, `tests/replay.rs` with stored ones.

mod readers;

pub use readers::{axes, exr_sky, exr_sums, gltf, heights, layers, netcdf, obj, ply, png, scene, spectrum_csv, stl};

/// A reader, by the name of its target and of the folders of its inputs.
#[derive(Debug, Clone, Copy)]
pub struct Reader {
    /// Name.
    pub name: &'static str,
    /// Reads a file, and says whether it is valid.
    pub read: fn(&[u8]) -> bool,
}

/// All readers.
pub const READERS: [Reader; 13] = [
    Reader { name: "axes", read: axes },
    Reader { name: "exr_sky", read: exr_sky },
    Reader { name: "exr_sums", read: exr_sums },
    Reader { name: "gltf", read: gltf },
    Reader { name: "heights", read: heights },
    Reader { name: "layers", read: layers },
    Reader { name: "netcdf", read: netcdf },
    Reader { name: "obj", read: obj },
    Reader { name: "ply", read: ply },
    Reader { name: "png", read: png },
    Reader { name: "scene", read: scene },
    Reader { name: "spectrum_csv", read: spectrum_csv },
    Reader { name: "stl", read: stl },
];
