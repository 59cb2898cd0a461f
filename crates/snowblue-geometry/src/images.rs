//! Image files as input: PNG for textures, masks and height fields, JPEG for textures of a glTF, and the memory that
//! OpenEXR files take, known from their headers before anything is decoded.

use std::io::Cursor;

use exr::image::{AnyChannels, FlatSamples, Image, Layers};
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::{ReadChannels, ReadLayers};
use image::codecs::png::PngDecoder;
use image::{DynamicImage, ImageDecoder as _, ImageError, Rgba};
use snowblue_base::files::{FileError, NamedFile, check_expansion, check_formats, check_memory, one_line};
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::options::DecoderOptions;

/// The first bytes of a JPEG file.
const JPEG_START: [u8; 2] = [0xff, 0xd8];

/// An image with the values of its file, scaled to 0–1.
#[derive(Debug, Clone, PartialEq)]
pub struct DecodedImage {
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

impl DecodedImage {
    /// Decodes a PNG file.
    ///
    /// # Errors
    ///
    /// As [`read`](Self::read), for a JPEG, and in a build without the feature `formats`.
    pub fn decode(file: &NamedFile) -> Result<Self, FileError> {
        check_formats(&file.path)?;
        let image = if file.bytes.starts_with(&JPEG_START) {
            Err("it is a JPEG file, but must be a PNG file: save it as PNG".to_owned())
        } else {
            Self::read_png(&file.bytes)
        };
        image.map_err(|reason| FileError::Content { path: file.path.clone(), reason })
    }

    /// Decodes a PNG or a JPEG, by its first bytes, as a glTF may hold it.
    ///
    /// # Errors
    ///
    /// When the file is malformed, or takes more memory than a file of its length may take.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        if bytes.starts_with(&JPEG_START) { Self::read_jpeg(bytes) } else { Self::read_png(bytes) }
    }

    /// Decodes a PNG of any colour type. Palettes become colours, and colours that are all grey become grey.
    fn read_png(png: &[u8]) -> Result<Self, String> {
        let malformed = |error: ImageError| format!("not a readable PNG file: {}", one_line(&error.to_string()));
        let decoder = PngDecoder::new(Cursor::new(png)).map_err(malformed)?;
        let ((width, height), color) = (decoder.dimensions(), decoder.color_type());
        // Memory of the decoded image, of its colours with alpha, of its values, and of the colours made of the values.
        let pixel_bytes = usize::from(color.bytes_per_pixel()) + size_of::<[u16; 4]>() + 2 * size_of::<[f32; 4]>();
        let pixels = f64::from(width) * f64::from(height);
        check_memory(&format!("{width} × {height} pixels"), pixels * pixel_bytes as f64, png.len())?;
        let image = DynamicImage::from_decoder(decoder).map_err(malformed)?.into_rgba16();
        let is_grey = image.pixels().all(|Rgba([r, g, b, _])| r == g && r == b);
        let channels = if is_grey { 1 } else { 3 };
        let fraction = |value: &u16| f32::from(*value) / 65_535.0;
        let values = image.pixels().flat_map(|Rgba(pixel)| pixel[..channels].iter().map(fraction)).collect();
        let alpha = image.pixels().filter(|_| color.has_alpha()).map(|Rgba([.., alpha])| fraction(alpha)).collect();
        Ok(Self { width: width as usize, height: height as usize, channels, values, alpha })
    }

    /// Decodes a JPEG. Its orientation and its colour profile are no part of a glTF.
    fn read_jpeg(jpeg: &[u8]) -> Result<Self, String> {
        let malformed = |error: DecodeErrors| format!("not a readable JPEG file: {}", one_line(&format!("{error:?}")));
        let mut decoder =
            JpegDecoder::new_with_options(Cursor::new(jpeg), DecoderOptions::new_safe().set_strict_mode(true));
        decoder.decode_headers().map_err(malformed)?;
        let (width, height) = decoder.dimensions().ok_or("the image has no size")?;
        // Memory of the decoded image, of its values, and of the colours with alpha made of the values.
        let pixel_bytes = 3 * (1 + size_of::<f32>()) + size_of::<[f32; 4]>();
        check_memory(&format!("{width} × {height} pixels"), (width * height * pixel_bytes) as f64, jpeg.len())?;
        let bytes = decoder.decode().map_err(malformed)?;
        let values = bytes.iter().map(|byte| f32::from(*byte) / 255.0).collect();
        Ok(Self { width, height, channels: bytes.len() / (width * height), values, alpha: Vec::new() })
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

/// The parts of an OpenEXR file with all channels and attributes.
pub type ExrImage = Image<Layers<AnyChannels<FlatSamples>>>;

/// Decodes an OpenEXR file, unless its images together take more memory than the file may take. `pixel_bytes` gives
/// the memory of a pixel in bytes, from the bytes of its samples in the file.
///
/// # Errors
///
/// When the file is malformed, or an image takes more memory.
pub fn read_exr(bytes: &[u8], pixel_bytes: impl Fn(usize) -> usize) -> Result<ExrImage, String> {
    let unreadable = |error: exr::error::Error| format!("not a readable EXR file: {error}");
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(unreadable)?;
    let mut asked = 0.0;
    for header in &meta.headers {
        let (what, of_header) = memory(header, &pixel_bytes);
        asked += of_header;
        check_memory(&what, asked, bytes.len())?;
    }
    let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().all_layers();
    reader.all_attributes().from_buffered(Cursor::new(bytes)).map_err(unreadable)
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
    use base64::Engine as _;
    use base64::engine::general_purpose::STANDARD;
    use png::{BitDepth, ColorType};

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
            let image = DecodedImage::read(&file).unwrap();
            assert_eq!((image.width, image.height, image.channels), (2, 1, channels));
            assert_eq!(image.values, expected);
            assert_eq!((0..2).map(|pixel| image.alpha_of(pixel)).collect::<Vec<_>>(), alpha);
        }
        let deep =
            DecodedImage::read(&png(ColorType::Grayscale, BitDepth::Sixteen, None, &[0, 1, 0xff, 0xff])).unwrap();
        assert_eq!(deep.values, [1.0 / 65_535.0, 1.0]);
    }

