//! Image files as input: PNG for textures, masks and height fields, and the memory that OpenEXR files take, known from
//! their headers before anything is decoded.

use std::io::Cursor;

use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use png::{BitDepth, ColorType, Transformations};
use snowblue_base::files::{FileError, NamedFile, check_expansion, check_formats, check_memory};

/// An image with the values of its file, scaled to 0–1.
#[derive(Debug, Clone, PartialEq)]
pub struct PngImage {
    /// Pixels from left to right.
    pub width: usize,
    /// Pixels from top to bottom.
    pub height: usize,
    /// Values of a pixel: 1 in a grey image, else 3.
    pub channels: usize,
    /// Values, row by row from the top.
    pub values: Vec<f32>,
    /// The alpha of each pixel; empty if the file has no alpha.
    pub alpha: Vec<f32>,
}

impl PngImage {
    /// Decodes a PNG file.
    ///
    /// # Errors
    ///
    /// As [`read`](Self::read), and in a build without the feature `formats`.
    pub fn decode(file: &NamedFile) -> Result<Self, FileError> {
        check_formats(&file.path)?;
        let image = Self::read(&file.bytes);
        image.map_err(|reason| FileError::Content { path: file.path.clone(), reason })
    }

    /// Decodes a PNG of any colour type. Palettes become colours, and colours that are all grey become grey.
    ///
    /// # Errors
    ///
    /// When the file is malformed, or takes more memory than a file of its length may take.
    pub fn read(png: &[u8]) -> Result<Self, String> {
        let malformed = |error: png::DecodingError| format!("not a readable PNG file: {error}");
        let mut decoder = png::Decoder::new(Cursor::new(png));
        decoder.set_transformations(Transformations::EXPAND);
        let mut reader = decoder.read_info().map_err(malformed)?;
        let (width, height) = reader.info().size();
        let (color, depth) = reader.output_color_type();
        let (stored, channels) = match color {
            ColorType::Grayscale => (1, 1),
            ColorType::GrayscaleAlpha => (2, 1),
            ColorType::Rgb | ColorType::Indexed => (3, 3),
            ColorType::Rgba => (4, 3),
        };
        // Memory of the decoded image, of its values, and of the colours with alpha made of the values.
        let sample_bytes = if depth == BitDepth::Sixteen { 2 } else { 1 };
        let pixel_bytes = stored * (sample_bytes + size_of::<f32>()) + size_of::<[f32; 4]>();
        let pixels = f64::from(width) * f64::from(height);
        check_memory(&format!("{width} × {height} pixels"), pixels * pixel_bytes as f64, png.len())?;
        let mut bytes = vec![0; reader.output_buffer_size().ok_or("the image is too large")?];
        let frame = reader.next_frame(&mut bytes).map_err(malformed)?;
        bytes.truncate(frame.buffer_size());
        let sample = |sample: &[u8]| match sample {
            [high, low] => f32::from(u16::from_be_bytes([*high, *low])) / 65_535.0,
            [byte, ..] => f32::from(*byte) / 255.0,
            [] => 0.0,
        };
        let pixels = width as usize * height as usize;
        let mut values = Vec::with_capacity(pixels * channels);
        let mut alpha = Vec::with_capacity(pixels * (stored - channels));
        for pixel in bytes.chunks_exact(stored * sample_bytes) {
            let (color, rest) = pixel.split_at(channels * sample_bytes);
            values.extend(color.chunks_exact(sample_bytes).map(sample));
            alpha.extend(rest.chunks_exact(sample_bytes).map(sample));
        }
        let mut image = Self { width: frame.width as usize, height: frame.height as usize, channels, values, alpha };
        if image.values.chunks_exact(channels).all(|pixel| pixel.iter().all(|value| value.total_cmp(&pixel[0]).is_eq()))
        {
            image.values = image.values.into_iter().step_by(channels).collect();
            image.channels = 1;
        }
        Ok(image)
    }

    /// The alpha of a pixel, by its number; 1 without alpha.
    pub fn alpha_of(&self, pixel: usize) -> f32 {
        self.alpha.get(pixel).copied().unwrap_or(1.0)
    }

    /// Red, green and blue of each pixel, as the file encodes them. Grey images have three equal channels.
    pub fn encoded_rgb(&self) -> Vec<[f32; 3]> {
        let last = self.channels - 1;
        self.values.chunks_exact(self.channels).map(|pixel| [0, last.min(1), last].map(|at| pixel[at])).collect()
    }
}

