//! `snowblue database info`: describes a table.

use std::path::PathBuf;

use clap::Args;
use snowblue_database::axes::NamedAxis;
use snowblue_database::file::{self, AnyTable};
use snowblue_database::table::Attribute;
use snowblue_figures::format_number;

use crate::output::{Failure, Outcome, print, printable};

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

impl Info {
    pub(super) fn run(&self) -> Outcome {
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
            text.push_str(&format!("  {}: {}\n", printable(name), printable(value)));
        }
        print(&text).map_err(Failure::work)
    }
}
