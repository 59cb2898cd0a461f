//! Raster images in 8-bit sRGB.

use snowblue_color::Srgb8;

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

    /// An image of one colour.
    pub fn filled(width: u32, height: u32, colour: Srgb8) -> Self {
        Self { width, height, pixels: vec![colour; width as usize * height as usize] }
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

    /// Copies another image into this one, with its upper left corner at a pixel.
    ///
    /// # Panics
    ///
    /// When the other image reaches beyond the edge.
    pub fn paste(&mut self, other: &RasterImage, at: PixelPosition) {
        let (width, other_width) = (self.width as usize, other.width as usize);
        for (row, pixels) in other.pixels.chunks_exact(other_width).enumerate() {
            let start = (at.y as usize + row) * width + at.x as usize;
            self.pixels[start..start + other_width].copy_from_slice(pixels);
        }
    }

    /// Blends a colour over a pixel with a coverage of 0–1. Blends encoded values instead of linear light, so that dark
    /// letters on a light background keep the weight of their design. Ignores pixels outside the image.
    pub fn blend(&mut self, x: i32, y: i32, colour: Srgb8, coverage: f32) {
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { return };
        if x < self.width && y < self.height {
            let pixel = &mut self.pixels[y as usize * self.width as usize + x as usize];
            let mix = |below: u8, above: u8| {
                let mixed = f32::from(below) + coverage.clamp(0.0, 1.0) * (f32::from(above) - f32::from(below));
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "rounded, and between two bytes"
                )]
                let mixed = mixed.round() as u8;
                mixed
            };
            *pixel = Srgb8 { r: mix(pixel.r, colour.r), g: mix(pixel.g, colour.g), b: mix(pixel.b, colour.b) };
        }
    }
}
