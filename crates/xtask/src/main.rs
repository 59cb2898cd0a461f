//! Development tasks: `cargo run --release -p xtask -- TASK`.
//!
//! A task is a program that developers run now and then and that neither the command nor a test can replace.

mod embed_table;

use std::process::ExitCode;

const USAGE: &str = "usage: cargo run --release -p xtask -- TASK

  embed-table [FILE]    compute the table that snowblue-data embeds [crates/snowblue-data/data/snow.nc]";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let file = match words[..] {
        ["embed-table"] => None,
        ["embed-table", file] => Some(file),
        _ => {
            report(USAGE);
            return ExitCode::from(2);
        }
    };
    match embed_table::run(file) {
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
