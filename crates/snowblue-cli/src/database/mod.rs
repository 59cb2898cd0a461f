//! `snowblue database`: build a table, tell about it, judge its compression, exchange it.

mod axes;
mod compression;
mod exchange;
mod fidelity;

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use snowblue_database::file::{self, AnyTable};
use snowblue_database::fill::{self, Engine, FillOptions, FillTimes};
use snowblue_database::shard::{self, Part};
use snowblue_database::{Axes, DatabaseError, Table};
use snowblue_transport::monte_carlo;

use crate::failure::{Failure, Outcome};
use crate::options::{IceWord, OrdinatesWords};
use crate::parse;
use crate::progress::Progress;
use crate::report::{check_table_place, figures, print, tell};

use axes::AxesOptions;
pub(crate) use compression::Compression;
use exchange::{Export, Import};
use fidelity::Fidelity;

/// Build, inspect, judge and exchange tables of snow
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
  snowblue database build --space linear --components 2 -o paper.nc   as the paper keeps them
  snowblue database build --space log --max-delta-e 2.3 --max-rmse 0.002 --illuminant D65,E -o small.nc
  snowblue database build --preset default --space log --components 3 -o snow.nc
  snowblue database build --density 300 --water-saturation 0,0.1,0.3 --impurity black-carbon=0:10:100 -o wet.nc
  snowblue database build --grain-size 300 --facetness 0.3 --engine montecarlo --rays 10000 -o walked.nc
  snowblue database build --shard 2/8 -o part2.nc                     one part; 'snowblue merge' puts them together"
)]
pub(crate) struct Build {
    #[command(flatten)]
    filling: Filling,
    /// Fill only a part of the table, PART/PARTS
    #[arg(long, value_name = "PART", conflicts_with = "Compression")]
    shard: Option<Part>,
    #[command(flatten)]
    compression: Compression,
    /// Where to write the table (NetCDF)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

/// How to fill a table
#[derive(Debug, Args)]
#[command(next_help_heading = "Engine")]
struct Filling {
    #[command(flatten)]
    axes: AxesOptions,
    /// Whose absorption of ice to use; the two differ in the blue
    #[arg(long, value_name = "TABLE", value_enum, default_value = "warren2008")]
    ice: IceWord,
    /// Discrete ordinates, or the Monte Carlo walk from grain to grain, whose standard errors are kept too
    #[arg(long, value_name = "ENGINE", value_enum, default_value = "ordinates")]
    engine: EngineWord,
    /// Rays at grains per facetness and index node; 1048576 leave 0.1 % in the transmittance of 15 cm [1024–1048576]
    #[arg(long, value_name = "N", default_value_t = 1 << 20, value_parser = clap::value_parser!(u32).range(1024..=1 << 20))]
    tally_rays: u32,
    /// Rays of the Monte Carlo engine for each kind of grain, angle and index node
    #[arg(long, value_name = "N", default_value_t = monte_carlo::DEFAULT_RAYS, value_parser = parse::count)]
    rays: u64,
    #[command(flatten)]
    ordinates: OrdinatesWords,
}

/// Tell what a table holds and how it was made
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  snowblue database info            the embedded table
  snowblue database info paper.nc"
)]
pub(crate) struct Info {
    /// Table to read [default: the embedded one]
    file: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EngineWord {
    Ordinates,
    Montecarlo,
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
            EngineWord::Ordinates => Engine::Ordinates { streams: self.ordinates.streams, tally_rays: self.tally_rays },
            EngineWord::Montecarlo => Engine::MonteCarlo { rays: self.rays },
        };
        FillOptions { engine, seed: self.ordinates.seed, ice: self.ice.table() }
    }

    /// Fills something on the axes by `fill`, and says how long the parts took.
    fn fill<T>(
        &self,
        quiet: bool,
        fill: impl Fn(&Axes, &FillOptions, &(dyn Fn(u64, u64) + Sync)) -> Result<(T, FillTimes), DatabaseError>,
    ) -> Result<(T, String), Failure> {
        let axes = self.axes.axes(self.ice.table())?;
        let bar = Progress::new("steps", quiet);
        let filled = fill(&axes, &self.options(), &|done, all| bar.at(done, all));
        bar.end();
        let (filled, times) = filled.map_err(Failure::input)?;
        let (tally, solve) = (times.tally.as_secs_f64(), times.solve.as_secs_f64());
        let threads = rayon::current_num_threads();
        Ok((filled, format!("T and R: tally {tally:.2} s, solve {solve:.2} s, {threads} threads")))
    }

    fn table(&self, quiet: bool) -> Result<(Table, String), Failure> {
        self.fill(quiet, fill::fill)
    }
}

impl Build {
    fn run(&self, quiet: bool) -> Outcome {
        check_table_place(&self.output)?;
        self.compression.check()?;
        let told = if let Some(part) = self.shard {
            let (shard, times) =
                self.filling.fill(quiet, |axes, options, told| shard::fill_part(axes, options, part, told))?;
            shard.write(&self.output).map_err(Failure::work)?;
            format!("part {part} of {} curves, {times}", shard.axes.curves())
        } else {
            let (table, times) = self.filling.table(quiet)?;
            let kept = self.compression.write(&table, &self.output)?;
            let noise = table.errors.as_ref().map_or(String::new(), |errors| noise(&table, errors));
            format!("{} curves{kept}, {times}{noise}", table.axes.curves())
        };
        if !quiet {
            tell(&format!("{}: {told}\n", self.output.display()));
        }
        Ok(())
    }
}

/// What the standard errors of a table are like.
fn noise(table: &Table, errors: &[Vec<f64>; 2]) -> String {
    let values = [&table.transmittance, &table.reflectance];
    let words = values.into_iter().zip(errors).zip(["T", "R"]).map(|((values, errors), name)| {
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let relative = errors.iter().zip(values).map(|(error, value)| error / value.abs());
        let share = 100.0 * relative.clone().filter(|share| *share > 0.1).count() as f64 / errors.len() as f64;
        format!("; standard error of {name}: mean {mean:.2e}, {share:.1} % of the values above a tenth of themselves")
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
            AnyTable::Full(table) => (&table.axes, &table.metadata, "every value".to_owned()),
            AnyTable::Shard(shard) => (&shard.axes, &shard.metadata, format!("of which this is part {}", shard.part)),
            AnyTable::Compressed(table) => {
                let components = table.transmittance.count;
                (&table.axes, &table.metadata, format!("{components} components in {} space", table.space.name()))
            }
        };
        let mut text = format!("{name}: {} curves of {} kinds of snow, {kind}\n", axes.curves(), axes.samples());
        for (axis, unit, values) in axes.named() {
            let value =
                |value: &f64| if axis == "angle" && *value < 0.0 { "diffuse".to_owned() } else { figures(*value) };
            let values: Vec<String> = values.iter().map(value).collect();
            let unit = if unit == "1" { String::new() } else { format!(" ({unit})") };
            text.push_str(&format!("  {axis}{unit}: {}\n", values.join(" ")));
        }
        for (attribute, value) in metadata {
            text.push_str(&format!("  {attribute}: {value}\n"));
        }
        print(&text)
    }
}
