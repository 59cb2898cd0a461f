//! OpenEXR files of finished images, of this program or another, as the source of a PNG.
//!
//! The colours are the channels `R`, `G` and `B`, or else those of the first layer that has them, such as
//! `ViewLayer.Combined.R`. They are linear, with the primaries and the white of the attribute `chromaticities`, or else
//! of sRGB. Colours for another white than D65 are adapted to D65 by the Bradford transform.

use std::io::Cursor;
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::attribute::Chromaticities;
use exr::meta::header::Header;
use exr::prelude::{AnyChannels, FlatSamples, Layer};
use snowblue_base::files::FileError;
use snowblue_color::{ChromaticAdaptation, Chromaticity, Primaries, RgbSpace, Xyy, Xyz};
use snowblue_geometry::images::read_exr;
use snowblue_scene::film::{ImageSize, PictureSettings};

use crate::error::RenderError;
use crate::film::image_file::{PNG_BYTES, of_exr_text};
use crate::film::resumable_file::settings_if_any;
use crate::film::{Film, Shown};

/// Memory of a pixel beside the channels of the file, in bytes: its colour and contents.
const PIXEL_BYTES: usize = size_of::<Xyz>() + size_of::<Shown>();

/// The content of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct FinishedImage {
    /// The image of the data window.
    pub film: Film,
    /// What this program keeps in the file for a PNG; none in a file of another program.
    pub settings: Option<PictureSettings>,
    /// Whether the file says which pixels show snow.
    pub knows_snow: bool,
    /// The prefix of the names of the colours, such as `ViewLayer.Combined.`.
    pub layer: String,
    /// The metadata, a line for each keyword.
    pub comments: String,
}

impl FinishedImage {
    /// Reads a file.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, has no layer with red, green and blue, a colour is not finite, or its primaries
    /// are not those of an RGB space.
    pub fn read(path: &Path) -> Result<Self, RenderError> {
        let bytes = std::fs::read(path).map_err(|source| FileError::Read { path: path.into(), source })?;
        Self::of(&bytes).map_err(|reason| FileError::Content { path: path.into(), reason }.into())
    }

    /// The memory that reading a file and writing a PNG take, in bytes.
    ///
    /// # Errors
    ///
    /// When the header cannot be read.
    pub fn memory_bytes(path: &Path) -> Result<u64, RenderError> {
        let meta = MetaData::read_from_file(path, false).map_err(|error| match error {
            exr::error::Error::Io(source) => FileError::Read { path: path.into(), source },
            error => FileError::Content { path: path.into(), reason: format!("not a readable EXR file: {error}") },
        })?;
        let of_part = |header: &Header| {
            let samples: usize =
                header.channels.list.iter().map(|channel| channel.sample_type.bytes_per_sample()).sum();
            header.layer_size.area() as u64 * (samples + PIXEL_BYTES + PNG_BYTES) as u64
        };
        Ok(meta.headers.iter().map(of_part).sum())
    }

