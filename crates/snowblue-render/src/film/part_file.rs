//! Pictures in progress as OpenEXR files: what any program shows, and beside it what is needed to go on.
//!
//! Every file has the channels `R`, `G`, `B`; those that were asked for stand beside them under names that other programs know. The
//! spectrum follows Fichet, Pacanowski & Wilkie (2021, "An OpenEXR layout for spectral images", Journal of Computer Graphics
//! Techniques 10(3), 1–18): `S0.400,000000nm` and so on, in W m⁻² sr⁻¹ nm⁻¹, as the attribute `emissiveUnits` says.
//!
//! A file that can be continued or merged has in addition the sums themselves, four unsigned words of 32 bits for each (`sums.X.0`, the
//! lowest, to `sums.X.3`), and as attributes which samples they are of, what they are made from ([`Origin`]) and how bright a
//! PNG of them is to be.
//! A part of a picture has its place in the whole by the data window and the display window, as the format means it.

use std::io::Cursor;
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, IntegerBounds, Text};
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, ReadChannels, ReadLayers, Vec2, WritableImage, read,
};
use snowblue_color::LinearRgb;

use crate::error::RenderError;
use crate::film::accumulator::FilmAccumulator;
use crate::film::aov::{Aov, Aovs};
use crate::film::exposure::Exposure;
use crate::film::image_file::{Notes, attributes, exr_text, store};
use crate::film::provenance::Provenance;
use crate::film::sample_block::{Coverage, SampleBlock, Window};
use crate::geometry::ray::narrow;
use crate::spectrum::SAMPLES;

const ORIGIN: &str = "snowblueOrigin";
const COVERAGE: &str = "snowblueSamples";
const CHANNELS: &str = "snowblueChannels";
const WAVELENGTHS: &str = "snowblueWavelengths";
const EXPOSURE: &str = "snowblueExposure";

/// Words of 32 bits in a sum.
const WORDS: usize = 4;

/// What a picture needs to be continued or merged, beside its sums.
#[derive(Debug, Clone, Copy)]
pub struct Kept<'a> {
    /// What it is made from.
    pub origin: &'a Provenance,
    /// Brightness of a PNG that is made of it; parts of one picture may differ in it.
    pub exposure: Exposure,
}

/// Writes the means of some sums as OpenEXR; with what is to be kept also the sums, so that the picture can be continued.
///
/// # Errors
///
/// When the picture cannot be encoded or stored.
pub fn write(sums: &FilmAccumulator, kept: Option<Kept>, notes: &Notes, path: &Path) -> Result<(), RenderError> {
    let mut channels = shown(sums);
    let mut attributes = attributes(notes);
    let window = sums.window();
    attributes.layer_position = Vec2(signed(window.columns.start), signed(window.rows.start));
    let mut say =
        |name: &str, text: &str| attributes.other.insert(exr_text(name), AttributeValue::Text(exr_text(text)));
    let asked = sums.channels();
    for (asked, name, text) in [
        (asked.spectrum, "spectralLayoutVersion", "1.0"),
        (asked.spectrum, "emissiveUnits", "W.m^-2.sr^-1.nm^-1"),
        (asked.thickness, "thicknessUnits", "m"),
        (asked.angle, "angleUnits", "deg"),
    ] {
        if asked {
            say(name, text);
        }
    }
    if let Some(Kept { origin, exposure }) = kept {
        let wavelengths: Vec<String> = sums.wavelengths_nm().iter().map(f64::to_string).collect();
        say(ORIGIN, &origin.to_string());
        say(COVERAGE, &sums.coverage().to_string());
        say(CHANNELS, &asked.to_string());
        say(WAVELENGTHS, &wavelengths.join(" "));
        say(EXPOSURE, &exposure.to_string());
        channels.extend(words(sums));
    }
    let size = Vec2(window.width() as usize, window.height() as usize);
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels.into()));
    let mut image = Image::from_layer(layer);
    let (whole_width, whole_height) = sums.size();
    image.attributes.display_window =
        IntegerBounds { position: Vec2(0, 0), size: Vec2(whole_width as usize, whole_height as usize) };
    let mut content = Cursor::new(Vec::new());
    let written = image.write().to_buffered(&mut content);
    drop(image);
    store(path, written.map(|()| content.into_inner()).map_err(|error| error.to_string()))
}

/// A coordinate of a pixel as the format has it; pictures have at most 2¹⁴ pixels a side.
fn signed(coordinate: u32) -> i32 {
    coordinate.cast_signed()
}

/// The channels that other programs show.
fn shown(sums: &FilmAccumulator) -> Vec<AnyChannel<FlatSamples>> {
    let channel = |name: &str, values: Vec<f32>| AnyChannel::new(name, FlatSamples::F32(values));
    let film = sums.film();
    let rgb = film.pixels().iter().map(|xyz| LinearRgb::from_xyz(*xyz));
    let mut channels = vec![
        channel("R", rgb.clone().map(|colour| narrow(colour.r)).collect()),
        channel("G", rgb.clone().map(|colour| narrow(colour.g)).collect()),
        channel("B", rgb.map(|colour| narrow(colour.b)).collect()),
    ];
    let asked = sums.channels();
    if asked.spectrum {
        let wavelengths_nm = sums.wavelengths_nm();
        // A band density is a spectral radiance times the width of all bands.
        let band_nm = (wavelengths_nm[SAMPLES - 1] - wavelengths_nm[0]) / (SAMPLES - 1) as f64;
        let per_nm = narrow((SAMPLES as f64 * band_nm).recip());
        for (place, nm) in wavelengths_nm.iter().enumerate() {
            let values = sums.radiance(place).into_iter().map(|density| density * per_nm).collect();
            channels.push(channel(&format!("S0.{}nm", format!("{nm:.6}").replace('.', ",")), values));
        }
    }
    if asked.variance {
        for (name, values) in ["variance.R", "variance.G", "variance.B"].into_iter().zip(sums.variance()) {
            channels.push(channel(name, values));
        }
    }
    for feature in Aov::ALL.into_iter().filter(|feature| asked.has(*feature)) {
        for (value, name) in feature.names().iter().enumerate() {
            channels.push(channel(name, sums.feature(feature, value)));
        }
    }
    channels
}

