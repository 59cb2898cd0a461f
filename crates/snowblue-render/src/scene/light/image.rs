//! An environment image as a light: a latitude-longitude map, sampled by luminance.
//!
//! Rows run from straight up (+z) to straight down, columns around; the middle column looks along +y, and directions
//! turn clockwise to the right as seen from above, as in a view from inside. Interpolation is bilinear. The sampling
//! density is constant over each pixel's solid angle and proportional to its mean luminance: rows first, then columns,
//! by inversion of cumulative sums (Pharr, Jakob & Humphreys 2023, section A.5).

use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::io::Cursor;

use exr::prelude::{ReadChannels, ReadLayers};
use glam::Vec3A;
use snowblue_color::LinearRgb;

use crate::error::RenderError;
use crate::files::{NamedFile, SceneFiles, check_formats};
use crate::geometry::ray::narrow;
use crate::spectrum::Spectrum;
use crate::spectrum::upsampling::Upsampling;

/// Largest channel of a pixel: the limit of all lights, far below that of single precision.
const GREATEST_PIXEL: f64 = 1e12;

/// Light from all directions with the colours of an image.
#[derive(Debug)]
pub struct SkyImage {
    width: usize,
    height: usize,
    /// Linear sRGB, row by row, within the gamut.
    pixels: Vec<[f32; 3]>,
    upsampling: Upsampling,
    turn_rad: f32,
    /// Cumulative fractions of the light over the rows, and over the columns of each row.
    rows: Vec<f32>,
    columns: Vec<f32>,
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

impl Panorama {
    /// Reads the first RGB layer of an OpenEXR file.
    ///
    /// # Errors
    ///
    /// When there is no such file, or it holds no red, green and blue.
    pub fn read_exr(files: &dyn SceneFiles, name: &str) -> Result<Self, RenderError> {
        let NamedFile { path, bytes } = NamedFile::read(files, name)?;
        check_formats(&path)?;
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
            .map_err(|error| RenderError::ReadImage { path, reason: error.to_string() })?;
        let (width, pixels) = image.layer_data.channel_data.pixels;
        Ok(Self { width, height: pixels.len() / width.max(1), pixels })
    }
}

impl SkyImage {
    /// Light of an image times `scale`. The value 1 is the luminance of 1 W m⁻² sr⁻¹ of equal-energy light, as in the
    /// images that this crate writes. `rotation_deg` turns it about z, counter-clockwise seen from above.
    ///
    /// Colours outside the sRGB gamut become the nearest of their luminance. Without `daylight` all colours are grey,
    /// for false colours.
    ///
    /// # Errors
    ///
    /// When a pixel is not finite or too bright, or all are black.
    pub fn new(panorama: &Panorama, scale: f32, rotation_deg: f32, daylight: bool) -> Result<Self, String> {
        let (width, height) = (panorama.width, panorama.height);
        let mut pixels = Vec::with_capacity(panorama.pixels.len());
        for (index, pixel) in panorama.pixels.iter().enumerate() {
            if ![pixel.r, pixel.g, pixel.b].iter().all(|channel| channel.is_finite()) {
                let (column, row) = (index % width, index / width);
                return Err(format!("pixel {column}, {row} is {}, {}, {}", pixel.r, pixel.g, pixel.b));
            }
            let LinearRgb { r, g, b } = pixel.into_gamut();
            let brightest = f64::from(scale) * r.max(g).max(b);
            if brightest > GREATEST_PIXEL {
                let (column, row) = (index % width, index / width);
                return Err(format!(
                    "pixel {column}, {row} is {brightest:.1e} with its scale, but must be at most {GREATEST_PIXEL:e}"
                ));
            }
            pixels.push([r, g, b].map(|channel| scale * narrow(channel)));
        }
        let upsampling = if daylight { Upsampling::daylight() } else { Upsampling::grey() };
        let turn_rad = rotation_deg.to_radians();
        let mut image = Self { width, height, pixels, upsampling, turn_rad, rows: Vec::new(), columns: Vec::new() };
        image.tabulate().then_some(image).ok_or_else(|| "the image is black".into())
    }

    /// The radiance that comes from a direction.
    pub(super) fn radiance(&self, direction: Vec3A) -> Spectrum {
        self.upsampling.spectrum(self.color(direction))
    }

    /// The spectrum of the radiance from a direction scaled to luminance 1; zero where the image is black.
    pub(super) fn relative(&self, direction: Vec3A) -> Spectrum {
        let color = self.color(direction);
        let luminance = luminance(color);
        if luminance > 0.0 { self.upsampling.spectrum(color) * luminance.recip() } else { Spectrum::ZERO }
    }

