//! `snowblue database`: builds, describes, judges and exports tables.

mod axes;
mod filling;

mod build;
mod export;
mod fidelity;
mod info;

use clap::Subcommand;

use crate::output::Outcome;
use build::Build;
use export::Export;
use fidelity::Fidelity;
use info::Info;

/// Build, describe, judge and export tables of snow
#[derive(Debug, Subcommand)]
pub(crate) enum Database {
    Build(Box<Build>),
    Info(Info),
    Fidelity(Box<Fidelity>),
    Export(Export),
}

impl Database {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        match self {
            Self::Build(build) => build.run(quiet),
            Self::Info(info) => info.run(),
            Self::Fidelity(fidelity) => fidelity.run(quiet),
            Self::Export(export) => export.run(),
        }
    }
}
