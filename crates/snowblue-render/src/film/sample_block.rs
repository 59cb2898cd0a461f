//! Which samples of which pixels: boxes of columns, rows and samples, and sets of them.
//!
//! An image is the box of all its columns, all its rows and samples 0 to n. A tile, a range of samples and the rows
//! done before an interrupt are boxes too, so one representation serves to compare, merge and complete parts of an
//! image.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use crate::film::window::{Window, range_length};

/// Most blocks of a set in a file, each of which is compared with all others. An image in as many parts as it has rows
/// or tiles has far fewer.
const MOST_BLOCKS: usize = 1 << 14;

/// Some samples of the pixels of a rectangle. All ranges are half-open; the upper left pixel is (0, 0).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SampleBlock {
    /// Columns of pixels.
    pub columns: Range<u32>,
    /// Rows of pixels.
    pub rows: Range<u32>,
    /// Samples of each pixel.
    pub samples: Range<u32>,
}

/// A text does not describe samples.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ParseSamplesError {
    /// A block is malformed, or one of its ranges is empty.
    #[error("'{0}' is not a block of samples X0:X1,Y0:Y1,S0:S1 of whole numbers")]
    MalformedBlock(String),
    /// Two blocks share samples.
    #[error("the blocks {0} and {1} overlap")]
    OverlappingBlocks(SampleBlock, SampleBlock),
    /// There are too many blocks.
    #[error("there are {0} blocks of samples, but must be at most {MOST_BLOCKS}")]
    TooManyBlocks(usize),
}

impl SampleBlock {
    /// Its pixels.
    pub fn window(&self) -> Window {
        Window { columns: self.columns.clone(), rows: self.rows.clone() }
    }

    /// Number of samples, over all pixels.
    pub fn count(&self) -> u64 {
        [&self.columns, &self.rows, &self.samples].into_iter().map(|range| u64::from(range_length(range))).product()
    }

    fn is_empty(&self) -> bool {
        [&self.columns, &self.rows, &self.samples].into_iter().any(Range::is_empty)
    }

    /// The samples in both blocks; none if they are disjoint.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        let both = Self {
            columns: intersection(&self.columns, &other.columns),
            rows: intersection(&self.rows, &other.rows),
            samples: intersection(&self.samples, &other.samples),
        };
        (!both.is_empty()).then_some(both)
    }

    /// The samples that are not in `other`, as disjoint blocks.
    fn difference(&self, other: &Self) -> Vec<Self> {
        let Some(hole) = self.intersection(other) else {
            return vec![self.clone()];
        };
        // Rows above and below the hole, then the columns beside it, then the samples before and after it.
        let (above, below) = (self.rows.start..hole.rows.start, hole.rows.end..self.rows.end);
        let (left, right) = (self.columns.start..hole.columns.start, hole.columns.end..self.columns.end);
        let (before, after) = (self.samples.start..hole.samples.start, hole.samples.end..self.samples.end);
        let mut rest: Vec<Self> = [above, below].map(|rows| Self { rows, ..self.clone() }).into();
        rest.extend([left, right].map(|columns| Self { columns, rows: hole.rows.clone(), ..self.clone() }));
        rest.extend([before, after].map(|samples| Self { samples, ..hole.clone() }));
        rest.retain(|block| !block.is_empty());
        rest
    }

    /// The union of two disjoint blocks, if it is a block.
    fn union(&self, other: &Self) -> Option<Self> {
        let (columns, rows, samples) =
            (self.columns == other.columns, self.rows == other.rows, self.samples == other.samples);
        match (columns, rows, samples) {
            (true, true, _) => Some(Self { samples: union(&self.samples, &other.samples)?, ..self.clone() }),
            (true, _, true) => Some(Self { rows: union(&self.rows, &other.rows)?, ..self.clone() }),
            (_, true, true) => Some(Self { columns: union(&self.columns, &other.columns)?, ..self.clone() }),
            _ => None,
        }
    }
}

/// `X0:X1,Y0:Y1,S0:S1`.
impl fmt::Display for SampleBlock {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let Self { columns, rows, samples } = self;
        let [columns, rows, samples] = [columns, rows, samples].map(|range| format!("{}:{}", range.start, range.end));
        write!(formatter, "{columns},{rows},{samples}")
    }
}

impl FromStr for SampleBlock {
    type Err = ParseSamplesError;

    fn from_str(text: &str) -> Result<Self, ParseSamplesError> {
        let range = |text: &str| {
            let (start, end) = text.split_once(':')?;
            Some(start.parse().ok()?..end.parse().ok()?)
        };
        let ranges: Option<Vec<Range<u32>>> = text.split(',').map(range).collect();
        let block = match ranges.as_deref() {
            Some([columns, rows, samples]) => {
                Some(Self { columns: columns.clone(), rows: rows.clone(), samples: samples.clone() })
            }
            _ => None,
        };
        block.filter(|block| !block.is_empty()).ok_or_else(|| ParseSamplesError::MalformedBlock(text.to_owned()))
    }
}

/// A set of samples, as disjoint blocks.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Coverage(Vec<SampleBlock>);

impl Coverage {
    /// The blocks.
    pub fn blocks(&self) -> &[SampleBlock] {
        &self.0
    }

