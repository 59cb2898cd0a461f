//! Engines, and options of the discrete ordinates.

use clap::{Args, ValueEnum};
use snowblue_transport::ordinates::{OrdinatesOptions, Streams};

use super::parse;

/// An engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Engine {
    /// Discrete ordinates
    Ordinates,
    /// Monte Carlo random walk from grain to grain
    Montecarlo,
}

/// Options of the discrete ordinates.
#[derive(Debug, Clone, Copy, Args)]
#[command(next_help_heading = "Engine")]
pub(crate) struct OrdinatesArguments {
    /// Streams of both hemispheres together: an even number, or 'auto': 16 up to 80° and for diffuse light, 48 above;
    /// 64 and 128 in wet snow and with algae
    #[arg(long, value_name = "N", default_value = "auto", value_parser = parse::streams)]
    pub(crate) streams: Streams,
    /// Seed of random numbers; the ordinates too send rays, through single grains
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = parse::seed())]
    pub(crate) seed: u64,
}

impl OrdinatesArguments {
    pub(crate) fn options(self) -> OrdinatesOptions {
        OrdinatesOptions { streams: self.streams, seed: self.seed, ..OrdinatesOptions::default() }
    }
}
