//! Files of environment images: OpenEXR and Radiance.

use std::io::Cursor;

use exr::image::{AnyChannels, FlatSamples, Layer};
use exr::meta::attribute::EnvironmentMap;
use exr::prelude::Vec2;
use image::codecs::hdr::{HdrDecoder, HdrMetadata};
use image::{DynamicImage, ImageError};
use snowblue_base::files::{FileError, FileSource, NamedFile, check_formats, check_memory};
use snowblue_color::{Chromaticity, LinearRgb, Primaries};
use snowblue_geometry::images::read_exr;

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

/// The chromaticities x and y of red, green, blue and white that a file states.
type Chromaticities = [[f64; 2]; 4];

/// The channels of a part of an OpenEXR file.
type Part = Layer<AnyChannels<FlatSamples>>;

impl Panorama {
    /// Reads an OpenEXR or Radiance file, in the primaries that it states, or in linear sRGB. Pixels outside the data
    /// window of an OpenEXR file are black. Without `layer`, it is the first part of an OpenEXR file with red, green
    /// and blue, or with luminance only, which is grey. Channels of the file above `max_radiance` become it.
    ///
    /// # Errors
    ///
    /// When there is no such file, or it is malformed, has another format, is a cube map, is not twice as wide as high,
    /// holds neither red, green and blue nor luminance alone, or has a channel that is not finite.
    pub fn read(
        files: &dyn FileSource,
        name: &str,
        layer: Option<&str>,
        max_radiance: Option<f64>,
    ) -> Result<Self, FileError> {
        let NamedFile { path, bytes } = NamedFile::read(files, name)?;
        check_formats(&path)?;
        let is = |magic: &[u8]| bytes.starts_with(magic);
        let read = if is(b"#?") {
            match layer {
                Some(layer) => Err(format!("a Radiance file has no layer \"{layer}\"")),
                None => Self::of_radiance(&bytes),
            }
        } else if is(b"\x89PNG") || is(b"\xff\xd8") {
            Err("the image is a PNG or JPEG, whose values end at white, so that the sun is too dark: take the .exr or \
                 .hdr of this sky, or convert it with `magick IN.jpg -colorspace RGB OUT.hdr`"
                .to_owned())
        } else {
            Self::of_exr(&bytes, layer)
        };
        let finished = |(mut panorama, chromaticities): (Self, Option<_>)| {
            panorama.check_shape()?;
            panorama.limit(max_radiance)?;
            chromaticities.map_or(Ok(()), |stated| panorama.convert(stated))?;
            Ok(panorama)
        };
        read.and_then(finished).map_err(|reason| FileError::Content { path, reason })
    }

    /// Refuses an image that is not twice as wide as high, up to a pixel: azimuths have twice the angle of elevations.
    fn check_shape(&self) -> Result<(), String> {
        let Self { width, height, .. } = self;
        if width.abs_diff(2 * height) <= 1 {
            return Ok(());
        }
        let whole = format!("`oiiotool IN.exr --resize {}x{height} -o OUT.exr` if it shows all directions", 2 * height);
        let part = format!(
            "`oiiotool IN.exr --fullsize {width}x{}+0+0 -o OUT.exr` if it shows the upper part of all directions, or ",
            width.div_ceil(2)
        );
        let part = if *width > 2 * height { part.as_str() } else { "" };
        Err(format!("the image is {width} × {height} pixels, but must be twice as wide as high: {part}{whole}"))
    }

    /// Replaces channels above `max_radiance` by it, and refuses channels that are not finite. In other primaries, one
    /// infinite channel would be no number.
    fn limit(&mut self, max_radiance: Option<f64>) -> Result<(), String> {
        let burnt = |pixel: &&LinearRgb| [pixel.r, pixel.g, pixel.b].contains(&f64::INFINITY);
        let burnt = self.pixels.iter().filter(burnt).count();
        let count = self.pixels.len();
        for (index, LinearRgb { r, g, b }) in self.pixels.iter_mut().enumerate() {
            for channel in [&mut *r, g, b] {
                *channel = max_radiance.filter(|most| *channel > *most).unwrap_or(*channel);
            }
            if ![*r, *g, *b].iter().all(|channel| channel.is_finite()) {
                let (column, row) = (index % self.width, index / self.width);
                return Err(format!(
                    "pixel {column}, {row} is {r}, {g}, {b}, and {burnt} of {count} pixels are infinite; \
                     `max_radiance` replaces infinity"
                ));
            }
        }
        Ok(())
    }

