//! The means of an image as named channels.
//!
//! Every image has the channels `R`, `G` and `B`, and the channels of its AOVs under names that other programs know.
//! Mattes have as many layers as the pixel with most identifiers needs.
//! The spectrum follows Fichet, Pacanowski & Wilkie (2021, "An OpenEXR layout for spectral images", Journal of
//! Computer Graphics Techniques 10(3), 1–18): `S0.400,000000nm` and so on, in W m⁻² sr⁻¹ nm⁻¹.

use rayon::prelude::*;
use snowblue_base::narrow;
use snowblue_color::LinearRgb;

use crate::film::accumulator::{FilmAccumulator, PixelSums};
use crate::film::aov::Aov;
use crate::film::cryptomatte::Matte;
use crate::film::residual_filter::Filtered;
use crate::film::{Film, Shown};
use snowblue_scene::spectrum::{SAMPLES, WAVELENGTH_STEP_NM, wavelengths_nm};

/// A channel of an image.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Its name.
    pub name: String,
    /// A value for each pixel of the window, row by row from the upper left.
    pub values: Vec<f32>,
}

/// Content of a channel for each pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mean {
    /// Red, green or blue.
    Rgb(usize),
    /// Radiance at a wavelength, as a multiple of the band density.
    Radiance { wavelength: usize, factor: f32 },
    /// Variance of the mean of red, green or blue.
    Variance(usize),
    /// A value of an AOV.
    Aov(Aov, usize),
    /// The identifier or the coverage of a rank of mattes.
    Matte { matte: Matte, rank: usize, value: usize },
}

impl Mean {
    /// The value of a pixel, with the changes of the filter.
    pub(crate) fn of(self, pixel: &PixelSums, changes: &[f32]) -> f32 {
        match self {
            Self::Rgb(channel) => {
                let LinearRgb { r, g, b } = LinearRgb::from_xyz(pixel.filtered_xyz(changes));
                narrow([r, g, b][channel])
            }
            Self::Radiance { wavelength, factor } => pixel.radiance(wavelength, changes) * factor,
            Self::Variance(channel) => pixel.variance()[channel],
            Self::Aov(aov, value) => pixel.aov(aov, value),
            Self::Matte { matte, rank, value } => {
                pixel.matte(matte).and_then(|counts| counts.ranked().get(rank).copied()).map_or(0.0, |at| at[value])
            }
        }
    }
}

/// Name and content of each channel of an image.
pub(crate) fn means(accumulator: &FilmAccumulator) -> Vec<(String, Mean)> {
    let rgb = |prefix: &'static str, mean: fn(usize) -> Mean| {
        ["R", "G", "B"].into_iter().enumerate().map(move |(k, name)| (format!("{prefix}{name}"), mean(k)))
    };
    let mut means: Vec<(String, Mean)> = rgb("", Mean::Rgb).collect();
    let aovs = accumulator.aovs();
    if aovs.spectrum {
        // A band density is a spectral radiance times the width of all bands.
        let factor = narrow((SAMPLES as f64 * WAVELENGTH_STEP_NM).recip());
        let name = |nm: f64| format!("S0.{}nm", format!("{nm:.6}").replace('.', ","));
        let wavelengths = wavelengths_nm().into_iter().enumerate();
        means.extend(wavelengths.map(|(wavelength, nm)| (name(nm), Mean::Radiance { wavelength, factor })));
    }
    if aovs.variance {
        means.extend(rgb("variance.", Mean::Variance));
    }
    for aov in aovs.of_first_surface() {
        let names = aov.channel_names().iter().enumerate();
        means.extend(names.map(|(value, name)| ((*name).to_owned(), Mean::Aov(aov, value))));
    }
    for matte in aovs.mattes() {
        // Two identifiers of a layer, each followed by its coverage.
        let layers = accumulator.most_in_mattes(matte, |counts| counts.ranked().len()).div_ceil(2).max(1);
        let channels = ["R", "G", "B", "A"].into_iter().enumerate();
        means.extend((0..layers).flat_map(|layer| channels.clone().map(move |place| (layer, place))).map(
            |(layer, (place, name))| {
                let mean = Mean::Matte { matte, rank: 2 * layer + place / 2, value: place % 2 };
                (format!("{}{layer:02}.{name}", matte.layer()), mean)
            },
        ));
    }
    means
}

/// The channels of colours and AOVs.
pub fn channels(accumulator: &FilmAccumulator) -> Vec<Channel> {
    let filtered = Filtered::new(accumulator);
    let pixels = accumulator.all_pixels();
    let changes = |index: usize| Filtered::changes(filtered.as_ref(), index);
    let values = |mean: Mean| pixels.iter().enumerate().map(|(index, pixel)| mean.of(pixel, changes(index))).collect();
    means(accumulator).into_iter().map(|(name, mean)| Channel { name, values: values(mean) }).collect()
}

impl FilmAccumulator {
    /// The image of the window: the mean of each pixel's samples. The noise of random walks is filtered if there are
    /// sums for the filter. Pixels without samples are black.
    pub fn film(&self) -> Film {
        let filtered = Filtered::new(self);
        let pixels = self.all_pixels();
        let changes = |index: usize| Filtered::changes(filtered.as_ref(), index);
        let colours = pixels.par_iter().enumerate().map(|(index, pixel)| pixel.filtered_xyz(changes(index)));
        let shown =
            |pixel: &PixelSums| Shown { snow: pixel.aov(Aov::Snow, 0), emitter: pixel.aov(Aov::Emitter, 0) > 0.0 };
        Film::new(self.window().size(), colours.collect()).with_shown(pixels.iter().map(shown).collect())
    }
}