    /// The samples of disjoint sets.
    ///
    /// # Errors
    ///
    /// When there are more blocks than a file may have.
    pub fn union<'a>(sets: impl IntoIterator<Item = &'a Self>) -> Result<Self, ParseSamplesError> {
        let mut union = Self::default();
        sets.into_iter().flat_map(|set| &set.0).for_each(|block| union.add(block.clone()));
        check_count(union.0.len()).map(|()| union)
    }

    /// Adds samples that are not in the set yet. Blocks whose union is a block are joined.
    pub(crate) fn add(&mut self, mut block: SampleBlock) {
        while let Some((index, joined)) =
            self.0.iter().enumerate().find_map(|(index, one)| Some((index, one.union(&block)?)))
        {
            self.0.swap_remove(index);
            block = joined;
        }
        self.0.push(block);
        self.0.sort_unstable_by_key(|one| (one.rows.start, one.columns.start, one.samples.start));
    }

    /// The first block of samples that are in both sets; none if the sets are disjoint.
    pub fn first_overlap(&self, other: &Self) -> Option<SampleBlock> {
        self.0.iter().find_map(|one| other.0.iter().find_map(|two| one.intersection(two)))
    }

    /// The samples of `target` that are not in the set, as disjoint blocks.
    pub fn missing_from(&self, target: &SampleBlock) -> Vec<SampleBlock> {
        self.0
            .iter()
            .fold(vec![target.clone()], |missing, one| missing.iter().flat_map(|block| block.difference(one)).collect())
    }
}

/// The blocks, separated by spaces.
impl fmt::Display for Coverage {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let blocks: Vec<String> = self.0.iter().map(SampleBlock::to_string).collect();
        formatter.write_str(&blocks.join(" "))
    }
}

impl FromStr for Coverage {
    type Err = ParseSamplesError;

    fn from_str(text: &str) -> Result<Self, ParseSamplesError> {
        let mut coverage = Self::default();
        check_count(text.split_whitespace().count())?;
        for block in text.split_whitespace() {
            let block: SampleBlock = block.parse()?;
            if let Some(other) = coverage.0.iter().find(|other| other.intersection(&block).is_some()) {
                return Err(ParseSamplesError::OverlappingBlocks(other.clone(), block));
            }
            coverage.0.push(block);
        }
        Ok(coverage)
    }
}

/// Checks the number of blocks of a file.
fn check_count(count: usize) -> Result<(), ParseSamplesError> {
    if count > MOST_BLOCKS { Err(ParseSamplesError::TooManyBlocks(count)) } else { Ok(()) }
}

fn intersection(one: &Range<u32>, other: &Range<u32>) -> Range<u32> {
    one.start.max(other.start)..one.end.min(other.end)
}

/// The union of two adjacent ranges.
fn union(one: &Range<u32>, other: &Range<u32>) -> Option<Range<u32>> {
    (one.end == other.start || other.end == one.start).then(|| one.start.min(other.start)..one.end.max(other.end))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(text: &str) -> SampleBlock {
        text.parse().unwrap()
    }

    #[test]
    fn difference_and_intersection_make_up_the_block() {
        let whole = block("0:6,0:5,0:4");
        for hole in ["0:6,0:5,0:4", "2:3,1:4,1:2", "0:1,0:1,0:1", "4:9,3:9,2:9", "1:6,0:5,0:4"].map(block) {
            let rest = whole.difference(&hole);
            let inside = whole.intersection(&hole).unwrap();
            assert_eq!(rest.iter().map(SampleBlock::count).sum::<u64>() + inside.count(), whole.count(), "{hole}");
            let mut coverage = Coverage::default();
            rest.into_iter().for_each(|one| coverage.add(one));
            assert_eq!(coverage.first_overlap(&Coverage(vec![inside.clone()])), None);
            assert_eq!(coverage.missing_from(&whole), [inside], "{coverage}");
        }
        assert_eq!(whole.difference(&block("6:7,0:5,0:4")), [whole]);
    }

    #[test]
    fn adjacent_blocks_are_joined() {
        let mut coverage = Coverage::default();
        for tile in ["0:3,0:2,0:4", "3:6,2:5,4:9", "3:6,0:2,0:9", "0:3,2:5,0:9", "3:6,2:5,0:4", "0:3,0:2,4:9"] {
            coverage.add(block(tile));
        }
        assert_eq!(coverage.to_string(), "0:6,0:5,0:9");
        assert_eq!("0:6,0:5,0:9".parse(), Ok(coverage));
    }

    #[test]
    fn malformed_texts_are_errors() {
        // A damaged file may contain any numbers; 2⁹⁶ samples exceed all counters.
        assert!("0:4294967295,0:4294967295,0:4294967295".parse::<Coverage>().is_ok());
        for malformed in ["0:6,0:5", "0:6,5:5,0:1", "a:1,0:1,0:1"] {
            let error = ParseSamplesError::MalformedBlock(malformed.to_owned());
            assert_eq!(malformed.parse::<Coverage>(), Err(error));
        }
        let many = (0..MOST_BLOCKS + 1).map(|row| format!("0:1,{row}:{},0:1 ", row + 1)).collect::<String>();
        assert_eq!(many.parse::<Coverage>(), Err(ParseSamplesError::TooManyBlocks(MOST_BLOCKS + 1)));
        // Every other row: blocks that cannot be joined.
        let rows = |rows: Range<usize>| {
            Coverage(rows.map(|row| block(&format!("0:1,{}:{},0:1", 2 * row, 2 * row + 1))).collect())
        };
        let halves = [rows(0..MOST_BLOCKS / 2), rows(MOST_BLOCKS / 2..MOST_BLOCKS)];
        assert_eq!(Coverage::union(&halves).map(|union| union.0.len()), Ok(MOST_BLOCKS));
        let more = rows(MOST_BLOCKS..MOST_BLOCKS + 1);
        assert_eq!(
            Coverage::union(halves.iter().chain([&more])),
            Err(ParseSamplesError::TooManyBlocks(MOST_BLOCKS + 1))
        );
        let error = "0:2,0:2,0:2 1:3,1:3,1:3".parse::<Coverage>().unwrap_err();
        assert_eq!(error.to_string(), "the blocks 0:2,0:2,0:2 and 1:3,1:3,1:3 overlap");
    }
}
