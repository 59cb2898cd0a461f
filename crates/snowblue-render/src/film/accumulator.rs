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
//!
//! The samples of a pixel form one range. All pixels begin with one common sample. After an interrupt, and in tiles
//! with different numbers of samples, they end with different samples.

use std::collections::BTreeMap;
use std::iter::repeat;
use std::ops::Range;

use rayon::prelude::*;
use snowblue_base::narrow;
use snowblue_color::{LinearRgb, Xyz};

use crate::film::aov::{Aov, Aovs, SPECTRUM_OFFSET};
use crate::film::cryptomatte::{IdCounts, Matte, PixelMattes};
use crate::film::window::{SampleBlock, Window, range_length};
use crate::raster::PixelPosition;
use snowblue_scene::film::ImageSize;

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
    /// The first sample of each pixel.
    first_sample: u32,
    /// The number of samples of each pixel, row by row.
    counts: Vec<u32>,
    /// The sums of each pixel, in the layout of [`Aovs`], row by row.
    sums: Vec<i128>,
    /// The mattes of each pixel, for each row; the rows are empty if there are none.
    mattes: Vec<Vec<PixelMattes>>,
    /// Names and texts of the attributes of the AOVs.
    pub(crate) attributes: BTreeMap<String, String>,
    /// The decision for the present pass.
    pub(crate) decision: Decision,
}

/// The pixels that need no further samples, for adaptive sampling. A decision holds for one pass over the pixels,
/// also if the pass is interrupted, and is no part of the image.
#[derive(Debug, Clone, Default)]
pub(crate) struct Decision {
    /// Number of samples of each pixel at the start of the pass.
    pub(crate) samples: u32,
    /// The greatest relative noise of a pixel that is done.
    pub(crate) target: f64,
    /// Whether each pixel of the window is done; empty if none is.
    pub(crate) done: Vec<bool>,
}

impl PartialEq for Decision {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Memory of a pixel, in bytes.
pub(crate) fn pixel_bytes(aovs: Aovs) -> usize {
    /// Memory of usual numbers of identifiers.
    const MATTES: usize = size_of::<PixelMattes>() + 2 * 64;
    aovs.sum_count() * size_of::<i128>() + size_of::<u32>() + if aovs.need_mattes() { MATTES } else { 0 }
}

/// Memory of the sums of a window, in bytes.
pub fn memory_bytes(window: &Window, aovs: Aovs) -> u64 {
    window.size().pixel_count() as u64 * pixel_bytes(aovs) as u64
}

/// Samples of a pixel that leave a gap after the present samples, or repeat some of them. Both ranges are half-open.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "the samples {}:{} of pixel {},{} do not follow {}:{}",
    added.start, added.end, pixel.x, pixel.y, present.start, present.end
)]
pub struct SamplesDoNotFollow {
    /// The pixel.
    pub pixel: PixelPosition,
    /// The present samples of the pixel.
    pub present: Range<u32>,
    /// The samples to add.
    pub added: Range<u32>,
}

/// The range of the number of samples per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleCounts {
    /// Samples of the pixel that has fewest.
    pub fewest: u32,
    /// Samples of the pixel that has most.
    pub most: u32,
}

