//! The memory that OpenEXR files take, known from their headers before anything is decoded.

use std::io::Cursor;

use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};

use snowblue_base::files::{check_expansion, check_memory};

/// Blocks that are decoded at a time, at most.
const BLOCKS_AT_A_TIME: f64 = 4.0;

/// Refuses a file whose images take more memory than it may. `pixel_bytes` gives the memory of a pixel in bytes, from
/// the bytes of its samples in the file.
///
/// # Errors
///
/// When the header cannot be read, or an image takes more memory.
pub fn check_exr_size(bytes: &[u8], pixel_bytes: impl Fn(usize) -> usize) -> Result<(), String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false);
    let meta = meta.map_err(|error| format!("not a readable EXR file: {error}"))?;
    meta.headers.iter().try_for_each(|header| {
        let (what, asked) = memory(header, &pixel_bytes);
        check_memory(&what, asked, bytes.len())
    })
}

/// Refuses an image that takes more memory than the length of its file justifies. Who reads it says what it may take.
///
/// # Errors
///
/// When the image takes more memory.
pub fn check_header_expansion(header: &Header, pixel_bytes: usize, file_bytes: usize) -> Result<(), String> {
    let (what, asked) = memory(header, |_| pixel_bytes);
    check_expansion(&what, asked, file_bytes)
}

/// The size of an image in words, and the memory that it takes in bytes.
fn memory(header: &Header, pixel_bytes: impl Fn(usize) -> usize) -> (String, f64) {
    let size = header.layer_size;
    let (width, height) = (size.width() as f64, size.height() as f64);
    let block_pixels = match header.blocks {
        BlockDescription::Tiles(tiles) => {
            (tiles.tile_size.width() as f64).min(width) * (tiles.tile_size.height() as f64).min(height)
        }
        BlockDescription::ScanLines => width * (header.compression.scan_lines_per_block() as f64).min(height),
    };
    let sample_bytes: usize = header.channels.list.iter().map(|channel| channel.sample_type.bytes_per_sample()).sum();
    let pixel_bytes = pixel_bytes(sample_bytes);
    let asked = width * height * pixel_bytes as f64 + BLOCKS_AT_A_TIME * block_pixels * sample_bytes as f64;
    (format!("{} × {} pixels", size.width(), size.height()), asked)
}
