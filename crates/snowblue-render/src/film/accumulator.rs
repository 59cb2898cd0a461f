//! The light of a picture, added up exactly.
//!
//! Each sample is rounded to a multiple of 2⁻⁶⁴ and added as an integer, so that neither order nor grouping changes a bit:
//! samples may come on any thread, in any range, in any file. 2⁻⁶⁴ is 5·10⁻²⁰ of the film's unit; a sample of 10⁻¹⁰, light
//! behind metres of snow, keeps nine digits. A sample may carry up to 2³³/31 = 2.8·10⁸ W m⁻² sr⁻¹, ten times what the sun's
//! disc has, and 2³⁰ such samples fit into a sum. One brighter than that, or one that is not a number, counts as dark and is
//! reported ([`Statistics::unusable_samples`](crate::scene::queries::Statistics)).
//!
//! Squares, for variances, are multiples of 2⁻⁷⁶ ≈ 10⁻²³ and may add up to 2⁵¹ ≈ 2·10¹⁵, where their sum stays:
//! such a variance is told as infinite.

use snowblue_color::{LinearRgb, Xyz};

use crate::film::Film;
use crate::film::aov::{Aov, Aovs};
use crate::film::sample_block::{Coverage, SampleBlock, Window, width};
use crate::geometry::ray::narrow;
use crate::scene::Scene;
use crate::spectrum::SAMPLES;

/// Units of a sum in 1.
pub(crate) const UNITS: f64 = (1u128 << 64) as f64;
/// Units of a sum of squares in 1.
pub(crate) const SQUARE_UNITS: f64 = (1u128 << 76) as f64;

/// Sums over the samples of some pixels of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmAccumulator {
    size: (u32, u32),
    /// The pixels that there is room for.
    window: Window,
    channels: Aovs,
    wavelengths_nm: [f64; SAMPLES],
    coverage: Coverage,
    /// Pixel by pixel, row by row.
    sums: Vec<i128>,
}

impl FilmAccumulator {
    /// No samples yet, with room for some pixels of a scene's picture.
    pub fn new(scene: &Scene, channels: Aovs, window: &Window) -> Self {
        let size = (scene.film.width, scene.film.height);
        Self::empty(size, channels, *scene.sensor.wavelengths_nm(), window)
    }

    /// No samples yet, of a picture of a size in pixels.
    ///
    /// # Panics
    ///
    /// When the window reaches beyond the picture.
    pub fn empty(size: (u32, u32), channels: Aovs, wavelengths_nm: [f64; SAMPLES], window: &Window) -> Self {
        assert!(window.columns.end <= size.0 && window.rows.end <= size.1, "the window lies within the picture");
        let pixels = window.width() as usize * window.height() as usize;
        Self {
            size,
            window: window.clone(),
            channels,
            wavelengths_nm,
            coverage: Coverage::default(),
            sums: vec![0; pixels * channels.sums().len()],
        }
    }

    /// Size of the whole picture in pixels.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// The pixels that there is room for.
    pub fn window(&self) -> &Window {
        &self.window
    }

    /// What is summed beside colours.
    pub fn channels(&self) -> Aovs {
        self.channels
    }

    /// The wavelengths of the spectrum, in nm.
    pub fn wavelengths_nm(&self) -> &[f64; SAMPLES] {
        &self.wavelengths_nm
    }

    /// The samples that are in the sums.
    pub fn coverage(&self) -> &Coverage {
        &self.coverage
    }

    /// Fewest and most samples of a pixel of the window.
    pub fn samples_per_pixel(&self) -> (u64, u64) {
        let counts = self.sample_counts();
        counts.iter().fold((u64::MAX, 0), |(least, most), &count| (least.min(count), most.max(count)))
    }

    /// Column and row of the first pixel of the window that has no sample.
    pub fn first_empty_pixel(&self) -> Option<(u32, u32)> {
        let place = self.sample_counts().iter().position(|count| *count == 0)?;
        let place = u32::try_from(place).ok()?;
        let (row, column) = (place / self.window.width(), place % self.window.width());
        Some((self.window.columns.start + column, self.window.rows.start + row))
    }

    /// Samples of each pixel of the window, row by row.
    fn sample_counts(&self) -> Vec<u64> {
        let columns = self.window.width() as usize;
        let mut counts = vec![0; columns * self.window.height() as usize];
        for SampleBlock { columns: covered, rows, samples } in self.coverage.portions() {
            for row in rows.clone() {
                let start = (row - self.window.rows.start) as usize * columns;
                let [first, end] = [covered.start, covered.end].map(|at| (at - self.window.columns.start) as usize);
                let count = u64::from(width(samples));
                counts[start + first..start + end].iter_mut().for_each(|sum| *sum += count);
            }
        }
        counts
    }

    /// The same sums with room for more pixels.
    #[must_use]
    pub fn widened(self, other: &Window) -> Self {
        if self.window.holds(other) {
            return self;
        }
        let window = self.window.enclosing(other);
        let mut wide = Self::empty(self.size, self.channels, self.wavelengths_nm, &window);
        wide.add(&self);
        wide
    }

