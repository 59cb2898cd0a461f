//! Text in raster images, set in Inter (SIL Open Font License, see `data/SOURCES.md`).

use std::sync::LazyLock;

use ab_glyph::{Font as _, FontRef, PxScale, ScaleFont as _, point};
use snowblue_color::Srgb8;

use snowblue_render::raster::RasterImage;

/// Size, weight and colour of text.
#[derive(Debug, Clone, Copy)]
pub struct Lettering {
    /// Font size in pixels: the height of the em.
    pub size_px: f32,
    /// Semibold instead of regular.
    pub bold: bool,
    /// Text colour.
    pub colour: Srgb8,
}

/// Where a line of text starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextOrigin {
    /// Left edge of the first letter, in pixels from the left.
    pub left_px: f32,
    /// Baseline, in pixels from the top.
    pub baseline_px: f32,
}

static REGULAR: LazyLock<FontRef<'static>> = LazyLock::new(|| font(include_bytes!("../../data/Inter-Regular.ttf")));
static SEMIBOLD: LazyLock<FontRef<'static>> = LazyLock::new(|| font(include_bytes!("../../data/Inter-SemiBold.ttf")));

fn font(bytes: &'static [u8]) -> FontRef<'static> {
    FontRef::try_from_slice(bytes).expect("the embedded font is valid: a test loads it")
}

impl Lettering {
    fn font(self) -> &'static FontRef<'static> {
        if self.bold { &SEMIBOLD } else { &REGULAR }
    }

    /// Converts an em size to the scale of `ab_glyph`, which is the height from ascent to descent.
    fn scale(self) -> PxScale {
        let font = self.font();
        PxScale::from(self.size_px * font.height_unscaled() / font.units_per_em().unwrap_or(1000.0))
    }

    /// Width of a line of text, in pixels.
    #[must_use]
    pub fn width_px(self, text: &str) -> f32 {
        let font = self.font().as_scaled(self.scale());
        text.chars().map(|letter| font.h_advance(font.glyph_id(letter))).sum()
    }

    /// Draws a line of text.
    pub fn draw(self, image: &mut RasterImage, origin: TextOrigin, text: &str) {
        let font = self.font().as_scaled(self.scale());
        let mut x_px = origin.left_px;
        for letter in text.chars() {
            let glyph = font.glyph_id(letter).with_scale_and_position(self.scale(), point(x_px, origin.baseline_px));
            x_px += font.h_advance(glyph.id);
            if let Some(outline) = font.outline_glyph(glyph) {
                let corner = outline.px_bounds().min;
                #[expect(clippy::cast_possible_truncation, reason = "an integer that is small")]
                let (x0, y0) = (corner.x as i32, corner.y as i32);
                outline.draw(|x, y, coverage| {
                    let (x, y) = (x0.saturating_add_unsigned(x), y0.saturating_add_unsigned(y));
                    image.blend(x, y, self.colour, coverage);
                });
            }
        }
    }

    /// Wraps text into lines of at most a width in pixels. A word that is wider has its own line.
    pub(crate) fn lines(self, text: &str, width_px: f32) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for word in text.split(' ') {
            match lines.last_mut() {
                Some(line) if self.width_px(&format!("{line} {word}")) <= width_px => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: Srgb8 = Srgb8 { r: 0, g: 0, b: 0 };
    const WHITE: Srgb8 = Srgb8 { r: 255, g: 255, b: 255 };

    #[test]
    fn both_weights_have_all_characters_of_labels() {
        for bold in [false, true] {
            let font = Lettering { size_px: 16.0, bold, colour: BLACK }.font();
            for letter in "AZaz09 µμ°²³⁻¹⁰·–—−×±*≈≤≥λΔθ%()/,.:;'’…".chars() {
                assert_ne!(font.glyph_id(letter).0, 0, "'{letter}' is missing");
            }
        }
    }

    #[test]
    fn text_stays_within_its_width_and_the_em() {
        let style = Lettering { size_px: 20.0, bold: true, colour: BLACK };
        let words = "300 kg/m³";
        let mut picture = RasterImage::filled(140, 40, WHITE);
        style.draw(&mut picture, TextOrigin { left_px: 10.0, baseline_px: 28.0 }, words);
        let inked: Vec<(u32, u32)> = (0..40)
            .flat_map(|y| (0..140).map(move |x| (x, y)))
            .filter(|(x, y)| picture.pixels()[(y * 140 + x) as usize] != WHITE)
            .collect();
        let right = inked.iter().map(|(x, _)| *x).max().unwrap();
        // A letter's ink may reach a pixel beyond its advance.
        assert!(f64::from(right) <= f64::from(10.0 + style.width_px(words)) + 1.0);
        assert!(right > 80 && inked.iter().all(|(x, y)| *x >= 9 && (8..=34).contains(y)), "{right}");
        assert!(picture.pixels().contains(&BLACK), "strokes are fully covered somewhere");
    }

    #[test]
    fn lines_break_between_words() {
        let style = Lettering { size_px: 12.0, bold: false, colour: BLACK };
        let lines = style.lines("light transmitted through snow", 80.0);
        assert!(lines.len() > 1 && lines.iter().all(|line| style.width_px(line) <= 80.0), "{lines:?}");
        assert_eq!(lines.join(" "), "light transmitted through snow");
    }
}