/// Greatest number of blocks that are decoded at a time.
const BLOCKS_AT_A_TIME: f64 = 4.0;

/// Refuses a file whose images together take more memory than the file may take. `pixel_bytes` gives the memory of a
/// pixel in bytes, from the bytes of its samples in the file.
///
/// # Errors
///
/// When the header cannot be read, or an image takes more memory.
pub fn check_exr_size(bytes: &[u8], pixel_bytes: impl Fn(usize) -> usize) -> Result<(), String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false);
    let meta = meta.map_err(|error| format!("not a readable EXR file: {error}"))?;
    let mut asked = 0.0;
    meta.headers.iter().try_for_each(|header| {
        let (what, of_header) = memory(header, &pixel_bytes);
        asked += of_header;
        check_memory(&what, asked, bytes.len())
    })
}

/// Refuses an image that takes more memory than the length of its file justifies. `pixel_bytes` is the memory of a
/// pixel for the reader.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn png(color: ColorType, depth: BitDepth, palette: Option<&'static [u8]>, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if let Some(palette) = palette {
            encoder.set_palette(palette);
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    }

    #[test]
    fn reads_every_colour_type_and_bit_depth() {
        let shade = 0x80 as f32 / 255.0;
        for (file, channels, expected, alpha) in [
            (png(ColorType::Grayscale, BitDepth::Eight, None, &[0, 0x80]), 1, vec![0.0, shade], [1.0; 2]),
            (png(ColorType::Grayscale, BitDepth::One, None, &[0b0100_0000]), 1, vec![0.0, 1.0], [1.0; 2]),
            (
                png(ColorType::GrayscaleAlpha, BitDepth::Eight, None, &[0x80, 0, 255, 0x80]),
                1,
                vec![shade, 1.0],
                [0.0, shade],
            ),
            (
                png(ColorType::Rgba, BitDepth::Eight, None, &[255, 0, 0x80, 0x80, 0, 0, 0, 255]),
                3,
                vec![1.0, 0.0, shade, 0.0, 0.0, 0.0],
                [shade, 1.0],
            ),
            (
                png(ColorType::Indexed, BitDepth::One, Some(&[0, 0, 255, 255, 0, 0]), &[0b1000_0000]),
                3,
                vec![1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
                [1.0; 2],
            ),
            // Grey that is stored as colours or by a palette.
            (
                png(ColorType::Rgb, BitDepth::Eight, None, &[0x80, 0x80, 0x80, 255, 255, 255]),
                1,
                vec![shade, 1.0],
                [1.0; 2],
            ),
            (
                png(ColorType::Indexed, BitDepth::One, Some(&[0, 0, 0, 255, 255, 255]), &[0b1000_0000]),
                1,
                vec![1.0, 0.0],
                [1.0; 2],
            ),
        ] {
            let image = PngImage::read(&file).unwrap();
            assert_eq!((image.width, image.height, image.channels), (2, 1, channels));
            assert_eq!(image.values, expected);
            assert_eq!((0..2).map(|pixel| image.alpha_of(pixel)).collect::<Vec<_>>(), alpha);
        }
        let deep = PngImage::read(&png(ColorType::Grayscale, BitDepth::Sixteen, None, &[0, 1, 0xff, 0xff])).unwrap();
        assert_eq!(deep.values, [1.0 / 65_535.0, 1.0]);
    }

    #[test]
    fn a_header_of_too_many_pixels_is_refused() {
        let mut wide = Vec::new();
        let mut encoder = png::Encoder::new(&mut wide, 1 << 24, 1 << 24);
        encoder.set_color(ColorType::Grayscale);
        encoder.write_header().unwrap().write_chunk(png::chunk::IDAT, &[]).unwrap();
        let message = PngImage::read(&wide).unwrap_err();
        assert!(message.contains("16777216 × 16777216 pixels take 5637144576 MiB of memory"), "{message}");
    }

    #[test]
    fn grey_images_have_three_equal_channels() {
        let image = PngImage::read(&png(ColorType::Grayscale, BitDepth::Eight, None, &[188, 255])).unwrap();
        assert_eq!(image.encoded_rgb(), [[188.0 / 255.0; 3], [1.0; 3]]);
    }
}