impl FilmAccumulator {
    /// An accumulator without samples for a window of an image. [`render::accumulator`](crate::render::accumulator)
    /// makes one for a scene.
    ///
    /// # Panics
    ///
    /// When the window reaches beyond the image.
    pub fn new(image_size: ImageSize, window: &Window, aovs: Aovs) -> Self {
        assert!(Window::of_image(image_size).contains(window), "the window lies within the image");
        let ImageSize { width, height } = window.size();
        let mattes = vec![PixelMattes::default(); if aovs.need_mattes() { width as usize } else { 0 }];
        Self {
            image_size,
            window: window.clone(),
            aovs,
            first_sample: 0,
            counts: vec![0; window.size().pixel_count()],
            sums: vec![0; window.size().pixel_count() * aovs.sum_count()],
            mattes: vec![mattes; height as usize],
            attributes: BTreeMap::new(),
            decision: Decision::default(),
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

    /// Names and texts of attributes that a file of the image has for its AOVs: the names that have mattes, and the
    /// origin of positions.
    pub fn attributes(&self) -> &BTreeMap<String, String> {
        &self.attributes
    }

    /// The samples of the pixel with most samples.
    pub fn samples(&self) -> Range<u32> {
        self.first_sample..self.first_sample + self.samples_per_pixel().most
    }

    /// Whether no pixel has a sample.
    pub fn is_empty(&self) -> bool {
        self.counts.iter().all(|count| *count == 0)
    }

    /// Fewest and most samples of a pixel of the window.
    pub fn samples_per_pixel(&self) -> SampleCounts {
        let [fewest, most] = [self.counts.iter().min(), self.counts.iter().max()];
        SampleCounts { fewest: fewest.copied().unwrap_or(0), most: most.copied().unwrap_or(0) }
    }

    /// The first pixel of the window, row by row, that has no sample.
    pub fn first_empty_pixel(&self) -> Option<PixelPosition> {
        self.pixels().find(|(_, count)| *count == 0).map(|(pixel, _)| pixel)
    }

    /// The pixels of the window, row by row, with their numbers of samples.
    fn pixels(&self) -> impl Iterator<Item = (PixelPosition, u32)> {
        let Window { columns, rows } = &self.window;
        let positions = rows.clone().flat_map(|y| columns.clone().map(move |x| PixelPosition { x, y }));
        positions.zip(self.counts.iter().copied())
    }

    /// The number of samples of a block that the sums lack. The block begins with the first sample of the sums, if
    /// they have any.
    ///
    /// # Panics
    ///
    /// If the block reaches beyond the window.
    pub fn missing_count(&self, target: &SampleBlock) -> u64 {
        let samples = range_length(&target.samples);
        self.counts_of(target).map(|count| u64::from(samples.saturating_sub(count))).sum()
    }

    /// The number of samples of each pixel of a block.
    pub(crate) fn counts_of(&self, target: &SampleBlock) -> impl Iterator<Item = u32> {
        assert!(self.window.contains(&target.window()), "the window contains that of the block");
        let width = range_length(&target.columns) as usize;
        target.rows.clone().flat_map(move |row| &self.counts[self.index(target.columns.start, row)..][..width]).copied()
    }

    /// The number of a pixel of the window, row by row.
    fn index(&self, x: u32, y: u32) -> usize {
        let Window { columns, rows } = &self.window;
        (y - rows.start) as usize * range_length(columns) as usize + (x - columns.start) as usize
    }

    /// Extends the window so that it also contains `other`, without a change of the sums.
    #[must_use]
    pub fn extended_to(self, other: &Window) -> Self {
        if self.window.contains(other) {
            return self;
        }
        let window = self.window.enclosing(other);
        let mut extended = Self::new(self.image_size, &window, self.aovs);
        extended.add_all(&self);
        extended
    }

    /// Adds the samples of another part of the image, which follow the present samples of each pixel.
    ///
    /// # Errors
    ///
    /// When the samples of a pixel do not follow its present samples. Nothing is added then.
    ///
    /// # Panics
    ///
    /// When the parts differ in image size or AOVs, or the other window is not contained in this one.
    pub fn add(&mut self, other: &Self) -> Result<(), SamplesDoNotFollow> {
        assert!(self.image_size == other.image_size && self.aovs == other.aovs, "the parts are of one image");
        assert!(self.window.contains(&other.window), "the window contains that of the part");
        let range = |first: u32, count: u32| first..first + count;
        let first = if self.is_empty() { other.first_sample } else { self.first_sample };
        for (pixel, count) in other.pixels().filter(|(_, count)| *count > 0) {
            let present = range(first, self.counts[self.index(pixel.x, pixel.y)]);
            if present.end != other.first_sample {
                return Err(SamplesDoNotFollow { pixel, present, added: range(other.first_sample, count) });
            }
        }
        self.add_all(other);
        Ok(())
    }

    /// Adds samples that follow the present samples of each pixel.
    fn add_all(&mut self, other: &Self) {
        self.decision = Decision::default();
        self.begin_at(if self.is_empty() { other.first_sample } else { self.first_sample });
        for ((pixel, count), sums) in other.pixels().zip(other.sums.chunks_exact(self.aovs.sum_count())) {
            let index = self.index(pixel.x, pixel.y);
            self.counts[index] += count;
            let own = self.sums[index * sums.len()..].iter_mut();
            own.zip(sums).for_each(|(sum, term)| *sum = sum.saturating_add(*term));
        }
        for ((PixelPosition { x, y }, _), added) in other.pixels().zip(other.mattes.iter().flatten()) {
            let [column, row] = [x - self.window.columns.start, y - self.window.rows.start].map(|place| place as usize);
            self.mattes[row][column].iter_mut().zip(added).for_each(|(counts, added)| counts.add_all(added));
        }
        self.attributes.clone_from(&other.attributes);
    }

    /// The greatest number of something in the mattes of a pixel.
    pub(crate) fn most_in_mattes(&self, matte: Matte, count: impl Fn(&IdCounts) -> usize) -> usize {
        self.mattes.iter().flatten().map(|pixel| count(&pixel[matte as usize])).max().unwrap_or(0)
    }

    /// Number of sums of a row of pixels.
    fn row_length(&self) -> usize {
        self.aovs.sum_count() * self.window.size().width as usize
    }

    /// Sets the first sample of all pixels.
    ///
    /// # Panics
    ///
    /// When the present samples begin with another sample.
    pub(crate) fn begin_at(&mut self, sample: u32) {
        assert!(self.first_sample == sample || self.is_empty(), "the samples of all pixels begin with the same one");
        self.first_sample = sample;
    }

    /// The rows of a block within the window. Callers that add samples to the sums also count them.
    pub(crate) fn par_rows_mut(&mut self, target: &SampleBlock) -> impl IndexedParallelIterator<Item = Row<'_>> {
        let [first_column, first_row] = [(&target.columns, &self.window.columns), (&target.rows, &self.window.rows)]
            .map(|(part, all)| (part.start - all.start) as usize);
        let (width, height) = (range_length(&target.columns) as usize, target.rows.len());
        let (row_length, sum_count) = (self.row_length(), self.aovs.sum_count());
        let counts = self.counts.par_chunks_mut(self.window.size().width as usize);
        let mattes = self.mattes.par_iter_mut();
        let rows = self.sums.par_chunks_mut(row_length).zip(counts).zip(mattes).skip(first_row).take(height);
        rows.zip(target.rows.clone()).map(move |(((sums, counts), mattes), number)| Row {
            number,
            sums: &mut sums[first_column * sum_count..][..width * sum_count],
            counts: &mut counts[first_column..][..width],
            mattes: mattes.get_mut(first_column..).unwrap_or_default(),
        })
    }

    /// The pixels of a row of the window.
    pub(crate) fn row(&self, row: u32) -> impl Iterator<Item = PixelSums<'_>> {
        let start = (row - self.window.rows.start) as usize * self.row_length();
        let pixels = self.sums[start..][..self.row_length()].chunks_exact(self.aovs.sum_count());
        let counts = &self.counts[self.index(self.window.columns.start, row)..];
        let mattes = self.mattes[(row - self.window.rows.start) as usize].iter().map(Some).chain(repeat(None));
        let pixels = pixels.zip(counts).zip(mattes);
        pixels.map(|((sums, count), mattes)| PixelSums { aovs: self.aovs, sums, mattes, count: *count })
    }

