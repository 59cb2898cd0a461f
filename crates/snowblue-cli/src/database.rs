//! `snowblue database`: build a table, tell about it, judge its compression.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use snowblue_database::fidelity::{self, PERCEPTIBLE_DELTA_E};
use snowblue_database::file::{self, AnyTable};
use snowblue_database::fill::{self, FillOptions};
use snowblue_database::pca::Decomposition;
use snowblue_database::{Axes, CompressedTable, DatabaseError, Quantity, Space, Table};

use crate::failure::{Failure, Outcome};
use crate::options::{IceWord, LightOptions, OrdinatesWords, OutputOptions};
use crate::progress::Progress;
use crate::report::{Cell, Report, check_place, figures, print, tell};

/// Build, inspect and judge tables of snow
#[derive(Debug, Subcommand)]
pub(crate) enum Database {
    Build(Build),
    Info(Info),
    Fidelity(Fidelity),
}

/// Fill a table by discrete ordinates and write it as NetCDF
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  snowblue database build -o full.nc                                  the paper's 24,750 curves, every value
  snowblue database build --space linear --components 2 -o paper.nc   as the paper keeps them
  snowblue database build --preset default --space log --components 3 -o snow.nc"
)]
pub(crate) struct Build {
    #[command(flatten)]
    filling: Filling,
    /// Compress in this space; without it the full table is written
    #[arg(long, value_name = "SPACE", value_enum, requires = "components")]
    space: Option<SpaceWord>,
    /// Principal components to keep [1–31]
    #[arg(long, value_name = "N", requires = "space")]
    components: Option<usize>,
    /// Where to write the table (NetCDF)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

/// How to fill a table
#[derive(Debug, Args)]
#[command(next_help_heading = "Engine")]
struct Filling {
    /// Axes of the table
    #[arg(long, value_name = "PRESET", value_enum, default_value = "paper")]
    preset: Preset,
    /// Whose absorption of ice to use; the two differ in the blue
    #[arg(long, value_name = "TABLE", value_enum, default_value = "warren2008")]
    ice: IceWord,
    /// Rays at grains per facetness and index node; 1048576 leave 0.1 % in the transmittance of 15 cm [1024–1048576]
    #[arg(long, value_name = "N", default_value_t = 1 << 20, value_parser = clap::value_parser!(u32).range(1024..=1 << 20))]
    tally_rays: u32,
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

/// Judge how well 1–4 principal components keep every curve of a full table, beside the paper's claims
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  snowblue database fidelity full.nc
  snowblue database fidelity --illuminant E --format csv -o fidelity.csv"
)]
pub(crate) struct Fidelity {
    /// Full table to judge [default: the paper's axes, filled now]
    #[arg(conflicts_with_all = ["Filling", "OrdinatesWords"])]
    file: Option<PathBuf>,
    #[command(flatten)]
    filling: Filling,
    #[command(flatten)]
    light: LightOptions,
    #[command(flatten)]
    output: OutputOptions,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Preset {
    /// Table 1 of the paper: 24,750 curves
    Paper,
    /// The same with thin and thick knots, as embedded: 54,000 curves
    Default,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SpaceWord {
    Linear,
    Log,
}

impl Database {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        match self {
            Self::Build(build) => build.run(quiet),
            Self::Info(info) => info.run(),
            Self::Fidelity(fidelity) => fidelity.run(quiet),
        }
    }
}

impl Filling {
    /// Fills the table; the second value says how long the parts took.
    fn fill(&self, quiet: bool) -> Result<(Table, String), Failure> {
        let axes = match self.preset {
            Preset::Paper => Axes::paper(),
            Preset::Default => Axes::with_thin_and_thick_knots(),
        };
        let options = FillOptions {
            streams: self.ordinates.streams,
            tally_rays: self.tally_rays,
            seed: self.ordinates.seed,
            ice: self.ice.table(),
        };
        let bar = Progress::new("steps", quiet);
        let filled = fill::by_ordinates(&axes, &options, &|done, all| bar.at(done as u64, all as u64));
        bar.end();
        let (table, times) = filled.map_err(Failure::input)?;
        let curves = table.axes.curves();
        let (tally, solve) = (times.tally.as_secs_f64(), times.solve.as_secs_f64());
        let threads = rayon::current_num_threads();
        let times = format!("{curves} curves, T and R: tally {tally:.2} s, solve {solve:.2} s, {threads} threads");
        Ok((table, times))
    }
}

impl Build {
    fn run(&self, quiet: bool) -> Outcome {
        check_place(&self.output)?;
        let (table, times) = self.filling.fill(quiet)?;
        match (self.space, self.components) {
            (Some(space), Some(components)) => {
                let compressed = CompressedTable::new(&table, space.space(), components).map_err(Failure::input)?;
                compressed.write(&self.output).map_err(Failure::work)?;
            }
            _ => table.write(&self.output).map_err(Failure::work)?,
        }
        if !quiet {
            tell(&format!("{}: {times}\n", self.output.display()));
        }
        Ok(())
    }
}

impl SpaceWord {
    fn space(self) -> Space {
        match self {
            Self::Linear => Space::Linear,
            Self::Log => Space::Log,
        }
    }
}

impl Info {
    fn run(&self) -> Outcome {
        let (name, table) = match &self.file {
            Some(path) => (path.display().to_string(), file::read(path).map_err(Failure::input)?),
            None => ("embedded table".to_owned(), AnyTable::Compressed(snowblue_data::embedded().clone())),
        };
        let (axes, metadata, kind) = match &table {
            AnyTable::Full(table) => (&table.axes, &table.metadata, "every value".to_owned()),
            AnyTable::Compressed(table) => {
                let components = table.transmittance.count;
                (&table.axes, &table.metadata, format!("{components} components in {} space", table.space.name()))
            }
        };
        let mut text = format!("{name}: {} curves of {} samples, {kind}\n", axes.curves(), axes.samples());
        for (axis, unit, values) in axes.named() {
            let values: Vec<String> = values.iter().map(|value| figures(*value)).collect();
            let unit = if unit == "1" { String::new() } else { format!(" ({unit})") };
            text.push_str(&format!("  {axis}{unit}: {}\n", values.join(" ")));
        }
        for (attribute, value) in metadata {
            text.push_str(&format!("  {attribute}: {value}\n"));
        }
        print(&text)
    }
}

const FIDELITY_COLUMNS: [&str; 11] = [
    "quantity",
    "space",
    "components",
    "rmse_worst",
    "rmse_p99",
    "rmse_mean",
    "delta_e_worst",
    "delta_e_p99",
    "delta_e_mean",
    "share_above_2.3",
    "negative_values",
];

impl Fidelity {
    fn run(&self, quiet: bool) -> Outcome {
        let (table, _) = match &self.file {
            None => self.filling.fill(quiet)?,
            Some(path) => match file::read(path).map_err(Failure::input)? {
                AnyTable::Full(table) => (table, String::new()),
                AnyTable::Compressed(_) => {
                    let what = "is compressed; fidelity is judged on a full table (database build without --space)";
                    return Err(Failure::Input(format!("{}: {what}", path.display())));
                }
            },
        };
        let rows = self.judge(&table).map_err(Failure::input)?;
        let claim = "l' = 2 linear: every ΔE below 2.3 and RMSE below 0.002";
        let metadata = vec![
            ("snowblue", env!("CARGO_PKG_VERSION").to_owned()),
            ("illuminant", self.light.illuminant.name().to_owned()),
            ("curves", table.axes.curves().to_string()),
            ("the paper claims", claim.to_owned()),
        ];
        Report { columns: FIDELITY_COLUMNS.to_vec(), rows, metadata }.write(&self.output, quiet)
    }

