//! Published tables of optical constants by wavelength, as they ship in `data/`, and ranges of wavelengths.

use snowblue_base::{ParameterRange, RangeError};

/// A range of wavelengths, ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WavelengthRange {
    /// First wavelength, in nm.
    pub first_nm: f64,
    /// Last wavelength, in nm.
    pub last_nm: f64,
}

impl WavelengthRange {
    /// The wavelengths from `first_nm` to `last_nm`.
    #[must_use]
    pub const fn new(first_nm: f64, last_nm: f64) -> Self {
        Self { first_nm, last_nm }
    }

    /// The least range that holds both.
    #[must_use]
    pub fn hull(self, other: Self) -> Self {
        Self { first_nm: self.first_nm.min(other.first_nm), last_nm: self.last_nm.max(other.last_nm) }
    }

    /// Whether `wavelength_nm` lies in the range.
    #[must_use]
    pub fn contains(self, wavelength_nm: f64) -> bool {
        (self.first_nm..=self.last_nm).contains(&wavelength_nm)
    }

    /// Checks that `wavelength_nm`, named `quantity` in the message, lies in the range.
    ///
    /// # Errors
    /// [`RangeError::OutOfRange`] otherwise.
    pub fn check(self, quantity: &'static str, wavelength_nm: f64) -> Result<(), RangeError> {
        ParameterRange { quantity, least: self.first_nm, greatest: self.last_nm, unit: "nm" }.check(wavelength_nm)
    }
}

/// Rows of numbers, the wavelength in nm first, ascending.
#[derive(Debug, PartialEq)]
pub(crate) struct SpectralTable(Vec<Vec<f64>>);

/// The two rows that enclose a wavelength, for interpolation.
pub(crate) struct Interpolation<'t> {
    below: &'t [f64],
    above: &'t [f64],
    /// Position of the wavelength between the rows: 0 at `below`, 1 at `above`.
    fraction: f64,
}

impl SpectralTable {
    /// Reads the lines after the header.
    ///
    /// # Panics
    /// If a table that ships with this crate is not numeric.
    pub(crate) fn new(csv: &str) -> Self {
        let number = |field: &str| field.parse().unwrap_or_else(|_| unreachable!("'{field}' is not a number"));
        Self(csv.lines().skip(1).map(|line| line.split(',').map(number).collect()).collect())
    }

    /// A table of columns of one length, the wavelengths first: at least one, ascending.
    pub(crate) fn of_columns(columns: &[Vec<f64>]) -> Self {
        Self((0..columns[0].len()).map(|row| columns.iter().map(|column| column[row]).collect()).collect())
    }

    /// The table with the values of a column times a factor.
    pub(crate) fn scaled(mut self, column: usize, factor: f64) -> Self {
        self.0.iter_mut().for_each(|row| row[column] *= factor);
        self
    }

    /// The greatest value of a column.
    pub(crate) fn greatest(&self, column: usize) -> f64 {
        self.0.iter().map(|row| row[column]).fold(f64::NEG_INFINITY, f64::max)
    }

    /// First and last wavelength.
    pub(crate) fn wavelength_range(&self) -> WavelengthRange {
        WavelengthRange::new(self.0[0][0], self.0[self.0.len() - 1][0])
    }

    /// The wavelengths of the rows, in nm.
    pub(crate) fn wavelengths_nm(&self) -> impl Iterator<Item = f64> {
        self.0.iter().map(|row| row[0])
    }

    /// All numbers, row by row.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f64> {
        self.0.iter().flatten().copied()
    }

    /// Finds the rows that enclose a wavelength.
    ///
    /// # Panics
    /// Outside the table.
    pub(crate) fn at(&self, wavelength_nm: f64) -> Interpolation<'_> {
        let range = self.wavelength_range();
        let WavelengthRange { first_nm, last_nm } = range;
        assert!(
            range.contains(wavelength_nm),
            "wavelength is {wavelength_nm} nm, but must lie in {first_nm}–{last_nm} nm"
        );
        let next = self.0.partition_point(|row| row[0] <= wavelength_nm).min(self.0.len() - 1);
        let (below, above) = (&self.0[next.saturating_sub(1)], &self.0[next]);
        let step_nm = above[0] - below[0];
        Interpolation { below, above, fraction: if step_nm > 0.0 { (wavelength_nm - below[0]) / step_nm } else { 0.0 } }
    }
}

impl Interpolation<'_> {
    /// Interpolates a column, linear in the wavelength.
    pub(crate) fn linear(&self, column: usize) -> f64 {
        self.below[column] + self.fraction * (self.above[column] - self.below[column])
    }

    /// Interpolates the logarithm of a column, linear in the wavelength.
    pub(crate) fn logarithmic(&self, column: usize) -> f64 {
        (self.below[column].ln() + self.fraction * (self.above[column] / self.below[column]).ln()).exp()
    }

    /// Interpolates the logarithm of a column, linear in the logarithm of the wavelength.
    pub(crate) fn double_logarithmic(&self, column: usize, wavelength_nm: f64) -> f64 {
        let fraction = (wavelength_nm / self.below[0]).ln() / (self.above[0] / self.below[0]).ln();
        (self.below[column].ln() + fraction * (self.above[column] / self.below[column]).ln()).exp()
    }
}

#[cfg(test)]
impl SpectralTable {
    /// Number of rows, or `None` if the wavelengths do not ascend or the rows differ in length.
    pub(crate) fn ordered_rows(&self) -> Option<usize> {
        self.0.is_sorted_by(|a, b| a[0] < b[0] && a.len() == b.len()).then_some(self.0.len())
    }
}
