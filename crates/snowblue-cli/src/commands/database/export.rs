//! `snowblue database export`: tables for other programs.

use std::path::PathBuf;

use clap::Args;
use snowblue_database::export_csv;
use snowblue_database::file::{self, AnyTable};

use crate::output::{Failure, Outcome, check_extension, output_path};

/// Write a table as CSV, a row for each value
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  snowblue database export -o snow.csv              the embedded table
  snowblue database export full.nc -o full.csv")]
pub(crate) struct Export {
    /// Table to export [default: the embedded one]
    file: Option<PathBuf>,
    /// File to write (.csv)
    #[arg(short, long, value_name = "FILE", value_parser = output_path())]
    output: PathBuf,
}

impl Export {
    pub(super) fn run(&self) -> Outcome {
        check_extension(&self.output, "csv", "the table")?;
        let table = match &self.file {
            Some(path) => file::read(path).map_err(Failure::input)?,
            None => AnyTable::Compressed(snowblue_data::embedded().clone()),
        };
        if let AnyTable::Shard(_) = table {
            return Err(Failure::Input("a shard cannot be exported; merge it first".to_owned()));
        }
        export_csv(&table, &self.output).map_err(Failure::work)
    }
}
