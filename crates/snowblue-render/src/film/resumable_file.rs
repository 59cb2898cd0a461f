//! OpenEXR files of images, with the exact sums that merging and resuming need.
//!
//! Every file has the [`channels`](crate::film::channels) of its means. The unit of the spectrum is in the attribute
//! `emissiveUnits`.
//!
//! Every file has attributes with the exposure and the tone curve of a later PNG, the light that looks white, and the
//! chromaticity of the light of the sky, if there is a sky.
//!
//! A resumable file has four further unsigned 32-bit channels for each sum (`sums.X.0`, the lowest 32 bits, to
//! `sums.X.3`). Its attributes hold the range of samples, the [`Provenance`] and the AOVs. One more channel
//! (`sums.missing`) has the number of samples that a pixel lacks at the end of the range. The data window and the
//! display window give the position of a part in the image.

use std::fmt::Display;
use std::fs::File;
use std::io::{self, BufRead as _, BufReader, BufWriter, Read as _, Seek as _, SeekFrom, Write as _};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use exr::block::BlockIndex;
use exr::block::reader::ChunksReader as _;
use exr::image::write::channels::{ChannelsWriter, WritableChannels};
use exr::math::RoundingMode;
use exr::meta::MetaData;
use exr::meta::attribute::{
    AttributeValue, ChannelDescription, ChannelList, IntegerBounds, LevelMode, SampleType, Text,
};
use exr::meta::header::Header;
use exr::prelude::{Compression, Encoding, Image, Layer, Vec2, WritableImage as _};
use snowblue_base::atomic_file::write_atomically;
use snowblue_base::files::FileError;
use snowblue_color::exposure::MAX_STOPS;
use snowblue_color::{Chromaticity, Xyy, Xyz};
use snowblue_geometry::images::check_header_expansion;

use crate::error::RenderError;
use crate::film::accumulator::{FilmAccumulator, MatteWord, PixelSums, pixel_bytes};
use crate::film::aov::Aovs;
use crate::film::channels::{Mean, means};
use crate::film::cryptomatte::{self, Matte};
use crate::film::image_file::{Metadata, attributes, exr_text, note_of, of_exr_text};
use crate::film::residual_filter::Filtered;
use crate::film::window::{Window, range_length};
use snowblue_scene::film::white_balance::PictureWhite;
use snowblue_scene::film::{Development, Exposure, ImageSize, PictureSettings};
use snowblue_scene::provenance::Provenance;

const PROVENANCE: &str = "snowblueProvenance";
const SAMPLE_RANGE: &str = "snowblueSamples";
const AOVS: &str = "snowblueAovs";
const EXPOSURE: &str = "snowblueExposure";
const TONE: &str = "snowblueTone";
const WHITE: &str = "snowblueWhite";
/// The chromaticity of the light of the sky, `x y`.
const SKY: &str = "snowblueSky";
/// The place of the local origin, from which positions count, in the scene file: `x y z` in m.
pub(crate) const POSITION_ORIGIN: &str = "positionOrigin";
/// The channel of missing samples.
const MISSING: &str = "sums.missing";

/// Channels of 32 bits for a sum.
const WORDS: usize = 4;

