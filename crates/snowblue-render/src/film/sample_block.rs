//! Which samples of which pixels: boxes of columns, rows and samples, and sets of them.
//!
//! A picture is the box of all its columns, all its rows and samples 0 to n. A tile, a range of samples, the rows that were done
//! before an interrupt: all are boxes too, so that parts are compared, added up and completed in one way.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Some samples of the pixels of a rectangle. All ranges are half-open and count from 0; the first pixel is the upper
/// left one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SampleBlock {
    /// Columns of pixels.
    pub columns: Range<u32>,
    /// Rows of pixels.
    pub rows: Range<u32>,
    /// Samples of each of the pixels.
    pub samples: Range<u32>,
}

/// A rectangle of pixels. Both ranges are half-open and count from 0 at the upper left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Window {
    /// Columns of pixels.
    pub columns: Range<u32>,
    /// Rows of pixels.
    pub rows: Range<u32>,
}

impl Window {
    /// Pixels from left to right.
    pub fn width(&self) -> u32 {
        width(&self.columns)
    }

    /// Pixels from top to bottom.
    pub fn height(&self) -> u32 {
        width(&self.rows)
    }

    /// The smallest window with the pixels of both.
    #[must_use]
    pub fn enclosing(&self, other: &Self) -> Self {
        let around = |one: &Range<u32>, other: &Range<u32>| one.start.min(other.start)..one.end.max(other.end);
        Self { columns: around(&self.columns, &other.columns), rows: around(&self.rows, &other.rows) }
    }

    /// Whether all pixels of another lie in this one.
    pub fn holds(&self, other: &Self) -> bool {
        self.enclosing(other) == *self
    }
}

impl SampleBlock {
    /// Its pixels.
    pub fn window(&self) -> Window {
        Window { columns: self.columns.clone(), rows: self.rows.clone() }
    }

    /// How many samples these are, of all pixels together.
    pub fn count(&self) -> u64 {
        u64::from(width(&self.columns)) * u64::from(width(&self.rows)) * u64::from(width(&self.samples))
    }

    fn is_empty(&self) -> bool {
        [&self.columns, &self.rows, &self.samples].into_iter().any(Range::is_empty)
    }

    /// What both have, if anything.
    pub fn overlap(&self, other: &Self) -> Option<Self> {
        let both = Self {
            columns: intersection(&self.columns, &other.columns),
            rows: intersection(&self.rows, &other.rows),
            samples: intersection(&self.samples, &other.samples),
        };
        (!both.is_empty()).then_some(both)
    }

    /// What remains without `other`, in boxes that do not overlap.
    fn minus(&self, other: &Self) -> Vec<Self> {
        let Some(hole) = self.overlap(other) else {
            return vec![self.clone()];
        };
        // Rows above and below the hole, then the columns beside it, then the samples before and after it.
        let (above, below) = (self.rows.start..hole.rows.start, hole.rows.end..self.rows.end);
        let (left, right) = (self.columns.start..hole.columns.start, hole.columns.end..self.columns.end);
        let (before, after) = (self.samples.start..hole.samples.start, hole.samples.end..self.samples.end);
        let mut rest: Vec<Self> = [above, below].map(|rows| Self { rows, ..self.clone() }).into();
        rest.extend([left, right].map(|columns| Self { columns, rows: hole.rows.clone(), ..self.clone() }));
        rest.extend([before, after].map(|samples| Self { samples, ..hole.clone() }));
        rest.retain(|portion| !portion.is_empty());
        rest
    }

    /// Both as one box, if they are one.
    fn joined(&self, other: &Self) -> Option<Self> {
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

impl fmt::Display for SampleBlock {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let Self { columns, rows, samples } = self;
        let [columns, rows, samples] = [columns, rows, samples].map(|range| format!("{}:{}", range.start, range.end));
        write!(formatter, "{columns},{rows},{samples}")
    }
}

impl FromStr for SampleBlock {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let range = |text: &str| {
            let (start, end) = text.split_once(':')?;
            Some(start.parse().ok()?..end.parse().ok()?)
        };
        let ranges: Option<Vec<Range<u32>>> = text.split(',').map(range).collect();
        let Ok([columns, rows, samples]) = <[Range<u32>; 3]>::try_from(ranges.ok_or(())?) else {
            return Err(());
        };
        let portion = Self { columns, rows, samples };
        if portion.is_empty() { Err(()) } else { Ok(portion) }
    }
}

