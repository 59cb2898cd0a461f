//! Rows of results as a table, CSV or JSON, to the terminal or, whole or not at all, into a file.

use std::fmt::Write as _;
use std::io::{self, IsTerminal as _, Write as _};
use std::path::Path;

use serde_json::{Map, Value, json};
use snowblue_database::file::write_whole;

use crate::failure::{Failure, Outcome};
use crate::options::{Format, OutputOptions};

/// A value in a row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Cell {
    Number(f64),
    Word(String),
}

/// Named columns, rows, and what made them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Report {
    pub(crate) columns: Vec<&'static str>,
    pub(crate) rows: Vec<Vec<Cell>>,
    /// Names and values for JSON and, as a closing line, for the table.
    pub(crate) metadata: Vec<(&'static str, String)>,
}

impl Report {
    /// Writes the report where and how the options say. CSV has no room for what made it: that goes to stderr.
    pub(crate) fn write(&self, options: &OutputOptions, quiet: bool) -> Outcome {
        let ending = options.output.as_deref().and_then(Path::extension).and_then(|ending| ending.to_str());
        let format = match (options.format, &options.output, ending) {
            (Some(format), ..) => format,
            (None, Some(_), Some("csv")) => Format::Csv,
            (None, Some(_), Some("json")) => Format::Json,
            (None, Some(_), Some("txt")) => Format::Table,
            (None, Some(path), _) => {
                let name = path.display();
                return Err(Failure::Input(format!(
                    "{name}: the file must end in .csv, .json or .txt, or give --format"
                )));
            }
            (None, None, _) if io::stdout().is_terminal() => Format::Table,
            (None, None, _) => Format::Csv,
        };
        let text = match format {
            Format::Table => self.table(),
            Format::Csv => self.csv(),
            Format::Json => self.json(),
        };
        if format == Format::Csv && !quiet {
            tell(&self.made());
        }
        match &options.output {
            Some(path) => write_file(path, text.as_bytes()),
            None => print(&text),
        }
    }

    pub(crate) fn csv(&self) -> String {
        let mut text = self.columns.join(",");
        text.push('\n');
        for row in &self.rows {
            text.push_str(&row.iter().map(Cell::text).collect::<Vec<_>>().join(","));
            text.push('\n');
        }
        text
    }

    pub(crate) fn table(&self) -> String {
        let rows: Vec<Vec<String>> = self.rows.iter().map(|row| row.iter().map(Cell::text).collect()).collect();
        let width = |column: usize| {
            let cells = rows.iter().map(|row| row[column].chars().count());
            cells.max().unwrap_or(0).max(self.columns[column].len())
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let mut text = String::new();
        let mut line = |cells: &mut dyn Iterator<Item = &str>| {
            for (cell, width) in cells.zip(&widths) {
                // Writing into a string cannot fail.
                let _ = write!(text, "{cell:>width$}  ");
            }
            text.truncate(text.trim_end().len());
            text.push('\n');
        };
        line(&mut self.columns.iter().copied());
        for row in &rows {
            line(&mut row.iter().map(String::as_str));
        }
        text.push_str(&self.made());
        text
    }

    /// What made the results, as a line; nothing where nothing is said.
    fn made(&self) -> String {
        let made: Vec<String> = self.metadata.iter().map(|(name, value)| format!("{name} {value}")).collect();
        if made.is_empty() { String::new() } else { made.join(" · ") + "\n" }
    }

    fn json(&self) -> String {
        let row = |row: &Vec<Cell>| {
            let cells = self.columns.iter().zip(row).map(|(name, cell)| ((*name).to_owned(), cell.json()));
            Value::Object(cells.collect::<Map<_, _>>())
        };
        let metadata: Map<_, _> =
            self.metadata.iter().map(|(name, value)| ((*name).to_owned(), json!(value))).collect();
        let document = json!({ "metadata": metadata, "rows": self.rows.iter().map(row).collect::<Vec<_>>() });
        format!("{document:#}\n")
    }
}

impl Cell {
    pub(crate) fn text(&self) -> String {
        match self {
            Self::Number(value) => figures(*value),
            Self::Word(word) => word.clone(),
        }
    }

    fn json(&self) -> Value {
        match self {
            Self::Number(value) => json!(value),
            Self::Word(word) => json!(word),
        }
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

/// A number with nine significant digits: plain where that is short, else with an exponent.
pub(crate) fn figures(value: f64) -> String {
    let rounded: f64 = format!("{value:.8e}").parse().unwrap_or(value);
    let size = rounded.abs();
    if rounded == 0.0 || (1e-4..1e7).contains(&size) { rounded.to_string() } else { format!("{rounded:e}") }
}

/// Prints text; a reader that has gone away is no failure.
pub(crate) fn print(text: &str) -> Outcome {
    match io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::work(error)),
        _ => Ok(()),
    }
}

/// Says something beside the results; where nobody can hear it, the results still stand.
pub(crate) fn tell(text: &str) {
    drop(io::stderr().write_all(text.as_bytes()));
}

/// Checks before long work that a file can stand at its place.
pub(crate) fn check_place(path: &Path) -> Outcome {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if path.is_dir() || folder.is_some_and(|folder| !folder.is_dir()) {
        let name = path.display();
        return Err(Failure::Input(format!("{name}: it is a folder, or its folder does not exist")));
    }
    Ok(())
}

/// Checks before long work that a table can stand at its place and has a name that tells what it is.
pub(crate) fn check_table_place(path: &Path) -> Outcome {
    if path.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("nc")) {
        return Err(Failure::Input(format!("{}: the table must end in .nc", path.display())));
    }
    check_place(path)
}

/// Writes a file, whole or not at all.
pub(crate) fn write_file(path: &Path, contents: &[u8]) -> Outcome {
    let failed = |error: io::Error| Failure::Work(format!("{}: cannot be written: {error}", path.display()));
    write_whole(path, |beside| std::fs::write(beside, contents)).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_keep_nine_digits_in_any_magnitude() {
        assert_eq!(figures(0.021_512_345_678), "0.0215123457");
        assert_eq!(figures(3.084_969_326_53e-20), "3.08496933e-20");
        assert_eq!(figures(400.0), "400");
        assert_eq!(figures(0.0), "0");
    }
}