    /// Red, green, blue and white, each 8 × 8 pixels, as libjpeg writes it with quality 75.
    const FOUR_COLOURS: &str = "\
        /9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAgGBgcGBQgHBwcJCQgKDBQNDAsLDBkSEw8UHRofHh0aHBwgJC4nICIsIxwcKDcpLDAx\
        NDQ0Hyc5PTgyPC4zNDL/2wBDAQkJCQwLDBgNDRgyIRwhMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIyMjIy\
        MjIyMjIyMjL/wAARCAAQABADAREAAhEBAxEB/8QAFgABAQEAAAAAAAAAAAAAAAAABwYI/8QAFBABAAAAAAAAAAAAAAAAAAAAAP/E\
        ABcBAAMBAAAAAAAAAAAAAAAAAAYHCAX/xAAUEQEAAAAAAAAAAAAAAAAAAAAA/9oADAMBAAIRAxEAPwCLDJ4koNIvAyvDMbiI5pv/\
        2Q==";

    /// The luminance of these colours.
    const FOUR_GREYS: &str = "\
        /9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAgGBgcGBQgHBwcJCQgKDBQNDAsLDBkSEw8UHRofHh0aHBwgJC4nICIsIxwcKDcpLDAx\
        NDQ0Hyc5PTgyPC4zNDL/wAALCAAQABABAREA/8QAFgABAQEAAAAAAAAAAAAAAAAABwYI/8QAFBABAAAAAAAAAAAAAAAAAAAAAP/a\
        AAgBAQAAPwCLJQGbif/Z";

    #[test]
    fn reads_colours_and_greys_of_a_jpeg() {
        let decode = |text| STANDARD.decode(text).unwrap();
        let middles = [(4, 4), (12, 4), (4, 12), (12, 12)];
        let image = DecodedImage::read(&decode(FOUR_COLOURS)).unwrap();
        assert_eq!((image.width, image.height, image.alpha.len()), (16, 16, 0));
        let pixels = image.encoded_rgb();
        let expected = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]];
        // Luminance of Rec. 601, by which JPEG codes colours.
        let greys = DecodedImage::read(&decode(FOUR_GREYS)).unwrap().encoded_rgb();
        for (((x, y), color), grey) in middles.into_iter().zip(expected).zip([0.299, 0.587, 0.114, 1.0f32]) {
            let (found, found_grey) = (pixels[y * 16 + x], greys[y * 16 + x]);
            assert!((0..3).all(|channel| (found[channel] - color[channel]).abs() < 0.02), "{found:?} for {color:?}");
            assert!(found_grey.iter().all(|value| (value - grey).abs() < 0.02), "{found_grey:?} for {grey}");
        }
    }

    #[test]
    fn a_jpeg_that_is_cut_or_named_as_png_is_refused() {
        let whole = STANDARD.decode(FOUR_COLOURS).unwrap();
        let file = NamedFile { path: "a.png".into(), bytes: whole.clone() };
        assert!(DecodedImage::decode(&file).unwrap_err().to_string().ends_with("save it as PNG"));
        for length in 0..whole.len() - 8 {
            assert!(DecodedImage::read(&whole[..length]).is_err(), "{length} of {} bytes", whole.len());
        }
    }

    #[test]
    fn a_header_of_too_many_pixels_is_refused() {
        let mut wide = Vec::new();
        let mut encoder = png::Encoder::new(&mut wide, 1 << 24, 1 << 24);
        encoder.set_color(ColorType::Grayscale);
        encoder.write_header().unwrap().write_chunk(png::chunk::IDAT, &[]).unwrap();
        let message = DecodedImage::read(&wide).unwrap_err();
        assert!(message.contains("16777216 × 16777216 pixels take 11005853696 MiB of memory"), "{message}");
    }

    #[test]
    fn grey_images_have_three_equal_channels() {
        let image = DecodedImage::read(&png(ColorType::Grayscale, BitDepth::Eight, None, &[188, 255])).unwrap();
        assert_eq!(image.encoded_rgb(), [[188.0 / 255.0; 3], [1.0; 3]]);
    }
}
