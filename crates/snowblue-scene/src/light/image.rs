//! An environment image as a light: a latitude-longitude map, sampled by luminance.
//!
//! Pixels lie as in a [table of directions](super::direction_table). Interpolation is bilinear.

use std::io::Cursor;

use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers};
use glam::Vec3A;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_base::files::{FileError, FileSource, NamedFile, check_formats};
use snowblue_color::LinearRgb;
use snowblue_geometry::images::check_exr_size;

use crate::error::SceneError;
use crate::light::direction_table::{DirectionTable, whole};
use crate::light::emitter::{Emitter, LightType};
use crate::light::keys::SkyScale;
use crate::light::sample::LightOrigin;
use crate::spectrum::Spectrum;
use crate::spectrum::upsampling::Upsampling;
use crate::values::{Rotation, visible};
use snowblue_base::{Number, narrow};

/// Largest channel of a pixel. This is the limit of all lights, far below the limit of single precision.
const MAX_PIXEL: f64 = 1e12;

/// Light of an image of all directions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImageSkyDescription {
    /// An OpenEXR file, latitude by longitude.
    pub image: String,
    /// Multiplies the image.
    #[serde(default = "ImageSkyDescription::default_scale")]
    pub scale: Number<SkyScale>,
    /// Turns the image about z, counter-clockwise seen from above, in degrees.
    #[serde(default)]
    pub rotation_deg: Number<Rotation>,
    /// Whether it is visible to the camera.
    #[serde(default = "visible")]
    pub visible: bool,
}

/// Light from all directions with the colours of an image.
#[derive(Debug)]
pub(crate) struct SkyImage {
    width: usize,
    height: usize,
    /// Linear sRGB, row by row, within the gamut.
    pixels: Vec<[f32; 3]>,
    upsampling: Upsampling,
    /// The luminance of the image.
    table: DirectionTable,
}

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

impl ImageSkyDescription {
    fn default_scale() -> Number<SkyScale> {
        Number::of(1.0)
    }
}

impl Panorama {
    /// Reads the first RGB layer of an OpenEXR file, or the first layer with luminance only, which is grey.
    ///
    /// # Errors
    ///
    /// When there is no such file, or it holds neither red, green and blue nor luminance alone.
    pub fn read_exr(files: &dyn FileSource, name: &str) -> Result<Self, SceneError> {
        let NamedFile { path, bytes } = NamedFile::read(files, name)?;
        check_formats(&path)?;
        let wrong = |reason: String| SceneError::File(FileError::Content { path: path.clone(), reason });
        // A pixel is a colour of double precision, and its colour, brightness and share of the light in single
        // precision.
        check_exr_size(&bytes, |_| size_of::<LinearRgb>() + 5 * size_of::<f32>()).map_err(wrong)?;
        let unreadable = |error: exr::error::Error| wrong(format!("not a readable EXR file: {error}"));
        let meta = MetaData::read_from_buffered(Cursor::new(&bytes), false).map_err(unreadable)?;
        let channels =
            |header: &Header| header.channels.list.iter().map(|one| one.name.to_string()).collect::<Vec<_>>();
        let has_all = |header: &Header, names: &[&str]| {
            names.iter().all(|name| channels(header).iter().any(|channel| channel == name))
        };
        if !meta.headers.iter().any(|header| has_all(header, &["R", "G", "B"])) {
            let first = meta.headers.first().map(channels).unwrap_or_default();
            // Luminance with chroma channels is not grey.
            if first != ["Y"] && first != ["A", "Y"] {
                let found = first.join(", ");
                return Err(wrong(format!("the channels are {found}, but must include R, G and B, or be Y alone")));
            }
            return Self::read_grey(&bytes).map_err(unreadable);
        }
        let image = exr::prelude::read()
            .no_deep_data()
            .largest_resolution_level()
            .rgba_channels(
                |size, _| (size.width(), vec![LinearRgb::default(); size.width() * size.height()]),
                |(width, pixels): &mut (usize, Vec<LinearRgb>), place, (r, g, b, _): (f32, f32, f32, f32)| {
                    pixels[place.y() * *width + place.x()] =
                        LinearRgb { r: f64::from(r), g: f64::from(g), b: f64::from(b) };
                },
            )
            .first_valid_layer()
            .all_attributes()
            .from_buffered(Cursor::new(bytes))
            .map_err(unreadable)?;
        let (width, pixels) = image.layer_data.channel_data.pixels;
        Ok(Self { width, height: pixels.len() / width.max(1), pixels })
    }

