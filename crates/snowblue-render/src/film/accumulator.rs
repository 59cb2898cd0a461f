//! Exact sums over the samples of an image.
//!
//! Each sample is rounded to a multiple of 2⁻⁶⁴ and added as an integer, so the sums have the same bits in any order
//! and grouping of the samples: on any number of threads, in any ranges of samples, from any number of files.
//!
//! 2⁻⁶⁴ is 5·10⁻²⁰ of the film's unit: a sample of 10⁻¹⁰, light through metres of snow, keeps nine digits. A sample may
//! have up to 2³³/31 = 2.8·10⁸ W m⁻² sr⁻¹, ten times the radiance of the sun's disc, and a sum holds 2³⁰ such samples.
//! A brighter sample, or one that is not finite, counts as black and as an unusable sample.
//!
//! Sums of squares, for variances, are multiples of 2⁻⁷⁶ ≈ 10⁻²³ and saturate at 2⁵¹ ≈ 2·10¹⁵. The variance is then
//! infinite.

use rayon::prelude::*;
use snowblue_color::{LinearRgb, Xyz};
use snowblue_geometry::ray::narrow;

use crate::film::Film;
use crate::film::aov::{Aov, Aovs, SPECTRUM_OFFSET};
use crate::film::sample_block::{Coverage, SampleBlock};
use crate::film::window::{Window, range_length};
use crate::raster::{ImageSize, PixelPosition};
use crate::spectrum::SAMPLES;

/// Units of a sum in 1.
pub(crate) const UNITS: f64 = (1u128 << 64) as f64;
/// Units of a sum of squares in 1.
pub(crate) const SQUARE_UNITS: f64 = (1u128 << 76) as f64;

/// Sums over the samples of a window of an image, and which samples they include.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmAccumulator {
    image_size: ImageSize,
    window: Window,
    aovs: Aovs,
    wavelengths_nm: [f64; SAMPLES],
    coverage: Coverage,
    /// The sums of each pixel, in the layout of [`Aovs`], row by row.
    sums: Vec<i128>,
}

/// Memory of the sums of a window, in bytes.
pub fn memory_bytes(window: &Window, aovs: Aovs) -> u64 {
    let bytes_per_pixel = aovs.sum_count() * size_of::<i128>();
    window.size().pixel_count() as u64 * bytes_per_pixel as u64
}

/// The range of the number of samples per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleCounts {
    /// Samples of the pixel that has fewest.
    pub fewest: u64,
    /// Samples of the pixel that has most.
    pub most: u64,
}

impl FilmAccumulator {
    /// An accumulator without samples for a window of an image. [`render::accumulator`](crate::render::accumulator)
    /// makes one for a scene.
    ///
    /// # Panics
    ///
    /// When the window reaches beyond the image.
    pub fn new(image_size: ImageSize, window: &Window, aovs: Aovs, wavelengths_nm: &[f64; SAMPLES]) -> Self {
        assert!(Window::of_image(image_size).contains(window), "the window lies within the image");
        Self {
            image_size,
            window: window.clone(),
            aovs,
            wavelengths_nm: *wavelengths_nm,
            coverage: Coverage::default(),
            sums: vec![0; window.size().pixel_count() * aovs.sum_count()],
        }
    }

    /// Size of the whole image.
    pub fn image_size(&self) -> ImageSize {
        self.image_size
    }

    /// The pixels that have sums.
    pub fn window(&self) -> &Window {
        &self.window
    }

    /// The values that are summed beside colours.
    pub fn aovs(&self) -> Aovs {
        self.aovs
    }

    /// The wavelengths of the spectrum, in nm.
    pub fn wavelengths_nm(&self) -> &[f64; SAMPLES] {
        &self.wavelengths_nm
    }

    /// The samples that the sums include.
    pub fn coverage(&self) -> &Coverage {
        &self.coverage
    }

    /// Fewest and most samples of a pixel of the window.
    pub fn samples_per_pixel(&self) -> SampleCounts {
        let none = SampleCounts { fewest: u64::MAX, most: 0 };
        let counts = self.window.rows.clone().flat_map(|row| self.sample_counts(row));
        counts.fold(none, |range, count| SampleCounts { fewest: range.fewest.min(count), most: range.most.max(count) })
    }