/// Writes the means of the samples as OpenEXR. With the provenance the file is resumable.
///
/// # Errors
///
/// When the image cannot be encoded or written.
pub fn write(
    accumulator: &FilmAccumulator,
    settings: PictureSettings,
    provenance: Option<&Provenance>,
    metadata: &Metadata,
    path: &Path,
) -> Result<(), RenderError> {
    let mut channels: Vec<(String, Content)> =
        means(accumulator).into_iter().map(|(name, mean)| (name, Content::Mean(mean))).collect();
    let mut attributes = attributes(metadata);
    let window = accumulator.window();
    attributes.layer_position = Vec2(window.columns.start.cast_signed(), window.rows.start.cast_signed());
    let mut insert =
        |name: &str, text: &str| attributes.other.insert(exr_text(name), AttributeValue::Text(exr_text(text)));
    let aovs = accumulator.aovs();
    for (name, text) in &accumulator.attributes {
        insert(name, text);
    }
    for (is_needed, name, text) in [
        (aovs.spectrum, "spectralLayoutVersion", "1.0"),
        (aovs.spectrum, "emissiveUnits", "W.m^-2.sr^-1.nm^-1"),
        (aovs.thickness, "thicknessUnits", "m"),
        (aovs.angle, "angleUnits", "deg"),
        (aovs.depth, "depthUnits", "m"),
        (aovs.position, "positionUnits", "m"),
    ] {
        if is_needed {
            insert(name, text);
        }
    }
    let PictureSettings { development, white: PictureWhite { white, sky } } = settings;
    insert(EXPOSURE, &development.exposure.to_string());
    insert(TONE, development.tone.name());
    insert(WHITE, &white.to_string());
    if let Some(Chromaticity { x, y }) = sky.map(Xyz::chromaticity) {
        insert(SKY, &format!("{x} {y}"));
    }
    let mut encoding = Encoding::SMALL_LOSSLESS;
    if let Some(provenance) = provenance {
        // The lower bits of sums are noise. Deflate makes them 10 % smaller than run lengths, in eight times the time,
        // for which an interrupt would have to wait.
        encoding.compression = Compression::RLE;
        insert(PROVENANCE, &provenance.to_string());
        let Range { start, end } = accumulator.samples();
        insert(SAMPLE_RANGE, &format!("{start}:{end}"));
        insert(AOVS, &aovs.to_string());
        channels.extend(sum_channels(aovs));
        for matte in aovs.mattes() {
            let entries = accumulator.most_in_mattes(matte, |counts| counts.entries().len());
            channels.extend((0..entries).flat_map(|entry| matte_channels(matte, entry)));
        }
    }
    let channels = FilmChannels::new(accumulator, channels);
    let mut image = Image::from_layer(Layer::new(exr_size(window.size()), attributes, encoding, channels));
    image.attributes.display_window = IntegerBounds { position: Vec2(0, 0), size: exr_size(accumulator.image_size()) };
    let written = write_atomically(path, |file| {
        image.write().to_buffered(BufWriter::new(&*file)).map_err(|error| match error {
            exr::error::Error::Io(error) => error,
            error => io::Error::other(error),
        })?;
        order_attributes(file)
    });
    written.map_err(|error| RenderError::WriteImage { path: path.into(), reason: error.to_string() })
}

/// Orders the attributes of an image of one part by name. The encoder takes them from a hash map, whose order changes
/// each time.
fn order_attributes(file: &mut File) -> io::Result<()> {
    /// After the magic number and the version.
    const START: SeekFrom = SeekFrom::Start(8);
    file.seek(START)?;
    let mut reader = BufReader::new(&*file);
    let mut attributes = Vec::new();
    loop {
        // Name, type, size and value. An empty name ends the header.
        let mut attribute = Vec::new();
        if reader.read_until(0, &mut attribute)? <= 1 {
            break;
        }
        reader.read_until(0, &mut attribute)?;
        let mut size = [0; 4];
        reader.read_exact(&mut size)?;
        attribute.extend(size);
        reader.by_ref().take(u32::from_le_bytes(size).into()).read_to_end(&mut attribute)?;
        attributes.push(attribute);
    }
    attributes.sort();
    file.seek(START)?;
    file.write_all(&attributes.concat())
}

fn exr_size(size: ImageSize) -> Vec2<usize> {
    Vec2(size.width as usize, size.height as usize)
}

/// Content of a channel of a file for each pixel.
#[derive(Debug, Clone, Copy)]
enum Content {
    Mean(Mean),
    /// 32 bits of the sum at an offset of the layout.
    Word {
        offset: usize,
        word: usize,
    },
    /// The number of samples that a pixel lacks at the end of the range.
    Missing,
    Matte(MatteWord),
}

/// The identifier and the count of an entry of mattes.
fn matte_channels(matte: Matte, entry: usize) -> [(String, Content); 2] {
    let channel = |(value, name)| {
        (
            word_channel_name(&format!("{}.{name}", matte.layer()), entry),
            Content::Matte(MatteWord { matte, entry, value }),
        )
    };
    [(0, "id"), (1, "samples")].map(channel)
}

/// The words of all sums, and the missing samples.
fn sum_channels(aovs: Aovs) -> impl Iterator<Item = (String, Content)> {
    let words = aovs.sum_names().into_iter().enumerate().flat_map(move |(offset, name)| {
        (0..WORDS).map(move |word| (word_channel_name(&name, word), Content::Word { offset, word }))
    });
    words.chain([(MISSING.to_owned(), Content::Missing)])
}

/// The channels of a file. Each block of lines is computed when it is written.
struct FilmChannels<'a> {
    accumulator: &'a FilmAccumulator,
    filtered: Option<Filtered>,
    list: ChannelList,
    /// In the order of the list.
    contents: Vec<Content>,
}

