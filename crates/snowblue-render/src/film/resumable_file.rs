//! OpenEXR files of images, with the exact sums that merging and resuming need.
//!
//! Every file has the [`channels`] of its means. The unit of the spectrum is in the attribute `emissiveUnits`.
//!
//! A resumable file has four further unsigned 32-bit channels for each sum (`sums.X.0`, the lowest 32 bits, to
//! `sums.X.3`). Its attributes hold the samples in the sums, the [`Provenance`], the AOVs, the wavelengths and the
//! exposure of a PNG. The data window and the display window give the position of a part in the image.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, IntegerBounds};
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, ReadChannels, ReadLayers, Vec2, WritableImage, read,
};

use crate::error::RenderError;
use crate::film::accumulator::FilmAccumulator;
use crate::film::aov::Aovs;
use crate::film::channels::{Channel, channels};
use crate::film::exposure::Exposure;
use crate::film::image_file::{Metadata, attributes, exr_text, of_exr_text, write_file};
use crate::film::provenance::Provenance;
use crate::film::sample_block::{Coverage, SampleBlock};
use crate::film::window::Window;
use crate::images::raster::ImageSize;
use crate::spectrum::SAMPLES;

const PROVENANCE: &str = "snowblueProvenance";
const COVERAGE: &str = "snowblueSamples";
const AOVS: &str = "snowblueAovs";
const WAVELENGTHS: &str = "snowblueWavelengths";
const EXPOSURE: &str = "snowblueExposure";

/// Channels of 32 bits for a sum.
const WORDS: usize = 4;

/// Data that a resumable file stores beside the sums.
#[derive(Debug, Clone, Copy)]
pub struct ResumeData<'a> {
    /// The inputs that the samples depend on.
    pub provenance: &'a Provenance,
    /// Exposure of a PNG. It may differ between parts of an image.
    pub exposure: Exposure,
}

/// Writes the means of the samples as OpenEXR. With `resume_data` the file is resumable.
///
/// # Errors
///
/// When the image cannot be encoded or written.
pub fn write(
    accumulator: &FilmAccumulator,
    resume_data: Option<ResumeData>,
    metadata: &Metadata,
    path: &Path,
) -> Result<(), RenderError> {
    let mut channels: Vec<AnyChannel<FlatSamples>> = channels(accumulator)
        .into_iter()
        .map(|Channel { name, values }| AnyChannel::new(&*name, FlatSamples::F32(values)))
        .collect();
    let mut attributes = attributes(metadata);
    let window = accumulator.window();
    attributes.layer_position = Vec2(window.columns.start.cast_signed(), window.rows.start.cast_signed());
    let mut insert =
        |name: &str, text: &str| attributes.other.insert(exr_text(name), AttributeValue::Text(exr_text(text)));
    let aovs = accumulator.aovs();
    for (is_needed, name, text) in [
        (aovs.spectrum, "spectralLayoutVersion", "1.0"),
        (aovs.spectrum, "emissiveUnits", "W.m^-2.sr^-1.nm^-1"),
        (aovs.thickness, "thicknessUnits", "m"),
        (aovs.angle, "angleUnits", "deg"),
    ] {
        if is_needed {
            insert(name, text);
        }
    }
    if let Some(ResumeData { provenance, exposure }) = resume_data {
        let wavelengths: Vec<String> = accumulator.wavelengths_nm().iter().map(f64::to_string).collect();
        insert(PROVENANCE, &provenance.to_string());
        insert(COVERAGE, &accumulator.coverage().to_string());
        insert(AOVS, &aovs.to_string());
        insert(WAVELENGTHS, &wavelengths.join(" "));
        insert(EXPOSURE, &exposure.to_string());
        channels.extend(sum_channels(accumulator));
    }
    let layer =
        Layer::new(exr_size(window.size()), attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels.into()));
    let mut image = Image::from_layer(layer);
    image.attributes.display_window = IntegerBounds { position: Vec2(0, 0), size: exr_size(accumulator.image_size()) };
    let mut content = Cursor::new(Vec::new());
    let result = image.write().to_buffered(&mut content);
    drop(image);
    write_file(path, result.map(|()| content.into_inner()).map_err(|error| error.to_string()))
}

fn exr_size(size: ImageSize) -> Vec2<usize> {
    Vec2(size.width as usize, size.height as usize)
}

/// The sums, as channels of 32-bit words.
fn sum_channels(accumulator: &FilmAccumulator) -> impl Iterator<Item = AnyChannel<FlatSamples>> {
    let word = |sum: i128, word: usize| {
        #[expect(clippy::cast_possible_truncation, reason = "one word of four")]
        let bits = (sum >> (32 * word)) as u32;
        bits
    };
    accumulator.aovs().sum_names().into_iter().enumerate().flat_map(move |(offset, name)| {
        (0..WORDS).map(move |number| {
            let values = accumulator.sums_at(offset).map(|sum| word(sum, number)).collect();
            AnyChannel::new(&*word_channel_name(&name, number), FlatSamples::U32(values))
        })
    })
}