/// The sums, as words.
fn words(sums: &FilmAccumulator) -> impl Iterator<Item = AnyChannel<FlatSamples>> {
    let word = |sum: i128, word: usize| {
        #[expect(clippy::cast_possible_truncation, reason = "one word of four")]
        let bits = (sum >> (32 * word)) as u32;
        bits
    };
    sums.channels().sums().into_iter().enumerate().flat_map(move |(place, name)| {
        (0..WORDS).map(move |number| {
            let values = sums.plane(place).map(|sum| word(sum, number)).collect();
            AnyChannel::new(&*word_name(&name, number), FlatSamples::U32(values))
        })
    })
}

fn word_name(sum: &str, word: usize) -> String {
    format!("sums.{sum}.{word}")
}

/// What a file says of itself, without its pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// What it is made from.
    pub origin: Provenance,
    /// Brightness of a PNG that is made of it.
    pub exposure: Exposure,
    /// The samples that are in it.
    pub coverage: Coverage,
    /// What it tells of its pixels.
    pub channels: Aovs,
    /// Size of the whole picture in pixels.
    pub size: (u32, u32),
    /// Its pixels.
    pub window: Window,
    /// The wavelengths of its spectrum, in nm.
    pub wavelengths_nm: [f64; SAMPLES],
}

impl Part {
    /// Reads what an OpenEXR file says of itself.
    ///
    /// # Errors
    ///
    /// When it cannot be read, or has no sums to go on from.
    pub fn open(path: &Path) -> Result<Self, RenderError> {
        let wrong = |reason: String| RenderError::ReadImage { path: path.into(), reason };
        let meta = MetaData::read_from_file(path, false).map_err(|error| match error {
            exr::error::Error::Io(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
                RenderError::ReadFile { path: path.into(), source }
            }
            error => wrong(format!("not a readable EXR file: {error}")),
        })?;
        let header = meta.headers.first().ok_or_else(|| wrong("an EXR file without a picture".to_owned()))?;
        if text(header, ORIGIN).is_none() {
            let reason = "the picture has no sums to go on from (render with --keep-sums)";
            return Err(wrong(reason.to_owned()));
        }
        Self::from_header(header)
            .ok_or_else(|| wrong("what the file says of its sums is damaged, or from another version".to_owned()))
    }

    fn from_header(header: &Header) -> Option<Self> {
        let display = header.shared_attributes.display_window;
        let size = (u32::try_from(display.size.0).ok()?, u32::try_from(display.size.1).ok()?);
        let position = header.own_attributes.layer_position;
        let range = |start: i32, length: usize| {
            let start = u32::try_from(start).ok()?;
            Some(start..start.checked_add(u32::try_from(length).ok()?)?)
        };
        let window =
            Window { columns: range(position.0, header.layer_size.0)?, rows: range(position.1, header.layer_size.1)? };
        let coverage: Coverage = text(header, COVERAGE)?.parse().ok()?;
        let within = |portion: &SampleBlock| window.holds(&portion.window());
        let fits = window.columns.end <= size.0 && window.rows.end <= size.1;
        let wavelengths: Option<Vec<f64>> =
            text(header, WAVELENGTHS)?.split_whitespace().map(|nm| nm.parse().ok()).collect();
        (fits && coverage.portions().iter().all(within)).then_some(Self {
            origin: Provenance::parse(&text(header, ORIGIN)?),
            exposure: text(header, EXPOSURE)?.parse().ok()?,
            coverage,
            channels: text(header, CHANNELS)?.parse().ok()?,
            size,
            window,
            wavelengths_nm: wavelengths?.try_into().ok()?,
        })
    }

    /// The sums that a file holds.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, or is another than it was.
    pub fn read(&self, path: &Path) -> Result<FilmAccumulator, RenderError> {
        let wrong = |reason: String| RenderError::ReadImage { path: path.into(), reason };
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .from_file(path)
            .map_err(|error| wrong(format!("not a readable EXR file: {error}")))?;
        let mut sums = FilmAccumulator::empty(self.size, self.channels, self.wavelengths_nm, &self.window);
        let list = &image.layer_data.channel_data.list;
        for (place, name) in self.channels.sums().into_iter().enumerate() {
            let mut plane = vec![0u128; sums.plane(place).len()];
            for word in 0..WORDS {
                let name = word_name(&name, word);
                let channel = list.iter().find(|channel| channel.name == *name);
                let Some(FlatSamples::U32(values)) = channel.map(|channel| &channel.sample_data) else {
                    return Err(wrong(format!("the channel {name} is missing")));
                };
                plane.iter_mut().zip(values).for_each(|(sum, bits)| *sum |= u128::from(*bits) << (32 * word));
            }
            sums.restore(place, plane.into_iter().map(u128::cast_signed));
        }
        self.coverage.portions().iter().for_each(|portion| sums.note(portion.clone()));
        Ok(sums)
    }
}

/// A text of a file's own.
fn text(header: &Header, name: &str) -> Option<String> {
    match header.own_attributes.other.get(&exr_text(name)) {
        Some(AttributeValue::Text(text)) => Some(Text::to_string(text)),
        _ => None,
    }
}
