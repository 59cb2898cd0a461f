//! Pictures as screens show them: pixels of 8-bit sRGB.

use snowblue_color::Srgb8;

/// A picture of encoded colours.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RasterImage {
    width: u32,
    height: u32,
    pixels: Vec<Srgb8>,
}

impl RasterImage {
    /// A picture of given pixels, row by row from the upper left.
    ///
    /// # Panics
    ///
    /// When there are not `width · height` pixels.
    pub fn new(width: u32, height: u32, pixels: Vec<Srgb8>) -> Self {
        assert_eq!(pixels.len(), width as usize * height as usize, "one value per pixel");
        Self { width, height, pixels }
    }

    /// A picture of one colour.
    pub fn plain(width: u32, height: u32, colour: Srgb8) -> Self {
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

    /// Lays another picture onto this one, its upper left corner at `(left, top)`.
    ///
    /// # Panics
    ///
    /// When it reaches beyond the edge.
    pub fn lay(&mut self, other: &RasterImage, (left, top): (u32, u32)) {
        let (wide, across) = (self.width as usize, other.width as usize);
        for (row, pixels) in other.pixels.chunks_exact(across).enumerate() {
            let start = (top as usize + row) * wide + left as usize;
            self.pixels[start..start + across].copy_from_slice(pixels);
        }
    }

    /// Covers a share of a pixel, 0–1, with a colour. Codes are mixed, not light: dark letters on a light ground keep the
    /// weight that their designer gave them. What lies beyond the edge is not drawn.
    pub(crate) fn cover(&mut self, (x, y): (i32, i32), colour: Srgb8, share: f32) {
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { return };
        if x < self.width && y < self.height {
            let pixel = &mut self.pixels[y as usize * self.width as usize + x as usize];
            let mix = |below: u8, above: u8| {
                let mixed = f32::from(below) + share.clamp(0.0, 1.0) * (f32::from(above) - f32::from(below));
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "rounded, between two bytes"
                )]
                let mixed = mixed.round() as u8;
                mixed
            };
            *pixel = Srgb8 { r: mix(pixel.r, colour.r), g: mix(pixel.g, colour.g), b: mix(pixel.b, colour.b) };
        }
    }
}
