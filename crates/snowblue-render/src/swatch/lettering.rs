//! Words in pictures, set in Inter (SIL Open Font License, see `data/SOURCES.md`).

use std::sync::LazyLock;

use ab_glyph::{Font as _, FontRef, PxScale, ScaleFont as _, point};
use snowblue_color::Srgb8;

use crate::images::raster::RasterImage;

/// How words look.
#[derive(Debug, Clone, Copy)]
pub struct Lettering {
    /// Size of the type, in pixels: the height of its em.
    pub size_px: f32,
    /// Semibold instead of regular.
    pub bold: bool,
    /// Colour of the ink.
    pub colour: Srgb8,
}

static REGULAR: LazyLock<FontRef<'static>> = LazyLock::new(|| font(include_bytes!("../../data/Inter-Regular.ttf")));
static SEMIBOLD: LazyLock<FontRef<'static>> = LazyLock::new(|| font(include_bytes!("../../data/Inter-SemiBold.ttf")));

fn font(bytes: &'static [u8]) -> FontRef<'static> {
    FontRef::try_from_slice(bytes).expect("the embedded typeface is whole: a test sets it")
}

impl Lettering {
    fn font(self) -> &'static FontRef<'static> {
        if self.bold { &SEMIBOLD } else { &REGULAR }
    }

    /// `ab_glyph` counts sizes from the top to the bottom of the line, typographers by the em.
    fn scale(self) -> PxScale {
        let font = self.font();
        PxScale::from(self.size_px * font.height_unscaled() / font.units_per_em().unwrap_or(1000.0))
    }

    /// Width of a line of words, in pixels.
    #[must_use]
    pub fn width_px(self, words: &str) -> f32 {
        let font = self.font().as_scaled(self.scale());
        words.chars().map(|letter| font.h_advance(font.glyph_id(letter))).sum()
    }

    /// Draws a line of words from `(left, baseline)`, in pixels.
    pub fn draw(self, picture: &mut RasterImage, (left, baseline): (f32, f32), words: &str) {
        let font = self.font().as_scaled(self.scale());
        let mut across = left;
        for letter in words.chars() {
            let glyph = font.glyph_id(letter).with_scale_and_position(self.scale(), point(across, baseline));
            across += font.h_advance(glyph.id);
            if let Some(outline) = font.outline_glyph(glyph) {
                let corner = outline.px_bounds().min;
                #[expect(clippy::cast_possible_truncation, reason = "whole numbers of pixels, few of them")]
                let (x0, y0) = (corner.x as i32, corner.y as i32);
                outline.draw(|x, y, share| {
                    picture.cover((x0.saturating_add_unsigned(x), y0.saturating_add_unsigned(y)), self.colour, share);
                });
            }
        }
    }

    /// Words in lines that are no wider than a width in pixels, except for single words that are.
    pub(crate) fn lines(self, words: &str, width_px: f32) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for word in words.split(' ') {
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
    fn both_weights_have_all_signs_of_labels() {
        for bold in [false, true] {
            let font = Lettering { size_px: 16.0, bold, colour: BLACK }.font();
            for letter in "AZaz09 µμ°²³⁻¹⁰·–—−×±*≈≤≥λΔθ%()/,.:;'’…".chars() {
                assert_ne!(font.glyph_id(letter).0, 0, "'{letter}' is missing");
            }
        }
    }

    #[test]
    fn words_stay_within_their_width_and_the_em() {
        let style = Lettering { size_px: 20.0, bold: true, colour: BLACK };
        let words = "300 kg/m³";
        let mut picture = RasterImage::plain(140, 40, WHITE);
        style.draw(&mut picture, (10.0, 28.0), words);
        let inked: Vec<(u32, u32)> = (0..40)
            .flat_map(|y| (0..140).map(move |x| (x, y)))
            .filter(|(x, y)| picture.pixels()[(y * 140 + x) as usize] != WHITE)
            .collect();
        let right = inked.iter().map(|(x, _)| *x).max().unwrap();
        // A letter's ink may reach a pixel beyond its advance.
        assert!(f64::from(right) <= f64::from(10.0 + style.width_px(words)) + 1.0);
        assert!(right > 80 && inked.iter().all(|(x, y)| *x >= 9 && (8..=34).contains(y)), "{right}");
        assert!(picture.pixels().contains(&BLACK), "strokes are full somewhere");
    }

    #[test]
    fn lines_break_between_words() {
        let style = Lettering { size_px: 12.0, bold: false, colour: BLACK };
        let lines = style.lines("light that comes through snow", 80.0);
        assert!(lines.len() > 1 && lines.iter().all(|line| style.width_px(line) <= 80.0), "{lines:?}");
        assert_eq!(lines.join(" "), "light that comes through snow");
    }
}
