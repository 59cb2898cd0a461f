//! Raster images in 8-bit sRGB.

use snowblue_color::{LinearRgb, Srgb8};

/// A pixel, counted from the upper left corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelPosition {
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
}

/// An image of encoded colours.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RasterImage {
    width: u32,
    height: u32,
    pixels: Vec<Srgb8>,
}

impl RasterImage {
    /// An image of given pixels, row by row from the upper left.
    ///
    /// # Panics
    ///
    /// When the number of pixels is not `width · height`.
    pub fn new(width: u32, height: u32, pixels: Vec<Srgb8>) -> Self {
        assert_eq!(pixels.len(), width as usize * height as usize, "one value per pixel");
        Self { width, height, pixels }
    }

    /// Square patches of colours without gaps: a list of columns for each row. Hues outside sRGB lose saturation.
    ///
    /// # Panics
    ///
    /// When the rows have different lengths, or `size_px` is zero.
    pub fn patches(rows: &[Vec<LinearRgb>], size_px: u32) -> Self {
        let size = size_px as usize;
        let line = |row: &Vec<LinearRgb>| -> Vec<Srgb8> {
            row.iter().flat_map(|colour| vec![Srgb8::encode(colour.displayable()); size]).collect()
        };
        let pixels: Vec<Srgb8> = rows.iter().flat_map(|row| line(row).repeat(size)).collect();
        let height = u32::try_from(rows.len()).expect("a picture has fewer rows") * size_px;
        Self::new(u32::try_from(pixels.len()).expect("and fewer pixels") / height, height, pixels)
    }

    /// Pixels from left to right.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels from top to bottom.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Colours, row by row from the upper left.
    pub fn pixels(&self) -> &[Srgb8] {
        &self.pixels
    }

    /// Red, green and blue of each pixel, row by row.
    pub fn bytes(&self) -> Vec<u8> {
        self.pixels.iter().flat_map(|colour| [colour.r, colour.g, colour.b]).collect()
    }
}
