//! Swatch sheets: labelled colours in rows and columns, flat or with a grey snow texture.

pub mod lettering;
pub mod snow_texture;

use snowblue_color::exposure::AutoExposure;
use snowblue_color::{LinearRgb, Srgb8};
use snowblue_render::raster::{PixelPosition, RasterImage};
use snowblue_render::scene::film::ImageSize;

use crate::swatch::lettering::{Lettering, TextOrigin};
use crate::swatch::snow_texture::SnowTexture;

const PAPER: Srgb8 = Srgb8 { r: 255, g: 255, b: 255 };
const INK: Srgb8 = Srgb8 { r: 31, g: 41, b: 51 };
const GREY: Srgb8 = Srgb8 { r: 107, g: 119, b: 133 };
/// A frame of one pixel around each swatch separates white swatches from the background.
const FRAME: Srgb8 = Srgb8 { r: 203, g: 210, b: 217 };

/// Least and greatest font size of labels, in pixels.
const MIN_FONT_PX: f32 = 13.0;
const MAX_FONT_PX: f32 = 30.0;
/// Swatch size over the font size of labels, within these limits.
const SWATCH_PER_FONT_SIZE: f32 = 9.0;
/// Least width of a sheet in ems, so that the title of a sheet with few swatches has room.
const MIN_WIDTH_EM: f32 = 24.0;

/// The quantity that varies along the rows or columns of a sheet.
#[derive(Debug, Clone, Default)]
pub struct SheetAxis {
    /// Name of the quantity; empty if nothing varies.
    pub name: String,
    /// One label, with unit, for each row or column.
    pub labels: Vec<String>,
}

/// A sheet of colours in rows and columns, with its texts.
#[derive(Debug, Clone)]
pub struct SwatchSheet {
    /// Title above the swatches.
    pub title: String,
    /// Footer below the swatches.
    pub footer: String,
    /// The quantity that varies from left to right.
    pub columns: SheetAxis,
    /// The quantity that varies from top to bottom.
    pub rows: SheetAxis,
    /// Linear colours to display, after exposure: a list of columns for each row.
    pub colours: Vec<Vec<LinearRgb>>,
    /// Height of a swatch, in pixels. Long labels make swatches wider than high.
    pub size_px: u32,
    /// Seed of the snow texture, which is the same on all swatches; none for flat colours.
    pub texture: Option<u64>,
}

/// A line of text and where it starts.
#[derive(Debug, Clone, Copy)]
struct PlacedText<'t> {
    style: Lettering,
    text: &'t str,
    origin: TextOrigin,
}

/// The layout of a sheet, in pixels.
#[derive(Debug, Clone)]
struct Layout {
    margin: f32,
    title: Lettering,
    label: Lettering,
    name: Lettering,
    footer: Lettering,
    title_lines: Vec<String>,
    footer_lines: Vec<String>,
    swatch: ImageSize,
    gap: u32,
    /// Upper left corner of the first swatch.
    first: PixelPosition,
    size: ImageSize,
}

/// The exposure factor that brings the brightest colour near white without clipping.
///
/// The greatest channel of all in-gamut colours becomes 1/[`SnowTexture::BRIGHTEST`] = 0.8 of the display range, which
/// leaves headroom for a texture. All colours have the same factor, so that they stay comparable. The factor is 1 if
/// all colours are black.
pub fn automatic_exposure<'c>(colours: impl IntoIterator<Item = &'c LinearRgb>) -> f64 {
    AutoExposure { fraction: 1.0, level: 1.0 / SnowTexture::BRIGHTEST }.factor(colours.into_iter().copied())
}

/// A swatch of a linear colour, flat or multiplied by a snow texture with a seed.
pub fn swatch(colour: LinearRgb, size: ImageSize, texture: Option<u64>) -> RasterImage {
    let Some(seed) = texture else {
        return RasterImage::filled(size.width, size.height, Srgb8::encode(colour.displayable()));
    };
    textured(colour, &SnowTexture::new(size.width, size.height, seed))
}

fn textured(colour: LinearRgb, texture: &SnowTexture) -> RasterImage {
    let colour = colour.into_gamut();
    let scaled = |factor: &f64| Srgb8::encode((colour * *factor).displayable());
    RasterImage::new(texture.width(), texture.height(), texture.factors().iter().map(scaled).collect())
}

