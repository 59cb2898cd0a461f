//! What the command line may say.

use clap::{Parser, Subcommand};

use crate::{bsdf, color, database, figures, match_command, merge, render, slab, spectrum, swatch};

/// The blue of light through snow, predicted from what the snow is made of
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, after_help = "Every command tells its options with --help.")]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Threads to work on [default: one for each core]; results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Say nothing but results
    #[arg(long, global = true)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Spectrum(Box<spectrum::Spectrum>),
    Bsdf(Box<bsdf::Bsdf>),
    Slab(slab::Slab),
    #[command(subcommand)]
    Database(database::Database),
    Merge(merge::Merge),
    Color(Box<color::Color>),
    Match(Box<match_command::Match>),
    Swatch(Box<swatch::Swatch>),
    Render(render::Render),
    Figures(figures::Figures),
}
