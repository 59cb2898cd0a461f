//! Image files: PNG for display, OpenEXR for further processing. A file is written completely or not at all.
//!
//! **From the light of an image to displayable colours.** A tone curve does not commute with the mean over a pixel.
//! Where snow many times as bright as white covers a tenth of a black pixel, the mean is still about white, and the
//! edge is jagged. So the curve applies separately to the snow and to the rest of such a pixel. The fraction c of
//! snow is known. The light D of the rest is the mean over the pixels without snow among the eight neighbours. The
//! light S of the snow follows from the mean c S + (1 − c) D, and
//!
//! > c T(S) + (1 − c) T(D)
//!
//! is shown. Pixels with only snow or without snow do not change. With `filmic` and `none`, displayable colours no
//! brighter than the straight part of the curve do not change either; `agx` has no straight part.

use std::io::{Cursor, Write as _};
use std::path::Path;

use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, Text, WritableImage};
use rayon::prelude::*;
use snowblue_base::atomic_file::write_atomically;
use snowblue_base::narrow;
use snowblue_color::{LinearRgb, Srgb8, ToneCurve, Xyz};
use snowblue_scene::film::{Development, ImageSize};

use crate::error::RenderError;
use crate::film::Film;
use crate::raster::RasterImage;

/// Memory of a pixel while a PNG is written, in bytes: its colour and what it shows, its brightness for the exposure,
/// and the bytes before and after encoding.
pub const PNG_BYTES: usize = 44;

/// Texts that are stored with an image: pairs of keyword and text, such as the program and the seed.
pub type Metadata<'a> = [(&'a str, &'a str)];

/// Writes an image as 8-bit sRGB: radiance times the exposure, by a tone curve, with out-of-gamut colours mapped into
/// the gamut. An exposure alone has no tone curve.
///
/// # Errors
///
/// When the image cannot be encoded or written.
pub fn write_png(
    film: &Film,
    development: impl Into<Development>,
    metadata: &Metadata,
    path: &Path,
) -> Result<(), RenderError> {
    write_raster_png(&to_raster(film, development), metadata, path)
}

/// Converts an image to the 8-bit sRGB of a PNG.
pub fn to_raster(film: &Film, development: impl Into<Development>) -> RasterImage {
    let ImageSize { width, height } = film.size();
    RasterImage::new(width, height, displayed(film, development.into()))
}

/// Writes an 8-bit image as PNG.
///
/// # Errors
///
/// When the image cannot be encoded or written.
pub fn write_raster_png(image: &RasterImage, metadata: &Metadata, path: &Path) -> Result<(), RenderError> {
    write_file(path, png_bytes(image, metadata).map_err(|error| error.to_string()))
}

/// The bytes of a PNG file with an 8-bit image.
///
/// # Errors
///
/// When the image is empty, or a keyword of the metadata has more than 79 letters.
pub fn png_bytes(image: &RasterImage, metadata: &Metadata) -> Result<Vec<u8>, RenderError> {
    let encode = || -> Result<Vec<u8>, png::EncodingError> {
        let mut content = Vec::new();
        let mut encoder = png::Encoder::new(&mut content, image.width(), image.height());
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
        for (keyword, text) in metadata {
            encoder.add_itxt_chunk((*keyword).into(), (*text).into())?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&image.bytes())?;
        writer.finish()?;
        Ok(content)
    };
    encode().map_err(|error| RenderError::EncodeImage(error.to_string()))
}