    /// The first pixel of the window, row by row, that has no sample.
    pub fn first_empty_pixel(&self) -> Option<PixelPosition> {
        let is_empty = |row: u32| self.sample_counts(row).iter().position(|count| *count == 0);
        let (row, index) = self.window.rows.clone().find_map(|row| Some((row, is_empty(row)?)))?;
        Some(PixelPosition { x: self.window.columns.start + u32::try_from(index).ok()?, y: row })
    }

    /// Number of samples of each pixel of a row of the window.
    fn sample_counts(&self, row: u32) -> Vec<u64> {
        sample_counts(&self.coverage, &self.window, row)
    }

    /// The same sums in a window that contains `other` too.
    #[must_use]
    pub fn extended_to(self, other: &Window) -> Self {
        if self.window.contains(other) {
            return self;
        }
        let window = self.window.enclosing(other);
        let mut extended = Self::new(self.image_size, &window, self.aovs, &self.wavelengths_nm);
        extended.add(&self);
        extended
    }

    /// Adds the samples of another part of the same image.
    ///
    /// # Panics
    ///
    /// When the parts differ in image size or AOVs, share a sample, or the other window is not contained in this one.
    pub fn add(&mut self, other: &Self) {
        assert!(self.image_size == other.image_size && self.aovs == other.aovs, "the parts are of one image");
        assert_eq!(self.coverage.first_overlap(&other.coverage), None, "no sample counts twice");
        assert!(self.window.contains(&other.window), "the window contains that of the part");
        let (row_length, other_row_length) = (self.row_length(), other.row_length());
        let first_row = (other.window.rows.start - self.window.rows.start) as usize;
        let first_sum = (other.window.columns.start - self.window.columns.start) as usize * self.aovs.sum_count();
        let rows = self.sums.chunks_exact_mut(row_length).skip(first_row);
        for (row, other_row) in rows.zip(other.sums.chunks_exact(other_row_length)) {
            let sums = row[first_sum..].iter_mut();
            sums.zip(other_row).for_each(|(sum, term)| *sum = sum.saturating_add(*term));
        }
        other.coverage.blocks().iter().for_each(|block| self.coverage.add(block.clone()));
    }

    /// Number of sums of a row of pixels.
    fn row_length(&self) -> usize {
        self.aovs.sum_count() * self.window.size().width as usize
    }

    /// The rows of the window. Samples that are added to their sums must be [recorded](Self::record).
    pub(crate) fn par_rows_mut(&mut self) -> impl IndexedParallelIterator<Item = Row<'_>> {
        let (row_length, Self { window, coverage, sums, .. }) = (self.row_length(), self);
        let rows = sums.par_chunks_mut(row_length).zip(window.rows.clone());
        rows.map(|(sums, number)| Row {
            number,
            first_column: window.columns.start,
            sums,
            counts: sample_counts(coverage, window, number),
        })
    }

    /// Records that the sums include the samples of a block.
    pub(crate) fn record(&mut self, block: SampleBlock) {
        self.coverage.add(block);
    }

    /// The pixels of a row of the window.
    pub(crate) fn row(&self, row: u32) -> impl Iterator<Item = PixelSums<'_>> {
        let start = (row - self.window.rows.start) as usize * self.row_length();
        let pixels = self.sums[start..][..self.row_length()].chunks_exact(self.aovs.sum_count());
        pixels.zip(self.sample_counts(row)).map(|(sums, count)| PixelSums { aovs: self.aovs, sums, count })
    }

    /// Fills bits of the sum at an offset of the layout, for some pixels of a row of the window, counted from its left.
    pub(crate) fn fill_bits(&mut self, row: u32, first: usize, offset: usize, bits: impl Iterator<Item = i128>) {
        let (length, sum_count) = (self.row_length(), self.aovs.sum_count());
        let sums = self.sums.chunks_exact_mut(length).skip((row - self.window.rows.start) as usize).take(1);
        let sums = sums.flatten().skip(first * sum_count);
        sums.skip(offset).step_by(sum_count).zip(bits).for_each(|(sum, bits)| *sum |= bits);
    }

    /// The image of the window: the mean of each pixel's samples. Pixels without samples are black.
    pub fn film(&self) -> Film {
        let size = self.window.size();
        let mut pixels = vec![Xyz::default(); size.pixel_count()];
        let rows = pixels.par_chunks_mut(size.width as usize).zip(self.window.rows.clone());
        rows.for_each(|(pixels, row)| {
            pixels.iter_mut().zip(self.row(row)).for_each(|(pixel, sums)| *pixel = sums.mean_xyz());
        });
        let film = Film::new(size, pixels);
        let Some(offset) = self.aovs.offset(Aov::Emitter) else { return film };
        let sums = self.window.rows.clone().flat_map(|row| self.row(row));
        film.with_emitters(sums.map(|sums| sums.at(offset + 1) > 0).collect())
    }
}

