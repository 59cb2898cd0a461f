//! `snowblue database build`: fills a table and writes it.

use std::path::PathBuf;

use clap::Args;
use snowblue_database::fill::{FillOptions, FillProgress};
use snowblue_database::shard::{self, Part};
use snowblue_database::table::StandardErrors;
use snowblue_database::{Axes, Quantity, Table};

use super::filling::{Filled, Filling};
use crate::options::{Compression, GivenOptions};
use crate::output::{Failure, Outcome, check_table_path, output_path, print_notes};

/// Fill a table and write it as NetCDF
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  snowblue database build -o full.nc                      the paper's 24,750 curves, uncompressed
  snowblue database build --space linear --components 2 -o paper.nc
  snowblue database build --space log --max-delta-e 2.3 --illuminant D65,E -o small.nc
  snowblue database build --preset default --space log --components 3 -o snow.nc
  snowblue database build --water-saturation 0,0.1,0.3 --impurity black-carbon=0:100 -o wet.nc
  snowblue database build --grain-size 300 --facetness 0.3 --engine montecarlo --rays 10000 -o mc.nc
  snowblue database build --shard 2/8 -o part2.nc         one shard, for 'snowblue merge'"
)]
pub(crate) struct Build {
    /// Must be the first field.
    #[command(flatten)]
    given: GivenOptions,
    #[command(flatten)]
    filling: Filling,
    /// Fill only one shard of the table, as 2/8
    #[arg(long, value_name = "PART/PARTS", conflicts_with = "Compression", help_heading = "Output")]
    shard: Option<Part>,
    #[command(flatten)]
    compression: Compression,
    /// Table to write (.nc, NetCDF)
    #[arg(short, long, value_name = "FILE", value_parser = output_path(), help_heading = "Output")]
    output: PathBuf,
}

impl Build {
    pub(super) fn run(&self, quiet: bool) -> Outcome {
        check_table_path(&self.output)?;
        self.compression.check()?;
        self.given.refuse_idle(&self.filling.idle())?;
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
        print_notes(quiet, [format!("{}: {summary}", self.output.display())]);
        Ok(())
    }
}

/// Mean of the standard errors, and the fraction of large errors.
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