/// Writes linear RGB with sRGB primaries as 32-bit floats: radiance without exposure. Channels are negative where a
/// colour lies outside the gamut. 1 is the luminance of 1 W m⁻² sr⁻¹ of equal-energy light (see [`film`](crate::film)).
///
/// # Errors
///
/// When the image cannot be encoded or written.
pub fn write_exr(film: &Film, metadata: &Metadata, path: &Path) -> Result<(), RenderError> {
    let rgb = |xyz: &Xyz| {
        let LinearRgb { r, g, b } = LinearRgb::from_xyz(*xyz);
        [narrow(r), narrow(g), narrow(b)]
    };
    let rows: Vec<Vec<[f32; 3]>> =
        film.pixels().chunks_exact(film.size().width as usize).map(|row| row.iter().map(rgb).collect()).collect();
    write_numbers_exr(&rows, metadata, path)
}

/// Writes rows of three numbers, the first row at the top, as the channels R, G and B of 32-bit floats.
///
/// # Errors
///
/// When the image cannot be encoded or written.
pub fn write_numbers_exr(rows: &[Vec<[f32; 3]>], metadata: &Metadata, path: &Path) -> Result<(), RenderError> {
    let size = (rows.first().map_or(0, Vec::len), rows.len());
    let channels = SpecificChannels::rgb(|place: exr::math::Vec2<usize>| {
        let [r, g, b] = rows[place.y()][place.x()];
        (r, g, b)
    });
    let layer = Layer::new(size, attributes(metadata), Encoding::SMALL_LOSSLESS, channels);
    let mut content = Cursor::new(Vec::new());
    let result = Image::from_layer(layer).write().to_buffered(&mut content);
    write_file(path, result.map(|()| content.into_inner()).map_err(|error| error.to_string()))
}

/// The metadata as attributes of an OpenEXR layer.
pub(crate) fn attributes(metadata: &Metadata) -> LayerAttributes {
    let lines: Vec<String> = metadata.iter().map(|(keyword, text)| format!("{keyword}: {text}")).collect();
    LayerAttributes { comments: (!lines.is_empty()).then(|| exr_text(&lines.join("\n"))), ..LayerAttributes::default() }
}

/// A text for OpenEXR, which stores bytes. Readers expect UTF-8.
pub(crate) fn exr_text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

/// A text of OpenEXR that [`exr_text`] made.
pub(crate) fn of_exr_text(text: &Text) -> String {
    String::from_utf8_lossy(text.bytes()).into_owned()
}

/// The text of a keyword in comments that [`attributes`] made.
pub(crate) fn note_of<'a>(comments: &'a str, keyword: &str) -> Option<&'a str> {
    comments.lines().find_map(|line| line.strip_prefix(keyword)?.strip_prefix(": "))
}

/// Writes a complete file, or nothing if encoding or writing fails.
fn write_file(path: &Path, content: Result<Vec<u8>, String>) -> Result<(), RenderError> {
    let error = |reason: String| RenderError::WriteImage { path: path.into(), reason };
    let content = content.map_err(error)?;
    write_atomically(path, |file| file.write_all(&content)).map_err(|source| error(source.to_string()))
}

/// The encoded colours of an image, row by row from the upper left.
pub(crate) fn displayed(film: &Film, development: Development) -> Vec<Srgb8> {
    let factor = film.display_factor(development);
    let edges = Edges { film, factor, tone: development.tone };
    (0..film.pixels().len()).into_par_iter().map(|pixel| Srgb8::encode(edges.displayed(pixel))).collect()
}

/// The tone curve on an image.
struct Edges<'film> {
    film: &'film Film,
    factor: f64,
    tone: ToneCurve,
}

