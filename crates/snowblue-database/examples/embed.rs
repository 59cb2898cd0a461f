//! Computes the embedded table and writes it to the file that `snowblue-data` includes:
//! `cargo run --release -p snowblue-database --example embed -- crates/snowblue-data/data/snow.nc`.
//!
//! The command line cannot do it, because it cannot be built without the file.

use std::path::Path;
use std::process::ExitCode;

use snowblue_database::fill::{self, FillOptions};
use snowblue_database::{Axes, CompressedTable, DatabaseError, Space};

fn main() -> ExitCode {
    let Some(path) = std::env::args_os().nth(1) else {
        complain("usage: embed FILE.nc");
        return ExitCode::from(2);
    };
    match embed(Path::new(&path)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            complain(&error.to_string());
            ExitCode::FAILURE
        }
    }
}

fn embed(path: &Path) -> Result<(), DatabaseError> {
    let (table, _) = fill::fill(&Axes::with_thin_and_thick_knots(), &FillOptions::default(), &|_, _| ())?;
    CompressedTable::new(&table, Space::Log, Space::Log.usual_components())?.write(path)
}

#[expect(clippy::print_stderr, reason = "a program speaks to its user")]
fn complain(message: &str) {
    eprintln!("{message}");
}
