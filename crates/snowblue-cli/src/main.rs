//! The `snowblue` command: the blue of light through snow, predicted from what the snow is made of.

mod bsdf;
mod color;
mod database;
mod failure;
mod layers;
mod options;
mod parse;
mod plot;
mod progress;
mod render;
mod report;
mod slab;
mod spectrum;

use clap::{Parser, Subcommand};
use failure::{Failure, Outcome};

/// The blue of light through snow, predicted from what the snow is made of
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, after_help = "Every command tells its options with --help.")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    /// Threads to work on [default: one for each core]; results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Say nothing but results
    #[arg(long, global = true)]
    quiet: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    Spectrum(Box<spectrum::Spectrum>),
    Bsdf(Box<bsdf::Bsdf>),
    Slab(slab::Slab),
    #[command(subcommand)]
    Database(database::Database),
    Color(Box<color::Color>),
    Render(render::Render),
}

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
        Command::Color(command) => command.run(arguments.quiet),
        Command::Render(command) => command.run(arguments.quiet),
    }
}
