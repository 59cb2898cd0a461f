//! `snowblue database`: builds, describes, judges and exchanges tables.

mod axes;
mod exchange;
mod fidelity;

use std::path::PathBuf;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use clap::{Args, Subcommand, ValueEnum};
use snowblue_database::axes::NamedAxis;
use snowblue_database::file::{self, AnyTable};
use snowblue_database::fill::{self, Engine, FillOptions, FillProgress, FillStage};
use snowblue_database::shard::{self, Part};
use snowblue_database::table::{Attribute, StandardErrors};
use snowblue_database::{Axes, DatabaseError, Quantity, Table};
use snowblue_transport::monte_carlo;

use crate::options::{Compression, IceArgument, OrdinatesArguments, parse};
use crate::output::{Failure, Outcome, Progress, check_table_path, print, print_message};
use axes::AxesOptions;
use exchange::{Export, Import};
use fidelity::Fidelity;
use snowblue_figures::format_number;

/// Build, describe, judge and exchange tables of snow
#[derive(Debug, Subcommand)]
pub(crate) enum Database {
    Build(Box<Build>),
    Info(Info),
    Fidelity(Box<Fidelity>),
    Import(Import),
    Export(Export),
}

/// Fill a table and write it as NetCDF
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  snowblue database build -o full.nc                                  the paper's 24,750 curves, every value
  snowblue database build --space linear --components 2 -o paper.nc   the paper's compression
  snowblue database build --space log --max-delta-e 2.3 --max-rmse 0.002 --illuminant D65,E -o small.nc
  snowblue database build --preset default --space log --components 3 -o snow.nc
  snowblue database build --density 300 --water-saturation 0,0.1,0.3 --impurity black-carbon=0:10:100 -o wet.nc
  snowblue database build --grain-size 300 --facetness 0.3 --engine montecarlo --rays 10000 -o mc.nc
  snowblue database build --shard 2/8 -o part2.nc                     one shard, for 'snowblue merge'"
)]
pub(crate) struct Build {
    #[command(flatten)]
    filling: Filling,
    /// Fill only one shard of the table, as 2/8
    #[arg(long, value_name = "PART/PARTS", conflicts_with = "Compression")]
    shard: Option<Part>,
    #[command(flatten)]
    compression: Compression,
    /// Table to write (.nc, NetCDF)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

/// How to fill a table
#[derive(Debug, Args)]
#[command(next_help_heading = "Engine")]
struct Filling {
    #[command(flatten)]
    axes: AxesOptions,
    /// Table of the absorption of ice; the two differ in the blue
    #[arg(long, value_name = "TABLE", value_enum, default_value = "warren2008")]
    ice: IceArgument,
    /// Method of solution
    #[arg(long, value_name = "ENGINE", value_enum, default_value = "ordinates")]
    engine: EngineArgument,
    /// Rays of the scattering tally for each facetness and index node; 1048576 give an error of 0.1 % in the
    /// transmittance of 15 cm [1024–1048576]
    #[arg(
        long, value_name = "N", default_value_t = 1 << 20,
        value_parser = clap::value_parser!(u32).range(1024..=1 << 20)
    )]
    tally_rays: u32,
    /// Rays of the Monte Carlo engine for each sample, angle and index node
    #[arg(long, value_name = "N", default_value_t = monte_carlo::DEFAULT_RAYS, value_parser = parse::count)]
    rays: u64,
    #[command(flatten)]
    ordinates: OrdinatesArguments,
}

/// Describe a table: axes, compression and metadata
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  snowblue database info            the embedded table
  snowblue database info paper.nc"
)]
pub(crate) struct Info {
    /// Table to describe [default: the embedded one]
    file: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EngineArgument {
    /// Discrete ordinates
    Ordinates,
    /// Monte Carlo random walk from grain to grain; keeps its standard errors
    Montecarlo,
}

/// A filled table or shard, and a description of the times.
struct Filled<T> {
    table: T,
    times: String,
}

impl Database {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        match self {
            Self::Build(build) => build.run(quiet),
            Self::Info(info) => info.run(),
            Self::Fidelity(fidelity) => fidelity.run(quiet),
            Self::Import(import) => import.run(quiet),
            Self::Export(export) => export.run(),
        }
    }
}

