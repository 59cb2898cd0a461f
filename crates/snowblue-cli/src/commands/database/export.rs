//! `snowblue database export`: tables for other programs.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use snowblue_database::exchange;
use snowblue_database::file::{self, AnyTable};

use crate::output::{Failure, Outcome, check_path, ending, output_path};

/// Write a table for programs that do not read NetCDF
#[derive(Debug, Args)]
#[command(
    after_help = "'raw' writes FILE.json, which describes the layout, and FILE.f32 with little-endian single-precision \
numbers. 'csv' writes a row for each value.

Examples:
  snowblue database export -o snow.json              the embedded table, for a real-time engine
  snowblue database export full.nc -o full.csv"
)]
pub(crate) struct Export {
    /// Table to export [default: the embedded one]
    file: Option<PathBuf>,
    /// Format [default: by the file's ending: .json is raw, .csv is CSV]
    #[arg(long, value_name = "FORMAT", value_enum)]
    format: Option<ExportFormat>,
    /// File to write (.json or .csv)
    #[arg(short, long, value_name = "FILE", value_parser = output_path())]
    output: PathBuf,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ExportFormat {
    /// JSON header and raw numbers
    Raw,
    /// A row for each value
    Csv,
}

impl Export {
    pub(super) fn run(&self) -> Outcome {
        let format = match (self.format, &*ending(&self.output, "csv")) {
            (Some(format), _) => format,
            (None, "json") => ExportFormat::Raw,
            (None, "csv") => ExportFormat::Csv,
            _ => {
                let name = self.output.display();
                return Err(Failure::Input(format!("{name}: the file must end in .json or .csv, or give --format")));
            }
        };
        check_path(&self.output)?;
        let table = match &self.file {
            Some(path) => file::read(path).map_err(Failure::input)?,
            None => AnyTable::Compressed(snowblue_data::embedded().clone()),
        };
        let export = match format {
            ExportFormat::Raw => exchange::export_raw,
            ExportFormat::Csv => exchange::export_csv,
        };
        if let AnyTable::Shard(_) = table {
            return Err(Failure::Input("a shard cannot be exported; merge it first".to_owned()));
        }
        export(&table, &self.output).map_err(Failure::work)
    }
}
