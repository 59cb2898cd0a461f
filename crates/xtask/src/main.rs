//! Development tasks: `cargo run --release -p xtask -- TASK`.
//!
//! A task is a program that developers run now and then and that neither the command nor a test can replace.

mod embed_table;
mod thickness_map;

use std::error::Error;
use std::process::ExitCode;

const USAGE: &str = "usage: cargo run --release -p xtask -- TASK

  embed-table [FILE]          compute the table that snowblue-data embeds [crates/snowblue-data/data/snow.nc]
  thickness-map MESH LINES    print the thickness of a mesh along grids of LINES × LINES lines as CSV";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done: Result<(), Box<dyn Error>> = match words[..] {
        ["embed-table"] => embed_table::run(None).map_err(Into::into),
        ["embed-table", file] => embed_table::run(Some(file)).map_err(Into::into),
        ["thickness-map", mesh, lines] => thickness_map::run(mesh.as_ref(), lines),
        _ => {
            report(USAGE);
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            report(&error.to_string());
            ExitCode::FAILURE
        }
    }
}

#[expect(clippy::print_stderr, reason = "messages of a command-line program")]
fn report(message: &str) {
    eprintln!("{message}");
}