    /// Converts colours to linear sRGB from a space of the chromaticities of red, green, blue and white.
    fn convert(&mut self, chromaticities: Chromaticities) -> Result<(), String> {
        let [red, green, blue, white] = chromaticities.map(|[x, y]| Chromaticity { x, y });
        let units = Primaries { red, green, blue }.in_srgb(white);
        let [red, green, blue] =
            units.ok_or_else(|| format!("the chromaticities {chromaticities:?} are of no space of colours"))?;
        for pixel in &mut self.pixels {
            let LinearRgb { r, g, b } = *pixel;
            *pixel = red * r;
            *pixel += green * g;
            *pixel += blue * b;
        }
        Ok(())
    }

    /// Reads a Radiance file, whose values are multiplied by its exposure and its correction of colours.
    fn of_radiance(bytes: &[u8]) -> Result<(Self, Option<Chromaticities>), String> {
        let unreadable = |error: ImageError| format!("not a readable Radiance file: {error}").replace('\n', " ");
        // The first line names the program that wrote the file.
        let rest = bytes.iter().position(|byte| *byte == b'\n').map_or(&[][..], |end| &bytes[end..]);
        let decoder = HdrDecoder::new(Cursor::new([b"#?RADIANCE", rest].concat())).map_err(unreadable)?;
        let HdrMetadata { width, height, exposure, color_correction, custom_attributes, .. } = decoder.metadata();
        check_pixels(width as usize, height as usize, bytes.len())?;
        let (exposure, (red, green, blue)) = (exposure.unwrap_or(1.0), color_correction.unwrap_or((1.0, 1.0, 1.0)));
        let factors = [red, green, blue].map(|factor| f64::from(exposure * factor));
        if !factors.iter().all(|factor| factor.is_finite() && *factor > 0.0) {
            return Err(format!("the exposure is {factors:?}, but must be finite and above 0"));
        }
        let image = DynamicImage::from_decoder(decoder).map_err(unreadable)?.into_rgb32f();
        let color = |pixel: &[f32]| {
            let [r, g, b] = [0, 1, 2].map(|channel| f64::from(pixel[channel]) / factors[channel]);
            LinearRgb { r, g, b }
        };
        let pixels = image.as_raw().chunks_exact(3).map(color).collect();
        let chromaticities = custom_attributes.iter().find(|(key, _)| key == "PRIMARIES").map(|(_, primaries)| {
            let numbers: Vec<f64> = primaries.split_whitespace().filter_map(|number| number.parse().ok()).collect();
            Chromaticities::try_from(numbers.as_chunks().0)
                .map_err(|_| format!("PRIMARIES is \"{primaries}\", but must have eight numbers"))
        });
        Ok((Self { width: width as usize, height: height as usize, pixels }, chromaticities.transpose()?))
    }

