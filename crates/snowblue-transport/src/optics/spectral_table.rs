//! A published table of optical constants against wavelength, as it ships in `data/`.

/// Rows of numbers, the wavelength in nm first, ascending.
#[derive(Debug)]
pub(crate) struct SpectralTable(Vec<Vec<f64>>);

/// The rows on both sides of a wavelength, and the share of the way from the lower to the upper one.
pub(crate) struct Between<'t> {
    below: &'t [f64],
    above: &'t [f64],
    share: f64,
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

    /// First and last wavelength, in nm.
    pub(crate) fn range_nm(&self) -> (f64, f64) {
        (self.0[0][0], self.0[self.0.len() - 1][0])
    }

    /// The wavelengths of the rows, in nm.
    pub(crate) fn wavelengths_nm(&self) -> impl Iterator<Item = f64> {
        self.0.iter().map(|row| row[0])
    }

    /// The rows on both sides of a wavelength.
    ///
    /// # Panics
    /// Outside the table.
    pub(crate) fn at(&self, wavelength_nm: f64) -> Between<'_> {
        let (low, high) = self.range_nm();
        assert!(
            (low..=high).contains(&wavelength_nm),
            "wavelength {wavelength_nm} nm is outside the table {low}–{high}"
        );
        let next = self.0.partition_point(|row| row[0] <= wavelength_nm).min(self.0.len() - 1);
        let (below, above) = (&self.0[next - 1], &self.0[next]);
        Between { below, above, share: (wavelength_nm - below[0]) / (above[0] - below[0]) }
    }
}

impl Between<'_> {
    /// A column, linear in the wavelength.
    pub(crate) fn linear(&self, column: usize) -> f64 {
        self.below[column] + self.share * (self.above[column] - self.below[column])
    }

    /// The logarithm of a column, linear in the wavelength.
    pub(crate) fn logarithmic(&self, column: usize) -> f64 {
        (self.below[column].ln() + self.share * (self.above[column] / self.below[column]).ln()).exp()
    }

    /// The logarithm of a column, linear in that of the wavelength.
    pub(crate) fn double_logarithmic(&self, column: usize, wavelength_nm: f64) -> f64 {
        let share = (wavelength_nm / self.below[0]).ln() / (self.above[0] / self.below[0]).ln();
        (self.below[column].ln() + share * (self.above[column] / self.below[column]).ln()).exp()
    }
}

#[cfg(test)]
impl SpectralTable {
    /// Number of rows, for tests that a table is whole; none if it is not in order.
    pub(crate) fn ordered_rows(&self) -> Option<usize> {
        self.0.is_sorted_by(|a, b| a[0] < b[0] && a.len() == b.len()).then_some(self.0.len())
    }
}
