//! The reference of a scene with its noise, and how far an image is from it.

use snowblue_color::{ColorDifference, Lab, Xyz};
use snowblue_render::Exposure;
use snowblue_render::Integrator;

use super::image::{PARTS, TimedImage, cells, film, render_timed};

/// Renderings with different seeds whose mean is the reference.
pub(super) const SEEDS: u32 = 4;
/// Cells below this fraction of the greatest luminance are not compared.
const LEAST_FRACTION: f64 = 0.01;
/// Least ratio of luminances that counts, for cells that are black in the compared image.
const LEAST_RATIO: f64 = 1e-3;

/// The mean of several path-traced renderings, and its noise.
pub(super) struct Reference {
    pub(super) mean: TimedImage,
    pub(super) cells: Vec<Xyz>,
    /// Relative standard error of the luminance of each cell.
    pub(super) noise: Vec<f64>,
    /// Mean CIEDE2000 that comes from noise alone.
    pub(super) noise_delta_e: f64,
    /// Indices of the cells that are compared.
    pub(super) lit_cells: Vec<usize>,
    /// Luminance of each of [`PARTS`].
    pub(super) parts: Vec<PartLuminance>,
    /// The light that is white at the scene's exposure.
    white: Xyz,
}

/// Mean luminance of a part of the reference.
pub(super) struct PartLuminance {
    pub(super) luminance: f64,
    pub(super) relative_error: f64,
}

/// How far an image is from the reference.
pub(super) struct Comparison {
    /// 5 %, median and 95 % of the ratios of luminance.
    pub(super) ratios: [f64; 3],
    /// Mean square of the logarithm of the ratio, less that of the noise.
    pub(super) mean_square_log: f64,
    /// Total light over that of the reference.
    pub(super) energy: f64,
    /// Mean CIEDE2000 at the reference's exposure.
    pub(super) delta_e: f64,
    /// CIEDE2000 of the total light at L* = 50: hue and chroma.
    pub(super) hue_delta_e: f64,
    pub(super) seconds: f64,
}

impl Reference {
    /// Renders a scene with each seed.
    pub(super) fn render(integrator: &mut Integrator, white: Xyz) -> Self {
        let images: Vec<TimedImage> = (1..=SEEDS)
            .map(|seed| {
                integrator.set_seed(seed);
                render_timed(integrator)
            })
            .collect();
        let mean_of = |chosen: &[TimedImage]| -> Vec<Xyz> {
            let sum = |pixel: usize| chosen.iter().fold(Xyz::default(), |sum, image| sum + image.pixels[pixel]);
            (0..images[0].pixels.len()).map(|pixel| sum(pixel) * (chosen.len() as f64).recip()).collect()
        };
        let pixels = mean_of(&images);
        let means = cells(&pixels);
        let single: Vec<Vec<Xyz>> = images.iter().map(|image| cells(&image.pixels)).collect();
        let count = f64::from(SEEDS);
        let relative_error = |mean: f64, single: &dyn Fn(usize) -> f64| {
            let squares: f64 = (0..images.len()).map(|image| (single(image) - mean).powi(2)).sum();
            (squares / (count * (count - 1.0))).sqrt() / mean
        };
        let noise = means.iter().enumerate().map(|(cell, mean)| relative_error(mean.y, &|image| single[image][cell].y));
        let noise = noise.collect();
        let parts = PARTS.iter().map(|part| {
            let luminance = part.luminance(&pixels);
            let relative_error = relative_error(luminance, &|image| part.luminance(&images[image].pixels));
            PartLuminance { luminance, relative_error }
        });
        let parts = parts.collect();
        let brightest = means.iter().map(|xyz| xyz.y).fold(0.0, f64::max);
        let lit_cells: Vec<usize> =
            (0..means.len()).filter(|cell| means[*cell].y > LEAST_FRACTION * brightest).collect();
        let exposure = film(&pixels).display_factor(Exposure::Auto);
        let white = white * exposure.recip();
        // Two halves differ from each other twice as much as their mean differs from the truth.
        let (first, second) = images.split_at(images.len() / 2);
        let halves = [first, second].map(|half| cells(&mean_of(half)));
        let noise_delta_e = 0.5 * mean_delta_e(&halves[0], &halves[1], &lit_cells, white);
        let seconds = images.iter().map(|image| image.seconds).sum();
        let mean = TimedImage { pixels, seconds };
        Self { mean, cells: means, noise, noise_delta_e, lit_cells, parts, white }
    }

    /// Compares an image with the reference.
    pub(super) fn compare(&self, image: &TimedImage) -> Comparison {
        let light = cells(&image.pixels);
        let ratio = |cell: usize| light[cell].y / self.cells[cell].y;
        let mut ratios: Vec<f64> = self.lit_cells.iter().map(|cell| ratio(*cell)).collect();
        ratios.sort_by(f64::total_cmp);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a fraction of a number of cells")]
        let quantile = |fraction: f64| ratios[((ratios.len() - 1) as f64 * fraction).round() as usize];
        let square = |cell: &usize| ratio(*cell).max(LEAST_RATIO).ln().powi(2) - self.noise[*cell].powi(2);
        let sum = |pixels: &[Xyz]| pixels.iter().fold(Xyz::default(), |sum, xyz| sum + *xyz);
        let (total, expected) = (sum(&light), sum(&self.cells));
        Comparison {
            ratios: [quantile(0.05), quantile(0.5), quantile(0.95)],
            mean_square_log: self.lit_cells.iter().map(square).sum::<f64>() / self.lit_cells.len() as f64,
            energy: total.y / expected.y,
            delta_e: mean_delta_e(&light, &self.cells, &self.lit_cells, self.white),
            hue_delta_e: ColorDifference::between(total, expected, self.white).at_middle_grey_2000,
            seconds: image.seconds,
        }
    }
}

/// Mean CIEDE2000 of two images over some cells.
fn mean_delta_e(one: &[Xyz], other: &[Xyz], chosen: &[usize], white: Xyz) -> f64 {
    let lab = |xyz: Xyz| Lab::from_xyz(xyz, white);
    let sum: f64 = chosen.iter().map(|cell| lab(one[*cell]).delta_e_2000(lab(other[*cell]))).sum();
    sum / chosen.len() as f64
}