impl Filling {
    fn options(&self) -> FillOptions {
        let engine = match self.engine {
            EngineArgument::Ordinates => {
                Engine::Ordinates { streams: self.ordinates.streams, tally_rays: self.tally_rays }
            }
            EngineArgument::Montecarlo => Engine::MonteCarlo { rays: self.rays },
        };
        FillOptions { engine, seed: self.ordinates.seed, ice: self.ice.table() }
    }

    /// Fills a table or a shard by `fill`.
    fn fill<T>(
        &self,
        quiet: bool,
        fill: impl Fn(&Axes, &FillOptions, &(dyn Fn(FillProgress) + Sync)) -> Result<T, DatabaseError>,
    ) -> Result<Filled<T>, Failure> {
        let axes = self.axes.axes(self.ice.table())?;
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

    fn table(&self, quiet: bool) -> Result<Filled<Table>, Failure> {
        self.fill(quiet, fill::fill)
    }
}

impl Build {
    fn run(&self, quiet: bool) -> Outcome {
        check_table_path(&self.output)?;
        self.compression.check()?;
        let summary = if let Some(part) = self.shard {
            let fill = |axes: &Axes, options: &FillOptions, progress: &(dyn Fn(FillProgress) + Sync)| {
                shard::fill_part(axes, options, part, progress)
            };
            let Filled { table: shard, times } = self.filling.fill(quiet, fill)?;
            shard.write(&self.output).map_err(Failure::work)?;
            format!("part {part} of {} curves, {times}", shard.axes.curves())
        } else {
            let Filled { table, times } = self.filling.table(quiet)?;
            let kept = self.compression.write(&table, &self.output)?;
            let noise = table.errors.as_ref().map_or(String::new(), |errors| describe_errors(&table, errors));
            format!("{} curves{kept}, {times}{noise}", table.axes.curves())
        };
        if !quiet {
            print_message(&format!("{}: {summary}\n", self.output.display()));
        }
        Ok(())
    }
}

/// Mean of the standard errors, and the fraction of large ones.
fn describe_errors(table: &Table, errors: &StandardErrors) -> String {
    let words = Quantity::ALL.into_iter().zip(["T", "R"]).map(|(quantity, name)| {
        let (values, errors) = (table.values(quantity), errors.of(quantity));
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let relative = errors.iter().zip(values).map(|(error, value)| error / value.abs());
        let large = 100.0 * relative.clone().filter(|error| *error > 0.1).count() as f64 / errors.len() as f64;
        format!("; standard error of {name}: mean {mean:.2e}, above 10 % for {large:.1} % of the values")
    });
    words.collect()
}

impl Info {
    fn run(&self) -> Outcome {
        let (name, table) = match &self.file {
            Some(path) => (path.display().to_string(), file::read(path).map_err(Failure::input)?),
            None => ("embedded table".to_owned(), AnyTable::Compressed(snowblue_data::embedded().clone())),
        };
        let (axes, metadata, kind) = match &table {
            AnyTable::Full(table) => (&table.axes, &table.metadata, "uncompressed".to_owned()),
            AnyTable::Shard(shard) => (&shard.axes, &shard.metadata, format!("shard {}", shard.part)),
            AnyTable::Compressed(table) => {
                let components = table.transmittance.count;
                (&table.axes, &table.metadata, format!("{components} components in {} space", table.space.name()))
            }
        };
        let mut text = format!("{name}: {} curves of {} kinds of snow, {kind}\n", axes.curves(), axes.samples());
        for NamedAxis { name: axis, unit, values } in axes.named() {
            let value = |value: &f64| {
                if axis == "angle" && *value < 0.0 { "diffuse".to_owned() } else { format_number(*value) }
            };
            let values: Vec<String> = values.iter().map(value).collect();
            let unit = if unit == "1" { String::new() } else { format!(" ({unit})") };
            text.push_str(&format!("  {axis}{unit}: {}\n", values.join(" ")));
        }
        for Attribute { name, value } in metadata {
            text.push_str(&format!("  {name}: {value}\n"));
        }
        print(&text).map_err(Failure::work)
    }
}