    /// Reads an OpenEXR file.
    fn of_exr(bytes: &[u8], layer: Option<&str>) -> Result<(Self, Option<Chromaticities>), String> {
        let image = read_exr(bytes, |samples| samples + PIXEL_BYTES)?;
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
        check_pixels(width, height, bytes.len())?;
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
        let chromaticities = image.attributes.chromaticities.map(|stated| {
            [stated.red, stated.green, stated.blue, stated.white].map(|Vec2(x, y)| [x, y].map(f64::from))
        });
        Ok((Self { width, height, pixels }, chromaticities))
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

/// Refuses an image of more pixels than a file of `file_bytes` may have.
fn check_pixels(width: usize, height: usize, file_bytes: usize) -> Result<(), String> {
    if width == 0 || height == 0 {
        return Err(format!("the image has {width} × {height} pixels, but must have at least one"));
    }
    check_memory(&format!("{width} × {height} pixels"), width as f64 * height as f64 * PIXEL_BYTES as f64, file_bytes)
}

#[cfg(test)]
mod tests {
    use exr::meta::attribute::{Chromaticities as StatedChromaticities, IntegerBounds};
    use exr::prelude::{AnyChannel, Encoding, Image, ImageAttributes, LayerAttributes, SmallVec, WritableImage};
    use snowblue_base::files::FilesInMemory;

    use super::*;

    fn read(bytes: Vec<u8>, layer: Option<&str>) -> Result<Panorama, String> {
        read_limited(bytes, layer, None)
    }

    fn read_limited(bytes: Vec<u8>, layer: Option<&str>, max_radiance: Option<f64>) -> Result<Panorama, String> {
        let files = FilesInMemory::from([("sky", bytes)]);
        Panorama::read(&files, "sky", layer, max_radiance).map_err(|error| error.to_string())
    }

    /// A part of 4 by 2 pixels whose channels have one value each.
    fn part(name: &str, channels: &[(&str, f32)]) -> Part {
        let channel = |(name, value): &(&str, f32)| AnyChannel::new(*name, FlatSamples::F32(vec![*value; 8]));
        let channels = AnyChannels::sort(channels.iter().map(channel).collect());
        Layer::new((4, 2), LayerAttributes::named(name), Encoding::FAST_LOSSLESS, channels)
    }

    /// A file of parts with attributes, whose display window has a place and a size.
    fn exr(
        parts: Vec<Part>,
        (position, size): ((i32, i32), (usize, usize)),
        primaries: Option<[[f32; 2]; 4]>,
    ) -> Vec<u8> {
        let chromaticities = primaries.map(|primaries| {
            let [red, green, blue, white] = primaries.map(|[x, y]| Vec2(x, y));
            StatedChromaticities { red, green, blue, white }
        });
        let window = IntegerBounds::new(position, size);
        let attributes = ImageAttributes { chromaticities, ..ImageAttributes::new(window) };
        let mut bytes = Cursor::new(Vec::new());
        let image = Image { attributes, layer_data: parts.into_iter().collect::<SmallVec<[Part; 2]>>() };
        image.write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    const WHOLE: ((i32, i32), (usize, usize)) = ((0, 0), (4, 2));
    const RGB: [(&str, f32); 3] = [("R", 0.1), ("G", 0.2), ("B", 0.4)];

    fn color(r: f32, g: f32, b: f32) -> LinearRgb {
        LinearRgb { r: r.into(), g: g.into(), b: b.into() }
    }

    #[test]
    fn the_data_window_lies_in_the_display_window() {
        let rgb = color(0.1, 0.2, 0.4);
        // The upper left and the lower right quarter.
        for (position, [first_column, first_row]) in [((0, 0), [0, 0]), ((-4, -2), [4, 2])] {
            let quarter = read(exr(vec![part("a", &RGB)], (position, (8, 4)), None), None).unwrap();
            let is_lit = |pixel: usize| {
                (first_column..first_column + 4).contains(&(pixel % 8))
                    && (first_row..first_row + 2).contains(&(pixel / 8))
            };
            let expected: Vec<_> =
                (0..32).map(|pixel| if is_lit(pixel) { rgb } else { LinearRgb::default() }).collect();
            assert_eq!((quarter.width, quarter.pixels), (8, expected));
        }
        // What reaches beyond the display window is cut off.
        let cut = read(exr(vec![part("a", &RGB)], ((1, 1), (2, 1)), None), None).unwrap();
        assert_eq!((cut.width, cut.pixels), (2, vec![rgb; 2]));
        let message = read(exr(vec![part("a", &RGB)], ((0, 0), (1 << 20, 1 << 20)), None), None).unwrap_err();
        assert!(message.contains("1048576 × 1048576 pixels take"), "{message}");
    }

    const ACES_CG: [[f32; 2]; 4] = [[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], [0.32168, 0.33767]];

    #[test]
    fn burnt_out_channels_are_limited_before_their_primaries_are_converted() {
        let bytes =
            |[r, g, b]: [f32; 3], primaries| exr(vec![part("a", &[("R", r), ("G", g), ("B", b)])], WHOLE, primaries);
        let expected = "pixel 0, 0 is inf, inf, inf, and 8 of 8 pixels are infinite; `max_radiance` replaces infinity";
        for primaries in [None, Some(ACES_CG)] {
            let burnt = || bytes([f32::INFINITY; 3], primaries);
            assert!(read(burnt(), None).unwrap_err().ends_with(expected));
            // White of any primaries is white of sRGB.
            let LinearRgb { r, g, b } = read_limited(burnt(), None, Some(100.0)).unwrap().pixels[0];
            assert!([r, g, b].iter().all(|channel| (channel - 100.0).abs() < 1e-3), "{r} {g} {b}");
            let no_number = read_limited(bytes([f32::NAN, 0.0, 0.0], primaries), None, Some(100.0)).unwrap_err();
            assert!(no_number.contains("pixel 0, 0 is NaN, 0, 0, and 0 of 8 pixels are infinite"), "{no_number}");
        }
        // The first column of the matrix of the next test.
        let red = read_limited(bytes([f32::INFINITY, 0.0, 0.0], Some(ACES_CG)), None, Some(100.0)).unwrap();
        let LinearRgb { r, g, b } = red.pixels[0];
        assert!((r - 170.505).abs() < 2e-3 && (g + 13.026).abs() < 2e-3 && (b + 2.4).abs() < 2e-3, "{r} {g} {b}");
    }

    #[test]
    fn colours_are_in_the_primaries_of_the_file() {
        // From ACEScg to linear sRGB, adapted from D60 to D65 by the matrix of Bradford: the columns of
        // 1.70505 -0.62179 -0.08326, -0.13026 1.14080 -0.01055, -0.02400 -0.12897 1.15297 (Academy, ACES 1.0.3).
        for (channel, expected) in [
            ("R", [1.70505, -0.13026, -0.024]),
            ("G", [-0.62179, 1.1408, -0.12897]),
            ("B", [-0.08326, -0.01055, 1.15297]),
        ] {
            let channels = ["R", "G", "B"].map(|name| (name, if name == channel { 1.0 } else { 0.0 }));
            let LinearRgb { r, g, b } =
                read(exr(vec![part("a", &channels)], WHOLE, Some(ACES_CG)), None).unwrap().pixels[0];
            let far =
                [r, g, b].iter().zip(expected).map(|(found, expected)| (found - expected).abs()).fold(0.0, f64::max);
            assert!(far < 2e-5, "{channel}: {r} {g} {b}");
        }
        // The same by the header of a Radiance file. One mantissa of 128 with the exponent 129 is 1.
        let header = "FORMAT=32-bit_rle_rgbe\nPRIMARIES=.713 .293 .165 .83 .128 .044 .32168 .33767\n";
        let LinearRgb { r, g, b } = radiance(header, &[128, 0, 0, 129]).unwrap().pixels[0];
        assert!((r - 1.70505).abs() < 2e-5 && (g + 0.13026).abs() < 2e-5 && (b + 0.024).abs() < 2e-5, "{r} {g} {b}");
        // Three equal primaries make one colour.
        let flat = [[0.3, 0.3]; 4];
        let message = read(exr(vec![part("a", &RGB)], WHOLE, Some(flat)), None).unwrap_err();
        assert!(message.contains("are of no space of colours"), "{message}");
    }

    #[test]
    fn a_layer_is_a_part_or_a_prefix_of_channels() {
        let channels = [("sun.R", 3.0), ("sun.G", 2.0), ("sun.B", 1.0), ("Z", 7.0), ("grey.Y", 5.0)];
        let bytes = || exr(vec![part("a", &channels), part("b", &RGB)], WHOLE, None);
        let first = |layer: Option<&str>| read(bytes(), layer).map(|panorama| panorama.pixels[0]);
        assert_eq!(first(None), Ok(color(0.1, 0.2, 0.4)));
        assert_eq!(first(Some("b")), Ok(color(0.1, 0.2, 0.4)));
        assert_eq!(first(Some("sun")), Ok(color(3.0, 2.0, 1.0)));
        assert_eq!(first(Some("grey")), Ok(color(5.0, 5.0, 5.0)));
        let message = first(Some("moon")).unwrap_err();
        let expected = "the channels are a: Z, grey.Y, sun.B, sun.G, sun.R; b: B, G, R, but must include R, G and B of \
                        the layer \"moon\"";
        assert!(message.contains(expected), "{message}");
    }

    #[test]
    fn images_that_are_not_twice_as_wide_as_high_are_refused_with_a_way_out() {
        let message = |size| read(exr(vec![part("a", &RGB)], ((0, 0), size), None), None).map(|_| ()).unwrap_err();
        let expected = "the image is 4 × 1 pixels, but must be twice as wide as high: `oiiotool IN.exr --fullsize \
                        4x2+0+0 -o OUT.exr` if it shows the upper part of all directions, or `oiiotool IN.exr --resize \
                        2x1 -o OUT.exr` if it shows all directions";
        assert!(message((4, 1)).ends_with(expected), "{}", message((4, 1)));
        let expected = "as high: `oiiotool IN.exr --resize 8x4 -o OUT.exr` if it shows all directions";
        assert!(message((4, 4)).ends_with(expected), "{}", message((4, 4)));
        // Half of an odd width is rounded.
        assert!(read(exr(vec![part("a", &RGB)], ((0, 0), (5, 2)), None), None).is_ok());
    }

    #[test]
    fn cube_maps_and_pictures_of_screens_are_refused_with_a_way_out() {
        let mut cube = part("a", &RGB);
        cube.attributes.environment_map = Some(EnvironmentMap::Cube);
        let message = read(exr(vec![cube], WHOLE, None), None).unwrap_err();
        assert!(message.contains("`exrenvmap -latlong IN.exr OUT.exr`"), "{message}");
        let mut latlong = part("a", &RGB);
        latlong.attributes.environment_map = Some(EnvironmentMap::LatitudeLongitude);
        assert!(read(exr(vec![latlong], WHOLE, None), None).is_ok());
        for magic in [&b"\x89PNG\r\n\x1a\n"[..], b"\xff\xd8\xff\xe0"] {
            let message = read(magic.to_vec(), None).unwrap_err();
            assert!(message.contains("`magick IN.jpg -colorspace RGB OUT.hdr`"), "{message}");
        }
    }

    /// A Radiance file of 8 by 4 pixels, with a header and pixels that are all alike.
    fn radiance(header: &str, pixel: &[u8; 4]) -> Result<Panorama, String> {
        // Runs of 8 equal bytes of each channel.
        let row = [vec![2, 2, 0, 8], pixel.iter().flat_map(|byte| [128 + 8, *byte]).collect()].concat();
        read([format!("#?RGBE\n# a comment\n{header}\n-Y 4 +X 8\n").into_bytes(), row.repeat(4)].concat(), None)
    }

    #[test]
    fn radiance_files_are_read_with_their_exposure() {
        let format = "FORMAT=32-bit_rle_rgbe\n";
        let panorama = radiance(format, &[128, 64, 32, 138]).unwrap();
        // The mantissa times 2 to the exponent less 128 + 8.
        assert_eq!((panorama.width, panorama.height), (8, 4));
        assert_eq!(panorama.pixels, [color(512.0, 256.0, 128.0); 32]);
        // Exposures multiply each other.
        let exposed = format!("{format}EXPOSURE=2\nEXPOSURE= 4\nCOLORCORR= 1 2 .5\n");
        assert_eq!(radiance(&exposed, &[128, 64, 32, 138]).unwrap().pixels[7], color(64.0, 16.0, 32.0));
        for (header, expected) in [
            ("FORMAT=32-bit_rle_xyze\n", "32-bit_rle_xyze"),
            (&format!("{format}EXPOSURE=0\n"), "the exposure is [0.0, 0.0, 0.0], but must be finite and above 0"),
            (&format!("{format}PRIMARIES=.64 .33\n"), "PRIMARIES is \".64 .33\", but must have eight numbers"),
        ] {
            let message = radiance(header, &[1, 1, 1, 1]).unwrap_err();
            assert!(message.contains(expected) && !message.contains('\n'), "{message}");
        }
        let whole = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n".to_vec();
        for wrong in [whole.clone(), String::from_utf8(whole).unwrap().replace("-Y", "+Y").into_bytes(), b"#?".to_vec()]
        {
            let message = read(wrong, None).unwrap_err();
            assert!(message.contains("not a readable Radiance file") && !message.contains('\n'), "{message}");
        }
        for size in ["-Y 0 +X 0", "-Y 0 +X 8"] {
            let message =
                read(format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes(), None).unwrap_err();
            assert!(message.contains("must have at least one"), "{message}");
        }
        assert!(read(b"#?RADIANCE\n".to_vec(), Some("a")).unwrap_err().contains("has no layer \"a\""));
    }
}