    /// A direction with the density [`density_per_sr`](Self::density_per_sr).
    pub(super) fn sample(&self, [u, v]: [f32; 2]) -> Vec3A {
        let (row, down) = invert(&self.rows, v);
        let (column, across) = invert(&self.columns[row * self.width..][..self.width], u);
        let (top, bottom) = self.edge_cosines(row);
        let z = top + (bottom - top) * down;
        let longitude = FRAC_PI_2 - TAU * ((column as f32 + across) / self.width as f32 - 0.5) + self.turn_rad;
        let radius = (1.0 - z * z).max(0.0).sqrt();
        Vec3A::new(radius * longitude.cos(), radius * longitude.sin(), z)
    }

    /// Density of [`sample`](Self::sample), in 1/sr.
    pub(super) fn density_per_sr(&self, direction: Vec3A) -> f32 {
        let [across, down] = self.place(direction);
        let (column, row) = (whole(across, self.width), whole(down, self.height));
        let (top, bottom) = self.edge_cosines(row);
        let share = step(&self.rows, row) * step(&self.columns[row * self.width..][..self.width], column);
        share * self.width as f32 / (TAU * (top - bottom))
    }

    /// Position of a direction in the image, in pixels from its upper left corner.
    fn place(&self, direction: Vec3A) -> [f32; 2] {
        let longitude = direction.y.atan2(direction.x) - self.turn_rad;
        let across = (0.5 + (FRAC_PI_2 - longitude) / TAU).rem_euclid(1.0);
        let down = direction.z.clamp(-1.0, 1.0).acos() / PI;
        [across * self.width as f32, down * self.height as f32]
    }

    /// Bilinear interpolation between pixel centres, periodic in azimuth and constant beyond the first and last row.
    fn color(&self, direction: Vec3A) -> [f32; 3] {
        let [across, down] = self.place(direction).map(|place| place - 0.5);
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

    /// Cosine of the polar angle at the upper and the lower edge of a row.
    fn edge_cosines(&self, row: usize) -> (f32, f32) {
        let z = |edge: usize| (PI * edge as f32 / self.height as f32).cos();
        (z(row), z(row + 1))
    }

    /// Fills the cumulative sums. Returns false if the image is black.
    fn tabulate(&mut self) -> bool {
        let (width, height) = (self.width, self.height);
        let bright: Vec<f32> = self.pixels.iter().map(|&pixel| luminance(pixel)).collect();
        let mut row_weights = Vec::with_capacity(height);
        self.columns = Vec::with_capacity(width * height);
        for row in 0..height {
            // Mean of the bilinear interpolation over a pixel: weights 1/8, 6/8, 1/8 along both axes.
            let rows = [(row.saturating_sub(1), 0.125), (row, 0.75), ((row + 1).min(height - 1), 0.125)];
            let at =
                |column: usize| -> f32 { rows.iter().map(|(row, share)| share * bright[row * width + column]).sum() };
            let weights = (0..width).map(|column| {
                0.125 * at((column + width - 1) % width) + 0.75 * at(column) + 0.125 * at((column + 1) % width)
            });
            let (total, shares) = cumulative(weights);
            self.columns.extend(shares);
            let (top, bottom) = self.edge_cosines(row);
            row_weights.push(narrow(total) * (top - bottom));
        }
        let (total, rows) = cumulative(row_weights.into_iter());
        self.rows = rows;
        total > 0.0
    }
}

fn luminance([r, g, b]: [f32; 3]) -> f32 {
    narrow(LinearRgb { r: f64::from(r), g: f64::from(g), b: f64::from(b) }.luminance())
}

/// The sum of weights, and their cumulative fractions.
fn cumulative(weights: impl Iterator<Item = f32>) -> (f64, Vec<f32>) {
    let mut total = 0.0;
    let sums: Vec<f64> = weights
        .map(|weight| {
            total += f64::from(weight);
            total
        })
        .collect();
    (total, sums.into_iter().map(|sum| if total > 0.0 { narrow(sum / total) } else { 0.0 }).collect())
}

/// The step of a cumulative sum that contains a number in [0, 1), and the position within it.
fn invert(sums: &[f32], u: f32) -> (usize, f32) {
    let index = sums.partition_point(|&sum| sum <= u).min(sums.len() - 1);
    let before = if index == 0 { 0.0 } else { sums[index - 1] };
    (index, ((u - before) / (sums[index] - before)).min(1.0))
}

/// The fraction of one step.
fn step(sums: &[f32], index: usize) -> f32 {
    sums[index] - if index == 0 { 0.0 } else { sums[index - 1] }
}

/// Pixel index of a coordinate, clamped to 0..`count`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "kept within the pixels")]
fn whole(place: f32, count: usize) -> usize {
    (place.max(0.0) as usize).min(count - 1)
}