impl Edges<'_> {
    fn exposed(&self, pixel: usize) -> LinearRgb {
        LinearRgb::from_xyz(self.film.pixels()[pixel] * self.factor)
    }

    fn displayed(&self, pixel: usize) -> LinearRgb {
        let (mean, snow) = (self.exposed(pixel), self.film.snow_fraction(pixel));
        let is_edge = snow > 0.0 && snow < 1.0;
        is_edge.then(|| self.displayed_edge(pixel, mean, snow)).flatten().unwrap_or_else(|| self.tone.displayed(mean))
    }

    /// The displayed colour of a pixel that snow covers in part; none if no neighbour shows the rest.
    fn displayed_edge(&self, pixel: usize, mean: LinearRgb, snow: f64) -> Option<LinearRgb> {
        let (mut rest, mut count) = (LinearRgb::default(), 0_u8);
        // A lamp beside the edge is no part of the pixel.
        let is_rest = |neighbour: &usize| {
            let shown = self.film.shown(*neighbour);
            shown.snow <= 0.0 && (!shown.emitter || self.film.shown(pixel).emitter)
        };
        for neighbour in self.neighbours(pixel).filter(is_rest) {
            rest += self.exposed(neighbour);
            count += 1;
        }
        let rest = (count > 0).then(|| rest * f64::from(count).recip())?;
        let mut of_snow = mean * snow.recip();
        of_snow += rest * ((snow - 1.0) / snow);
        let mut sum = (of_snow.luminance() > 0.0).then(|| self.tone.displayed(of_snow) * snow)?;
        sum += self.tone.displayed(rest) * (1.0 - snow);
        Some(sum)
    }

    /// The pixels around a pixel.
    fn neighbours(&self, pixel: usize) -> impl Iterator<Item = usize> {
        let [width, height] = [self.film.size().width, self.film.size().height].map(|side| side as usize);
        let (column, row) = (pixel % width, pixel / width);
        let around = |place: usize, end: usize| place.saturating_sub(1)..(place + 2).min(end);
        around(row, height)
            .flat_map(move |y| around(column, width).map(move |x| y * width + x))
            .filter(move |neighbour| *neighbour != pixel)
    }
}

#[cfg(test)]
mod tests {
    use snowblue_scene::film::Exposure;

    use super::*;
    use crate::film::Shown;

    fn film() -> Film {
        let blue = LinearRgb { r: -0.1, g: 0.2, b: 0.5 }.xyz();
        let white = LinearRgb { r: 1.0, g: 1.0, b: 1.0 }.xyz();
        Film::new(ImageSize { width: 2, height: 2 }, vec![Xyz::default(), white, blue, white * 0.25])
    }

