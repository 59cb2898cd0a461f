//! Sheets of swatches: colours in rows and columns with their labels, flat or with the grey of snow over them.

pub mod lettering;
pub mod snow_texture;

use snowblue_color::exposure::AutoExposure;
use snowblue_color::{LinearRgb, Srgb8};

use crate::images::raster::RasterImage;
use crate::swatch::lettering::Lettering;
use crate::swatch::snow_texture::SnowTexture;

const PAPER: Srgb8 = Srgb8 { r: 255, g: 255, b: 255 };
const INK: Srgb8 = Srgb8 { r: 31, g: 41, b: 51 };
const GREY: Srgb8 = Srgb8 { r: 107, g: 119, b: 133 };
/// Around each swatch a line of one pixel, which tells white swatches from the paper.
const FRAME: Srgb8 = Srgb8 { r: 203, g: 210, b: 217 };

/// Sizes of type in pixels between which labels follow the size of the swatches.
const TYPE_PX: (f32, f32) = (13.0, 30.0);
/// Swatches are so many times as large as the type of their labels.
const TYPE_SHARE: f32 = 9.0;
/// A sheet is at least as wide as so many ems, so that few swatches do not break its title to pieces.
const LEAST_EMS: f32 = 24.0;

/// What varies along the rows or columns of a sheet.
#[derive(Debug, Clone, Default)]
pub struct SheetAxis {
    /// Name of the quantity; none if nothing varies.
    pub name: String,
    /// One label, with unit, for each row or column.
    pub labels: Vec<String>,
}

/// Colours in rows and columns, and the words around them.
#[derive(Debug, Clone)]
pub struct SwatchSheet {
    /// What is shown.
    pub title: String,
    /// What made it.
    pub closing: String,
    /// What varies from left to right.
    pub columns: SheetAxis,
    /// What varies from top to bottom.
    pub rows: SheetAxis,
    /// Linear light as it is to be shown, exposed already: for each row, each column.
    pub colours: Vec<Vec<LinearRgb>>,
    /// Height of a swatch, in pixels; it is as wide or, under long labels, wider.
    pub size_px: u32,
    /// Seed of the snow texture, which is the same on all swatches, so that only colours differ; none for flat colours.
    pub texture: Option<u64>,
}

/// Where things lie on a sheet, in pixels.
#[derive(Debug, Clone)]
struct Layout {
    margin: f32,
    title: Lettering,
    label: Lettering,
    name: Lettering,
    closing: Lettering,
    title_lines: Vec<String>,
    closing_lines: Vec<String>,
    swatch: (u32, u32),
    gap: u32,
    /// Upper left corner of the first swatch.
    first: (u32, u32),
    size: (u32, u32),
}

/// The factor that brings the brightest of some colours towards white, so that no channel is cut off.
///
/// The greatest channel of all, colours being within the gamut, becomes 1/[`SnowTexture::BRIGHTEST`] = 0.8 of what a screen
/// can show: a texture has room above it. One factor serves all colours, so that they compare; darkness stays as it is.
pub fn automatic_exposure<'c>(colours: impl IntoIterator<Item = &'c LinearRgb>) -> f64 {
    AutoExposure { fraction: 1.0, level: 1.0 / SnowTexture::BRIGHTEST }.factor(colours.into_iter().copied())
}

/// A swatch: a colour in linear light, flat or times a texture.
pub fn swatch(colour: LinearRgb, (width, height): (u32, u32), texture: Option<u64>) -> RasterImage {
    let Some(seed) = texture else {
        return RasterImage::plain(width, height, Srgb8::encode(colour.displayable()));
    };
    textured(colour, &SnowTexture::new(width, height, seed))
}

fn textured(colour: LinearRgb, texture: &SnowTexture) -> RasterImage {
    let colour = colour.into_gamut();
    let times = |factor: &f64| Srgb8::encode((colour * *factor).displayable());
    RasterImage::new(texture.width(), texture.height(), texture.factors().iter().map(times).collect())
}

impl SwatchSheet {
    /// The sheet as a picture.
    pub fn draw(&self) -> RasterImage {
        let layout = self.layout();
        let mut picture = RasterImage::plain(layout.size.0, layout.size.1, PAPER);
        let frame = RasterImage::plain(layout.swatch.0 + 2, layout.swatch.1 + 2, FRAME);
        let texture = self.texture.map(|seed| SnowTexture::new(layout.swatch.0, layout.swatch.1, seed));
        for (row, colours) in (0..).zip(&self.colours) {
            for (column, colour) in (0..).zip(colours) {
                let tile = match &texture {
                    Some(texture) => textured(*colour, texture),
                    None => swatch(*colour, layout.swatch, None),
                };
                let (x, y) = layout.corner(row, column);
                picture.lay(&frame, (x - 1, y - 1));
                picture.lay(&tile, (x, y));
            }
        }
        for (style, words, place) in self.words(&layout) {
            style.draw(&mut picture, place, words);
        }
        picture
    }