impl SwatchSheet {
    /// Draws the sheet.
    pub fn draw(&self) -> RasterImage {
        let layout = self.layout();
        let mut image = RasterImage::filled(layout.size.width, layout.size.height, PAPER);
        let frame = RasterImage::filled(layout.swatch.width + 2, layout.swatch.height + 2, FRAME);
        let texture = self.texture.map(|seed| SnowTexture::new(layout.swatch.width, layout.swatch.height, seed));
        for (row, colours) in (0..).zip(&self.colours) {
            for (column, colour) in (0..).zip(colours) {
                let tile = match &texture {
                    Some(texture) => textured(*colour, texture),
                    None => swatch(*colour, layout.swatch, None),
                };
                let corner = layout.corner(row, column);
                image.paste(&frame, PixelPosition { x: corner.x - 1, y: corner.y - 1 });
                image.paste(&tile, corner);
            }
        }
        for text in self.texts(&layout) {
            text.style.draw(&mut image, text.origin, text.text);
        }
        image
    }

    /// The pixel in the centre of each swatch: a list of columns for each row.
    pub fn centres(&self) -> Vec<Vec<PixelPosition>> {
        let layout = self.layout();
        let centre = |row: u32, column: u32| {
            let PixelPosition { x, y } = layout.corner(row, column);
            PixelPosition { x: x + layout.swatch.width / 2, y: y + layout.swatch.height / 2 }
        };
        let across =
            |row: u32, colours: &Vec<LinearRgb>| (0..).zip(colours).map(|(column, _)| centre(row, column)).collect();
        (0..).zip(&self.colours).map(|(row, colours)| across(row, colours)).collect()
    }

    fn layout(&self) -> Layout {
        let size_px = self.size_px as f32;
        let font_px = (size_px / SWATCH_PER_FONT_SIZE).clamp(MIN_FONT_PX, MAX_FONT_PX);
        let style = |scale: f32, bold: bool, colour: Srgb8| Lettering { size_px: scale * font_px, bold, colour };
        let (title, label) = (style(1.25, true, INK), style(1.0, false, INK));
        let (name, footer) = (style(1.0, false, GREY), style(0.8, false, GREY));
        let widest = |labels: &[String]| labels.iter().map(|text| label.width_px(text)).fold(0.0, f32::max);
        let swatch =
            ImageSize { width: whole(size_px.max(widest(&self.columns.labels) + 0.5 * font_px)), height: self.size_px };
        let gap = whole((0.04 * size_px).max(3.0));
        let beside = widest(&self.rows.labels).max(name.width_px(&self.rows.name));
        let beside = if beside > 0.0 { beside + 0.8 * font_px } else { 0.0 };
        let margin = 1.6 * font_px;
        let count = self.columns.labels.len() as f32;
        let grid = beside + count * swatch.width as f32 + (count - 1.0).max(0.0) * gap as f32;
        let longest_word =
            |style: Lettering, text: &str| text.split(' ').map(|word| style.width_px(word)).fold(0.0, f32::max);
        let content = grid
            .max(MIN_WIDTH_EM * font_px)
            .max(longest_word(title, &self.title))
            .max(longest_word(footer, &self.footer))
            .max(beside + name.width_px(&self.columns.name));
        let (title_lines, footer_lines) = (title.lines(&self.title, content), footer.lines(&self.footer, content));
        let above = margin + 1.25 * title.size_px * title_lines.len() as f32 + 1.0 * font_px;
        let names = if self.columns.name.is_empty() { 0.0 } else { 1.5 * font_px };
        // The name of the rows is on the same line as the labels of the columns.
        let labelled = widest(&self.columns.labels) > 0.0 || !self.rows.name.is_empty();
        let labels = if labelled { 1.5 * font_px } else { 0.0 };
        let first = PixelPosition { x: whole(margin + beside), y: whole(above + names + labels) };
        let rows = u32::try_from(self.colours.len()).unwrap_or(u32::MAX);
        let below = first.y + rows * (swatch.height + gap);
        let height =
            below as f32 + 1.0 * font_px + 1.45 * footer.size_px * footer_lines.len() as f32 + margin - 0.4 * font_px;
        let size = ImageSize { width: whole(content + 2.0 * margin), height: whole(height) };
        Layout { margin, title, label, name, footer, title_lines, footer_lines, swatch, gap, first, size }
    }