impl<'a> FilmChannels<'a> {
    fn new(accumulator: &'a FilmAccumulator, channels: Vec<(String, Content)>) -> Self {
        let mut channels: Vec<(Text, Content)> =
            channels.into_iter().map(|(name, content)| (Text::from(&*name), content)).collect();
        channels.sort_unstable_by(|(one, _), (other, _)| one.cmp(other));
        let description = |(name, content): &(Text, Content)| {
            let sample_type = if matches!(content, Content::Mean(_)) { SampleType::F32 } else { SampleType::U32 };
            ChannelDescription::named(name.clone(), sample_type)
        };
        let list = ChannelList::new(channels.iter().map(description).collect());
        let filtered = Filtered::new(accumulator);
        Self { accumulator, filtered, list, contents: channels.into_iter().map(|(_, content)| content).collect() }
    }
}

impl<'a> WritableChannels<'a> for FilmChannels<'a> {
    type Writer = &'a Self;

    fn infer_channel_list(&self) -> ChannelList {
        self.list.clone()
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_writer(&'a self, _header: &Header) -> Self::Writer {
        self
    }
}

impl ChannelsWriter for &FilmChannels<'_> {
    fn extract_uncompressed_block(&self, header: &Header, block: BlockIndex) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(block.pixel_size.area() * header.channels.bytes_per_pixel);
        let most = range_length(&self.accumulator.samples());
        let window = self.accumulator.window();
        let lines = window.rows.clone().skip(block.pixel_position.y());
        for row in lines.take(block.pixel_size.height()) {
            let (first, count) = (block.pixel_position.x(), block.pixel_size.width());
            let pixels: Vec<PixelSums> = self.accumulator.row(row).skip(first).take(count).collect();
            let first = (row - window.rows.start) as usize * window.size().width as usize + first;
            let changes = |index: usize| Filtered::changes(self.filtered.as_ref(), first + index);
            for content in &self.contents {
                match *content {
                    Content::Mean(mean) => {
                        let values = pixels.iter().enumerate().map(|(index, pixel)| mean.of(pixel, changes(index)));
                        bytes.extend(values.flat_map(f32::to_ne_bytes));
                    }
                    Content::Word { offset, word } => {
                        bytes.extend(pixels.iter().flat_map(|pixel| word_of(pixel.at(offset), word).to_ne_bytes()));
                    }
                    Content::Matte(MatteWord { matte, entry, value }) => {
                        let word = |pixel: &PixelSums| pixel.matte(matte)?.entries().get(entry).map(|at| at[value]);
                        bytes.extend(pixels.iter().flat_map(|pixel| word(pixel).unwrap_or(0).to_ne_bytes()));
                    }
                    Content::Missing => {
                        bytes.extend(pixels.iter().flat_map(|pixel| (most - pixel.count()).to_ne_bytes()));
                    }
                }
            }
        }
        bytes
    }
}

#[expect(clippy::cast_possible_truncation, reason = "one word of four")]
fn word_of(sum: i128, word: usize) -> u32 {
    (sum >> (32 * word)) as u32
}

fn word_channel_name(sum_name: &str, word: usize) -> String {
    format!("sums.{sum_name}.{word}")
}

/// A resumable file without its sums.
#[derive(Debug, Clone, PartialEq)]
pub struct ResumableImage {
    path: PathBuf,
    /// The metadata, a line for each keyword.
    comments: String,
    /// The inputs that the samples depend on.
    pub provenance: Provenance,
    /// What a PNG of the image needs.
    pub settings: PictureSettings,
    /// The samples of the pixel with most samples.
    pub samples: Range<u32>,
    /// The values that are summed beside colours.
    pub aovs: Aovs,
    /// Size of the whole image.
    pub image_size: ImageSize,
    /// The pixels that have sums.
    pub window: Window,
}

impl ResumableImage {
    /// Reads the header of a resumable file.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, or has no sums that this version can read.
    pub fn open(path: &Path) -> Result<Self, RenderError> {
        let reason = "the image has no sums, so it cannot be resumed or merged (render with --keep-sums)";
        let without = || FileError::Content { path: path.into(), reason: reason.to_owned() };
        Self::open_if_resumable(path)?.ok_or_else(|| without().into())
    }