    /// Reads the luminance of the first layer.
    fn read_grey(bytes: &[u8]) -> exr::error::Result<Self> {
        let image = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
        let layer = image.all_attributes().from_buffered(Cursor::new(bytes))?.layer_data;
        let grey = |y: f32| LinearRgb { r: y.into(), g: y.into(), b: y.into() };
        let luminance = layer.channel_data.list.iter().find(|channel| channel.name == *"Y");
        let pixels: Vec<LinearRgb> =
            luminance.into_iter().flat_map(|y| y.sample_data.values_as_f32()).map(grey).collect();
        let width = layer.size.width();
        Ok(Self { width, height: pixels.len() / width.max(1), pixels })
    }
}

impl SkyImage {
    /// Light of an image times `scale`. The value 1 is the luminance of 1 W m⁻² sr⁻¹ of equal-energy light, as in the
    /// images that this crate writes. `rotation_deg` turns the image about z, counter-clockwise seen from above.
    ///
    /// A colour outside the sRGB gamut becomes the nearest colour of the same luminance.
    ///
    /// # Errors
    ///
    /// When a pixel is not finite or too bright, or all pixels are black.
    pub(crate) fn new(panorama: &Panorama, scale: f32, rotation_deg: f32) -> Result<Self, String> {
        let (width, height) = (panorama.width, panorama.height);
        let mut pixels = Vec::with_capacity(panorama.pixels.len());
        for (index, pixel) in panorama.pixels.iter().enumerate() {
            if ![pixel.r, pixel.g, pixel.b].iter().all(|channel| channel.is_finite()) {
                let (column, row) = (index % width, index / width);
                return Err(format!("pixel {column}, {row} is {}, {}, {}", pixel.r, pixel.g, pixel.b));
            }
            let LinearRgb { r, g, b } = pixel.into_gamut();
            let brightest = f64::from(scale) * r.max(g).max(b);
            if brightest > MAX_PIXEL {
                let (column, row) = (index % width, index / width);
                return Err(format!(
                    "pixel {column}, {row} is {brightest:.1e} with its scale, but must be at most {MAX_PIXEL:e}"
                ));
            }
            pixels.push([r, g, b].map(|channel| scale * narrow(channel)));
        }
        let upsampling = Upsampling::daylight();
        let bright: Vec<f32> = pixels.iter().map(|&pixel| luminance(pixel)).collect();
        let table = DirectionTable::new(width, bright, rotation_deg.to_radians());
        let table = table.ok_or_else(|| "the image is black".to_owned())?;
        Ok(Self { width, height, pixels, upsampling, table })
    }

    /// Bilinear interpolation between pixel centres, periodic in azimuth and constant beyond the first and last row.
    fn color(&self, direction: Vec3A) -> [f32; 3] {
        let [across, down] = self.table.place(direction).map(|place| place - 0.5);
        let (left, right) = ((across + self.width as f32).floor(), across - across.floor());
        let left = whole(left, 2 * self.width) % self.width;
        let (above, below) = (whole(down.floor(), self.height), whole(down.floor() + 1.0, self.height));
        let lower = down - down.floor();
        let mut color = [0.0; 3];
        for (row, weight_down) in [(above, 1.0 - lower), (below, lower)] {
            for (column, weight_across) in [(left, 1.0 - right), ((left + 1) % self.width, right)] {
                let pixel = self.pixels[row * self.width + column];
                for (sum, channel) in color.iter_mut().zip(pixel) {
                    *sum += weight_down * weight_across * channel;
                }
            }
        }
        color
    }
}

impl Emitter for SkyImage {
    fn name(&self) -> &'static str {
        "sky"
    }

    fn light_type(&self) -> LightType {
        LightType::Infinite
    }

    fn uniform(&self) -> Option<&Spectrum> {
        None
    }

    fn le(&self, origin: &LightOrigin) -> Spectrum {
        self.upsampling.spectrum(self.color(origin.direction()))
    }

    fn sample_li(&self, _from: Vec3A, numbers: [f32; 2]) -> Option<LightOrigin> {
        Some(LightOrigin::Distant(self.table.sample(numbers)))
    }

    fn pdf_li(&self, _from: Vec3A, origin: &LightOrigin) -> f32 {
        self.table.density_per_sr(origin.direction())
    }
}

fn luminance([r, g, b]: [f32; 3]) -> f32 {
    narrow(LinearRgb { r: f64::from(r), g: f64::from(g), b: f64::from(b) }.luminance())
}