    /// The pixels of the window, row by row.
    pub(crate) fn all_pixels(&self) -> Vec<PixelSums<'_>> {
        self.window.rows.clone().flat_map(|row| self.row(row)).collect()
    }

    /// Fills bits of the sum at an offset of the layout, for some pixels of a row of the window, counted from its left.
    pub(crate) fn fill_bits(&mut self, row: u32, first: usize, offset: usize, bits: impl Iterator<Item = i128>) {
        let (length, sum_count) = (self.row_length(), self.aovs.sum_count());
        let sums = self.sums.chunks_exact_mut(length).skip((row - self.window.rows.start) as usize).take(1);
        let sums = sums.flatten().skip(first * sum_count);
        sums.skip(offset).step_by(sum_count).zip(bits).for_each(|(sum, bits)| *sum |= bits);
    }

    /// Sets a value of an entry of the mattes of some pixels of a row of the window, counted from its left.
    pub(crate) fn fill_mattes(&mut self, row: u32, first: usize, place: MatteWord, numbers: Vec<u32>) {
        let pixels = self.mattes[(row - self.window.rows.start) as usize].iter_mut().skip(first);
        let MatteWord { matte, entry, value } = place;
        pixels.zip(numbers).for_each(|(pixel, number)| pixel[matte as usize].set(entry, value, number));
    }

    /// Drops the entries without samples that fill up the mattes of a file.
    pub(crate) fn drop_empty_entries(&mut self) {
        self.mattes.iter_mut().flatten().flatten().for_each(IdCounts::drop_empty);
    }

    /// Sets the number of samples of some pixels of a row of the window, counted from its left.
    pub(crate) fn fill_counts(&mut self, row: u32, first: usize, numbers: Vec<u32>) {
        let start = self.index(self.window.columns.start, row) + first;
        self.counts[start..].iter_mut().zip(numbers).for_each(|(count, number)| *count = number);
    }
}

/// A row of a block.
pub(crate) struct Row<'sums> {
    pub(crate) number: u32,
    /// The sums of all its pixels.
    pub(crate) sums: &'sums mut [i128],
    /// The number of samples in the sums of each pixel.
    pub(crate) counts: &'sums mut [u32],
    /// The mattes of each pixel; empty if there are none.
    pub(crate) mattes: &'sums mut [PixelMattes],
}

