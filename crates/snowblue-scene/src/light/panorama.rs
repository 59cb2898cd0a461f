//! Files of environment images: OpenEXR and Radiance.

use std::io::Cursor;

use exr::image::{AnyChannels, FlatSamples, Layer};
use exr::meta::attribute::EnvironmentMap;
use exr::prelude::{ReadChannels, ReadLayers, Vec2};
use snowblue_base::files::{FileError, FileSource, NamedFile, check_formats, check_memory};
use snowblue_color::{Chromaticity, LinearRgb, Primaries};
use snowblue_geometry::images::check_exr_size;

use crate::light::radiance_file;

/// Memory of a pixel: a colour of double precision, and its colour, brightness and share of the light in single
/// precision.
const PIXEL_BYTES: usize = size_of::<LinearRgb>() + 5 * size_of::<f32>();

/// An environment image as in its file.
#[derive(Debug, Clone, PartialEq)]
pub struct Panorama {
    /// Pixels in a row, over all azimuths.
    pub width: usize,
    /// Pixels from zenith to nadir.
    pub height: usize,
    /// Linear sRGB, row by row.
    pub pixels: Vec<LinearRgb>,
}

/// The channels of a part of an OpenEXR file.
type Part = Layer<AnyChannels<FlatSamples>>;

impl Panorama {
    /// Reads an OpenEXR or Radiance file, in the primaries that it states, or in linear sRGB. Pixels outside the data
    /// window of an OpenEXR file are black. Without `layer`, it is the first part of an OpenEXR file with red, green
    /// and blue, or with luminance only, which is grey.
    ///
    /// # Errors
    ///
    /// When there is no such file, or it is malformed, has another format, is a cube map, or holds neither red, green
    /// and blue nor luminance alone.
    pub fn read(files: &dyn FileSource, name: &str, layer: Option<&str>) -> Result<Self, FileError> {
        let NamedFile { path, bytes } = NamedFile::read(files, name)?;
        check_formats(&path)?;
        let is = |magic: &[u8]| bytes.starts_with(magic);
        let read = if is(b"#?") {
            match layer {
                Some(layer) => Err(format!("a Radiance file has no layer \"{layer}\"")),
                None => Self::of_radiance(&bytes),
            }
        } else if is(b"\x89PNG") || is(b"\xff\xd8") {
            Err("the image is a PNG or JPEG, whose values end at white, so that it has no sun: take the .exr or .hdr of \
                 this sky, or convert it with `magick IN.jpg -colorspace RGB OUT.hdr`"
                .to_owned())
        } else {
            Self::of_exr(&bytes, layer)
        };
        read.map_err(|reason| FileError::Content { path, reason })
    }

    /// Reads a Radiance file.
    fn of_radiance(bytes: &[u8]) -> Result<Self, String> {
        let header = radiance_file::Header::read(bytes)?;
        let (width, height) = (header.width, header.height);
        let what = format!("{width} × {height} pixels");
        check_memory(&what, width as f64 * height as f64 * PIXEL_BYTES as f64, bytes.len())?;
        let mut pixels = header.pixels()?;
        if let Some(primaries) = header.primaries {
            convert(&mut pixels, primaries)?;
        }
        Ok(Self { width, height, pixels })
    }

