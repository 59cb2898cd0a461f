//! Compression of a table into principal components.

use std::path::Path;

use clap::{Args, ValueEnum};
use snowblue_color::Illuminant;
use snowblue_database::fidelity::{self, Criteria};
use snowblue_database::{CompressedTable, Space, Table};

use super::parse;
use crate::output::{Failure, Outcome};

/// How to compress a table
#[derive(Debug, Args)]
#[command(next_help_heading = "Compression")]
pub(crate) struct Compression {
    /// Space of the principal components; without this option the full table is written
    #[arg(long, value_name = "SPACE", value_enum)]
    space: Option<SpaceArgument>,
    /// Number of principal components [1–31]
    #[arg(
        long, value_name = "N", requires = "space", conflicts_with_all = ["max_delta_e", "max_rmse"],
        value_parser = parse::whole_number::<usize>(1..=31)
    )]
    components: Option<usize>,
    /// Least number of components that keeps every curve below this colour difference, ΔE*ab (the paper: 2.3)
    #[arg(long, value_name = "DE", requires = "space", value_parser = parse::number)]
    max_delta_e: Option<f64>,
    /// Least number of components that keeps every curve below this root mean square error (the paper: 0.002)
    #[arg(long, value_name = "RMSE", requires = "space", value_parser = parse::number)]
    max_rmse: Option<f64>,
    /// Illuminants of --max-delta-e, separated by commas
    #[arg(
        long, value_name = "NAMES", default_value = "D65", value_delimiter = ',', value_parser = parse::illuminant,
        requires = "max_delta_e"
    )]
    illuminant: Vec<Illuminant>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SpaceArgument {
    /// The values, as in the paper
    Linear,
    /// Their natural logarithms
    Log,
}

impl Compression {
    /// Checks before long work that the options agree.
    pub(crate) fn check(&self) -> Outcome {
        let is_limited = self.components.is_some() || self.max_delta_e.is_some() || self.max_rmse.is_some();
        if self.space.is_some() && !is_limited {
            return Err(Failure::Input("--space needs --components, --max-delta-e or --max-rmse".to_owned()));
        }
        Ok(())
    }

    /// Writes a table, and returns a few words on its compression.
    pub(crate) fn write(&self, table: &Table, path: &Path) -> Result<String, Failure> {
        let Some(space) = self.space.map(SpaceArgument::space) else {
            table.write(path).map_err(Failure::work)?;
            return Ok(String::new());
        };
        let components = match self.components {
            Some(components) => components,
            None => {
                let criteria = Criteria {
                    max_delta_e: self.max_delta_e.unwrap_or(f64::INFINITY),
                    max_rmse: self.max_rmse.unwrap_or(f64::INFINITY),
                    illuminants: self.illuminant.clone(),
                };
                fidelity::fewest_components(table, space, &criteria).map_err(Failure::input)?
            }
        };
        let compressed = CompressedTable::new(table, space, components).map_err(Failure::input)?;
        compressed.write(path).map_err(Failure::work)?;
        Ok(format!(", {components} components in {} space", space.name()))
    }
}

impl SpaceArgument {
    fn space(self) -> Space {
        match self {
            Self::Linear => Space::Linear,
            Self::Log => Space::Log,
        }
    }
}
