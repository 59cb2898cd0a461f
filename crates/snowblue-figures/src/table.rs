//! Tables of numbers and words, as CSV or as aligned text.

use std::fmt::Write as _;

/// Provenance of a result: names and values, in the order in which they are printed.
pub type Metadata = Vec<(&'static str, String)>;

/// A value in a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A number, printed with nine significant digits.
    Number(f64),
    /// A word, printed as it is.
    Word(String),
}

/// Named columns, rows, and their provenance.
#[derive(Debug, Clone, PartialEq)]
pub struct DataTable {
    /// Names of the columns, with units.
    pub columns: Vec<&'static str>,
    /// Rows with a cell for each column.
    pub rows: Vec<Vec<Cell>>,
    /// Closing line of the text; CSV does not hold it.
    pub metadata: Metadata,
}

impl DataTable {
    /// A table without metadata.
    pub fn new(columns: &[&'static str], rows: Vec<Vec<Cell>>) -> Self {
        Self { columns: columns.to_vec(), rows, metadata: Metadata::new() }
    }

    /// The table with numbers of a few significant digits, as words. Whole numbers keep all digits.
    pub fn rounded(&self, digits: usize) -> Self {
        let rounded = |cell: &Cell| match cell {
            Cell::Number(value) if value.fract() != 0.0 => Cell::Word(format_digits(*value, digits)),
            other => other.clone(),
        };
        let rows = self.rows.iter().map(|row| row.iter().map(rounded).collect()).collect();
        Self { rows, ..self.clone() }
    }

    /// The table as CSV with a header line.
    pub fn csv(&self) -> String {
        let mut text = self.columns.join(",");
        text.push('\n');
        for row in &self.rows {
            text.push_str(&row.iter().map(Cell::text).collect::<Vec<_>>().join(","));
            text.push('\n');
        }
        text
    }

    /// The table as text with aligned columns, and the metadata as a last line.
    pub fn text(&self) -> String {
        let rows: Vec<Vec<String>> = self.rows.iter().map(|row| row.iter().map(Cell::text).collect()).collect();
        let width = |column: usize| {
            let cells = rows.iter().map(|row| row[column].chars().count());
            cells.max().unwrap_or(0).max(self.columns[column].len())
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let mut text = String::new();
        let mut line = |cells: &mut dyn Iterator<Item = &str>| {
            for (cell, width) in cells.zip(&widths) {
                // Writing to a string cannot fail.
                let _ = write!(text, "{cell:>width$}  ");
            }
            text.truncate(text.trim_end().len());
            text.push('\n');
        };
        line(&mut self.columns.iter().copied());
        for row in &rows {
            line(&mut row.iter().map(String::as_str));
        }
        text.push_str(&self.metadata_line());
        text
    }

    /// The metadata as one line, empty without metadata.
    pub fn metadata_line(&self) -> String {
        let entries: Vec<String> = self.metadata.iter().map(|(name, value)| format!("{name} {value}")).collect();
        if entries.is_empty() { String::new() } else { entries.join(" · ") + "\n" }
    }
}

impl Cell {
    /// A word.
    pub fn word(word: impl Into<String>) -> Self {
        Self::Word(word.into())
    }

    /// The cell as it is printed.
    pub fn text(&self) -> String {
        match self {
            Self::Number(value) => format_number(*value),
            Self::Word(word) => word.clone(),
        }
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

/// A number with nine significant digits: plain where that is short, else with an exponent.
pub fn format_number(value: f64) -> String {
    format_digits(value, 9)
}

fn format_digits(value: f64, digits: usize) -> String {
    let rounded: f64 = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    let magnitude = rounded.abs();
    if rounded == 0.0 || (1e-4..1e7).contains(&magnitude) { rounded.to_string() } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_nine_digits_at_any_magnitude() {
        assert_eq!(format_number(0.021_512_345_678), "0.0215123457");
        assert_eq!(format_number(3.084_969_326_53e-20), "3.08496933e-20");
        assert_eq!(format_number(400.0), "400");
        assert_eq!(format_number(0.0), "0");
        let table = DataTable::new(&["T"], vec![vec![Cell::Number(0.036_474_21)], vec![Cell::Number(34_255.0)]]);
        assert_eq!(table.rounded(3).csv(), "T\n0.0365\n34255\n");
    }
}