    /// The middle of each swatch, for each row and column, in pixels from the upper left corner of the sheet.
    pub fn middles(&self) -> Vec<Vec<(u32, u32)>> {
        let layout = self.layout();
        let middle = |row: u32, column: u32| {
            let (x, y) = layout.corner(row, column);
            (x + layout.swatch.0 / 2, y + layout.swatch.1 / 2)
        };
        let across =
            |row: u32, colours: &Vec<LinearRgb>| (0..).zip(colours).map(|(column, _)| middle(row, column)).collect();
        (0..).zip(&self.colours).map(|(row, colours)| across(row, colours)).collect()
    }

    fn layout(&self) -> Layout {
        let size_px = self.size_px as f32;
        let type_px = (size_px / TYPE_SHARE).clamp(TYPE_PX.0, TYPE_PX.1);
        let style = |share: f32, bold: bool, colour: Srgb8| Lettering { size_px: share * type_px, bold, colour };
        let (title, label) = (style(1.25, true, INK), style(1.0, false, INK));
        let (name, closing) = (style(1.0, false, GREY), style(0.8, false, GREY));
        let widest = |words: &[String]| words.iter().map(|words| label.width_px(words)).fold(0.0, f32::max);
        let swatch = (whole(size_px.max(widest(&self.columns.labels) + 0.5 * type_px)), self.size_px);
        let gap = whole((0.04 * size_px).max(3.0));
        let beside = widest(&self.rows.labels).max(name.width_px(&self.rows.name));
        let beside = if beside > 0.0 { beside + 0.8 * type_px } else { 0.0 };
        let margin = 1.6 * type_px;
        let count = self.columns.labels.len() as f32;
        let grid = beside + count * swatch.0 as f32 + (count - 1.0).max(0.0) * gap as f32;
        let longest_word =
            |style: Lettering, words: &str| words.split(' ').map(|word| style.width_px(word)).fold(0.0, f32::max);
        let content = grid
            .max(LEAST_EMS * type_px)
            .max(longest_word(title, &self.title))
            .max(longest_word(closing, &self.closing))
            .max(beside + name.width_px(&self.columns.name));
        let (title_lines, closing_lines) = (title.lines(&self.title, content), closing.lines(&self.closing, content));
        let above = margin + 1.25 * title.size_px * title_lines.len() as f32 + 1.0 * type_px;
        let names = if self.columns.name.is_empty() { 0.0 } else { 1.5 * type_px };
        // The name of the rows stands on the line of the columns' labels.
        let labelled = widest(&self.columns.labels) > 0.0 || !self.rows.name.is_empty();
        let labels = if labelled { 1.5 * type_px } else { 0.0 };
        let first = (whole(margin + beside), whole(above + names + labels));
        let rows = u32::try_from(self.colours.len()).unwrap_or(u32::MAX);
        let below = first.1 + rows * (swatch.1 + gap);
        let height =
            below as f32 + 1.0 * type_px + 1.45 * closing.size_px * closing_lines.len() as f32 + margin - 0.4 * type_px;
        let size = (whole(content + 2.0 * margin), whole(height));
        Layout { margin, title, label, name, closing, title_lines, closing_lines, swatch, gap, first, size }
    }

    /// All words with their look, and where their first letter stands on its baseline.
    fn words<'w>(&'w self, layout: &'w Layout) -> Vec<(Lettering, &'w str, (f32, f32))> {
        let Layout { margin, title, label, name, closing, .. } = *layout;
        let mut words = Vec::new();
        for (line, text) in layout.title_lines.iter().enumerate() {
            words.push((title, text.as_str(), (margin, margin + title.size_px * (0.8 + 1.25 * line as f32))));
        }
        let (left, top) = (layout.first.0 as f32, layout.first.1 as f32);
        let above = top - 0.55 * label.size_px;
        let beside = |style: Lettering, words: &str| left - 0.8 * label.size_px - style.width_px(words);
        if !self.columns.name.is_empty() {
            words.push((name, &self.columns.name, (left, above - 1.5 * label.size_px)));
        }
        if !self.rows.name.is_empty() {
            words.push((name, &self.rows.name, (beside(name, &self.rows.name), above)));
        }
        for (column, text) in (0..).zip(&self.columns.labels) {
            let middle = layout.corner(0, column).0 as f32 + 0.5 * layout.swatch.0 as f32;
            words.push((label, text, (middle - 0.5 * label.width_px(text), above)));
        }
        for (row, text) in (0..).zip(&self.rows.labels) {
            let middle = layout.corner(row, 0).1 as f32 + 0.5 * layout.swatch.1 as f32;
            words.push((label, text, (beside(label, text), middle + 0.36 * label.size_px)));
        }
        let (_, height) = layout.size;
        let lines = layout.closing_lines.len() as f32;
        let first = height as f32 - margin + 0.3 * closing.size_px - 1.45 * closing.size_px * (lines - 1.0);
        for (line, text) in layout.closing_lines.iter().enumerate() {
            words.push((closing, text, (margin, first + 1.45 * closing.size_px * line as f32)));
        }
        words
    }
}