    /// Reads an OpenEXR file.
    fn of_exr(bytes: &[u8], layer: Option<&str>) -> Result<Self, String> {
        check_exr_size(bytes, |samples| samples + PIXEL_BYTES)?;
        let image = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().all_layers();
        let image = image.all_attributes().from_buffered(Cursor::new(bytes));
        let image = image.map_err(|error| format!("not a readable EXR file: {error}"))?;
        let parts = &image.layer_data;
        let found = parts.iter().find_map(|part| Some((part, colours(part, layer)?)));
        let Some((part, channels)) = found else { return Err(lacks(parts, layer)) };
        if part.attributes.environment_map == Some(EnvironmentMap::Cube) {
            return Err("the image is a cube map, but must be latitude by longitude (`exrenvmap -latlong IN.exr \
                        OUT.exr` makes such an image)"
                .to_owned());
        }
        let window = image.attributes.display_window;
        let (width, height) = (window.size.width(), window.size.height());
        let what = format!("{width} × {height} pixels");
        check_memory(&what, width as f64 * height as f64 * PIXEL_BYTES as f64, bytes.len())?;
        let mut pixels = vec![LinearRgb::default(); width * height];
        let offset = part.attributes.layer_position - window.position;
        let [mut red, mut green, mut blue] = channels.map(FlatSamples::values_as_f32);
        let inside = |place: usize, offset: i32, count: usize| {
            usize::try_from(place as i64 + i64::from(offset)).ok().filter(|place| *place < count)
        };
        for Vec2(column, row) in (0..part.size.area()).map(|index| Vec2(index % part.size.0, index / part.size.0)) {
            let (Some(r), Some(g), Some(b)) = (red.next(), green.next(), blue.next()) else {
                return Err("the channels of colours have fewer pixels than the image".to_owned());
            };
            if let (Some(x), Some(y)) = (inside(column, offset.0, width), inside(row, offset.1, height)) {
                pixels[y * width + x] = LinearRgb { r: r.into(), g: g.into(), b: b.into() };
            }
        }
        if let Some(stated) = image.attributes.chromaticities {
            let at = |Vec2(x, y): Vec2<f32>| Chromaticity { x: x.into(), y: y.into() };
            let primaries = Primaries { red: at(stated.red), green: at(stated.green), blue: at(stated.blue) };
            convert(&mut pixels, (primaries, at(stated.white)))?;
        }
        Ok(Self { width, height, pixels })
    }
}

/// The channels of red, green and blue of a part, which are one channel if there is only luminance besides alpha.
fn colours<'part>(part: &'part Part, layer: Option<&str>) -> Option<[&'part FlatSamples; 3]> {
    let prefix = match layer {
        Some(layer) if part.attributes.layer_name.as_ref().is_none_or(|name| name != layer) => format!("{layer}."),
        _ => String::new(),
    };
    let channels = &part.channel_data.list;
    let channel = |name: &str| {
        let name = format!("{prefix}{name}");
        channels.iter().find(|channel| channel.name == *name.as_str()).map(|channel| &channel.sample_data)
    };
    if let (Some(red), Some(green), Some(blue)) = (channel("R"), channel("G"), channel("B")) {
        return Some([red, green, blue]);
    }
    // Luminance with chroma channels is not grey.
    let names = channels.iter().map(|channel| channel.name.to_string());
    let mut others = names.filter_map(|name| name.strip_prefix(&prefix).map(str::to_owned));
    others.all(|name| ["A", "Y"].contains(&name.as_str())).then(|| channel("Y").map(|grey| [grey; 3]))?
}

/// Why no part has colours.
fn lacks(parts: &[Part], layer: Option<&str>) -> String {
    let named = |part: &Part| {
        let name = part.attributes.layer_name.as_ref().filter(|_| parts.len() > 1);
        let channels: Vec<String> = part.channel_data.list.iter().map(|channel| channel.name.to_string()).collect();
        name.map_or_else(|| channels.join(", "), |name| format!("{name}: {}", channels.join(", ")))
    };
    let found = parts.iter().map(named).collect::<Vec<_>>().join("; ");
    let of_layer = layer.map(|layer| format!(" of the layer \"{layer}\"")).unwrap_or_default();
    format!("the channels are {found}, but must include R, G and B{of_layer}, or be Y alone; `layer` chooses a layer")
}

/// Converts colours from a space of other primaries and white to linear sRGB.
fn convert(pixels: &mut [LinearRgb], (primaries, white): (Primaries, Chromaticity)) -> Result<(), String> {
    let units = primaries.in_srgb(white);
    let [red, green, blue] = units.ok_or_else(|| format!("{primaries:?} with {white:?} are no space of colours"))?;
    for pixel in pixels {
        let LinearRgb { r, g, b } = *pixel;
        *pixel = red * r;
        *pixel += green * g;
        *pixel += blue * b;
    }
    Ok(())
}