    fn judge(&self, table: &Table) -> Result<Vec<Vec<Cell>>, DatabaseError> {
        let mut rows = Vec::new();
        for quantity in Quantity::ALL {
            for space in [Space::Linear, Space::Log] {
                let decomposition = Decomposition::new(table, quantity, space)?;
                for components in 1..=4.min(decomposition.singular_values().len()) {
                    let kept = decomposition.keep(table, quantity, components)?;
                    let found = fidelity::judge(table, quantity, (&kept, space), self.light.illuminant)?;
                    let mut row = vec![Cell::Word(quantity.name().to_owned()), Cell::Word(space.name().to_owned())];
                    let (rmse, delta_e) = (&found.rmse, &found.delta_e);
                    let numbers = [
                        components as f64,
                        rmse.worst,
                        rmse.percentile_99,
                        rmse.mean,
                        delta_e.worst,
                        delta_e.percentile_99,
                        delta_e.mean,
                        found.perceptible_share,
                        found.negative_values as f64,
                    ];
                    debug_assert!(PERCEPTIBLE_DELTA_E.to_bits() == 2.3_f64.to_bits(), "the column says 2.3");
                    row.extend(numbers.map(Cell::from));
                    rows.push(row);
                }
            }
        }
        Ok(rows)
    }
}