    #[test]
    fn exr_stores_radiance_and_metadata() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("light.exr");
        write_exr(&film(), &[("seed", "7"), ("thickness", "30 cm ± 1 µm")], &path).unwrap();
        let image = exr::prelude::read_first_rgba_layer_from_file(
            &path,
            |size, _| vec![vec![[0.0f32; 3]; size.width()]; size.height()],
            |rows, place, (r, g, b, _): (f32, f32, f32, f32)| rows[place.y()][place.x()] = [r, g, b],
        )
        .unwrap();
        let rows = &image.layer_data.channel_data.pixels;
        for (read, written) in rows[1][0].iter().zip([-0.1, 0.2, 0.5]) {
            assert!((read - written).abs() < 1e-6, "{rows:?}");
        }
        let comments = image.layer_data.attributes.comments.unwrap();
        assert_eq!(comments.as_slice(), "seed: 7\nthickness: 30 cm ± 1 µm".as_bytes());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file remains");
    }

    #[test]
    fn png_applies_exposure_and_maps_into_the_gamut() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.png");
        write_png(&film(), Exposure::Stops(1.0), &[("Software", "snowblue")], &path).unwrap();
        let decoder = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(&pixels[..6], [0, 0, 0, 255, 255, 255]);
        // Linear 0.25 at +1 stop is 0.5, code 188 (IEC 61966-2-1).
        assert_eq!(&pixels[9..], [188, 188, 188]);
        // The blue pixel at +1 stop is (−0.2, 0.4, 1.0). Its chroma is reduced until red is 0.
        assert!(pixels[6] == 0 && pixels[7] > 130 && pixels[8] > pixels[7] && pixels[8] < 255, "{pixels:?}");
    }

    #[test]
    fn a_tone_curve_compresses_what_is_brighter_than_white() {
        let development = |tone| Development { exposure: Exposure::Stops(2.0), tone };
        let codes =
            |tone| to_raster(&film(), development(tone)).pixels().iter().map(|pixel| pixel.g).collect::<Vec<_>>();
        let [none, filmic, agx] = [ToneCurve::None, ToneCurve::Filmic, ToneCurve::Agx].map(codes);
        // Light of 4 and 1 is white without a curve; by the shoulder it is 1 − 0.04/3.4 = 0.988 and 0.9.
        assert_eq!((none[1], none[3], filmic[1], filmic[3]), (255, 255, 254, 243));
        assert!(agx[3] < agx[1] && agx[1] < 243, "{agx:?}");
        assert_eq!([none[0], filmic[0], agx[0]], [0; 3]);
    }

    #[test]
    fn failed_writes_leave_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("missing").join("image.png");
        let message = write_png(&film(), Exposure::Auto, &[], &path).unwrap_err().to_string();
        assert!(message.contains("image.png"), "{message}");
        let directory = folder.path().join("directory.png");
        std::fs::create_dir(&directory).unwrap();
        assert!(write_png(&film(), Exposure::Auto, &[], &directory).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "only the directory");
    }

    /// A row of pixels, given by their light and their fraction of snow.
    fn codes(pixels: &[(f64, f32)], tone: ToneCurve) -> Vec<u8> {
        let grey = |level: f64| LinearRgb { r: level, g: level, b: level }.xyz();
        let light: Vec<Xyz> = pixels.iter().map(|(level, _)| grey(*level)).collect();
        let shown = pixels.iter().map(|(_, snow)| Shown { snow: *snow, emitter: false }).collect();
        let size = ImageSize { width: u32::try_from(pixels.len()).unwrap(), height: 1 };
        let film = Film::new(size, light).with_shown(shown);
        displayed(&film, Development { exposure: Exposure::Stops(0.0), tone }).iter().map(|pixel| pixel.g).collect()
    }

    fn code(level: f64) -> u8 {
        Srgb8::encode(LinearRgb { r: level, g: level, b: level }).g
    }

    /// Snow of light 8 that covers a quarter of a black pixel.
    #[test]
    fn an_edge_of_bright_snow_is_as_bright_as_its_share_of_the_pixel() {
        for tone in ToneCurve::ALL {
            let shown = tone.displayed(LinearRgb { r: 8.0, g: 8.0, b: 8.0 }).luminance();
            let found = codes(&[(0.0, 0.0), (2.0, 0.25), (8.0, 1.0)], tone);
            assert_eq!(found, [0, code(0.25 * shown), code(shown)], "{tone}");
            let found = codes(&[(0.4, 0.0), (0.75 * 0.4 + 2.0, 0.25), (8.0, 1.0)], tone);
            let rest = tone.displayed(LinearRgb { r: 0.4, g: 0.4, b: 0.4 }).luminance();
            assert!(found[1].abs_diff(code(0.25 * shown + 0.75 * rest)) <= 1, "{tone}: {found:?}");
        }
    }

    #[test]
    fn all_else_stays_as_it_is() {
        // Within the straight part of the curve, inside and outside of snow, and where snow covers the neighbours too.
        let pixels = [(0.1, 0.0), (0.3, 0.4), (0.6, 1.0), (1.4, 0.5), (3.0, 1.0), (2.0, 0.0)];
        for tone in [ToneCurve::None, ToneCurve::Filmic] {
            let found = codes(&pixels[..4], tone);
            let alone = pixels[..4].iter().map(|pixel| codes(&[*pixel], tone)[0]).collect::<Vec<_>>();
            assert_eq!(found, alone, "{tone}");
        }
        // The neighbour is brighter than the mean, so no light of the snow explains the mean.
        assert_eq!(codes(&[(2.0, 0.0), (0.5, 0.5)], ToneCurve::None)[1], code(0.5));
    }
}