fn word_channel_name(sum_name: &str, word: usize) -> String {
    format!("sums.{sum_name}.{word}")
}

/// A resumable file without its sums.
#[derive(Debug, Clone, PartialEq)]
pub struct ResumableImage {
    path: PathBuf,
    /// The inputs that the samples depend on.
    pub provenance: Provenance,
    /// Exposure of a PNG.
    pub exposure: Exposure,
    /// The samples in the sums.
    pub coverage: Coverage,
    /// The values that are summed beside colours.
    pub aovs: Aovs,
    /// Size of the whole image.
    pub image_size: ImageSize,
    /// The pixels that have sums.
    pub window: Window,
    /// The wavelengths of the spectrum, in nm.
    pub wavelengths_nm: [f64; SAMPLES],
}

impl ResumableImage {
    /// Reads the header of a resumable file.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, or has no sums that this version can read.
    pub fn open(path: &Path) -> Result<Self, RenderError> {
        let invalid = |reason: &str| RenderError::ReadImage { path: path.into(), reason: reason.to_owned() };
        let meta = MetaData::read_from_file(path, false).map_err(|error| match error {
            exr::error::Error::Io(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
                RenderError::ReadFile { path: path.into(), source }
            }
            error => invalid(&format!("not a readable EXR file: {error}")),
        })?;
        let header = meta.headers.first().ok_or_else(|| invalid("the EXR file has no image"))?;
        if !header.channels.list.iter().any(|channel| channel.name == *word_channel_name("X", 0)) {
            return Err(invalid("the image has no sums, so it cannot be resumed or merged (render with --keep-sums)"));
        }
        if text(header, PROVENANCE).is_none() {
            return Err(invalid("another version of snowblue wrote the image; this one cannot resume or merge it"));
        }
        Self::from_header(path, header).ok_or_else(|| invalid("the attributes of the sums are damaged"))
    }

    fn from_header(path: &Path, header: &Header) -> Option<Self> {
        let display = header.shared_attributes.display_window;
        let image_size =
            ImageSize { width: u32::try_from(display.size.0).ok()?, height: u32::try_from(display.size.1).ok()? };
        let position = header.own_attributes.layer_position;
        let range = |start: i32, length: usize| {
            let start = u32::try_from(start).ok()?;
            Some(start..start.checked_add(u32::try_from(length).ok()?)?)
        };
        let window =
            Window { columns: range(position.0, header.layer_size.0)?, rows: range(position.1, header.layer_size.1)? };
        let coverage: Coverage = text(header, COVERAGE)?.parse().ok()?;
        let is_within = |block: &SampleBlock| window.contains(&block.window());
        let wavelengths: Option<Vec<f64>> =
            text(header, WAVELENGTHS)?.split_whitespace().map(|nm| nm.parse().ok()).collect();
        let is_consistent = Window::of_image(image_size).contains(&window) && coverage.blocks().iter().all(is_within);
        is_consistent.then_some(Self {
            path: path.into(),
            provenance: Provenance::parse(&text(header, PROVENANCE)?),
            exposure: text(header, EXPOSURE)?.parse().ok()?,
            coverage,
            aovs: text(header, AOVS)?.parse().ok()?,
            image_size,
            window,
            wavelengths_nm: wavelengths?.try_into().ok()?,
        })
    }

    /// Reads the sums.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, or has changed since it was opened.
    pub fn read_sums(&self) -> Result<FilmAccumulator, RenderError> {
        let invalid = |reason: String| RenderError::ReadImage { path: self.path.clone(), reason };
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_file(&self.path)
            .map_err(|error| invalid(format!("not a readable EXR file: {error}")))?;
        let mut accumulator = FilmAccumulator::new(self.image_size, &self.window, self.aovs, &self.wavelengths_nm);
        let channels = &image.layer_data.channel_data.list;
        for (offset, sum_name) in self.aovs.sum_names().into_iter().enumerate() {
            let mut sums = vec![0u128; self.window.size().pixel_count()];
            for word in 0..WORDS {
                let name = word_channel_name(&sum_name, word);
                let channel = channels.iter().find(|channel| channel.name == *name);
                let Some(FlatSamples::U32(values)) = channel.map(|channel| &channel.sample_data) else {
                    return Err(invalid(format!("the channel {name} is missing")));
                };
                sums.iter_mut().zip(values).for_each(|(sum, bits)| *sum |= u128::from(*bits) << (32 * word));
            }
            accumulator.set_sums_at(offset, sums.into_iter().map(u128::cast_signed));
        }
        self.coverage.blocks().iter().for_each(|block| accumulator.record(block.clone()));
        Ok(accumulator)
    }
}

/// A text attribute of a layer.
fn text(header: &Header, name: &str) -> Option<String> {
    match header.own_attributes.other.get(&exr_text(name)) {
        Some(AttributeValue::Text(text)) => Some(of_exr_text(text)),
        _ => None,
    }
}
