//! How the ways through snow and the reference are shown side by side.

use snowblue_color::{LinearRgb, Srgb8};
use snowblue_render::film::exposure::Exposure;
use snowblue_render::film::image_file;
use snowblue_render::images::raster::RasterImage;
use snowblue_render::swatch::lettering::Lettering;

use super::truth::{MODES, SIDE, Timed, Truth, cell_of, cells, film};
use crate::failure::Failure;

/// Pixels of the page that one pixel of a picture takes along each side.
const ZOOM: u32 = 9;
/// A picture's side on the page, and what lies between pictures.
const SHOWN: u32 = SIDE * ZOOM;
const GAP: u32 = 14;
/// Above the pictures, for their titles, and to their right, for the scale of colours.
const HEAD: u32 = 28;
const SCALE: u32 = 100;
const BAR: u32 = 14;
/// Stops at which the colours of ratios are full.
const FULL_STOPS: f64 = 2.0;
const MARKS: [(f64, &str); 5] = [(4.0, "≥ 4"), (2.0, "2"), (1.0, "1"), (0.5, "1/2"), (0.25, "≤ 1/4")];

const PAPER: Srgb8 = Srgb8 { r: 255, g: 255, b: 255 };
const INK: Srgb8 = Srgb8 { r: 40, g: 44, b: 52 };
/// Where the reference is too dark to compare.
const DARK: Srgb8 = Srgb8 { r: 120, g: 120, b: 120 };

/// The pictures of a scene above, and below how far each is from the reference, as a PNG.
pub(super) fn drawn(truth: &Truth, films: &[Timed]) -> Result<Vec<u8>, Failure> {
    let exposure = Exposure::Stops(film(&truth.mean.pixels).display_factor(Exposure::Auto).log2());
    let (width, height) = (5 * (SHOWN + GAP) + SCALE, HEAD + 2 * SHOWN + GAP);
    let mut page = RasterImage::plain(width, height, PAPER);
    let mut column = |number: u32, title: &str, pixels: &Timed, below: &dyn Fn(usize) -> Srgb8| {
        let (left, lower) = (number * (SHOWN + GAP), HEAD + SHOWN + GAP);
        words(&mut page, (left, HEAD - 10), title, number == 0);
        page.lay(&enlarged(&image_file::picture(&film(&pixels.pixels), exposure)), (left, HEAD));
        let compared = (0..(SIDE * SIDE) as usize).map(below).collect();
        page.lay(&enlarged(&RasterImage::new(SIDE, SIDE, compared)), (left, lower));
    };
    let shown = |ratios: &[f64], pixel: usize| {
        let cell = cell_of(pixel);
        if truth.lit.contains(&cell) { colour(ratios[cell]) } else { DARK }
    };
    // Noise on the same scale: two standard errors above equality.
    let noise: Vec<f64> = truth.noise.iter().map(|noise| 1.0 + 2.0 * noise).collect();
    column(0, "reference, noise", &truth.mean, &|pixel| shown(&noise, pixel));
    for (number, (found, (mode, _))) in (1..).zip(films.iter().zip(MODES)) {
        let light = cells(&found.pixels);
        let ratios: Vec<f64> = light.iter().zip(&truth.cells).map(|(light, truth)| light.y / truth.y).collect();
        column(number, mode, found, &|pixel| shown(&ratios, pixel));
    }
    scale(&mut page, (5 * (SHOWN + GAP), HEAD + SHOWN + GAP));
    let notes = [("Software", concat!("snowblue ", env!("CARGO_PKG_VERSION")))];
    image_file::png_bytes(&page, &notes).map_err(Failure::work)
}

/// The colours of ratios, with numbers beside them.
fn scale(page: &mut RasterImage, (left, top): (u32, u32)) {
    let stops = |y: u32| FULL_STOPS * (1.0 - 2.0 * (f64::from(y) + 0.5) / f64::from(SHOWN));
    let pixels = (0..SHOWN).flat_map(|y| [colour(stops(y).exp2()); BAR as usize]).collect();
    page.lay(&RasterImage::new(BAR, SHOWN, pixels), (left, top));
    for (ratio, label) in MARKS {
        let place = 0.5 * (1.0 - ratio.log2() / FULL_STOPS) * f64::from(SHOWN);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the page")]
        let baseline = (f64::from(top) + place + 4.5).clamp(f64::from(top) + 10.0, f64::from(top + SHOWN)) as u32;
        words(page, (left + BAR + 5, baseline), label, false);
    }
    words(page, (left, top - 8), "over reference", false);
}

fn words(page: &mut RasterImage, (left, baseline): (u32, u32), words: &str, bold: bool) {
    let style = Lettering { size_px: if bold { 15.0 } else { 14.0 }, bold, colour: INK };
    style.draw(page, (left as f32, baseline as f32), words);
}

/// A picture with each pixel as a square.
fn enlarged(picture: &RasterImage) -> RasterImage {
    let place = |x: u32, y: u32| (y / ZOOM * SIDE + x / ZOOM) as usize;
    let pixels = (0..SHOWN).flat_map(|y| (0..SHOWN).map(move |x| (x, y)));
    RasterImage::new(SHOWN, SHOWN, pixels.map(|(x, y)| picture.pixels()[place(x, y)]).collect())
}

/// Ratios as colours: blue below one, red above.
fn colour(ratio: f64) -> Srgb8 {
    let (less, equal, more) = ([0.02, 0.11, 0.42], [0.92, 0.92, 0.92], [0.45, 0.01, 0.03]);
    let share = (ratio.max(1e-6).log2() / FULL_STOPS).clamp(-1.0, 1.0);
    let end: [f64; 3] = if share < 0.0 { less } else { more };
    let [r, g, b] = [0, 1, 2].map(|i| equal[i] + share.abs().sqrt() * (end[i] - equal[i]));
    Srgb8::encode(LinearRgb { r, g, b })
}
