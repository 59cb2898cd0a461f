//! `snowblue merge`: parts that were made apart become one.

use std::path::{Path, PathBuf};

use clap::Args;
use snowblue_database::file::{self, AnyTable};
use snowblue_database::shard::{self, Shard};

use crate::database::Compression;
use crate::failure::{Failure, Outcome};
use crate::report::{check_table_place, tell};

/// Put all shards of a table together (database build --shard)
#[derive(Debug, Args)]
#[command(after_help = "The merged table is the one that an unsharded build makes, to the last bit.

Examples:
  snowblue database build --shard 1/3 -o part1.nc    (and 2/3, 3/3, on machines of one kind)
  snowblue merge part1.nc part2.nc part3.nc -o full.nc
  snowblue merge part*.nc --space log --components 3 -o snow.nc")]
pub(crate) struct Merge {
    /// Every shard, in any order
    #[arg(required = true, value_name = "SHARD")]
    shards: Vec<PathBuf>,
    #[command(flatten)]
    compression: Compression,
    /// Where to write the table (NetCDF)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

impl Merge {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        check_table_place(&self.output)?;
        self.compression.check()?;
        let shards: Result<Vec<(String, Shard)>, Failure> = self.shards.iter().map(|path| read(path)).collect();
        let table = shard::merge(&shards?).map_err(Failure::input)?;
        let kept = self.compression.write(&table, &self.output)?;
        if !quiet {
            tell(&format!(
                "{}: {} curves of {} shards{kept}\n",
                self.output.display(),
                table.axes.curves(),
                self.shards.len()
            ));
        }
        Ok(())
    }
}

fn read(path: &Path) -> Result<(String, Shard), Failure> {
    let name = path.display().to_string();
    match file::read(path).map_err(Failure::input)? {
        AnyTable::Shard(shard) => Ok((name, shard)),
        other => Err(Failure::Input(format!("{name}: is {}, not a shard", other.kind()))),
    }
}
