//! Fills a table or a shard: axes, engine and progress.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use snowblue_database::fill::{self, Engine, FillOptions, FillProgress, FillStage};
use snowblue_database::{Axes, DatabaseError, Table};
use snowblue_transport::monte_carlo;
use snowblue_transport::optics::IceTable;

use super::axes::AxesOptions;
use crate::options::{Idle, OrdinatesArguments, parse};
use crate::output::{Failure, Progress};

/// How to fill a table
#[derive(Debug, Args)]
#[command(next_help_heading = "Engine")]
pub(super) struct Filling {
    #[command(flatten)]
    axes: AxesOptions,
    /// Table of the absorption of ice: warren2008 or picard2016; the two differ in the blue
    #[arg(
        long, value_name = "TABLE", default_value = "warren2008", value_parser = parse::ice, help_heading = "Engine"
    )]
    ice: IceTable,
    /// Method of solution
    #[arg(long, value_name = "ENGINE", value_enum, default_value = "ordinates", help_heading = "Engine")]
    engine: EngineArgument,
    /// Rays of the scattering tally for each facetness and index node; 1048576 give an error of 0.1 % in the
    /// transmittance of 15 cm [1024–1048576]
    #[arg(
        long, value_name = "N", default_value_t = 1 << 20,
        value_parser = parse::whole_number::<u32>(1024..=1 << 20), help_heading = "Engine"
    )]
    tally_rays: u32,
    /// Rays of the Monte Carlo engine for each sample, angle and index node
    #[arg(
        long, value_name = "N", default_value_t = monte_carlo::DEFAULT_RAYS, value_parser = parse::rays(),
        help_heading = "Engine"
    )]
    rays: u64,
    #[command(flatten)]
    pub(super) ordinates: OrdinatesArguments,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EngineArgument {
    /// Discrete ordinates
    Ordinates,
    /// Monte Carlo random walk from grain to grain; keeps its standard errors
    Montecarlo,
}

/// A filled table or shard, and a description of the times.
pub(super) struct Filled<T> {
    pub(super) table: T,
    pub(super) times: String,
}

impl Filling {
    fn options(&self) -> FillOptions {
        let engine = match self.engine {
            EngineArgument::Ordinates => {
                Engine::Ordinates { streams: self.ordinates.streams, tally_rays: self.tally_rays }
            }
            EngineArgument::Montecarlo => Engine::MonteCarlo { rays: self.rays },
        };
        FillOptions { engine, seed: self.ordinates.seed, ice: self.ice }
    }

    /// Options of the engine that is not used.
    pub(super) fn idle(&self) -> [Idle<'static>; 2] {
        [
            Idle {
                when: self.engine == EngineArgument::Ordinates,
                options: &["rays"],
                why: "it belongs to --engine montecarlo; --tally-rays sets the rays through single grains",
            },
            Idle {
                when: self.engine == EngineArgument::Montecarlo,
                options: &["streams", "tally_rays"],
                why: "it belongs to --engine ordinates",
            },
        ]
    }

    /// Fills a table or a shard by `fill`.
    pub(super) fn fill<T>(
        &self,
        quiet: bool,
        fill: impl Fn(&Axes, &FillOptions, &(dyn Fn(FillProgress) + Sync)) -> Result<T, DatabaseError>,
    ) -> Result<Filled<T>, Failure> {
        let axes = self.axes.axes(self.ice)?;
        let bar = Progress::new("steps", quiet);
        let (start, tallied) = (Instant::now(), OnceLock::<Duration>::new());
        let filled = fill(&axes, &self.options(), &|progress| {
            if progress.stage == FillStage::Solve {
                tallied.get_or_init(|| start.elapsed());
            }
            bar.set(progress.done, progress.total);
        });
        let elapsed = start.elapsed();
        bar.finish();
        let table = filled.map_err(Failure::input)?;
        let tally = tallied.get().copied().unwrap_or_default();
        let (tally, solve) = (tally.as_secs_f64(), (elapsed - tally).as_secs_f64());
        let threads = rayon::current_num_threads();
        let times = format!("T and R: tally {tally:.2} s, solve {solve:.2} s, {threads} threads");
        Ok(Filled { table, times })
    }

    /// Fills a table.
    pub(super) fn table(&self, quiet: bool) -> Result<Filled<Table>, Failure> {
        self.fill(quiet, fill::fill)
    }
}
