//! A tabulated function of wavelength, interpolated linearly.

use std::ops::RangeInclusive;

/// Values at increasing wavelengths.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Curve {
    wavelengths_nm: Vec<f64>,
    values: Vec<f64>,
}

impl Curve {
    /// Requires at least two values and an equal number of increasing wavelengths.
    pub(crate) fn new(wavelengths_nm: Vec<f64>, values: Vec<f64>) -> Curve {
        Curve { wavelengths_nm, values }
    }

    /// The value at a wavelength, `None` outside the table.
    pub(crate) fn at(&self, wavelength_nm: f64) -> Option<f64> {
        if !self.range_nm().contains(&wavelength_nm) {
            return None;
        }
        let last = self.wavelengths_nm.len() - 1;
        let right = self.wavelengths_nm.partition_point(|&known_nm| known_nm <= wavelength_nm).min(last);
        let left = right - 1;
        let step_nm = self.wavelengths_nm[right] - self.wavelengths_nm[left];
        let fraction = (wavelength_nm - self.wavelengths_nm[left]) / step_nm;
        Some((1.0 - fraction) * self.values[left] + fraction * self.values[right])
    }

    /// The first and the last wavelength in nm.
    pub(crate) fn range_nm(&self) -> RangeInclusive<f64> {
        self.wavelengths_nm[0]..=self.wavelengths_nm[self.wavelengths_nm.len() - 1]
    }
}

/// Parses CSV with the given header: the wavelength in nm, then one column per curve.
///
/// # Panics
/// If the header differs, a row has another number of fields, a field is negative or not finite, the wavelengths are
/// not increasing in even steps, or there are fewer than two rows. All tables are part of this crate and parsed in its
/// tests.
pub(crate) fn parse<const COLUMNS: usize>(csv: &str, header: &str) -> [Curve; COLUMNS] {
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some(header), "unexpected header");
    assert_eq!(header.split(',').count(), COLUMNS + 1, "unexpected number of columns in the header");
    let rows: Vec<Vec<f64>> = lines.map(|line| parse_row(line, COLUMNS + 1)).collect();
    assert!(rows.len() >= 2, "a curve needs at least 2 rows, but there are {}", rows.len());
    let step_nm = rows[1][0] - rows[0][0];
    assert!(step_nm > 0.0, "wavelengths must increase, but the first step is {step_nm} nm");
    for pair in rows.windows(2) {
        let error_nm = (pair[1][0] - pair[0][0] - step_nm).abs();
        assert!(error_nm < 1e-9, "the step from {} to {} nm is not {step_nm} nm", pair[0][0], pair[1][0]);
    }
    std::array::from_fn(|column| Curve {
        wavelengths_nm: rows.iter().map(|row| row[0]).collect(),
        values: rows.iter().map(|row| row[column + 1]).collect(),
    })
}

fn parse_row(line: &str, fields: usize) -> Vec<f64> {
    let row: Vec<f64> = line
        .split(',')
        .map(|field| field.parse().unwrap_or_else(|error| panic!("`{field}` in row `{line}`: {error}")))
        .collect();
    assert_eq!(row.len(), fields, "unexpected number of fields in row `{line}`");
    assert!(row.iter().all(|value| value.is_finite() && *value >= 0.0), "row `{line}` is not finite and ≥ 0");
    row
}

#[cfg(test)]
impl Curve {
    /// Number of entries.
    pub(crate) fn count(&self) -> usize {
        self.values.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "wavelength_nm,a,b";

    fn parse_two(rows: &str) -> [Curve; 2] {
        parse(&format!("{HEADER}\n{rows}"), HEADER)
    }

    #[test]
    fn entries_are_exact_and_interpolated_linearly() {
        let [a, b] = parse_two("400,1,0\n410,3,0.5\n420,0,0.1\n");
        assert_eq!([400.0, 410.0, 420.0].map(|nm| a.at(nm)), [Some(1.0), Some(3.0), Some(0.0)]);
        assert_eq!([405.0, 415.0].map(|nm| a.at(nm)), [Some(2.0), Some(1.5)]);
        assert_eq!(b.at(405.0), Some(0.25));
    }

    #[test]
    fn values_outside_the_table_are_none() {
        let [a, _] = parse_two("400,1,0\n410,3,0.5\n");
        assert_eq!([399.999, 410.001, f64::NAN, f64::INFINITY].map(|nm| a.at(nm)), [None; 4]);
    }

    #[test]
    #[should_panic(expected = "unexpected header")]
    fn another_header_panics() {
        let _: [Curve; 2] = parse("wavelength_um,a,b\n400,1,0\n410,3,0\n", HEADER);
    }

    #[test]
    #[should_panic(expected = "unexpected number of fields in row `410,3`")]
    fn a_short_row_panics() {
        parse_two("400,1,0\n410,3\n");
    }

    #[test]
    #[should_panic(expected = "`x` in row `410,3,x`")]
    fn a_word_panics() {
        parse_two("400,1,0\n410,3,x\n");
    }

    #[test]
    #[should_panic(expected = "row `410,3,-1` is not finite and ≥ 0")]
    fn a_negative_value_panics() {
        parse_two("400,1,0\n410,3,-1\n");
    }

    #[test]
    #[should_panic(expected = "the step from 410 to 425 nm is not 10 nm")]
    fn an_uneven_step_panics() {
        parse_two("400,1,0\n410,3,0\n425,3,0\n");
    }
}