    fn of(bytes: &[u8]) -> Result<Self, String> {
        let image = read_exr(bytes, |samples| samples + PIXEL_BYTES)?;
        let unreadable = |error: exr::error::Error| format!("not a readable EXR file: {error}");
        let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(unreadable)?;
        let found = image.layer_data.iter().zip(&meta.headers).find_map(|(layer, header)| {
            let prefix = rgb_prefix(layer)?;
            Some((layer, header, prefix))
        });
        let (layer, header, prefix) = found.ok_or_else(|| {
            let names: Vec<String> = image.layer_data.iter().flat_map(names).collect();
            format!("no layer has the channels R, G and B; the channels are {}", names.join(", "))
        })?;
        let values = |name: &str| {
            let channel = layer.channel_data.list.iter().find(|channel| channel.name == *name)?;
            Some(channel.sample_data.values_as_f32().collect::<Vec<f32>>())
        };
        let colours = ["R", "G", "B"].map(|name| values(&format!("{prefix}{name}")).unwrap_or_default());
        let size = |side: usize| u32::try_from(side).map_err(|_| "the image is too large".to_owned());
        let image_size = ImageSize { width: size(layer.size.width())?, height: size(layer.size.height())? };
        let to_xyz = converter(image.attributes.chromaticities)?;
        let mut pixels = Vec::with_capacity(image_size.pixel_count());
        for ((&r, &g), &b) in colours[0].iter().zip(&colours[1]).zip(&colours[2]) {
            if !(r + g + b).is_finite() {
                let (column, row) = (pixels.len() % layer.size.width(), pixels.len() / layer.size.width());
                return Err(format!("pixel {column},{row} is {r}, {g}, {b}, but must be finite"));
            }
            pixels.push(to_xyz([r.into(), g.into(), b.into()]));
        }
        if pixels.len() != image_size.pixel_count() {
            return Err(format!("the channel {prefix}R, {prefix}G or {prefix}B has fewer pixels than the image"));
        }
        let mut film = Film::new(image_size, pixels);
        let [snow, emitter] = ["snow", "emitter"].map(values);
        let knows_snow = snow.is_some();
        if knows_snow || emitter.is_some() {
            let at = |values: &Option<Vec<f32>>, pixel| values.as_ref().and_then(|all| all.get(pixel)).copied();
            let shown = |pixel| Shown {
                snow: at(&snow, pixel).unwrap_or(0.0),
                emitter: at(&emitter, pixel).is_some_and(|fraction| fraction > 0.0),
            };
            film = film.with_shown((0..image_size.pixel_count()).map(shown).collect());
        }
        let comments = header.own_attributes.comments.as_ref().map(of_exr_text).unwrap_or_default();
        Ok(Self { film, settings: settings_if_any(header)?, knows_snow, layer: prefix, comments })
    }
}

fn names(layer: &Layer<AnyChannels<FlatSamples>>) -> Vec<String> {
    layer.channel_data.list.iter().map(|channel| channel.name.to_string()).collect()
}

/// The part of the names before R, G and B: nothing, or else the first that the three have in common.
fn rgb_prefix(layer: &Layer<AnyChannels<FlatSamples>>) -> Option<String> {
    let names = names(layer);
    let has_all = |prefix: &str| ["R", "G", "B"].iter().all(|one| names.contains(&format!("{prefix}{one}")));
    let of_layers = names.iter().filter_map(|name| name.strip_suffix('R').filter(|prefix| prefix.ends_with('.')));
    std::iter::once("").chain(of_layers).find(|prefix| has_all(prefix)).map(str::to_owned)
}

/// From linear colours with some primaries and white to tristimulus values for the white of sRGB.
fn converter(chromaticities: Option<Chromaticities>) -> Result<impl Fn([f64; 3]) -> Xyz, String> {
    let srgb = (RgbSpace::Srgb.primaries(), RgbSpace::Srgb.white().chromaticity());
    let (primaries, white) = chromaticities.map_or(srgb, |Chromaticities { red, green, blue, white }| {
        let [red, green, blue, white] =
            [red, green, blue, white].map(|at| Chromaticity { x: at.x().into(), y: at.y().into() });
        (Primaries { red, green, blue }, white)
    });
    let from_white = Xyy { chromaticity: white, luminance: 1.0 }.xyz();
    let [red, green, blue] = primaries.units(white).ok_or_else(|| {
        let at = |Chromaticity { x, y }| format!("{x:.4} {y:.4}");
        let Primaries { red, green, blue } = primaries;
        let listed = [red, green, blue, white].map(at).join(", ");
        format!("the attribute chromaticities is {listed}, but must be three primaries around a white")
    })?;
    let adaptation = ChromaticAdaptation { from_white, to_white: RgbSpace::Srgb.white() };
    Ok(move |[r, g, b]: [f64; 3]| adaptation.apply(red * r + green * g + blue * b))
}
