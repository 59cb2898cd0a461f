//! The command line: global options and the list of commands.

use clap::{Parser, Subcommand};

use crate::commands::bake::Bake;
use crate::commands::bsdf::Bsdf;
use crate::commands::color::Color;
use crate::commands::database::Database;
use crate::commands::export::Export;
use crate::commands::figures::Figures;
use crate::commands::match_color::Match;
use crate::commands::merge::Merge;
use crate::commands::render::Render;
use crate::commands::sky::Sky;
use crate::commands::slab::Slab;
use crate::commands::spectrum::Spectrum;
use crate::commands::swatch::Swatch;

/// Predicts the blue of light through snow from what the snow is made of
#[derive(Debug, Parser)]
#[command(
    version,
    propagate_version = true,
    after_help = "Examples:
  snowblue spectrum --thickness 15              reflectance and transmittance of 15 cm of snow
  snowblue color --thickness 5,10,15,30         the colour of the light behind it
  snowblue render scene.toml -o picture.png     a picture of a scene with snow

'snowblue COMMAND --help' describes a command with its options, units and examples. Exit codes: 0 success, 1 failure, \
2 bad input, 130 interrupted."
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Number of threads [1–1024; default: one for each core]; results do not depend on it
    #[arg(
        long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024),
        help_heading = "Global options"
    )]
    pub(crate) threads: Option<u16>,
    /// Print results and errors only
    #[arg(long, global = true, help_heading = "Global options")]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Spectrum(Box<Spectrum>),
    Bsdf(Box<Bsdf>),
    Slab(Slab),
    Sky(Sky),
    #[command(subcommand)]
    Database(Database),
    Merge(Merge),
    Color(Box<Color>),
    Match(Box<Match>),
    Swatch(Box<Swatch>),
    Render(Render),
    Bake(Bake),
    #[command(subcommand)]
    Export(Export),
    Figures(Figures),
}