impl Layout {
    fn corner(&self, row: u32, column: u32) -> (u32, u32) {
        (self.first.0 + column * (self.swatch.0 + self.gap), self.first.1 + row * (self.swatch.1 + self.gap))
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "sizes of pictures: positive, far below 2³²"
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
            closing:
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
    fn words_lie_within_the_sheet_and_none_on_a_swatch_or_each_other() {
        for sheet in sheets() {
            let layout = sheet.layout();
            let (width, height) = (layout.size.0 as f32, layout.size.1 as f32);
            let words = sheet.words(&layout);
            // Left, right, top and bottom of the letters: ascenders reach .76 em up, descenders .24 em down.
            let boxes: Vec<[f32; 4]> = words
                .iter()
                .filter(|(_, words, _)| !words.is_empty())
                .map(|(style, words, (x, y))| {
                    [*x, x + style.width_px(words), y - 0.76 * style.size_px, y + 0.24 * style.size_px]
                })
                .collect();
            for (i, [left, right, top, bottom]) in boxes.iter().enumerate() {
                assert!(*left >= 0.0 && *right <= width && *top >= 0.0 && *bottom <= height, "{:?}", words[i].1);
                let apart = |other: &[f32; 4]| {
                    right <= &other[0] || &other[1] <= left || bottom <= &other[2] || &other[3] <= top
                };
                assert!(boxes[..i].iter().all(apart), "{:?}", words[i].1);
                for (x, y) in (0..)
                    .zip(&sheet.colours)
                    .flat_map(|(row, of)| (0..).zip(of).map(move |(column, _)| (row, column)))
                    .map(|(row, column)| layout.corner(row, column))
                {
                    let (x, y) = (x as f32, y as f32);
                    assert!(apart(&[x, x + layout.swatch.0 as f32, y, y + layout.swatch.1 as f32]), "{:?}", words[i].1);
                }
            }
        }
    }

    #[test]
    fn flat_swatches_have_their_colours() {
        for sheet in sheets() {
            let picture = sheet.draw();
            for (colours, middles) in sheet.colours.iter().zip(sheet.middles()) {
                for (colour, (x, y)) in colours.iter().zip(middles) {
                    assert_eq!(picture.pixels()[(y * picture.width() + x) as usize], Srgb8::encode(*colour));
                }
            }
        }
    }

    #[test]
    fn white_swatches_are_told_from_the_paper() {
        let mut sheet = sheet(&["0°", "20°"], &["100 µm"], 40);
        sheet.colours = vec![vec![LinearRgb { r: 1.0, g: 1.0, b: 1.0 }; 2]];
        let (picture, layout) = (sheet.draw(), sheet.layout());
        let pixel = |x: u32, y: u32| picture.pixels()[(y * picture.width() + x) as usize];
        for column in 0..2 {
            let (x, y) = layout.corner(0, column);
            assert_eq!((pixel(x, y), pixel(x - 1, y + 20), pixel(x - 2, y + 20)), (PAPER, FRAME, PAPER));
        }
    }

    #[test]
    fn the_average_of_a_textured_swatch_is_its_colour() {
        let colour = LinearRgb { r: 0.12, g: 0.4, b: 0.8 };
        let picture = swatch(colour, (160, 160), Some(1));
        let (mut r, mut g, mut b) = (0.0, 0.0, 0.0);
        for pixel in picture.pixels() {
            let light = pixel.decode();
            (r, g, b) = (r + light.r, g + light.g, b + light.b);
        }
        let count = picture.pixels().len() as f64;
        for (sum, expected) in [(r, colour.r), (g, colour.g), (b, colour.b)] {
            // Rounding to codes errs by half a code, at most 0.5 % of such light, and evens out over 25,600 pixels.
            assert!((sum / count / expected - 1.0).abs() < 1e-3, "{} {expected}", sum / count);
        }
    }

    #[test]
    fn automatic_exposure_leaves_room_for_the_texture() {
        let colours = [LinearRgb { r: -0.01, g: 0.004, b: 0.02 }, LinearRgb { r: 0.001, g: 0.001, b: 0.001 }];
        let factor = automatic_exposure(&colours);
        let LinearRgb { r, g, b } = colours[0].into_gamut();
        assert!((factor * r.max(g).max(b) - 0.8).abs() < 1e-12);
        assert!((automatic_exposure(&[LinearRgb::default()]) - 1.0).abs() < 1e-15, "darkness stays");
    }
}