    /// All texts of the sheet.
    fn texts<'t>(&'t self, layout: &'t Layout) -> Vec<PlacedText<'t>> {
        let Layout { margin, title, label, name, footer, .. } = *layout;
        let mut texts = Vec::new();
        let mut add = |style: Lettering, text: &'t str, left_px: f32, baseline_px: f32| {
            texts.push(PlacedText { style, text, origin: TextOrigin { left_px, baseline_px } });
        };
        for (line, text) in layout.title_lines.iter().enumerate() {
            add(title, text, margin, margin + title.size_px * (0.8 + 1.25 * line as f32));
        }
        let (left, top) = (layout.first.x as f32, layout.first.y as f32);
        let above = top - 0.55 * label.size_px;
        let beside = |style: Lettering, text: &str| left - 0.8 * label.size_px - style.width_px(text);
        if !self.columns.name.is_empty() {
            add(name, &self.columns.name, left, above - 1.5 * label.size_px);
        }
        if !self.rows.name.is_empty() {
            add(name, &self.rows.name, beside(name, &self.rows.name), above);
        }
        for (column, text) in (0..).zip(&self.columns.labels) {
            let middle = layout.corner(0, column).x as f32 + 0.5 * layout.swatch.width as f32;
            add(label, text, middle - 0.5 * label.width_px(text), above);
        }
        for (row, text) in (0..).zip(&self.rows.labels) {
            let middle = layout.corner(row, 0).y as f32 + 0.5 * layout.swatch.height as f32;
            add(label, text, beside(label, text), middle + 0.36 * label.size_px);
        }
        let height = layout.size.height as f32;
        let lines = layout.footer_lines.len() as f32;
        let first = height - margin + 0.3 * footer.size_px - 1.45 * footer.size_px * (lines - 1.0);
        for (line, text) in layout.footer_lines.iter().enumerate() {
            add(footer, text, margin, first + 1.45 * footer.size_px * line as f32);
        }
        texts
    }
}

