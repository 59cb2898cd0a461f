//! An environment image as a light: a latitude-longitude map, sampled by luminance.
//!
//! Pixels lie as in a [table of directions](super::direction_table). Interpolation is bilinear.

use std::sync::Arc;

use glam::Vec3A;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use snowblue_color::LinearRgb;
use snowblue_geometry::ray::Ray;

use crate::light::direction_table::{DirectionTable, whole};
use crate::light::emitter::{Emitter, LightType};
use crate::light::keys::{PixelValue, SkyScale};
use crate::light::panorama::Panorama;
use crate::light::sample::LightOrigin;
use crate::spectrum::Spectrum;
use crate::spectrum::upsampling::Upsampling;
use crate::values::{Rotation, visible};
use snowblue_base::{Number, narrow};

/// Largest channel of a pixel. This is the limit of all lights, far below the limit of single precision.
const MAX_PIXEL: f64 = 1e12;
/// Luminance up to which rays find the light of an image by chance, relative to the mean over all directions.
const FAINT_OF_MEAN: f32 = 4.0;

/// Light of an image of all directions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImageSkyDescription {
    /// An OpenEXR or Radiance file, latitude by longitude.
    pub image: String,
    /// The layer of an OpenEXR file that is the image: a part, or the channels whose names begin with this name and a
    /// point; by default the first channels R, G and B, or Y alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layer: Option<String>,
    /// Multiplies the image.
    #[serde(default = "ImageSkyDescription::default_scale")]
    pub scale: Number<SkyScale>,
    /// Greatest value of a channel of the file, before `scale`: brighter channels, and infinite channels, get this
    /// value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_radiance: Option<Number<PixelValue>>,
    /// Turns the image about z, counter-clockwise seen from above, in degrees.
    #[serde(default)]
    pub rotation_deg: Number<Rotation>,
    /// Whether it is visible to the camera.
    #[serde(default = "visible")]
    pub visible: bool,
}

/// Light from all directions with the colours of an image, or a part of this light.
#[derive(Debug)]
pub(crate) struct SkyImage {
    image: Arc<Image>,
    part: Part,
    /// The luminance of this part.
    table: DirectionTable,
}

/// An image as a light.
#[derive(Debug)]
struct Image {
    width: usize,
    height: usize,
    /// Linear sRGB, row by row, within the gamut.
    pixels: Vec<[f32; 3]>,
    turn_rad: f32,
    upsampling: Upsampling,
}

/// A part of the light of each pixel. The faint part and the bright part add up to the whole.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Part {
    Whole,
    /// Up to a luminance.
    Faint(f32),
    /// Beyond a luminance.
    Bright(f32),
}

impl Part {
    fn of(self, pixel: [f32; 3]) -> [f32; 3] {
        let faint = |limit: f32| (limit / luminance(pixel).max(f32::MIN_POSITIVE)).min(1.0);
        let share = match self {
            Self::Whole => return pixel,
            Self::Faint(limit) => faint(limit),
            Self::Bright(limit) => 1.0 - faint(limit),
        };
        pixel.map(|channel| share * channel)
    }
}

impl ImageSkyDescription {
    fn default_scale() -> Number<SkyScale> {
        Number::of(1.0)
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
    /// When a pixel is too bright, or all pixels are black.
    pub(crate) fn new(panorama: &Panorama, scale: f32, rotation_deg: f32) -> Result<Self, String> {
        let (width, height) = (panorama.width, panorama.height);
        let mut pixels = Vec::with_capacity(panorama.pixels.len());
        for (index, pixel) in panorama.pixels.iter().enumerate() {
            let LinearRgb { r, g, b } = pixel.into_gamut();
            let brightest = f64::from(scale) * r.max(g).max(b);
            if brightest > MAX_PIXEL {
                let (column, row) = (index % width, index / width);
                return Err(format!(
                    "pixel {column}, {row} is {brightest:.1e} with its scale, but must be at most {MAX_PIXEL:e}; \
                     `max_radiance` limits it"
                ));
            }
            pixels.push([r, g, b].map(|channel| scale * narrow(channel)));
        }
        let turn_rad = rotation_deg.to_radians();
        let image = Arc::new(Image { width, height, pixels, turn_rad, upsampling: Upsampling::daylight() });
        Self::part(image, Part::Whole).ok_or_else(|| "the image is black".to_owned())
    }

    /// A part of an image; none if it is black.
    fn part(image: Arc<Image>, part: Part) -> Option<Self> {
        let bright = image.pixels.iter().map(|&pixel| luminance(part.of(pixel))).collect();
        let table = DirectionTable::new(image.width, bright, image.turn_rad)?;
        Some(Self { image, part, table })
    }

    /// Bilinear interpolation between pixel centres, periodic in azimuth and constant beyond the first and last row.
    fn color(&self, direction: Vec3A) -> [f32; 3] {
        let [across, down] = self.table.place(direction).map(|place| place - 0.5);
        let Image { width, height, pixels, .. } = &*self.image;
        let (left, right) = ((across + *width as f32).floor(), across - across.floor());
        let left = whole(left, 2 * width) % width;
        let (above, below) = (whole(down.floor(), *height), whole(down.floor() + 1.0, *height));
        let lower = down - down.floor();
        let mut color = [0.0; 3];
        for (row, weight_down) in [(above, 1.0 - lower), (below, lower)] {
            for (column, weight_across) in [(left, 1.0 - right), ((left + 1) % width, right)] {
                let pixel = self.part.of(pixels[row * width + column]);
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
        match self.part {
            Part::Whole | Part::Faint(_) => LightType::Infinite,
            Part::Bright(_) => LightType::Disc(self.table.sample([0.5; 2])),
        }
    }

    fn le(&self, origin: &LightOrigin) -> Spectrum {
        self.image.upsampling.spectrum(self.color(origin.direction()))
    }

    fn table(&self) -> Option<&DirectionTable> {
        Some(&self.table)
    }

    fn hit(&self, ray: &Ray, _limit_m: f32) -> Option<LightOrigin> {
        Some(LightOrigin::Distant(ray.direction))
    }

    fn parts(&self) -> Option<[Arc<dyn Emitter>; 2]> {
        let limit = FAINT_OF_MEAN * self.table.mean();
        let [faint, bright] =
            [Part::Faint(limit), Part::Bright(limit)].map(|part| Self::part(Arc::clone(&self.image), part));
        Some([Arc::new(faint?), Arc::new(bright?)])
    }
}

fn luminance([r, g, b]: [f32; 3]) -> f32 {
    narrow(LinearRgb { r: f64::from(r), g: f64::from(g), b: f64::from(b) }.luminance())
}
