//! A sheet that shows the reference and the methods for a scene side by side.

use snowblue_color::{LinearRgb, Srgb8};
use snowblue_render::Exposure;
use snowblue_render::RenderError;
use snowblue_render::film::image_file;
use snowblue_render::raster::{PixelPosition, RasterImage};

use crate::swatch::lettering::{Lettering, TextOrigin};

use super::comparison::Reference;
use super::image::{SIDE, TimedImage, cell_of, cells, film};
use super::method::Method;
use crate::figure::SOFTWARE;

/// An image by a method.
pub(super) struct MethodImage {
    pub(super) method: Method,
    pub(super) image: TimedImage,
}

/// Magnification of the images.
const ZOOM: u32 = 9;
/// Images on the sheet side by side: the reference, and each method.
#[expect(clippy::cast_possible_truncation, reason = "a few")]
const COLUMNS: u32 = 1 + Method::COMPARED.len() as u32;
/// Side of an image on the sheet, and the gap between images, in pixels.
const SHOWN: u32 = SIDE * ZOOM;
const GAP: u32 = 14;
/// Height of the titles, width of the colour scale and of its bar, in pixels.
const HEAD: u32 = 28;
const SCALE: u32 = 100;
const BAR: u32 = 14;
/// Ratio of full colour, in stops.
const FULL_STOPS: f64 = 2.0;
const MARKS: [(f64, &str); 5] = [(4.0, "≥ 4"), (2.0, "2"), (1.0, "1"), (0.5, "1/2"), (0.25, "≤ 1/4")];

const PAPER: Srgb8 = Srgb8 { r: 255, g: 255, b: 255 };
const INK: Srgb8 = Srgb8 { r: 40, g: 44, b: 52 };
/// Cells in which the reference is too dark to compare.
const DARK: Srgb8 = Srgb8 { r: 120, g: 120, b: 120 };

/// The images of a scene above, and their ratios to the reference below, as the bytes of a PNG file.
pub(super) fn png(reference: &Reference, images: &[MethodImage]) -> Result<Vec<u8>, RenderError> {
    let exposure = Exposure::Stops(film(&reference.mean.pixels).display_factor(Exposure::Auto).log2());
    let (width, height) = (COLUMNS * (SHOWN + GAP) + SCALE, HEAD + 2 * SHOWN + GAP);
    let mut page = RasterImage::filled(width, height, PAPER);
    let mut column = |number: u32, title: &str, image: &TimedImage, below: &dyn Fn(usize) -> Srgb8| {
        let (left, lower) = (number * (SHOWN + GAP), HEAD + SHOWN + GAP);
        draw_text(&mut page, (left, HEAD - 10), title, number == 0);
        page.paste(
            &magnified(&image_file::to_raster(&film(&image.pixels), exposure)),
            PixelPosition { x: left, y: HEAD },
        );
        let compared = (0..(SIDE * SIDE) as usize).map(below).collect();
        page.paste(&magnified(&RasterImage::new(SIDE, SIDE, compared)), PixelPosition { x: left, y: lower });
    };
    let shown = |ratios: &[f64], pixel: usize| {
        let cell = cell_of(pixel);
        if reference.lit_cells.contains(&cell) { colour(ratios[cell]) } else { DARK }
    };
    // Noise on the same scale: two standard errors above equality.
    let noise: Vec<f64> = reference.noise.iter().map(|noise| 1.0 + 2.0 * noise).collect();
    column(0, "reference, noise", &reference.mean, &|pixel| shown(&noise, pixel));
    for (number, MethodImage { method, image }) in (1..).zip(images) {
        let light = cells(&image.pixels);
        let ratios: Vec<f64> = light.iter().zip(&reference.cells).map(|(light, truth)| light.y / truth.y).collect();
        column(number, method.name(), image, &|pixel| shown(&ratios, pixel));
    }
    draw_scale(&mut page, (COLUMNS * (SHOWN + GAP), HEAD + SHOWN + GAP));
    image_file::png_bytes(&page, &[("Software", SOFTWARE)])
}

/// The colours of ratios with their values.
fn draw_scale(page: &mut RasterImage, (left, top): (u32, u32)) {
    let stops = |y: u32| FULL_STOPS * (1.0 - 2.0 * (f64::from(y) + 0.5) / f64::from(SHOWN));
    let pixels = (0..SHOWN).flat_map(|y| [colour(stops(y).exp2()); BAR as usize]).collect();
    page.paste(&RasterImage::new(BAR, SHOWN, pixels), PixelPosition { x: left, y: top });
    for (ratio, label) in MARKS {
        let offset = 0.5 * (1.0 - ratio.log2() / FULL_STOPS) * f64::from(SHOWN);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the page")]
        let baseline = (f64::from(top) + offset + 4.5).clamp(f64::from(top) + 10.0, f64::from(top + SHOWN)) as u32;
        draw_text(page, (left + BAR + 5, baseline), label, false);
    }
    draw_text(page, (left, top - 8), "over reference", false);
}

fn draw_text(page: &mut RasterImage, (left, baseline): (u32, u32), text: &str, bold: bool) {
    let style = Lettering { size_px: if bold { 15.0 } else { 14.0 }, bold, colour: INK };
    style.draw(page, TextOrigin { left_px: left as f32, baseline_px: baseline as f32 }, text);
}

/// A picture with each pixel magnified to a square.
fn magnified(picture: &RasterImage) -> RasterImage {
    let source = |x: u32, y: u32| (y / ZOOM * SIDE + x / ZOOM) as usize;
    let pixels = (0..SHOWN).flat_map(|y| (0..SHOWN).map(move |x| (x, y)));
    RasterImage::new(SHOWN, SHOWN, pixels.map(|(x, y)| picture.pixels()[source(x, y)]).collect())
}

/// The colour of a ratio: blue below one, red above.
fn colour(ratio: f64) -> Srgb8 {
    let (less, equal, more) = ([0.02, 0.11, 0.42], [0.92, 0.92, 0.92], [0.45, 0.01, 0.03]);
    let amount = (ratio.max(1e-6).log2() / FULL_STOPS).clamp(-1.0, 1.0);
    let end: [f64; 3] = if amount < 0.0 { less } else { more };
    let [r, g, b] = [0, 1, 2].map(|i| equal[i] + amount.abs().sqrt() * (end[i] - equal[i]));
    Srgb8::encode(LinearRgb { r, g, b })
}