/// Where a file stores a number of the mattes of a pixel: the identifier or the count of an entry.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MatteWord {
    pub(crate) matte: Matte,
    pub(crate) entry: usize,
    pub(crate) value: usize,
}

/// The sums of a pixel.
#[derive(Clone, Copy)]
pub(crate) struct PixelSums<'a> {
    aovs: Aovs,
    sums: &'a [i128],
    mattes: Option<&'a PixelMattes>,
    /// Number of samples.
    count: u32,
}

impl PixelSums<'_> {
    /// Number of samples.
    pub(crate) fn count(&self) -> u32 {
        self.count
    }

    /// The sum at an offset of the layout.
    pub(crate) fn at(&self, offset: usize) -> i128 {
        self.sums[offset]
    }

    /// Mean colour; black without samples.
    pub(crate) fn mean_xyz(&self) -> Xyz {
        mean_xyz(self.sums, self.count.into())
    }

    /// Mean colour with the changes of the filter.
    pub(crate) fn filtered_xyz(&self, changes: &[f32]) -> Xyz {
        let Xyz { x, y, z } = self.mean_xyz();
        let [by_x, by_y, by_z] = [0, 1, 2].map(|k| changes.get(k).copied().map_or(0.0, f64::from));
        Xyz { x: x + by_x, y: y + by_y, z: z + by_z }
    }

    /// Mean radiance at a wavelength, as a band density in W m⁻² sr⁻¹, with the changes of the filter.
    pub(crate) fn radiance(&self, wavelength: usize, changes: &[f32]) -> f32 {
        self.mean(SPECTRUM_OFFSET + wavelength) + changes.get(3 + wavelength).copied().unwrap_or(0.0)
    }

    /// Mean of the sum at an offset of the layout.
    pub(crate) fn mean(&self, offset: usize) -> f32 {
        narrow(self.exact_mean(offset))
    }

    /// Mean of the sum at an offset of the layout, in double precision.
    pub(crate) fn exact_mean(&self, offset: usize) -> f64 {
        mean(self.sums[offset], self.count.into())
    }

    /// The sum at an offset divided by the number of samples at another offset; 0 without samples.
    pub(crate) fn quotient(&self, offset: usize, count: usize) -> f32 {
        narrow(quotient(self.sums[offset], self.sums[count]))
    }

    /// Variance of a mean, from the sum of squares at an offset; for one sample the square of the sample. Infinite if
    /// the sum of squares is saturated.
    pub(crate) fn variance_of_mean(&self, squares: usize, mean: f64) -> f32 {
        if self.sums[squares] == i128::MAX {
            return f32::INFINITY;
        }
        let count = f64::from(self.count);
        let square = self.sums[squares] as f64 / SQUARE_UNITS / count.max(1.0);
        if self.count < 2 { narrow(square) } else { narrow((square - mean * mean).max(0.0) / (count - 1.0)) }
    }

    /// Mean of one value of an AOV over the samples that have it, if the layout has the AOV and any sample has it.
    pub(crate) fn aov(&self, aov: Aov, value: usize) -> f32 {
        let offset = self.aovs.offset(aov).filter(|offset| self.sums[*offset] > 0);
        offset.map_or(aov.without_samples(), |offset| self.quotient(offset + 1 + value, offset))
    }

    /// The mattes of the pixel, if there are any.
    pub(crate) fn matte(&self, matte: Matte) -> Option<&IdCounts> {
        self.mattes.map(|mattes| &mattes[matte as usize])
    }

    /// Variance of the mean of red, green and blue, s²/n. Infinite if the pixel has one sample only, or its sum of
    /// squares is saturated, or the layout has no squares.
    pub(crate) fn variance(&self) -> [f32; 3] {
        let unknown = [f32::INFINITY; 3];
        let Some(offset) = self.aovs.squares_offset().filter(|_| self.count > 1) else { return unknown };
        let LinearRgb { r, g, b } = LinearRgb::from_xyz(self.mean_xyz());
        [(offset, r), (offset + 1, g), (offset + 2, b)].map(|(squares, mean)| self.variance_of_mean(squares, mean))
    }
}

/// Mean colour of a pixel, from its sums.
fn mean_xyz(sums: &[i128], count: u64) -> Xyz {
    let [x, y, z] = [sums[0], sums[1], sums[2]].map(|sum| mean(sum, count));
    Xyz { x, y, z }
}

/// A sum divided by its number of samples; 0 without samples.
fn mean(sum: i128, count: u64) -> f64 {
    if count == 0 { 0.0 } else { sum as f64 / UNITS / count as f64 }
}

/// A sum divided by a count in the same units; 0 for a count of 0.
fn quotient(sum: i128, count: i128) -> f64 {
    if count == 0 { 0.0 } else { sum as f64 / count as f64 }
}