    /// Reads the header of a file; none if the image has no sums.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, or has sums that this version cannot read.
    pub fn open_if_resumable(path: &Path) -> Result<Option<Self>, RenderError> {
        let invalid =
            |reason: &str| RenderError::from(FileError::Content { path: path.into(), reason: reason.to_owned() });
        let meta = MetaData::read_from_file(path, false).map_err(|error| match error {
            exr::error::Error::Io(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
                FileError::Read { path: path.into(), source }.into()
            }
            error => invalid(&format!("not a readable EXR file: {error}")),
        })?;
        let header = meta.headers.first().ok_or_else(|| invalid("the EXR file has no image"))?;
        if !header.channels.list.iter().any(|channel| channel.name == *word_channel_name("X", 0)) {
            return Ok(None);
        }
        if text(header, PROVENANCE).is_none() {
            return Err(invalid("another version of snowblue wrote the image; this one cannot resume or merge it"));
        }
        let image = Self::from_header(path, header).map_err(|reason| invalid(&reason))?;
        let length = std::fs::metadata(path).map_err(|source| FileError::Read { path: path.into(), source })?.len();
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        let mattes = size_of::<u32>() * header.channels.list.len();
        check_header_expansion(header, pixel_bytes(image.aovs) + mattes, length).map_err(|reason| invalid(&reason))?;
        Ok(Some(image))
    }

    /// The content of the header, or the reason why it does not describe sums.
    fn from_header(path: &Path, header: &Header) -> Result<Self, String> {
        fn damaged(part: &str) -> String {
            format!("the {part} of the sums are damaged")
        }
        let display = header.shared_attributes.display_window;
        let position = header.own_attributes.layer_position;
        let range = |start: i32, length: usize| {
            let start = u32::try_from(start).ok()?;
            Some(start..start.checked_add(u32::try_from(length).ok()?)?)
        };
        let size = u32::try_from(display.size.0).ok().zip(u32::try_from(display.size.1).ok());
        let window = range(position.0, header.layer_size.0).zip(range(position.1, header.layer_size.1));
        let (Some((width, height)), Some((columns, rows))) = (size, window) else {
            return Err(damaged("windows"));
        };
        let (image_size, window) = (ImageSize { width, height }, Window { columns, rows });
        if !Window::of_image(image_size).contains(&window) {
            return Err(damaged("windows"));
        }
        let samples: String = parsed(header, SAMPLE_RANGE)?;
        let samples = samples.split_once(':').and_then(|(start, end)| Some(start.parse().ok()?..end.parse().ok()?));
        Ok(Self {
            path: path.into(),
            comments: header.own_attributes.comments.as_ref().map(of_exr_text).unwrap_or_default(),
            provenance: Provenance::parse(&parsed::<String>(header, PROVENANCE)?),
            settings: settings_of(header)?,
            samples: samples.ok_or_else(|| damaged("range of samples"))?,
            aovs: Aovs::of_file(&parsed::<String>(header, AOVS)?)
                .map_err(|error| format!("the attribute {AOVS}: {error}"))?,
            image_size,
            window,
        })
    }

    /// The text of a keyword of the metadata.
    pub fn note(&self, keyword: &str) -> Option<&str> {
        note_of(&self.comments, keyword)
    }

    /// Whether this is the header of the file.
    fn is_of(&self, header: &Header) -> bool {
        Self::from_header(&self.path, header).is_ok_and(|image| image == *self)
    }

