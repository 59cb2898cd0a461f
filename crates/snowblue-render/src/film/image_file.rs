//! Pictures as files: PNG to look at, OpenEXR to work with. A picture is there whole or not at all.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels, Text, WritableImage};
use snowblue_color::{LinearRgb, Srgb8, Xyz};
use snowblue_database::file::write_whole;

use crate::error::RenderError;
use crate::film::Film;
use crate::film::exposure::Exposure;
use crate::geometry::ray::narrow;
use crate::images::raster::RasterImage;

/// Words that are stored with a picture: pairs of keyword and text, such as what made it and with which seed.
pub type Notes<'a> = [(&'a str, &'a str)];

/// Writes an 8-bit sRGB picture: radiance times the exposure, colours brought into the gamut.
///
/// # Errors
///
/// When the picture cannot be encoded or stored.
pub fn write_png(film: &Film, exposure: Exposure, notes: &Notes, path: &Path) -> Result<(), RenderError> {
    write_picture(&picture(film, exposure), notes, path)
}

/// A film as 8-bit sRGB: radiance times the exposure, colours brought into the gamut.
pub fn picture(film: &Film, exposure: Exposure) -> RasterImage {
    let factor = film.display_factor(exposure);
    let shown = |xyz: &Xyz| Srgb8::encode(LinearRgb::from_xyz(*xyz * factor).displayable());
    RasterImage::new(film.width(), film.height(), film.pixels().iter().map(shown).collect())
}

/// Writes a picture as PNG.
///
/// # Errors
///
/// When the picture cannot be encoded or stored.
pub fn write_picture(picture: &RasterImage, notes: &Notes, path: &Path) -> Result<(), RenderError> {
    store(path, png_bytes(picture, notes).map_err(|error| error.to_string()))
}

/// A picture as the bytes of a PNG file.
///
/// # Errors
///
/// When the picture is empty, or a keyword of the notes is longer than 79 letters.
pub fn png_bytes(picture: &RasterImage, notes: &Notes) -> Result<Vec<u8>, RenderError> {
    let bytes: Vec<u8> = picture.pixels().iter().flat_map(|colour| [colour.r, colour.g, colour.b]).collect();
    let encode = || -> Result<Vec<u8>, png::EncodingError> {
        let mut content = Vec::new();
        let mut encoder = png::Encoder::new(&mut content, picture.width(), picture.height());
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
        for (keyword, text) in notes {
            encoder.add_itxt_chunk((*keyword).into(), (*text).into())?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&bytes)?;
        writer.finish()?;
        Ok(content)
    };
    encode().map_err(|error| RenderError::EncodeImage(error.to_string()))
}

/// Writes linear RGB with sRGB primaries in 32-bit floats: radiance as it is, without exposure, and with channels below
/// 0 where a colour lies outside the gamut. 1 is the luminance of 1 W m⁻² sr⁻¹ of equal-energy light (see
/// [`film`](crate::film)).
///
/// # Errors
///
/// When the picture cannot be encoded or stored.
pub fn write_exr(film: &Film, notes: &Notes, path: &Path) -> Result<(), RenderError> {
    let (width, height) = (film.width() as usize, film.height() as usize);
    let channels = SpecificChannels::rgb(|place: exr::math::Vec2<usize>| {
        let LinearRgb { r, g, b } = LinearRgb::from_xyz(film.pixels()[place.y() * width + place.x()]);
        (narrow(r), narrow(g), narrow(b))
    });
    let layer = Layer::new((width, height), attributes(notes), Encoding::SMALL_LOSSLESS, channels);
    let mut content = Cursor::new(Vec::new());
    let written = Image::from_layer(layer).write().to_buffered(&mut content);
    store(path, written.map(|()| content.into_inner()).map_err(|error| error.to_string()))
}

/// What is said of an OpenEXR picture beside its pixels.
pub(crate) fn attributes(notes: &Notes) -> LayerAttributes {
    let lines: Vec<String> = notes.iter().map(|(keyword, text)| format!("{keyword}: {text}")).collect();
    LayerAttributes { comments: (!lines.is_empty()).then(|| exr_text(&lines.join("\n"))), ..LayerAttributes::default() }
}

/// A text as OpenEXR stores it: bytes, in which readers expect UTF-8.
pub(crate) fn exr_text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

/// Puts a complete file in its place, or says why not.
pub(crate) fn store(path: &Path, content: Result<Vec<u8>, String>) -> Result<(), RenderError> {
    let failed = |reason: String| RenderError::WriteImage { path: path.into(), reason };
    let content = content.map_err(failed)?;
    write_whole(path, |beside| std::fs::write(beside, content)).map_err(|error| failed(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film() -> Film {
        let blue = LinearRgb { r: -0.1, g: 0.2, b: 0.5 }.xyz();
        let white = LinearRgb { r: 1.0, g: 1.0, b: 1.0 }.xyz();
        Film::new(2, 2, vec![Xyz::default(), white, blue, white * 0.25])
    }

    #[test]
    fn exr_keeps_light_as_it_is() {
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
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside");
    }

    #[test]
    fn png_is_encoded_exposed_and_in_gamut() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("look.png");
        write_png(&film(), Exposure::Stops(1.0), &[("Software", "snowblue")], &path).unwrap();
        let decoder = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(&pixels[..6], [0, 0, 0, 255, 255, 255]);
        // Linear 0.25, one stop up, is 0.5: code 188 (IEC 61966-2-1).
        assert_eq!(&pixels[9..], [188, 188, 188]);
        // Twice the blue, (−0.2, 0.4, 1.0), loses chroma until red is 0.
        assert!(pixels[6] == 0 && pixels[7] > 130 && pixels[8] > pixels[7] && pixels[8] < 255, "{pixels:?}");
    }

    #[test]
    fn what_cannot_be_stored_is_said_and_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("missing").join("look.png");
        let message = write_png(&film(), Exposure::Auto, &[], &path).unwrap_err().to_string();
        assert!(message.contains("look.png"), "{message}");
        let taken = folder.path().join("taken.png");
        std::fs::create_dir(&taken).unwrap();
        assert!(write_png(&film(), Exposure::Auto, &[], &taken).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "only the folder itself");
    }
}
