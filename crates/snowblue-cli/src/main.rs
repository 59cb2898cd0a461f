//! The `snowblue` command: the blue of light through snow, predicted from what the snow is made of.

mod args;
mod broadband;
mod bsdf;
mod color;
mod colored;
mod database;
mod failure;
mod figures;
mod inspect;
mod interrupt;
mod layers;
mod match_command;
mod merge;
mod merge_pictures;
mod options;
mod parse;
mod picture;
mod plot;
mod preview;
mod progress;
mod render;
mod render_job;
mod report;
mod slab;
mod source;
mod spectrum;
mod spectrum_file;
mod swatch;

use args::{Arguments, Command};
use clap::Parser as _;
use failure::{Failure, Outcome};

fn main() -> std::process::ExitCode {
    failure::exit_code(&run())
}

fn run() -> Outcome {
    let arguments = Arguments::try_parse()?;
    let threads = usize::from(arguments.threads.unwrap_or(0));
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().map_err(Failure::work)?;
    match arguments.command {
        Command::Spectrum(command) => command.run(arguments.quiet),
        Command::Bsdf(command) => command.run(arguments.quiet),
        Command::Slab(command) => command.run(arguments.quiet),
        Command::Database(command) => command.run(arguments.quiet),
        Command::Merge(command) => command.run(arguments.quiet),
        Command::Color(command) => command.run(arguments.quiet),
        Command::Match(command) => command.run(arguments.quiet),
        Command::Swatch(command) => command.run(),
        Command::Render(command) => command.run(arguments.quiet),
        Command::Figures(command) => command.run(arguments.quiet),
    }
}