    /// Reads the sums.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, or has changed since it was opened.
    pub fn read_sums(&self) -> Result<FilmAccumulator, RenderError> {
        let invalid = |reason: String| RenderError::from(FileError::Content { path: self.path.clone(), reason });
        let unreadable = |error: exr::error::Error| invalid(format!("not a readable EXR file: {error}"));
        let file = File::open(&self.path).map_err(|error| unreadable(error.into()))?;
        let reader = exr::block::read(BufReader::new(file), false).map_err(unreadable)?;
        let header = reader.headers().first().filter(|header| self.is_of(header));
        let header = header.ok_or_else(|| invalid("the file has changed".to_owned()))?;
        // The part of the sums that each channel of the file holds.
        let mut contents: Vec<Option<Content>> = vec![None; header.channels.list.len()];
        let place_of = |name: &str| {
            let is_named =
                |channel: &ChannelDescription| channel.name == *name && channel.sample_type == SampleType::U32;
            header.channels.list.iter().position(is_named)
        };
        for (name, content) in sum_channels(self.aovs) {
            let place = place_of(&name).ok_or_else(|| invalid(format!("the channel {name} is missing")))?;
            contents[place] = Some(content);
        }
        for matte in self.aovs.mattes() {
            for (name, content) in (0..header.channels.list.len()).flat_map(|entry| matte_channels(matte, entry)) {
                let Some(place) = place_of(&name) else { break };
                contents[place] = Some(content);
            }
        }
        let mut accumulator = FilmAccumulator::new(self.image_size, &self.window, self.aovs);
        let attributes = header.own_attributes.other.iter().filter_map(|(name, value)| match value {
            AttributeValue::Text(text) => Some((of_exr_text(name), of_exr_text(text))),
            _ => None,
        });
        accumulator.attributes = attributes.filter(|(name, _)| is_of_aovs(name)).collect();
        accumulator.begin_at(self.samples.start);
        let most = range_length(&self.samples);
        let rows = self.window.rows.start;
        reader
            .filter_chunks(false, |_, _, block| block.layer == 0 && block.level == Vec2(0, 0))
            .and_then(|chunks| {
                chunks.decompress_parallel(false, |meta, block| {
                    for line in block.lines(&meta.headers[0].channels) {
                        let (Vec2(first, row), content) = (line.location.position, contents[line.location.channel]);
                        let row = rows + u32::try_from(row).unwrap_or(u32::MAX);
                        let values = || line.read_samples::<u32>().collect::<Result<Vec<u32>, _>>();
                        match content {
                            None | Some(Content::Mean(_)) => {}
                            Some(Content::Missing) => {
                                let count = |missing: u32| most.checked_sub(missing);
                                let counts: Option<Vec<u32>> = values()?.into_iter().map(count).collect();
                                let error = || exr::error::Error::Invalid("more samples are missing than all".into());
                                accumulator.fill_counts(row, first, counts.ok_or_else(error)?);
                            }
                            Some(Content::Matte(word)) => accumulator.fill_mattes(row, first, word, values()?),
                            Some(Content::Word { offset, word }) => {
                                let bits = |bits: u32| (u128::from(bits) << (32 * word)).cast_signed();
                                accumulator.fill_bits(row, first, offset, values()?.into_iter().map(bits));
                            }
                        }
                    }
                    Ok(())
                })
            })
            .map_err(unreadable)?;
        accumulator.drop_empty_entries();
        Ok(accumulator)
    }
}

/// The settings that [`write`] stores.
fn settings_of(header: &Header) -> Result<PictureSettings, String> {
    let exposure = parsed(header, EXPOSURE)?;
    if matches!(exposure, Exposure::Stops(stops) if !(-MAX_STOPS..=MAX_STOPS).contains(&stops)) {
        let range = format!("must lie in -{MAX_STOPS} to {MAX_STOPS} stops");
        return Err(format!("the attribute {EXPOSURE} is {exposure}, but {range}"));
    }
    let sky = text(header, SKY).map(|text| {
        let (x, y) = text.split_once(' ').and_then(|(x, y)| Some((x.parse().ok()?, y.parse().ok()?)))?;
        let xyz = Xyy { chromaticity: Chromaticity { x, y }, luminance: 1.0 }.xyz();
        (x > 0.0 && y > 0.0 && xyz.z > 0.0).then_some(xyz)
    });
    if sky == Some(None) {
        return Err(format!("the attribute {SKY} is no chromaticity"));
    }
    Ok(PictureSettings {
        development: Development { exposure, tone: parsed(header, TONE)? },
        white: PictureWhite { white: parsed(header, WHITE)?, sky: sky.flatten() },
    })
}

/// The settings of a later PNG; none in a file of another program.
pub(crate) fn settings_if_any(header: &Header) -> Result<Option<PictureSettings>, String> {
    text(header, WHITE).map(|_| settings_of(header)).transpose()
}

/// Whether an attribute belongs to the AOVs of the scene.
fn is_of_aovs(name: &str) -> bool {
    name.starts_with(cryptomatte::ATTRIBUTES) || name == POSITION_ORIGIN
}

/// An attribute as a value.
fn parsed<T: FromStr<Err: Display>>(header: &Header, name: &str) -> Result<T, String> {
    let text = text(header, name).ok_or_else(|| format!("the attribute {name} is missing"))?;
    text.parse().map_err(|error| format!("the attribute {name}: {error}"))
}

/// A text attribute of a layer.
fn text(header: &Header, name: &str) -> Option<String> {
    match header.own_attributes.other.get(&exr_text(name)) {
        Some(AttributeValue::Text(text)) => Some(of_exr_text(text)),
        _ => None,
    }
}
