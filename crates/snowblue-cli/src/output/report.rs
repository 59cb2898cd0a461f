//! Output options, and tables of results written according to these options.

use std::io::{self, IsTerminal as _};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde_json::{Map, Value, json};
use snowblue_base::atomic_file::STANDARD_OUTPUT;
use snowblue_figures::{Cell, DataTable};

use super::failure::{Failure, Outcome};
use super::files::{check_path, ending, output_path, write_file};
use super::terminal::{print, print_message};

/// Where results go, and in which format.
#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputOptions {
    /// Write to a file instead of the terminal; - is the standard output
    #[arg(short, long, value_name = "FILE", value_parser = output_path())]
    pub(crate) output: Option<PathBuf>,
    /// Format [default: by the file's ending, else a table on a terminal and CSV into a pipe]
    #[arg(long, value_name = "FORMAT", value_enum)]
    pub(crate) format: Option<Format>,
}

/// A format of results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Aligned columns and metadata
    Table,
    /// Comma-separated values with a header line
    Csv,
    /// An object with metadata and rows
    Json,
}

/// Endings of files of results.
const ENDINGS: &str = ".csv, .json or .txt";

/// Endings of files of results on wavelengths.
const ENDINGS_OF_SPECTRA: &str = ".csv, .json, .txt or .nc";

impl OutputOptions {
    /// Checks before long work that the output can be written.
    pub(crate) fn check(&self) -> Outcome {
        self.chosen_format(ENDINGS)?;
        self.output.as_deref().map_or(Ok(()), check_path)
    }

    /// Writes results to the file or to stdout. Metadata of CSV goes to stderr unless `quiet`.
    pub(crate) fn write(&self, results: &DataTable, quiet: bool) -> Outcome {
        let format = self.chosen_format(ENDINGS)?;
        let text = match format {
            Format::Table => results.text(),
            Format::Csv => results.csv(),
            Format::Json => json_text(results),
        };
        if format == Format::Csv && !quiet {
            print_message(&results.metadata_line());
        }
        match &self.output {
            Some(path) => write_file(path, text.as_bytes()),
            None => print(&text).map_err(Failure::work),
        }
    }

    /// As [`check`](Self::check), for results on wavelengths, which may also be written as NetCDF.
    pub(crate) fn check_spectrum(&self) -> Outcome {
        match self.netcdf_path() {
            Some(path) => check_path(path),
            None => {
                self.chosen_format(ENDINGS_OF_SPECTRA)?;
                self.check()
            }
        }
    }

    /// The output file if it is NetCDF by its ending.
    pub(crate) fn netcdf_path(&self) -> Option<&Path> {
        self.output.as_deref().filter(|path| self.format.is_none() && ending(path, "csv") == "nc")
    }

    /// The format by the option or the ending of the file, which must be one of `endings`.
    fn chosen_format(&self, endings: &str) -> Result<Format, Failure> {
        if let Some(format) = self.format {
            return Ok(format);
        }
        let Some(path) = self.output.as_deref().filter(|path| *path != Path::new(STANDARD_OUTPUT)) else {
            return Ok(if io::stdout().is_terminal() { Format::Table } else { Format::Csv });
        };
        match &*ending(path, "csv") {
            "csv" => Ok(Format::Csv),
            "json" => Ok(Format::Json),
            "txt" => Ok(Format::Table),
            _ => {
                let name = path.display();
                Err(Failure::Input(format!("{name}: the file must end in {endings}, or give --format")))
            }
        }
    }
}

fn json_text(results: &DataTable) -> String {
    let value = |cell: &Cell| match cell {
        #[expect(clippy::cast_possible_truncation, reason = "whole and below 2⁵³")]
        Cell::Number(value) if value.fract() == 0.0 && value.abs() < 9e15 => json!(*value as i64),
        // JSON has no number for the thickness of a half-space.
        Cell::Number(value) if value.is_infinite() => json!(value.to_string()),
        Cell::Number(value) => json!(value),
        Cell::Word(word) => json!(word),
    };
    let row = |row: &Vec<Cell>| {
        let cells = results.columns.iter().zip(row).map(|(name, cell)| ((*name).to_owned(), value(cell)));
        Value::Object(cells.collect::<Map<_, _>>())
    };
    let metadata: Map<_, _> = results.metadata.iter().map(|(name, value)| ((*name).to_owned(), json!(value))).collect();
    let document = json!({ "metadata": metadata, "rows": results.rows.iter().map(row).collect::<Vec<_>>() });
    format!("{document:#}\n")
}