/// A set of samples: boxes that do not overlap.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Coverage(Vec<SampleBlock>);

impl Coverage {
    /// The boxes.
    pub fn portions(&self) -> &[SampleBlock] {
        &self.0
    }

    /// Adds samples that are not in the set yet; boxes that make one box become it.
    pub(crate) fn add(&mut self, mut portion: SampleBlock) {
        while let Some((place, whole)) =
            self.0.iter().enumerate().find_map(|(place, one)| Some((place, one.joined(&portion)?)))
        {
            self.0.swap_remove(place);
            portion = whole;
        }
        self.0.push(portion);
        self.0.sort_unstable_by_key(|one| (one.rows.start, one.columns.start, one.samples.start));
    }

    /// Samples that both sets have, if there are any: one box of them.
    pub fn overlap(&self, other: &Self) -> Option<SampleBlock> {
        self.0.iter().find_map(|one| other.0.iter().find_map(|two| one.overlap(two)))
    }

    /// What of a box is not in the set.
    pub fn missing_from(&self, target: &SampleBlock) -> Vec<SampleBlock> {
        self.0
            .iter()
            .fold(vec![target.clone()], |missing, one| missing.iter().flat_map(|portion| portion.minus(one)).collect())
    }
}

impl fmt::Display for Coverage {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let portions: Vec<String> = self.0.iter().map(SampleBlock::to_string).collect();
        formatter.write_str(&portions.join(" "))
    }
}

impl FromStr for Coverage {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let mut coverage = Self::default();
        for portion in text.split_whitespace() {
            let portion: SampleBlock = portion.parse()?;
            if coverage.0.iter().any(|one| one.overlap(&portion).is_some()) {
                return Err(());
            }
            coverage.0.push(portion);
        }
        Ok(coverage)
    }
}

/// How many numbers a range has.
pub(crate) fn width(range: &Range<u32>) -> u32 {
    range.end.saturating_sub(range.start)
}

fn intersection(one: &Range<u32>, other: &Range<u32>) -> Range<u32> {
    one.start.max(other.start)..one.end.min(other.end)
}

/// Two ranges that touch as one.
fn union(one: &Range<u32>, other: &Range<u32>) -> Option<Range<u32>> {
    (one.end == other.start || other.end == one.start).then(|| one.start.min(other.start)..one.end.max(other.end))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn portion(text: &str) -> SampleBlock {
        text.parse().unwrap()
    }

    #[test]
    fn what_is_taken_away_and_what_remains_are_the_whole() {
        let whole = portion("0:6,0:5,0:4");
        for hole in ["0:6,0:5,0:4", "2:3,1:4,1:2", "0:1,0:1,0:1", "4:9,3:9,2:9", "1:6,0:5,0:4"].map(portion) {
            let rest = whole.minus(&hole);
            let inside = whole.overlap(&hole).unwrap();
            assert_eq!(rest.iter().map(SampleBlock::count).sum::<u64>() + inside.count(), whole.count(), "{hole}");
            let mut coverage = Coverage::default();
            rest.into_iter().for_each(|one| coverage.add(one));
            assert_eq!(coverage.overlap(&Coverage(vec![inside.clone()])), None);
            assert_eq!(coverage.missing_from(&whole), [inside], "{coverage}");
        }
        assert_eq!(whole.minus(&portion("6:7,0:5,0:4")), [whole]);
    }

    #[test]
    fn parts_become_one_whole() {
        let mut coverage = Coverage::default();
        for tile in ["0:3,0:2,0:4", "3:6,2:5,4:9", "3:6,0:2,0:9", "0:3,2:5,0:9", "3:6,2:5,0:4", "0:3,0:2,4:9"] {
            coverage.add(portion(tile));
        }
        assert_eq!(coverage.to_string(), "0:6,0:5,0:9");
        assert_eq!("0:6,0:5,0:9".parse(), Ok(coverage));
        // A damaged file may say anything; 2⁹⁶ samples are beyond any counter.
        assert!("0:4294967295,0:4294967295,0:4294967295".parse::<Coverage>().is_ok());
        for bad in ["0:6,0:5", "0:6,5:5,0:1", "a:1,0:1,0:1", "0:2,0:2,0:2 1:3,1:3,1:3"] {
            assert_eq!(bad.parse::<Coverage>(), Err(()), "{bad}");
        }
    }
}