/// A row of the window.
pub(crate) struct Row<'sums> {
    pub(crate) number: u32,
    /// Column of its first pixel.
    pub(crate) first_column: u32,
    /// The sums of all its pixels.
    pub(crate) sums: &'sums mut [i128],
    /// The number of samples in the sums of each pixel.
    pub(crate) counts: Vec<u64>,
}

/// Number of samples of each pixel of a row of a window.
fn sample_counts(coverage: &Coverage, window: &Window, row: u32) -> Vec<u64> {
    let mut counts = vec![0; window.size().width as usize];
    for SampleBlock { columns, samples, .. } in coverage.blocks().iter().filter(|block| block.rows.contains(&row)) {
        let [first, end] = [columns.start, columns.end].map(|column| (column - window.columns.start) as usize);
        let count = u64::from(range_length(samples));
        counts[first..end].iter_mut().for_each(|sum| *sum += count);
    }
    counts
}

/// The sums of a pixel.
#[derive(Clone, Copy)]
pub(crate) struct PixelSums<'a> {
    aovs: Aovs,
    sums: &'a [i128],
    /// Number of samples.
    count: u64,
}

impl PixelSums<'_> {
    /// The sum at an offset of the layout.
    pub(crate) fn at(&self, offset: usize) -> i128 {
        self.sums[offset]
    }

    /// Mean colour; black without samples.
    pub(crate) fn mean_xyz(&self) -> Xyz {
        mean_xyz(self.sums, self.count)
    }

    /// Mean radiance at a wavelength, as a band density in W m⁻² sr⁻¹.
    pub(crate) fn radiance(&self, wavelength: usize) -> f32 {
        narrow(mean(self.sums[SPECTRUM_OFFSET + wavelength], self.count))
    }

    /// Mean of one value of an AOV over the samples that have it; 0 if none has, or the layout does not have the AOV.
    pub(crate) fn aov(&self, aov: Aov, value: usize) -> f32 {
        let at = |offset: usize| narrow(quotient(self.sums[offset + 1 + value], self.sums[offset]));
        self.aovs.offset(aov).map_or(0.0, at)
    }

    /// Variance of the mean of red, green and blue, s²/n. Infinite if the pixel has one sample only, or its sum of
    /// squares is saturated, or the layout has no squares.
    pub(crate) fn variance(&self) -> [f32; 3] {
        let unknown = [f32::INFINITY; 3];
        let Some(offset) = self.aovs.squares_offset().filter(|_| self.count > 1) else { return unknown };
        let squares = &self.sums[offset..offset + 3];
        let estimate = Estimate::new(self.sums, squares, self.count);
        [0, 1, 2].map(|k| if squares[k] < i128::MAX { narrow(estimate.variance[k]) } else { f32::INFINITY })
    }
}

/// The mean of a pixel and its variance.
pub(crate) struct Estimate {
    /// Linear red, green and blue.
    pub(crate) mean: [f64; 3],
    /// Of the mean.
    pub(crate) variance: [f64; 3],
}

impl Estimate {
    /// The estimate of `count` samples, at least two, by their sums and sums of squares.
    pub(crate) fn new(sums: &[i128], squares: &[i128], count: u64) -> Self {
        let LinearRgb { r, g, b } = LinearRgb::from_xyz(mean_xyz(sums, count));
        let (mean, count) = ([r, g, b], count as f64);
        let variance = |k: usize| (squares[k] as f64 / SQUARE_UNITS / count - mean[k] * mean[k]).max(0.0);
        Self { mean, variance: [0, 1, 2].map(|k| variance(k) / (count - 1.0)) }
    }
}

/// Mean colour of a pixel, from its sums.
fn mean_xyz(sums: &[i128], count: u64) -> Xyz {
    let [x, y, z] = [sums[0], sums[1], sums[2]].map(|sum| mean(sum, count));
    Xyz { x, y, z }
}

/// A sum over its number of samples; 0 for none.
fn mean(sum: i128, count: u64) -> f64 {
    if count == 0 { 0.0 } else { sum as f64 / UNITS / count as f64 }
}

/// A sum over a count in the same units; 0 for none.
fn quotient(sum: i128, count: i128) -> f64 {
    if count == 0 { 0.0 } else { sum as f64 / count as f64 }
}
