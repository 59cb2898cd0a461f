//! The `snowblue` command: predicts the blue of light through snow from what the snow is made of.
//!
//! ```text
//! arguments ─► commands ─► options (values of options) ─► output (results, errors, exit codes)
//!                       └► input (settings, spectra)  ─┘
//! ```

mod output;

mod options;

mod input;

mod commands;

mod arguments;

use clap::{CommandFactory as _, Parser as _};

use arguments::{Arguments, Command};
use output::{Failure, Outcome, exit_code};

fn main() -> std::process::ExitCode {
    exit_code(&run())
}

fn run() -> Outcome {
    let arguments = Arguments::try_parse()?;
    let threads = usize::from(arguments.threads.unwrap_or(0));
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().map_err(Failure::work)?;
    match arguments.command {
        Command::Spectrum(command) => command.run(arguments.quiet),
        Command::Bsdf(command) => command.run(arguments.quiet),
        Command::Slab(command) => command.run(arguments.quiet),
        Command::Sky(command) => command.run(arguments.quiet),
        Command::Database(command) => command.run(arguments.quiet),
        Command::Merge(command) => command.run(arguments.quiet),
        Command::Color(command) => command.run(arguments.quiet),
        Command::Match(command) => command.run(arguments.quiet),
        Command::Swatch(command) => command.run(),
        Command::Render(command) => command.run(arguments.quiet),
        Command::Bake(command) => command.run(arguments.quiet),
        Command::Repair(command) => command.run(arguments.quiet),
        Command::Export(command) => command.run(),
        Command::Figures(command) => command.run(arguments.quiet),
        Command::Schema(command) => command.run(),
        Command::Completions(command) => command.run(Arguments::command()),
        Command::Man(command) => command.run(Arguments::command()),
    }
}