    /// Adds the samples of another part of the picture, within the window.
    ///
    /// # Panics
    ///
    /// When the parts are not of one picture, the window has no room, or a sample is in both.
    pub fn add(&mut self, other: &Self) {
        assert!(self.size == other.size && self.channels == other.channels, "parts are of one picture");
        assert_eq!(self.coverage.overlap(&other.coverage), None, "no sample counts twice");
        let planes = self.channels.sums().len();
        let row_length = planes * other.window.width() as usize;
        let offset = planes * (other.window.columns.start - self.window.columns.start) as usize;
        for (row, added) in other.window.rows.clone().zip(other.sums.chunks_exact(row_length)) {
            let sums = &mut self.row_mut(row)[offset..offset + row_length];
            sums.iter_mut().zip(added).for_each(|(sum, term)| *sum = sum.saturating_add(*term));
        }
        other.coverage.portions().iter().for_each(|portion| self.coverage.add(portion.clone()));
    }

    fn row_mut(&mut self, row: u32) -> &mut [i128] {
        let length = self.channels.sums().len() * self.window.width() as usize;
        let start = (row - self.window.rows.start) as usize * length;
        &mut self.sums[start..start + length]
    }

    /// All sums, and how many belong to a row of pixels.
    pub(crate) fn rows_mut(&mut self) -> (&mut [i128], usize) {
        let length = self.channels.sums().len() * self.window.width() as usize;
        (&mut self.sums, length)
    }

    /// Notes that the samples of a portion have been added.
    pub(crate) fn note(&mut self, portion: SampleBlock) {
        self.coverage.add(portion);
    }

    /// One of the sums of a pixel, for all pixels.
    pub(crate) fn plane(&self, place: usize) -> impl ExactSizeIterator<Item = i128> {
        self.sums.iter().skip(place).step_by(self.channels.sums().len()).copied()
    }

    /// Puts one of the sums of a pixel in, for all pixels.
    pub(crate) fn restore(&mut self, place: usize, values: impl Iterator<Item = i128>) {
        let planes = self.channels.sums().len();
        let sums = self.sums.iter_mut().skip(place).step_by(planes);
        sums.zip(values).for_each(|(sum, value)| *sum = value);
    }

    /// The picture of the window: the mean of each pixel's samples; dark where there are none.
    pub fn film(&self) -> Film {
        let planes = self.channels.sums().len();
        let mean = |(sums, count): (&[i128], u64)| {
            let [x, y, z] = [sums[0], sums[1], sums[2]].map(|sum| mean(sum, count));
            Xyz { x, y, z }
        };
        let pixels = self.sums.chunks_exact(planes).zip(self.sample_counts()).map(mean).collect();
        Film::new(self.window.width(), self.window.height(), pixels)
    }

    /// Mean radiance at a wavelength, of each pixel, as a band density in W m⁻² sr⁻¹.
    pub(crate) fn radiance(&self, wavelength: usize) -> Vec<f32> {
        let sums = self.plane(3 + wavelength);
        sums.zip(self.sample_counts()).map(|(sum, count)| narrow(mean(sum, count))).collect()
    }

    /// Mean of one value of a feature over the samples that had it, of each pixel; 0 where none had.
    pub(crate) fn feature(&self, feature: Aov, value: usize) -> Vec<f32> {
        let Some(place) = self.channels.place(feature) else { return Vec::new() };
        let counts = self.plane(place);
        self.plane(place + 1 + value).zip(counts).map(|(sum, count)| narrow(quotient(sum, count))).collect()
    }

    /// Variance of the mean of red, green and blue, of each pixel: s²/n. Infinite where a pixel has one sample only, or its
    /// squares are beyond all measure.
    pub(crate) fn variance(&self) -> [Vec<f32>; 3] {
        let Some(place) = self.channels.squares() else { return Default::default() };
        let planes = self.channels.sums().len();
        let mut variances = [(); 3].map(|()| Vec::new());
        for (sums, count) in self.sums.chunks_exact(planes).zip(self.sample_counts()) {
            let [x, y, z] = [sums[0], sums[1], sums[2]].map(|sum| mean(sum, count));
            let LinearRgb { r, g, b } = LinearRgb::from_xyz(Xyz { x, y, z });
            for (channel, mean) in [r, g, b].into_iter().enumerate() {
                let (squares, count) = (sums[place + channel], count as f64);
                let spread = (squares as f64 / SQUARE_UNITS / count - mean * mean).max(0.0);
                let known = squares < i128::MAX && count > 1.5;
                variances[channel].push(if known { narrow(spread / (count - 1.0)) } else { f32::INFINITY });
            }
        }
        variances
    }
}

/// A sum over its number of samples; 0 for none.
fn mean(sum: i128, count: u64) -> f64 {
    if count == 0 { 0.0 } else { sum as f64 / UNITS / count as f64 }
}

/// A sum over a sum; 0 for none.
fn quotient(sum: i128, count: i128) -> f64 {
    if count == 0 { 0.0 } else { sum as f64 / count as f64 }
}