impl Layout {
    /// The upper left corner of a swatch.
    fn corner(&self, row: u32, column: u32) -> PixelPosition {
        PixelPosition {
            x: self.first.x + column * (self.swatch.width + self.gap),
            y: self.first.y + row * (self.swatch.height + self.gap),
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "image sizes are positive and far below 2³²"
)]
fn whole(pixels: f32) -> u32 {
    pixels.ceil() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(columns: &[&str], rows: &[&str], size_px: u32) -> SwatchSheet {
        let axis = |name: &str, labels: &[&str]| SheetAxis {
            name: name.to_owned(),
            labels: labels.iter().map(|label| (*label).to_owned()).collect(),
        };
        let blue = LinearRgb { r: 0.1, g: 0.3, b: 0.6 };
        SwatchSheet {
            title: "Light through snow: 350–450 µm, facetness 0.3, 300 kg/m³".to_owned(),
            footer:
                "snowblue · exposure +3.2 stops · ice warren2008 · a_word_that_is_longer_than_any_that_one_would_expect"
                    .to_owned(),
            columns: axis("angle of incidence", columns),
            rows: axis("a quantity of long name", rows),
            colours: vec![vec![blue; columns.len()]; rows.len()],
            size_px,
            texture: None,
        }
    }

    fn sheets() -> Vec<SwatchSheet> {
        let few = sheet(&["0°"], &["100 µm"], 16);
        let many = sheet(&["0°", "89°", "diffuse", "FL3.15"], &["1 cm", "0.2:0.4:0.3:0.075"], 40);
        let large = sheet(&["0°", "20°"], &[""], 500);
        let mut rows_alone = sheet(&[""], &["100 µm", "500 µm"], 100);
        rows_alone.columns.name = String::new();
        vec![few, many, large, rows_alone]
    }

    #[test]
    fn texts_lie_within_the_sheet_and_overlap_neither_swatches_nor_each_other() {
        for sheet in sheets() {
            let layout = sheet.layout();
            let (width, height) = (layout.size.width as f32, layout.size.height as f32);
            let texts = sheet.texts(&layout);
            // Left, right, top and bottom of the letters. Ascenders are 0.76 em high, descenders 0.24 em deep.
            let boxes: Vec<[f32; 4]> = texts
                .iter()
                .filter(|text| !text.text.is_empty())
                .map(|PlacedText { style, text, origin: TextOrigin { left_px: x, baseline_px: y } }| {
                    [*x, x + style.width_px(text), y - 0.76 * style.size_px, y + 0.24 * style.size_px]
                })
                .collect();
            for (i, [left, right, top, bottom]) in boxes.iter().enumerate() {
                assert!(*left >= 0.0 && *right <= width && *top >= 0.0 && *bottom <= height, "{:?}", texts[i].text);
                let apart = |other: &[f32; 4]| {
                    right <= &other[0] || &other[1] <= left || bottom <= &other[2] || &other[3] <= top
                };
                assert!(boxes[..i].iter().all(apart), "{:?}", texts[i].text);
                for PixelPosition { x, y } in (0..)
                    .zip(&sheet.colours)
                    .flat_map(|(row, of)| (0..).zip(of).map(move |(column, _)| (row, column)))
                    .map(|(row, column)| layout.corner(row, column))
                {
                    let (x, y) = (x as f32, y as f32);
                    assert!(
                        apart(&[x, x + layout.swatch.width as f32, y, y + layout.swatch.height as f32]),
                        "{:?}",
                        texts[i].text
                    );
                }
            }
        }
    }

    #[test]
    fn flat_swatches_have_their_colours() {
        for sheet in sheets() {
            let picture = sheet.draw();
            for (colours, centres) in sheet.colours.iter().zip(sheet.centres()) {
                for (colour, PixelPosition { x, y }) in colours.iter().zip(centres) {
                    assert_eq!(picture.pixels()[(y * picture.width() + x) as usize], Srgb8::encode(*colour));
                }
            }
        }
    }

    #[test]
    fn a_frame_separates_white_swatches_from_the_background() {
        let mut sheet = sheet(&["0°", "20°"], &["100 µm"], 40);
        sheet.colours = vec![vec![LinearRgb { r: 1.0, g: 1.0, b: 1.0 }; 2]];
        let (picture, layout) = (sheet.draw(), sheet.layout());
        let pixel = |x: u32, y: u32| picture.pixels()[(y * picture.width() + x) as usize];
        for column in 0..2 {
            let PixelPosition { x, y } = layout.corner(0, column);
            assert_eq!((pixel(x, y), pixel(x - 1, y + 20), pixel(x - 2, y + 20)), (PAPER, FRAME, PAPER));
        }
    }

    #[test]
    fn the_average_of_a_textured_swatch_is_its_colour() {
        let colour = LinearRgb { r: 0.12, g: 0.4, b: 0.8 };
        let picture = swatch(colour, ImageSize { width: 160, height: 160 }, Some(1));
        let (mut r, mut g, mut b) = (0.0, 0.0, 0.0);
        for pixel in picture.pixels() {
            let light = pixel.decode();
            (r, g, b) = (r + light.r, g + light.g, b + light.b);
        }
        let count = picture.pixels().len() as f64;
        for (sum, expected) in [(r, colour.r), (g, colour.g), (b, colour.b)] {
            // Rounding to 8 bits errs by at most 0.5 % for each pixel and averages out over 25,600 pixels.
            assert!((sum / count / expected - 1.0).abs() < 1e-3, "{} {expected}", sum / count);
        }
    }

    #[test]
    fn automatic_exposure_leaves_headroom_for_the_texture() {
        let colours = [LinearRgb { r: -0.01, g: 0.004, b: 0.02 }, LinearRgb { r: 0.001, g: 0.001, b: 0.001 }];
        let factor = automatic_exposure(&colours);
        let LinearRgb { r, g, b } = colours[0].into_gamut();
        assert!((factor * r.max(g).max(b) - 0.8).abs() < 1e-12);
        assert!((automatic_exposure(&[LinearRgb::default()]) - 1.0).abs() < 1e-15, "black stays black");
    }
}
